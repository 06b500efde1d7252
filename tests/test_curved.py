"""Ellipsoids and cylinders: known answers, bounds that need no solver, and the same bits alone and in a batch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import refimpl
from refimpl import compiling
from refimpl.algorithms import curved
from refimpl.algorithms.rows import body_rows
from refimpl.linear import apply, quaternion_product, rotation_matrix
from refimpl.shapes import AABB, Box, Capsule, ConvexPolyhedron, Cylinder, Ellipsoid, Point, Proxy, Sphere

PAIRS = [
    (Sphere, Ellipsoid),
    (Sphere, Cylinder),
    (Capsule, Ellipsoid),
    (Capsule, Cylinder),
    (AABB, Ellipsoid),
    (Box, Ellipsoid),
    (Box, Cylinder),
    (Ellipsoid, Ellipsoid),
    (Ellipsoid, Cylinder),
    (Cylinder, Cylinder),
    (ConvexPolyhedron, Cylinder),
]
UP = np.array([0.0, 0.0, 1.0])


def draw(kind: type[Proxy], rng: Any, n: int, spread: float, thin: float = 1.0) -> Any:
    """Any proxies of a type; some of their sizes `thin` times smaller."""
    place, q = rng.uniform(-spread, spread, (n, 3)), rng.normal(size=(n, 4))
    size = rng.uniform(0.2, 1.5, (n, 3)) * np.where(rng.random((n, 3)) < 0.4, thin, 1.0)
    reach = size[:, 2:] * apply(rotation_matrix(q), np.broadcast_to(UP, (n, 3)))
    corners = rng.uniform(-1, 1, (n, 7, 3)) * size[:, None, :]
    made = {
        Point: lambda: Point(place),
        Sphere: lambda: Sphere(place, size[:, 0]),
        Capsule: lambda: Capsule(place - reach, place + reach, size[:, 0]),
        AABB: lambda: AABB(place - size, place + size),
        Box: lambda: Box(place, size, q),
        Ellipsoid: lambda: Ellipsoid(place, size, q),
        Cylinder: lambda: Cylinder(place - reach, place + reach, size[:, 0]),
        ConvexPolyhedron: lambda: ConvexPolyhedron.from_vertices(corners, place, q),
    }
    return made[kind]()


def support(row: Any, n: Any) -> Any:
    """Support function of a body's row in unit directions (..., 3); written apart from the kernels."""
    if row[0] == 0:
        return np.max(n @ row[18:].reshape(-1, 3)[: int(row[2])].T, axis=-1) + row[1]
    across = n @ row[6:15].reshape(3, 3).T
    if row[0] == 1:
        return n @ row[3:6] + np.linalg.norm(across * row[15:18], axis=-1)
    return n @ row[3:6] + row[15] * np.hypot(across[..., 0], across[..., 1]) + row[17] * np.abs(across[..., 2])


def gaps(a: Any, b: Any, n: Any) -> Any:
    """Gap g(n) of two bodies' rows in directions (..., 3): a lower bound of σ for every one of them."""
    return -(support(a, n) + support(b, -n))


def greatest_gap(a: Any, b: Any, rng: Any) -> float:
    """Approach σ from below: directions everywhere, then ever closer around the best ones that differ."""
    n = rng.normal(size=(3000, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    best = n[np.argsort(-gaps(a, b, n))[:24:3]]
    for step in 0.2 * 0.8 ** np.arange(60):
        around = best[:, None] + step * rng.normal(size=(len(best), 30, 3))
        around[:, 0] = best
        around /= np.linalg.norm(around, axis=-1, keepdims=True)
        best = around[np.arange(len(best)), np.argmax(gaps(a, b, around), axis=1)]
    return float(np.max(gaps(a, b, best)))


def check(a: Any, b: Any) -> Any:
    """Hold an answer against what needs no solver: g(n) = σ, witnesses in place and σ·n apart."""
    found = curved.separation(a, b)
    rows_a, rows_b = body_rows(a), body_rows(b)
    size = np.maximum(np.maximum(a.magnitude, b.magnitude), np.abs(found.distance))
    along = np.array([gaps(x, y, n) for x, y, n in zip(rows_a, rows_b, found.normal, strict=True)])
    assert np.all(np.abs(along - found.distance) <= 2e-14 * size)
    assert np.all(np.abs(np.linalg.norm(found.normal, axis=-1) - 1) <= 1e-15)
    misfit = np.linalg.norm(found.on_b - found.on_a - found.distance[:, None] * found.normal, axis=-1)
    assert np.all(misfit <= 5e-12 * size)
    ways = np.random.default_rng(1).normal(size=(500, 3))
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    for rows, points in ((rows_a, found.on_a), (rows_b, found.on_b)):
        for row, x, s in zip(rows, points, size, strict=True):
            assert np.all(ways @ x <= support(row, ways) + 1e-13 * s)
    return found


@pytest.mark.parametrize("thin", [1.0, 1e-3, 1e-9])
@pytest.mark.parametrize(("A", "B"), PAIRS)
@pytest.mark.parametrize("spread", [0.5, 3.0])
def test_answers_hold_without_a_solver(A: Any, B: Any, spread: float, thin: float) -> None:
    rng = np.random.default_rng([1, PAIRS.index((A, B)), int(10 * spread), int(1 / thin)])
    check(draw(A, rng, 60, spread, thin), draw(B, rng, 60, spread, thin))


@pytest.mark.parametrize(("A", "B"), PAIRS)
def test_no_direction_has_a_greater_gap(A: Any, B: Any) -> None:
    rng = np.random.default_rng([2, PAIRS.index((A, B))])
    a, b = draw(A, rng, 8, 0.5), draw(B, rng, 8, 0.5)
    found = check(a, b)
    assert np.any(found.distance < 0)
    for x, y, sigma in zip(body_rows(a), body_rows(b), found.distance, strict=True):
        assert -1e-4 < greatest_gap(x, y, rng) - sigma < 1e-13


@pytest.mark.parametrize(("A", "B"), PAIRS)
def test_depths_lie_in_the_expanding_polytope(A: Any, B: Any) -> None:
    rng = np.random.default_rng([3, PAIRS.index((A, B))])
    a, b = draw(A, rng, 6, 0.3), draw(B, rng, 6, 0.3)
    found = curved.separation(a, b)
    widened = sum(np.max(s.radius) if isinstance(s, (Sphere, Capsule)) else 0.0 for s in (a, b))
    for i in np.flatnonzero(found.distance < -0.1 - widened):  # where the cores overlap as well
        x, y, triangles = curved.expanded(a[i], b[i], 1e-6, found.normal[i])
        corners = x - y
        p, q, r = (corners[triangles[:, k]] for k in range(3))
        normals = np.cross(q - p, r - p)
        thick = np.linalg.norm(normals, axis=-1) > 1e-12
        assert np.all(np.sum(normals * p, axis=-1)[thick] > 0)
        heights = np.sum(normals * p, axis=-1)[thick] / np.linalg.norm(normals, axis=-1)[thick]
        radius = sum(float(s.radius) for s in (a[i], b[i]) if isinstance(s, (Sphere, Capsule)))
        assert np.min(heights) + radius >= -found.distance[i] - 1e-5
        sides = {(t[k], t[k - 2]) for t in triangles.tolist() for k in range(3)}
        assert sides == {(v, u) for u, v in sides}, "the polytope is closed"


@pytest.mark.parametrize(("A", "B"), PAIRS)
def test_alone_in_a_batch_and_swapped(A: Any, B: Any) -> None:
    rng = np.random.default_rng([4, PAIRS.index((A, B))])
    a, b = draw(A, rng, compiling.WORTH_COMPILING, 1.0, 1e-2), draw(B, rng, compiling.WORTH_COMPILING, 1.0, 1e-2)
    batch = curved.separation(a, b)
    for i in range(0, len(a), 40):
        alone = curved.separation(a[i : i + 1], b[i : i + 1])
        for name in ("distance", "on_a", "on_b", "normal"):
            assert np.array_equal(getattr(alone, name)[0], getattr(batch, name)[i])
    other = curved.separation(b, a)
    assert np.all(np.abs(other.distance - batch.distance) < 1e-13)


# ---- known answers ------------------------------------------------------------------------------------------


def turned(shape: Any, q: Any, shift: Any) -> Any:
    """Move a batch to other poses."""
    return shape.rotated(q).translated(shift)


def concentric_depths(rng: Any, n: int) -> list[tuple[Any, Any, Any]]:
    """Aligned bodies with one centre; h_A + h_B is concave in the squares of n's coordinates: an axis is best."""
    q, zero = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (n, 4)), np.zeros((n, 3))
    s, t = rng.choice([0.3, 0.5, 0.8, 1.0, 1.0 + 1e-9], (n, 3)), rng.choice([0.3, 0.5, 0.7, 1.0], (n, 3))
    thin = np.where(rng.random((n, 1)) < 0.3, [1.0, 1.0, 1e-9], 1.0)
    s = s * thin

    def rod(size: Any) -> Any:
        return Cylinder(-size[:, 2:] * UP, size[:, 2:] * UP, size[:, 0])

    def round_sizes(size: Any) -> Any:
        return np.stack([size[:, 0], size[:, 0], size[:, 2]], axis=-1)

    e, f, box = Ellipsoid(zero, s, q), Ellipsoid(zero, t, q), Box(zero, t, q)
    return [
        (e, f, s + t),
        (e, e, 2 * s),
        (rod(s), rod(t), round_sizes(s) + round_sizes(t)),
        (rod(s), rod(s), 2 * round_sizes(s)),
        (rod(s), f, round_sizes(s) + t),
        (e, box, s + t),
        (rod(s), box, round_sizes(s) + t),
        (Capsule(-t[:, 2:] * UP, t[:, 2:] * UP, np.full(n, 0.1)), e, s + 0.1 + t * UP),
    ]


@pytest.mark.parametrize("turn", [False, True])
def test_concentric_bodies_have_circles_of_minimisers(turn: bool) -> None:
    rng = np.random.default_rng(5)
    n = 40
    q = rng.normal(size=(n, 4)) if turn else np.broadcast_to([0.0, 0.0, 0.0, 1.0], (n, 4))
    for a, b, sums in concentric_depths(rng, n):
        found = check(turned(a, q, np.zeros((n, 3))), turned(b, q, np.zeros((n, 3))))
        assert np.all(np.abs(found.distance + np.min(sums, axis=-1)) < 1e-14)


def test_coaxial_cylinders() -> None:
    rng = np.random.default_rng(6)
    n = 60
    r, s, h, k, z = rng.uniform(0.2, 1.0, (5, n))
    z = np.where(np.arange(n) % 3 == 0, 0.0, z)
    way = rng.normal(size=(n, 3))
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    a = Cylinder(-h[:, None] * way, h[:, None] * way, r)
    b = Cylinder((z - k)[:, None] * way, (z + k)[:, None] * way, s)
    overlap = h + k - z
    expected = np.where(overlap > 0, -np.minimum(overlap, r + s), -overlap)
    assert np.all(np.abs(check(a, b).distance - expected) < 1e-14)


@pytest.mark.parametrize("gap", [0.5, 2e-3, 1e-12, 0.0, -1e-12, -2e-3, -0.05])
def test_features_that_meet(gap: float) -> None:
    """A face of a box, and above it a cap, a rim, a side and an ellipsoid's apex; then turned and moved."""
    rng = np.random.default_rng(7)
    q, shift = rng.normal(size=(5, 4)), rng.uniform(-1, 1, (5, 3))
    box = Box(np.zeros((5, 3)), np.broadcast_to([1.0, 1.0, 0.5], (5, 3)), np.broadcast_to([0.0, 0, 0, 1], (5, 4)))
    for way in ([0.0, 0, 1], [1.0, 0, 0], [0.6, 0, 0.8], [1e-9, 0, 1], [1.0, 0, 1e-9]):
        axis = np.broadcast_to(np.array(way) / np.linalg.norm(way), (5, 3))
        height = 0.2 * np.hypot(axis[:, 0], axis[:, 1]) + 0.3 * np.abs(axis[:, 2])
        center = np.array([0.1, 0.2, 0.5]) + (height + gap)[:, None] * UP
        c = Cylinder(center - 0.3 * axis, center + 0.3 * axis, np.full(5, 0.2))
        found = check(turned(box, q, shift), turned(c, q, shift))
        assert np.all(np.abs(found.distance - gap) < 3e-15)
    turn = rng.normal(size=(5, 4))
    e = Ellipsoid(np.zeros((5, 3)), np.broadcast_to([0.1, 0.2, 0.3], (5, 3)), turn)
    height = np.linalg.norm(np.array([0.1, 0.2, 0.3]) * rotation_matrix(turn)[:, 2, :], axis=-1)
    e = e.translated(np.array([0.1, 0.2, 0.5]) + (height + gap)[:, None] * UP)
    product = quaternion_product(q, turn)
    moved = Ellipsoid(apply(rotation_matrix(q), e.center) + shift, e.radii, product)
    assert np.all(np.abs(check(turned(box, q, shift), moved).distance - gap) < 3e-15)


def exact_from_ellipsoid(radii: Any, y: Any) -> Any:
    """Signed distance of a point from an axis-aligned ellipsoid at the origin, 50 digits, by bisection."""
    with mp.workdps(50):
        r, x = [mpf(float(v)) for v in radii], [abs(mpf(float(v))) for v in y]
        least = min(r)
        inside = sum((a / b) ** 2 for a, b in zip(x, r, strict=True)) < 1
        flat = all(a == 0 for a, b in zip(x, r, strict=True) if b == least)
        if flat:
            u = [a * b / (b * b - least * least) if b > least else mpf(0) for a, b in zip(x, r, strict=True)]
            rest = 1 - sum(v * v for v in u)
            if rest >= 0:
                off = sum((a - v * b) ** 2 for a, b, v in zip(x, r, u, strict=True)) + rest * least**2
                return -mp.sqrt(off) if inside else mp.sqrt(off)
        low, high = -(least**2), max(r) * (mp.sqrt(sum(a * a for a in x)) + max(r))
        for _ in range(340):
            t = (low + high) / 2
            above = sum((a * b / (t + b * b)) ** 2 for a, b in zip(x, r, strict=True) if a > 0) > 1
            low, high = (t, high) if above else (low, t)
        gap = mp.sqrt(sum((a * high / (high + b * b)) ** 2 for a, b in zip(x, r, strict=True)))
        return -gap if inside else gap


def test_points_and_thin_ellipsoids() -> None:
    rng = np.random.default_rng(8)
    n = 150
    radii = rng.uniform(0.2, 1.5, (n, 3)) * np.where(rng.random((n, 3)) < 0.4, 10.0 ** rng.uniform(-9, 0, (n, 3)), 1)
    radii[::7, 1] = radii[::7, 0]
    y = rng.uniform(-1, 1, (n, 3)) * np.where(rng.random((n, 1)) < 0.5, radii, 2.0)
    y *= rng.random((n, 3)) > 0.2
    e = Ellipsoid(np.zeros((n, 3)), radii, np.broadcast_to([0.0, 0, 0, 1], (n, 4)))
    found = curved.point_ellipsoid(Point(y), e)
    for i in range(n):
        assert abs(found.distance[i] - exact_from_ellipsoid(radii[i], y[i])) < 2e-15
        off = found.on_b[i] - found.on_a[i] - found.distance[i] * found.normal[i]
        assert np.max(np.abs(off)) < 2e-15


@pytest.mark.parametrize("x", [(-3.0, -2.75, -1.0), (-2.5, -3.0, -1.0), (-3.0, -3.0, -0.75)])
def test_a_point_of_the_surface_a_hair_off_two_planes_of_symmetry(x: tuple[float, float, float]) -> None:
    turn = [6.471812626116437e-200, 1.038539135619462e-235, -2.7911651441711096e-144, -0.5276144175766938]
    found = refimpl.distance(Point(x), Ellipsoid([-3, -3, -1], [0.5, 0.25, 0.25], turn))
    assert abs(found.distance) < 1e-15
    assert np.allclose(found.on_b, x, rtol=0.0, atol=1e-15)
