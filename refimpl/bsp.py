"""A concave solid as convex pieces: a binary space partition whose planes are those of its faces, exact.

A cell that holds faces is cut by the plane of one of them, and so are the faces; a cell without faces is wholly
solid or wholly empty, as the faces in its last cutting plane say (Thibault & Naylor 1987, Set Operations on
Polyhedra Using Binary Space Partitioning Trees). Where the faces of a cell lie behind each other's planes, what is
solid of it is one convex piece, however many faces there are. Pieces that fit together are joined again.
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from itertools import pairwise
from math import gcd
from typing import NamedTuple

import numpy as np

from refimpl.cells import Arrangement, Cell, Facet, Loop, Plane, Point, bounding_cell
from refimpl.cutting import Face, cutting_plane
from refimpl.linear import Array
from refimpl.meshes import Triangles
from refimpl.signs import Points

EMPTY, SOLID = -1, -2
"""What is in a cell that is not cut any further."""


class Piece(NamedTuple):
    """A convex piece of a solid.

    Attributes
    ----------
    planes : tuple of (a, b, c, d), whole numbers
        The piece is where ax + by + cz + d ≤ 0 for all of them, exactly; each carries a facet.
    corners : tuple of (x, y, z, w), whole numbers, w > 0
        Its corners (x/w, y/w, z/w), exactly.
    facets : tuple of loops
        For each plane its facet's corners, by number, anticlockwise seen from outside.
    vertices : (m, 3)
        The corners, each coordinate correctly rounded.
    """

    planes: tuple[Plane, ...]
    corners: tuple[Point, ...]
    facets: tuple[Loop, ...]
    vertices: Array

    def six_volumes(self) -> Fraction:
        """Six times the volume, exactly."""
        total = Fraction(0)
        for loop in self.facets:
            (ax, ay, az, aw), *rest = (self.corners[i] for i in loop)
            for (bx, by, bz, bw), (cx, cy, cz, cw) in pairwise(rest):
                det = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
                total += Fraction(det, aw * bw * cw)
        return total


class Cut(NamedTuple):
    """A node of the tree: a plane, and what is below and above it.

    Attributes
    ----------
    plane : (a, b, c, d), whole numbers
        Below is ax + by + cz + d < 0.
    children : list of two int
        Below and above: another node's number, `EMPTY` or `SOLID`.
    """

    plane: Plane
    children: list[int]


def convex_pieces(vertices: Array, triangles: Triangles) -> list[Piece]:
    """Split the solid that a mesh bounds into convex pieces whose interiors are disjoint.

    Parameters
    ----------
    vertices : (m, 3)
    triangles : (t, 3) int
        A mesh that `meshes.require_solid` accepts.
    """
    space, faces, reach, exponent = _exact_faces(vertices, triangles)
    if cutting_plane(space, faces) is None:
        cells = [_convex_cell(faces)]
    else:
        cells = _joined(space, _solid_cells(space, bounding_cell(space, reach), faces)[0])
    return [_piece(space, cell, exponent) for cell in cells]


def solid_tree(vertices: Array, triangles: Triangles) -> list[Cut]:
    """Give the tree that parts the solid which a mesh bounds from the rest of space; the first node is its root.

    Parameters as for `convex_pieces`.
    """
    space, faces, reach, exponent = _exact_faces(vertices, triangles)
    _, tree = _solid_cells(space, bounding_cell(space, reach), faces)
    return [Cut(_own_unit(cut.plane, exponent), cut.children) for cut in tree]


def bounds_convex(vertices: Array, triangles: Triangles) -> bool:
    """Whether the solid that a mesh bounds is convex."""
    space, faces, _, _ = _exact_faces(vertices, triangles)
    return cutting_plane(space, faces) is None


def _exact_faces(vertices: Array, triangles: Triangles) -> tuple[Arrangement, list[Face], int, int]:
    """Faces on the grid, a bound of the coordinates there that leaves room around, and the grid's exponent."""
    points = Points(vertices)
    grid = points.grid
    reach = 2 * max(int(abs(x)) for x in grid.ravel()) + 1
    space = Arrangement(reach)
    numbers = [space.point(*row) for row in grid.tolist()]
    faces = [_face(space, [numbers[i] for i in corners]) for corners in triangles.tolist()]
    return space, faces, reach, points.grid_exponent


def _face(space: Arrangement, loop: list[int]) -> Face:
    p, q, r = loop
    (px, py, pz, _), (qx, qy, qz, _), (rx, ry, rz, _) = (space.points[i] for i in loop)
    ux, uy, uz, vx, vy, vz = qx - px, qy - py, qz - pz, rx - px, ry - py, rz - pz
    a, b, c = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    plane, side = space.plane(a, b, c, -(a * px + b * py + c * pz))
    for corner in loop:
        space.lies_on(corner, plane)
    return Face(plane, side, (p, q, r), ((p, q), (q, r), (r, p)))


def _solid_cells(space: Arrangement, cell: Cell, faces: list[Face]) -> tuple[list[Cell], list[Cut]]:
    """What is solid of a cell, and the tree that tells, walked depth first without recursion."""
    found: list[Cell] = []
    tree: list[Cut] = []
    root = Cut((0, 0, 0, 0), [0, 0])
    waiting = [(cell, faces, root, 0)]
    while waiting:
        cell, faces, parent, place = waiting.pop()
        parent.children[place] = len(tree)
        plane = cutting_plane(space, faces)
        if plane is None:
            found.append(_behind_all(space, cell, faces, tree))
            continue
        cut = Cut(space.planes[plane], [EMPTY, EMPTY])
        tree.append(cut)
        below, within, above = _cut_faces(space, faces, plane)
        halves = zip(cell.split(space, plane), (below, above), (-1, 1), strict=True)
        for place, (part, inside, side) in enumerate(halves):
            assert part is not None  # a face of the cell lies in the plane
            if inside:
                waiting.append((part, inside, cut, place))
            elif within == -side:
                found.append(part)
                cut.children[place] = SOLID
    return found, tree


def _cut_faces(space: Arrangement, faces: list[Face], plane: int) -> tuple[list[Face], int, list[Face]]:
    """Faces below and above a plane, and the side to which those in it look, where they agree."""
    below, above, within = [], [], 0
    memo: dict[int, int] = {}
    for face in faces:
        if face.plane == plane:
            within = face.side
            continue
        sides = []
        for corner in face.loop:
            side = memo.get(corner)
            if side is None:
                side = memo[corner] = space.side(corner, plane)
            sides.append(side)
        if 1 not in sides:
            below.append(face)
        elif -1 not in sides:
            above.append(face)
        else:
            below.append(_part(space, face, plane, sides, -1))
            above.append(_part(space, face, plane, sides, 1))
    return below, within, above


def _part(space: Arrangement, face: Face, plane: int, sides: list[int], keep: int) -> Face:
    """What of a face lies on one side of a plane that cuts it."""
    loop: list[int] = []
    lines: list[int | tuple[int, int]] = []
    count = len(face.loop)
    for i in range(count):
        j = (i + 1) % count
        here, there, line = sides[i], sides[j], face.lines[i]
        if here != -keep:
            loop.append(face.loop[i])
            lines.append(line if keep in (here, there) else plane)
        if here * there < 0:
            if isinstance(line, tuple):
                new = space.edge_point(*line, plane)
                space.lies_on(new, face.plane)
            else:
                new = space.meeting(face.plane, line, plane)
            loop.append(new)
            lines.append(line if there == keep else plane)
    return Face(face.plane, face.side, tuple(loop), tuple(lines))


def _convex_cell(faces: list[Face]) -> Cell:
    """The cell that a convex mesh bounds: its faces in one plane make one facet."""
    edges: dict[tuple[int, int], set[tuple[int, int]]] = {}
    for face in faces:
        rim = edges.setdefault((face.plane, face.side), set())
        for u, v in zip(face.loop, face.loop[1:] + face.loop[:1], strict=True):
            rim.add((u, v)) if (v, u) not in rim else rim.remove((v, u))
    around = Counter(u for rim in edges.values() for u, _ in rim)
    facets = []
    for (plane, side), rim in edges.items():
        following = dict(rim)
        loop = [next(iter(following))]
        while (here := following[loop[-1]]) != loop[0]:
            loop.append(here)
        facets.append(Facet(plane, -side, tuple(corner for corner in loop if around[corner] > 2)))
    return Cell(facets)


def _behind_all(space: Arrangement, cell: Cell, faces: list[Face], tree: list[Cut]) -> Cell:
    """What of a cell is behind all of its faces; the tree gets a node for the plane of each."""
    for plane, side in dict.fromkeys((face.plane, face.side) for face in faces):
        after = len(tree) + 1
        tree.append(Cut(space.planes[plane], [after, EMPTY] if side > 0 else [EMPTY, after]))
        parts = cell.split(space, plane)
        part = parts[0] if side > 0 else parts[1]
        assert part is not None
        cell = part
    last = tree[-1].children
    last[last.index(len(tree))] = SOLID
    return cell


# ------------------------------------------------------------------------------------------- joining


def _joined(space: Arrangement, cells: list[Cell]) -> list[Cell]:
    """Join cells that share a whole facet, as long as there are two whose union is convex."""
    alive = dict(enumerate(cells))
    facets: dict[tuple[int, frozenset[int]], list[int]] = {}
    for number, cell in alive.items():
        for facet in cell.facets:
            facets.setdefault((facet.plane, frozenset(facet.loop)), []).append(number)
    waiting = [key for key, owners in facets.items() if len(owners) == 2]
    count = len(cells)
    while waiting:
        key = waiting.pop()
        owners = [number for number in facets[key] if number in alive]
        if len(owners) != 2:
            continue
        union = alive[owners[0]].joined(alive[owners[1]], space, key[0])
        if union is None:
            continue
        del alive[owners[0]], alive[owners[1]]
        alive[count] = union
        for facet in union.facets:
            again = (facet.plane, frozenset(facet.loop))
            facets.setdefault(again, []).append(count)
            waiting.append(again)
        count += 1
    return list(alive.values())


def _reduced(x: int, y: int, z: int, w: int) -> tuple[int, int, int, int]:
    """The same ratios in the smallest whole numbers."""
    shared = gcd(x, y, z, w)
    return x // shared, y // shared, z // shared, w // shared


def _own_unit(plane: Plane, exponent: int) -> Plane:
    """Turn a plane of the grid, whose coordinates count 2^exponent, into the same in the mesh's own unit."""
    a, b, c, d = plane
    up, down = 1 << max(exponent, 0), 1 << max(-exponent, 0)
    return _reduced(a * down, b * down, c * down, d * up)


def _piece(space: Arrangement, cell: Cell, exponent: int) -> Piece:
    """A cell in the mesh's own unit: grid coordinates times 2^exponent."""
    up, down = 1 << max(exponent, 0), 1 << max(-exponent, 0)
    order = sorted(cell.corners)
    number = {corner: i for i, corner in enumerate(order)}
    corners = tuple(_reduced(x * up, y * up, z * up, w * down) for x, y, z, w in (space.points[i] for i in order))
    planes = []
    for facet in cell.facets:
        a, b, c, d = (-facet.side * x for x in space.planes[facet.plane])
        planes.append(_own_unit((a, b, c, d), exponent))
    vertices = np.array([[x / w, y / w, z / w] for x, y, z, w in corners])
    loops = tuple(tuple(number[corner] for corner in facet.loop) for facet in cell.facets)
    return Piece(tuple(planes), corners, loops, vertices)
