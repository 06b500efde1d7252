"""Certificates of ellipsoids and cylinders: narrow, true to 50 digits, also where circles of directions compete."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf  # type: ignore[import-untyped]

from oracles.regimes import REGIMES
from refimpl.proof import Certificate, Inscribed, InvalidCertificate, certify, check, from_json, to_json
from refimpl.proof.certify import mirrored, round_down, round_up
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
    Proxy,
    Ray,
    Sphere,
)
from tests.conftest import effort, name_of, regimes_in_turn, scenes_of
from tests.truth import ray_interval, signed_distance

INF = math.inf
OTHERS = (Point, Sphere, Capsule, HalfSpace, AABB, Box, KDOP, ConvexPolyhedron)
PAIRS = [
    *((A, B) for A in OTHERS for B in (Ellipsoid, Cylinder)),
    (Ellipsoid, Ellipsoid),
    (Ellipsoid, Cylinder),
    (Cylinder, Cylinder),
]
WIDTH, WIDEST = 1e-10, 1e-8
"""Of the proven interval, relative to the scene: in all but one in a thousand, and in every scene."""


def real(x: Any) -> mpf:
    return mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mpf(x)


def width(a: Proxy, b: Proxy) -> float:
    """Width of a certificate's interval, relative to the scene; it holds in both orders."""
    certificate = certify(a, b)
    lower, upper = check(certificate, a, b)
    assert (certificate.lower, certificate.upper) == (round_down(lower), round_up(upper))
    assert check(mirrored(certificate), b, a) == (lower, upper)
    size = max(float(a.magnitude), float(b.magnitude), abs(float(lower)))
    return float(upper - lower) / size


def test_intervals_are_narrow_in_every_regime() -> None:
    widths = []
    for pair in PAIRS:
        for regime in regimes_in_turn(pair):
            a, b = scenes_of(pair, regime, max(2, effort() // 4))
            widths += [width(a[i], b[i]) for i in range(len(a))]
    assert len(widths) > 140
    assert max(widths) <= WIDEST
    assert sum(w > WIDTH for w in widths) <= len(widths) / 1000


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_intervals_hold_the_truth(pair: tuple[type[Proxy], type[Proxy]]) -> None:
    signs = set()
    for regime in ("generic", "nearly_touching", "deep", "parallel_edges", "sliver"):
        a, b = scenes_of(pair, regime, 1)
        lower, upper = check(certify(a[0], b[0]), a[0], b[0])
        with mp.workdps(60):
            truth = signed_distance(a[0], b[0])
            slack = mpf(10) ** -22 * max(mpf(float(a[0].magnitude)), mpf(float(b[0].magnitude)), abs(truth))
            assert real(lower) - slack <= truth <= real(upper) + slack
        signs.add(truth > 0)
    assert signs


@pytest.mark.parametrize("B", [Ellipsoid, Cylinder], ids=lambda kind: kind.__name__)
def test_rays_are_timed_to_the_last_bits(B: type[Proxy]) -> None:
    ends = set()
    for regime in REGIMES:
        ray, b = scenes_of((Ray, B), regime, effort())
        for i in range(len(ray)):
            certificate = certify(ray[i], b[i])
            lower, upper = check(certificate, ray[i], b[i])
            times = ray_interval(ray[i], b[i])  # type: ignore[arg-type]
            with mp.workdps(80):
                truth = mpf("inf") if times is None else times[0]
                if mp.isinf(truth):
                    assert lower == upper == INF
                else:
                    slack = abs(truth) * mpf(10) ** -50
                    assert real(lower) - slack <= truth <= real(upper) + slack
                    assert real(upper) - real(lower) <= mpf(10) ** -14 * abs(truth)
            ends.add({0.0: "inside", INF: "missed"}.get(float(certificate.upper), "hit"))
    assert ends == {"inside", "hit", "missed"}


# ---- circles and spheres of directions ----------------------------------------------------------------------

UPRIGHT = Cylinder((0, 0, -2), (0, 0, 2), 0.5)
EGG = Ellipsoid((0, 0, 0), (0.5, 0.5, 2), (0, 0, 0, 1))
SYMMETRIC: dict[str, tuple[Proxy, Proxy, float]] = {
    "coaxial cylinders": (UPRIGHT, Cylinder((0, 0, -1), (0, 0, 3), 1), -1.5),
    "flat and tall cylinder": (Cylinder((0, 0, -0.125), (0, 0, 0.125), 1), Cylinder((0, 0, -3), (0, 0, 3), 0.5), -1.5),
    "equal eggs": (EGG, EGG, -1),
    "egg in cylinder": (EGG, UPRIGHT, -1),
    "point on a cylinder's axis": (Point((0, 0, 0.25)), UPRIGHT, -0.5),
    "point in the middle of an egg": (Point((0, 0, 0)), EGG, -0.5),
    "capsule along a cylinder": (Capsule((0, 0, -1), (0, 0, 1), 0.25), UPRIGHT, -0.75),
    "capsule along an egg": (Capsule((0, 0, -1), (0, 0, 1), 0.25), EGG, -0.75),
    "spheres as ellipsoids": (Ellipsoid((0, 0, 0), (2, 2, 2), (1, 2, 3, 4)), Sphere((0, 0, 0), 1), -3),
    "equal triaxial ellipsoids": (Ellipsoid((1, 2, 3), (1, 2, 3), (1, 0, 0, 2)),) * 2 + (-2.0,),  # type: ignore[dict-item]
}


@pytest.mark.parametrize("name", SYMMETRIC)
def test_symmetric_overlaps(name: str) -> None:
    a, b, sigma = SYMMETRIC[name]
    for certificate in (certify(a, b), certify(b, a)):
        assert certificate.lower <= sigma <= certificate.upper
        assert certificate.upper - certificate.lower <= 1e-10


@pytest.mark.parametrize("tilt", [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2, 0.1])
def test_nearly_coaxial_overlaps(tilt: float) -> None:
    for a in (UPRIGHT, EGG, Cylinder((0, 0, -0.1), (0, 0, 0.1), 1)):
        for b in (
            UPRIGHT.rotated((tilt / 2, 0, 0, 1)),
            EGG.rotated((tilt / 2, 0, 0, 1)),
            AABB((-1, -2, -3), (1, 2, 3)),
        ):
            assert width(a, b) <= WIDTH


# ---- tampering ------------------------------------------------------------------------------------------------

TUBES = (UPRIGHT, Cylinder((0, 0, -1), (0, 0, 3), 1))
EGGS = (EGG, Ellipsoid((0, 0, 0), (0.75, 0.75, 1.5), (0, 0, 0, 1)))


def inscribed_of(a: Proxy, b: Proxy) -> Inscribed:
    return next(claim for claim in certify(a, b).claims if isinstance(claim, Inscribed))


def grown(columns: Any, factor: float) -> Any:
    return tuple(tuple(factor * c for c in column) for column in columns)


@pytest.mark.parametrize("pair", [TUBES, EGGS], ids=["cylinders", "ellipsoids"])
def test_false_ellipsoids_are_refused(pair: tuple[Proxy, Proxy]) -> None:
    claim = inscribed_of(*pair)
    assert check(Certificate((claim,)), *pair)[1] < 0
    (x, y, z), millionth = claim.a, 1 + 1e-6  # type: ignore[misc]
    false = {
        "radius": replace(claim, radius=float(claim.radius) * millionth),
        "negative radius": replace(claim, radius=-1),
        "p": replace(claim, p=grown(claim.p, millionth)),
        "q": replace(claim, q=grown(claim.q, millionth)),
        "smaller p": replace(claim, p=grown(claim.p, 1 / millionth)),
        "flat": replace(claim, p=grown(claim.p, 0.0), q=grown(claim.q, 0.0)),
        "same direction of u": replace(claim, q=grown(claim.q, -1.0)),
        "moved": replace(claim, a=(float(x) + 1e-6, y, z)),
        "moved along": replace(claim, a=(x, y, float(z) + 1e-6)),
        "first share": replace(claim, shares=(-1, *claim.shares[1:])),
        "second share": replace(claim, shares=(claim.shares[0], 2 * claim.shares[1], claim.shares[2])),
        "third share": replace(claim, shares=(*claim.shares[:2], 0)),
        "swapped": claim,
    }
    for name, wrong in false.items():
        shapes = pair[::-1] if name == "swapped" else pair
        with pytest.raises(InvalidCertificate):
            check(Certificate((wrong,)), *shapes)


def test_an_ellipsoid_does_not_hold_for_smaller_shapes() -> None:
    claim = inscribed_of(*TUBES)
    for wrong in (
        Cylinder((0, 0, -2), (0, 0, 2), 0.5 * (1 - 1e-6)),
        Cylinder((0, 0, 0.5), (0, 0, 2), 0.5),
        Point((0, 0, 0)),
    ):
        with pytest.raises(InvalidCertificate):
            check(Certificate((claim,)), wrong, TUBES[1])


def test_shallow_polytopes_prove_no_more_than_the_truth() -> None:
    """A millionth more of any number of the certificate leaves a true bound, or none."""
    a, b = Ellipsoid((0.5, 0, 0), (1, 2, 3), (1, 2, 3, 4)), Cylinder((0, 0, 0), (1, 1, 1), 0.5)
    lower, upper = check(certify(a, b), a, b)
    rng = np.random.default_rng(1)
    for claim in certify(a, b).claims:
        for name, value in vars(claim).items():
            if name in {"triangles", "directions", "until", "faces"}:
                continue
            for _ in range(5):
                changed = shaken(value, rng)
                try:
                    low, high = check(Certificate((replace(claim, **{name: changed}),)), a, b)
                except InvalidCertificate:
                    continue
                assert low <= upper
                assert high >= lower


def shaken(value: Any, rng: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(shaken(v, rng) for v in value)
    return float(value) * (1 + 1e-6 * rng.standard_normal())


@pytest.mark.parametrize("name", SYMMETRIC)
def test_certificates_survive_json(name: str) -> None:
    a, b, _ = SYMMETRIC[name]
    certificate = certify(a, b)
    assert from_json(to_json(certificate)) == certificate
