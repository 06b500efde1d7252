"""Scenes: picking, line of sight and location against all proxies one by one; culling against proofs and Fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from oracles.crowds.making import thrown
from refimpl.flat import Disc
from refimpl.linear import Array, rotation_matrix
from refimpl.lookup import (
    Scene,
    containing,
    culled_by,
    frustum_of_matrix,
    in_view,
    line_of_sight,
    perspective,
    pick,
    proof_of_absence,
    shows,
)
from refimpl.lookup.frustum import PLANES
from refimpl.proof import certify, check
from refimpl.proxy import Proxy
from refimpl.queries import intersect, raycast
from refimpl.shapes import AABB, Box, Capsule, ConvexPolyhedron, HalfSpace, Point, Ray, ShapeError, Sphere

COUNT = 60
CUBE = frustum_of_matrix(np.eye(4))
"""The planes x, y, z = ±1."""


@pytest.fixture(scope="module")
def bodies() -> list[Proxy]:
    return list(thrown(COUNT, 3).proxies)


@pytest.fixture(scope="module")
def scene(bodies: list[Proxy]) -> Scene:
    return Scene(bodies)


def rays_through(count: int, seed: int) -> Ray:
    """From all around to places among the bodies."""
    rng = np.random.default_rng(seed)
    origin = [0, 0, 3] + 6 * rng.normal(size=(count, 3))
    origin[:, 2] = np.abs(origin[:, 2])
    return Ray(origin, rng.uniform([-2.5, -2.5, 0.5], [2.5, 2.5, 5.5], (count, 3)) - origin)


# -- picking -------------------------------------------------------------------------------------------------


def by_brute_force(bodies: list[Proxy], ray: Ray) -> tuple[Array, Array]:
    """Numbers and times of the first hits, every ray against every proxy."""
    times = np.stack([raycast(ray, body).t for body in bodies])
    number = np.argmin(times, axis=0)
    time = times.min(axis=0)
    return np.where(np.isfinite(time), number, -1), time


@pytest.mark.parametrize("seed", [0, 1])
def test_picks_are_the_first_of_all(scene: Scene, bodies: list[Proxy], seed: int) -> None:
    ray = rays_through(80, seed)
    found = pick(scene, ray)
    number, time = by_brute_force(bodies, ray)
    assert np.array_equal(found.number, number)
    assert np.array_equal(found.hit.t, time)
    assert len(set(number.tolist())) > 20
    for i in np.flatnonzero(number >= 0)[:20].tolist():
        alone = raycast(ray[i], bodies[number[i]])
        assert np.array_equal(found.hit.point[i], alone.point)
        assert np.array_equal(found.hit.normal[i], alone.normal, equal_nan=True)


@pytest.mark.parametrize("exponent", [-60, 40])
def test_picks_do_not_hang_on_the_unit(bodies: list[Proxy], exponent: int) -> None:
    ray, scaled = rays_through(30, 5).times_power(exponent), [body.times_power(exponent) for body in bodies[:15]]
    number, time = by_brute_force(scaled, ray)
    found = pick(Scene(scaled), ray)
    assert np.array_equal(found.number, number)
    assert np.array_equal(found.hit.t, time)
    assert len(set(number.tolist())) > 4


def test_rays_from_far_away_are_picked_as_all(scene: Scene, bodies: list[Proxy]) -> None:
    rng = np.random.default_rng(2)
    origin = 1e7 * rng.normal(size=(30, 3))
    origin[:, 2] = np.abs(origin[:, 2])
    ray = Ray(origin, rng.uniform([-5, -5, 1], [5, 5, 9], (30, 3)) - origin)
    number, time = by_brute_force(bodies, ray)
    found = pick(scene, ray)
    assert np.array_equal(found.number, number)
    assert np.array_equal(found.hit.t, time)
    assert len(set(number.tolist())) > 3


def test_of_equal_hits_the_lowest_number_is_picked_and_a_single_ray_gives_numbers() -> None:
    box = Box([0, 0, 4.5], [1, 1, 0.5], [0, 0, 0, 1])
    balls = [Sphere([0, 0, 9], 1.0), Sphere([0, 0, 5], 1.0), Sphere([0, 0, 5], 1.0), box]
    found = pick(Scene(balls), Ray([0, 0, 0], [0, 0, 2]))
    assert (int(found.number), float(found.hit.t)) == (1, 2.0)
    assert found.hit.normal.tolist() == [0, 0, -1]
    inside = pick(Scene(balls), Ray([0, 0, 9], [0, 0, 2]))
    assert (int(inside.number), float(inside.hit.t)) == (0, 0.0)
    missed = pick(Scene(balls), Ray([0, 0, 0], [0, 0, -2]))
    assert (int(missed.number), bool(missed.hit.hit), float(missed.hit.t)) == (-1, False, np.inf)
    assert pick(Scene(balls), Ray(np.zeros((2, 3, 3)), [0, 0, 1])).number.shape == (2, 3)


def test_an_empty_scene_has_nothing_to_find() -> None:
    empty = Scene([])
    assert pick(empty, rays_through(3, 0)).number.tolist() == [-1] * 3
    assert line_of_sight(empty, [0, 0, 0], [1, 1, 1]).free
    assert containing(empty, np.zeros((2, 3))).shape == (0, 2)
    assert len(in_view(empty, CUBE)) == 0


def test_rays_are_no_part_of_a_scene() -> None:
    with pytest.raises(ShapeError, match="not rays"):
        Scene([Sphere([0, 0, 0], 1.0), Ray([0, 0, 0], [1, 0, 0])])


def test_bad_input_is_refused_by_name(scene: Scene) -> None:
    ball = Sphere([0, 0, 0], 1.0)
    for ask, *rest in ((containing, [[0, 0, 0]]), (pick, Ray([0, 0, 0], [1, 0, 0])), (in_view, CUBE)):
        with pytest.raises(ShapeError, match=r"scene: expected a Scene, got list: Scene\(proxies\) makes one"):
            ask([ball], *rest)  # type: ignore[operator]
    with pytest.raises(ShapeError, match="scene: expected a Scene, got Sphere"):
        line_of_sight(ball, [0, 0, 0], [0, 0, 1])  # type: ignore[arg-type]
    with pytest.raises(ShapeError, match=r"points: expected shape \(n, 3\)"):
        containing(scene, [0, 0, 0])
    with pytest.raises(ShapeError, match="ray: expected a Ray"):
        pick(scene, ball)  # type: ignore[arg-type]
    with pytest.raises(ShapeError, match="not cast at points"):
        pick(Scene([ball, Point([9, 9, 9])]), Ray([5, 0, 0], [-1, 0, 0]))
    with pytest.raises(ShapeError, match="do not broadcast"):
        line_of_sight(scene, np.zeros((2, 3)), np.zeros((3, 3)))
    for numbers in (0, [0.5], ["a"]):
        with pytest.raises(ShapeError, match="apart_from"):
            line_of_sight(scene, [0, 0, 0], [0, 0, 1], apart_from=numbers)  # type: ignore[arg-type]
    for culling in (culled_by, shows, proof_of_absence):
        with pytest.raises(ShapeError, match="frustum: expected a ConvexPolyhedron"):
            culling(AABB([0, 0, 0], [1, 1, 1]), ball)  # type: ignore[operator]
        for volume in (Ray([5, 0, 0], [1, 0, 0]), Disc([0, 0], 1.0), 3):
            with pytest.raises(ShapeError, match="volumes: expected solids"):
                culling(CUBE, volume)  # type: ignore[operator]
    with pytest.raises(ShapeError, match="frustum: expected a ConvexPolyhedron"):
        in_view(Scene([]), AABB([0, 0, 0], [1, 1, 1]))  # type: ignore[arg-type]
    with pytest.raises(ShapeError, match=r"volume: expected a single proxy, got a batch of shape \(2,\)"):
        proof_of_absence(CUBE, Sphere([[5, 0, 0], [6, 0, 0]], 1.0))


def test_a_line_of_sight_from_far_away_ends_where_it_is_said_to() -> None:
    box = AABB([9.95e-6, 9.96e-6, 1.001e-5], [9.99e-6, 1e-5, 1.005e-5])
    p, q = [10.06, 9.97, 10.03], [9.96e-6, 1e-5, 1.003e-5]  # on the box's face; p + (q - p) is not
    assert line_of_sight(Scene([box]), p, q).blocker == 0
    assert line_of_sight(Scene([box]), q, p).blocker == 0
    assert line_of_sight(Scene([box]), p, [9.96e-6, 1e-5 + 1e-13, 1.003e-5]).free


def test_a_line_of_sight_may_be_longer_than_the_largest_number() -> None:
    balls = Scene([Sphere([0, 0, 0], 1e307), Sphere([0, 0, 1e308], 1e307)])
    assert line_of_sight(balls, [-1.5e308, 0, 1e308], [1.5e308, 0, 1e308]).blocker == 1
    assert line_of_sight(balls, [-1.5e308, 0, 2e307], [1.5e308, 0, 2e307]).free
    assert line_of_sight(balls, [-1.5e308, 0, 0], [0, 0, 0]).blocker == 0


# -- line of sight and location --------------------------------------------------------------------------------


def test_lines_of_sight_are_as_of_all(scene: Scene, bodies: list[Proxy]) -> None:
    rng = np.random.default_rng(1)
    p = rng.uniform([-3, -3, 0.1], [3, 3, 6], (60, 3))
    q = p + rng.normal(size=(60, 3)) * rng.choice([0.0, 0.5, 2.0, 1e2], (60, 1))
    q[:, 2] = np.abs(q[:, 2])
    found = line_of_sight(scene, p, q)
    between = np.stack([intersect(Capsule(p, q, np.zeros(60)), body) for body in bodies])
    assert np.array_equal(found.free, ~between.any(axis=0))
    assert np.array_equal(found.blocker, np.where(between.any(axis=0), between.argmax(axis=0), -1))
    assert 5 < np.count_nonzero(found.free) < 55
    again = line_of_sight(scene, p, q, apart_from=range(COUNT // 2))
    assert np.array_equal(again.free, ~between[COUNT // 2 :].any(axis=0))


def test_a_line_of_sight_is_proven_and_touching_blocks_it() -> None:
    balls = Scene([Sphere([0, 0, 0], 1.0), Sphere([9, 0, 0], 1.0)])
    p, q = [-5.0, 1.0, 0.0], [5.0, 1.0, 0.0]
    assert line_of_sight(balls, p, q).blocker == 0
    assert check(certify(Capsule(p, q, 0.0), balls[0]), Capsule(p, q, 0.0), balls[0])[1] <= 0
    above = np.nextafter(1.0, 2.0)
    p[1] = q[1] = above
    assert line_of_sight(balls, p, q).free
    for number in range(2):
        assert check(certify(Capsule(p, q, 0.0), balls[number]), Capsule(p, q, 0.0), balls[number])[0] > 0


def test_a_point_is_in_what_contains_it(scene: Scene, bodies: list[Proxy]) -> None:
    rng = np.random.default_rng(4)
    own = [body.reference_point for body in bodies]
    points = np.concatenate([rng.uniform([-4, -4, -0.5], [4, 4, 6], (100, 3)), own])
    found = containing(scene, points)
    expected = np.argwhere(np.stack([intersect(Point(points), body) for body in bodies], axis=1))
    assert np.array_equal(found, expected)
    assert len(found) > COUNT * 0.8
    for point, number in found[::5].tolist():
        where = Point(points[point])
        assert check(certify(where, bodies[number]), where, bodies[number])[1] <= 0


# -- frusta ----------------------------------------------------------------------------------------------------


def opengl(eye: Array, target: Array, up: Array, angle: float, aspect: float, near: float, far: float) -> Array:
    """The matrices of gluLookAt and gluPerspective, multiplied."""
    f = (target - eye) / np.linalg.norm(target - eye)
    s = np.cross(f, up) / np.linalg.norm(np.cross(f, up))
    view = np.eye(4)
    view[:3, :3] = [s, np.cross(s, f), -f]
    view[:3, 3] = -view[:3, :3] @ eye
    c = 1 / np.tan(angle / 2)
    last = [[0, 0, (far + near) / (near - far), 2 * far * near / (near - far)], [0, 0, -1, 0]]
    return np.array([[c / aspect, 0, 0, 0], [0, c, 0, 0], *last]) @ view


def test_a_frustum_is_what_its_matrix_shows() -> None:
    rng = np.random.default_rng(0)
    for _ in range(5):
        eye, target, up = rng.normal(size=(3, 3))
        angle, aspect, near = rng.uniform(0.3, 2.5), rng.uniform(0.5, 2.5), rng.uniform(0.1, 1)
        matrix = opengl(eye, target, up, angle, aspect, near, 9 * near)
        frustum = perspective(eye, target, up, angle=angle, aspect=aspect, near=near, far=9 * near)
        way = (target - eye) / np.linalg.norm(target - eye)
        points = eye + rng.uniform(0, 10 * near, (400, 1)) * (way + rng.normal(size=(400, 3)))
        clip = np.concatenate([points, np.ones((400, 1))], axis=1) @ matrix.T
        shown = np.all(np.abs(clip[:, :3]) <= clip[:, 3:], axis=1)
        for made in (frustum, frustum_of_matrix(matrix)):
            inside = np.all(made.numbers[:, :3] @ points.T + made.numbers[:, 3:] <= 0, axis=0)
            assert np.array_equal(inside, shown)
        assert 10 < np.count_nonzero(shown) < 300


def test_planes_are_in_their_order() -> None:
    frustum = perspective([0, 0, 0], [0, 5, 0], near=1.0, far=9.0)
    beyond = {"near": [0, 0.5, 0], "far": [0, 10, 0], "left": [-9, 5, 0], "right": [9, 5, 0], "bottom": [0, 5, -9]}
    for number, name in enumerate(PLANES):
        where = beyond.get(name, [0, 5, 9])
        assert np.flatnonzero(frustum.numbers[:, :3] @ where + frustum.numbers[:, 3] > 0).tolist() == [number]
    direct3d = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    assert not shows(frustum_of_matrix(direct3d, nearest=0.0), Point([0, 0, -0.5]))
    assert shows(CUBE, Point([0, 0, -0.5]))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"target": [0, 0, 0]}, "target"),
        ({"up": [0, 2, 0]}, "up"),
        ({"up": [0, np.nan, 0]}, "finite"),
        ({"angle": np.pi}, "angle"),
        ({"aspect": 0.0}, "aspect"),
        ({"near": 5.0, "far": 5.0}, "near"),
        ({"far": np.inf}, "far"),
    ],
)
def test_what_is_no_camera_is_refused(change: dict[str, object], why: str) -> None:
    with pytest.raises(ShapeError, match=why):
        perspective(**{"eye": [0, 0, 0], "target": [0, 1, 0], **change})  # type: ignore[arg-type]


def test_what_is_no_frustum_is_refused() -> None:
    with pytest.raises(ShapeError, match="4 × 4"):
        frustum_of_matrix(np.eye(3))
    with pytest.raises(ShapeError, match="nearest must be -1 or 0"):
        frustum_of_matrix(np.eye(4), nearest=1.0)
    endless = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, -2], [0, 0, -1, 0.0]])
    with pytest.raises(ShapeError, match="far plane is at infinity"):
        frustum_of_matrix(endless)
    with pytest.raises(ShapeError, match="near plane is at infinity or nowhere"):
        frustum_of_matrix(np.zeros((4, 4)))
    with pytest.raises(ShapeError, match="too far apart"):
        perspective([1e308, 0, 0], [-1e308, 0, 0])
    with pytest.raises(ShapeError, match="neither moved nor turned"):
        culled_by(CUBE.translated([1, 0, 0]), Point([0, 0, 0]))


# -- culling ---------------------------------------------------------------------------------------------------


def beyond(plane: Array, volume: Proxy) -> bool:
    """Whether a ball or box lies beyond a plane, in rational numbers."""
    n, k = [Fraction(x) for x in plane[:3].tolist()], Fraction(float(plane[3]))
    if isinstance(volume, Sphere):
        height = sum(a * Fraction(x) for a, x in zip(n, volume.center.tolist(), strict=True)) + k
        return height > 0 and height**2 > Fraction(float(volume.radius)) ** 2 * sum(a * a for a in n)
    assert isinstance(volume, AABB)
    ends = zip(n, volume.lower.tolist(), volume.upper.tolist(), strict=True)
    return sum(min(a * Fraction(low), a * Fraction(high)) for a, low, high in ends) + k > 0


def test_culling_is_exact_for_each_plane() -> None:
    rng = np.random.default_rng(7)
    frustum = perspective([1, 2, 3], [4, 4, 4], near=0.5, far=6.0)
    center, half = rng.uniform(-4, 9, (150, 3)), rng.uniform(0.1, 2, (150, 3))
    for volumes in (Sphere(center, half[:, 0]), AABB(center - half, center + half)):
        found = culled_by(frustum, volumes)
        expected = [
            next((i for i in range(6) if beyond(frustum.numbers[i], volumes[row])), -1) for row in range(len(volumes))
        ]
        assert np.array_equal(found >= 0, np.array(expected) >= 0)
        assert all(number < 0 or beyond(frustum.numbers[number], volumes[row]) for row, number in enumerate(found))
        assert 20 < np.count_nonzero(found < 0) < 100


def test_culling_is_exact_within_a_few_bits_of_a_plane() -> None:
    rng = np.random.default_rng(8)
    decided = set()
    for _ in range(12):
        frustum = perspective(*rng.normal(size=(3, 3)), near=0.5, far=6.0)
        number = int(rng.integers(6))
        n, k = frustum.numbers[number, :3], frustum.numbers[number, 3]
        size = np.sqrt(n @ n)
        half = rng.uniform(0.1, 2, (10, 3))
        center = 5 * rng.normal(size=(10, 3))
        center -= ((center @ n + k) / size**2)[:, None] * n
        off = 1 + rng.integers(-3, 4, (10, 1)) * 2.0**-53 * rng.choice([1, 8], (10, 1))
        ball = Sphere(center + n / size * half[:, :1] * off, half[:, 0])
        middle = center + n / size * np.sum(np.abs(n / size) * half, axis=1)[:, None] * off
        for volumes in (ball, AABB(middle - half, middle + half)):
            for row, found in enumerate(culled_by(frustum, volumes).tolist()):
                behind = [beyond(plane, volumes[row]) for plane in frustum.numbers]
                assert any(behind) == (found >= 0)
                assert found < 0 or behind[found]
                decided.add((isinstance(volumes, Sphere), found >= 0))
    assert len(decided) == 4


def test_what_touches_a_plane_is_not_culled_and_what_misses_it_by_a_bit_is() -> None:
    out = np.nextafter(1.0, 2.0)
    touching = [
        AABB([1, 0, 0], [2, 1, 1]),
        Sphere([2, 0, 0], 1.0),
        Capsule([3, 0, 0], [1.5, 0, 0], 0.5),
        Box([0, 2, 0], [1, 1, 1], [0, 0, 0, 1]),
        ConvexPolyhedron.from_vertices([[0, 0, 1], [0, 0, 2], [1, 0, 2], [0, 1, 2]]),
        HalfSpace([-1, 0, 0], 1.0),
    ]
    missing = [AABB([out, 0, 0], [2, 1, 1]), Sphere([out + 1, 0, 0], 1.0), Sphere([2, 0, 0], np.nextafter(1.0, 0.0))]
    for volume in touching:
        assert int(culled_by(CUBE, volume)) == -1
        assert shows(CUBE, volume)
        assert proof_of_absence(CUBE, volume) is None
    for volume in missing[:1] + missing[2:]:
        assert PLANES[int(culled_by(CUBE, volume))] == "right"
        assert not shows(CUBE, volume)
    grazing = [shape for shape in missing if beyond(CUBE.numbers[PLANES.index("right")], shape)]
    assert all(int(culled_by(CUBE, shape)) == PLANES.index("right") for shape in grazing)


def test_what_is_not_shown_is_proven_absent_and_edges_are_seen_past(bodies: list[Proxy]) -> None:
    frustum = perspective([0, -2, 3], [0, 4, 3], angle=1.1, near=0.5, far=5.0)
    some = bodies[1:25]
    absent = 0
    for body in some:
        if shows(frustum, body):
            assert check(certify(frustum, body), frustum, body)[1] <= 1e-12
            assert int(culled_by(frustum, body)) == -1
        else:
            proof = proof_of_absence(frustum, body)
            assert proof is not None
            assert 0 < proof.lower <= check(proof, frustum, body)[0]
            absent += 1
    assert 5 < absent < len(some) - 5
    corner = Sphere([1.9, 1.9, 0], 1.2)  # beyond an edge of the cube, and beyond no plane
    assert int(culled_by(CUBE, corner)) == -1
    assert not shows(CUBE, corner)
    proof = proof_of_absence(CUBE, corner)
    assert proof is not None
    assert check(proof, CUBE, corner)[0] > 0


def test_what_a_frustum_shows_of_a_scene_is_as_of_all(scene: Scene, bodies: list[Proxy]) -> None:
    for seed in range(3):
        turn = rotation_matrix(np.random.default_rng(seed).normal(size=4))
        eye = np.array([0, 0, 4.0])
        frustum = perspective(eye, eye + turn[0], turn[1], angle=0.9, near=0.2, far=7.0)
        expected = [number for number, body in enumerate(bodies) if intersect(frustum, body)]
        assert in_view(scene, frustum).tolist() == expected
        assert 0 < len(expected) < COUNT / 2
