"""The truth of k-DOPs, ellipsoids, cylinders, convex polyhedra and unions, put to the test by other methods."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf  # type: ignore[import-untyped]

from refimpl.linear import rotation_matrix
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
    Ray,
    Sphere,
)
from tests import truth
from tests.benchmarks.scenes import globe
from tests.truth import body_of, ray_interval, signed_distance
from tests.truth.hulls import Hull, hull_of_planes, hull_of_points
from tests.truth.polytopes import straight_distance
from tests.truth.rationals import dot, minus, vector
from tests.truth.unions import surrounds

NEW = (KDOP, Ellipsoid, Cylinder, ConvexPolyhedron)
BOUNDED = (Point, Sphere, Capsule, AABB, Box, *NEW)
PAIRS = [(A, B) for i, A in enumerate(BOUNDED) for B in BOUNDED[i:] if {A, B} & set(NEW)]
NO_TURN, TURN = (0, 0, 0, 1), (0, 0, 1, 2)  # TURN: about z, cosine 3/5, sine 4/5


def draw(kind: Any, rng: Any, spread: float, thinnest: float = 0.0) -> Any:
    """A proxy of about size 1; with `thinnest`, extents down to that power of ten."""
    place, extents, q = spread * rng.normal(size=3), rng.uniform(0.2, 1.5, 3), rng.normal(size=4)
    extents = extents * 10.0 ** -(rng.uniform(0, thinnest, 3) * (rng.random(3) < 0.5))
    reach = extents[2] * rotation_matrix(q)[:, 2]
    slabs = rng.uniform(0.2, 1.5, (2, 7))
    makers = {
        Point: lambda: Point(place),
        Sphere: lambda: Sphere(place, extents[0]),
        Capsule: lambda: Capsule(place - reach, place + reach, extents[0]),
        AABB: lambda: AABB(place - extents, place + extents),
        Box: lambda: Box(place, extents, q),
        KDOP: lambda: KDOP(rng.normal(size=(7, 3)), -slabs[0], slabs[1]).translated(place),
        Ellipsoid: lambda: Ellipsoid(place, extents, q),
        Cylinder: lambda: Cylinder(place - reach, place + reach, extents[0]),
        ConvexPolyhedron: lambda: ConvexPolyhedron.from_vertices(rng.normal(size=(10, 3)) * extents, place, q),
    }
    return makers[kind]()


# ---- σ is the greatest gap over all directions -------------------------------------------------------------


def gaps(a: Proxy, b: Proxy, n: Any) -> Any:
    """−(h_A(n) + h_B(−n)) for unit vectors (..., 3), in doubles."""
    total = np.zeros(n.shape[:-1])
    for shape, sign in ((a, 1.0), (b, -1.0)):
        body = body_of(shape)
        points = np.array([[float(x) for x in p] for p in body.points])
        total += np.max(sign * n @ points.T, axis=-1) + float(body.radius)
        if body.axes:
            total += np.linalg.norm(n @ np.array(body.axes).T, axis=-1)
    return -total


def greatest_gap(a: Proxy, b: Proxy, rng: Any) -> float:
    """Search directions at random, then ever closer around the best: approaches σ from below."""
    n = rng.normal(size=(3000, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    best = n[np.argsort(gaps(a, b, n))[-8:]]
    for step in 0.2 * 0.72 ** np.arange(50):
        around = best[:, None] + step * rng.normal(size=(len(best), 60, 3))
        around[:, 0] = best
        around /= np.linalg.norm(around, axis=-1, keepdims=True)
        best = around[np.arange(len(best)), np.argmax(gaps(a, b, around), axis=1)]
    return float(np.max(gaps(a, b, best)))


@pytest.mark.parametrize(("A", "B"), PAIRS)
def test_no_direction_has_a_greater_gap(A: Any, B: Any) -> None:
    rng = np.random.default_rng([21, BOUNDED.index(A), BOUNDED.index(B)])
    near = []
    for thinnest, spread in ((0.0, 1.0), (0.0, 0.3), (8.0, 0.3)):
        a, b = draw(A, rng, spread, thinnest), draw(B, rng, spread, thinnest)
        below = float(signed_distance(a, b)) - greatest_gap(a, b, rng)
        assert below > -1e-14
        near.append(below)
    assert min(near) < 1e-6  # the search comes close where nothing is thin


# ---- exact hulls -------------------------------------------------------------------------------------------


def faces_of(hull: Hull) -> int:
    """Planes with at least three corners that are not on one line: here, no plane has less unless it has none."""
    return sum(sum(dot(p[:3], c) + p[3] == 0 for c in hull.corners) >= 3 for p in hull.planes)


@pytest.mark.parametrize("seed", range(8))
def test_hulls_are_closed_and_convex(seed: int) -> None:
    rng = np.random.default_rng([22, seed])
    whole = seed % 2 == 0  # many points on the same planes and lines
    points = rng.integers(-1, 2, (14, 3)).astype(float) if whole else rng.normal(size=(14, 3))
    hull = hull_of_points([vector(p) for p in points])
    assert len(hull.corners) - len(hull.edges) + faces_of(hull) == 2
    heights = [[dot(p[:3], vector(x)) + p[3] for x in points] for p in hull.planes]
    assert max(map(max, heights)) == 0
    again = hull_of_planes(hull.planes)
    assert set(again.corners) == set(hull.corners)
    assert len(again.edges) == len(hull.edges)


def test_corners_of_planes_are_those_of_all_triples() -> None:
    rng = np.random.default_rng(23)
    planes = [(*vector(n), Fraction(-1)) for n in rng.integers(-3, 4, (9, 3)) if n.any()]
    planes += [(*n, Fraction(-1)) for n in [(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)]]
    found = set()
    for rows in combinations(planes, 3):
        matrix = [list(row[:3]) for row in rows]
        d = _determinant(matrix)
        if d:
            columns = [[[-r[3] if j == i else r[j] for j in range(3)] for r in rows] for i in range(3)]
            x = tuple(_determinant(c) / Fraction(d) for c in columns)
            if all(dot(p[:3], x) + p[3] <= 0 for p in planes):
                found.add(x)
    assert set(hull_of_planes(planes).corners) == found


def _determinant(m: list[list[Any]]) -> Any:
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def test_flat_hulls() -> None:
    square = [vector(p) for p in [(0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1), (1, 1, 1), (1, 0, 1)]]
    hull = hull_of_points(square)
    assert (len(hull.corners), len(hull.edges)) == (4, 4)
    line = hull_of_points([vector((x, x, 0)) for x in (3, 1, 2)])
    assert sorted(float(c[0]) for c in line.corners) == [1, 3]
    assert len(hull_of_points([vector((1, 2, 3))] * 3).corners) == 1


def test_any_polytopes_agree_with_zonotopes() -> None:
    rng = np.random.default_rng(24)
    kinds = (Point, Capsule, AABB, Box)
    for i in range(60):
        A, B = kinds[rng.integers(4)], kinds[rng.integers(4)]
        a, b = draw(A, rng, 0.8, 9.0 * (i % 2)), draw(B, rng, 0.8, 9.0 * (i % 3 == 0))
        (p, q), core_sigma = (body_of(a), body_of(b)), truth.signed_distance(a, b)
        square = straight_distance(p, q)
        with mp.workdps(60):
            sigma = mp.sqrt(abs(truth.real(square))) * (1 if square > 0 else -1) - truth.real(p.radius + q.radius)
            assert abs(sigma - core_sigma) <= mpf(10) ** -50


# ---- known answers -----------------------------------------------------------------------------------------

ROD = Cylinder((0, 0, -1), (0, 0, 1), 1)
EGG = Ellipsoid((0, 0, 0), (1, 2, 3))
KNOWN = [
    (Point((5, 0, 0)), EGG, 4),
    (Point((0, 0, 0)), EGG, -1),
    (EGG, Ellipsoid((0, 0, 0), (3, 1, 2)), -3),  # along y: 2 + 1
    (Sphere((0, 5, 0), 1), EGG, 2),
    (Ellipsoid((0, 0, 0), (2, 2, 2)), Ellipsoid((0, 0, 0), (2, 2, 2)), -4),
    (Ellipsoid((0, 0, 0), (2, 2, 2)), Ellipsoid((3, 4, 0), (1, 1, 1)), 2),
    (EGG, HalfSpace((1, 0, 0), 2), 1),
    (EGG, HalfSpace((0, -3, 0), 3), -1),
    (Point((0, 0, 0)), ROD, -1),
    (Point((4, 0, 5)), ROD, 5),
    (Point((0, 0, 5)), ROD, 4),
    (ROD, ROD, -2),
    (ROD, Cylinder((0, 0, 3), (0, 0, 4), 0.5), 2),
    (ROD, Cylinder((5, 0, 0.5), (5, 0, 1.5), 1), 3),
    (ROD, Box((0, 0, 4), (1, 1, 1), TURN), 2),
    (ROD, HalfSpace((0, 0, 2), 4), 1),
    (KDOP(np.eye(3), [-1, -1, -1], [1, 1, 1]), AABB((3, -1, -1), (4, 1, 1)), 2),
    (KDOP(np.eye(3), [-1, -1, -1], [1, 1, 1]), Box((4, 0, 0), (1, 1, 1), TURN), Fraction(8, 5)),
]


@pytest.mark.parametrize(("a", "b", "sigma"), KNOWN)
def test_known_answers(a: Proxy, b: Proxy, sigma: Any) -> None:
    with mp.workdps(60):
        assert abs(signed_distance(a, b) - truth.real(Fraction(sigma))) < mpf(10) ** -30


@pytest.mark.parametrize(
    ("a", "b", "square"),
    [
        (
            ConvexPolyhedron.from_vertices([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]),
            Point((1, 1, 1)),
            Fraction(4, 3),
        ),
        (ROD, Cylinder((4, 0, 5), (9, 0, 5), 1), Fraction(18)),
    ],
)
def test_known_squares(a: Proxy, b: Proxy, square: Fraction) -> None:
    with mp.workdps(60):
        assert abs(signed_distance(a, b) ** 2 - truth.real(square)) < mpf(10) ** -40


@pytest.mark.parametrize("B", [Point, Sphere, Ellipsoid])
def test_gaps_between_smooth_bodies_are_proven(B: Any) -> None:
    """Their support points along the normal are unique, and as far apart as σ says."""
    rng = np.random.default_rng([25, BOUNDED.index(B)])
    for _ in range(2):
        a, b = draw(Ellipsoid, rng, 0.0), draw(B, rng, 0.0).translated([3.0, 2.0, -2.0])
        sigma = signed_distance(a, b)
        ways = _directions(rng, 2000)
        best = ways[np.argmax(gaps(a, b, ways))]
        assert sigma > 0
        best = _lined_up(a, b, best)
        with mp.workdps(60):
            bodies, n = [body_of(a), body_of(b)], tuple(mpf(float(x)) for x in best)
            step = minus(_support_point(bodies[1], tuple(-x for x in n)), _support_point(bodies[0], n))
            upper = mp.sqrt(dot(step, step)) - truth.real(bodies[0].radius + bodies[1].radius)
            assert -(mpf(10) ** -40) <= upper - sigma <= mpf(10) ** -13


def _directions(rng: Any, count: int) -> Any:
    n = rng.normal(size=(count, 3))
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def _lined_up(a: Proxy, b: Proxy, n: Any) -> Any:
    """Turn n, little by little, until it points from one support point to the other."""
    centers = [np.array([float(x) for x in body_of(shape).points[0]]) for shape in (a, b)]
    shapes = [np.array(body_of(shape).axes or np.zeros((1, 3))).T for shape in (a, b)]

    def support(i: int, way: Any) -> Any:
        image = shapes[i] @ (shapes[i].T @ way)
        return centers[i] + image / (np.linalg.norm(shapes[i].T @ way) or 1.0)

    for _ in range(6000):
        step = support(1, -n) - support(0, n)
        n = n + 0.05 * step / np.linalg.norm(step)
        n = n / np.linalg.norm(n)
    return n


def _support_point(body: Any, n: Any) -> Any:
    center = tuple(truth.real(x) for x in body.points[0])
    if body.ellipsoid is None:
        return center
    image = tuple(sum(truth.real(m) * x for m, x in zip(row, n, strict=True)) for row in body.ellipsoid)
    size = mp.sqrt(dot(n, image))
    return tuple(c + x / size for c, x in zip(center, image, strict=True))


# ---- rays --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", NEW)
def test_ray_times_agree_with_distances_of_segments(kind: Any) -> None:
    """Up to its first time a ray is a segment apart from the solid; so it is again after its last time."""
    rng = np.random.default_rng([26, NEW.index(kind)])
    hits = 0
    for _ in range(12):
        solid = draw(kind, rng, 0.3)
        origin = 3.0 * rng.normal(size=3)
        ray = Ray(origin, rng.normal(size=3) * 0.3 - origin)
        times = ray_interval(ray, solid)
        if times is None:
            assert signed_distance(Capsule(ray.at(0.0), ray.at(50.0), 0.0), solid) > 0
            continue
        hits += 1
        first, last = (float(t) for t in times)
        if first > 0:
            assert signed_distance(Capsule(ray.at(0.0), ray.at(first * (1 - 1e-9)), 0.0), solid) > 0
        assert abs(signed_distance(Point(ray.at(first)), solid)) < 1e-14 or first == 0
        assert abs(signed_distance(Point(ray.at(last)), solid)) < 1e-14
        assert signed_distance(Capsule(ray.at(last * (1 + 1e-9)), ray.at(50.0), 0.0), solid) > 0
    assert hits >= 4


# ---- unions ------------------------------------------------------------------------------------------------


def test_unions_are_as_near_as_their_pieces() -> None:
    parts = [Box((0, 0, 0), (1, 1, 1), NO_TURN), Sphere((5, 0, 0), 1), Ellipsoid((0, 9, 0), (1, 2, 1))]
    both = Composite(parts)
    assert signed_distance(both, Point((3, 0, 0))) == 1
    assert signed_distance(Composite([parts[1], Composite(parts[:1])]), Sphere((0, 0, 4), 1)) == 2
    assert signed_distance(both, HalfSpace((0, 0, 1), 5)) == 4
    assert signed_distance(both, Sphere((5, 0.5, 0), 1)) <= -1.5


def test_a_polyhedron_is_a_solid() -> None:
    mesh = Polyhedron(*globe(6, 8))
    assert abs(float(signed_distance(mesh, Point((0, 0, 3)))) - 2) < 1e-15
    assert signed_distance(mesh, Sphere((0, 0, 0.1), 0.1)) <= 0  # wholly inside
    assert signed_distance(Sphere((0, 0, 0.1), 0.1), mesh) <= 0
    assert signed_distance(mesh, Polyhedron(*globe(4, 5), position=(0, 0, 5))) > 0
    hull = ConvexPolyhedron.from_vertices(mesh.vertices)
    for x in ([2.0, 1.0, -1.0], [0.3, -1.2, 0.4]):
        assert abs(signed_distance(mesh, Point(x)) - signed_distance(hull, Point(x))) < 1e-15
    assert math.isclose(float(signed_distance(mesh, HalfSpace((0, 0, 1), 3))), 2.0)


def test_points_in_line_with_edges_are_surrounded_or_not() -> None:
    """A cube of triangles: from points in the planes and lines of its faces and edges, and from its centre."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [tuple(vector(corners[i]) for i in t) for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    outside = [(0, 0, 2), (0, 0, -1), (2, 1, 1), (-1, -1, 0), (0.5, 0, 3), (2, 2, 2), (-1, 2, -3)]
    assert not any(surrounds(triangles, vector(p)) for p in outside)
    assert all(surrounds(triangles, vector(p)) for p in [(0.5, 0.5, 0.5), (0.25, 0.5, 0.75), (1e-9, 1e-9, 1e-9)])
