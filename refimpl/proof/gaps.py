"""What claims by planes prove, in exact arithmetic: part of what has to be believed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

from refimpl.proof.claims import Bound, Cover, Escape, Piece, Separated, Split
from refimpl.proof.rational import InvalidCertificate, direction, index, items, rational, require, spend, vector, whole
from refimpl.proof.reading import segment
from refimpl.proof.sets import Hull, Line, Points
from refimpl.proof.unions import Mesh, Union
from refimpl.proof.vectors import NONE, Exact, cross, dot, minus, root, times

NOWHERE = [NONE] * 3
Numbers: TypeAlias = Sequence[int]
Sides: TypeAlias = tuple[Union, Union]


class Gap:
    """The room between the supporting planes, across the direction of a claim, of some atoms of A and some of B."""

    def __init__(self, claim: Separated | Escape, sides: Sides, chosen: Sequence[Numbers], shift: Exact = ()) -> None:
        self.n = direction(claim.n)
        self.room = dot(self.n, shift) if shift else NONE  # between the cores, times ‖n‖, with B moved by `shift`
        self.radius = NONE
        given = zip(sides, chosen, (self.n, times(-1, self.n)), items(claim.faces, "faces", 2), strict=True)
        for side, atoms, n, faces in given:
            pairs = [items(entry, "faces", 2) for entry in items(faces, "faces")]
            height, radius = side.height(n, atoms, {index(i, "faces", len(side.atoms)): shares for i, shares in pairs})
            self.room, self.radius = self.room - height, self.radius + radius

    def compared(self, width: Fraction = NONE) -> int:
        """Sign of how much wider than `width` ≥ 0 it is."""
        other = self.radius + width
        p, q = self.room.numerator * other.denominator, other.numerator * self.room.denominator
        beyond = p * p - q * q * dot(self.n, self.n) if p >= 0 else -1
        return (beyond > 0) - (beyond < 0)

    @property
    def width(self) -> Fraction:
        """At least how wide it is."""
        low, high = root(Fraction(dot(self.n, self.n)))
        return Fraction(self.room / (high if self.room > 0 else low) - self.radius)


def gaps(tree: Any, sides: Sides, shift: Exact = ()) -> Iterator[Gap]:
    """Gaps at the leaves of a tree, with B moved by `shift`."""
    for node, groups in leaves(tree, sides):
        yield Gap(node, sides, groups, shift)


def leaves(tree: Any, sides: Sides) -> Iterator[tuple[Separated, list[Numbers]]]:
    """Leaves of a tree, and their atoms of A and B: every atom of one side meets every atom of the other in one."""
    waiting: list[tuple[Any, list[Numbers]]] = [(tree, [range(len(side.atoms)) for side in sides])]
    while waiting:
        node, groups = waiting.pop()
        spend(sum(map(len, groups)))
        if isinstance(node, Separated):
            if all(groups):
                yield node, groups
            continue
        if not isinstance(node, Split):
            raise InvalidCertificate("tree: neither parted nor separated")
        side, first = index(node.side, "side", 2), items(node.first, "first")
        require(set(map(type, first)) <= {int}, "first: not numbers of atoms")
        require(
            all(0 <= i < len(sides[side].atoms) for i in (min(first, default=0), max(first, default=0))),
            "first: not there",
        )
        chosen = set(first)
        parted = [i for i in groups[side] if i in chosen], [i for i in groups[side] if i not in chosen]
        for branch, part in zip(items(node.branches, "branches", 2), parted, strict=True):
            waiting.append((branch, [part, groups[1]] if side == 0 else [groups[0], part]))


def escape(claim: Escape, sides: Sides) -> Bound:
    """Lower bound of σ of two convex sets that may overlap."""
    require(not any(isinstance(side.alone(), Line) for side in sides), "an escape of a ray")
    gap = Gap(claim, sides, ([0], [0]))
    require(gap.compared() <= 0, "n: the supporting planes leave a gap")
    return gap.width


def cover(claim: Cover, sides: Sides) -> Bound:
    """Lower bound of σ by planes between all atoms, or of the time when a ray first hits."""
    for first, (side, solid) in ((True, sides), (False, sides[::-1])):
        if isinstance(ray := side.convex.get(0), Line):
            return _free(claim, ray, solid, first)
    shift, places = vector(claim.shift, "shift"), claim.places
    least: Bound = -math.inf
    for gap in gaps(claim.tree, sides, shift if any(shift) else ()):
        # not even touching: a flat part between two others touches both, and is inside their union
        require(gap.compared() > 0, "n: the supporting planes do not leave a gap")
        if isinstance(least, float) or gap.compared(least) < 0:
            least = max(gap.width, NONE)
    require(claim.until is None, "until: without a ray")
    require_outside(sides, places, shift)
    return -root(dot(shift, shift))[1] if any(shift) else least


def require_outside(sides: Sides, places: Any, shift: Exact = NOWHERE) -> None:
    """Refuse solids of which one has something wholly inside a mesh of the other, B moved by `shift`."""
    given = items(places, "places", 2)
    for (one, other), points, way in ((sides, given[1], shift), (sides[::-1], given[0], times(-1, shift))):
        samples = other.samples(points) if one.meshes else []
        inside = any(one.contains(minus(point, times(-1, way))) for point in samples)
        require(not inside, "places: one lies inside the other")


def _free(claim: Cover, ray: Line, solid: Union, ray_first: bool) -> Bound:
    """Lower bound of the time of the first hit, by planes between the ray up to some time and all atoms."""
    time: Bound = math.inf if claim.until is None else rational(claim.until, "until")
    require(time >= 0 and not any(vector(claim.shift, "shift")), "until: before the start")
    path = Union([ray if claim.until is None else segment(ray.origin, ray.at(Fraction(time)))])
    for gap in gaps(claim.tree, (path, solid) if ray_first else (solid, path)):
        rate = dot(gap.n, ray.direction) if ray_first else -dot(gap.n, ray.direction)
        touching = time < math.inf and rate > 0  # the end of the path, and nothing before it
        require(gap.compared() >= (0 if touching else 1), "n: the supporting planes do not leave a gap")
    require(not solid.contains(ray.origin), "the ray starts inside")
    return time


def piece_of(mesh: Mesh, piece: Any) -> Hull:
    """The hull of a piece's vertices, widened, once it is shown to lie in the solid."""
    if not isinstance(piece, Piece):
        raise InvalidCertificate("of: not a piece of a mesh")
    places, unit = whole([vector(v, "vertices") for v in items(piece.vertices, "vertices")])
    hull = Hull(Points(places, unit), range(len(places)), rational(piece.radius, "radius"))
    edges = [minus(place, places[0]) for place in places]
    normal = next((n for n in map(cross, edges[1:], edges[2:]) if any(n)), NOWHERE)
    require(hull.radius >= 0 and (hull.radius or any(dot(normal, edge) for edge in edges)), "vertices: a flat piece")
    found = gaps(piece.tree, (Union([hull]), Union([mesh])))
    require(all(gap.compared() >= 0 for gap in found), "tree: a triangle may enter the piece")
    middle = times(Fraction(1, unit * len(places)), [sum(c) for c in zip(*places, strict=True)])
    require(mesh.contains(middle), "vertices: the piece is not inside the solid")
    return hull
