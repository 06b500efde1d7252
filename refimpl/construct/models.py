"""The mesh that colliders are made for: taken from wherever it is, in numbers that can be computed with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from refimpl.construct.sources import ConstructionError
from refimpl.linear import power_of_two
from refimpl.loading import from_trimesh, load_polyhedron
from refimpl.shapes import Composite, Polyhedron
from refimpl.solids import Solid

MOST = 256
"""Parts of a collider."""
MODERATE = 64
"""Meshes whose size is beyond 2^±64 are fitted in another unit."""


def solid_of(source: Any) -> Polyhedron:
    """Give the solid that a collider is to be made for.

    Parameters
    ----------
    source
        A single `Polyhedron`, the path of a mesh file, or a `trimesh.Trimesh`. Whatever needs a repair is loaded with
        it first: `load_polyhedron(path, repairs=[...])`.

    Raises
    ------
    ShapeError
        For anything else, a batch, and faces that bound no solid.
    """
    if isinstance(source, str | Path):
        return load_polyhedron(source)
    if isinstance(source, Polyhedron):
        if source.batch_shape:
            raise ConstructionError(f"mesh: expected a single Polyhedron, got a batch of shape {source.batch_shape}")
        return source
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return from_trimesh(source)
    raise ConstructionError(
        f"mesh: expected a Polyhedron, the path of a mesh file or a trimesh object, got {type(source).__name__}: "
        "a collider needs to know what is inside"
    )


def whole_number(count: Any) -> int:
    """Check the number of parts."""
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not 1 <= count <= MOST:
        raise ConstructionError(f"count: expected a whole number from 1 to {MOST}, got {count!r}")
    return int(count)


def in_moderate_unit(mesh: Polyhedron) -> tuple[Solid, int]:
    """Solid of numbers whose powers neither overflow nor vanish, and the exponent of its unit; mostly 0."""
    exponent = int(power_of_two(np.asarray(mesh.solid.extent)))
    if abs(exponent) <= MODERATE:
        return mesh.solid, 0
    return mesh.times_power(-exponent).solid, exponent


def placed(mesh: Polyhedron, exponent: int, found: Composite) -> Composite:
    """Put a composite that was found in the mesh's own frame to where the mesh is, unrounded where that is at home."""
    found = found.times_power(exponent)
    if np.any(mesh.rotation[:3] != 0):
        found = found.rotated(mesh.rotation)
    return found.translated(mesh.position) if np.any(mesh.position != 0) else found
