"""The truth for tests: signed distances and ray times of single pairs, 60 digits, every decision exact.

A double is a rational number, so every scene is computed in rationals, and only the last step, one square
root, is rounded. A proxy is a *core* widened by a radius, and every core (point, segment, box) is
center + Σ tᵢ·gᵢ with |tᵢ| ≤ 1. The Minkowski difference of two cores therefore is such a set again, a
zonotope of at most six generators, and the signed distance is that of the origin from it. Each tᵢ is put at
−1, free or +1 in turn, which tries every vertex, edge and facet of the difference; the one that fulfils the
exact optimality conditions is nearest, whatever the degeneracy. Slow and simple on purpose, it shares neither
code nor method with what it is the measure of.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations, product
from typing import Any

from mpmath import mp, mpf  # type: ignore[import-untyped]

from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Point, Proxy, Ray, Sphere

DIGITS = 60
Vector = tuple[Any, Any, Any]  # of rationals, or of integers
UNIT_VECTORS: list[Vector] = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]


def signed_distance(a: Proxy, b: Proxy) -> mpf:
    """Signed distance σ(a, b) of two single proxies: gap > 0, touching 0, minus the penetration depth < 0.

    Parameters
    ----------
    a, b : Point, Sphere, Capsule, HalfSpace, AABB or Box
        Of batch shape (). Degenerate sizes are ordinary.

    Returns
    -------
    mpf
        Right to a relative 1e-58, hence of the right sign, and 0 exactly when they touch. −inf for
        half-spaces whose normals are not exactly antiparallel.
    """
    if isinstance(a, HalfSpace) and isinstance(b, HalfSpace):
        return _between_half_spaces(a, b)
    if isinstance(a, HalfSpace):
        a, b = b, a
    core = core_of(a)
    if isinstance(b, HalfSpace):
        return _widened(_core_to_half_space(core, b), core.radius)
    other = core_of(b)
    return _widened(_core_to_core(core, other), core.radius + other.radius)


def ray_interval(ray: Ray, b: Proxy) -> tuple[mpf, mpf] | None:
    """Times t ≥ 0 at which origin + t·direction lies in the solid `b`; None if there are none.

    Whether the ray hits is decided exactly, and grazing is a hit. The times are right to a relative 1e-58.
    The first is 0 exactly when the origin lies in `b`; the last is +inf when the ray stays in a half-space.
    """
    origin, d = _vector(ray.origin), _vector(ray.direction)
    with mp.workdps(DIGITS):
        match b:
            case HalfSpace():
                n = _vector(b.normal)
                pieces = [_at_most_0(0, _dot(n, d) / 2, _dot(n, origin) + _number(b.k), FOREVER)]
            case Sphere():
                pieces = [_ray_in_ball(_minus(origin, _vector(b.center)), d, _number(b.radius))]
            case Capsule():
                pieces = _ray_in_capsule(origin, d, b)
            case AABB() | Box():
                center, half_axes = _frame(b)
                pieces = [_ray_in_slabs(_minus(origin, center), d, half_axes)]
            case _:
                raise TypeError(f"no true ray times for {type(b).__name__}")
        hits = [(_real(piece[0]), _real(piece[1])) for piece in pieces if piece]
        return (min(first for first, _ in hits), max(last for _, last in hits)) if hits else None


def scene_scale(a: Proxy, b: Proxy) -> float:
    """Size s of the scene: its largest absolute coordinate, extent or finite distance."""
    sigma = signed_distance(a, b)
    sizes = [float(a.magnitude), float(b.magnitude)]
    return max(sizes) if mp.isinf(sigma) else max(*sizes, float(abs(sigma)))


# ---- cores -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Core:
    """The set {center + Σ tᵢ·gᵢ, |tᵢ| ≤ 1} ⊕ ball of `radius`, in rationals; no generator is zero."""

    center: Vector
    generators: tuple[Vector, ...] = ()
    radius: Fraction = Fraction(0)


def core_of(shape: Proxy) -> Core:
    """Core and radius of a single proxy: exactly the set that its stored doubles mean."""
    match shape:
        case Point():
            return Core(_vector(shape.position))
        case Sphere():
            return Core(_vector(shape.center), (), _number(shape.radius))
        case Capsule():
            p, q = _vector(shape.p), _vector(shape.q)
            half = _scaled(Fraction(1, 2), _minus(q, p))
            return Core(_plus(p, half), (half,) if any(half) else (), _number(shape.radius))
        case AABB() | Box():
            center, half_axes = _frame(shape)
            return Core(center, tuple(_scaled(h, axis) for axis, h in half_axes if h))
    raise TypeError(f"no core for {type(shape).__name__}")


def _frame(shape: AABB | Box) -> tuple[Vector, list[tuple[Vector, Fraction]]]:
    """Centre of a box, and its three unit axes with their half extents."""
    if isinstance(shape, Box):
        axes = [_rotated(shape.rotation, e) for e in UNIT_VECTORS]
        return _vector(shape.center), list(zip(axes, _vector(shape.half_extents), strict=True))
    lower, upper = _vector(shape.lower), _vector(shape.upper)
    half = _scaled(Fraction(1, 2), _minus(upper, lower))
    return _plus(lower, half), list(zip(UNIT_VECTORS, half, strict=True))


def _rotated(quaternion: Any, v: Vector) -> Vector:
    """Turn v by the quaternion (u, w): ((w² − u·u) v + 2(u·v) u + 2w u×v) / (w² + u·u)."""
    x, y, z, w = (_number(component) for component in quaternion)
    u = (x, y, z)
    turned = _plus(_scaled(w * w - _dot(u, u), v), _scaled(2 * _dot(u, v), u))
    return _scaled(1 / (w * w + _dot(u, u)), _plus(turned, _scaled(2 * w, _cross(u, v))))


# ---- distances: each is handed on as its signed square d·|d|, which is rational ----------------------------


def _core_to_core(a: Core, b: Core) -> Fraction:
    c, g, unit = difference(a, b)
    depth_square = _depth_square(c, g)
    square = -depth_square if depth_square else Nearest.of(c, g).square
    return square / unit**2


def difference(a: Core, b: Core) -> tuple[Vector, list[Vector], int]:
    """Zonotope (center, generators) of the Minkowski difference A ⊖ B, in integers that count 1/unit."""
    vectors = [_minus(a.center, b.center), *a.generators, *b.generators]
    unit = math.lcm(*(x.denominator for v in vectors for x in v))
    c, *g = ((int(v[0] * unit), int(v[1] * unit), int(v[2] * unit)) for v in vectors)
    return c, g, unit


def _depth_square(c: Vector, generators: list[Vector]) -> Fraction:
    """Squared depth of the origin in the zonotope; 0 if it is not in the interior.

    Two generators span each facet, so their vector products are all the directions of shortest escape.
    """
    squares = []
    for p, q in combinations(generators, 2):
        n = _cross(p, q)
        if any(n):
            depth = sum(abs(_dot(n, g)) for g in generators) - abs(_dot(n, c))
            if depth <= 0:
                return Fraction(0)
            squares.append(Fraction(depth * depth, _dot(n, n)))
    return min(squares, default=Fraction(0))


@cache
def _features(generators: int) -> list[tuple[list[int], list[int], tuple[int, ...]]]:
    """All ways to fix each tᵢ at an end or leave it free, two at most: (free, fixed, end or 0 of each)."""
    ends = [s for s in product((-1, 0, 1), repeat=generators) if s.count(0) <= 2]
    return [([i for i, e in enumerate(s) if not e], [i for i, e in enumerate(s) if e], s) for s in ends]


@dataclass(frozen=True)
class Nearest:
    """The point c + Σ tᵢ·gᵢ of a zonotope nearest to the origin, and its squared distance."""

    t: list[Fraction]
    square: Fraction

    @classmethod
    def of(cls, c: Vector, generators: list[Vector]) -> Nearest:
        """Find it, for a zonotope that does not hold the origin in its interior.

        On each feature, x is the foot of the perpendicular from the origin to its span. It is the nearest
        point if and only if all |tᵢ| ≤ 1 and moving a fixed tᵢ inwards brings nothing nearer: sᵢ (gᵢ·x) ≤ 0.
        Some feature always does both: of all t that give the nearest point, take a basic solution.
        """
        G = [[_dot(p, q) for q in generators] for p in generators]
        v = [_dot(g, c) for g in generators]
        for free, fixed, s in _features(len(generators)):
            det, t = _foot(G, [v[i] + sum(s[j] * G[i][j] for j in fixed) for i in free], free)
            if det == 0 or any(abs(t_i) > det for t_i in t):
                continue
            t_all = [det * e for e in s]
            for i, t_i in zip(free, t, strict=True):
                t_all[i] = t_i
            if all(s[i] * (det * v[i] + _sum_product(t_all, G[i])) <= 0 for i in fixed):
                x = [det * c[k] + _sum_product(t_all, [g[k] for g in generators]) for k in range(3)]
                return cls([Fraction(t_i, det) for t_i in t_all], Fraction(_sum_product(x, x), det * det))
        raise AssertionError("the origin is in the interior")


def _foot(G: list[list[int]], u: list[int], free: list[int]) -> tuple[int, list[int]]:
    """Solve G t = −u for the free generators by Cramer's rule: (determinant, determinant·t)."""
    if not free:
        return 1, []
    if len(free) == 1:
        return G[free[0]][free[0]], [-u[0]]
    i, j = free
    det = G[i][i] * G[j][j] - G[i][j] * G[i][j]
    return det, [G[i][j] * u[1] - G[j][j] * u[0], G[i][j] * u[0] - G[i][i] * u[1]]


def _core_to_half_space(core: Core, h: HalfSpace) -> Fraction:
    n = _vector(h.normal)
    d = _dot(n, core.center) + _number(h.k) - sum(abs(_dot(n, g)) for g in core.generators)
    return Fraction(d * abs(d) / _dot(n, n))


def _between_half_spaces(a: HalfSpace, b: HalfSpace) -> mpf:
    m, n = _vector(a.normal), _vector(b.normal)
    if any(_cross(m, n)) or _dot(m, n) > 0:
        return mpf("-inf")
    ratio = -_dot(m, n) / _dot(n, n)  # m = −ratio·n
    d = _number(a.k) + ratio * _number(b.k)
    return _widened(d * abs(d) / _dot(m, m), Fraction(0))


def _widened(signed_square: Fraction, radius: Fraction) -> mpf:
    """d − radius, given d·|d|; a gap as (d² − radius²) / (d + radius), for then the numerator is exact."""
    with mp.workdps(DIGITS):
        size = mp.sqrt(_real(abs(signed_square))) + _real(radius)
        return -size if signed_square <= 0 else _real(signed_square - radius**2) / size


# ---- rays: each piece of a solid is met in an interval of times, or not at all -----------------------------

Interval = tuple[Any, Any] | None
FOREVER: tuple[Any, Any] = (0, math.inf)


def _ray_in_capsule(origin: Vector, d: Vector, capsule: Capsule) -> list[Interval]:
    """Stays in the two end balls and in the cylinder between them, whose hull is the stay in the capsule."""
    core = core_of(capsule)
    x = _minus(origin, core.center)
    if not core.generators:
        return [_ray_in_ball(x, d, core.radius)]
    (g,) = core.generators
    balls = [_ray_in_ball(_plus(x, g), d, core.radius), _ray_in_ball(_minus(x, g), d, core.radius)]
    between = _ray_in_slabs(x, d, [(g, _dot(g, g))])
    if between is None:
        return balls
    p, v = _cross(g, x), _cross(g, d)  # of length ‖g‖ times the distance from the axis
    return [*balls, _at_most_0(_dot(v, v), _dot(v, p), _dot(p, p) - core.radius**2 * _dot(g, g), between)]


def _ray_in_ball(x: Vector, d: Vector, radius: Fraction) -> Interval:
    return _at_most_0(_dot(d, d), _dot(d, x), _dot(x, x) - radius**2, FOREVER)


def _ray_in_slabs(x: Vector, d: Vector, slabs: Iterable[tuple[Vector, Fraction]]) -> Interval:
    """Times at which |n·(x + t d)| ≤ size for every slab (n, size)."""
    times: Interval = FOREVER
    for n, size in slabs:
        for sign in (-1, 1):
            if times is not None:
                times = _at_most_0(0, sign * _dot(n, d) / 2, sign * _dot(n, x) - size, times)
    return times


def _at_most_0(a: Any, b: Any, c: Any, times: tuple[Any, Any]) -> Interval:
    """Part of `times` in which a t² + 2b t + c ≤ 0, for a ≥ 0; rational unless an end is a square's root."""
    first, last = times

    def f(t: Any) -> Any:
        return (a * t + 2 * b) * t + c

    if a == 0 and b == 0:
        return times if c <= 0 else None
    if a == 0:
        root = -c / (2 * b)
        low, high = (root, last) if b < 0 else (first, root)
        low, high = max(low, first), min(high, last)
        return (low, high) if low <= high else None
    if f(min(max(-b / a, first), last)) > 0:
        return None
    q = -_real(b) - (1 if b > 0 else -1) * mp.sqrt(_real(b * b - a * c))  # adds, so that nothing cancels
    low, high = sorted([q / _real(a), _real(c) / q if q else mpf(0)])
    return first if f(first) <= 0 else low, last if last < math.inf and f(last) <= 0 else high


# ---- small arithmetic --------------------------------------------------------------------------------------


def _number(x: Any) -> Fraction:
    return Fraction(float(x))


def _vector(v: Any) -> Vector:
    x, y, z = v
    return _number(x), _number(y), _number(z)


def _real(x: Any) -> mpf:
    return mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mpf(x)


def _dot(u: Vector, v: Vector) -> Any:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _sum_product(u: Sequence[int], v: Sequence[int]) -> int:
    return sum(x * y for x, y in zip(u, v, strict=True))


def _cross(u: Vector, v: Vector) -> Vector:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def _plus(u: Vector, v: Vector) -> Vector:
    return u[0] + v[0], u[1] + v[1], u[2] + v[2]


def _minus(u: Vector, v: Vector) -> Vector:
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def _scaled(factor: Any, v: Vector) -> Vector:
    return factor * v[0], factor * v[1], factor * v[2]
