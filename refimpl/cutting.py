"""Which plane cuts a cell best: planes of its faces are compared by the faces that are left in front of others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from refimpl.cells import UNSURE, Arrangement, Loop

CANDIDATES = 24  # cutting planes that are compared for a cell
SAMPLE = 120  # faces of a cell that are looked at for the comparison
LEVEL = 1e-12  # what is looked at for choosing only may be decided roughly


class Face(NamedTuple):
    """What of a mesh's face lies in a cell.

    `side` is 1 where the stored plane's normal looks outwards. `lines` says of each edge, from its corner on, what it
    is part of: a plane's number, or the two ends of an edge of the mesh.
    """

    plane: int
    side: int
    loop: Loop
    lines: tuple[int | tuple[int, int], ...]


def cutting_plane(space: Arrangement, faces: list[Face]) -> int | None:
    """Plane of a face that other faces lie in front of, chosen so that few such pairs are left; None without any."""
    if len(faces) > SAMPLE:
        some = [faces[i] for i in np.linspace(0, len(faces) - 1, SAMPLE).astype(int).tolist()]
        plane = _best_plane(space, some)
        if plane is not None:
            return plane
    elif (plane := _best_plane(space, faces)) is not None:
        return plane
    return _any_concave(space, faces)


def _best_plane(space: Arrangement, faces: list[Face]) -> int | None:
    """Of the planes of these faces, the one whose cut leaves the fewest pairs (plane, face in front of it)."""
    start = np.cumsum([0] + [len(face.loop) for face in faces[:-1]])
    near = np.array([space.near[corner] for face in faces for corner in face.loop])
    slopes = np.array([space.slopes[face.plane] for face in faces]) * np.array([[face.side] for face in faces])
    height = slopes[:, :3] @ near.T + slopes[:, 3:]
    front = np.maximum.reduceat(height, start, axis=1) > LEVEL
    concave = np.flatnonzero(front.any(axis=1))
    if len(concave) == 0:
        return None
    if len(concave) > CANDIDATES:
        concave = concave[np.linspace(0, len(concave) - 1, CANDIDATES).astype(int)]
    back = np.minimum.reduceat(height[concave], start, axis=1) < -LEVEL
    relation = front.astype(np.float32)
    left = np.zeros(len(concave))
    for part in (front[concave].astype(np.float32), back.astype(np.float32)):
        left += np.sum((part @ relation) * part, axis=1)
    return faces[int(concave[np.argmin(left)])].plane


def _any_concave(space: Arrangement, faces: list[Face]) -> int | None:
    """Plane of a face that some corner lies in front of; decided exactly."""
    planes = list(dict.fromkeys((face.plane, face.side) for face in faces))
    corners = list(dict.fromkeys(corner for face in faces for corner in face.loop))
    near = np.array([space.near[corner] for corner in corners])
    slopes = np.array([space.slopes[plane] for plane, _ in planes]) * np.array([[side] for _, side in planes])
    for first in range(0, len(planes), 256):
        height = slopes[first : first + 256, :3] @ near.T + slopes[first : first + 256, 3:]
        if np.any(height > LEVEL):
            return planes[first + int(np.argmax(np.max(height, axis=1)))][0]
        for i, j in np.argwhere(height > -2 * UNSURE).tolist():
            plane, side = planes[first + i]
            if space.side(corners[j], plane) == side:
                return plane
    return None
