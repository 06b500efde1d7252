"""Batches of unions as the rows of atoms that the scalar kernels read (`refimpl.kernels.atoms`)."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cache
from threading import RLock
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from refimpl.algorithms.halfspaces import halfspace_halfspace, unit_plane
from refimpl.algorithms.polytopes import own_row, table_of
from refimpl.algorithms.rows import body_rows
from refimpl.atoms import piece_atoms, portions
from refimpl.compiling import module_for, numbers
from refimpl.kernels import atoms
from refimpl.kernels.bodies import AXES, CENTER, VERTICES
from refimpl.kernels.bodies import SIZES as BODY_SIZES
from refimpl.kernels.boxes import SEGMENT, TURNED
from refimpl.kernels.polytopes import FACTOR
from refimpl.kernels.polytopes_batch import MIDDLE, POINT, POWER
from refimpl.kernels.scaling import NOTHING
from refimpl.linear import Array, apply, rotation_matrix
from refimpl.proxy import Proxy
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Sphere,
)
from refimpl.solids import Solid

MUCH = 4
"""So many pieces are as much work as two small ones, and worth compiling for accordingly."""
REMEMBERED = 64
"""Meshes, and combinations of tables, whose rows are kept."""
K = TypeVar("K", bound=Hashable)
V = TypeVar("V")
NINE = slice(atoms.MATRIX, FACTOR)
THREE = slice(atoms.SIZES, atoms.RADIUS)


@dataclass(frozen=True)
class Packed:
    """A batch of unions.

    Attributes
    ----------
    atoms : (n, k, ATOM)
        Rows of the atoms of each, in the order in which contacts name them.
    shapes : (g, width)
        Geometries of hulls.
    """

    atoms: Array
    shapes: Array

    def alone(self) -> Packed:
        """Give the same without the geometries that none of the batch has."""
        hulls = self.atoms[..., atoms.KIND] == atoms.HULL
        used, which = np.unique(self.atoms[hulls, atoms.SHAPE], return_inverse=True)
        if len(used) == len(self.shapes):
            return self
        rows = self.atoms.copy()
        rows[hulls, atoms.SHAPE] = which
        return Packed(rows, self.shapes[used.astype(np.int64)])


def atom_count(x: Proxy) -> int:
    """Count the convex atoms of a union."""
    return sum(map(_count, portions(x)))


def _count(portion: Proxy) -> int:
    if isinstance(portion, Composite):
        return portion.sizes[0]
    return len(portion.pieces) if isinstance(portion, Polyhedron) else 1


def packed_pair(a: Proxy, b: Proxy, exponent: Any) -> tuple[Packed, Packed]:
    """Rows of two batches of unions, with one batch axis, each row scaled by 2^−exponent."""
    x, y = packed(a, exponent), packed(b, exponent)
    _mark_facing(a, b, x, y)
    return x, y


def packed(x: Proxy, exponent: Any) -> Packed:
    """Rows of a batch of unions; those of its half-spaces are still without the mark of what they face."""
    parts = portions(x)
    counts = list(map(_count, parts))
    rows = np.zeros((len(x), sum(counts), atoms.ATOM))
    rows[..., FACTOR] = 1.0
    tables: list[Array] = []
    known, start = 0, 0
    for part, count in zip(parts, counts, strict=True):
        mine = rows[:, start : start + count]
        if isinstance(part, Polyhedron):
            table: Array | None = _put_all(_piece_rows(part.solid), part, exponent, mine)
        elif isinstance(part, Composite) and part.mesh is not None:
            table = _put_all(_face_rows(part.mesh.solid), part.mesh, exponent, mine)
        else:
            table = _put_atom(part, exponent, mine[:, 0])
        if table is not None:
            mine[..., atoms.SHAPE] += known
            tables.append(table)
            known += len(table)
        start += count
    return Packed(rows, _stacked(tables))


def _put_atom(shape: Proxy, exponent: NDArray[np.int64], rows: Array) -> Array | None:
    """Write the rows of one convex part; gives the table of its geometries, where it has one."""
    rows[:, NINE] = np.eye(3).ravel()
    if isinstance(shape, KDOP | ConvexPolyhedron):
        return _put_hull(shape, exponent, rows)
    x = shape.times_power(-exponent)
    match x:
        case HalfSpace():
            rows[:, atoms.KIND] = atoms.HALF_SPACE
            rows[:, atoms.MATRIX : atoms.MATRIX + 3], rows[:, atoms.SIZES] = unit_plane(x)
            return None
        case Ellipsoid() | Cylinder():
            body = body_rows(x)
            rows[:, :3] = body[:, CENTER:AXES]
            rows[:, NINE] = np.swapaxes(body[:, AXES:BODY_SIZES].reshape(-1, 3, 3), 1, 2).reshape(-1, 9)
            rows[:, THREE] = body[:, BODY_SIZES:VERTICES]
            rows[:, atoms.KIND] = atoms.ELLIPSOID if isinstance(x, Ellipsoid) else atoms.CYLINDER
            return None
    rows[:, :3] = x.reference_point
    match x:
        case Point():
            rows[:, atoms.KIND] = atoms.POINT
        case Sphere():
            rows[:, atoms.KIND], rows[:, atoms.RADIUS] = atoms.POINT, x.radius
        case Capsule():
            rows[:, atoms.KIND], rows[:, atoms.RADIUS] = atoms.SEGMENT, x.radius
            rows[:, THREE] = x.q / 2 - x.p / 2
        case AABB():
            rows[:, atoms.KIND], rows[:, THREE] = atoms.BOX, x.upper / 2 - x.lower / 2
        case Box():
            rows[:, atoms.KIND], rows[:, THREE] = atoms.BOX, x.half_extents
            rows[:, NINE] = rotation_matrix(x.rotation).reshape(-1, 9)
    return None


def _put_hull(x: KDOP | ConvexPolyhedron, exponent: NDArray[np.int64], rows: Array) -> Array:
    derived = x.derived().times_power(-exponent)  # what the hull itself was made of need not be scaled
    table, notes = table_of(derived)
    middles, powers = _scales(notes)
    power = powers[derived.which] + derived.exponent
    rows[:, :3] = np.ldexp(middles[derived.which], power[:, None])
    if isinstance(x, ConvexPolyhedron):
        matrix = rotation_matrix(x.rotation)
        rows[:, :3] = np.ldexp(x.position, -exponent[:, None]) + apply(matrix, rows[:, :3])
        rows[:, NINE] = matrix.reshape(-1, 9)
    rows[:, FACTOR], rows[:, atoms.KIND] = np.ldexp(1.0, power), atoms.HULL
    rows[:, atoms.SHAPE] = derived.which
    return table


def _scales(notes: Array) -> tuple[Array, NDArray[np.int64]]:
    """Where the origins of geometries lie, and by which powers of two these are multiplied."""
    power = notes[:, POWER].astype(np.int64)
    return notes[:, MIDDLE : MIDDLE + 3], np.where(power == NOTHING, 0, power)


Geometries = tuple[Array, Array, NDArray[np.int64]]
"""Rows of the geometries of a mesh's atoms, in their order, where their origins lie in its frame, and their scales."""


def _put_all(atoms_of: Geometries, mesh: Polyhedron, exponent: NDArray[np.int64], rows: Array) -> Array:
    """Write the rows of a mesh's atoms in all its placements; gives the table of their geometries."""
    table, middles, powers = atoms_of
    module = module_for("placing", len(mesh) * (1 + len(middles) // MUCH))
    placements = np.concatenate([np.ldexp(mesh.position, -exponent[:, None]), mesh.rotation], axis=1)
    factors = np.ldexp(1.0, powers - exponent[:, None])
    placed = numbers(np.ascontiguousarray(rows), module)
    module.put_pieces(*(numbers(columns, module) for columns in (placements, middles, factors)), placed)
    if placed is not rows:
        rows[:] = np.reshape(placed, rows.shape)
    return table


_PIECES: dict[str, Geometries] = {}
_FACES: dict[str, Geometries] = {}
_STACKED: dict[tuple[int, ...], tuple[Sequence[Array], Array]] = {}
_one_at_a_time = RLock()


def _kept(store: dict[K, V], key: K, make: Callable[[], V]) -> V:
    """What is stored under a key; made if it is not there, and the oldest of many forgotten."""
    with _one_at_a_time:
        if key not in store:
            store[key] = make()
            while len(store) > REMEMBERED:
                del store[next(iter(store))]
        return store[key]


def _piece_rows(solid: Solid) -> Geometries:
    """The convex pieces of a mesh."""

    def made() -> Geometries:
        batches = piece_atoms(solid)
        found = [table_of(batch.proxies.derived()) for batch in batches]
        order = np.argsort(np.concatenate([batch.numbers for batch in batches]))
        middles, powers = _scales(np.concatenate([notes for _, notes in found])[order])
        return _filled([rows for rows, _ in found])[order], middles, powers

    return _kept(_PIECES, solid.digest, made)


def _face_rows(solid: Solid) -> Geometries:
    """The faces of a mesh, as flat hulls."""

    def made() -> Geometries:
        derived = ConvexPolyhedron.from_vertices(solid.corners).derived()
        table, notes = table_of(derived)
        middles, powers = _scales(notes)
        return table[derived.which], middles[derived.which], powers[derived.which] + derived.exponent

    return _kept(_FACES, solid.digest, made)


def _stacked(tables: Sequence[Array]) -> Array:
    """Tables of geometries one after the other; kept, for batches of the same geometries are asked again."""
    if len(tables) < 2:
        return tables[0] if tables else np.zeros((1, 1))
    # the tables too are kept, so that no other one gets their ids
    return _kept(_STACKED, tuple(map(id, tables)), lambda: (tables, _filled(tables)))[1]


def _filled(tables: Sequence[Array]) -> Array:
    """Tables one after the other, their rows filled up with zeros, which mean nothing there."""
    rows = np.zeros((sum(map(len, tables)), max(t.shape[1] for t in tables)))
    start = 0
    for table in tables:
        rows[start : start + len(table), : table.shape[1]] = table
        start += len(table)
    return rows


def _mark_facing(a: Proxy, b: Proxy, x: Packed, y: Packed) -> None:
    """Give half-spaces of two unions that face each other exactly the same number other than 0."""
    ours, theirs = _half_spaces(a, x), _half_spaces(b, y)
    for number, (g, their) in enumerate(theirs, 1):
        for h, our in ours:
            facing = np.isfinite(halfspace_halfspace(h, g).distance)
            same = np.where(our[:, atoms.SHAPE] > 0, our[:, atoms.SHAPE], number)
            our[facing, atoms.SHAPE] = same[facing]
            their[facing, atoms.SHAPE] = same[facing]


def _half_spaces(union: Proxy, rows: Packed) -> list[tuple[HalfSpace, Array]]:
    """Half-spaces among the parts of a union, and their rows."""
    found, start = [], 0
    for part in portions(union):
        if isinstance(part, HalfSpace):
            found.append((part, rows.atoms[:, start]))
        start += _count(part)
    return found


@cache
def fixed_rows() -> tuple[Array, Array, Array]:
    """Geometries of a box, a segment and a point, whose sizes the kernels fill in."""
    return own_row(TURNED), own_row(SEGMENT), own_row(POINT)
