"""Points and triangle surfaces: nearest points, and whether a point is inside."""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.nearest import nearest_on_segment
from refimpl.linear import Array, Bools, apply, apply_inverse, cross, dot, norm, rotation_matrix, scale, unit_or
from refimpl.meshes import winding_numbers
from refimpl.results import Separation
from refimpl.shapes import Polyhedron
from refimpl.solids import Solid

STILL = np.eye(3)
FEW_FACES = 256  # so many faces are looked at without a tree
CHUNK = 256  # points that are answered together
BATCH = 32  # triangles that are looked at together


def nearest_on_triangles(p: Array, corners: Array) -> Array:
    """Points of triangles nearest to `p`.

    The foot on the plane is found in a frame along the longest side, so that it errs, where a triangle is thin, only
    by what costs nothing in distance; outside of the triangle one of the sides is nearest. Ericson, Real-Time
    Collision Detection, 5.1.5, tells the same by regions.

    Parameters
    ----------
    p : (n, 3)
    corners : (n, 3, 3)
    """
    sides = np.stack([corners[:, (i + 1) % 3] - corners[:, i] for i in range(3)], axis=1)
    first = np.argmax(norm(sides), axis=1)
    rows = np.arange(len(corners))
    a, b, c = (corners[rows, (first + i) % 3] for i in range(3))
    along, length = unit_or(b - a, STILL[0])
    rise = c - a
    for _ in range(2):  # the second time takes away what rounding left of the first
        rise = rise - scale(dot(rise, along), along)
    up, height = unit_or(rise, STILL[1])
    x, y, apex = dot(p - a, along), dot(p - a, up), dot(c - a, along)
    share = y / np.where(height > 0, height, 1.0)
    inside = (y >= 0) & (x >= apex * share) & (length - x >= (length - apex) * share) & (y <= height) & (height > 0)
    best = a + scale(x, along) + scale(y, up)
    least = np.where(inside, norm(p - best), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        foot = nearest_on_segment(p, u, v)
        gap = norm(p - foot)
        nearer = gap < least
        best, least = np.where(nearer[:, None], foot, best), np.where(nearer, gap, least)
    return np.asarray(best)


def points_surface(solid: Solid, points: Array) -> tuple[Array, Array, Array]:
    """Signed distances of points from a solid, the nearest points of its surface, and the unit normals there.

    Inside, the nearest point of the surface is where the shortest way out ends, so this is exact on both sides. Where
    a point is on the surface, the normal is its face's.

    Parameters
    ----------
    solid : Solid
    points : (n, 3)
        In the solid's frame.
    """
    if len(solid.triangles) > FEW_FACES:
        found = [point_surface(solid, p) for p in points]
        return (
            np.array([gap for gap, _, _ in found]),
            np.array([foot for _, foot, _ in found]).reshape(-1, 3),
            np.array([normal for _, _, normal in found]).reshape(-1, 3),
        )
    parts = [_all_faces(solid, points[i : i + CHUNK]) for i in range(0, len(points), CHUNK)]
    gap, foot, normal = (np.concatenate(column) for column in zip(*parts, strict=True))
    return gap, foot, normal


def _all_faces(solid: Solid, points: Array) -> tuple[Array, Array, Array]:
    """The same for few faces: all of them are looked at."""
    count, faces = len(points), len(solid.triangles)
    from_point = np.repeat(points, faces, axis=0)
    feet = nearest_on_triangles(from_point, np.tile(solid.corners, (count, 1, 1)))
    gaps = norm(from_point - feet).reshape(count, faces)
    face = np.argmin(gaps, axis=1)
    rows = np.arange(count)
    gap, foot = gaps[rows, face], feet.reshape(count, faces, 3)[rows, face]
    inside = winding_numbers(solid.corners, points, solid.face_bounds) > 0
    return _signed(points, gap, foot, inside, solid.corners[face])


def point_surface(solid: Solid, p: Array) -> tuple[float, Array, Array]:
    """Signed distance of one point from a solid, by the boxes of its faces; see `points_surface`."""
    faces, bounds = solid.surface.nearest_to(p)
    gap, foot, face, start = np.inf, p, 0, 0
    while start < len(faces) and bounds[start] <= gap:
        some = faces[start : start + BATCH]
        feet = nearest_on_triangles(np.broadcast_to(p, (len(some), 3)), solid.corners[some])
        gaps = norm(p - feet)
        i = int(np.argmin(gaps))
        if gaps[i] < gap:
            gap, foot, face = float(gaps[i]), feet[i], int(some[i])
        start += BATCH
    corners = solid.corners[face][None]
    _, _, normal = _signed(p[None], np.array([gap]), foot[None], np.zeros(1, dtype=bool), corners)
    inside = gap > 0 and float(dot(normal[0], p - foot)) < 0  # over a face: behind it, for nothing lies between
    if not (inside or _faces_away(normal, corners)):
        inside = bool(winding_numbers(solid.corners, p[None], solid.face_bounds)[0] > 0)
        _, _, normal = _signed(p[None], np.array([gap]), foot[None], np.array([inside]), corners)
    return (-gap if inside else gap), foot, normal[0]


def _faces_away(normal: Array, corners: Array) -> bool:
    """Whether a normal is its face's own."""
    return bool(np.all(normal == _outward(corners)))


def _signed(p: Array, gap: Array, foot: Array, inside: Bools, corners: Array) -> tuple[Array, Array, Array]:
    """Signed distances, feet, and outward normals."""
    outward = _outward(corners)
    away, _ = unit_or(np.where(inside[:, None], foot - p, p - foot), outward)
    over = (np.abs(dot(away, outward)) > 1 - 1e-8) | (gap == 0)  # over a face: its own normal has fewer roundings
    return np.where(inside, -gap, gap), foot, np.where(over[:, None], outward, away)


def _outward(corners: Array) -> Array:
    """Unit normals of faces."""
    return unit_or(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), STILL[2])[0]


def mesh_heights(p: Array, mesh: Polyhedron) -> Separation:
    """Signed distances of points from polyhedra, exact on both sides of the surface; points first."""
    turn = rotation_matrix(mesh.rotation)
    local = apply_inverse(turn, p - mesh.position)
    gap, foot, outward = points_surface(mesh.solid, local)
    return Separation(gap, p, apply(turn, foot) + mesh.position, -apply(turn, outward))
