"""Certificates as people read them: what each claim states, and what that proves.

Those of the plane speak of its lines, and leave out the third coordinate, which is 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import get_args

from oracles.records import AnyCertificate
from refimpl.proof import (
    Claim,
    Clear,
    Common,
    Core,
    Cover,
    Escape,
    Inscribed,
    Meets,
    Near,
    Part,
    Piece,
    Separated,
    Split,
    SweepCertificate,
)
from refimpl.proof.claims import Place, Simple, Tree
from refimpl.proof.impacts import ImpactCertificate, Residuals
from refimpl.proof.rigid import Spans, Touch
from refimpl.proof.vectors import Vector
from reports import text

MOST_CLAIMS = 12
MOST_VERTICES = 8
LONGEST_NUMBER = 24


@dataclass(frozen=True)
class Proof:
    """A certificate as people read it.

    Attributes
    ----------
    interval
        What the certificate proves.
    claims
        One sentence per claim.
    """

    interval: str
    claims: tuple[str, ...]


def proof_view(certificate: AnyCertificate, interval: str, *, flat: bool = False) -> Proof:
    """Put a certificate into words, those of the plane where it is `flat`."""
    if isinstance(certificate, ImpactCertificate):
        said = residuals_in_words(certificate.residuals)
    elif isinstance(certificate, SweepCertificate):
        said = [_of_sweep(claim, flat) for claim in certificate.claims[:MOST_CLAIMS]]
        if more := len(certificate.claims) - len(said):
            said.append(f"And {text.plural(more, 'more claim')} of such kinds.")
    else:
        said = [claim_in_words(claim, flat=flat) for claim in certificate.claims[:MOST_CLAIMS]]
        if more := len(certificate.claims) - len(said):
            said.append(f"And {text.plural(more, 'more claim')} of such kinds.")
    return Proof(interval, tuple(said))


def _of_sweep(claim: object, flat: bool) -> str:
    """Say what one claim about two bodies on their way states."""
    match claim:
        case Clear():
            end = "1: no contact from then on" if claim.until is None else f"{_v(claim.until)}: no contact yet"
            said = f"{'Lines' if flat else 'Planes'} between the two leave a gap, which stays open until t = {end}."
        case Meets():
            places = f"{_place(claim.a, flat)} of A and {_place(claim.b, flat)} of B, at the start,"
            said = f"{places} are in one place at t = {_v(claim.time)}: the contact is no later."
        case Spans():
            many = text.plural(len(claim.spans), "span")
            said = f"In {many} of time, planes between the two leave gaps at both ends that no turning closes between."
        case Touch():
            said = f"At t = {_v(claim.time)}, where both then are: {claim_in_words(claim.claim, flat=flat)}"
        case _ if isinstance(claim, get_args(Claim)):
            said = f"At the start: {claim_in_words(claim, flat=flat)}"
        case _:
            said = "Boxes around the parts bound how far any point of them moves by turning."
    return said


RESIDUALS = (
    ("linear_a", "A's momentum: what is left of Δv + P/m, P being the impulse on B of which the velocities speak"),
    ("linear_b", "B's momentum: what is left of Δv − P/m"),
    ("angular_a", "A's angular momentum: what is left of I Δω − r × (−P), r from the centre of mass to the contact"),
    ("angular_b", "B's angular momentum: what is left of I Δω − r × P"),
    ("restitution", "restitution: n·u after plus e times n·u before, u being B's velocity against A's at the contact"),
    ("pressure", "push: n·P, which must not be negative"),
    ("cone", "friction: μ² (n·P)² − |n × P|², which must not be negative"),
    ("energy", "energy gained, which must not be positive"),
)


def residuals_in_words(residuals: Residuals) -> list[str]:
    """Say what is left over of each law of an impact."""
    said = []
    for name, law in RESIDUALS:
        value = getattr(residuals, name)
        rounded = [float(x) for x in value] if isinstance(value, tuple) else float(value)
        said.append(_sentence(f"{law}: about {text.full(rounded)}."))
    return said


def claim_in_words(claim: Claim, *, flat: bool = False) -> str:
    """Say what one claim of a certificate states, and what that proves."""
    match claim:
        case Cover():
            return _cover(claim)
        case Part():
            return _sentence(
                f"{_chosen(claim.of_a, 'A')} and {_chosen(claim.of_b, 'B')}, called A and B in what follows, bound the "
                f"whole from above, since more parts only meet sooner. {_simple(claim.claim, flat)}"
            )
        case _:
            return _simple(claim, flat)


def _simple(claim: Simple, flat: bool) -> str:
    match claim:
        case Separated() | Escape():
            shares = " Shares of a polytope's own planes show that they support it." if any(claim.faces) else ""
            return _by_planes(claim, flat) + shares
        case Near():
            said = (
                f"{_place(claim.a, flat)} lies in A and {_place(claim.b, flat)} in B: no farther apart than these two."
            )
        case Common(p=None):
            said = f"At t = {_v(claim.time)} the ray is inside the solid: the hit is no later."
        case Common(time=None):
            said = f"{_place(claim.p, flat)} lies in both: they intersect."
        case Common():
            where = _place(claim.p, flat)
            said = f"At t = {_v(claim.time)} the ray is inside the solid, at {where}: the hit is no later."
        case Core():
            said = _core(claim)
        case Inscribed():
            said = (
                f"A holds an ellipsoid around {_place(claim.a)} and B one around {_place(claim.b)}; differences of "
                f"their points fill a ball of radius {_v(claim.radius)} about the origin: at least that deep."
            )
    return _sentence(said)


def _by_planes(claim: Separated | Escape, flat: bool) -> str:
    n, plane = _direction(claim.n, flat), "line" if flat else "plane"
    if isinstance(claim, Escape):
        return f"Moving B along {n} until the supporting {plane}s meet separates the interiors: no deeper than that."
    if claim.until is None:
        both = f"{plane.capitalize()}s with normal {n} support A and B"
        return f"{both} and leave a gap between them: at least that far apart."
    said = f"Up to t = {_v(claim.until)}, a {plane} with normal {n} keeps the ray away from the solid"
    return f"{said}: no hit before."


def _core(claim: Core) -> str:
    if claim.directions:
        return "Directions in which A and B go on for ever surround the origin: the overlap has no end."
    if len(claim.pairs) > 1 and not claim.triangles:
        count = text.plural(len(claim.pairs), "corner")
        return f"Differences of points of A and B span a polygon of {count} around the origin: at least that deep."
    if not claim.triangles:
        return "A point of A's axis or centre and one of B's are nearer than the radii reach: at least that deep."
    count = text.plural(len(claim.triangles), "triangle")
    return f"Differences of points of A and B span {count} around a ball about the origin: at least that deep."


def _cover(claim: Cover) -> str:
    planes = f"planes across {text.plural(_leaves(claim.tree), 'direction')}"
    if claim.until is not None:
        return f"Up to t = {_v(claim.until)}, {planes} keep the ray away from all of the solid's parts: no hit before."
    parted = f"{planes} part all convex parts and triangles of A from all of B's, and neither holds a part of the other"
    if any(claim.shift):
        return f"Once B is moved by {_v(claim.shift)}, {parted}: no deeper than this move is long."
    return f"{_sentence(parted)}: at least as far apart as the narrowest of these gaps."


def _chosen(choice: int | tuple[int, Piece] | None, name: str) -> str:
    """Which part of a union a claim speaks of; parts and triangles are counted from 0, as in the data."""
    if choice is None:
        return name
    if isinstance(choice, int):
        return f"{name}'s part {choice}"
    number, piece = choice
    rounded = f", widened by {_v(piece.radius)}" if piece.radius else ""
    return (
        f"the hull of {text.plural(len(piece.vertices), 'point')}{rounded} in {name}'s part {number} "
        f"({text.plural(_leaves(piece.tree), 'plane')} keep the mesh's triangles out of it)"
    )


def _leaves(tree: Tree) -> int:
    count, waiting = 0, [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, Split):
            waiting += node.branches
        else:
            count += 1
    return count


def _place(place: Place | None, flat: bool = False) -> str:
    """Coordinates of a point, or the vertices whose weighted mean it is."""
    if not place or not isinstance(place[0], tuple):
        return _v(place[:2] if place and flat else place)
    numbers = list(map(str, sorted(entry[0] for entry in place if isinstance(entry, tuple))))
    if len(numbers) == 1:
        return f"vertex {numbers[0]}"
    named = f"vertices {', '.join(numbers[:-1])} and {numbers[-1]}"
    return f"a mean of {named if len(numbers) <= MOST_VERTICES else text.plural(len(numbers), 'vertex', 'vertices')}"


def _direction(n: Vector, flat: bool = False) -> str:
    """A direction as it is, or where its numbers are too long to be read, of length 1 and rounded."""
    numbers = n[:2] if flat else n
    if all(isinstance(x, float) or len(_v(x)) <= LONGEST_NUMBER for x in numbers):
        return _v(numbers)
    largest = max(abs(Fraction(x)) for x in numbers)
    scaled = [float(Fraction(x) / largest) for x in numbers]
    length = math.hypot(*scaled)
    return f"about ({', '.join(f'{x / length:.6g}' for x in scaled)})"


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:]


def _v(value: object) -> str:
    return text.full(value)
