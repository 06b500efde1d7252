"""Unions against unions: nearest atoms, contacts of overlapping atoms, and the bounds of the depth.

The signed distance of unions that are apart is the least over all pairs of atoms. Where they overlap it is minus the
length of the shortest translation that separates them, and that is known between two bounds: no pair of atoms comes
apart with less than its own depth, and every translation that is found to leave them disjoint is long enough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from refimpl.algorithms.surfaces import point_surface, points_surface
from refimpl.atoms import leaves
from refimpl.compiling import batch_of
from refimpl.escapes import Look, Pairs, Ways, escape, joined_pairs, push, touching
from refimpl.linear import Array, Bools, apply, apply_inverse, norm, rotation_matrix, scale, unit_or
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.scenes import LargeScene, ask, scene
from refimpl.shapes import HalfSpace, Point, Polyhedron, Sphere
from refimpl.shapes.polytopes import USUAL_DIRECTIONS
from refimpl.signs import Indices
from refimpl.small_scenes import SmallScene
from refimpl.supports import support

AROUND = USUAL_DIRECTIONS[26] / norm(USUAL_DIRECTIONS[26])[:, None]
HULL_WAYS = 6  # directions that are tried because the convex hulls part soonest along them
CONTACT_WAYS = 8  # contacts whose normals are tried
LOOKS = 16  # how often a search for a way out answers about as many pairs as there are
ROUNDING = 1e-12  # part of a scene's size by which the depth of a pair may be rounding


@dataclass(frozen=True)
class Overlaps:
    """What is known of a batch of pairs of unions, apart or overlapping.

    Attributes
    ----------
    separation : Separation with one batch axis
        Where they overlap, the distance is minus the length of a translation along the normal that was found to
        separate them, or −inf where none was.
    lower : (n,)
        No shorter translation separates; 0 where they do not overlap.
    contacts : Pairs
        Overlapping pairs of convex atoms.
    """

    separation: Separation
    lower: Array
    contacts: Pairs


def resolve(a: Proxy, b: Proxy) -> Overlaps:
    """Answer for two batches of proxies with one axis, of which one at least holds unions."""
    known, decided = _by_surface(a, b)
    rest = np.flatnonzero(~decided)
    if not len(rest):
        return Overlaps(known, np.maximum(0.0, -known.distance), joined_pairs([]))
    if not len(rest) < len(a):
        return _by_atoms(a, b)
    others = _by_atoms(a[rest], b[rest])
    columns = []
    for name in NAMES:
        column = getattr(known, name).copy()
        column[rest] = getattr(others.separation, name)
        columns.append(column)
    lower = np.maximum(0.0, -known.distance)
    lower[rest] = others.lower
    return Overlaps(Separation(*columns), lower, others.contacts._replace(row=rest[others.contacts.row]))


def _by_surface(a: Proxy, b: Proxy) -> tuple[Separation, Bools]:
    """Points, and balls that are apart, against polyhedra, by the surface; and which rows these are."""
    if isinstance(a, Polyhedron) and isinstance(b, Point | Sphere):
        found, decided = _by_surface(b, a)
        return found.flipped(), decided
    if isinstance(b, Polyhedron) and isinstance(a, Point):
        return mesh_heights(a.position, b), np.ones(len(a), dtype=bool)
    if isinstance(b, Polyhedron) and isinstance(a, Sphere):
        found = mesh_heights(a.center, b)
        gap = found.distance - a.radius
        return Separation(gap, a.center + scale(a.radius, found.normal), found.on_b, found.normal), gap >= 0
    none = np.full((len(a), 3), np.nan)
    return Separation(none[:, 0], none, none, none), np.zeros(len(a), dtype=bool)


def _by_atoms(a: Proxy, b: Proxy) -> Overlaps:
    """Nearest atoms; where some overlap, contacts and a way out."""
    there = scene(a, b)
    if isinstance(there, LargeScene):
        near = there.nearest(np.arange(len(a)))
        deep = np.flatnonzero(_swallowed(a, b, near) | (_firsts(near).found.distance < 0))
        pieces = there.pairs(deep, np.zeros((len(deep), 3)))
        pieces = pieces._replace(row=deep[pieces.row])
        near = joined_pairs([near.at(~np.isin(near.row, pieces.row)), pieces])
        first = _firsts(near).found
    else:
        first = there.nearest()
        deep = np.flatnonzero(first.distance < 0)
        near = there.pairs(deep, np.zeros((len(deep), 3)))
        near = near._replace(row=deep[near.row])
    answer = {name: getattr(first, name).copy() for name in NAMES}
    contacts = near.at(near.found.distance < 0)
    contacts = contacts.at(np.lexsort((contacts.part_b, contacts.part_a, contacts.found.distance, contacts.row)))
    lower = np.maximum(0.0, -answer["distance"])
    plain = isinstance(a, HalfSpace) or isinstance(b, HalfSpace)  # left by all along its normal, by the deepest last
    if not plain and there.pair_count != 1 and len(contacts.row):
        rows = np.unique(contacts.row)
        found, lower[rows] = _searched(a, b, there, rows, contacts)
        for name, column in answer.items():
            column[rows] = getattr(found, name)
    return Overlaps(Separation(*answer.values()), lower, contacts)


def meet(a: Proxy, b: Proxy) -> Bools:
    """Whether two batches have points in common, row by row."""
    known, decided = _by_surface(a, b)
    if np.any(decided):
        rest = np.flatnonzero(~decided)
        hit = known.distance <= 0
        hit[rest] = meet_atoms(a[rest], b[rest]) if len(rest) else False
        return hit
    return meet_atoms(a, b)


def meet_atoms(a: Proxy, b: Proxy) -> Bools:
    """The same, by pairs of atoms."""
    there = scene(a, b)
    if not isinstance(there, LargeScene):
        return there.meetings()
    near = there.nearest(np.arange(len(a)))
    found = np.zeros(len(a), dtype=bool)
    found[near.row[near.found.distance <= 0]] = True
    return found | _swallowed(a, b, near)


def _firsts(pairs: Pairs) -> Pairs:
    """Pair of least distance of each row that has one; of equal ones the first by number."""
    order = np.lexsort((pairs.part_b, pairs.part_a, pairs.found.distance, pairs.row))
    _, first = np.unique(pairs.row[order], return_index=True)
    return pairs.at(order[first])


NAMES = ("distance", "on_a", "on_b", "normal")


def _searched(
    a: Proxy, b: Proxy, there: SmallScene | LargeScene, rows: Indices, contacts: Pairs
) -> tuple[Separation, Array]:
    """Translations that separate some rows, and lower bounds."""
    x, y = a[rows], b[rows]
    contacts = contacts._replace(row=np.searchsorted(rows, contacts.row))
    deepest = _firsts(contacts).found
    lower = -deepest.distance
    tolerance = ROUNDING * np.maximum(x.magnitude, y.magnitude)

    def look(which: Indices, moves: Array) -> Pairs:
        return there.pairs(rows[which], moves)

    with batch_of(LOOKS * len(contacts.row)):
        ways = escape(look, len(rows), lower, tolerance)
        rough = np.flatnonzero(ways.length > lower + 2 * tolerance)
        if len(rough):
            lower[rough] = np.maximum(lower[rough], _balls(x[rough], y[rough], deepest[rough]))
            rough = rough[ways.length[rough] > lower[rough] + 2 * tolerance[rough]]
        if len(rough):
            _try_directions(x[rough], y[rough], lambda w, m: look(rough[w], m), contacts, rough, ways, tolerance)
        ways = touching(lambda which, moves, within: there.pairs(rows[which], moves, within), ways, tolerance)
    normal, _ = unit_or(ways.move, deepest.normal)
    depth = ways.length
    known = np.isfinite(depth)
    touch = np.where(np.isnan(ways.touch), deepest.on_a, ways.touch)
    touch = np.where(known[:, None], touch, np.nan)
    normal = np.where(known[:, None], normal, np.nan)
    shift = scale(np.where(known, depth, 0.0), normal)
    return Separation(-depth, touch, touch - shift, normal), np.minimum(lower, depth)


def _try_directions(
    x: Proxy, y: Proxy, look: Look, contacts: Pairs, rough: Indices, ways: Ways, tolerance: Array
) -> None:
    """Push along several directions for each row, all at once, and keep what is shorter."""
    directions, row = _directions(x, y, contacts.at(np.isin(contacts.row, rough)), rough)
    enough = _reach(x, row, directions) + _reach(y, row, -directions)
    order = np.lexsort((enough, row))
    rank = np.empty(len(order), dtype=np.int64)
    start = np.searchsorted(row[order], row[order])
    rank[order] = np.arange(len(order)) - start
    hull = np.arange(len(row)) < 2 * len(AROUND) * len(rough)
    tried = np.flatnonzero(~hull | (rank < HULL_WAYS))
    row, directions, enough = row[tried], directions[tried], enough[tried]
    found = push(
        lambda w, m: look(row[w], m),
        directions,
        enough,
        ways.length[rough][row],
        tolerance[rough][row],
    )
    order = np.lexsort((np.arange(len(row)), found.length, row))
    rows, first = np.unique(row[order], return_index=True)
    ways.put(rough[rows], found.at(order[first]))


def _directions(x: Proxy, y: Proxy, contacts: Pairs, rough: Indices) -> tuple[Array, Indices]:
    """Directions to try, and the row of each: all around, normals of the deepest contacts, ways out of meshes."""
    count = len(rough)
    around = np.concatenate([AROUND, -AROUND])
    found, row = [np.tile(around, (count, 1))], [np.repeat(np.arange(count), len(around))]
    place = np.searchsorted(rough, contacts.row)
    rank = np.arange(len(place)) - np.searchsorted(place, place)
    some = rank < CONTACT_WAYS
    found.append(contacts.found.normal[some])
    row.append(place[some])
    middle = _middle(contacts.at(rank == 0).found)
    for one, sign in ((x, 1.0), (y, -1.0)):
        for mesh in leaves(one):
            if isinstance(mesh, Polyhedron):
                found.append(-sign * mesh_heights(middle, mesh).normal)
                row.append(np.arange(count))
    return np.concatenate(found), np.concatenate(row)


def _reach(shape: Proxy, row: Indices, directions: Array) -> Array:
    """Support function of rows of a union along directions."""
    return np.asarray(np.max([support(leaf[row], directions) for leaf in leaves(shape)], axis=0))


def _middle(deepest: Separation) -> Array:
    """A point of each deepest overlap."""
    return deepest.on_a / 2 + deepest.on_b / 2


def _balls(x: Proxy, y: Proxy, deepest: Separation) -> Array:
    """Lower bounds of depths by two balls around one point, one within each: no less than both radii together.

    Only where there is a mesh, of which pieces are thin.
    """
    best = np.zeros(len(x))
    if not any(isinstance(leaf, Polyhedron) and not leaf.solid.is_convex for leaf in (*leaves(x), *leaves(y))):
        return best
    points = [_middle(deepest)]
    points += [leaves(z)[0].reference_point for z in (x, y) if len(leaves(z)) == 1 and not isinstance(z, HalfSpace)]
    for p in points:
        best = np.maximum(best, -(_height(p, x) + _height(p, y)))
    return best


def _height(p: Array, shape: Proxy) -> Array:
    """Upper bounds of the signed distances of points; exact for all but composites."""
    found = []
    for part in leaves(shape):
        if isinstance(part, Polyhedron):
            found.append(mesh_heights(p, part).distance)
        elif isinstance(part, Point):
            found.append(norm(p - part.position))
        else:
            found.append(ask(Point(p), part).distance)
    return np.asarray(np.min(found, axis=0))


def mesh_heights(p: Array, mesh: Polyhedron) -> Separation:
    """Signed distances of points from polyhedra, exact on both sides of the surface; points first."""
    turn = rotation_matrix(mesh.rotation)
    local = apply_inverse(turn, p - mesh.position)
    gap, foot, outward = points_surface(mesh.solid, local)
    return Separation(gap, p, apply(turn, foot) + mesh.position, -apply(turn, outward))


def _swallowed(a: Proxy, b: Proxy, near: Pairs) -> Bools:
    """Rows without meeting surfaces in which a part of one union has a point within a polyhedron of the other.

    One point of each connected surface tells for all of it.
    """
    found = np.zeros(len(a), dtype=bool)
    apart = np.ones(len(a), dtype=bool)
    apart[near.row[near.found.distance <= 0]] = False
    for row in np.flatnonzero(apart).tolist():
        parts_a, parts_b = leaves(a[row]), leaves(b[row])
        found[row] = any(
            _holds(mesh, point)
            for ones, others in ((parts_a, parts_b), (parts_b, parts_a))
            for mesh in ones
            if isinstance(mesh, Polyhedron)
            for other in others
            for point in _representatives(other)
        )
    return found


def _representatives(part: Proxy) -> Array:
    """A point of each connected surface of a part; none of a half-space, which no polyhedron holds."""
    if isinstance(part, HalfSpace):
        return np.zeros((0, 3))
    if isinstance(part, Polyhedron):
        return apply(rotation_matrix(part.rotation), part.vertices[part.solid.shell_corners]) + part.position
    return part.reference_point[None]


def _holds(mesh: Polyhedron, point: Array) -> bool:
    local = apply_inverse(rotation_matrix(mesh.rotation), point - mesh.position)
    low, high = mesh.solid.bounds
    return bool(np.all((low <= local) & (local <= high))) and point_surface(mesh.solid, local)[0] <= 0
