"""Claims about the time when a ray first hits a union.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from refimpl.proof.atoms import Atom, Directions, Group, atoms_of, gap_along
from refimpl.proof.checker import check
from refimpl.proof.claims import Certificate, Claim, Common, Cover, Part, Tree
from refimpl.proof.points import Vector, along, dot, exact, rationals, round_down, round_up
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.rays import Hit, Miss
from refimpl.proof.times import first_hit
from refimpl.proof.union_search import around
from refimpl.proof.vectors import Number
from refimpl.shapes import Capsule, Proxy, Ray

CLEAR = 1e-9  # relative to the scene: a group of atoms so far from the ray needs one direction only


class _Free(Directions):
    """Builds a tree of directions that show a ray to be free up to a time, or for ever."""

    def __init__(self, ray: Ray, time: Number | None, least: float) -> None:
        super().__init__(least, [])
        self.ray, self.time = ray, time
        self.way = rationals(ray.direction)

    def _best(self, one: Group, other: Group, inherited: Vector | None) -> tuple[float, Vector]:
        if len(other.atoms) == 1:
            return -math.inf, (1, 0, 0)  # `_exactly` knows better
        best, n = super()._best(one, other, inherited)
        rate = dot(exact(n), self.way)
        if self.time is None and rate > 0:  # for ever: not towards the plane
            n = along(exact(n), -Fraction(rate) / dot(self.way, self.way), self.way)
            unit = (float(n[0]), float(n[1]), float(n[2]))
            best = gap_along(one, other, unit) if any(unit) else -math.inf
        return best, n

    def _exactly(self, a: Atom, b: Atom, normal: Vector) -> Vector:
        del a, normal
        found = first_hit(self.ray, b.shape)[0]
        return found.normal if isinstance(found, Miss) else found.normal(Fraction(self.time or 0))


def union_times(ray: Ray, shape: Proxy) -> tuple[Claim, ...]:
    """Make claims about the first hit of a ray."""
    origin: Vector = tuple(ray.origin.tolist())
    for choice, place_of in around(shape, origin):
        claim = Part(None, choice, Common(place_of, 0))
        if _holds(claim, ray, shape):
            return (claim,)
    atoms = atoms_of(shape)
    hits: list[tuple[Fraction, Fraction, Atom, Hit]] = []
    for atom in atoms:
        if _may_hit(ray, atom):
            found = first_hit(ray, atom.shape)[0]
            if isinstance(found, Hit):
                hits.append((found.high, found.low, atom, found))
    size = float(max(shape.magnitude, ray.magnitude))
    if not hits:
        return (Cover(_Free(ray, None, CLEAR * size).build([_path(ray, atoms)], atoms)),)
    high, low, atom, found = min(hits, key=lambda hit: hit[:2])
    low = min(hit[1] for hit in hits)
    claims: list[Claim] = []
    place = first_hit(ray, atom.shape)[2]
    for late in (round_up(high), high, found.within):
        if math.isfinite(late):
            inside = Part(None, atom.number, Common(place(Fraction(late)), late))
            if _holds(inside, ray, shape):
                claims.append(inside)
                break
    for early in (round_down(low), low, low * (1 - Fraction(1, 1 << 100))):
        if low == 0:
            break
        outside = Cover(_tree(ray, early, atoms, CLEAR * size), until=early)
        if _holds(outside, ray, shape):
            claims.append(outside)
            break
    return tuple(claims)


def _tree(ray: Ray, time: Number, atoms: Sequence[Atom], least: float) -> Tree:
    end = tuple(float(c) for c in along(rationals(ray.origin), Fraction(time), rationals(ray.direction)))
    return _Free(ray, time, least).build([Atom(0, Capsule(ray.origin, end, 0.0))], atoms)


def _path(ray: Ray, atoms: Sequence[Atom]) -> Atom:
    """The ray as far as it comes near to the atoms."""
    reach = max(
        float(np.max(np.abs(bound - ray.origin))) for atom in atoms for bound in atom.box if abs(bound[0]) < 1e299
    )
    length = math.sqrt(float(ray.direction @ ray.direction))
    return Atom(0, Capsule(ray.origin, ray.origin + 4.0 * reach / length * ray.direction, 0.0))


def _may_hit(ray: Ray, atom: Atom) -> bool:
    """Whether the ray's line comes near to a box around the atom."""
    low, high = atom.box
    slack = 1e-9 * (np.max(np.abs(ray.origin)) + np.max(np.abs(np.minimum(np.abs(low), np.abs(high)))))
    first, last = 0.0, math.inf
    for o, d, l, h in zip(
        ray.origin.tolist(), ray.direction.tolist(), (low - slack).tolist(), (high + slack).tolist(), strict=True
    ):
        if d == 0:
            if not l <= o <= h:
                return False
            continue
        ends = sorted(((l - o) / d, (h - o) / d))
        first, last = max(first, ends[0]), min(last, ends[1])
    return first <= last


def _holds(claim: Claim, ray: Ray, shape: Proxy) -> bool:
    try:
        check(Certificate((claim,)), ray, shape)
    except InvalidCertificate:
        return False
    return True
