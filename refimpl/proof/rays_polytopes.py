"""Where a ray first enters a polytope given by planes or vertices, in exact rational arithmetic.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from fractions import Fraction

from refimpl.proof.bodies import Corners, Mix, Planes
from refimpl.proof.convex import exact_nearest
from refimpl.proof.points import ZERO, Vector, along, dot, minus, opposite
from refimpl.proof.rays import Hit, Miss, moment

ROUNDS = 200


def planes(origin: Vector, way: Vector, solid: Planes) -> Hit | Miss:
    """Last entry behind a plane, if it comes before the first exit (Cyrus and Beck 1978)."""
    entry, inwards, rate_in = Fraction(0), ZERO, Fraction(0)
    leave: tuple[Fraction, Vector, Fraction] | None = None
    for normal, k in zip(solid.normals(), solid.levels(), strict=True):
        height, rate = dot(normal, origin) + k, dot(normal, way)
        if height > 0 and rate >= 0:
            return Miss(opposite(normal))
        if rate < 0 and -height / rate > entry:
            entry, inwards, rate_in = -height / rate, opposite(normal), -rate
        if rate > 0 and (leave is None or -height / rate < leave[0]):
            leave = -height / rate, normal, rate
    if leave is not None and entry > leave[0]:  # the planes of entry and exit meet beside the ray
        return Miss(along(along(ZERO, leave[2], inwards), -rate_in, leave[1]))
    return moment(entry, inwards)


def hull(origin: Vector, way: Vector, solid: Corners) -> tuple[Hit | Miss, Mix]:
    """First entry into a hull of vertices, and of which vertices that point is made.

    From a point of the ray outside, the plane across the shortest way to the hull holds all of the hull behind it:
    the ray is free up to that plane (Gilbert and Foo 1990). The last plane is a face's, and the ray meets it inside.
    """
    time, last, climb = Fraction(0), ZERO, Fraction(0)
    for _ in range(ROUNDS):
        found, (_, mix) = exact_nearest(Corners([along(origin, time, way)]), solid)
        n = found.normal
        if not any(n):
            return moment(time, ZERO), mix
        rate = dot(n, way)
        gap = dot(n, minus(solid.corner(solid.farthest(opposite(n))), along(origin, time, way)))
        if rate <= 0:  # together with the plane that the ray came to before, across a direction normal to the ray
            return Miss(along(along(ZERO, climb, n), -rate, last) if time else n), ()
        ahead = time + Fraction(gap) / rate
        there, (_, mix) = exact_nearest(Corners([along(origin, ahead, way)]), solid)
        if not any(there.normal):
            return moment(ahead, n), mix
        last, climb = n, Fraction(rate)
        time = max(time, Fraction(float(ahead * (1 - Fraction(1, 1 << 52)))))  # a number of few digits, not beyond
    raise AssertionError("the ray comes to a face after finitely many planes")
