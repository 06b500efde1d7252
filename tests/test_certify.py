"""Certificates of every pair in both orders: narrow, true against 60 digits, in plain numbers, fit to be sent."""

from __future__ import annotations

import ast
import json
import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp, mpf  # type: ignore[import-untyped]

from oracles.regimes import REGIMES
from refimpl import proof
from refimpl.proof import (
    Certificate,
    Common,
    Core,
    Escape,
    InvalidCertificate,
    Near,
    Separated,
    certify,
    check,
    from_json,
    to_json,
)
from refimpl.proof.certify import mirrored, round_down, round_up
from refimpl.proof.points import root
from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Point, Proxy, Ray, ShapeError, Sphere
from tests.conftest import effort, scenes_of
from tests.truth import ray_interval, signed_distance

INF = math.inf
TYPES = (Point, Sphere, Capsule, HalfSpace, AABB, Box)
PAIRS = [(A, B) for A in TYPES for B in TYPES]
SOLIDS = TYPES[1:]
CUBE = AABB((-1, -1, -1), (1, 1, 1))
NO_TURN, TURN = (0, 0, 0, 1), (0, 0, 1, 2)
WIDTH = 1e-14
"""Widest interval allowed, relative to the scene; a hundredth of what is asked for."""


def real(x: Any) -> mpf:
    return mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mpf(x)


def close_enough(lower: Any, upper: Any, truth: mpf, size: float) -> None:
    """Assert that an interval holds the truth, known to 58 digits, and is narrow."""
    with mp.workdps(80):
        if mp.isinf(truth):
            assert lower == upper == truth
            return
        slack = abs(truth) * mpf(10) ** -55
        assert real(lower) - slack <= truth <= real(upper) + slack
        assert real(upper) - real(lower) <= WIDTH * max(mpf(size), abs(truth))
        if truth == 0:
            assert lower == upper == 0


def proven(a: Proxy, b: Proxy) -> Certificate:
    """Check the certificate of a pair against the truth, in the order given."""
    certificate = certify(a, b)
    lower, upper = check(certificate, a, b)
    assert certificate.lower == round_down(lower)
    assert certificate.upper == round_up(upper)
    if not isinstance(a, Ray) and not isinstance(b, Ray):
        close_enough(lower, upper, signed_distance(a, b), max(float(a.magnitude), float(b.magnitude)))
        return certificate
    ray, solid = (a, b) if isinstance(a, Ray) else (b, a)
    assert isinstance(ray, Ray)
    times = ray_interval(ray, solid)
    close_enough(lower, upper, mpf("inf") if times is None else times[0], 0.0)
    return certificate


# ---- the truth, over all regimes ---------------------------------------------------------------------------


@pytest.mark.parametrize(("A", "B"), PAIRS[1:], ids=lambda kind: kind.__name__)
def test_certificates_enclose_the_truth_in_every_regime(A: type[Proxy], B: type[Proxy]) -> None:
    signs = set()
    for regime in REGIMES:
        a, b = scenes_of((A, B), regime, max(4, effort() // 2))
        for i in range(len(a)):
            signs.add(proven(a[i], b[i]).upper > 0)
    assert signs == {False, True}


@pytest.mark.parametrize("B", SOLIDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("ray_first", [True, False])
def test_ray_certificates_enclose_the_truth_in_every_regime(B: type[Proxy], ray_first: bool) -> None:
    ends = set()
    for regime in REGIMES:
        ray, b = scenes_of((Ray, B), regime, max(4, effort() // 2))
        for i in range(len(ray)):
            certificate = proven(ray[i], b[i]) if ray_first else proven(b[i], ray[i])
            ends.add({0.0: "inside", INF: "missed"}.get(float(certificate.upper), "hit"))
    assert ends == {"inside", "hit", "missed"}


# ---- adversarial scenes ------------------------------------------------------------------------------------

NUMBERS = st.one_of(
    st.integers(-4, 4).map(float),
    st.integers(-8, 8).map(lambda i: i / 4),
    st.sampled_from([0.1, 1 / 3, -0.3, math.sqrt(2), 1e6, 1e-9, 1e9, -1e-16, math.nextafter(1.0, 2.0)]),
    st.floats(-1e9, 1e9, allow_subnormal=False),
)
SIZES = NUMBERS.map(abs)
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)
WAYS = VECTORS.filter(any)
SCENERY: dict[type[Proxy], st.SearchStrategy[Any]] = {
    Point: st.builds(Point, VECTORS),
    Ray: st.builds(Ray, VECTORS, WAYS),
    Sphere: st.builds(Sphere, VECTORS, SIZES.filter(bool)),
    Capsule: st.one_of(
        st.builds(Capsule, VECTORS, VECTORS, SIZES), st.builds(lambda p, r: Capsule(p, p, r), VECTORS, SIZES)
    ),
    HalfSpace: st.builds(HalfSpace, WAYS, NUMBERS),
    AABB: st.builds(lambda p, q: AABB(np.minimum(p, q), np.maximum(p, q)), VECTORS, VECTORS),
    Box: st.builds(
        Box,
        VECTORS,
        st.tuples(SIZES, SIZES, SIZES),
        st.one_of(st.just(NO_TURN), st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS).filter(any)),
    ),
}


@pytest.mark.parametrize(("A", "B"), PAIRS[::2] + PAIRS[1::2], ids=lambda kind: kind.__name__)
@given(data=st.data())
def test_adversarial_scenes(A: type[Proxy], B: type[Proxy], data: Any) -> None:
    try:
        a, b = data.draw(SCENERY[A]), data.draw(SCENERY[B])
    except ShapeError:
        assume(False)
    there, back = proven(a, b), proven(b, a)
    assert there.lower <= back.upper
    assert back.lower <= there.upper


@pytest.mark.parametrize("B", SOLIDS, ids=lambda kind: kind.__name__)
@given(data=st.data())
def test_adversarial_rays(B: type[Proxy], data: Any) -> None:
    try:
        ray, b = data.draw(SCENERY[Ray]), data.draw(SCENERY[B])
    except ShapeError:
        assume(False)
    there, back = proven(ray, b), proven(b, ray)
    assert (there.lower, there.upper) == (back.lower, back.upper)


# ---- hard cases with known answers -------------------------------------------------------------------------

HARD = {
    "equal points": (Point((1e6, 0.1, 3)), Point((1e6, 0.1, 3)), 0),
    "equal boxes": (Box((0.1, 0.2, 0.3), (1, 2, 3), NO_TURN), Box((0.1, 0.2, 0.3), (1, 2, 3), NO_TURN), -2),
    "equal cubes": (CUBE, CUBE, -2),
    "cube in cube": (CUBE, AABB((-9, -9, -9), (9, 9, 9)), -10),
    "boxes face to face": (CUBE, AABB((1, 0.5, -7), (4, 1.5, 7)), 0),
    "boxes edge to edge": (CUBE, AABB((1, 1, -1), (4, 4, 4)), 0),
    "boxes corner to corner": (CUBE, AABB((1, 1, 1), (4, 4, 4)), 0),
    "boxes edge across edge": (
        Box((3, 0, 0), (1, 5, 1), (0, 1, 0, 0)),
        Box((5, 0, 0), (1, 1, 5), (3, 0, 0, 3)),
        0,
    ),
    "turned box at a face": (CUBE, Box((8, 0, 0), (5, 5, 5), TURN), 0),
    "turned box in a face": (CUBE, Box((7.5, 0, 0), (5, 5, 5), TURN), -0.4),
    "flat boxes crossing": (Box((0, 0, 0), (5, 0, 0), NO_TURN), Box((1, 0, 0), (0, 5, 5), NO_TURN), -4),
    "flat boxes in a plane": (Box((0, 0, 0), (5, 5, 0), NO_TURN), Box((1, 0, 0), (3, 5, 0), TURN), 0),
    "point boxes": (Box((1, 2, 3), (0, 0, 0), TURN), AABB((1, 2, 3), (1, 2, 3)), 0),
    "point in a flat box": (Point((0.5, 0.25, 0)), AABB((-1, -1, 0), (1, 1, 0)), 0),
    "concentric spheres": (Sphere((0.1, 0.2, 0.3), 3), Sphere((0.1, 0.2, 0.3), 1e-9), -3 - 1e-9),
    "spheres touching": (Sphere((0, 0, 0), 2), Sphere((2, 3, 6), 5), 0),
    "spheres touching within": (Sphere((0, 0, 0), 7), Sphere((2, 3, 6), 1e-3), -1e-3),
    "tiny spheres apart": (Sphere((0, 0, 0), 1e-9), Sphere((3e9, 4e9, 0), 1e-9), 5e9 - 2e-9),
    "segments crossing": (Capsule((-1, 0, 0), (1, 0, 0), 0), Capsule((0, -1, 0), (0, 1, 0), 0), 0),
    "capsules crossing": (Capsule((-1, 0, 0), (1, 0, 0), 1), Capsule((0, -1, 0), (0, 1, 0), 2), -3),
    "segments on a line": (Capsule((0, 0, 0), (3, 6, 9), 0), Capsule((1, 2, 3), (5, 10, 15), 0), 0),
    "capsules side by side": (Capsule((0, 0, 0), (8, 0, 0), 0.5), Capsule((4, 3, 4), (20, 3, 4), 0.25), 4.25),
    "zero-length capsules": (Capsule((1, 1, 1), (1, 1, 1), 1), Capsule((1, 3, 1), (1, 3, 1), 1), 0),
    "capsule through a box": (Capsule((-9, 0, 0), (9, 0, 0), 0.5), CUBE, -1.5),
    "segment on an edge": (Capsule((-9, 1, 1), (9, 1, 1), 0), CUBE, 0),
    "segment in a face": (Capsule((0, 1, 0), (0, 1, 0.5), 0), CUBE, 0),
    "sphere on a corner": (Sphere((2, 3, 3), 3), CUBE, 0),
    "sphere at a face's inside": (Sphere((1, 0, 0), 2), CUBE, -2),
    "half-space under a corner": (HalfSpace((2, 3, 6), 11), CUBE, 0),
    "half-space in a sphere": (HalfSpace((2, 3, 6), -7), Sphere((0, 0, 0), 1), -2),
    "half-space with a long normal": (HalfSpace((2e300, 3e300, 6e300), 14e300), Point((0, 0, 0)), 2),
    "half-space with a short normal": (HalfSpace((2e-300, 3e-300, 6e-300), 14e-300), Point((0, 0, 0)), 2),
    "opposite half-spaces": (HalfSpace((0.25, 0.5, 1), 0), HalfSpace((-0.5, -1, -2), 0), 0),
    "half-spaces apart": (HalfSpace((0, 3, 4), 5), HalfSpace((0, -6, -8), 20), 3),
    "half-spaces overlapping": (HalfSpace((0, 3, 4), -5), HalfSpace((0, -6, -8), -20), -3),
    "nearly opposite half-spaces": (HalfSpace((0, 0, 1), 0), HalfSpace((1e-300, 0, -1), 9), -INF),
    "same half-space": (HalfSpace((1, 2, 3), 4), HalfSpace((1, 2, 3), 4), -INF),
    "far and small": (Box((1e6, 1e6, 1e6), (1e-3, 1e-3, 1e-3), NO_TURN), Point((1e6, 1e6, 1e6)), -1e-3),
    "huge and tiny": (AABB((-1e9, -1e9, -1e9), (1e9, 1e9, 1e9)), Sphere((0, 0, 1e9), 1e-9), -1e-9),
}


@pytest.mark.parametrize("name", HARD)
@pytest.mark.parametrize("swap", [False, True])
def test_hard_cases(name: str, swap: bool) -> None:
    a, b, sigma = HARD[name]
    certificate = proven(b, a) if swap else proven(a, b)
    if math.isfinite(sigma):
        size = max(float(a.magnitude), float(b.magnitude), abs(sigma))
        assert certificate.lower - 1e-15 * size <= sigma <= certificate.upper + 1e-15 * size
    else:
        assert certificate.lower == certificate.upper == sigma


RAYS = {
    "into a face": (Ray((-4, 0, 0), (2, 0, 0)), CUBE, 1.5),
    "into a corner": (Ray((-2, -2, -2), (0.5, 0.5, 0.5)), CUBE, 2),
    "along an edge": (Ray((-3, 1, 1), (1, 0, 0)), CUBE, 2),
    "past an edge": (Ray((-3, math.nextafter(1, 2), 1), (1, 0, 0)), CUBE, INF),
    "over an edge": (Ray((-2, 0, 0), (1, 1, 0)), CUBE, 1),
    "on a face, outwards": (Ray((1, 0, 0), (1, 0, 0)), CUBE, 0),
    "beside, away": (Ray((2, 0, 0), (1, 0, 0)), CUBE, INF),
    "grazing a sphere": (Ray((-5, 1, 0), (1, 0, 0)), Sphere((0, 0, 0), 1), 5),
    "missing it by a bit": (Ray((-5, math.nextafter(1, 2), 0), (1, 0, 0)), Sphere((0, 0, 0), 1), INF),
    "along a capsule's side": (Ray((-5, 2, 0), (1, 0, 0)), Capsule((-1, 0, 0), (1, 0, 0), 2), 4),
    "along its axis": (Ray((-5, 0, 0), (0.5, 0, 0)), Capsule((-1, 0, 0), (1, 0, 0), 1), 6),
    "across its side": (Ray((0, 5, 0), (0, -1, 0)), Capsule((-1, 0, 0), (1, 0, 0), 2), 3),
    "to a segment": (Ray((0, 5, 0), (0, -2, 0)), Capsule((-1, 0, 0), (1, 0, 0), 0), 2.5),
    "past a segment": (Ray((0, 5, 1e-300), (0, -2, 0)), Capsule((-1, 0, 0), (1, 0, 0), 0), INF),
    "along a segment": (Ray((-5, 0, 0), (2, 0, 0)), Capsule((-1, 0, 0), (1, 0, 0), 0), 2),
    "to a flat box": (Ray((0, 0, 3), (0, 0, -0.5)), AABB((-1, -1, 0), (1, 1, 0)), 6),
    "along a flat box": (Ray((-3, 0, 0), (1, 0, 0)), AABB((-1, -1, 0), (1, 1, 0)), 2),
    "to a plane": (Ray((0, 0, 9), (0, 0, -3)), HalfSpace((0, 0, 7), 0), 3),
    "along a plane, above": (Ray((0, 0, 1e-300), (1, 0, 0)), HalfSpace((0, 0, 7), 0), INF),
    "along a plane, in it": (Ray((0, 0, 0), (1, 0, 0)), HalfSpace((0, 0, 7), 0), 0),
    "nearly along a plane": (Ray((0, 0, 1), (1, 0, -1e-300)), HalfSpace((0, 0, 7), 0), 1e300),
    "beyond all doubles": (Ray((0, 0, 1e200), (1, 0, -1e-200)), HalfSpace((0, 0, 7), 0), None),
    "from far away": (Ray((-1e9, 0.5e-9, 0), (1, 0, 0)), Sphere((0, 0, 0), 1e-9), None),
    "slowly": (Ray((-4, 0, 0), (5e-324, 0, 0)), Sphere((0, 0, 0), 1), None),
}


@pytest.mark.parametrize("name", RAYS)
@pytest.mark.parametrize("swap", [False, True])
def test_hard_rays(name: str, swap: bool) -> None:
    ray, solid, time = RAYS[name]
    certificate = proven(solid, ray) if swap else proven(ray, solid)
    if time is not None:
        assert certificate.lower <= time <= certificate.upper
    if time in (0, INF):
        assert certificate.lower == certificate.upper


def test_a_ray_to_a_point_is_timed_as_well() -> None:
    certificate = certify(Ray((0, 0, 0), (1, 2, 3)), Point((2, 4, 6)))
    assert certificate.lower <= 2 <= certificate.upper <= math.nextafter(2, 3)
    assert certify(Point((2, 4, 6.5)), Ray((0, 0, 0), (1, 2, 3))).lower == INF


# ---- the numbers of a certificate --------------------------------------------------------------------------


def numbers(value: Any) -> list[Any]:
    """Every number of a certificate's claims."""
    if isinstance(value, tuple | list):
        return [x for v in value for x in numbers(v)]
    return numbers(list(vars(value).values())) if hasattr(value, "__dataclass_fields__") else [value]


def test_certificates_of_ordinary_scenes_are_plain_doubles() -> None:
    plain = total = 0
    for A, B in PAIRS[1:]:
        if A is B is HalfSpace:  # directions of half-spaces have to be exact
            continue
        a, b = scenes_of((A, B), "generic", 8)
        for i in range(len(a)):
            found = numbers(certify(a[i], b[i]).claims)
            assert not any(isinstance(x, np.generic) for x in found)
            plain += not any(isinstance(x, Fraction) for x in found)
            total += 1
    assert plain >= 0.95 * total


def test_exact_numbers_stand_in_where_doubles_do_not_tell() -> None:
    ball = Sphere((0, 0, 0), 1)  # touches the plane in (−3/5, −4/5, 0)
    touching, overlapping = certify(ball, HalfSpace((3, 4, 0), 5)), certify(ball, HalfSpace((3, 4, 0), 4))
    assert touching.lower == touching.upper == 0
    assert any(isinstance(x, Fraction) for x in numbers(touching.claims))
    assert not any(isinstance(x, Fraction) for x in numbers(overlapping.claims))


def test_claims_fit_the_sign() -> None:
    kinds = {
        (Separated, Near): (CUBE, Sphere((4, 0, 0), 1)),
        (Escape, Common): (CUBE, AABB((1, 1, 1), (2, 2, 2))),
        (Escape, Core): (CUBE, Sphere((0.5, 0, 0), 1)),
        (Core,): (HalfSpace((0, 0, 1), 0), HalfSpace((1, 0, 0), 0)),
        (Separated,): (Ray((3, 0, 0), (0, 1, 0)), CUBE),
        (Separated, Common): (Ray((3, 0, 0), (-1, 0, 0)), CUBE),
        (Common,): (Ray((0, 0, 0), (-1, 0, 0)), CUBE),
    }
    for expected, (a, b) in kinds.items():
        for certificate in (certify(a, b), certify(b, a)):
            assert tuple(type(claim) for claim in certificate.claims) == expected


def test_mirrored_certificates_hold_for_the_other_order() -> None:
    for A, B in [*PAIRS[1:], *((Ray, B) for B in SOLIDS)]:
        a, b = scenes_of((A, B), "deep", 4)
        for i in range(len(a)):
            certificate = certify(a[i], b[i])
            assert check(mirrored(certificate), b[i], a[i]) == check(certificate, a[i], b[i])
            assert mirrored(mirrored(certificate)) == certificate


@given(st.one_of(st.fractions(), st.floats(allow_nan=False), st.just(Fraction(10) ** 400)))
def test_bounds_are_rounded_outwards(bound: Fraction | float) -> None:
    low, high = round_down(bound), round_up(bound)
    assert low <= bound <= high
    assert high in (low, math.nextafter(low, INF))
    assert round_down(-bound) == -high


@given(st.fractions(0), st.integers(8, 300))
def test_roots_are_enclosed(square: Fraction, bits: int) -> None:
    low, high = root(square, bits)
    assert low**2 <= square <= high**2
    assert (high - low) * 2 ** (bits - 2) <= high
    assert root(square**2) == (square, square)


# ---- the search stands on its own --------------------------------------------------------------------------


def test_the_search_and_the_reference_meet_in_few_places() -> None:
    """What the reference answers is one proposal among others (`convex.reference`, and where a sweep may meet): nothing
    is believed that is not checked, so a wrong answer costs width, never truth. The exact searches and the checker
    know nothing of it.
    """
    flat = tuple(f"refimpl.flat.{name}" for name in ("base", "shapes", "polygon", "corners"))  # no algorithm of a pair
    own = ("refimpl.proof", "refimpl.shapes", "refimpl.linear", *flat)
    moving = {"refimpl.queries", "refimpl.motions", "refimpl.atoms", "refimpl.pairs", "refimpl.sweeps"}
    asking = {"convex.py": {"refimpl.queries"}}
    asking |= dict.fromkeys(("sweep_search.py", "sweep_unions.py", "rigid_search.py"), moving)
    floats = {"atoms.py", "bodies.py", "inscribed.py", "planes.py", "solids.py", "union_cast.py", "union_search.py"}
    floats |= {"rigid_bodies.py", *asking} - {"convex.py"}
    for path in Path(proof.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("refimpl"):
                room = ".".join(str(node.module).split(".")[:2])
                assert str(node.module).startswith(own) or room in asking.get(path.name, set()), (path, node.module)
                assert node.module != "refimpl.linear" or path.name in floats
            elif isinstance(node, ast.Import):
                assert not any(alias.name.startswith("refimpl") for alias in node.names)
                assert path.name in floats or not any(alias.name.startswith("numpy") for alias in node.names)


def test_what_cannot_be_certified_says_so() -> None:
    with pytest.raises(ValueError, match="single"):
        certify(Sphere(np.zeros((2, 3)), 1), CUBE)
    with pytest.raises(TypeError, match="two rays"):
        certify(Ray((0, 0, 0), (1, 0, 0)), Ray((0, 0, 0), (1, 0, 0)))
    with pytest.raises(TypeError, match="two proxies"):
        certify(CUBE, 3)  # type: ignore[arg-type]


# ---- certificates on the wire ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*HARD, *RAYS])
def test_certificates_survive_json(name: str) -> None:
    a, b, _ = HARD.get(name) or RAYS[name]
    certificate = certify(a, b)
    text = json.dumps(to_json(certificate), allow_nan=False)
    back = from_json(json.loads(text))
    assert back == certificate
    assert [type(x) for x in numbers(back.claims)] == [type(x) for x in numbers(certificate.claims)]
    assert check(back, a, b) == check(certificate, a, b)


def test_long_rationals_survive_json() -> None:
    long = Fraction(10**9000 + 1, 3**9000)
    certificate = Certificate((Escape((long, -long, 2**80)),), -INF, Fraction(1, 3))
    back = from_json(json.loads(json.dumps(to_json(certificate))))
    assert numbers(back.claims) == [long, -long, 2**80]
    assert (back.lower, back.upper) == (-INF, Fraction(1, 3))


GOOD = to_json(certify(CUBE, Sphere((0.5, 0, 0), 1)))
BAD_JSON: list[Any] = [
    None,
    [],
    "certificate",
    {},
    {"claims": {}},
    {"claims": [], "extra": 1},
    {"claims": [], "lower": "nan"},
    {"claims": [], "upper": math.nan},
    {"claims": [], "upper": True},
    {"claims": [], "upper": [1]},
    {"claims": [3]},
    {"claims": [{"kind": "sure"}]},
    {"claims": [{"kind": ["near"]}]},
    {"claims": [{"kind": "near", "a": [0, 0, 0]}]},
    {"claims": [{"kind": "near", "a": [0, 0, 0], "b": [0, 0]}]},
    {"claims": [{"kind": "escape", "n": [0, 0, 1], "m": 1}]},
    {"claims": [{"kind": "escape", "n": [0, 0, None]}]},
    {"claims": [{"kind": "escape", "n": [0, 0, True]}]},
    {"claims": [{"kind": "escape", "n": [0, 0, INF]}]},
    *(
        {"claims": [{"kind": "escape", "n": [0, 0, text]}]}
        for text in (
            "1/0",
            "1/-2",
            "1.5",
            "one",
            "1/2/3",
            "",
            "/2",
            " 1",
            "1_0",
            "007",
            "٣",
            "1" * 5000,
            "0x",
        )
    ),
    {"claims": [{"kind": "escape", "n": [0, 0, "0x" + "f" * 200_000]}]},
    {"claims": [{"kind": "common", "p": "0"}]},
    {"claims": [{"kind": "core", "pairs": [], "triangles": [], "directions": 1}]},
    {"claims": [{"kind": "core", "pairs": [], "triangles": [[0, 1]], "directions": False}]},
    {"claims": [{"kind": "core", "pairs": [], "triangles": [[0, 1, 2.0]], "directions": False}]},
    {"claims": [{"kind": "core", "pairs": [[[0, 0, 0]]], "triangles": [], "directions": False}]},
    {"claims": GOOD["claims"] * 40_000},
]


@pytest.mark.parametrize("data", BAD_JSON, ids=range(len(BAD_JSON)))
def test_malformed_json_is_refused(data: Any) -> None:
    with pytest.raises(InvalidCertificate):
        from_json(data)
