"""Models: real geometry, and what each of them can be used as.

A model is what a mesh file or a URDF holds: pieces, which are meshes and simple proxies. It can be had as the hull of
its vertices, as a solid, when its mesh bounds one, and as a composite: the simple proxies of a URDF and the hulls of
its meshes' objects, which is what physics engines make of them. What a model cannot be is refused with the defect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from oracles.meshfiles import Mesh, ModelError, merged, read_bytes, read_mesh, require_usable
from oracles.urdf import ORIGIN, Element, Pose, collision_elements, shown
from refimpl.linear import Array, apply, rotation_matrix
from refimpl.meshes import directed_edges, require_solid
from refimpl.shapes import Box, Capsule, Composite, ConvexPolyhedron, Cylinder, Polyhedron, Proxy, ShapeError, Sphere
from refimpl.signs import Points

HULL, SOLID, COMPOSITE = FORMS = ("hull", "solid", "composite")
MOST_VERTICES, MOST_FACES, MOST_PARTS = 600, 1000, 64
"""Sizes beyond which a hull, a solid, a composite are refused: one scene of them would take the time of hundreds."""
MOST_CONCAVE = 64
"""Concave edges beyond which a solid is refused: it has about as many convex pieces, and overlaps test all pairs."""
MOST_CHECKED = 5000
"""Faces up to which a mesh that is too large is still searched for defects."""
LONGEST_LABEL = 60
SMALLEST = 1e-9
"""Least thickness of a hull relative to its largest extent; below, it counts as flat."""
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)


@dataclass(frozen=True)
class MeshPiece:
    """A mesh and where it stands in its model."""

    mesh: Mesh
    pose: Pose = ORIGIN

    @property
    def corners(self) -> Array:
        """The vertices in the model's frame."""
        return self.pose.position + apply(rotation_matrix(self.pose.rotation), self.mesh.vertices)


Piece = MeshPiece | Proxy


@dataclass(eq=False)
class Model:
    """One model: read when it is first used, and then remembered in the forms that were asked for.

    Attributes
    ----------
    name
        The file's path within its folder.
    read
        Gives the pieces, or raises `ModelError`.
    """

    name: str
    read: Callable[[], Sequence[Piece]]
    made: dict[str, Proxy | ModelError] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The name in harmless letters and not too long, for the name of a scene."""
        plain = ascii(self.name)[1:-1]
        return plain if len(plain) <= LONGEST_LABEL else "..." + plain[-LONGEST_LABEL:]

    def form(self, form: str) -> Proxy:
        """The model as a single proxy in its own frame.

        Parameters
        ----------
        form : {"hull", "solid", "composite"}
            A `ConvexPolyhedron` by vertices, a `Polyhedron` or a `Composite`.

        Raises
        ------
        ModelError
            When the model cannot be that; the text says why.
        """
        if form not in self.made:
            try:
                self.made[form] = MAKERS[form](_pieces_of(self))
            except ModelError as error:
                self.made[form] = error
            except ShapeError as error:
                self.made[form] = ModelError(str(error).removeprefix("Polyhedron: "))
        made = self.made[form]
        if isinstance(made, ModelError):
            raise made
        return made

    def size(self, form: str) -> int:
        """Vertices of its hull, faces of its solid, or parts of its composite."""
        match self.form(form):
            case ConvexPolyhedron() as hull:
                return int(hull.numbers.shape[-2])
            case Polyhedron() as solid:
                return len(solid.triangles)
            case Composite() as composite:
                return len(composite.parts)
        raise AssertionError(form)

    def defect(self, form: str) -> str:
        """Why the model cannot have a form; empty when it can."""
        try:
            self.form(form)
        except ModelError as error:
            return str(error)
        return ""


@lru_cache(maxsize=8)
def _pieces_of(model: Model) -> Sequence[Piece]:
    """Pieces of a model, remembered for a while: forms are asked for one after the other."""
    return model.read()


# -- forms ---------------------------------------------------------------------------------------------------


def hull_of(points: Array) -> ConvexPolyhedron:
    """Hull of points by their extreme ones; those that qhull takes for inner ones are left out."""
    extents = np.ptp(points, axis=0)
    try:
        outer = points[np.sort(ConvexHull(points).vertices)]
    except (QhullError, ValueError):
        raise ModelError("is flat: its hull has no volume") from None
    thin = np.linalg.svd(outer - outer.mean(axis=0), compute_uv=False)[-1]
    if thin < SMALLEST * extents.max():
        raise ModelError("is flat: its hull has next to no volume")
    if len(outer) > MOST_VERTICES:
        raise ModelError(f"is too large: {len(outer)} vertices on its hull, at most {MOST_VERTICES}")
    return ConvexPolyhedron.from_vertices(outer)


def _hull(pieces: Sequence[Piece]) -> Proxy:
    corners = []
    for piece in pieces:
        match piece:
            case MeshPiece():
                corners.append(piece.corners)
            case Box():
                turned = apply(rotation_matrix(piece.rotation), CUBE * piece.half_extents)
                corners.append(piece.center + turned)
            case _:
                raise ModelError(f"has a round part, a {type(piece).__name__}, so its hull has no corners")
    return hull_of(np.concatenate(corners))


def _solid(pieces: Sequence[Piece]) -> Proxy:
    meshes = [Mesh(piece.corners, piece.mesh.triangles) for piece in pieces if isinstance(piece, MeshPiece)]
    if len(meshes) < len(pieces):
        raise ModelError("has parts that are no meshes")
    whole = merged(meshes)
    faces = len(whole.triangles)
    if MOST_FACES < faces <= MOST_CHECKED:
        require_solid(whole.vertices, whole.triangles)  # a defect says more than the size
    if faces > MOST_FACES:
        raise ModelError(f"is too large: {faces} faces, at most {MOST_FACES}")
    solid = Polyhedron(whole.vertices, whole.triangles)
    concave = concave_edges(solid)
    if concave > MOST_CONCAVE:
        raise ModelError(f"splits into too many convex pieces: {concave} concave edges, at most {MOST_CONCAVE}")
    return solid


def concave_edges(solid: Polyhedron) -> int:
    """Number of edges along which a solid's faces fold towards each other, decided exactly."""
    edges, faces = directed_edges(solid.triangles)
    opposite = np.concatenate([solid.triangles[:, 2], solid.triangles[:, 0], solid.triangles[:, 1]])
    there, back = np.lexsort(edges.T), np.lexsort(edges.T[::-1])  # each edge is run through both ways, once
    across = np.empty(len(edges), dtype=np.int64)
    across[there] = opposite[back]
    a, b, c = solid.triangles[faces].T
    return int(np.sum(Points(solid.vertices).orientation(a, b, c, across) > 0)) // 2


def _composite(pieces: Sequence[Piece]) -> Proxy:
    if len(pieces) > MOST_PARTS:
        raise ModelError(f"is too large: {len(pieces)} parts, at most {MOST_PARTS}")
    if len(pieces) < 2:
        raise ModelError("is one piece, so as a composite it is nothing new")
    parts: list[Proxy] = []
    for number, piece in enumerate(pieces):
        if isinstance(piece, Proxy):
            parts.append(piece)
            continue
        try:
            hull = hull_of(piece.mesh.vertices)
        except ModelError as error:
            raise ModelError(f"part {number} {error}") from None
        parts.append(ConvexPolyhedron.from_vertices(hull.numbers, piece.pose.position, piece.pose.rotation))
    return Composite(parts)


MAKERS: dict[str, Callable[[Sequence[Piece]], Proxy]] = {HULL: _hull, SOLID: _solid, COMPOSITE: _composite}


# -- files ---------------------------------------------------------------------------------------------------


def confined(path: Path, root: Path) -> Path:
    """Where a path leads in the end, links followed; a `ModelError` when that is outside of `root`."""
    try:
        real = path.resolve()
        inside = real.is_relative_to(root.resolve())
    except (OSError, RuntimeError, ValueError) as error:  # loops of links, null characters
        raise ModelError(f"leads nowhere: {shown(str(error))}") from None
    if not inside:
        raise ModelError("lies outside of the folder")
    return real


def mesh_model(path: Path, root: Path) -> Sequence[Piece]:
    """Pieces of a mesh file: its objects."""
    return [MeshPiece(mesh) for mesh in read_mesh(confined(path, root))]


def urdf_model(path: Path, root: Path) -> Sequence[Piece]:
    """Pieces of a URDF: its collision elements, the objects of its meshes one by one."""
    elements = collision_elements(read_bytes(confined(path, root)))
    if len(elements) > MOST_PARTS:
        raise ModelError(f"is too large: {len(elements)} collision elements, at most {MOST_PARTS}")
    files: dict[str, tuple[Mesh, ...]] = {}
    pieces: list[Piece] = []
    for element in elements:
        try:
            if element.sort == "mesh" and element.file not in files:
                files[element.file] = read_mesh(found_mesh(element.file, path, root))
            pieces += _pieces(element, files)
        except (ModelError, ShapeError) as error:
            named = f" {shown(element.file)!r}" if element.file else ""
            raise ModelError(f"{element.where}:{named} {error}") from None
    return pieces


def found_mesh(said: str, urdf: Path, root: Path) -> Path:
    """Find the file of a mesh: beside the URDF, or, for a package, in a folder above it that has such a path."""
    scheme, _, rest = said.rpartition("://")
    if scheme not in ("", "package"):
        raise ModelError("is no file: only relative paths and package:// are followed")
    if rest.startswith(("/", "\\")) or Path(rest).is_absolute():
        raise ModelError("is an absolute path")
    above = [folder for folder in urdf.parents if folder == root or folder.is_relative_to(root)]
    within = rest.partition("/")[2]
    candidates = [folder / rest for folder in above]
    if scheme and within:
        candidates += [folder / within for folder in above]
    outside = None
    for candidate in candidates:
        try:
            real = confined(candidate, root)
            if real.is_file():
                return real
        except ModelError as error:
            outside = outside or error
        except OSError as error:  # a name longer than the system allows
            raise ModelError(f"cannot be read: {error.strerror or error}") from None
    raise outside or ModelError("is not there")


def _pieces(element: Element, files: dict[str, tuple[Mesh, ...]]) -> list[Piece]:
    place, sizes = element.pose, element.sizes
    require_usable(place.position)
    if element.sort == "mesh":
        return [MeshPiece(_scaled(mesh, sizes), place) for mesh in files[element.file]]
    if element.sort == "box":
        return [Box(place.position, np.array(sizes) / 2, place.rotation)]
    if element.sort == "sphere":
        return [Sphere(place.position, sizes[0])]
    radius, length = sizes
    half = apply(rotation_matrix(place.rotation), np.array([0.0, 0.0, length / 2]))
    kind = Cylinder if element.sort == "cylinder" else Capsule
    return [kind(place.position - half, place.position + half, radius)]


def _scaled(mesh: Mesh, factors: tuple[float, ...]) -> Mesh:
    """Stretch a mesh; a mirror image has its triangles turned over."""
    vertices = mesh.vertices * np.array(factors)
    require_usable(vertices)
    mirrored = np.prod(np.sign(factors)) < 0
    return Mesh(vertices, mesh.triangles[:, ::-1] if mirrored else mesh.triangles)
