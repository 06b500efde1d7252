"""The truth for tests: signed distances and ray times of single pairs of proxies, to 50 digits and more.

A double is a rational number, so every scene is computed in rationals for as long as it is rational: polytopes, and
what is a polytope grown by a ball, up to one last square root. Ellipsoids and cylinders are searched for all their
critical directions and finished at 60 digits. Slow and simple on purpose, it shares neither code nor method with what
it is the measure of.
"""

from __future__ import annotations

from fractions import Fraction

from mpmath import mp, mpf  # type: ignore[import-untyped]

from refimpl.shapes import AABB, Box, Capsule, Composite, HalfSpace, Point, Polyhedron, Proxy, Sphere
from tests.truth.bodies import Body, body_of
from tests.truth.curved import curved_distance
from tests.truth.polytopes import straight_distance
from tests.truth.rationals import DIGITS, cross, dot, number, real, vector
from tests.truth.rays import ray_interval
from tests.truth.unions import union_distance
from tests.truth.zonotopes import Nearest, core_of, core_to_core, difference

__all__ = ["Nearest", "body_of", "core_of", "difference", "ray_interval", "real", "scene_scale", "signed_distance"]

UNIONS = (Polyhedron, Composite)
ZONOTOPES = (Point, Sphere, Capsule, AABB, Box)


def signed_distance(a: Proxy, b: Proxy) -> mpf:
    """Signed distance σ(a, b) of two single proxies: gap > 0, touching 0, minus the penetration depth < 0.

    Returns
    -------
    mpf
        Right to a relative 1e-58, hence of the right sign, and 0 exactly when they touch, unless an ellipsoid or a
        cylinder takes part: then right to an absolute 1e-25 of the scene, and a proven lower bound to 50 digits.
        −inf for half-spaces whose normals are not exactly antiparallel. Of unions that overlap, an upper bound.
    """
    if isinstance(a, UNIONS) or isinstance(b, UNIONS):
        return union_distance(a, b, _between)
    if isinstance(a, ZONOTOPES) and isinstance(b, ZONOTOPES):
        core, other = core_of(a), core_of(b)
        return _widened(core_to_core(core, other), core.radius + other.radius)
    return _between(*(x if isinstance(x, HalfSpace) else body_of(x) for x in (a, b)))


def _between(a: Body | HalfSpace, b: Body | HalfSpace) -> mpf:
    """Signed distance of two convex pieces."""
    if isinstance(a, HalfSpace):
        return _between_half_spaces(a, b) if isinstance(b, HalfSpace) else _to_half_space(b, a)
    if isinstance(b, HalfSpace):
        return _to_half_space(a, b)
    radius = a.radius + b.radius
    if a.ellipsoid is None and b.ellipsoid is None:
        return _widened(straight_distance(a, b), radius)
    with mp.workdps(DIGITS):
        return curved_distance(a, b) - real(radius)


def scene_scale(a: Proxy, b: Proxy, sigma: mpf | None = None) -> float:
    """Size s of the scene: its largest absolute coordinate, extent or finite distance."""
    sigma = signed_distance(a, b) if sigma is None else sigma
    sizes = [float(a.magnitude), float(b.magnitude)]
    return max(sizes) if mp.isinf(sigma) else max(*sizes, float(abs(sigma)))


def _to_half_space(body: Body, h: HalfSpace) -> mpf:
    """Height of the body's lowest point above the plane."""
    n = vector(h.normal)
    lowest = min(dot(n, p) for p in body.points) + number(h.k)
    if body.ellipsoid is None:
        return _widened(Fraction(lowest * abs(lowest)) / dot(n, n), body.radius)
    with mp.workdps(DIGITS):
        return (real(lowest) - body.bulge(n)) / mp.sqrt(real(dot(n, n))) - real(body.radius)


def _between_half_spaces(a: HalfSpace, b: HalfSpace) -> mpf:
    m, n = vector(a.normal), vector(b.normal)
    if any(cross(m, n)) or dot(m, n) > 0:
        return mpf("-inf")
    ratio = -dot(m, n) / dot(n, n)  # m = −ratio·n
    d = number(a.k) + ratio * number(b.k)
    return _widened(d * abs(d) / dot(m, m), Fraction(0))


def _widened(signed_square: Fraction, radius: Fraction) -> mpf:
    """d − radius, given d·|d|; a gap as (d² − radius²) / (d + radius), for then the numerator is exact."""
    with mp.workdps(DIGITS):
        size = mp.sqrt(real(abs(signed_square))) + real(radius)
        return -size if signed_square <= 0 else real(signed_square - radius**2) / size
