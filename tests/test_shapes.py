"""The proxies as data: meaning, validation, batches, isometries."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest

import refimpl
from refimpl import AABB, Box, Capsule, HalfSpace, Point, Ray, ShapeError, Sphere, UnsupportedOperation
from refimpl.shapes import Proxy

NAN, INF = math.nan, math.inf
EXAMPLES: list[Proxy] = [
    Point([1.0, -2.0, 0.5]),
    Ray([1.0, 2.0, 3.0], [0.0, -2.0, 0.5]),
    Sphere([1.0, 2.0, 3.0], 0.5),
    Capsule([0.0, 0.0, 0.0], [1.0, 2.0, 0.0], 0.25),
    HalfSpace([0.0, 3.0, 4.0], -10.0),
    AABB([-1.0, 0.0, 2.0], [1.0, 0.0, 3.0]),
    Box([1.0, 2.0, 3.0], [0.5, 1.0, 0.0], [0.0, 0.0, 3.0, 4.0]),
]
SOLIDS = [s for s in EXAMPLES if s.is_solid]


def kind(shape):
    return type(shape).__name__


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: Point([0, 0]), "Point.position: expected 3 numbers, got an array of shape (2,)"),
        (lambda: Point([0, NAN, 0]), "Point.position must be finite, got nan at index (1,)"),
        (lambda: Point("abc"), "Point.position: not an array of real numbers: 'abc'"),
        (lambda: Point([1j, 0, 0]), "Point.position: not an array of real numbers"),
        (lambda: Point([10**400, 0, 0]), "Point.position: not an array of real numbers"),
        (lambda: Point(None), "Point.position"),
        (lambda: Ray([0, 0, 0], [0, 0, 0]), "Ray.direction must not be zero"),
        (lambda: Sphere([0, 0, 0], 0), "Sphere.radius must be greater than 0, got 0.0"),
        (lambda: Sphere([0, 0, 0], -1), "Sphere.radius must be greater than 0, got -1.0"),
        (lambda: Sphere([0, 0, 0], [1, 2, -3]), "got -3.0 at index (2,)"),
        (
            lambda: Sphere([[0, 0, 0]] * 2, [1, 1, 1]),
            "Sphere: batch shapes do not broadcast: center (2,), radius (3,)",
        ),
        (lambda: Capsule([0, 0, 0], [1, 0, INF], 1), "Capsule.q must be finite, got inf"),
        (lambda: Capsule([0, 0, 0], [1, 0, 0], -1), "Capsule.radius must be at least 0"),
        (lambda: HalfSpace([0, 0, 0], 1), "HalfSpace.normal must not be zero"),
        (lambda: HalfSpace([1e-300, 0, 0], 1e300), "HalfSpace.k puts the plane beyond the largest float"),
        (
            lambda: AABB([0, 0, 0], [1, -1, 1]),
            "AABB.upper must not be below AABB.lower, got -1.0 at index (1,)",
        ),
        (lambda: Box([0, 0, 0], [1, -1, 1], [0, 0, 0, 1]), "Box.half_extents must be at least 0, got -1.0"),
        (lambda: Box([0, 0, 0], [1, 1, 1], [0, 0, 0, 0]), "Box.rotation must not be zero"),
        (lambda: Box([0, 0, 0], [1, 1, 1], [0, 0, 1]), "Box.rotation: expected 4 numbers"),
    ],
)
def test_bad_numbers_are_refused_by_name_and_value(build, words):
    with pytest.raises(ShapeError) as caught:
        build()
    assert words in str(caught.value)


@pytest.mark.parametrize("shape", EXAMPLES, ids=kind)
def test_a_proxy_is_immutable_and_does_not_share_its_input(shape):
    name = fields(shape)[0].name
    with pytest.raises(AttributeError):
        setattr(shape, name, 0)
    assert not getattr(shape, name).flags.writeable
    mine = np.array([1.0, 2.0, 3.0])
    point = Point(mine)
    mine[:] = 9
    assert point.position.tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("shape", EXAMPLES, ids=kind)
def test_packing_and_repr_lose_nothing(shape):
    again = type(shape).unpack(shape.pack())
    assert np.array_equal(again.pack(), shape.pack())
    assert shape.pack().shape == (type(shape).width(),)
    rebuilt = eval(repr(shape), vars(refimpl))
    assert np.array_equal(rebuilt.pack(), shape.pack())


def test_batches_broadcast_and_index():
    spheres = Sphere(np.arange(12.0).reshape(2, 2, 3), 0.5)
    assert spheres.batch_shape == (2, 2)
    assert spheres.radius.shape == (2, 2)
    assert spheres[1].batch_shape == (2,)
    assert spheres[1, 0].center.tolist() == [6.0, 7.0, 8.0]
    assert len(spheres) == 2
    with pytest.raises(TypeError, match="a single Sphere has no length"):
        len(spheres[0, 0])
    assert refimpl.distance(spheres, Point([0, 0, 0])).distance.shape == (2, 2)
    assert refimpl.distance(Sphere(np.zeros((4, 1, 3)), 1.0), Point(np.ones((5, 3)))).normal.shape == (
        4,
        5,
        3,
    )
    with pytest.raises(ShapeError, match="do not broadcast"):
        refimpl.distance(Sphere(np.zeros((4, 3)), 1.0), Point(np.ones((5, 3))))
    empty = refimpl.distance(Sphere(np.zeros((0, 3)), 1.0), Point([0, 0, 0]))
    assert empty.distance.shape == (0,)


MOVES = {
    "turned": lambda s: s.rotated([0.1, 0.2, -0.3, 0.9]),
    "moved": lambda s: s.translated([0.5, -1.0, 2.0]),
    "transformed": lambda s: s.transformed([1.0, 0.0, 0.0, 2.0], [3.0, 0.0, 1.0]),
    "scaled": lambda s: s.scaled(2.5),
}


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("shape", SOLIDS, ids=kind)
def test_transforming_a_shape_transforms_the_set(shape, move):
    """Signed distances of points do not change (or scale) when both are transformed."""
    points = Point(np.random.default_rng(3).uniform(-4, 4, (50, 3)))
    if isinstance(shape, AABB) and move in ("turned", "transformed"):
        with pytest.raises(UnsupportedOperation, match="Box"):
            MOVES[move](shape)
        shape = shape.to_box()
    before = refimpl.distance(points, shape).distance
    after = refimpl.distance(MOVES[move](points), MOVES[move](shape)).distance
    assert np.allclose(after, before * (2.5 if move == "scaled" else 1.0), rtol=0, atol=1e-13)
    assert not np.allclose(refimpl.distance(points, MOVES[move](shape)).distance, before, atol=1e-3)


@pytest.mark.parametrize("factor", [0.0, -1.0, NAN, INF])
def test_only_positive_scales(factor):
    with pytest.raises(UnsupportedOperation, match="positive and finite"):
        Sphere([0, 0, 0], 1).scaled(factor)


@pytest.mark.parametrize("rotation", [[0, 0, 0, 0], [0, 0, 1], [NAN, 0, 0, 1], "up"])
def test_only_quaternions_rotate(rotation):
    with pytest.raises((ShapeError, TypeError, ValueError)):
        Sphere([0, 0, 0], 1).rotated(rotation)


@pytest.mark.parametrize("shape", EXAMPLES, ids=kind)
@pytest.mark.parametrize("offset", [0, [1, 2], [0, 0, NAN], [[1, 2, 3, 4]]])
def test_only_vectors_translate(shape, offset):
    with pytest.raises(ShapeError, match="a translation is a finite vector"):
        shape.translated(offset)


def test_a_quaternion_of_any_length_is_the_same_rotation():
    q = np.array([0.1, -0.2, 0.3, 0.4])
    points = Point(np.random.default_rng(4).uniform(-2, 2, (20, 3)))
    distances = [
        refimpl.distance(points, Box([0, 0, 0], [1, 2, 3], q * f)).distance for f in (1.0, 2.0**400, 2.0**-500, -1.0)
    ]
    assert all(np.array_equal(d, distances[0]) for d in distances)
