"""Ellipsoids, cylinders, k-DOPs and convex polyhedra as data; moving, turning and scaling every bounded type."""

from __future__ import annotations

import copy
import itertools
import math
import pickle
from dataclasses import fields
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import refimpl.shapes
from refimpl.bounds import aabb, bounding_sphere, support
from refimpl.linear import apply, apply_inverse, dot, norm, rotation_matrix
from refimpl.mass import mass_properties
from refimpl.principal import principal_axes, quaternion_of
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Ray,
    ShapeError,
    Sphere,
    UnsupportedOperation,
)

CUBE = np.concatenate([np.concatenate([np.eye(3), -np.eye(3)]), -np.ones((6, 1))], axis=1)
TURN = [0.1, 0.2, -0.3, 0.9]
CLOUD = np.random.default_rng(5).normal(size=(12, 3))
NEW = [
    Ellipsoid([1.0, -2.0, 0.5], [1.0, 2.0, 0.25], [0.5, 0.1, 0.0, 0.7]),
    Cylinder([0.0, 1.0, 0.0], [1.0, 2.0, 3.0], 0.5),
    KDOP.around(CLOUD, 18),
    ConvexPolyhedron(CUBE * [[1, 2, 3, 1]], [1.0, 2.0, 3.0], [0.0, 0.6, 0.0, 0.8]),
    ConvexPolyhedron.from_vertices(CLOUD, [0.0, -1.0, 0.0], TURN),
]
OLD = [
    Point([1.0, -2.0, 0.5]),
    Sphere([1.0, 2.0, 3.0], 0.5),
    Capsule([0.0, 0.0, 0.0], [1.0, 2.0, 0.0], 0.25),
    AABB([-1.0, 0.0, 2.0], [1.0, 0.5, 3.0]),
    Box([1.0, 2.0, 3.0], [0.5, 1.0, 0.1], [0.0, 0.2, 3.0, 4.0]),
]
HALF_SPACE = HalfSpace([0.0, 3.0, 4.0], -10.0)
WAYS = np.concatenate([np.random.default_rng(6).normal(size=(60, 3)), np.eye(3), -np.eye(3)])


def kind(shape):
    return f"{type(shape).__name__}{getattr(shape, 'given', '')}"


# ---- as data -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: Ellipsoid([0, 0, 0], [1, 0, 1]), "Ellipsoid.radii must be greater than 0, got 0.0 at index (1,)"),
        (lambda: Ellipsoid([0, 0, 0], [1, 1]), "Ellipsoid.radii: expected 3 numbers"),
        (lambda: Ellipsoid([0, 0, 0], [1, 1, 1], [0, 0, 0, 0]), "Ellipsoid.rotation must not be zero"),
        (lambda: Cylinder([0, 0, 0], [1, 0, 0], 0), "Cylinder.radius must be greater than 0"),
        (lambda: Cylinder([1, 2, 3], [1, 2, 3], 1), "Cylinder.q must differ from Cylinder.p"),
        (lambda: Cylinder([[1, 2, 3], [0, 0, 0]], [0, 0, 0], 1), "at index (1,)"),
        (lambda: Cylinder([0, 0, math.nan], [1, 0, 0], 1), "Cylinder.p must be finite"),
        (lambda: KDOP([1, 0, 0], [0], [1]), "KDOP.directions: expected k × 3 numbers, got an array of shape (3,)"),
        (lambda: KDOP(np.eye(3), [0, 0], [1, 1]), "KDOP.lower: expected 3 numbers, got an array of shape (2,)"),
        (lambda: KDOP(np.zeros((0, 3)), [], []), "KDOP.directions"),
        (lambda: KDOP([[1, 0, 0], [0, 0, 0]], [0, 0], [1, 1]), "KDOP.directions must not be zero"),
        (
            lambda: KDOP(np.eye(3), [0, 2, 0], [1, 1, 1]),
            "KDOP.upper must not be below KDOP.lower, got 1.0 at index (1,)",
        ),
        (lambda: KDOP(np.eye(3)[:2], [0, 0], [1, 1]), "KDOP: the set is unbounded along (0.0, 0.0, "),
        (lambda: KDOP(np.eye(3)[[0, 1, 2, 0]] * [[1], [1], [1], [2]], [0, 0, 0, 5], [1, 1, 1, 6]), "the set is empty"),
        (lambda: KDOP(np.eye(3), [0, 0, 0], [1, 1, math.inf]), "KDOP.upper must be finite"),
        (lambda: KDOP.around(CLOUD, 12), "the usual k are 6, 14, 18, 26, got 12"),
        (lambda: KDOP.around([1, 2, 3]), "KDOP.around: expected finite points"),
        (lambda: ConvexPolyhedron(np.eye(3)), "ConvexPolyhedron.planes: expected 3 × 4 numbers"),
        (lambda: ConvexPolyhedron.from_vertices(CUBE), "ConvexPolyhedron.vertices: expected 6 × 3 numbers"),
        (lambda: ConvexPolyhedron.from_vertices(np.zeros((0, 3))), "ConvexPolyhedron.vertices: expected"),
        (
            lambda: ConvexPolyhedron(np.concatenate([CUBE, [[0, 0, 0, -1]]])),
            "planes must have a normal that is not zero",
        ),
        (lambda: ConvexPolyhedron(CUBE, rotation=[0, 0, 0, 0]), "ConvexPolyhedron.rotation must not be zero"),
        (
            lambda: ConvexPolyhedron(np.eye(3)),
            "expected 3 × 4 numbers, got an array of shape (3, 3); of corners, use from_",
        ),
        (lambda: ConvexPolyhedron.from_vertices([]), "ConvexPolyhedron.vertices: expected n × 3 numbers, got"),
        (lambda: ConvexPolyhedron(CUBE, [1, 2]), "ConvexPolyhedron.position: expected 3 numbers"),
        (lambda: ConvexPolyhedron([CUBE] * 2, np.zeros((3, 3))), "do not broadcast: planes (2,), position (3,)"),
        (
            lambda: ConvexPolyhedron([CUBE, [*CUBE[:5], [0, 0, -1e-300, -1e300]]]),
            "ConvexPolyhedron: a plane lies beyond the largest float, at index (1,)",
        ),
        (
            lambda: ConvexPolyhedron(
                [[1, 0, 0, -1e308], [-1, 1e-3, 0, 0], [0, -1, 0, 0], [0, 0, 1, -1], [0, 0, -1, 0]]
            ),
            "ConvexPolyhedron: a corner lies beyond the largest float",
        ),
        (lambda: KDOP(np.eye(3) * 1e-300, [0, 0, 0], [1e300, 1, 1]), "KDOP: a plane lies beyond the largest float"),
        (lambda: KDOP.unpack([3.5, 1, 2]), "KDOP.unpack: sizes must be whole numbers"),
        (lambda: KDOP.unpack([3, 1, 2]), "KDOP.unpack: expected rows of 16 numbers"),
        (lambda: KDOP.unpack([]), "KDOP.unpack: expected 1 sizes first"),
        (lambda: KDOP.unpack(np.zeros((0, 16))), "KDOP.unpack: a batch of none has no sizes"),
        (lambda: ConvexPolyhedron.unpack([2, 1, 0, 0, 0]), "must be 0 for planes or 1 for vertices, got 2"),
        (lambda: Sphere.unpack([1, 2, 3]), "Sphere.unpack: expected rows of 4 numbers"),
    ],
)
def test_bad_numbers_are_refused_by_name_and_value(build, words):
    with pytest.raises(ShapeError) as caught:
        build()
    assert words in str(caught.value)


@pytest.mark.parametrize("shape", NEW, ids=kind)
def test_a_proxy_is_immutable(shape):
    for field in fields(shape):
        with pytest.raises(AttributeError):
            setattr(shape, field.name, 0)
        assert not getattr(shape, field.name).flags.writeable


@pytest.mark.parametrize("shape", NEW, ids=kind)
def test_packing_and_repr_lose_nothing(shape):
    again = type(shape).unpack(shape.pack())
    assert np.array_equal(again.pack(), shape.pack())
    assert shape.pack().shape == (type(shape).header + shape.storage,)
    rebuilt = eval(repr(shape), vars(refimpl.shapes))
    assert np.array_equal(rebuilt.pack(), shape.pack())
    assert kind(rebuilt) == kind(shape)
    assert np.array_equal(shape.rebuilt(shape.pack() + 0.0).pack(), shape.pack())


def test_rows_say_how_long_they_are():
    assert KDOP.around(CLOUD, 14).pack()[0] == 7
    assert NEW[3].pack()[:2].tolist() == [0, 6]
    assert NEW[4].pack()[:2].tolist() == [1, 12]
    assert [s.storage for s in NEW] == [10, 7, 9 * 5, 6 * 4 + 7, 12 * 3 + 7]
    with pytest.raises(UnsupportedOperation, match="no fixed width"):
        KDOP.width()
    mixed = np.stack([KDOP.around(CLOUD, 6).pack()] * 2)
    mixed[1, 0] = 2
    with pytest.raises(ShapeError, match="must have the same sizes"):
        KDOP.unpack(mixed)


@pytest.mark.parametrize("shape", NEW, ids=kind)
def test_batches_broadcast_index_and_flatten(shape):
    many = shape.translated(np.arange(12.0).reshape(2, 2, 3))
    assert many.batch_shape == (2, 2)
    assert len(many) == 2
    assert many[1].batch_shape == (2,)
    assert np.array_equal(many[1, 0].pack(), shape.translated([6.0, 7.0, 8.0]).pack())
    flat = many.flattened()
    assert flat.batch_shape == (4,)
    assert np.array_equal(flat.pack(), many.pack().reshape(4, -1))
    assert np.array_equal(flat[np.array([True, False, False, True])].pack(), flat.pack()[[0, 3]])
    wide = many.broadcast_to((5, 2, 2))
    assert np.array_equal(wide[3].pack(), many.pack())
    assert shape.broadcast_to(()).flattened().batch_shape == (1,)
    assert np.array_equal(type(shape).unpack(many.pack()).pack(), many.pack())


@pytest.mark.parametrize("shape", [*NEW, *OLD, HALF_SPACE], ids=kind)
@pytest.mark.parametrize("exponent", [-300, -1, 0, 3, 280])
def test_powers_of_two_scale_exactly(shape, exponent):
    """The set is the scaled one to the bit, and back again."""
    there = shape.times_power(exponent)
    back = there.times_power(-exponent)
    assert there.magnitude == np.ldexp(shape.magnitude, exponent)
    assert np.array_equal(there.reference_point, np.ldexp(shape.reference_point, exponent))
    if isinstance(shape, HalfSpace | KDOP) or kind(shape).endswith("planes"):
        back = back.times_power(0)
        shape = shape.times_power(0)  # directions at about 1
    assert np.array_equal(back.pack(), shape.pack())


def test_directions_are_brought_to_one():
    ray = Ray([1, 2, 3], [0, 1e200, 3e199]).times_power(3)
    assert ray.origin.tolist() == [8, 16, 24]
    assert 0.5 <= np.max(np.abs(ray.direction)) < 1
    long = KDOP(np.eye(3) * 1e150, [-1e150] * 3, [1e150] * 3)
    assert np.all(np.max(np.abs(long.times_power(0).directions), axis=-1) < 1)
    assert np.array_equal(long.times_power(1).vertices, 2 * long.vertices)
    planes = ConvexPolyhedron(CUBE * 1e-150).times_power(2)
    assert np.all(np.max(np.abs(planes.planes[:, :3]), axis=-1) >= 0.5)
    assert sorted(set(planes.hull.vertices.ravel())) == [-4, 4]


def test_what_puts_two_proxies_in_order_is_the_same_alone_and_in_a_batch():
    alone = ConvexPolyhedron.from_vertices(CLOUD, [1, 2, 3])
    batch = ConvexPolyhedron.from_vertices(np.stack([CLOUD, CLOUD + 1]), [[1, 2, 3], [4, 5, 6]])
    shared = ConvexPolyhedron.from_vertices(CLOUD, [[1, 2, 3], [4, 5, 6]])
    for many in (batch, shared):
        assert many.identity()[0] == alone.identity()[0]
        assert np.array_equal(many.identity()[1][0], alone.identity()[1])
    assert not np.array_equal(batch.identity()[1][1], shared.identity()[1][1])


def test_a_batch_of_none_is_one():
    for shape in NEW:
        none = shape.broadcast_to((3,))[:0]
        fresh = [
            none,
            KDOP(np.eye(3), np.zeros((0, 3)), np.ones((0, 3))),
            ConvexPolyhedron.from_vertices(np.zeros((0, 5, 3))),
        ]
        for empty in fresh:
            assert empty.batch_shape == (0,)
            assert empty.magnitude.shape == (0,)
            assert empty.reference_point.shape == (0, 3)
            assert empty.flattened().times_power(np.zeros(0, dtype=int)).batch_shape == (0,)
            assert empty.pack().shape[0] == empty.identity()[1].shape[0] == 0
            assert aabb(empty).batch_shape == bounding_sphere(empty).batch_shape == (0,)
            assert mass_properties(empty).volume.shape == (0,)


def test_proxies_can_be_sent_to_another_process():
    for shape in [*NEW, NEW[4].translated(CLOUD)[3:].times_power(2)]:
        again = pickle.loads(pickle.dumps(shape))
        assert np.array_equal(again.pack(), shape.pack())
        assert np.array_equal(copy.deepcopy(shape).times_power(1).pack(), shape.times_power(1).pack())


# ---- k-DOPs around points ----------------------------------------------------------------------------------------


def outside_by(dop, points):
    """How far points lie outside, exactly: the largest violation of a slab."""
    rows = [tuple(map(Fraction, p)) for p in points.tolist()]
    worst = Fraction(-1)
    for d, low, high in zip(dop.directions.tolist(), dop.lower.tolist(), dop.upper.tolist(), strict=True):
        heights = [sum(Fraction(a) * b for a, b in zip(d, p, strict=True)) for p in rows]
        worst = max(worst, max(heights) - Fraction(high), Fraction(low) - min(heights))
    return worst


@pytest.mark.parametrize("k", [6, 14, 18, 26])
def test_a_kdop_around_points_contains_them_exactly_and_closely(k):
    for shift, scale in ((0, 1), (1e6, 1e-3), (0.1, 1e-9)):
        points = CLOUD * scale + shift
        dop = KDOP.around(points, k)
        assert 2 * len(dop.lower) == k
        assert outside_by(dop, points) <= 0
        reach = 3 * np.max(np.abs(points))
        heights = points @ dop.directions.T
        assert np.all(dop.upper - heights.max(0) <= 1e-15 * reach)
        assert np.all(heights.min(0) - dop.lower <= 1e-15 * reach)
        assert outside_by(KDOP(dop.directions, dop.lower, dop.upper - 1e-15 * reach), points) > 0
    exact = np.array([[-1.0, 2.0, 3.0], [4.0, 0.5, -6.0]])
    assert KDOP.around(exact, 6).upper.tolist() == [4.0, 2.0, 3.0]


@pytest.mark.parametrize(("k", "zeros"), [(6, {2}), (14, {2, 0}), (18, {2, 1}), (26, {2, 1, 0})])
def test_the_usual_directions_are_those_of_a_cube(k, zeros):
    """To its faces, its edges and its corners; each once, and one of each opposite two."""
    cube = {d for d in itertools.product((-1, 0, 1), repeat=3) if d.count(0) in zeros}
    found = [tuple(int(x) for x in d) for d in KDOP.around(CLOUD, k).directions]
    assert {*found, *(tuple(-x for x in d) for d in found)} == cube
    assert 2 * len(found) == len(cube) == k


def test_the_reference_point_is_the_mean_of_the_corners_alone_and_in_a_batch():
    """The batch's smaller hulls repeat their last corner."""
    cube = np.array(list(itertools.product((-1, 0.5), repeat=3)))
    clouds = np.stack([CLOUD, np.repeat(CLOUD[:4], 3, axis=0), np.concatenate([cube, cube[:4]])])
    for many in (KDOP.around(clouds, 14), ConvexPolyhedron.from_vertices(clouds, [1, 2, 3], TURN)):
        assert len({len(type(many).unpack(row).hull.vertices) for row in many.pack()}) >= 2
        for i, row in enumerate(many.pack()):
            alone = type(many).unpack(row)
            middle = alone.hull.vertices.mean(axis=0)
            if isinstance(many, ConvexPolyhedron):
                middle = many.position[i] + apply(rotation_matrix(np.array(TURN)), middle)
            assert np.array_equal(many.reference_point[i], alone.reference_point)
            assert np.allclose(alone.reference_point, middle, rtol=0, atol=1e-14)
            assert many.magnitude[i] == alone.magnitude


@pytest.mark.parametrize("shape", [NEW[0], NEW[3], NEW[4], OLD[4]], ids=kind)
def test_quaternions_of_any_length_turn_alike(shape):
    expected = support(shape.rotated(TURN), WAYS)
    for length in (2.0**800, 2.0**-800, -1.0):
        again = shape.rotated(np.array(TURN) * length).rotated(np.array([0, 0, 0, 1]) * length)
        assert np.allclose(support(again, WAYS), expected, rtol=0, atol=1e-14)


# ---- isometries and scalings -------------------------------------------------------------------------------------

MATRIX = rotation_matrix(np.array(TURN))
SHIFT = np.array([0.5, -1.0, 2.0])
FACTORS = np.array([2.0, 0.5, 3.0])
MOVES = {
    "turned": (lambda s: s.rotated(TURN), MATRIX, 0.0),
    "moved": (lambda s: s.translated(SHIFT), np.eye(3), SHIFT),
    "transformed": (lambda s: s.transformed(TURN, SHIFT), MATRIX, SHIFT),
    "scaled": (lambda s: s.scaled(2.5), 2.5 * np.eye(3), 0.0),
    "stretched": (lambda s: s.stretched(FACTORS), np.diag(FACTORS), 0.0),
    "stretched evenly": (lambda s: s.stretched([1.5, 1.5, 1.5]), 1.5 * np.eye(3), 0.0),
}


def image_error(shape, moved, matrix, shift):
    """By how much an image is not M A + t, whose support function is h(A, Mᵀn) + n·t."""
    expected = support(shape, WAYS @ matrix) + WAYS @ (shift * np.ones(3))
    return np.max(np.abs(support(moved, WAYS) - expected))


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("shape", [*NEW, *OLD], ids=kind)
def test_transforming_a_shape_transforms_the_set(shape, move):
    change, matrix, shift = MOVES[move]
    impossible = (
        (isinstance(shape, AABB) and move in ("turned", "transformed"))
        or (isinstance(shape, Sphere | Capsule | Cylinder | Box) and move == "stretched")
    )  # fmt: skip
    if impossible:
        with pytest.raises(UnsupportedOperation):
            change(shape)
        return
    moved = change(shape)
    assert type(moved) is type(shape)
    assert image_error(shape, moved, matrix, shift) <= 2e-14
    for wrong in (matrix.T @ np.diag([1, 1, 1.01]), matrix + 1e-8):
        assert image_error(shape, moved, wrong, shift) > 1e-10
    assert image_error(shape, moved, matrix, shift + 1e-8) > 1e-10


@pytest.mark.parametrize("shape", [HALF_SPACE, ConvexPolyhedron(CUBE, [[1, 2, 3]] * 2), NEW[2]], ids=kind)
def test_stretching_moves_the_boundary(shape):
    """Points of the boundary stay on it."""
    if isinstance(shape, HalfSpace):
        points = apply(MATRIX, CLOUD) - np.outer(dot(apply(MATRIX, CLOUD), shape.normal) + shape.k, shape.normal) / 25
        after = shape.stretched(FACTORS)
        assert np.max(np.abs(dot(points * FACTORS, after.normal) + after.k)) < 1e-13
        assert np.max(np.abs(dot(points, after.normal) + after.k)) > 0.1
    else:
        corners = shape.hull.vertices + getattr(shape, "position", np.zeros(3))[..., None, :]
        after = shape.stretched(FACTORS)
        moved = after.hull.vertices + getattr(after, "position", np.zeros(3))[..., None, :]
        assert sorted(map(tuple, np.round((corners * FACTORS).reshape(-1, 3), 12))) == sorted(
            map(tuple, np.round(moved.reshape(-1, 3), 12))
        )


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        (OLD[1], "Ellipsoid (Sphere.to_ellipsoid())"),
        (OLD[2], "Composite"),
        (OLD[4], "ConvexPolyhedron (Box.to_convex_polyhedron())"),
        (NEW[1], "ConvexPolyhedron comes near"),
    ],
)
def test_what_cannot_be_stretched_says_what_to_use(shape, words):
    with pytest.raises(UnsupportedOperation) as caught:
        shape.stretched(FACTORS)
    assert words in str(caught.value)
    assert f"a {type(shape).__name__} cannot be stretched" in str(caught.value)


def test_the_types_named_by_the_errors_can_be_stretched():
    for shape, other in ((OLD[1], OLD[1].to_ellipsoid()), (OLD[4], OLD[4].to_convex_polyhedron())):
        assert image_error(shape, other, np.eye(3), 0.0) < 1e-14
        assert image_error(shape, other.stretched(FACTORS), np.diag(FACTORS), 0.0) < 1e-13


def test_stretching_along_the_axes_where_the_set_allows_it():
    upright = Cylinder([1, 2, 5], [1, 2, 1], 0.5)
    assert image_error(upright, upright.stretched([2, 2, 3]), np.diag([2, 2, 3]), 0.0) < 1e-14
    with pytest.raises(UnsupportedOperation, match="cross-section"):
        upright.stretched([2, 2.5, 3])
    quarter_turned = Box([1, 2, 3], [1, 2, 4], [0, 0, 1, 1])
    assert image_error(quarter_turned, quarter_turned.stretched(FACTORS), np.diag(FACTORS), 0.0) < 1e-14
    segment = Capsule([0, 1, 2], [3, 4, 5], 0)
    assert image_error(segment, segment.stretched(FACTORS), np.diag(FACTORS), 0.0) < 1e-14
    for bad in ([1, 2], [1, -1, 1], [0, 1, 1], [1, math.inf, 1], 2.0):
        with pytest.raises(UnsupportedOperation):
            segment.stretched(bad)


def test_batches_stretch_row_by_row():
    factors = np.array([[1, 2, 3], [3, 1, 1], [2, 2, 2.0]])
    for shape in (NEW[0], NEW[2], NEW[3], NEW[4]):
        many = shape.stretched(factors)
        for i, each in enumerate(factors):
            assert np.array_equal(many[i].pack(), shape.stretched(each).pack())


# ---- principal axes ----------------------------------------------------------------------------------------------


def exact_radii(matrix):
    with mpmath.workdps(60):
        return sorted((float(mpmath.sqrt(x)) for x in mpmath.eigsy(matrix.T * matrix, eigvals_only=True)), reverse=True)


@pytest.mark.parametrize("thin", [1.0, 1e-3, 1e-9])
def test_radii_of_stretched_ellipsoids_are_good_to_rounding_however_thin(thin):
    """Against 60 digits; and a general-purpose decomposition is not good enough for the thin ones."""
    worst = general = 0.0
    rng = np.random.default_rng(8)
    for _ in range(40):
        radii, factors, q = rng.uniform(0.5, 2, 3) * [1, thin, thin**0.5], rng.uniform(0.2, 5, 3), rng.normal(size=4)
        matrix = np.diag(factors) @ rotation_matrix(q) * radii
        axes, found = principal_axes(matrix)
        expected = np.array(exact_radii(mpmath.matrix(matrix.tolist())))
        worst = max(worst, np.max(np.abs(found / expected - 1)))
        general = max(general, np.max(np.abs(np.linalg.svd(matrix)[1] / expected - 1)))
        assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-15)
        assert np.linalg.det(axes) > 0
        back = rotation_matrix(quaternion_of(axes)) * found
        assert np.allclose(back @ back.T, matrix @ matrix.T, rtol=0, atol=1e-14 * np.max(np.abs(matrix)) ** 2)
    assert worst < 4e-15
    if thin == 1e-9:
        assert general > 1e-12


def test_quaternions_of_all_quarter_and_half_turns():
    for q in np.array(np.meshgrid(*[[-1, 0, 1]] * 4)).reshape(4, -1).T:
        if np.any(q):
            matrix = rotation_matrix(q.astype(float))
            assert np.allclose(rotation_matrix(quaternion_of(matrix)), matrix, atol=2e-16)


# ---- membership: what the numbers mean ---------------------------------------------------------------------------


def test_the_support_function_is_that_of_the_documented_set():
    """Points drawn from the set by its definition come as high as the support function, and never higher."""
    rng = np.random.default_rng(9)
    ball = rng.normal(size=(200_000, 3))
    ball /= norm(ball)[:, None]
    e, c, poly = NEW[0], NEW[1], NEW[3]
    drawn = {kind(e): e.center + apply(rotation_matrix(e.rotation), ball * e.radii)}
    axis = (c.q - c.p) / norm(c.q - c.p)
    rim = ball - np.outer(dot(ball, axis), axis)
    rim = c.radius * rim / norm(rim)[:, None]
    drawn[kind(c)] = np.concatenate([c.p + rim, c.q + rim])
    inside = rng.uniform(-1, 1, (200_000, 3))
    inside = inside[np.all(inside @ poly.planes[:, :3].T + poly.planes[:, 3] <= 0, axis=1)]
    drawn[kind(poly)] = poly.position + apply(rotation_matrix(poly.rotation), inside)
    for shape in (e, c, poly):
        heights = drawn[kind(shape)] @ WAYS.T
        reach = support(shape, WAYS)
        assert np.all(np.max(heights, axis=0) <= reach + 1e-14)
        assert np.all(np.max(heights, axis=0) >= reach - 0.05 * norm(WAYS))


def test_rotations_turn_the_frame_and_not_back():
    poly = ConvexPolyhedron(CUBE * [[1, 2, 3, 1]], [1, 2, 3], TURN)
    corner = poly.position + apply(rotation_matrix(np.array(TURN)), np.array([1, 0.5, 1 / 3]))
    assert np.min(norm(poly.position + apply(rotation_matrix(poly.rotation), poly.vertices) - corner)) < 1e-15
    back = poly.position + apply_inverse(rotation_matrix(np.array(TURN)), np.array([1, 0.5, 1 / 3]))
    assert np.min(norm(poly.position + apply(rotation_matrix(poly.rotation), poly.vertices) - back)) > 0.01
