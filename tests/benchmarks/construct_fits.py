"""How well colliders fit, and how long they take: ``python -m tests.benchmarks.construct_fits [COUNT] [MODEL ...]``.

A model is a mesh file, or the path of one within `pybullet_data`. Beside the fits stand the simple ways that they have
to beat: the smallest enclosing ball, and the largest balls inside about centres that k-means finds for points inside.
Distances are in thousandths of the model's longest side; seconds are of the processor, for the fit alone.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.cluster.vq import kmeans2

from refimpl import Composite, Polyhedron, Proxy, Sphere, load_polyhedron
from refimpl.construct import (
    ConstructionError,
    decomposed,
    fitted_boxes,
    fitted_capsules,
    fitted_spheres,
    medial_spheres,
    packed_spheres,
    points_of,
    sphere,
)
from refimpl.construct.adjusting import target_of
from refimpl.construct.measures import surface_distance, volume_overlap
from refimpl.construct.medial import inscribed_radii
from tests.solids import torus

MODELS = ("bunny.obj", "franka_panda/meshes/collision/link0.obj", "laikago/chassis.stl", "torus of 10 000 faces")


def by_k_means(mesh: Polyhedron, count: int) -> Composite:
    """The largest balls inside, about the means of clusters of points inside."""
    target = target_of(mesh.solid, 4096)
    points = np.ldexp(target.within[0], target.exponent) + target.middle
    centers, _ = kmeans2(points, count, minit="++", seed=0)
    radii = inscribed_radii(mesh.solid, centers)
    return Composite([Sphere(c, r) for c, r in zip(centers, radii, strict=True) if r > 0])


WAYS: dict[str, Callable[[Polyhedron, int], Proxy]] = {
    "enclosing ball": lambda mesh, _: sphere(points_of(mesh)),
    "k-means, balls inside": by_k_means,
    "packed spheres": packed_spheres,
    "medial spheres": medial_spheres,
    "fitted spheres": fitted_spheres,
    "fitted capsules": fitted_capsules,
    "fitted boxes": fitted_boxes,
    "convex decomposition": decomposed,
}


def model_of(name: str) -> Polyhedron:
    """A mesh by the name that the command was given."""
    if name == MODELS[-1]:
        return Polyhedron(*torus(around=100, across=50))
    path = Path(name)
    if not path.exists():
        import pybullet_data  # noqa: PLC0415  an extra

        path = Path(pybullet_data.getDataPath()) / name
    return load_polyhedron(path)


def row_of(way: str, mesh: Polyhedron, count: int) -> list[str]:
    """One line of the table."""
    began = time.process_time()
    try:
        proxy = WAYS[way](mesh, count)
    except ConstructionError as error:
        return [way, "–", str(error)]
    seconds = time.process_time() - began
    volume, surface = volume_overlap(proxy, mesh), surface_distance(proxy, mesh)
    unit = float(np.max(np.ptp(mesh.vertices, axis=0))) / 1000
    shares = (volume.iou, volume.covered, volume.outside)
    lengths = (surface.mean / unit, surface.of_proxy.over / unit, surface.hausdorff / unit)
    parts = len(proxy.parts) if isinstance(proxy, Composite) else 1
    return [way, str(parts), *(f"{x:.3f}" for x in shares), *(f"{x:.1f}" for x in lengths), f"{seconds:.1f}"]


def main(arguments: list[str]) -> None:
    """Print a table for each model."""
    count = int(arguments[0]) if arguments else 16
    medial_spheres(model_of(MODELS[-1]), 1)  # compiles what is compiled
    for name in arguments[1:] or MODELS:
        mesh = model_of(name)
        columns = ("parts", "IoU", "covered", "outside", "mean", "stands out", "Hausdorff", "s")
        table = Table("", *columns, title=f"{name}: {len(mesh.triangles)} faces")
        for way in WAYS:
            table.add_row(*row_of(way, mesh, count))
        Console().print(table)


if __name__ == "__main__":
    main(sys.argv[1:])
