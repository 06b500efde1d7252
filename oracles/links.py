"""The solid of one link of a robot: the meshes and boxes of a URDF's link, placed as the link has them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from oracles.meshfiles import ModelError, read_bytes
from oracles.models import CUBE, found_mesh
from oracles.urdf import Element, link_elements, shown
from refimpl.linear import Array, apply, rotation_matrix
from refimpl.loading import LoadError, polyhedron_of, read_faces
from refimpl.meshes import Triangles
from refimpl.repairs import Mesh
from refimpl.shapes import Polyhedron

SORTS = ("collision", "visual")
MOST_NAMED = 12
MANIFEST = "package.xml"
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Corners of a box's sides, anticlockwise from outside, as `CUBE` has them."""


def solid_of_link(
    path: Path,
    link: str = "",
    *,
    sort: str = "",
    root: Path | None = None,
    repairs: Iterable[str] = (),
    scale: float = 1.0,
) -> tuple[str, Polyhedron]:
    """Name and solid of a link, in the link's frame: what its elements' faces bound, all of them together.

    Parameters
    ----------
    path
        A URDF file.
    link
        Its name; may be left out where only one link has such elements.
    sort : {"", "collision", "visual"}
        Which elements; by default those that collide, or else those that are seen.
    root
        The folder that files of meshes must be in, and in which packages are looked for. By default that of the
        package (with a ``package.xml``) around the URDF, else the one above the URDF's folder.
    repairs, scale
        As for `load_polyhedron`.

    Raises
    ------
    ModelError
        For a file that is no URDF, a link that there is not, a mesh outside of the folder or not there, and a link that
        has round elements, which are proxies already.
    LoadError
        For a mesh that bounds no solid; see `load_polyhedron`.
    """
    path, repairs = path.absolute(), tuple(repairs)
    data = read_bytes(path)
    found = next((links for one in ([sort] if sort else SORTS) if (links := link_elements(data, one))), {})
    if not found:
        raise ModelError(f"has no link with a {sort or 'collision or visual'} element")
    name = _chosen(link, list(found), sort)
    inside = (_package(path) if root is None else root).resolve()
    meshes = [_faces(element, path, inside, repairs) for element in found[name]]
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    vertices = np.concatenate([vertices for vertices, _ in meshes])
    triangles = np.concatenate([faces + start for (_, faces), start in zip(meshes, starts, strict=False)])
    return name, polyhedron_of(f"{path.name}, link {shown(name)}", (vertices, triangles), scale=scale, repairs=repairs)


def _chosen(link: str, names: list[str], sort: str) -> str:
    known = ", ".join(map(shown, names[:MOST_NAMED])) + (", …" if len(names) > MOST_NAMED else "")
    if link and link not in names:
        raise ModelError(f"has no link {shown(link)} with a {sort or 'collision or visual'} element; there are {known}")
    if not link and len(names) > 1:
        raise ModelError(f"has {len(names)} links with shapes: {known}")
    return link or names[0]


def _package(path: Path) -> Path:
    """The folder of the package that a file belongs to, or the one above its own."""
    around = path.resolve().parents
    return next((folder for folder in around if (folder / MANIFEST).is_file()), around[min(1, len(around) - 1)])


def _faces(element: Element, path: Path, root: Path, repairs: tuple[str, ...]) -> Mesh:
    """Faces of an element in its link's frame."""
    if element.sort == "mesh":
        vertices, triangles = _of_file(element, path, root, repairs)
        vertices = vertices * np.array(element.sizes)
        if np.prod(np.sign(element.sizes)) < 0:
            triangles = triangles[:, ::-1]
    elif element.sort == "box":
        vertices, triangles = CUBE * np.array(element.sizes) / 2, _sides()
    else:
        raise ModelError(f"{element.where}: a {element.sort} is a proxy already; solids are made of meshes and boxes")
    return _placed(element, vertices), triangles


def _of_file(element: Element, path: Path, root: Path, repairs: tuple[str, ...]) -> Mesh:
    """Faces of the file that an element names."""
    try:
        file = found_mesh(element.file, path.resolve(), root)
        return read_faces(file, repairs)
    except (ModelError, LoadError) as error:
        why = str(error).rpartition(f"{root}/")[2]  # where the package lies is no news
        raise ModelError(f"{element.where}: {shown(element.file)!r}: {why}") from None


def _sides() -> Triangles:
    return np.array([(a, *pair) for a, b, c, d in SIDES for pair in ((b, c), (c, d))], dtype=np.int64)


def _placed(element: Element, vertices: Array) -> Array:
    turn = rotation_matrix(element.pose.rotation)
    return (
        apply(turn, vertices) + element.pose.position if np.any(turn != np.eye(3)) else vertices + element.pose.position
    )
