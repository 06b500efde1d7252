"""Support functions and bounding volumes: they contain exactly, and reach no farther than rounding."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from refimpl.bounds import aabb, bounding_sphere, support, support_point
from refimpl.intervals import plus_rounded, sum_rounded
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
    Ray,
    Sphere,
    UnsupportedOperation,
)

rng = np.random.default_rng(11)
CUBE = np.concatenate([np.concatenate([np.eye(3), -np.eye(3)]), -np.ones((6, 1))], axis=1)
TETRAHEDRON = np.concatenate([np.zeros((1, 3)), np.eye(3)])
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
COUNT = 40


def batches(place, size):
    """A batch of each bounded type, with places and sizes of these orders of magnitude, thin ones among them."""
    center = place * rng.normal(size=(COUNT, 3))
    q = rng.normal(size=(COUNT, 4))
    thin = size * np.where(rng.random((COUNT, 3)) < 0.3, 10.0 ** rng.uniform(-9, -3, (COUNT, 3)), 1)
    extents = thin * rng.uniform(0.5, 2, (COUNT, 3))
    cloud = extents[:, None, :] * rng.normal(size=(COUNT, 7, 3))
    other = center + size * rng.normal(size=(COUNT, 3))
    parts = [Sphere(center, extents[:, 0]), Box(other, extents, q)]
    return [
        Point(center),
        Sphere(center, extents[:, 0]),
        Capsule(center, other, extents[:, 1]),
        AABB(center, center + extents),
        Box(center, extents, q),
        KDOP.around(center[:, None, :] + cloud, 18),
        Ellipsoid(center, extents, q),
        Cylinder(center, other, extents[:, 2]),
        ConvexPolyhedron(CUBE * [1, 1, 1, size], center, q),
        ConvexPolyhedron.from_vertices(cloud, center, q),
        Polyhedron(size * TETRAHEDRON, FACES, center, q),
        Composite(parts),
    ]


CASES = [
    pytest.param(shape, id=f"{type(shape).__name__}{getattr(shape, 'given', '')}-{place:g}-{size:g}")
    for place, size in ((1.0, 1.0), (1e6, 1e-3), (0.0, 1e-9), (1.0, 1e9), (0.0, 1e-150), (1e150, 1e150))
    for shape in batches(place, size)
]


# ---- an independent reading of the shapes in 50 digits ------------------------------------------------------------


def big(v):
    return [mpmath.mpf(float(x)) for x in np.asarray(v).ravel()]


def turn(q, v, inverse=False):
    """R(q) v, or its inverse, by the quaternion product q v q* / |q|²."""
    x, y, z, w = q
    u = [-x, -y, -z] if inverse else [x, y, z]
    t = [2 * (u[1] * v[2] - u[2] * v[1]), 2 * (u[2] * v[0] - u[0] * v[2]), 2 * (u[0] * v[1] - u[1] * v[0])]
    c = [u[1] * t[2] - u[2] * t[1], u[2] * t[0] - u[0] * t[2], u[0] * t[1] - u[1] * t[0]]
    square = x * x + y * y + z * z + w * w
    return [a + (w * b + d) / square for a, b, d in zip(v, t, c, strict=True)]


def dot(u, v):
    return sum(a * b for a, b in zip(u, v, strict=True))


def length(v):
    return mpmath.sqrt(dot(v, v))


def corners(shape):
    """Corners of a polytope in the world, in 50 digits, where they are given by floats."""
    if isinstance(shape, Box):
        q, c = big(shape.rotation), big(shape.center)
        signs = [(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
        local = [[s * h for s, h in zip(sign, big(shape.half_extents), strict=True)] for sign in signs]
    elif isinstance(shape, ConvexPolyhedron | Polyhedron):
        q, c = big(shape.rotation), big(shape.position)
        local = [big(v) for v in (shape.vertices if isinstance(shape, Polyhedron) else shape.hull.vertices)]
    else:
        points = shape.hull.vertices if isinstance(shape, KDOP) else [shape.position]
        return [big(v) for v in points]
    return [[a + b for a, b in zip(c, turn(q, v), strict=True)] for v in local]


def exact_support(shape, n):  # noqa: PLR0911  a definition for each type
    """h(n), n any vector of mpf, from the set's definition."""
    if isinstance(shape, Composite):
        return max(exact_support(part, n) for part in shape.parts)
    if isinstance(shape, Sphere):
        return dot(big(shape.center), n) + big(shape.radius)[0] * length(n)
    if isinstance(shape, Capsule):
        return max(dot(big(shape.p), n), dot(big(shape.q), n)) + big(shape.radius)[0] * length(n)
    if isinstance(shape, Cylinder):
        p, q, r = big(shape.p), big(shape.q), big(shape.radius)[0]
        way = [b - a for a, b in zip(p, q, strict=True)]
        along = dot(way, n) / length(way)
        return max(dot(p, n), dot(q, n)) + r * mpmath.sqrt(max(dot(n, n) - along * along, 0))
    if isinstance(shape, Ellipsoid):
        local = turn(big(shape.rotation), n, inverse=True)
        return dot(big(shape.center), n) + length([a * x for a, x in zip(big(shape.radii), local, strict=True)])
    if isinstance(shape, AABB):
        return sum(x * (h if x > 0 else l) for x, l, h in zip(n, big(shape.lower), big(shape.upper), strict=True))
    return max(dot(c, n) for c in corners(shape))


def farthest_from(shape, center):
    """Largest distance of the set from a point: exact for round shapes about it and for corners, else a lower bound."""
    if isinstance(shape, Composite):
        return max(farthest_from(part, center) for part in shape.parts)
    if isinstance(shape, Sphere | Capsule):
        ends = [shape.center] if isinstance(shape, Sphere) else [shape.p, shape.q]
        return max(length([a - b for a, b in zip(big(e), center, strict=True)]) for e in ends) + big(shape.radius)[0]
    if isinstance(shape, AABB):
        return length([max(h - c, c - l) for c, l, h in zip(center, big(shape.lower), big(shape.upper), strict=True)])
    if isinstance(shape, Ellipsoid):
        return max(big(shape.radii))
    if isinstance(shape, Cylinder):
        p, q = big(shape.p), big(shape.q)
        half = length([b - a for a, b in zip(p, q, strict=True)]) / 2
        return mpmath.sqrt(half**2 + big(shape.radius)[0] ** 2)
    return max(length([a - b for a, b in zip(c, center, strict=True)]) for c in corners(shape))


# ---- tests -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", CASES)
def test_the_support_function_is_the_exact_one(shape):
    ways = rng.normal(size=(COUNT, 3)) * 10.0 ** rng.integers(-30, 30, (COUNT, 1))
    ways[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    found = support(shape, ways)
    points = support_point(shape, ways)
    worst = 0.0
    for i in range(0, COUNT, 3):
        n = big(ways[i])
        exact = exact_support(shape[i], n)
        unit = length(n) * (mpmath.mpf(float(shape[i].magnitude)) or 1)
        worst = max(worst, float(abs(found[i] - exact) / unit), float(abs(dot(big(points[i]), n) - exact) / unit))
        assert found[i] == support(shape[i], ways[i])
        assert np.array_equal(points[i], support_point(shape[i], ways[i]))
    assert worst < 4e-15
    assert worst > 0 or isinstance(shape, Point | AABB)


@pytest.mark.parametrize("shape", CASES)
def test_the_bounding_box_contains_exactly_and_closely(shape):
    box = aabb(shape)
    for i in range(0, COUNT, 3):
        check_box(shape[i], box[i])
        assert np.array_equal(aabb(shape[i]).pack(), box[i].pack())


def check_box(shape, box, slack=2e-14):
    size = float(shape.magnitude)
    for axis in range(3):
        n = [mpmath.mpf(int(k == axis)) for k in range(3)]
        for sign, bound in ((1, box.upper), (-1, box.lower)):
            beyond = sign * big(bound)[axis] - exact_support(shape, [sign * x for x in n])
            rounded = 2.0**-53 * size if isinstance(shape, KDOP) else 0.0  # its corners are known to rounding here
            assert beyond >= -rounded
            assert beyond <= slack * size


@pytest.mark.parametrize("shape", CASES)
def test_the_bounding_sphere_contains_exactly_and_closely(shape):
    ball = bounding_sphere(shape)
    for i in range(0, COUNT, 3):
        check_ball(shape[i], ball[i])
        assert np.array_equal(bounding_sphere(shape[i]).pack(), ball[i].pack())


def check_ball(shape, ball):
    size = float(shape.magnitude)
    far = farthest_from(shape, big(ball.center))
    rounded = 4 * 2.0**-53 * size if isinstance(shape, KDOP) else 0.0
    assert big(ball.radius)[0] - far >= -rounded
    if not isinstance(shape, Composite):
        assert big(ball.radius)[0] - far <= max(4e-14 * size, 1e-300)


def test_the_checks_see_what_is_too_small_or_too_large():
    for shape in batches(1.0, 1.0):
        one = shape[0]
        box, ball = aabb(one), bounding_sphere(one)
        least = 1e-14 * float(one.magnitude) * np.eye(3)
        for axis in range(3):
            wrong = [
                replace(box, upper=box.upper + 3 * least[axis]),
                replace(box, lower=box.lower - 3 * least[axis]),
            ]
            if box.upper[axis] - box.lower[axis] > 4e-14 * one.magnitude:
                wrong.append(replace(box, upper=box.upper - 3 * least[axis]))
            for each in wrong:
                with pytest.raises(AssertionError):
                    check_box(one, each)
        if not isinstance(one, Point):
            with pytest.raises(AssertionError):
                check_ball(one, replace(ball, radius=ball.radius * (0.5 if isinstance(one, Composite) else 0.99)))
        if not isinstance(one, Composite):
            with pytest.raises(AssertionError):
                check_ball(one, replace(ball, radius=ball.radius + 1e-13 * one.magnitude))


def test_round_bounds_are_exact_where_doubles_allow():
    assert aabb(Sphere([1, 2, 3], 0.5)).pack().tolist() == [0.5, 1.5, 2.5, 1.5, 2.5, 3.5]
    assert aabb(Point([0.1, 0.2, 0.3])).pack().tolist() == [0.1, 0.2, 0.3] * 2
    assert aabb(Capsule([0.1, 0, 0], [1, 2, 3], 0)).pack().tolist() == [0.1, 0, 0, 1, 2, 3]
    assert bounding_sphere(Ellipsoid([1, 2, 3], [1, 2, 4], [1, 2, 3, 4])).pack().tolist() == [1, 2, 3, 4]
    tiny = Sphere([1, 0, 0], 1e-30)
    assert aabb(tiny).upper[0] == np.nextafter(1, 2)
    assert aabb(tiny).lower[0] == np.nextafter(1, 0)


@pytest.mark.parametrize("bound", [aabb, bounding_sphere, lambda s: support_point(s, [1, 0, 0])])
@pytest.mark.parametrize("shape", [Ray([0, 0, 0], [1, 2, 3]), HalfSpace([0, 0, 1], 2)])
def test_what_is_unbounded_has_no_bounds(shape, bound):
    for each in (shape, Composite([Sphere([0, 0, 0], 1), shape])) if shape.is_solid else (shape,):
        with pytest.raises(UnsupportedOperation, match=f"a {type(shape).__name__} has no .*: it is unbounded"):
            bound(each)


def test_support_of_what_is_unbounded():
    ray, half = Ray([1, 2, 3], [0, 0, 2]), HalfSpace([0, 0, 2], -6)
    ways = np.array([[0, 0, 1.0], [0, 0, -1], [1, 0, 0], [1, 0, -1e-9], [0, 0, 0]])
    assert support(ray, ways).tolist() == [np.inf, -3, 1, 1 - 3e-9, 0]
    assert support(half, ways).tolist() == [3, np.inf, np.inf, np.inf, 0]


def test_sums_are_rounded_to_the_side_that_is_asked_for():
    for _ in range(300):
        a, b, c = (rng.normal(size=3) * 10.0 ** rng.integers(-20, 20, 3)).tolist()
        pair = Fraction(a) + Fraction(b)
        low, high = float(plus_rounded(a, b, -np.inf)), float(plus_rounded(a, b, np.inf))
        assert Fraction(low) <= pair <= Fraction(high)
        assert high == low or (np.nextafter(low, np.inf) == high and Fraction(low) < pair < Fraction(high))
        three = pair + Fraction(c)
        terms = np.array([a, b, c])
        low, high = float(sum_rounded(terms, -np.inf)), float(sum_rounded(terms, np.inf))
        assert Fraction(low) <= three <= Fraction(high)
        assert high - low <= 4 * np.spacing(max(abs(high), abs(low)))


def test_support_along_a_cylinders_axis_is_right_whatever_rounding_leaves_across() -> None:
    rng = np.random.default_rng(7)
    p, q = rng.normal(size=(2, 500, 3))
    cylinder, way = Cylinder(p, q, rng.uniform(0.1, 2.0, 500)), q - p
    unit = way / np.linalg.norm(way, axis=-1)[:, None]
    expected = np.maximum(np.sum(p * unit, axis=-1), np.sum(q * unit, axis=-1))
    reached = np.sum(support_point(cylinder, way) * unit, axis=-1)
    assert np.abs(reached - expected).max() < 4e-15
