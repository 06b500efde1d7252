"""Points from whatever a bounding volume is asked for: an array, a mesh file, a mesh, a polytope."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from refimpl.linear import Array
from refimpl.loading import LARGEST
from refimpl.meshfiles import FORMATS, FileError, form_of, numbers, parsed, read_bytes
from refimpl.pointfiles import CLOUDS, points_in
from refimpl.proxy import ShapeError
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron

MOST_POINTS = 1 << 24


class ConstructionError(ShapeError):
    """No proxy of the wanted type can be made from what was given; the text says why, and what can."""


def points_of(source: Any) -> Array:
    """Points (n, 3) whose hull is to be bounded.

    Parameters
    ----------
    source
        An array (n, 3), the path of a mesh file (its faces' corners; nothing else of it is needed, so that it may be
        open) or of a file of points (see `refimpl.pointfiles`), a `Polyhedron`, a `ConvexPolyhedron` of vertices in the
        frame in which they were given, a composite of these, or what else has `vertices` and perhaps `faces`, such as a
        `trimesh.Trimesh` or `trimesh.PointCloud`.

    Raises
    ------
    ConstructionError
        For no point at all, for a number that is not finite (the first such is named), and for a file or an object
        that is no mesh.
    """
    if isinstance(source, str | Path):
        return _checked(_of_file(Path(source)), str(source))
    if isinstance(source, Composite):
        return np.concatenate([points_of(part) for part in source.parts])
    if isinstance(source, Polyhedron | ConvexPolyhedron):
        return _of_polytope(source)
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return _checked(_of_mesh(source), type(source).__name__)
    if hasattr(source, "vertices"):
        return _checked(source.vertices, type(source).__name__)
    return _checked(source, "points")


def _of_file(path: Path) -> Array:
    form = form_of(path)
    if form not in (*FORMATS, *CLOUDS):
        known = f"meshes are read from {', '.join(FORMATS)} files, points from {', '.join(CLOUDS)} files"
        raise ConstructionError(f"{path}: {known}, this is {form or 'without suffix'}")
    try:
        if form in CLOUDS:
            return points_in(read_bytes(path, LARGEST), form)
        meshes = parsed(read_bytes(path, LARGEST), form, split=False)
    except FileError as error:
        raise ConstructionError(f"{path} {error}") from None
    return np.concatenate([vertices[np.unique(triangles)] for vertices, triangles in meshes])


def _of_mesh(mesh: Any) -> Array:
    try:
        vertices, triangles = numbers(mesh)
    except FileError as error:
        raise ConstructionError(f"{type(mesh).__name__} object {error}") from None
    return np.asarray(vertices[np.unique(triangles)])


def _of_polytope(solid: Polyhedron | ConvexPolyhedron) -> Array:
    """Corners in the solid's own frame, where they are no rounded numbers; a pose would round them."""
    name = type(solid).__name__
    if solid.batch_shape:
        raise ConstructionError(f"expected a single {name}, got a batch of {solid.batch_shape}")
    if np.any(solid.position != 0) or np.any(solid.rotation[..., :3] != 0):
        raise ConstructionError(f"the {name} is moved or turned, which rounds its corners; bound it in its own frame")
    if isinstance(solid, ConvexPolyhedron) and solid.given == "planes":
        raise ConstructionError(
            "a ConvexPolyhedron of planes has corners that are no doubles, and points near them bound another set; "
            "build it by ConvexPolyhedron.from_vertices"
        )
    return np.array(solid.vertices, dtype=np.float64)


def _checked(given: Any, name: str) -> Array:
    """Finite points, at least one."""
    try:
        points = np.array(given, dtype=np.float64, order="C") + 0.0
    except (TypeError, ValueError) as error:
        raise ConstructionError(f"{name}: expected points (n, 3), got {type(given).__name__} ({error})") from None
    if points.ndim != 2 or points.shape[1] != 3:
        raise ConstructionError(f"{name}: expected points (n, 3), got an array of shape {points.shape}")
    if not len(points):
        raise ConstructionError(f"{name}: there is no point to bound")
    if len(points) > MOST_POINTS:
        raise ConstructionError(f"{name}: {len(points)} points, more than {MOST_POINTS}")
    if not (np.isfinite(points.max()) and np.isfinite(points.min())):
        where = int(np.argwhere(~np.isfinite(points))[0][0])
        raise ConstructionError(f"{name}: point {where} is not finite: {points[where].tolist()}")
    return points
