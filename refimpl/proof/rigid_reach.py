"""How far the atoms of a proxy reach from a pivot, in exact arithmetic: part of what has to be believed."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from refimpl.proof.claims import Weights
from refimpl.proof.rational import index, items, require, spend
from refimpl.proof.rigid_poses import Course
from refimpl.proof.sets import Factor, Hull, Planes, Product
from refimpl.proof.unions import Union
from refimpl.proof.vectors import NONE, Exact, cross, dot, minus, root, times

SixShares: TypeAlias = tuple[Weights, Weights, Weights, Weights, Weights, Weights]
WAYS: list[list[int]] = [[sign * (i == axis) for i in range(3)] for sign in (1, -1) for axis in range(3)]


class Reach(NamedTuple):
    """At least how far a core is from the pivot, and how fast ‖w×(x − center)‖ a point swings that changes the core."""

    far: Fraction
    fast: Fraction


def reaches(union: Union, motion: Course, boxes: Any) -> list[Reach | None]:
    """Reach of all atoms at the start; None for those that are unbounded or not known to be bounded."""
    pairs = [items(entry, "boxes", 2) for entry in items(boxes, "boxes")]
    given = {index(i, "boxes", len(union.atoms)): items(six, "boxes", 6) for i, six in pairs}
    return [_reach(atom, motion, given.get(i)) for i, atom in enumerate(union.atoms)]


def _long(v: Exact) -> Fraction:
    return root(Fraction(dot(v, v)))[1]


def _reach(atom: Any, motion: Course, six: Sequence[Any] | None) -> Reach | None:
    match atom:
        case Product(centre, factors, unit, _):
            spend(256)
            middle = minus(times(Fraction(1, unit), centre), motion.center)
            vectors = [[times(Fraction(1, unit), v) for v in factor.vectors] for factor in factors]
            turning = [[] if _stays(factor, motion) else vs for factor, vs in zip(factors, vectors, strict=True)]
            far, fast = _ways(motion)
            return Reach(
                _sum(far(middle), [[far(v) for v in vs] for vs in vectors]),
                _sum(fast(middle), [[fast(v) for v in vs] for vs in turning]),
            )
        case Hull(points, corners, _):
            spend(64 * len(corners))
            places = [minus(times(Fraction(1, points.unit), points.places[i]), motion.center) for i in corners]
            return Reach(*(max(_long(way(place)) for place in places) for way in _ways(motion)))
        case Planes(planes, _) if six is not None:
            require(len(planes) > 1, "boxes: around a half-space")
            bounds = [atom.support(n, faces) for n, faces in zip(WAYS, six, strict=True)]
            high, low = bounds[:3], times(-1, bounds[3:])
            farthest = [max(h - c, c - l, NONE) for h, l, c in zip(high, low, motion.center, strict=True)]
            far = _long(farthest)
            return Reach(far, far * _long(motion.angular))
    return None


def _stays(factor: Factor, motion: Course) -> bool:
    """Whether a factor turns into itself: a disc, all eigenvalues of which are equal, about its own axis."""
    same = all(share == factor.shares[0] for share in factor.shares)
    return same and len(factor.vectors) > 1 and not any(dot(v, motion.angular) for v in factor.vectors)


def _ways(motion: Course) -> tuple[Any, Any]:
    """From a place off the pivot to what its length is asked of: itself, and its velocity."""
    return (lambda x: x), (lambda x: cross(motion.angular, x))


def _sum(middle: Exact, factors: Sequence[Sequence[Exact]]) -> Fraction:
    """At least the length of middle + Σ of each factor's vectors, with coefficients in a unit ball."""
    sizes = (root(sum((Fraction(dot(v, v)) for v in vectors), NONE))[1] for vectors in factors)
    return _long(middle) + sum(sizes, NONE)
