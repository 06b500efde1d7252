"""Colliders fitted to meshes: inside where they claim to be (exactly), near where it can be known, good elsewhere."""

from __future__ import annotations

import math
import sys
from fractions import Fraction
from functools import partial
from itertools import combinations

import numpy as np
import pytest
import trimesh
from scipy.cluster.vq import kmeans2

from refimpl import from_trimesh
from refimpl.construct import (
    ConstructionError,
    decomposed,
    fitted_boxes,
    fitted_capsules,
    fitted_spheres,
    medial_spheres,
    packed_spheres,
)
from refimpl.construct.adjusting import loss_of, target_of
from refimpl.construct.measures import surface_distance, volume_overlap
from refimpl.construct.medial import covering, inscribed_radii
from refimpl.construct.parts import split
from refimpl.construct.primitives import BOXES, CAPSULES, SPHERES, Family
from refimpl.linear import Array, norm
from refimpl.loading import LoadError
from refimpl.mass import mass_properties
from refimpl.meshes import MeshError
from refimpl.queries import distance
from refimpl.shapes import Box, Capsule, Composite, ConvexPolyhedron, Point, Polyhedron, Proxy, Sphere
from tests.solids import L_SHAPE, U_SHAPE, box, prism, torus

TURN = (0.1, 0.5, -0.3, 0.7)
DETAIL = 1500
L_PRISM = Polyhedron(*prism(L_SHAPE))
TORUS = Polyhedron(*torus(around=16, across=10))
NEEDLE = Polyhedron(*box((0, 0, 0), (100, 1, 1)))
PLATE = Polyhedron(*box((0, 0, 0), (10, 10, 0.5)))
TETRAHEDRON = Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
FITS = [fitted_spheres, fitted_capsules, fitted_boxes]


def iou(proxy: Proxy, mesh: Polyhedron) -> float:
    return volume_overlap(proxy, mesh, boxes=8192).iou


def spheres(found: Composite) -> list[Sphere]:
    assert all(isinstance(part, Sphere) for part in found.parts)
    return list(found.parts)  # type: ignore[arg-type]


def exactly(v: Array) -> list[Fraction]:
    return [Fraction(float(x)) for x in v]


def is_within_l_prism(ball: Sphere) -> bool:
    """In fractions: the centre is inside, and no wall is nearer than the radius."""
    x, y, z = exactly(ball.center)
    r = Fraction(float(ball.radius))
    inside = 0 < z < 1 and 0 < x < 2 and 0 < y < 2 and (x < 1 or y < 1)
    gaps = [z, 1 - z]
    squares = []
    for (a, b), (c, d) in zip(L_SHAPE, L_SHAPE[1:] + L_SHAPE[:1], strict=True):
        u, v = Fraction(c - a), Fraction(d - b)
        t = min(max(((x - a) * u + (y - b) * v) / (u * u + v * v), Fraction(0)), Fraction(1))
        squares.append((a + t * u - x) ** 2 + (b + t * v - y) ** 2)
    return inside and min(gaps) >= r and min(squares) >= r * r


@pytest.mark.parametrize("fit", [partial(medial_spheres, detail=DETAIL), packed_spheres], ids=["medial", "packed"])
def test_spheres_inside_are_inside_exactly(fit):
    found = spheres(fit(L_PRISM, 12))
    assert len(found) == 12
    assert all(is_within_l_prism(ball) for ball in found)
    assert not is_within_l_prism(Sphere(found[0].center, found[0].radius * (1 + 1e-9)))  # the first one touches


def test_packed_spheres_have_no_point_in_common_exactly():
    found = spheres(packed_spheres(TORUS, 16))
    for a, b in combinations(found, 2):
        between = sum((x - y) ** 2 for x, y in zip(exactly(a.center), exactly(b.center), strict=True))
        assert between >= (Fraction(float(a.radius)) + Fraction(float(b.radius))) ** 2
    whole = mass_properties(packed_spheres(TORUS, 16)).volume  # refuses parts that overlap
    assert whole == pytest.approx(sum(4 / 3 * math.pi * float(s.radius) ** 3 for s in found), rel=1e-12)


def test_the_first_packed_sphere_is_the_largest():
    assert float(spheres(packed_spheres(Polyhedron(*box((0, 0, 0), (1, 2, 3))), 1))[0].radius) > 0.499
    side = math.sqrt(3) / 2
    inscribed = 1 / (3 + 2 * side)  # 3 V / surface, of the tetrahedron of the axes
    assert float(spheres(packed_spheres(TETRAHEDRON, 1))[0].radius) == pytest.approx(inscribed, rel=0.01)


def test_medial_spheres_touch_the_surface_twice():
    """A torus of n-gons: its medial axis is the ring, whose balls touch all around the tube."""
    for ball in spheres(medial_spheres(TORUS, 8, detail=DETAIL)):
        x, y, z = ball.center.tolist()
        assert math.hypot(math.hypot(x, y) - 1, z) < 0.06
        assert float(ball.radius) == pytest.approx(0.4, rel=0.12)


def test_covering_is_no_worse_than_it_must_be():
    """Against the best of all choices of three of nine balls."""
    random = np.random.default_rng(5)
    center, radius = random.uniform(0, 1, (9, 3)), random.uniform(0.2, 0.4, 9)
    points, weight = random.uniform(0, 1, (400, 3)), random.uniform(1, 2, 400)
    inside = norm(points[:, None] - center) <= radius

    def covered(chosen: list[int]) -> float:
        return float(weight @ np.any(inside[:, chosen], axis=1))

    best = max(covered(list(chosen)) for chosen in combinations(range(9), 3))
    found = covering(center, radius, points, weight, 3)
    assert (1 - 1 / math.e) * best <= covered(found) <= best
    assert found[0] == np.argmax(weight @ inside)


# ------------------------------------------------------------------------------------------- the best fit


@pytest.mark.parametrize(("family", "width"), [(SPHERES, 4), (CAPSULES, 7), (BOXES, 10)], ids=["4", "7", "10"])
def test_derivatives_against_differences(family: Family, width: int):
    target = target_of(L_PRISM.solid, 400)
    random = np.random.default_rng(width)
    rows = random.uniform(-0.3, 0.3, (3, width))
    rows[:, family.lengths] = random.uniform(0.2, 0.4, rows[:, family.lengths].shape)
    _, slopes = loss_of(family, rows, target, 4.0)
    step = 1e-6
    for at in np.ndindex(*rows.shape):
        shift = np.zeros_like(rows)
        shift[at] = step
        after, before = (loss_of(family, rows + s * shift, target, 4.0)[0] for s in (1, -1))
        assert slopes[at] == pytest.approx((after - before) / (2 * step), abs=2e-5)
    assert np.max(np.abs(slopes)) > 0.05


@pytest.mark.parametrize("family", [SPHERES, CAPSULES, BOXES], ids=["spheres", "capsules", "boxes"])
def test_heights_are_the_references(family: Family):
    random = np.random.default_rng(8)
    points = random.uniform(-1, 1, (200, 3))
    row = family.ball(np.array([0.1, 0.2, -0.1]), 0.7)
    row[-4:] += random.uniform(0, 0.2, 4)
    found = family.heights(row[None], points)[:, 0]
    assert found == pytest.approx(distance(Point(points), family.proxy(row)).distance, abs=1e-12)


def test_a_ball_is_fitted_by_a_sphere():
    mesh = from_trimesh(trimesh.creation.icosphere(subdivisions=3, radius=2.0))
    (found,) = spheres(fitted_spheres(mesh.translated([5, 0, 0]), 1, detail=DETAIL))
    truth = (float(mass_properties(mesh).volume) * 0.75 / math.pi) ** (1 / 3)
    assert float(found.radius) == pytest.approx(truth, rel=0.01)
    assert found.center == pytest.approx([5, 0, 0], abs=0.02)


def test_a_capsule_is_fitted_by_a_capsule():
    mesh = from_trimesh(trimesh.creation.capsule(height=3.0, radius=0.5, count=[16, 16])).rotated(TURN)
    found = fitted_capsules(mesh, 1, detail=DETAIL)
    (capsule,) = found.parts
    assert isinstance(capsule, Capsule)
    assert norm(capsule.q - capsule.p) == pytest.approx(3, rel=0.03)
    assert float(capsule.radius) == pytest.approx(0.5, rel=0.03)
    assert iou(found, mesh) > 0.95


@pytest.mark.parametrize("half", [(0.5, 0.5, 0.5), (2.0, 0.3, 0.7)])
def test_a_box_is_fitted_by_a_box(half):
    mesh = Polyhedron(*box([-x for x in half], half)).rotated(TURN).translated([1, 2, 3])
    found = fitted_boxes(mesh, 1, detail=DETAIL)
    (part,) = found.parts
    assert isinstance(part, Box)
    assert sorted(part.half_extents) == pytest.approx(sorted(half), rel=1e-4)
    assert part.center == pytest.approx([1, 2, 3], abs=1e-4)
    assert surface_distance(found, mesh).hausdorff < 1e-3


def test_two_boxes_make_an_l_and_three_a_u():
    assert iou(fitted_boxes(L_PRISM, 2, detail=600), L_PRISM) > 0.99
    u_prism = Polyhedron(*prism(U_SHAPE))
    assert iou(fitted_boxes(u_prism, 3, detail=600), u_prism) > 0.99
    assert iou(fitted_boxes(u_prism, 1, detail=600), u_prism) < 0.9


def test_spheres_fit_better_than_simple_ways():
    """Bounding sphere; centres by k-means of interior points, with the largest balls inside; medial balls."""
    count = 12
    random = np.random.default_rng(2)
    points = random.uniform(-1.4, 1.4, (4000, 3)) * [1, 1, 0.4]
    points = points[inscribed_radii(TORUS.solid, points) > 0]
    centers, _ = kmeans2(points, count, minit="++", seed=2)
    simple = Composite([Sphere(c, r) for c, r in zip(centers, inscribed_radii(TORUS.solid, centers), strict=True)])
    around = Sphere([0, 0, 0], float(np.max(norm(TORUS.vertices))))
    medial, fitted = medial_spheres(TORUS, count, detail=DETAIL), fitted_spheres(TORUS, count, detail=DETAIL)
    found = [iou(proxy, TORUS) for proxy in (around, simple, medial, fitted)]
    assert found == sorted(found)
    assert found[0] < 0.35
    assert found[3] > 0.8
    assert surface_distance(fitted, TORUS).mean < 0.7 * surface_distance(medial, TORUS).mean


@pytest.mark.parametrize("fit", FITS)
def test_more_parts_fit_better(fit):
    few, more = (iou(fit(TORUS, count, detail=800), TORUS) for count in (2, 5))
    assert few + 0.1 < more


@pytest.mark.parametrize("mesh", [NEEDLE, PLATE, TETRAHEDRON], ids=["needle", "plate", "tetrahedron"])
def test_extreme_meshes_are_fitted(mesh: Polyhedron):
    assert iou(fitted_boxes(mesh, 1, detail=600), mesh) > (0.45 if mesh is TETRAHEDRON else 0.99)
    assert iou(fitted_capsules(mesh, 2, detail=600), mesh) > (0.1 if mesh is PLATE else 0.5)
    assert all(float(ball.radius) > 0 for ball in spheres(medial_spheres(mesh, 20, detail=600)))
    assert len(packed_spheres(mesh, 20).parts) == 20


def test_parts_are_split_where_they_are_apart():
    random = np.random.default_rng(4)
    places = np.array([[0, 0, 0], [5, 0, 0], [5, 5, 0]])
    points = np.concatenate([place + random.uniform(-1, 1, (50, 3)) for place in places])
    found = split(points, np.ones(150), 3)
    middles = sorted(np.round(np.mean(some, axis=0)).tolist() for some, _ in found)
    assert middles == sorted(places.astype(float).tolist())
    assert sum(len(some) for some, _ in split(points, np.ones(150), 40)) == 150


# ------------------------------------------------------------------------------------------- the same everywhere


@pytest.mark.parametrize("fit", [medial_spheres, packed_spheres, fitted_spheres, fitted_capsules, fitted_boxes])
def test_a_seed_decides_and_units_do_not(fit, monkeypatch):
    """How far the search goes makes no difference to that; here not far."""
    monkeypatch.setattr("refimpl.construct.fitting.ROUNDS", 10)
    monkeypatch.setattr("refimpl.construct.relocating.ROUNDS", 5)
    monkeypatch.setattr("refimpl.construct.relocating.MOVES", 1)
    options = {} if fit is packed_spheres else {"detail": 200}
    made = fit(TORUS, 3, seed=4, **options)
    first = made.pack()
    assert np.array_equal(first, fit(TORUS, 3, seed=4, **options).pack())
    other = fit(TORUS.times_power(-300), 3, seed=4, **options).times_power(300)
    assert np.array_equal(first, other.pack())
    moved = fit(TORUS.rotated(TURN).translated([1, 2, 3]), 3, seed=4, **options)
    assert np.array_equal(moved.pack(), made.rotated(TURN).translated([1, 2, 3]).pack())


def test_meshes_come_from_files_and_trimesh_objects(tmp_path):
    path = tmp_path / "model.obj"
    mesh = trimesh.Trimesh(*box(), process=False)
    mesh.export(path)
    wanted = medial_spheres(Polyhedron(*box()), 2).pack()
    for source in (str(path), path, mesh):
        assert medial_spheres(source, 2).pack() == pytest.approx(wanted, abs=0.2)


def test_what_no_collider_can_be_made_of_is_refused(tmp_path):
    vertices, triangles = box()
    with pytest.raises(MeshError, match="open"):
        fitted_boxes(Polyhedron(vertices, triangles[1:]), 2)
    with pytest.raises(LoadError, match="open"):
        fitted_boxes(trimesh.Trimesh(vertices, triangles[1:], process=False), 2)
    with pytest.raises(LoadError, match="cannot be read"):
        fitted_boxes(tmp_path / "none.obj", 2)
    for source in (vertices, Sphere([0, 0, 0], 1.0), 5, None):
        with pytest.raises(ConstructionError, match="mesh: expected a Polyhedron"):
            medial_spheres(source, 2)
    with pytest.raises(ConstructionError, match="single Polyhedron"):
        medial_spheres(L_PRISM.translated(np.zeros((2, 3))), 2)
    with pytest.raises(ConstructionError, match="no ball fits"):
        medial_spheres(Polyhedron(*box((0, 0, 0), (1, 1, 2.0**-48))), 2)
    for count in (0, 257, 2.0, True, "2"):
        with pytest.raises(ConstructionError, match="count: expected a whole number"):
            packed_spheres(L_PRISM, count)


# ------------------------------------------------------------------------------------------- convex decomposition


def test_a_u_is_decomposed_into_its_boxes():
    pytest.importorskip("coacd")
    mesh = Polyhedron(*prism(U_SHAPE)).translated([0, 0, 4])
    found = decomposed(mesh, seed=1)
    assert all(isinstance(part, ConvexPolyhedron) and part.given == "vertices" for part in found.parts)
    assert len(found.parts) == 3
    measured = volume_overlap(found, mesh)
    assert measured.iou > 0.95
    assert surface_distance(found, mesh).hausdorff < 0.06
    assert np.array_equal(found.pack(), decomposed(mesh, seed=1).pack())
    assert len(decomposed(mesh, 1).parts) == 1


def test_decomposition_names_what_it_needs(monkeypatch):
    for threshold in (0.0, 1.5, float("nan")):
        with pytest.raises(ConstructionError, match=r"threshold: expected 0\.01 to 1"):
            decomposed(L_PRISM, threshold=threshold)
    monkeypatch.setitem(sys.modules, "coacd", None)
    with pytest.raises(ConstructionError, match=r"proxyproof\[decompose\]"):
        decomposed(L_PRISM)
