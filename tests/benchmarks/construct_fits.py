"""How well colliders fit: ``python -m tests.benchmarks.construct_fits [--write [FOLDER]] [--count N] [MODEL ...]``.

Takes about two minutes of the processor, half of them for convex decompositions; ``--write`` makes the page
``colliders.md`` of the studies, whose figures but the seconds are the same on every machine. A model is a mesh file, or
the path of one within `pybullet_data`. Beside the fits stand the simple ways that they have to beat: the smallest
enclosing ball, and the largest balls inside about centres that k-means finds for points inside. Distances are in
thousandths of the model's longest side; seconds are of the processor, for the fit alone.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.progress import track
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
from refimpl.threads import products_in_one_thread
from reports import studies
from reports.console import console, fitted
from reports.markdown import table_lines
from reports.tables import Column, Entry, Table
from tests.solids import torus

HERE, PAGE = Path(str(studies.__file__)).parent, "colliders.md"
COUNT = 16
COLUMNS = ("way", "parts", "IoU", "covered", "outside", "mean", "stands out", "Hausdorff", "s")
TEXT = (
    "Colliders of at most {count} parts for models that PyBullet ships, and for a torus. IoU: the intersection of both "
    "volumes over their union; covered: the share of the model that is covered; outside: what lies outside of it, by "
    "its volume; mean: the two-sided mean distance of the surfaces; stands out: how far the collider's does on "
    "average; Hausdorff: the largest distance; all three in thousandths of the model's longest side; s: seconds of the "
    "processor for the fit alone. The first two ways are what the others have to beat. Packed and medial spheres stay "
    "inside, and so cannot have the best IoU."
)
MODELS = ("bunny.obj", "franka_panda/meshes/collision/link0.obj", "laikago/chassis.stl", "torus of 10 000 faces")


def by_k_means(mesh: Polyhedron, count: int) -> Composite:
    """The largest balls inside, about the means of clusters of points inside."""
    target = target_of(mesh.solid, 4096)
    points, weight = target.within
    even = np.searchsorted(np.cumsum(weight) / np.sum(weight), (np.arange(4096) + 0.5) / 4096)
    centers, _ = kmeans2(np.ldexp(points[even], target.exponent) + target.middle, count, minit="++", seed=0)
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
        return [way, "–", str(error), *[""] * (len(COLUMNS) - 3)]
    seconds = time.process_time() - began
    volume, surface = volume_overlap(proxy, mesh), surface_distance(proxy, mesh)
    unit = float(np.max(np.ptp(mesh.vertices, axis=0))) / 1000
    shares = (volume.iou, volume.covered, volume.outside)
    lengths = (surface.mean / unit, surface.of_proxy.over / unit, surface.hausdorff / unit)
    parts = len(proxy.parts) if isinstance(proxy, Composite) else 1
    return [way, str(parts), *(f"{x:.3f}" for x in shares), *(f"{x:.1f}" for x in lengths), f"{seconds:.1f}"]


def table_of(name: str, count: int) -> Table:
    """The table of a model."""
    mesh = model_of(name)
    rows = [row_of(way, mesh, count) for way in track(WAYS, description=name, transient=True)]
    columns = tuple(Column(title, at > 0) for at, title in enumerate(COLUMNS))
    return Table(
        f"{name}: {len(mesh.triangles)} faces", columns, tuple(tuple(Entry(cell) for cell in row) for row in rows)
    )


def told(tables: list[Table], count: int) -> str:
    """The page."""
    parts = [
        "# Colliders of a few parts, measured",
        "Made by `python -m tests.benchmarks.construct_fits --write`.",
        TEXT.format(count=count),
        *(f"## {table.title}\n\n" + "\n".join(table_lines(table)) for table in tables),
    ]
    return "\n\n".join(parts) + "\n"


def main(arguments: list[str]) -> None:
    """Print a table for each model, and write the page if asked to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", nargs="?", type=Path, const=HERE, help="write the page into this folder")
    parser.add_argument("--count", type=int, default=COUNT, help="parts of a collider")
    parser.add_argument("models", nargs="*", default=MODELS)
    asked = parser.parse_args(arguments)
    with products_in_one_thread():
        medial_spheres(model_of(MODELS[-1]), 1)  # compiles what is compiled
        tables = []
        for name in asked.models:
            tables.append(table_of(name, asked.count))
            console().print(fitted(tables[-1], console().width))
    if asked.write:
        (asked.write / PAGE).write_text(told(tables, asked.count), encoding="utf-8")
        print(asked.write / PAGE)


if __name__ == "__main__":
    main(sys.argv[1:])
