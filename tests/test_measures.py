"""Volume overlap and surface distances: against closed forms, quadrature, and another library."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
import trimesh

from refimpl.construct.heights import heights
from refimpl.construct.measures import Volume, proxy_volume, surface_distance, volume_overlap
from refimpl.construct.partition import partition
from refimpl.construct.surfaces import surface_samples
from refimpl.linear import norm
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Proxy,
    ShapeError,
    Sphere,
    UnsupportedOperation,
)
from refimpl.shapes.polytopes import USUAL_DIRECTIONS
from tests.solids import L_SHAPE, box, prism, torus

TURN = (0.1, 0.5, -0.3, 0.7)
CUBE = Polyhedron(*box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)))
TWO = Composite([Sphere([-0.5, 0, 0], 1.0), Sphere([0.5, 0, 0], 1.0)])
SOLIDS: list[Proxy] = [
    Sphere([1, 2, 3], 2.0),
    Capsule([0, 0, 0], [1, 2, 0], 0.5),
    Cylinder([0, 0, 0], [1, 2, 0], 0.7),
    Ellipsoid([1, 0, 0], [3, 1, 0.5], TURN),
    AABB([0, 0, 0], [1, 2, 3]),
    Box([3, 0, 0], [0.1, 1, 2], TURN),
    KDOP(USUAL_DIRECTIONS[14], np.full(7, -1.0), np.full(7, 1.5)),
    ConvexPolyhedron.from_vertices(np.random.default_rng(1).standard_normal((12, 3)), [1, 1, 1], TURN),
    Polyhedron(*torus(), [1, 2, 3], TURN),
]


def lens(r: float, d: float) -> float:
    """Volume that two balls of radius r at a distance d have in common: two caps."""
    h = r - d / 2
    return 2 * math.pi * h * h * (3 * r - h) / 3


def ball_in_cube(r: float) -> float:
    """Volume that a ball has in common with the cube of edge 1 about its centre, for r from 1/2 to √½."""
    h = r - 0.5
    return 4 / 3 * math.pi * r**3 - 6 * math.pi * h * h * (3 * r - h) / 3


@pytest.mark.parametrize("seed", range(4))
def test_a_measured_volume_is_within_its_error(seed: int):
    truth = 2 * 4 / 3 * math.pi - lens(1.0, 1.0)
    found = proxy_volume(TWO, boxes=8192, seed=seed)
    assert 0 < abs(found.value - truth) <= found.error < 0.04 * truth
    assert found.lower <= truth <= found.upper


def test_the_error_is_not_far_too_large():
    """Of many seeds the worst is a third of the bound at least, or the bound would be of no use."""
    truth = 2 * 4 / 3 * math.pi - lens(1.0, 1.0)
    found = [proxy_volume(TWO, boxes=512, seed=seed) for seed in range(40)]
    assert 0.2 < max(abs(f.value - truth) / f.error for f in found) <= 1


def test_common_volume_of_a_ball_and_a_cube():
    radius = 0.6
    found = volume_overlap(Sphere([0, 0, 0], radius), CUBE)
    ball, common = 4 / 3 * math.pi * radius**3, ball_in_cube(radius)
    assert found.mesh.value == pytest.approx(1, rel=1e-14)
    assert found.proxy == Volume(pytest.approx(ball, rel=1e-14), 0.0)  # type: ignore[arg-type]
    assert abs(found.common.value - common) <= found.common.error < 0.03
    iou = common / (1 + ball - common)
    assert found.iou_bounds[0] <= iou <= found.iou_bounds[1]
    assert found.iou == pytest.approx(iou, abs=0.01)
    assert found.covered == pytest.approx(common, abs=0.01)
    assert found.outside == pytest.approx(ball - common, abs=0.01)
    assert found.ratio == pytest.approx(ball, rel=1e-14)


def test_common_volume_of_boxes_with_faces_in_common():
    found = volume_overlap(AABB([-0.5, -0.5, 0], [0.5, 0.5, 2]), CUBE)
    assert found.common.value == pytest.approx(0.5, rel=1e-9)
    assert found.iou == pytest.approx(0.5 / 2.5, rel=1e-9)


def test_an_equal_proxy_has_all_in_common():
    mesh = Polyhedron(*torus())
    found = volume_overlap(mesh, mesh)
    assert found.iou_bounds[1] == 1
    assert found.iou == pytest.approx(1, abs=0.01)
    known = trimesh.Trimesh(*torus(), process=False).volume
    assert found.mesh.value == pytest.approx(known, rel=1e-12)


def test_proxies_apart_have_nothing_in_common():
    assert volume_overlap(Sphere([5, 0, 0], 1.0), CUBE).iou == 0
    assert volume_overlap(Box([0.9, 0.9, 0], [0.3, 0.3, 0.3], [0, 0, 0.38, 0.92]), CUBE).common.value == 0


def test_boxes_of_a_partition_fill_it_and_are_what_they_say():
    mesh = Polyhedron(*prism(L_SHAPE))
    lower, upper = np.array([-1.0, -1, -1]), np.array([3.0, 3, 2])
    found = partition(lambda at, reach: heights(mesh, at, reach), lower, upper, 500)
    assert np.sum(found.volume) == pytest.approx(np.prod(upper - lower), rel=1e-12)
    assert 100 < np.sum(found.mixed) <= 500
    random = np.random.default_rng(0).uniform(-1, 1, (4, *found.center.shape))
    x, y, z = np.moveaxis(found.center + random * found.half, -1, 0)
    inside = (z > 0) & (z < 1) & (x > 0) & (y > 0) & (x < 2) & (y < 2) & ((x < 1) | (y < 1))
    sure = ~found.mixed
    assert np.array_equal(inside[:, sure], np.broadcast_to(found.value[sure] < 0, (4, np.sum(sure))))
    assert np.any(inside[:, ~sure] != inside[0, ~sure])


def test_heights_of_unions_are_the_least_of_their_parts():
    parts = [Sphere([i, 0, 0], 0.7) for i in range(5)]
    points = np.random.default_rng(3).uniform(-2, 6, (500, 3))
    least = np.min([norm(points - part.center) - part.radius for part in parts], axis=0)
    found = heights(Composite(parts), points)
    assert found == pytest.approx(least, abs=1e-14)
    within = heights(Composite(parts), points, 0.5)
    near = least <= 0.5
    assert np.array_equal(within[near], found[near])
    assert np.all(within[~near] > 0.5)


# ------------------------------------------------------------------------------------------- surfaces


@pytest.mark.parametrize("shape", SOLIDS, ids=lambda shape: type(shape).__name__)
def test_samples_are_on_the_surface_and_normals_look_out(shape: Proxy):
    found = surface_samples(shape, 500)
    assert found.points.shape == (500, 3)
    assert heights(shape, found.points) == pytest.approx(0, abs=1e-12)
    assert norm(found.normals) == pytest.approx(1, abs=1e-12)
    assert heights(shape, found.points + 1e-4 * found.normals) == pytest.approx(1e-4, rel=1e-6)


@pytest.mark.parametrize("shape", SOLIDS, ids=lambda shape: type(shape).__name__)
def test_samples_are_even(shape: Proxy):
    """The divergence theorem: the mean of (x − c)·n over the surface, times its area, is three times the volume."""
    found = surface_samples(shape, 4000)
    away = found.points - np.mean(found.points, axis=0)
    flux = found.area * np.mean(np.sum(away * found.normals, axis=1))
    assert flux == pytest.approx(3 * proxy_volume(shape).value, rel=0.01)
    assert np.mean(found.normals, axis=0) == pytest.approx(0, abs=0.01)  # a closed surface has no outward side


def test_area_of_an_ellipsoid():
    """Legendre's formula, by incomplete elliptic integrals."""
    a, b, c = 3.0, 1.0, 0.5
    angle = mpmath.acos(c / a)
    m = (a * a * (b * b - c * c)) / (b * b * (a * a - c * c))
    sine, cosine = mpmath.sin(angle), mpmath.cos(angle)
    both = mpmath.ellipe(angle, m) * sine**2 + mpmath.ellipf(angle, m) * cosine**2
    truth = 2 * mpmath.pi * (c * c + a * b * both / sine)
    assert surface_samples(Ellipsoid([1, 0, 0], [a, b, c], TURN), 10).area == pytest.approx(float(truth), rel=1e-5)


def test_what_another_part_covers_is_no_surface():
    found = surface_samples(TWO, 8000)
    assert found.area == pytest.approx(2 * (4 * math.pi - 2 * math.pi * 0.5), rel=0.005)  # caps of height 1/2 are gone
    assert np.all(np.sign(found.points[:, 0]) * 0.5 * found.points[:, 0] > 0)
    halves = Composite([AABB([0, 0, 0], [1, 1, 1]), AABB([1, 0, 0], [2, 1, 1]), AABB([0, 0, 0], [2, 1, 1])])
    assert surface_samples(halves, 20_000).area == pytest.approx(10, rel=0.01)


def test_distances_of_nested_cubes():
    a = 0.25
    found = surface_distance(AABB([-0.5 - a] * 3, [0.5 + a] * 3), CUBE, points=20_000)
    strip = mpmath.quad(lambda t: mpmath.sqrt(a * a + t * t), [0, a]) / a
    corner = mpmath.quad(lambda u, v: mpmath.sqrt(a * a + u * u + v * v), [0, a], [0, a]) / a**2
    mean = (a + 4 * a * strip + 4 * a * a * corner) / (1 + 2 * a) ** 2
    assert found.of_mesh.mean == pytest.approx(a, rel=1e-12)
    assert found.of_mesh.largest == pytest.approx(a, rel=1e-12)
    assert found.of_mesh.over == 0
    assert found.of_proxy.mean == pytest.approx(float(mean), rel=0.002)
    assert found.of_proxy.over == found.of_proxy.mean
    assert found.of_proxy.largest == found.hausdorff == pytest.approx(a * math.sqrt(3), rel=0.05)
    assert found.hausdorff <= a * math.sqrt(3)
    assert found.mean == pytest.approx((a + float(mean)) / 2, rel=0.002)


@pytest.mark.parametrize(("radius", "away"), [(1.2, 0.0), (0.9, 0.4), (1.5, 0.7)])
def test_distances_of_balls(radius: float, away: float):
    """The distance s from the centre has the density s/(2rd) on a sphere of radius r, d beside it."""
    mesh = trimesh.creation.icosphere(subdivisions=4)
    found = surface_distance(Sphere([away, 0, 0], radius), Polyhedron(mesh.vertices, mesh.faces))
    flat = 0.003  # the mesh is so much smaller than a ball

    def mean(r: float, other: float) -> float:
        if away == 0:
            return abs(r - other)
        ends = sorted({abs(r - away), min(max(other, abs(r - away)), r + away), r + away})
        return float(mpmath.quad(lambda s: abs(s - other) * s / (2 * r * away), ends))

    assert found.of_proxy.mean == pytest.approx(mean(radius, 1.0), abs=flat)
    assert found.of_mesh.mean == pytest.approx(mean(1.0, radius), abs=flat)
    assert found.hausdorff == pytest.approx(abs(radius - 1) + away, abs=0.01)


def test_the_way_out_of_a_union_may_lead_to_where_parts_meet():
    tiny = Polyhedron(*box((-1e-3, -1e-3, -1e-3), (1e-3, 1e-3, 1e-3)))
    found = surface_distance(TWO, tiny, points=2000)
    assert found.of_mesh.mean == pytest.approx(math.sqrt(0.75), abs=0.01)  # not ½, where it would still be inside
    assert found.of_mesh.mean > math.sqrt(0.75) - 0.002


def test_a_union_of_touching_boxes_is_measured_as_the_one_box_it_is():
    whole = surface_distance(AABB([-0.6] * 3, [0.6] * 3), CUBE)
    halves = Composite([AABB([-0.6] * 3, [0, 0.6, 0.6]), AABB([0, -0.6, -0.6], [0.6] * 3)])
    found = surface_distance(halves, CUBE)
    assert whole.of_mesh.mean <= found.of_mesh.mean < 1.01 * whole.of_mesh.mean
    assert found.of_proxy.mean == pytest.approx(whole.of_proxy.mean, rel=0.01)


@pytest.mark.parametrize("measure", [volume_overlap, surface_distance])
def test_what_cannot_be_measured_is_refused(measure):
    batch = Sphere(np.zeros((2, 3)), 1.0)
    with pytest.raises(ShapeError, match="single"):
        measure(batch, CUBE)
    for endless in (HalfSpace([0, 0, 1], 0.0), Point([0, 0, 0])):
        with pytest.raises(UnsupportedOperation, match=type(endless).__name__):
            measure(endless, CUBE)
    with pytest.raises(ShapeError, match="no surface area"):
        surface_distance(Capsule([0, 0, 0], [1, 0, 0], 0.0), CUBE)
