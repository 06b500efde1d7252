"""A mesh as a union of convex parts that is nearly the mesh."""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.construct.models import in_moderate_unit, placed, solid_of, whole_number
from refimpl.construct.sources import ConstructionError
from refimpl.shapes import Composite, ConvexPolyhedron

THRESHOLD = 0.05


def decomposed(mesh: Any, count: int | None = None, *, threshold: float = THRESHOLD, seed: int = 0) -> Composite:
    """Convex hulls of parts into which a mesh is cut, until each hull is nearly its part.

    The parts are found by the library `coacd` (Wei, Liu, Ling and Su, Approximate Convex Decomposition for 3D Meshes
    with Collision-Aware Concavity and Tree Search, 2022), an extra: ``pip install 'proxyproof[decompose]'``. What is
    taken from it are vertices, of which the hulls are built here, exactly. Hulls may overlap a little, and what they
    fill of dents is not in the mesh.

    Parameters
    ----------
    mesh : Polyhedron, path of a mesh file, or trimesh object
    count : int, optional
        Parts at most, 1 to 256; where fewer than the threshold asks for, hulls are joined.
    threshold : float, 0.01 to 1
        Concavity of a part, in units of half the mesh's longest side: smaller gives more parts.
    seed : int
        The same seed gives the same parts.

    Returns
    -------
    Composite
        Of `ConvexPolyhedron`s by vertices.

    Raises
    ------
    ConstructionError
        Where coacd is not installed, or for a threshold or count out of range.
    """
    if not 0.01 <= threshold <= 1:
        raise ConstructionError(f"threshold: expected 0.01 to 1, got {threshold!r}")
    most = -1 if count is None else whole_number(count)
    polyhedron = solid_of(mesh)
    try:
        import coacd  # noqa: PLC0415  an extra
    except ImportError:
        raise ConstructionError("a convex decomposition needs coacd: pip install 'proxyproof[decompose]'") from None
    solid, exponent = in_moderate_unit(polyhedron)
    coacd.set_log_level("error")
    found = coacd.run_coacd(
        coacd.Mesh(solid.vertices, solid.triangles),
        threshold=threshold,
        max_convex_hull=most,
        preprocess_mode="off",  # it repairs what bounds no solid, and this does
        seed=seed,
    )
    hulls = [ConvexPolyhedron.from_vertices(np.asarray(vertices, dtype=np.float64)) for vertices, _ in found]
    return placed(polyhedron, exponent, Composite([hull for hull in hulls if hull.hull.dimension == 3]))
