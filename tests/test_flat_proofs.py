"""Certificates of the flat world: they enclose the truth narrowly, and what is false is refused."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import refimpl
from refimpl import Sphere
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatRay, FlatTranslation, Rectangle, Segment
from refimpl.proof import (
    Certificate,
    Clear,
    Common,
    Core,
    Escape,
    Inscribed,
    InvalidCertificate,
    Meets,
    Near,
    Separated,
    SweepCertificate,
    certify,
    check,
    check_sweep,
    from_json,
    to_json,
)
from tests import flat_truth
from tests.flat_scenes import REGIMES
from tests.test_flat_distances import PAIRS, true_scenes
from tests.test_flat_moving import TARGETS, rays

INF = math.inf
UNIT = Rectangle((0, 0), (1, 1))
NEAR = Rectangle((0.5, 0.25), (2, 2))
FAR = Rectangle((3, 0), (4, 1))
DISC = Disc((0, 0), 2)
TRIANGLE = ConvexPolygon([(-1, 0, 0), (0, -1, 0), (1, 1, -1)])
HULL = ConvexPolygon.from_vertices([(0, 0), (1, 0), (0, 1)])
RAY = FlatRay((-2, 0.5), (2, 0))


@pytest.mark.parametrize("pair", PAIRS, ids=lambda p: f"{p[0].__name__}-{p[1].__name__}")
def test_proofs_enclose_brute_force_narrowly(pair: Any) -> None:
    for name, a, b, true, size in true_scenes(pair):
        certificate = certify(a, b)
        lower, upper = check(certificate, a, b)
        assert flat_truth.real(Fraction(lower)) - size * 1e-40 <= true, name
        assert true <= flat_truth.real(Fraction(upper)) + size * 1e-40, name
        assert upper - lower <= 3e-15 * size, name
        assert certificate.lower <= lower <= upper <= certificate.upper
        found = float(refimpl.distance(a, b).distance)
        assert certificate.lower - 2e-15 * size <= found <= certificate.upper + 2e-15 * size


@pytest.mark.parametrize("kind", TARGETS)
def test_proofs_enclose_the_times_of_rays(kind: Any) -> None:
    for ray, b, true in rays(kind):
        lower, upper = check(certify(ray, b), ray, b)
        if true == flat_truth.inf:
            assert lower == INF
        else:
            assert float(lower) * (1 - 1e-15) <= true <= float(upper) * (1 + 1e-15)
            assert upper - lower <= 1e-14 * max(1, upper)


def test_touching_is_proven_to_the_last_bit() -> None:
    for a, b in (
        (UNIT, Rectangle((1, 1), (2, 2))),
        (Disc((0, 0), 1), Disc((4, 3), 4)),
        (HULL, ConvexPolygon.from_vertices([(0.5, 0.5), (3, 1), (1, 3)])),
        (TRIANGLE, Rectangle((0.5, 0.5), (2, 2))),
        (Segment((0, 0), (2, 2)), Segment((1, 1), (3, 3))),
    ):
        assert check(certify(a, b), a, b) == (0, 0)


@pytest.mark.parametrize(
    ("claim", "a", "b", "bounds"),
    [
        (Separated((1, 0, 0)), UNIT, FAR, (2, INF)),
        (Escape((2, 0, 0)), UNIT, NEAR, (-0.5, INF)),
        (Escape((0, 1, 0)), UNIT, NEAR, (-0.75, INF)),
        (Separated((0, 1, 0), faces=(((0, ((2, 1), (0, 1))),), ())), TRIANGLE, Disc((0, 4), 1), (2, INF)),
        (Near((1, 0.5, 0), (3, 0.5, 0)), UNIT, FAR, (-INF, 2)),
        (Near(((1, 1),), (3, 0, 0)), HULL, FAR, (-INF, 2)),
        (Common((0.75, 0.5, 0)), UNIT, NEAR, (-INF, 0)),
        (Core((((0, 0, 0), (0, 1, 0)),)), DISC, Disc((0, 1), 3), (-INF, -4)),
        (Core((((0, 0, 0), (0.5, 0.25, 0)),)), Segment((0, 0), (1, 0)), Disc((0.5, 0.25), 1), None),
        (
            Core(tuple(((x, y, 0), (0.5, 0.5, 0)) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))),
            UNIT, FlatPoint((0.5, 0.5)), (-INF, -0.5),
        ),
        (Separated((1, 0, 0), 1), RAY, UNIT, (1, INF)),
        (Separated((0, 1, 0)), RAY, FAR.translated((0, 2)), (INF, INF)),
        (Common(None, 1), RAY, UNIT, (0, 1)),
    ],
)  # fmt: skip
def test_known_claims(claim: Any, a: Any, b: Any, bounds: Any) -> None:
    found = check(Certificate((claim,)), a, b)
    if bounds is None:
        assert found[1] < -0.4
    else:
        assert found == bounds


AROUND = tuple(((x, y, 0), (0.5, 0.5, 0)) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
CENTER = FlatPoint((0.5, 0.5))


@pytest.mark.parametrize(
    ("claim", "a", "b", "words"),
    [
        (Escape((0, 0, 1)), UNIT, NEAR, "not a direction of the plane"),
        (Separated((1, 0, 1)), UNIT, FAR, "not a direction of the plane"),
        (Separated((0, 1, 0)), UNIT, FAR, "do not leave a gap"),
        (Separated((1, 0, 0)), TRIANGLE, FAR, "shares"),
        (Separated((1, 0, 0), faces=(((0, ((2, 1),)),), ())), TRIANGLE, FAR, "no normal of a plane"),
        (Near((1, 0.5, 1), (3, 0.5, 0)), UNIT, FAR, "not in the plane"),
        (Common((0.25, 0.25, 5)), TRIANGLE, TRIANGLE, "not in the plane"),
        (Common((0.9, 0.9, 0)), TRIANGLE, UNIT, "outside a face"),
        (Core(AROUND[::-1]), UNIT, CENTER, "not to the left"),
        (Core(AROUND[:2]), UNIT, CENTER, "not to the left"),
        (Core(()), UNIT, CENTER, "pairs"),
        (Core(AROUND), UNIT, FlatPoint((2, 2)), "do not prove|not to the left|outside"),
        (Core((AROUND[0], AROUND[2], AROUND[1], AROUND[3])), UNIT, CENTER, "not to the left"),
        (Inscribed((0, 0, 0), ((0, 0, 0),) * 3, (0, 0, 0), ((0, 0, 0),) * 3, 1, (0, 0, 0)), DISC, UNIT, "columns"),
        (Separated((1, 0, 0)), UNIT, Sphere((9, 0, 0), 1), "of the plane and one of space"),
        (Common((0, 0, 0)), Sphere((0, 0, 0), 1), DISC, "of the plane and one of space"),
        (Separated((1, 0, 0), 1.5), RAY, UNIT, "do not leave a gap"),
        (Common(None, 0.9), RAY, UNIT, "not inside then"),
        (Common(None, 1), FlatRay((-2, 0.5), (2, 0)), Sphere((0, 0, 0), 1), "of the plane and one of space"),
    ],
)
def test_false_claims_are_refused(claim: Any, a: Any, b: Any, words: str) -> None:
    with pytest.raises(InvalidCertificate, match=words):
        check(Certificate((claim,)), a, b)


@pytest.mark.parametrize(
    ("claim", "words"),
    [
        (Clear(Separated((1, 0, 0))), "until the end"),
        (Clear(Separated((1, 0, 0)), 0.75), "until the end"),
        (Clear(Separated((1, 0, 1)), 0.5), "not a direction of the plane"),
        (Meets(0.5, (1, 0.5, 0), (3, 0.5, 0)), "not in one place"),
        (Meets(0.75, (1.5, 0.5, 0), (4.5, 0.5, 0)), "outside its proxy"),
    ],
)
def test_false_claims_about_sweeps_are_refused(claim: Any, words: str) -> None:
    motion = FlatTranslation((-4, 0))
    right = SweepCertificate((Clear(Separated((1, 0, 0)), 0.5), Meets(0.5, (1, 0.5, 0), (3, 0.5, 0))))
    assert check_sweep(right, UNIT, FAR, None, motion) == (0.5, 0.5)
    with pytest.raises(InvalidCertificate, match=words):
        check_sweep(
            SweepCertificate((claim,)), UNIT, FAR, None, FlatTranslation((-4, 0.5)) if "one" in words else motion
        )


def test_a_set_that_is_not_as_it_says_is_refused() -> None:
    class Wrong:
        pass

    for kind, values in (
        ("Disc", {"center": (0.0, 0.0), "radius": -1.0}),
        ("Disc", {"center": (0.0, 0.0, 1.0), "radius": 1.0}),
        ("Rectangle", {"lower": (0.0, 0.0), "upper": (-1.0, 1.0)}),
        ("FlatRay", {"origin": (0.0, 0.0), "direction": (0.0, 0.0)}),
        ("ConvexPolygon", {"numbers": [(0.0, 0.0, 1.0)], "given": "lines"}),
        ("ConvexPolygon", {"numbers": [(0.0, 0.0)], "given": "points"}),
    ):
        made = type(kind, (Wrong,), {k: np.array(v) if k != "given" else v for k, v in values.items()})()
        with pytest.raises(InvalidCertificate):
            check(Certificate((Common((0, 0, 0)),)), made, UNIT)
    composite = type("Composite", (Wrong,), {"parts": (DISC,)})()
    with pytest.raises(InvalidCertificate, match="no part of a solid"):
        check(Certificate((Common((0, 0, 0)),)), composite, Sphere((0, 0, 0), 1))


def test_certificates_survive_json() -> None:
    rng = np.random.default_rng(3)
    for make in REGIMES.values():
        a, b = make(ConvexPolygon, Segment, rng)
        certificate = certify(a, b)
        again = from_json(json.loads(json.dumps(to_json(certificate))))
        assert again == certificate
        assert check(again, a, b) == check(certificate, a, b)


def ellipse(count: int, thin: float) -> ConvexPolygon:
    """A polygon of many corners on an ellipse: the thinner it is, the more nearly are all sides parallel, and level."""
    angles = 2 * np.pi * np.arange(count) / count
    return ConvexPolygon.from_vertices(np.stack([np.cos(angles), thin * np.sin(angles)], axis=1))


@pytest.mark.parametrize("angle", [0.0, 1.3])
def test_polygons_of_many_nearly_parallel_sides_lie_in_their_proofs(angle: float) -> None:
    signs = set()
    for count in (10, 13):
        for thin in 10.0 ** -np.arange(0, 15, 3):
            for a, b in (
                (ellipse(12, 0.8).rotated(angle), ellipse(count, thin)),
                (ellipse(count, thin).rotated(angle), ellipse(10, thin).translated((0.3, thin / 2))),
                (ellipse(count, thin).rotated(angle), ellipse(10, thin).translated((0.3, 2.5 * thin))),
            ):
                certificate, found = certify(a, b), refimpl.distance(a, b)
                assert certificate.lower - 1e-15 <= found.distance <= certificate.upper + 1e-15
                assert certificate.upper - certificate.lower <= 2e-15
                reach = refimpl.support(a, found.normal) + refimpl.support(b, -found.normal)
                assert float(reach) == pytest.approx(-float(found.distance), abs=2e-15)
                assert np.max(np.abs(found.on_b - found.on_a - found.distance * found.normal)) <= 2e-15
                signs.add(bool(found.distance > 0))
    assert signs == {False, True}
