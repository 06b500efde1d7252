"""The truth itself, put to the test: known answers, exact certificates, other methods, similar scenes."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from itertools import combinations, product
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf  # type: ignore[import-untyped]

from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Point, Proxy, Ray, Sphere
from tests import truth
from tests.truth import ray_interval, scene_scale, signed_distance

TYPES = (Point, Sphere, Capsule, HalfSpace, AABB, Box)
CORES = (Point, Capsule, AABB, Box)
PAIRS = [(A, B) for i, A in enumerate(TYPES) for B in TYPES[i:]]
NO_TURN = (0, 0, 0, 1)
TURN = (0, 0, 1, 2)  # about z, cosine 3/5, sine 4/5
CUBE, BALL = AABB((-1, -1, -1), (1, 1, 1)), Sphere((0, 0, 0), 1)
HALF_ROOT_3 = math.sqrt(3) / 2  # rounded: two spheres of this radius nearly touch
ROD = Capsule((-1, 0, 0), (1, 0, 0), 1)


def close(x: mpf, y: Any, digits: int = 55) -> bool:
    """Whether x and y agree to so many digits; zeros and infinities must be equal."""
    with mp.workdps(80):
        return bool(x == y or abs(x - y) <= mpf(10) ** -digits * abs(y))


def root(square: Any, rest: Any = 0) -> mpf:
    """Return rest ± √|square| to 80 digits, with the sign of `square`."""
    with mp.workdps(80):
        p, q = Fraction(square), Fraction(rest)
        size = mp.sqrt(mpf(abs(p.numerator)) / p.denominator)
        return (size if p >= 0 else -size) + mpf(q.numerator) / q.denominator


# ---- known answers -----------------------------------------------------------------------------------------

KNOWN = [
    (Point((3, 0, 0)), CUBE, 2),
    (Point((2, 2, 2)), CUBE, root(3)),
    (Point((0.5, 0.25, 0)), CUBE, -0.5),
    (Point((1, 0, 0)), CUBE, 0),
    (Point((0, 0, 0)), BALL, -1),
    (Point((3, 3, 3)), HalfSpace((1, 2, 2), 0), 5),
    (Point((0, 0, -0.5)), ROD, -0.5),
    (Sphere((0, 0, 0), 0.5), CUBE, -1.5),
    (Sphere((2, 2, 0), 0.5), CUBE, root(2, -0.5)),
    (Sphere((2, 3, 3), 3), CUBE, 0),
    (Sphere((3, 4, 0), 4), BALL, 0),
    (Sphere((0, 0, 0), 4), BALL, -5),
    (Sphere((0, 0, 0), HALF_ROOT_3), Sphere((1, 1, 1), HALF_ROOT_3), root(3, -2 * HALF_ROOT_3)),
    (Sphere((0, 0, 5), 1), HalfSpace((0, 0, 2), -4), 2),
    (Sphere((0, 0, 5), 1), Capsule((0, 0, 0), (0, 0, 0), 1), 3),
    (Sphere((7, 0, 4), 1), Capsule((0, 0, 0), (4, 0, 0), 3), 1),
    (ROD, Capsule((0, -1, 0), (0, 1, 0), 2), -3),
    (ROD, Capsule((0, -1, 3), (0, 1, 3), 1), 1),
    (Capsule((0, 0, 0), (1, 2, 3), 0), Capsule((3, 6, 9), (2, 4, 6), 0), root(14)),
    (Capsule((0, 0, 0), (8, 0, 0), 0.5), Capsule((4, 1, 1), (20, 1, 1), 0), root(2, -0.5)),
    (Capsule((-5, 0, 0), (5, 0, 0), 0.5), CUBE, -1.5),
    (Capsule((-5, -5, -5), (5, 5, 5), 0.5), CUBE, root(-2, -0.5)),
    (Capsule((-5, 2, 2), (5, 2, 2), 1), CUBE, root(2, -1)),
    (Capsule((0, 0, 4), (3, 0, 0), 1), HalfSpace((0, 0, 1), 0), -1),
    (CUBE, CUBE, -2),
    (CUBE, AABB((1, 0, 0), (4, 1, 1)), 0),
    (CUBE, AABB((0.5, -9, -9), (9, 9, 9)), -0.5),
    (CUBE, HalfSpace((1, 1, 0), -4), root(-18)),
    (CUBE, HalfSpace((1, 1, 0), 4), root(2)),
    (CUBE, Box((4, 0, 0), (1, 1, 1), TURN), root(0, Fraction(8, 5))),
    (CUBE, Box((4, 0, 0), (1, 1, 1), (0, 0, -0.5, -1)), root(0, Fraction(8, 5))),
    (CUBE, Box((4, 4, 0), (1, 1, 1), (0, 0, -2, -1)), root(0, Fraction(16, 5))),
    (CUBE, Box((8, 0, 0), (5, 5, 5), TURN), 0),
    (CUBE, Box((7.5, 0, 0), (5, 5, 5), TURN), root(0, Fraction(-2, 5))),
    (Box((0, 0, 0), (5, 0, 0), NO_TURN), Box((0, 0, 3), (0, 5, 0), (0, 0, 7, 0)), 3),
    (Box((0, 0, 0), (5, 5, 0), NO_TURN), Box((0, 0, 0), (0, 5, 5), NO_TURN), -5),
    (Box((0, 0, 0), (5, 5, 0), NO_TURN), Box((1, 0, 0), (2, 2, 0), TURN), 0),
    (HalfSpace((0, 0, -3), 3), HalfSpace((0, 0, 2), -6), -2),
    (HalfSpace((0, 0, 2), -2), HalfSpace((0, 0, -3), 9), 2),
    (HalfSpace((0.1, 0.2, 0.3), -1), HalfSpace((-0.2, -0.4, -0.6), 2), 0),
    (HalfSpace((0.1, 0.2, 0.3), -1), HalfSpace((-0.1, -0.2, -math.nextafter(0.3, 1)), 2), -math.inf),
    (HalfSpace((1, 1, 0), 0), HalfSpace((1, 1, 0), 5), -math.inf),
]


@pytest.mark.parametrize(("a", "b", "expected"), KNOWN)
def test_known_distances(a: Proxy, b: Proxy, expected: Any) -> None:
    assert close(signed_distance(a, b), expected)
    assert signed_distance(a, b) == signed_distance(b, a)


def test_scene_scale_counts_coordinates_extents_and_distances() -> None:
    assert scene_scale(Point((3, 0, 0)), CUBE) == 3
    assert scene_scale(Point((-3, 0, 0)), Point((3, 0, 0))) == 6
    assert scene_scale(CUBE, CUBE) == 2
    assert scene_scale(HalfSpace((0, 0, 2), -8), HalfSpace((1, 0, 0), 1)) == 4


def test_what_has_no_truth_is_refused() -> None:
    with pytest.raises(TypeError, match="Ray"):
        signed_distance(Ray((0, 0, 0), (1, 0, 0)), CUBE)
    with pytest.raises(TypeError, match="Point"):
        ray_interval(Ray((0, 0, 0), (1, 0, 0)), Point((0, 0, 0)))


# ---- scenes, and what their numbers mean, written once more ------------------------------------------------


def draw(kind: Any, rng: Any, size: float = 1, place: float = 0, *, whole: bool = False) -> Any:
    """Draw a proxy of about `size` near `place`; many of `whole` numbers are aligned, flat and touching."""

    def vector() -> Any:
        return place + (rng.integers(-size, size + 1, 3) if whole else size * rng.normal(size=3))

    def sizes(count: int) -> Any:
        return rng.integers(0, 4, count) if whole else size * rng.uniform(0, 1, count)

    def direction(width: int) -> Any:
        v = rng.integers(-1, 2, width) if whole else rng.normal(size=width)
        return v if v.any() else direction(width)

    if kind is AABB:
        lower = vector()
        return AABB(lower, lower + sizes(3))
    fields: dict[Any, Callable[[], tuple[Any, ...]]] = {
        Point: lambda: (vector(),),
        Sphere: lambda: (vector(), size / 2 + sizes(1)[0]),
        Capsule: lambda: (vector(), vector(), sizes(1)[0]),
        HalfSpace: lambda: (direction(3), vector()[0]),
        Box: lambda: (vector(), sizes(3), direction(4)),
    }
    return kind(*fields[kind]())


def exact(v: Any) -> Any:
    return np.array([Fraction(float(x)) for x in v])


def left(q: Any) -> Any:
    """Matrix of the map p ↦ q·p on quaternions (x, y, z, w)."""
    x, y, z, w = q
    return np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])


def matrix(quaternion: Any) -> Any:
    """Rotation matrix, exactly, of v ↦ q·v·q̄ / |q|²; p ↦ p·q̄ is the conjugate of p ↦ q·p̄."""
    q, conjugate = exact(quaternion), np.diag([-1, -1, -1, 1])
    return (left(q) @ conjugate @ left(q) @ conjugate)[:3, :3] / (q @ q)


def vertices(shape: Any) -> Any:
    """Vertices of the core of a bounded proxy: rows of Fractions."""
    match shape:
        case Point() | Sphere():
            return exact(shape.reference_point)[None]
        case Capsule():
            return np.array([exact(shape.p), exact(shape.q)])
        case AABB():
            return np.array(list(product(*zip(exact(shape.lower), exact(shape.upper), strict=True))))
        case Box():
            corners = np.array(list(product((-1, 1), repeat=3))) * exact(shape.half_extents)
            return exact(shape.center) + corners @ matrix(shape.rotation).T
    raise TypeError(type(shape).__name__)


def holds(shape: Any, x: Any) -> bool:
    """Whether the core of a bounded proxy holds the rational point x."""
    match shape:
        case Capsule():
            p, d = exact(shape.p), exact(shape.q) - exact(shape.p)
            along = d @ (x - p)
            return bool(np.all(along * d == (d @ d) * (x - p)) and 0 <= along <= d @ d)
        case AABB():
            return bool(np.all(exact(shape.lower) <= x) and np.all(x <= exact(shape.upper)))
        case Box():
            local = matrix(shape.rotation).T @ (x - exact(shape.center))
            return bool(np.all(np.abs(local) <= exact(shape.half_extents)))
    return bool(np.all(x == vertices(shape)[0]))


def radius_of(shape: Any) -> float:
    return float(shape.radius) if isinstance(shape, (Sphere, Capsule)) else 0.0


# ---- another method: σ is the greatest gap over all directions ---------------------------------------------


def greatest_gap(a: Proxy, b: Proxy, rng: np.random.Generator) -> float:
    """Search directions at random, then ever closer around the best: approaches σ from below."""
    va, vb = vertices(a).astype(float), vertices(b).astype(float)
    differences = (vb[:, None] - va).reshape(-1, 3)

    def gaps(n: Any) -> Any:
        return np.min(n @ differences.T, axis=-1) - (radius_of(a) + radius_of(b))

    n = rng.normal(size=(3000, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    best = n[np.argsort(gaps(n))[-6:]]
    for step in 0.2 * 0.9 ** np.arange(150):
        around = best[:, None] + step * rng.normal(size=(len(best), 100, 3))
        around[:, 0] = best
        around /= np.linalg.norm(around, axis=-1, keepdims=True)
        best = around[np.arange(len(best)), np.argmax(gaps(around), axis=1)]
    return float(np.max(gaps(best)))


@pytest.mark.parametrize(("A", "B"), [pair for pair in PAIRS if pair != (HalfSpace, HalfSpace)])
def test_distance_is_the_greatest_gap_over_all_directions(A: Any, B: Any) -> None:
    rng = np.random.default_rng([11, TYPES.index(A), TYPES.index(B)])
    for _ in range(6):
        a, b = draw(A, rng), draw(B, rng)
        sigma = float(signed_distance(a, b))
        if HalfSpace in (A, B):  # the plane's normal is the only direction
            plane, other = (a, b) if A is HalfSpace else (b, a)
            heights = vertices(other).astype(float) @ plane.normal + plane.k
            expected = np.min(heights) / np.linalg.norm(plane.normal) - radius_of(other)
            assert abs(sigma - expected) < 1e-13
        else:
            assert -1e-5 < greatest_gap(a, b, rng) - sigma < 1e-13  # the search ends within 1e-6


# ---- exact certificates of gaps ----------------------------------------------------------------------------


def witnesses(a: Proxy, b: Proxy) -> tuple[Any, Any]:
    """Nearest points of two cores, rational, from the nearest point of their difference."""
    A, B = truth.core_of(a), truth.core_of(b)
    c, g, _ = truth.difference(A, B)
    t, k = truth.Nearest.of(c, g).t, len(A.generators)
    on_a = np.array(A.center) + sum(s * np.array(v) for s, v in zip(t[:k], A.generators, strict=True))
    on_b = np.array(B.center) - sum(s * np.array(v) for s, v in zip(t[k:], B.generators, strict=True))
    return on_a, on_b


def proves(sigma: mpf, on_a: Any, on_b: Any, a: Proxy, b: Proxy) -> bool:
    """Whether the points prove the gap: they lie in the cores, and the planes through them part the cores."""
    x = on_b - on_a
    parted = min(vertices(b) @ x) - max(vertices(a) @ x) >= x @ x
    length = root(x @ x, -Fraction(radius_of(a)) - Fraction(radius_of(b)))
    return holds(a, on_a) and holds(b, on_b) and bool(parted) and close(sigma, length, 50)


def separated_scenes(seed: int) -> list[tuple[Proxy, Proxy]]:
    """Scenes with cores apart, among them those in which the nearest features are hard to tell."""
    rng = np.random.default_rng(seed)
    scenes: list[tuple[Proxy, Proxy]] = []
    for A, B in product(CORES, CORES):
        scenes.append((draw(A, rng), draw(B, rng, place=3)))
        scenes.append((draw(A, rng, 3, whole=True), draw(B, rng, 3, whole=True)))
        scenes.append((draw(A, rng, 1e-3, 1e6), draw(B, rng, 1e-3, 1e6 + 3e-3)))
        scenes.append((draw(A, rng, 1e9), draw(B, rng, 1e-9, 5e9)))
        scenes.append((draw(A, rng, 1e-9), draw(B, rng, 1e-9, 3e-9)))
    for angle in 10.0 ** -np.arange(2, 18):  # nearly parallel, down to the last bits
        box, shift, (p, q) = draw(Box, rng), 3 * rng.normal(size=3), rng.normal(size=(2, 3))
        rotation = box.rotation + angle * rng.normal(size=4)
        scenes.append((box, Box(box.center + shift, box.half_extents, rotation)))
        scenes.append((Capsule(p, q, 0), Capsule(p + shift, q + shift + angle * rng.normal(size=3), 0)))
    return [(a, b) for a, b in scenes if signed_distance(a, b) > 0]


def test_gaps_are_proven_exactly() -> None:
    scenes = separated_scenes(12)
    assert len(scenes) > 90
    for a, b in scenes:
        assert proves(signed_distance(a, b), *witnesses(a, b), a, b), (a, b)


def test_tampered_proofs_are_rejected() -> None:
    for a, b in separated_scenes(13)[::4]:
        sigma, (on_a, on_b) = signed_distance(a, b), witnesses(a, b)
        aside = (on_b - on_a) * Fraction(1, 10**60)
        with mp.workdps(80):
            assert not proves(sigma * (1 + mpf("1e-48")), on_a, on_b, a, b)
            assert not proves(sigma * (1 - mpf("1e-48")), on_a, on_b, a, b)
        assert not proves(sigma, on_a + aside, on_b, a, b)
        assert not proves(sigma, on_a - aside, on_b, a, b)


# ---- exact depths by the convex hull of the difference -----------------------------------------------------


def hull_facets(points: Any) -> list[tuple[int, int]]:
    """(offset, squared length of normal) of each plane through three integer points that has none outside."""
    p = np.unique(points, axis=0)
    i, j, k = np.array(list(combinations(range(len(p)), 3)), dtype=int).reshape(-1, 3).T
    n = np.cross(p[j] - p[i], p[k] - p[i])
    offset = np.sum(n * p[i], axis=1)
    n, offset = np.concatenate([n, -n]), np.concatenate([offset, -offset])
    outer = np.any(n != 0, axis=1) & np.all(n @ p.T <= offset[:, None], axis=1)
    planes = np.column_stack([offset[outer], np.sum(n[outer] ** 2, axis=1)])
    return [(int(d), int(square)) for d, square in np.unique(planes, axis=0)]


@pytest.mark.parametrize(("A", "B"), [(A, B) for A in CORES for B in (AABB, Box)])
def test_depths_agree_with_the_hull_of_the_difference(A: Any, B: Any) -> None:
    rng = np.random.default_rng([14, TYPES.index(A), TYPES.index(B)])
    deep = 0
    for _ in range(30):
        a, b = draw(A, rng, 3, whole=True), draw(B, rng, 3, whole=True)
        b = b.translated(np.rint(a.reference_point - b.reference_point) + rng.integers(-2, 3, 3) / 4)
        differences = [p - q for p in vertices(a) for q in vertices(b)]
        unit = math.lcm(*(x.denominator for v in differences for x in v))
        facets = hull_facets([[int(x * unit) for x in v] for v in differences])
        if facets and min(facets)[0] > 0:
            deep += 1
            square = min(Fraction(d * d, n * unit**2) for d, n in facets)
            assert close(signed_distance(a, b), root(-square, -radius_of(a)))
        else:
            assert signed_distance(a, b) >= -radius_of(a)
    assert deep >= 4


# ---- similar scenes, in whole numbers and so without rounding ----------------------------------------------


def similar(shape: Any, q: Any, shift: Any) -> Any:
    """Return the image under x ↦ |q|² R x + shift, where R is the rotation of the quaternion q."""
    n = int(q @ q)
    M = (matrix(q) * n).astype(float)
    match shape:
        case Point():
            return Point(M @ shape.position + shift)
        case Sphere():
            return Sphere(M @ shape.center + shift, n * shape.radius)
        case Capsule():
            return Capsule(M @ shape.p + shift, M @ shape.q + shift, n * shape.radius)
        case HalfSpace():
            return HalfSpace(M @ shape.normal, n * n * shape.k - M @ shape.normal @ shift)
        case AABB():
            return similar(shape.to_box(), q, shift)
    return Box(M @ shape.center + shift, n * shape.half_extents, left(q) @ shape.rotation)


@pytest.mark.parametrize(("A", "B"), PAIRS)
def test_similar_scenes_have_similar_distances(A: Any, B: Any) -> None:
    rng = np.random.default_rng([15, TYPES.index(A), TYPES.index(B)])
    for _ in range(8):
        a, b = draw(A, rng, 3, whole=True), draw(B, rng, 3, whole=True)
        q, shift = rng.integers(-5, 6, 4), rng.integers(-99, 100, 3)
        sigma = signed_distance(a, b)
        with mp.workdps(80):
            assert close(signed_distance(similar(a, q, shift), similar(b, q, shift)), int(q @ q) * sigma)
        assert sigma == signed_distance(b, a)


# ---- rays --------------------------------------------------------------------------------------------------

RAYS = [
    (Ray((-3, 0.5, 0), (1, 0, 0)), BALL, (root(-0.75, 3), root(0.75, 3))),
    (Ray((-3, 1, 0), (2, 0, 0)), BALL, (1.5, 1.5)),
    (Ray((-3, math.nextafter(1, 2), 0), (2, 0, 0)), BALL, None),
    (Ray((3, 0, 0), (2, 0, 0)), BALL, None),
    (Ray((1, 0, 0), (2, 0, 0)), BALL, (0, 0)),
    (Ray((1, 0, 0), (-2, 0, 0)), BALL, (0, 1)),
    (Ray((1 - 2**-50, 1e-9, 0), (1, 0, 0)), BALL, (0, root(1 - Fraction(1e-9) ** 2, 2**-50 - 1))),
    (Ray((-3, 1, 1), (1, 0, 0)), CUBE, (2, 4)),
    (Ray((-3, 1, math.nextafter(1, 2)), (1, 0, 0)), CUBE, None),
    (Ray((-3, 0, 2), (1, 0.5, -0.5)), CUBE, (2, 2)),
    (Ray((0, 0, 0), (0, 0, 4)), CUBE, (0, 0.25)),
    (Ray((-9, 0, 0), (1, 0, 0)), Box((0, 0, 0), (5, 5, 0), TURN), (2.75, 15.25)),
    (Ray((-9, 0, 0), (1, 0, 0)), Box((0, 0, 0), (0, 5, 5), NO_TURN), (9, 9)),
    (Ray((0, 0, 3), (0, 0, -1)), HalfSpace((0, 0, 2), -2), (2, math.inf)),
    (Ray((0, 0, 1), (1, 0, 0)), HalfSpace((0, 0, 2), -2), (0, math.inf)),
    (Ray((0, 0, 0), (1, 0, 2)), HalfSpace((0, 0, 2), -2), (0, 0.5)),
    (Ray((0, 0, 3), (0, 1, 0)), HalfSpace((0, 0, 2), -2), None),
    (Ray((0, -3, 0), (0, 1, 0)), ROD, (2, 4)),
    (Ray((-5, 0, 1), (1, 0, 0)), ROD, (4, 6)),
    (Ray((-5, 0, 0.5), (1, 0, 0)), ROD, (root(-0.75, 4), root(0.75, 6))),
    (Ray((0, 0, 5), (0, 0, -1)), Capsule((-1, 0, 0), (1, 0, 0), 0), (5, 5)),
    (Ray((-3, 0, 0), (1, 0, 0)), Capsule((-1, 0, 0), (1, 0, 0), 0), (2, 4)),
    (Ray((-3, 1, 5), (0, 1, 0)), Capsule((1, 1, 2), (1, 1, 2), 5), (0, 0)),
]


@pytest.mark.parametrize(("ray", "solid", "expected"), RAYS)
def test_known_rays(ray: Ray, solid: Proxy, expected: Any) -> None:
    times = ray_interval(ray, solid)
    assert (times is None) == (expected is None)
    assert times is None or all(close(t, e) for t, e in zip(times, expected, strict=True))


@pytest.mark.parametrize("kind", [Sphere, Capsule, HalfSpace, AABB, Box])
def test_ray_times_agree_with_distances_of_segments(kind: Any) -> None:
    """Up to its first time a ray is a segment apart from the solid; so it is again after its last time."""
    rng = np.random.default_rng([16, TYPES.index(kind)])
    hits, tick, end = 0, 2.0**-30, 1000.0
    for _ in range(150):
        origin = rng.integers(-5, 6, 3)
        ray, solid = (
            Ray(origin, rng.integers(-2, 3, 3) - 2 * origin + (0, 0, 0.5)),
            draw(kind, rng, 1, whole=True),
        )

        def apart(first: float, last: float, ray: Ray = ray, solid: Proxy = solid) -> bool:
            return bool(signed_distance(Capsule(ray.at(first), ray.at(last), 0), solid) > 0)

        times = ray_interval(ray, solid)
        if times is None:
            assert apart(0, end)
            continue
        hits += 1
        assert (times[0] == 0) == (not apart(0, 0))
        with mp.workdps(80):
            before, inside = (float(mp.floor(t / tick)) * tick for t in times)
            entered, left_it = (float(mp.ceil(t / tick)) * tick for t in times)
        assert not apart(0, entered)
        assert before == entered or apart(0, before)
        assert not apart(min(inside, end), end)
        assert inside == left_it or apart(left_it, end)
    assert 20 <= hits < 150
