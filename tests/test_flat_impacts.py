"""The plane's areas, moments and impacts: against sums over pixels, the textbook's formula in fractions, and laws."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import refimpl
from refimpl import ShapeError, UnsupportedOperation
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatTranslation, Rectangle, Segment
from refimpl.flat.area import area_properties
from refimpl.flat.impacts import FlatBody, FlatImpact, ImpactLine, impact_in_plane, respond
from tests import flat_truth
from tests.flat_scenes import some

SOLIDS: list[Any] = [
    Disc((1, 2), 1.5),
    Segment((-1, 0), (2, 1), 0.7),
    Rectangle((-1, 0.5), (2, 1.5)),
    ConvexPolygon.from_vertices([(0, 0), (3, 1), (2, 3), (1, 1)]),
    ConvexPolygon([(-1, 0, -1), (0, -1, -1), (1, 2, -2), (1, 0, -9)]),
]


def by_pixels(shape: Any, step: float) -> tuple[float, Any, float]:
    """Area, centroid and polar moment from the points of a grid that lie inside."""
    box = refimpl.aabb(shape)
    x, y = (np.arange(box.lower[i] + step / 2, box.upper[i], step) for i in (0, 1))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    inside = points[refimpl.intersect(FlatPoint(points), shape)]
    middle = inside.mean(axis=0)
    return len(inside) * step**2, middle, float(np.sum((inside - middle) ** 2)) * step**2


@pytest.mark.parametrize("shape", SOLIDS, ids=lambda s: type(s).__name__)
def test_areas_and_moments_are_those_of_pixels(shape: Any) -> None:
    found = area_properties(shape)
    area, middle, moment = by_pixels(shape, 0.02)
    assert found.area == pytest.approx(area, rel=0.01)
    assert found.centroid == pytest.approx(middle, abs=0.01)
    assert found.moment == pytest.approx(moment, rel=0.02)
    assert found.moment != pytest.approx(1.1 * moment, rel=0.02)


def test_a_moved_polygon_has_the_same_area_and_a_row_the_same_as_alone() -> None:
    rng = np.random.default_rng(2)
    batch = ConvexPolygon.from_vertices(rng.normal(size=(20, 7, 2)))
    found, away = area_properties(batch), area_properties(batch.translated((1024, -2048)))
    assert np.allclose(found.area, away.area, rtol=1e-10)
    assert np.allclose(found.moment, away.moment, rtol=1e-9)
    for i in range(20):
        alone = area_properties(batch[i])
        assert alone.area == found.area[i]
        assert np.array_equal(alone.centroid, found.centroid[i])
        assert alone.moment == found.moment[i]
    same = area_properties(Rectangle((-1, 0.5), (2, 1.5)).to_polygon())
    assert same.moment == pytest.approx(area_properties(Rectangle((-1, 0.5), (2, 1.5))).moment, rel=1e-15)


def test_what_has_no_area_has_no_body() -> None:
    with pytest.raises(UnsupportedOperation, match="FlatPoint has no area"):
        area_properties(FlatPoint((0, 0)))
    with pytest.raises(UnsupportedOperation, match="area_properties"):
        refimpl.mass_properties(Disc((0, 0), 1))
    assert area_properties(ConvexPolygon.from_vertices([(0, 0), (2, 2)])).area == 0
    for make, words in (
        (lambda: FlatBody.of(Segment((0, 0), (1, 0)), density=1), "must have an area"),
        (lambda: FlatBody.of(Segment((1, 2), (1, 2)), mass=1), "or a mass and a length"),
        (lambda: FlatBody.of(Disc((0, 0), 1e200), density=1), "beyond the largest float: give a mass"),
        (lambda: FlatBody.of(Disc((0, 0), 1)), "either a density or a mass"),
        (lambda: FlatBody.of(Disc((0, 0), 1), mass=-1), "must be positive"),
        (lambda: FlatBody((0, 0, 0), (0, 0), 0, 1, 1), "FlatBody.position: expected 2 numbers"),
        (lambda: FlatBody((0, 0), (0, 0), 0, 1), "FlatBody.moment: needed"),
        (lambda: FlatBody((0, 0), (0, 0), 0, 1, 0), "FlatBody.moment: must be positive"),
        (lambda: FlatBody((0, 0), (0, 0), 0, -1, 1), "FlatBody.inverse_mass: must be at least 0"),
    ):
        with pytest.raises(ShapeError, match=words):
            make()


@pytest.mark.parametrize("exponent", [-400, 0, 400])
def test_a_body_may_have_any_size(exponent: int) -> None:
    """Its moment is the mass by a square of lengths: the area's moment would be beyond the largest double, or 0."""
    size = 2.0**exponent
    shapes = Disc((0, 0), size), Rectangle((0, 0), (size, 2 * size)), Segment((0, 0), (3 * size, 4 * size))
    for shape, ninths in zip(shapes, (4.5, 3.75, 18.75), strict=True):
        body = FlatBody.of(shape, mass=2.0)
        assert body.moment is not None
        assert float(body.moment) == pytest.approx(2 * ninths / 9 * size * size, rel=1e-14)


def some_body(rng: np.random.Generator, *, fixed: bool = False) -> FlatBody:
    """A body of small fractions."""
    x, y, u, v, spin = (Fraction(int(k), 4) for k in rng.integers(-8, 9, size=5))
    mass, moment = (Fraction(int(k), 2) for k in rng.integers(1, 9, size=2))
    return FlatBody((x, y), (u, v), spin, Fraction(0) if fixed else 1 / mass, moment)


def textbook(a: FlatBody, b: FlatBody, line: ImpactLine, e: Fraction) -> tuple[list[Any], Any]:
    """Velocities and spins after −(1 + e) n·u / (w_a + w_b + l_a²/I_a + l_b²/I_b) for n of any length, in fractions."""
    n, p = line.direction, line.point
    arms = [p - body.position for body in (a, b)]
    speeds = [
        np.array([body.velocity[0] - body.angular_velocity * r[1], body.velocity[1] + body.angular_velocity * r[0]])
        for body, r in zip((a, b), arms, strict=True)
    ]
    approach = n @ (speeds[1] - speeds[0])
    levers = [r[0] * n[1] - r[1] * n[0] for r in arms]
    softness = sum(
        body.inverse_mass * (n @ n) + (lever**2 / body.moment if body.inverse_mass else 0)
        for body, lever in zip((a, b), levers, strict=True)
    )
    impulse = -(1 + e) * approach / softness
    after = []
    for body, lever, sign in ((a, levers[0], -1), (b, levers[1], 1)):
        turn = sign * impulse * lever / body.moment if body.inverse_mass else 0
        after += [body.velocity + sign * impulse * body.inverse_mass * n, body.angular_velocity + turn]
    return after, approach


@pytest.mark.parametrize("fixed", [False, True])
def test_impacts_along_the_line_are_the_textbooks_in_fractions(fixed: bool) -> None:
    rng = np.random.default_rng(11)
    differs = 0
    for _ in range(40):
        a, b = some_body(rng), some_body(rng, fixed=fixed)
        line = ImpactLine(*(np.array([Fraction(int(k)) for k in row]) for row in rng.integers(-3, 4, size=(2, 2))))
        if not line.direction.any():
            continue
        e = Fraction(int(rng.integers(0, 5)), 4)
        found = impact_in_plane(a, b, line, e)
        expected, _ = textbook(a, b, line, e)
        answers = [found.a.velocity, found.a.angular_velocity, found.b.velocity, found.b.angular_velocity]
        for answer, right in zip(answers, expected, strict=True):
            assert np.all(answer == right)
        for body, after in ((a, found.a), (b, found.b)):
            if line.lever(body) == 0:
                assert after.angular_velocity == body.angular_velocity
        differs += np.any(textbook(a, b, line, e + 1)[0][0] != found.a.velocity)
    assert differs > 30


def energy(body: FlatBody) -> Any:
    v = body.velocity
    return (v @ v / body.inverse_mass + body.moment * body.angular_velocity**2) / 2 if body.inverse_mass else 0


def spin_about_origin(body: FlatBody) -> Any:
    x, v = body.position, body.velocity
    return body.moment * body.angular_velocity + (x[0] * v[1] - x[1] * v[0]) / body.inverse_mass


def test_friction_keeps_momentum_in_the_cone_and_never_gains_energy() -> None:
    rng = np.random.default_rng(12)
    rubbed = 0
    for _ in range(60):
        a, b = some_body(rng), some_body(rng)
        line = ImpactLine(*(np.array([Fraction(int(k)) for k in row]) for row in rng.integers(-3, 4, size=(2, 2))))
        if not line.direction.any() or (approach := textbook(a, b, line, Fraction(0))[1]) >= 0:
            continue
        mu = Fraction(int(rng.integers(1, 5)), 4)
        found = impact_in_plane(a, b, line, Fraction(1, 2), mu)
        n, p = line.direction, found.impulse
        across = p[0] * n[1] - p[1] * n[0]
        rubbed += across != 0
        assert p @ n > 0
        assert across**2 <= (mu * (p @ n)) ** 2 * (1 + Fraction(1, 10**9))
        assert energy(found.a) + energy(found.b) <= energy(a) + energy(b)
        assert np.all(a.velocity / a.inverse_mass - found.a.velocity / a.inverse_mass == p)
        assert spin_about_origin(a) + spin_about_origin(b) == spin_about_origin(found.a) + spin_about_origin(found.b)
        speeds = [
            body.velocity + body.angular_velocity * np.array([-r[1], r[0]])
            for body, r in ((found.a, line.point - a.position), (found.b, line.point - b.position))
        ]
        assert n @ (speeds[1] - speeds[0]) == -approach / 2
    assert rubbed > 15


def test_a_response_moves_apart_and_bounces() -> None:
    ball, floor = Disc((0, 0.9), 1), Rectangle((-5, -1), (5, 0))
    a = FlatBody.of(ball, density=2.0, velocity=(3, -4))
    b = FlatBody.of(floor, mass=np.inf)
    found = refimpl.collide(ball, floor, a.inverse_mass, b.inverse_mass)
    line = ImpactLine.of(found)
    assert line.point == pytest.approx([0, 0])
    assert line.lever(a) == 0
    answer: FlatImpact = respond(found, a, b, 0.5)
    assert answer.happened
    assert answer.a.position == pytest.approx([0, 1])
    assert answer.a.velocity == pytest.approx([3, 2])
    assert answer.a.angular_velocity == 0
    rough = respond(found, a, b, 0.5, 100.0)
    assert rough.a.velocity[0] == pytest.approx(2)  # it rolls: two thirds of the speed, as for any disc
    assert rough.a.angular_velocity == pytest.approx(-2)
    apart = respond(refimpl.collide(ball.translated((0, 3)), floor), a, b, 0.5)
    assert not apart.happened
    assert np.array_equal(apart.a.velocity, a.velocity)
    many = FlatBody(np.tile([0.0, 0.9], (3, 1)), np.tile([3.0, -4.0], (3, 1)), np.zeros(3), a.inverse_mass, a.moment)
    rows = respond(refimpl.collide(Disc(np.tile([0, 0.9], (3, 1)), 1), floor, a.inverse_mass, 0), many, b, 0.5, 100.0)
    assert np.array_equal(rows.a.velocity[2], rough.a.velocity)


def test_swept_volumes_are_where_a_sweep_can_meet() -> None:
    rng = np.random.default_rng(13)
    for kind in (FlatPoint, Disc, Segment, Rectangle, ConvexPolygon):
        shape, way = some(kind, rng), FlatTranslation(rng.normal(size=2))
        volume = refimpl.swept(shape, way)
        for n in rng.normal(size=(10, 2)):
            reach = volume.support(n) if isinstance(volume, refimpl.SweptShape) else refimpl.support(volume, n)
            points, radius = flat_truth.corners(shape)
            places = np.array([[float(c) for c in p] for p in points])
            ends = [n @ place + t * (n @ way.vector) for place in places for t in (0, 1)]
            assert reach == pytest.approx(max(ends) + float(radius) * float(np.hypot(*n)), abs=1e-14)


def test_contacts_of_flat_proxies_are_one_or_none() -> None:
    a, b = Disc((0, 0), 1), Rectangle((0.5, -1), (2, 1))
    found = refimpl.contacts(a, b)
    assert len(found) == 1
    assert found.depth_interval.tolist() == [0.5, 0.5]
    assert np.array_equal(found.pairs.normal[0], found.separation.normal)
    assert len(refimpl.contacts(a, b.translated((5, 0)))) == 0
