"""The surface of a mesh as one composite: the very numbers of the composite of its faces, made one by one."""

import numpy as np
import pytest

from refimpl import (
    AABB,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Sphere,
    distance,
    intersect,
)
from refimpl.contacts import contacts
from refimpl.overlaps import resolve
from refimpl.proof import certify, check
from tests.solids import L_SHAPE, hollow_box, prism
from tests.test_unions import SOLID_KINDS, make

N = 12


def both(vertices, triangles, seed, n=N):
    """A batch of poses of a mesh's surface: as one, and as the union of its faces."""
    rng = np.random.default_rng(seed)
    mesh = Polyhedron(vertices, triangles, rng.uniform(-1, 1, (n, 3)), rng.normal(size=(n, 4)))
    corners = np.asarray(vertices)[np.asarray(triangles)]
    faces = [ConvexPolyhedron.from_vertices(corner, mesh.position, mesh.rotation) for corner in corners]
    return Composite.of_faces(mesh), Composite(faces)


MESHES = [prism(L_SHAPE), hollow_box()]


@pytest.mark.parametrize("kind", [*SOLID_KINDS, Composite])
@pytest.mark.parametrize("number", [0, 1])
def test_a_surface_is_the_union_of_its_faces_to_the_bit(kind, number):
    surface, faces = both(*MESHES[number], seed=number)
    other = make(kind, np.random.default_rng(3), n=N)
    one, many = resolve(other, surface), resolve(other, faces)
    assert np.any(one.separation.distance < 0) or kind is HalfSpace
    for name in ("distance", "on_a", "on_b", "normal"):
        assert np.array_equal(getattr(one.separation, name), getattr(many.separation, name)), name
    assert np.array_equal(one.lower, many.lower)
    assert np.array_equal(intersect(surface, other), intersect(faces, other))
    if kind is Sphere:
        assert np.array_equal(distance(surface, faces).distance, distance(faces, faces).distance)


def test_what_it_says_of_itself_is_what_the_faces_say():
    surface, faces = both(*MESHES[0], seed=5)
    offset = np.arange(3.0 * N).reshape(N, 3)
    for one, many in (
        (surface, faces),
        (surface[2:7], faces[2:7]),
        (surface.translated(offset), faces.translated(offset)),
    ):
        assert np.array_equal(one.magnitude, many.magnitude)
        assert one.sizes == many.sizes
        assert one.batch_shape == many.batch_shape
        assert np.array_equal(one.pack(), many.pack())
    assert surface.identity()[0] != both(*MESHES[1], seed=5)[0].identity()[0]
    form, rows = surface.identity()
    assert form == surface[::-1].identity()[0]
    assert len(np.unique(rows, axis=0)) == N


def test_points_have_the_distance_of_the_nearest_face_inside_and_outside():
    """By the heights above the solid; the faces go by their closest features."""
    for number, mesh in enumerate(MESHES):
        surface, faces = both(*mesh, seed=number, n=200)
        points = Point(np.random.default_rng(8).uniform(-2, 2, (200, 3)))
        solid = Polyhedron(*mesh, surface.mesh.position, surface.mesh.rotation)
        inside = distance(points, solid).distance < 0
        assert inside.any()
        one, many = distance(points, surface), distance(points, faces)
        assert np.all(one.distance > 0)
        assert np.abs(one.distance - many.distance).max() < 1e-14
        assert np.abs(one.on_b - one.on_a - one.distance[:, None] * one.normal).max() < 1e-14
        swapped = distance(surface, points)
        assert np.array_equal(swapped.distance, one.distance)
        assert np.array_equal(swapped.normal, -one.normal)


@pytest.mark.parametrize("other", [Sphere([0.3, 0.2, 0.1], 0.4), AABB([0, 0, 0], [1, 1, 1]), Point([0.1, 0.2, 0.3])])
def test_its_answers_are_proven(other):
    surface = both(*MESHES[0], seed=1)[0][0]
    certificate = certify(other, surface)
    lower, upper = check(certificate, other, surface)
    assert lower <= distance(other, surface).distance + 1e-14
    assert upper >= distance(other, surface).distance - 1e-14


def test_a_surface_may_be_a_part_of_another_union():
    surface, faces = both(*MESHES[0], seed=2)
    ball, other = Sphere([2.0, 0, 0], 0.5), make(Ellipsoid, np.random.default_rng(4), n=N)
    one, many = resolve(other, Composite([ball, surface])), resolve(other, Composite([ball, faces]))
    assert np.array_equal(one.separation.distance, many.separation.distance)
    middle = surface.mesh.position[0]
    tool = Capsule(middle - 3.0, middle + 3.0, 0.3)
    found, wanted = (contacts(tool, Composite([ball, whole[0]])) for whole in (surface, faces))
    assert len(found) > 0
    assert np.array_equal(found.part_b, wanted.part_b)
