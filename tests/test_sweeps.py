"""Sweeps in translation: against roots to 50 digits, ray casts, fine steps, and the laws that times of contact obey."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refimpl import (
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
    ShapeError,
    Sphere,
    Translation,
    UnsupportedOperation,
    distance,
    raycast,
    support,
    sweep,
    swept,
)
from refimpl.pairs import TABLE
from refimpl.proof import InvalidCertificate, Meets, Separated, SweepCertificate, certify_sweep, check_sweep
from refimpl.proof.sweeps import Clear
from refimpl.proof.wire import sweep_certificate_from_json, sweep_certificate_to_json
from refimpl.proxy import Proxy
from refimpl.sweeps import SweptShape
from refimpl.sweeps.methods import methods_of
from reports.vs import as_markdown
from tests.solids import L_SHAPE, prism

RNG = np.random.default_rng(20)
TURNED = (0.1, 0.2, 0.3, 1.0)
CLOUD = RNG.normal(size=(9, 3))
SOLIDS: list[Proxy] = [
    Sphere((0.1, 0.0, 0.2), 0.8),
    Capsule((-0.5, 0.0, 0.0), (0.6, 0.3, 0.1), 0.4),
    HalfSpace((1.0, 0.2, -0.1), 0.3),
    AABB((-0.5, -0.6, -0.7), (0.4, 0.5, 0.6)),
    Box((0.0, 0.1, 0.0), (0.5, 0.7, 0.3), TURNED),
    KDOP.around(CLOUD, 14),
    Ellipsoid((0.0, 0.0, 0.1), (0.5, 0.9, 0.7), TURNED),
    Cylinder((0.0, -0.5, 0.0), (0.2, 0.6, 0.1), 0.4),
    ConvexPolyhedron.from_vertices(0.6 * CLOUD),
    Polyhedron(*prism(L_SHAPE), (-0.8, -0.7, -0.4), TURNED),
    Composite([Sphere((0.6, 0.0, 0.0), 0.4), Box((-0.3, 0.0, 0.0), (0.6, 0.2, 0.3), TURNED)]),
]
KINDS = [*SOLIDS, Point((0.1, 0.2, 0.3))]
PAIRS = [(a, b) for i, a in enumerate(KINDS) for b in SOLIDS[: i + 1]]
NAMES = [f"{type(a).__name__}-{type(b).__name__}" for a, b in PAIRS]
FROM = np.array([-5.0, 1.0, 0.5])
WAY = np.array([8.0, -1.5, -0.9])


def apart(pair: tuple[Any, Any]) -> tuple[Proxy, Proxy, Translation]:
    """The first of a pair moved away, and a way on which it comes back."""
    a, b = pair
    way = WAY
    if isinstance(a, HalfSpace) and not isinstance(b, HalfSpace):
        return a.translated(FROM), b, Translation(WAY)
    if isinstance(a, HalfSpace):
        return HalfSpace(-a.normal, 2.0), b, Translation(-3.0 * a.normal)
    if isinstance(b, HalfSpace):
        return a.translated(-FROM), b, Translation(-WAY)
    return a.translated(FROM), b, Translation(way)


@pytest.fixture(scope="module")
def proofs() -> dict[str, tuple[Proxy, Proxy, Translation, SweepCertificate]]:
    """A certificate of each pair of types."""
    found = {}
    for name, pair in zip(NAMES, PAIRS, strict=True):
        a, b, motion = apart(pair)
        found[name] = a, b, motion, certify_sweep(a, b, motion)
    return found


@pytest.mark.parametrize("name", NAMES)
def test_the_time_lies_in_a_narrow_proof(name: str, proofs: dict[str, Any]) -> None:
    a, b, motion, proof = proofs[name]
    lower, upper = check_sweep(proof, a, b, motion)
    assert 0 < lower <= upper < 1, "the scenes are made to meet on the way"
    assert upper - lower <= 1e-12
    assert proof.lower <= lower <= upper <= proof.upper
    for found, sign in ((sweep(a, b, motion), 1.0), (sweep(b, a, None, motion), -1.0)):
        assert found.hit
        assert lower - 1e-13 <= found.t <= upper + 1e-13
        assert found.t_lower <= upper
        assert abs(np.linalg.norm(found.normal) - 1) < 1e-14
        assert sign * found.normal @ motion.vector > 0, "they come nearer across the normal"
    read = sweep_certificate_from_json(json.loads(json.dumps(sweep_certificate_to_json(proof))))
    assert read == proof


@pytest.mark.parametrize("name", NAMES)
def test_contact_is_where_and_when_static_detection_finds_it(name: str, proofs: dict[str, Any]) -> None:
    """Just before they are apart, just after they overlap, at the contact the point is on both."""
    a, b, motion, proof = proofs[name]
    found = sweep(a, b, motion)
    size = 20.0
    for share in (0.2, 0.6, 0.95, 1 - 1e-6):
        assert distance(motion.placed(a, share * proof.lower), b).distance > 0
    later = distance(motion.placed(a, found.t + 1e-4), b).distance
    assert later < 0 or name == "Point-Point"
    if not {"Point"} & set(name.split("-")):
        assert abs(distance(Point(found.point), b).distance) < 1e-12 * size
        assert abs(distance(Point(found.point), motion.placed(a, found.t)).distance) < 1e-12 * size


@pytest.mark.parametrize("name", NAMES)
def test_tampered_proofs_are_refused(name: str, proofs: dict[str, Any]) -> None:
    a, b, motion, proof = proofs[name]
    clear, meets = proof.claims
    assert isinstance(clear, Clear)
    assert isinstance(meets, Meets)
    late = Fraction(clear.until) + Fraction(1, 1000)
    early = Fraction(meets.time) - Fraction(1, 1 << 60)
    wrong: list[Any] = [
        replace(clear, until=late),
        replace(clear, until=None),
        replace(meets, time=early),
        replace(meets, time=2),
        replace(meets, a=meets.b, b=meets.a) if meets.a != meets.b else replace(meets, time=-1),
        Separated((1.0, 0.0, 0.0)),
    ]
    if isinstance(clear.tree, Separated):
        wrong.append(replace(clear, tree=replace(clear.tree, n=tuple(-c for c in clear.tree.n))))
    for claim in wrong:
        with pytest.raises(InvalidCertificate):
            check_sweep(SweepCertificate((claim,)), a, b, motion)
    with pytest.raises(InvalidCertificate):
        check_sweep(proof, a, b, Translation(-motion.vector))


@pytest.mark.parametrize("name", NAMES)
def test_a_miss_is_proven(name: str) -> None:
    """Moving away, standing still, and stopping short."""
    a, b, motion = apart(PAIRS[NAMES.index(name)])
    for way in (-1.0 * motion.vector, 0.0 * motion.vector, 0.1 * motion.vector):
        assert not sweep(a, b, Translation(way)).hit
        proof = certify_sweep(a, b, Translation(way))
        assert check_sweep(proof, a, b, Translation(way)) == (math.inf, math.inf)


@pytest.mark.parametrize("pair", PAIRS[:: len(PAIRS) // 12], ids=NAMES[:: len(PAIRS) // 12])
def test_rows_of_a_batch_are_the_pairs_alone(pair: tuple[Any, Any]) -> None:
    a, b, motion = apart(pair)
    ways = motion.vector * np.array([[1.0], [0.7], [-1.0], [0.0], [1.1]]) + 0.1 * RNG.normal(size=(5, 3))
    together = sweep(a, b, Translation(ways))
    assert together.hit[0]
    assert not together.hit[2]
    for i, way in enumerate(ways):
        alone = sweep(a, b, Translation(way))
        for name in ("hit", "t", "point", "normal", "t_lower"):
            assert np.array_equal(getattr(alone, name), getattr(together, name)[i], equal_nan=name != "hit")


# ------------------------------------------------------------------------------------ closed forms

NUMBERS = st.floats(-4.0, 4.0).map(lambda x: round(x, 3))
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)


@settings(max_examples=15)
@given(start=VECTORS, way_a=VECTORS, way_b=VECTORS, radius=st.floats(0.1, 2.0))
def test_spheres_against_the_root_to_50_digits(start: Any, way_a: Any, way_b: Any, radius: float) -> None:
    a, b = Sphere(start, radius), Sphere((0.0, 0.0, 0.0), 0.5)
    with mpmath.workdps(50):
        offset = [mpmath.mpf(c) for c in start]
        way = [mpmath.mpf(u) - mpmath.mpf(v) for u, v in zip(way_a, way_b, strict=True)]
        reach = mpmath.mpf(radius) + mpmath.mpf("0.5")
        p, q, r = (mpmath.fdot(u, v) for u, v in ((way, way), (way, offset), (offset, offset)))
        room, inside = q * q - p * (r - reach**2), r <= reach**2
        first = 0 if inside else (-q - mpmath.sqrt(room)) / p if p and room >= 0 and q < 0 else mpmath.inf
        first = first if first <= 1 else mpmath.inf
    proof = certify_sweep(a, b, Translation(way_a), Translation(way_b))
    assert proof.lower <= first <= proof.upper
    assert proof.lower == math.inf or proof.upper - proof.lower <= 1e-12
    assert sweep(a, b, Translation(way_a), Translation(way_b)).hit == (first <= 1)


@settings(max_examples=10)
@given(origin=VECTORS, way=VECTORS.filter(any), index=st.integers(0, len(SOLIDS) - 1))
def test_a_point_is_a_ray(origin: Any, way: Any, index: int) -> None:
    solid = SOLIDS[index]
    cast = raycast(Ray(origin, way), solid)
    found = sweep(Point(origin), solid, Translation(way))
    assert found.hit == (cast.t <= 1)
    if found.hit:
        assert abs(found.t - cast.t) <= 1e-9 * (1 + cast.t)


GRAZES: list[tuple[Proxy, Proxy, Any, float]] = [
    (Sphere((0, 0, 0), 1.0), Sphere((3, 2, 0), 1.0), (4, 0, 0), 0.75),
    (Sphere((0, 0, 0), 1.0), Capsule((2, 2, -1), (2, 2, 1), 1.0), (4, 0, 0), 0.5),
    (Sphere((0, 0, 0), 1.0), AABB((2, 1, -1), (3, 2, 1)), (4, 0, 0), 0.5),
    (AABB((0, 0, 0), (1, 1, 1)), AABB((2, 1, 0), (3, 2, 1)), (4, 0, 0), 0.25),
    (Box((0, 0, 0), (1, 1, 1), (0, 0, 0, 1)), Box((4, 2, 2), (1, 1, 1), (0, 0, 0, 1)), (4, 0, 0), 0.5),
    (Point((0, 0, 0)), Sphere((2, 1, 0), 1.0), (4, 0, 0), 0.5),
    (Point((0, 0, 0)), Cylinder((2, 1, -1), (2, 1, 1), 1.0), (4, 0, 0), 0.5),
    (Cylinder((0, 0, 0), (0, 0, 1), 1.0), Cylinder((2, 2, 0), (2, 2, 1), 1.0), (4, 0, 0), 0.5),
    (Ellipsoid((0, 0, 0), (1, 1, 2), (0, 0, 0, 1)), AABB((2, 1, -1), (3, 2, 1)), (4, 0, 0), 0.5),
    (Sphere((0, 0, 3), 1.0), HalfSpace((0, 0, 1), 0.0), (0, 0, -2), 1.0),
    (Capsule((0, 0, 0), (0, 0, 1), 0.5), Capsule((2, 1, 0), (2, 1, 1), 0.5), (4, 0, 0), 0.5),
]


@pytest.mark.parametrize(("a", "b", "way", "time"), GRAZES)
def test_grazing_contact_is_contact_and_a_hair_more_is_none(a: Proxy, b: Proxy, way: Any, time: float) -> None:
    motion = Translation(way)
    found, proof = sweep(a, b, motion), certify_sweep(a, b, motion)
    assert found.hit
    assert abs(found.t - time) <= 1e-12
    assert time - 1e-12 <= proof.lower <= time <= proof.upper <= time + 1e-12
    off = np.array([0.0, 0.0, -1.0]) if isinstance(b, HalfSpace) else np.array([0.0, 1.0, 0.0])
    aside = b.translated(2.0**-40 * off)
    assert not sweep(a, aside, motion).hit
    assert certify_sweep(a, aside, motion).lower == math.inf


def test_the_contact_of_an_overlap_is_a_point_of_both() -> None:
    """Of sticks and plates too, whose witnesses lie outside the other."""
    rng = np.random.default_rng(8)
    a, b = (
        Box(rng.uniform(-1, 1, (300, 3)), np.exp(rng.uniform(-5, 1, (300, 3))), rng.normal(size=(300, 4))) for _ in "ab"
    )
    found = sweep(a, b)
    overlap = distance(a, b)
    there = np.flatnonzero(overlap.distance < 0)
    outside = [distance(Point(overlap.on_a), b).distance, distance(Point(overlap.on_b), a).distance]
    assert (np.max(outside, axis=0)[there] > 0.1).sum() > 5
    for solid in (a, b):
        assert distance(Point(found.point[there]), solid[there]).distance.max() < 1e-14


def test_what_overlaps_from_the_start_meets_at_0() -> None:
    for a, b in PAIRS[::7]:
        found, proof = sweep(a, b, Translation(WAY)), certify_sweep(a, b, Translation(WAY))
        if distance(a, b).distance < 0:
            assert (found.t, proof.lower, proof.upper) == (0.0, 0.0, 0.0)
            assert np.all(np.isnan(found.normal))


TOUCHING: list[tuple[Proxy, Proxy]] = [
    (Box((-3, 3, 0.5), (2, 1.5, 0.25), (0, 1, 0, 1)), Cylinder((-1.75, 1.5, 1), (-1.75, 1, 1), 1.0)),
    (Sphere((0, 0, 0), 1.0), Box((2, 0, 0), (1, 1, 1), (0, 0, 0, 1))),
    (
        AABB((0, 0, 0), (1, 1, 1)),
        ConvexPolyhedron.from_vertices(np.array([[1, 1, 1], [2, 1, 1], [1, 2, 1], [1, 1, 2]])),
    ),
    (Polyhedron(*prism(L_SHAPE)), Sphere((3.0, 0.5, 0.5), 1.0)),
    (Polyhedron(*prism(L_SHAPE)), Point((2.0, 0.25, 0.5))),
    (HalfSpace((0, 0, 1), 0.0), Ellipsoid((0, 0, 2), (1, 1, 2), (0, 0, 0, 1))),
]


@pytest.mark.parametrize(("a", "b"), TOUCHING)
def test_what_touches_at_the_start_meets_there_whatever_the_way(a: Proxy, b: Proxy) -> None:
    for way in ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.5, 0.0)):
        assert sweep(a, b, None, Translation(way)).t == 0.0
        assert certify_sweep(a, b, None, Translation(way)).upper == 0.0


def test_motions_that_doubles_cannot_subtract_are_taken_as_they_are() -> None:
    """v_B − v_A rounds to 1e16, which is 1 too little; the proof knows of that."""
    a, b = Sphere((0.0, 0.0, 0.0), 1.0), Sphere((1e16, 0.0, 0.0), 1.0)
    proof = certify_sweep(a, b, Translation((1e16, 0.0, 0.0)), Translation((1.0, 0.0, 0.0)))
    exact = Fraction(10**16 - 2, 10**16 - 1)
    lower, upper = check_sweep(proof, a, b, Translation((1e16, 0.0, 0.0)), Translation((1.0, 0.0, 0.0)))
    assert lower <= exact == upper
    assert upper - lower < Fraction(1, 1 << 52)


# -------------------------------------------------------------------------------------------- laws

SCENES = st.tuples(st.sampled_from(range(len(PAIRS))), VECTORS, VECTORS, st.floats(0.2, 0.8))


@settings(max_examples=12)
@given(scene=SCENES)
def test_a_motion_in_two_parts_meets_when_the_whole_does(scene: Any) -> None:
    index, start, way, share = scene
    a, b = PAIRS[index]
    a = a.translated(start)
    whole = certify_sweep(a, b, Translation(way))
    first = np.array(way) * 0.5
    one = sweep(a, b, Translation(first))
    other = sweep(a.translated(first), b, Translation(first))
    t = 0.5 * one.t if one.hit else 0.5 + 0.5 * other.t
    if whole.upper <= 1 and whole.upper - whole.lower < 1e-9:
        assert abs(t - whole.upper) < 1e-6 or whole.lower == 0.0
    elif whole.lower > 1:
        assert t > 1 or distance(a.translated(t * np.array(way)), b).distance > -1e-9
    del share


@settings(max_examples=12)
@given(scene=SCENES)
def test_another_frame_changes_nothing(scene: Any) -> None:
    """Both motions plus one translation, and both proxies elsewhere."""
    index, start, way, _ = scene
    a, b = PAIRS[index]
    a = a.translated(start)
    frame, place = np.array([1.0, -2.0, 0.5]), np.array([8.0, 4.0, -2.0])
    plain = certify_sweep(a, b, Translation(way))
    other = sweep(a.translated(place), b.translated(place), Translation(np.array(way) + frame), Translation(frame))
    if plain.upper <= 1:
        assert abs(other.t - plain.upper) < 1e-6 or plain.lower == 0.0
    else:
        assert not other.hit or distance(a.translated(other.t * np.array(way)), b).distance > -1e-9


@settings(max_examples=10)
@given(scene=SCENES)
def test_backwards_in_time(scene: Any) -> None:
    """The way back, from an end at which they are apart, meets at least as late as the last time of contact."""
    index, start, way, _ = scene
    a, b = PAIRS[index]
    a = a.translated(start)
    found, end = certify_sweep(a, b, Translation(way)), a.translated(way)
    back = sweep(end, b, Translation(-np.array(way)))
    if found.upper < 1 and distance(end, b).distance > 1e-9:
        assert back.hit
        assert back.t <= 1 - found.lower + 1e-6
    if found.lower > 1 and back.hit:
        assert distance(end.translated(-back.t * np.array(way)), b).distance > -1e-9


@settings(max_examples=8)
@given(scene=SCENES)
def test_fine_steps_find_no_earlier_contact(scene: Any) -> None:
    index, start, way, _ = scene
    a, b = PAIRS[index]
    a = a.translated(start)
    t = np.linspace(0.0, 1.0, 65)
    gaps = distance(Translation(way).placed(a.broadcast_to((65,)), t), b).distance
    found = sweep(a, b, Translation(way))
    assert np.all(gaps[t < found.t - 1e-9] > -1e-12)
    if np.any(gaps < -1e-9):
        assert found.t <= t[np.argmax(gaps < -1e-9)]


# ------------------------------------------------------------------------------------ swept volumes


def test_swept_volumes() -> None:
    way = Translation((1.0, 2.0, -1.0))
    point, ball = swept(Point((1.0, 0.0, 0.0)), way), swept(Sphere((1.0, 0.0, 0.0), 0.5), way)
    assert isinstance(point, Capsule)
    assert point.radius == 0
    assert isinstance(ball, Capsule)
    assert ball.radius == 0.5
    assert isinstance(swept(AABB((0, 0, 0), (1, 1, 1)), Translation((0, -2, 0))), AABB)
    assert isinstance(swept(AABB((0, 0, 0), (1, 1, 1)), way), ConvexPolyhedron)
    assert isinstance(swept(Cylinder((0, 0, 0), (0, 0, 1), 1.0), Translation((0, 0, -3))), Cylinder)
    assert isinstance(swept(SOLIDS[6], way), SweptShape)
    for shape in KINDS:
        if isinstance(shape, HalfSpace):
            continue
        for n in RNG.normal(size=(4, 3)):
            made = swept(shape, way)
            level = max(support(shape, n), support(shape.translated(way.vector), n))
            reach = made.support(n) if isinstance(made, SweptShape) else support(made, n)
            assert abs(reach - level) < 1e-13
            if isinstance(made, SweptShape):
                assert abs(made.support_point(n) @ n - level) < 1e-13
    half = swept(HalfSpace((0.0, 0.0, 2.0), -4.0), Translation((0.0, 0.0, 3.0)))
    assert isinstance(half, HalfSpace)
    assert half.k == -10.0


def test_the_swept_volume_meets_what_the_sweep_meets() -> None:
    for pair in PAIRS[:40:3]:
        a, b, motion = apart(pair)
        for way in (motion.vector, 0.1 * motion.vector):
            volume = swept(a, Translation(way))
            if not isinstance(volume, SweptShape):
                assert (distance(volume, b).distance <= 0) == sweep(a, b, Translation(way)).hit


def test_bad_input_is_named() -> None:
    ball = Sphere((0.0, 0.0, 0.0), 1.0)
    with pytest.raises(UnsupportedOperation, match="Ray"):
        sweep(Ray((0, 0, 0), (1, 0, 0)), ball)
    with pytest.raises(UnsupportedOperation, match="Point against Point"):
        sweep(Point((0, 0, 0)), Point((0, 0, 0)))
    with pytest.raises(TypeError, match="motion"):
        sweep(ball, ball, (1.0, 0.0, 0.0))  # type: ignore[arg-type]
    with pytest.raises(ShapeError, match="broadcast"):
        sweep(ball.broadcast_to((2,)), ball, Translation(np.zeros((3, 3))))
    with pytest.raises(ShapeError, match=r"Translation\.vector"):
        Translation((0.0, np.inf, 0.0))
    with pytest.raises(ValueError, match="batches"):
        certify_sweep(ball.broadcast_to((2,)), ball)
    for data in ({"kind": "clear"}, {"kind": "sweep certificate", "claims": 3}, [], None):
        with pytest.raises(InvalidCertificate):
            sweep_certificate_from_json(data)


def test_every_pair_of_the_table_names_its_methods() -> None:
    for a, b in TABLE:
        named = methods_of(a, b)
        assert (named is None) == (a is Ray)
    assert methods_of(Sphere, HalfSpace) == ("height over speed", "conservative advancement")
    assert "translation" in as_markdown()
