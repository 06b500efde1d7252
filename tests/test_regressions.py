"""Scenes on which an earlier version of the reference was wrong, found by attacking it; each with what went wrong."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import refimpl
from refimpl import (
    AABB,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    HalfSpace,
    Point,
    Polyhedron,
    Ray,
    ShapeError,
    Sphere,
    UnsupportedOperation,
    certify,
)
from refimpl.linear import norm
from refimpl.proof import check
from tests import truth

ACCURACY = 1e-14

PAIRS = {
    "normal of a capsule along a box's face, 1e-8 off parallel": (
        Capsule([1.000000017, 1.000000019, 0], [1, 0.999999997, 2], 1),
        AABB([-1] * 3, [1] * 3),
    ),
    "normal between box edges 1e-8 off parallel": (
        AABB([-1] * 3, [1] * 3),
        Box([1.5, 2.000000008, 2.000000009], [1, 1, 1], [0, 0, -1e-8, 1]),
    ),
    "corner of one box in the other's tilted frame": (
        Box([1.0634403235587886, -1.890264633165657, -0.06145171816195516],
            [0.44594880101975987, 0.36778358383334536, 0.76800400955393], [0, 0, 0, 1]),
        Box([0.12031546223274259, -0.7870429785141738, -0.6704109427010243],
            [0.4971760528272826, 0.7354380703090866, 0.7155226292295893], [0, 5e-9, 0, 1]),
    ),
    "witnesses of capsules 1e-9 off parallel": (
        Capsule([2, -2, 1], [-1, 1, 1], 0),
        Capsule([-6.000000000000001e-09, -4e-09, -0.999999991], [0, -3, -1], 1),
    ),
    "plane whose normal is the smallest double": (Point([1e4, 0, 0]), HalfSpace([5e-324, 0, 0], 1e-320)),
    "plane whose normal is near the largest double": (Point([0.1, 0, 0]), HalfSpace([1.7e308] * 3, 1e308)),
    "ball beside a denormal plane": (
        Sphere([-1, 0, 2.5e-323], 0.7442150811045276),
        HalfSpace([2.5e-323, 0, 0], 2.5e-323),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PAIRS)
def test_pairs_keep_the_contract(name: str) -> None:
    a, b = PAIRS[name]
    found = refimpl.distance(a, b)
    size = truth.scene_scale(a, b)
    assert abs(truth.signed_distance(a, b) - float(found.distance)) <= ACCURACY * size
    assert np.abs(found.on_b - found.on_a - found.distance * found.normal).max() <= ACCURACY * size
    if not isinstance(b, HalfSpace):
        moved = b.translated(-found.distance * found.normal)
        assert abs(truth.signed_distance(a, moved)) <= ACCURACY * size
    data = refimpl.collide(a, b)
    if data.hit and not isinstance(b, HalfSpace):
        assert abs(truth.signed_distance(a.translated(data.shift_a), b.translated(data.shift_b))) <= 2 * ACCURACY * size


RAYS = {
    "entry just past the seam of a capsule": (
        Ray([1.0000000384, 0, -3.9999999851], [-9.6e-9, 0, 1]),
        Capsule([0, 0, 0], [0, 0, 4], 1),
    ),
    "the same, slanted": (
        Ray([-2.416387569994818, -3.9377093153703138, 0.25596192758484543],
            [0.599999984812985, 0.8000000113902612, -1.1313029815963719e-08]),
        Capsule([0, 0, 0], [3, 4, 0], 0.5),
    ),
    "from far away along the axis": (
        Ray([-19724751.24024281, 8783280.13507349, -8427383.762404885],
            [0.8510015584200482, -0.3789444074610917, 0.3635897188049739]),
        Capsule([0, 0, 0], [6898633.220821453, -3071905.707377399, 2947435.4971120297], 1),
    ),
    "inside the line's cylinder but past its end": (
        Ray([-0.10741173, -0.5160253, -0.41625113], [-0.10957025, -0.15944354, -0.22250441]),
        Capsule([0.47132456, 0.50192628, -0.0816179], [0.25092976, -0.51353447, -0.0937143], 0.47841914),
    ),
    "parallel to the axis outside": (Ray([2, 0, 0.5], [0, 0, -0.25]), Capsule([-2, -1.5, 0.5], [-2, -1.5, -2.5], 1)),
}  # fmt: skip


@pytest.mark.parametrize("name", RAYS)
def test_rays_enter_where_they_truly_do(name: str) -> None:
    ray, solid = RAYS[name]
    found, span = refimpl.raycast(ray, solid), truth.ray_interval(ray, solid)
    assert bool(found.hit) == bool(refimpl.intersect(ray, solid)) == (span is not None)
    if span is None:
        return
    size = max(float(ray.magnitude), float(solid.magnitude))
    assert abs(truth.signed_distance(Point(found.point), solid)) <= 2 * ACCURACY * size
    assert abs(truth.signed_distance(Capsule(ray.origin, found.point, 0), solid)) <= 2 * ACCURACY * size


def test_normals_of_rays_face_the_ray() -> None:
    far = Ray([-3300000, 100000, 600000], [3.3, -0.1, -0.6])
    assert refimpl.raycast(far, Sphere([0, 0, 1e-10], 1e-9)).normal @ far.direction < 0
    thin = Ray([-1.97, 3.8899999999999997, 3.32], [0.89, -0.83, -0.64])
    for radius in (1e-12, 1e-9, 0.0):
        found = refimpl.raycast(thin, Capsule([0, 0, 0], [1, 2, 2], radius))
        if found.hit:
            assert abs(found.normal @ [1, 2, 2]) < 1e-14


def test_directions_of_any_length_hit_or_miss_alike() -> None:
    for ray, ball in (
        (Ray([-5, 0, 0], [1e-310, 0, 0]), Sphere([0, 0, 0], 1)),
        (Ray([-1e300, 0, 0], [1e-300, 0, 0]), Sphere([0, 0, 0], 1e299)),
        (Ray([-2e-16, 0, 0], [1e308, 0, 0]), Sphere([0, 0, 0], 1e-16)),
    ):
        found = refimpl.raycast(ray, ball)
        assert found.hit
        assert refimpl.intersect(ray, ball)
        assert norm(found.point - ball.center) == pytest.approx(float(ball.radius))


def test_there_is_one_zero() -> None:
    boxes = AABB([0.0, 0, 0], [0.0, 1, 1]), AABB([-0.0, 0, 0], [-0.0, 1, 1])
    there, back = refimpl.distance(*boxes).distance, refimpl.distance(*boxes[::-1]).distance
    assert there.tobytes() == back.tobytes()


def test_points_on_a_face_touch() -> None:
    rng = np.random.default_rng(5)
    lower = rng.uniform(-3, 0, (2000, 3))
    upper = lower + rng.uniform(0.1, 3, (2000, 3))
    on_face = lower + (upper - lower) * rng.uniform(0, 1, (2000, 3))
    on_face[:, 1] = upper[:, 1]
    on_face = np.clip(on_face, lower, upper)
    boxes, points = AABB(lower, upper), Point(on_face)
    assert refimpl.intersect(points, boxes).all()
    assert refimpl.collide(points, boxes).hit.all()
    assert np.all(refimpl.distance(points, boxes).distance == 0)
    outside = on_face.copy()
    outside[:, 1] = np.nextafter(upper[:, 1], np.inf)
    assert not refimpl.collide(Point(outside), boxes).hit.any()


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: Sphere([1e-300, 0, 0], 1e-300).scaled(1e-300), ShapeError),
        (lambda: Sphere([0, 0, 0], 1).scaled([1, 2, 3]), UnsupportedOperation),
    ],
)
def test_what_scaling_cannot_give_is_refused(call, error) -> None:
    with pytest.raises(error):
        call()


def test_masses_of_any_size_and_number() -> None:
    a, b = Sphere([0, 0, 0], 1), Sphere([1, 0, 0], 1)
    heavy = refimpl.collide(a, b, 1.7e308, 1.7e308)
    assert np.allclose(heavy.shift_a, [-0.5, 0, 0])
    assert np.allclose(heavy.shift_b, [0.5, 0, 0])
    many = refimpl.collide(a, b, [1, 2, 3], 1)
    assert many[0].hit
    assert many.depth.shape == many.hit.shape == (3,)
    with np.errstate(all="raise"):
        assert not refimpl.intersect(Point([0, 0, 1]), Sphere([0, 0, 0], 1e-200))


@pytest.mark.parametrize("scene", json.loads(Path(__file__).with_name("thin_pieces.json").read_text("utf-8")))
def test_pieces_too_thin_to_be_proven_to_lie_inside_their_mesh_are_left_out(scene: dict[str, Any]) -> None:
    kind = {"Box": Box, "AABB": AABB}[scene["type"]]
    a, b = kind.unpack(np.array(scene["a"])), Polyhedron.unpack(np.array(scene["b"]))
    lower, upper = check(certify(a, b), a, b)
    assert lower <= refimpl.distance(a, b).distance + 1e-12
    assert upper < 0


def test_a_ray_creeps_across_the_axis_of_a_capsule() -> None:
    """The square of its speed across is no double any more."""
    capsule = refimpl.Capsule([0, 0, 0], [0, 0, 1], 0.5)
    for slow in (1e-140, 1e-156, 1e-170, 5e-324):
        assert refimpl.raycast(Ray([1, 0, 0.25], [-slow, 0, 0]), capsule).t == pytest.approx(0.5 / slow, rel=1e-14)
        assert refimpl.raycast(Ray([0.25, 0, -2], [-slow, 0, 1]), capsule).hit
        assert not refimpl.raycast(Ray([1, 0, 0.25], [-slow, 0, 1]), capsule).hit


def test_rays_pass_a_wedge_thinner_than_rounding() -> None:
    """Two planes of which one is tilted by 1e-72 hold nothing beyond their edge; the hit was taken for one there."""
    sides = [[0, 1, 0, -1], [0, -1, 0, -1], [0, 0, 1, -1], [0, 0, -1, -1]]
    wedge = ConvexPolyhedron([[1, 0, 0, 0], [-1, 1e-72, 0, 0], *sides])
    y = np.array([-1.5, -1.0, -0.014, 0.0, 0.014, 0.5])
    found = refimpl.raycast(Ray(np.stack([np.ones(6), y, np.zeros(6)], axis=-1), [-1.0, 0, 0]), wedge)
    assert found.hit.tolist() == [False, True, True, True, False, False]
    assert found.t[1:4].tolist() == [1, 1, 1]


def test_the_witness_of_a_way_out_that_every_pair_has_to_be_answered_for() -> None:
    """The two points were those of the deepest piece, though the way out is another one: B's was 0.5 off it."""
    ball = Sphere([-1.0, 1.5, 2.0], 0.5)
    half, radius = [0.6385525931404099, 0.37530524523891073, 0.3971421237984042], 0.6385525931404099
    planes = [[*(sign * np.eye(3)[axis]), -half[axis]] for sign in (1.0, -1.0) for axis in range(3)]
    place = [-1.2012822570464663, 1.1802479201010172, 2.2215954110189435]
    p, q = (
        [-1.2293676360219683, 1.648038502986405, 2.396430479551473],
        [-1.3161629632078746, 2.392735803601931, 2.134171127735243],
    )
    union = Composite([ConvexPolyhedron(planes, position=place, rotation=[0, 0, 1, 0]), Cylinder(p, q, radius)])
    found = refimpl.distance(ball, union)
    assert found.distance == pytest.approx(-0.687, abs=1e-3)
    for point, shape in ((found.on_a, ball), (found.on_b, union)):
        assert truth.signed_distance(Point(point), shape) <= 1e-12
    np.testing.assert_allclose(found.on_b - found.on_a, found.distance * found.normal, atol=1e-15)
