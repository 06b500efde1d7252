"""Unions against unions: nearest atoms, contacts of overlapping atoms, and ways out.

The signed distance of unions that are apart is the least over all pairs of atoms. Where they overlap it is minus the
length of the shortest translation that separates them, and that is known between two bounds: no pair of atoms comes
apart with less than its own depth, and every translation that is found to leave them disjoint is long enough.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from refimpl.algorithms.surfaces import point_surface
from refimpl.atoms import Group, candidates, groups, leaves
from refimpl.bounds import support
from refimpl.compiling import batch_of
from refimpl.escapes import Pairs, escape
from refimpl.linear import Array, apply, apply_inverse, dot, norm, rotation_matrix, unit_or
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.shapes import Composite, HalfSpace, Point, Polyhedron, Sphere
from refimpl.shapes.polytopes import USUAL_DIRECTIONS
from refimpl.signs import Indices

AROUND = USUAL_DIRECTIONS[26] / norm(USUAL_DIRECTIONS[26])[:, None]
TRIED = 8  # directions that are tried because the convex hulls part soonest along them
MOST = 12  # contacts whose normals are tried
LOOKS = 32  # how often a search for a way out answers about as many pairs as overlap
FIRST = 16  # pairs that are answered first, the most promising ones


@dataclass(frozen=True)
class Contacts:
    """Overlapping pairs of convex atoms of two unions, the deepest first.

    Attributes
    ----------
    part_a, part_b : (k,) int
        Numbers of the atoms: parts of a composite in order, nested ones in their place; each polyhedron counts as
        many as it has pieces.
    separation : Separation with one batch axis
        Each pair as if it were alone: depth (negated), contact points, normal from A to B.
    """

    part_a: Indices
    part_b: Indices
    separation: Separation

    def flipped(self) -> Contacts:
        """Return the same, seen from the other proxy."""
        return Contacts(self.part_b, self.part_a, self.separation.flipped())


NONE = Separation(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))


def _distance(x: Proxy, y: Proxy) -> Separation:
    from refimpl.queries import distance  # noqa: PLC0415  the door needs the pair table, which names this module

    return distance(x, y)


def joined(parts: Sequence[Separation]) -> Separation:
    """Several batches as one."""
    if not parts:
        return NONE
    columns = ([getattr(part, name) for part in parts] for name in ("distance", "on_a", "on_b", "normal"))
    return Separation(*(np.concatenate(column) for column in columns))


def nearest(xs: Sequence[Group], ys: Sequence[Group], within: float = np.inf) -> Separation | None:
    """Nearest pair of atoms of two unions, or some pair that overlaps; None where no pair is as near as `within`."""
    best: Separation | None = None
    for x in xs:
        for y in ys:
            i, j, least = candidates(x, y, within)
            start, size = 0, FIRST
            while start < len(i) and least[start] <= within:
                some = slice(start, start + size)
                found = _distance(x.proxies[i[some]], y.proxies[j[some]])
                row = int(np.argmin(found.distance))
                if best is None or found.distance[row] < best.distance:
                    best = found[row]
                    within = min(within, float(best.distance))
                    if within < 0:
                        return best
                start, size = start + size, 2 * size
    return best


def meeting(xs: Sequence[Group], ys: Sequence[Group]) -> Pairs:
    """All pairs of atoms whose boxes meet."""
    numbers_a, numbers_b, parts = [], [], []
    for x in xs:
        for y in ys:
            i, j, _ = candidates(x, y, 0.0)
            if len(i):
                parts.append(_distance(x.proxies[i], y.proxies[j]))
                numbers_a.append(x.numbers[i])
                numbers_b.append(y.numbers[j])
    if not parts:
        return Pairs(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), NONE)
    return Pairs(np.concatenate(numbers_a), np.concatenate(numbers_b), joined(parts))


def one_inside(parts_a: Sequence[Proxy], parts_b: Sequence[Proxy]) -> bool:
    """Whether a part of one union has a point within a polyhedron of the other.

    For parts whose surfaces do not meet: then one point of each connected surface tells for all of it.
    """
    for ones, others in ((parts_a, parts_b), (parts_b, parts_a)):
        for mesh in ones:
            if isinstance(mesh, Polyhedron) and any(
                holds(mesh, point) for other in others for point in representatives(other)
            ):
                return True
    return False


def representatives(part: Proxy) -> Array:
    """A point of each connected surface of a part; none of a half-space, which no polyhedron holds."""
    if isinstance(part, HalfSpace):
        return np.zeros((0, 3))
    if isinstance(part, Polyhedron):
        firsts = part.vertices[part.solid.shell_corners]
        return apply(rotation_matrix(part.rotation), firsts) + part.position
    return part.reference_point[None]


def holds(mesh: Polyhedron, point: Array) -> bool:
    """Whether a point is in a polyhedron."""
    return point_surface(mesh.solid, into_frame(mesh, point))[0] <= 0


def into_frame(mesh: Polyhedron, point: Array) -> Array:
    """A point of the world in the frame of a polyhedron's mesh."""
    return apply_inverse(rotation_matrix(mesh.rotation), point - mesh.position)


@dataclass(frozen=True)
class Overlap:
    """What is known of two unions, apart or overlapping.

    Attributes
    ----------
    separation : Separation
        A single answer. Where they overlap, the distance is minus the length of a translation along the normal that
        was found to separate them, or −inf where none was.
    lower : float
        No shorter translation separates; 0 where they do not overlap.
    contacts : Contacts
        Overlapping pairs of convex atoms.
    """

    separation: Separation
    lower: float
    contacts: Contacts


def apart_or_overlapping(a: Proxy, b: Proxy) -> Overlap:
    """Answer for two single proxies, of which one at least is a union."""
    parts_a, parts_b = leaves(a), leaves(b)
    quick = _round_polyhedron(parts_a, parts_b)
    if quick is not None:
        return Overlap(quick, max(0.0, -float(quick.distance)), NO_CONTACTS)
    gap = nearest(groups(parts_a, surfaces=True), groups(parts_b, surfaces=True))
    assert gap is not None
    if gap.distance > 0 and not one_inside(parts_a, parts_b):
        return Overlap(gap, 0.0, NO_CONTACTS)
    xs, ys = groups(parts_a), groups(parts_b)
    pairs = meeting(xs, ys)
    deep = np.flatnonzero(pairs.found.distance < 0)
    if not len(deep):
        touching = gap if gap.distance >= 0 else nearest(xs, ys)
        assert touching is not None
        return Overlap(touching, 0.0, NO_CONTACTS)
    deep = deep[np.argsort(pairs.found.distance[deep], kind="stable")]
    contacts = Contacts(pairs.part_a[deep], pairs.part_b[deep], pairs.found[deep])
    if sum(map(len, xs)) * sum(map(len, ys)) == 1:
        return Overlap(contacts.separation[0], -float(contacts.separation.distance[0]), contacts)
    return _overlapping(a, b, xs, ys, contacts)


def meet(a: Proxy, b: Proxy) -> bool:
    """Whether two single proxies, of which one at least is a union, have a point in common."""
    parts_a, parts_b = leaves(a), leaves(b)
    quick = _round_polyhedron(parts_a, parts_b)
    if quick is not None:
        return bool(quick.distance <= 0)
    gap = nearest(groups(parts_a, surfaces=True), groups(parts_b, surfaces=True), within=0.0)
    return (gap is not None and bool(gap.distance <= 0)) or one_inside(parts_a, parts_b)


NO_CONTACTS = Contacts(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), NONE)


def _round_polyhedron(parts_a: Sequence[Proxy], parts_b: Sequence[Proxy]) -> Separation | None:
    """A point or a ball whose centre is outside, and one polyhedron: by the nearest point of the surface."""
    if len(parts_a) != 1 or len(parts_b) != 1:
        return None
    match parts_a[0], parts_b[0]:
        case Point() as p, Polyhedron() as mesh:
            return point_polyhedron(p.position, mesh)
        case Polyhedron() as mesh, Point() as p:
            return point_polyhedron(p.position, mesh).flipped()
        case Sphere() as s, Polyhedron() as mesh:
            return _ball(s, mesh)
        case Polyhedron() as mesh, Sphere() as s:
            found = _ball(s, mesh)
            return None if found is None else found.flipped()
    return None


def _ball(s: Sphere, mesh: Polyhedron) -> Separation | None:
    found = point_polyhedron(s.center, mesh)
    gap = found.distance - s.radius
    if gap < 0:
        return None
    return Separation(gap, s.center + s.radius * found.normal, found.on_b, found.normal)


def _overlapping(a: Proxy, b: Proxy, xs: list[Group], ys: list[Group], contacts: Contacts) -> Overlap:
    """Bounds of the depth, and a translation that separates."""
    deepest = contacts.separation[0]
    lower = max(-float(deepest.distance), _balls(a, b, contacts))
    scene = max(float(a.magnitude), float(b.magnitude))

    def look(move: Array) -> Pairs:
        return meeting(xs, [y.moved(move) for y in ys])

    with batch_of(LOOKS * len(contacts.part_a)):
        way = escape(look, lambda: _directions(a, b, contacts), lower, 1e-12 * scene)
    if way is None:
        nowhere = np.full(3, np.nan)
        return Overlap(Separation(np.asarray(-np.inf), nowhere, nowhere, nowhere), lower, contacts)
    normal, _ = unit_or(way.move, deepest.normal)
    depth = way.length
    touch = deepest.on_a if way.contact is None else way.contact.on_a
    found = Separation(np.asarray(-depth), touch, touch - depth * normal, normal)
    return Overlap(found, min(lower, depth), contacts)


def _directions(a: Proxy, b: Proxy, contacts: Contacts) -> Iterator[tuple[Array, float]]:
    """Directions to try, each with the length that parts even the convex hulls along it; the shortest first."""
    ways = [*np.concatenate([AROUND, -AROUND]), *_different(contacts.separation.normal)]
    for one, sign in ((a, 1.0), (b, -1.0)):
        for mesh in leaves(one):
            if isinstance(mesh, Polyhedron):
                ways.append(-sign * point_polyhedron(_middle(contacts), mesh).normal)
    directions = np.array(ways)
    enough = _reach(a, directions) + _reach(b, -directions)
    order = np.argsort(enough, kind="stable")[:TRIED]
    tried = [*range(2 * len(AROUND), len(ways)), *order.tolist()]
    for i in dict.fromkeys(tried):
        yield directions[i], float(enough[i])


def _reach(shape: Proxy, directions: Array) -> Array:
    """Support function of a single proxy along many directions."""
    return np.asarray(np.max([support(leaf, directions) for leaf in leaves(shape)], axis=0))


def _middle(contacts: Contacts) -> Array:
    """A point of the deepest overlap."""
    return np.asarray(contacts.separation.on_a[0] / 2 + contacts.separation.on_b[0] / 2)


def _different(normals: Array) -> list[Array]:
    """Normals of the deepest contacts, without those that are almost repeated."""
    kept: list[Array] = []
    for n in normals[:MOST]:
        if all(abs(float(dot(n, k)) - 1) > 1e-3 for k in kept):
            kept.append(n)
    return kept


def _balls(a: Proxy, b: Proxy, contacts: Contacts) -> float:
    """Lower bound of the depth by two balls around one point, one within each: no less than both radii together."""
    best = 0.0
    points = [_middle(contacts)]
    points += [x.reference_point for x in (a, b) if not isinstance(x, Composite)]
    for p in points:
        best = max(best, -(_height(p, a) + _height(p, b)))
    return best


def _height(p: Array, shape: Proxy) -> float:
    """Upper bound of the signed distance of a point; exact for all but composites."""
    found = []
    for part in leaves(shape):
        if isinstance(part, Polyhedron):
            found.append(float(point_polyhedron(p, part).distance))
        else:
            found.append(float(_distance(Point(p), part).distance))
    return min(found)


def point_polyhedron(p: Array, mesh: Polyhedron) -> Separation:
    """Signed distance of a point from a polyhedron, exact on both sides of its surface."""
    gap, foot, outward = point_surface(mesh.solid, into_frame(mesh, p))
    turn = rotation_matrix(mesh.rotation)
    normal = -apply(turn, outward)
    return Separation(np.asarray(gap), p, apply(turn, foot) + mesh.position, normal)
