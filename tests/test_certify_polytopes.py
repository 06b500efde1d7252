"""Certificates of k-DOPs and convex polyhedra: narrow, true in rationals, refused when tampered with."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf  # type: ignore[import-untyped]

from oracles.regimes import REGIMES
from refimpl.proof import (
    Certificate,
    Claim,
    Common,
    Core,
    Escape,
    InvalidCertificate,
    Near,
    Separated,
    certify,
    check,
    from_json,
    reading,
    sets,
    to_json,
)
from refimpl.proof.certify import mirrored, round_down, round_up
from refimpl.shapes import AABB, KDOP, Box, Capsule, ConvexPolyhedron, HalfSpace, Point, Proxy, Ray, Sphere
from tests.conftest import effort, name_of, regimes_in_turn, scenes_of
from tests.truth import ray_interval, signed_distance

INF = math.inf
OTHERS = (Point, Sphere, Capsule, HalfSpace, AABB, Box)
PAIRS = [
    *((A, B) for A in OTHERS for B in (KDOP, ConvexPolyhedron)),
    (KDOP, KDOP),
    (KDOP, ConvexPolyhedron),
    (ConvexPolyhedron, ConvexPolyhedron),
]
WIDTH = 1e-12


def real(x: Any) -> mpf:
    return mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mpf(x)


def encloses(lower: Any, upper: Any, truth: mpf) -> None:
    with mp.workdps(60):
        slack = abs(truth) * mpf(10) ** -45 if mp.isfinite(truth) else mpf(0)
        assert real(lower) - slack <= truth <= real(upper) + slack


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_intervals_are_narrow_and_true_in_every_regime(pair: tuple[type[Proxy], type[Proxy]]) -> None:
    signs = set()
    for regime in regimes_in_turn(pair):
        a, b = scenes_of(pair, regime, max(2, effort() // 4))
        for i in range(len(a)):
            certificate = certify(a[i], b[i])
            lower, upper = check(certificate, a[i], b[i])
            assert (certificate.lower, certificate.upper) == (round_down(lower), round_up(upper))
            assert check(mirrored(certificate), b[i], a[i]) == (lower, upper)
            size = max(float(a[i].magnitude), float(b[i].magnitude), abs(float(lower)))
            assert upper - lower <= WIDTH * size
            if i == 0:
                encloses(lower, upper, signed_distance(a[i], b[i]))
            signs.add(upper > 0)
    assert signs == {False, True}


@pytest.mark.parametrize("B", [KDOP, ConvexPolyhedron], ids=lambda kind: kind.__name__)
def test_rays_are_timed_to_the_last_bits(B: type[Proxy]) -> None:
    ends = set()
    for regime in REGIMES:
        ray, b = scenes_of((Ray, B), regime, max(2, effort() // 2))
        for i in range(len(ray)):
            certificate = certify(ray[i], b[i])
            lower, upper = check(certificate, ray[i], b[i])
            times = ray_interval(ray[i], b[i])  # type: ignore[arg-type]
            encloses(lower, upper, mpf("inf") if times is None else times[0])
            assert lower == upper or upper - lower <= 1e-14 * float(upper)
            ends.add({0.0: "inside", INF: "missed"}.get(float(certificate.upper), "hit"))
    assert ends == {"inside", "hit", "missed"}


def test_touching_faces_have_distance_zero() -> None:
    cube = ConvexPolyhedron.from_vertices(list(product((-1, 1), repeat=3)), (2, 0, 0))
    slabs = KDOP(np.eye(3), (-1, -1, -1), (1, 1, 1))
    assert check(certify(cube, slabs), cube, slabs) == (0, 0)


# ---- the trusted facts ----------------------------------------------------------------------------------------

TURN = (1, 2, 3, 4)
CORNERS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
CUBE_PLANES = [[*n, -1] for n in (*np.eye(3).tolist(), *(-np.eye(3)).tolist())]
TETRAHEDRON = ConvexPolyhedron.from_vertices(CORNERS, (1, 0, 0), TURN)
CUBE = ConvexPolyhedron(CUBE_PLANES, (1, 0, 0), TURN)
SLABS = KDOP(np.eye(3), (-1, -1, -1), (1, 1, 1))
BOX = Box((1, 0, 0), (1, 1, 1), TURN)


def one(claim: Claim, a: Proxy, b: Proxy) -> tuple[Any, Any]:
    return check(Certificate((claim,)), a, b)


def test_a_turned_cube_of_planes_is_the_box() -> None:
    cube, box = reading.read(CUBE), reading.read(BOX)
    assert isinstance(cube, sets.Planes)
    assert isinstance(box, sets.Product)
    for i, j, k in product((0, 1), (1, 2), (2, 5)):
        faces = [i * 3, 1 + (j == 1) * 3, 2 + (k == 2) * 3]
        shares = tuple((face, 1 + face) for face in faces)
        n = [sum(w * cube.planes[f][0][axis] for f, w in shares) for axis in range(3)]
        assert cube.support(n, shares) == box.support(n)
    rng = np.random.default_rng(3)
    for point in (rng.uniform(-1, 3, (40, 3)) * (1, 0.5, 0.5)).tolist():
        inside = box.member(point)[1] == 0
        try:
            assert cube.member(point) == ([Fraction(x) for x in point], 0)
            assert inside
        except InvalidCertificate:
            assert not inside


def test_a_hull_is_as_far_as_its_vertices() -> None:
    hull = reading.read(TETRAHEDRON)
    assert isinstance(hull, sets.Hull)
    corners = [hull.member(((i, 1),))[0] for i in range(4)]
    for n in product((-2, 0, 3), (1, -1), (0, 5)):
        assert hull.support(n) == max(sum(c * x for c, x in zip(n, corner, strict=True)) for corner in corners)
    mean, outside = hull.member(((0, 2), (3, 0.5)))
    assert outside == 0
    assert mean == [(4 * x + y) / 5 for x, y in zip(corners[0], corners[3], strict=True)]
    box = reading.read(BOX)
    assert isinstance(box, sets.Product)
    assert all(box.member(corner)[1] == 0 for corner in corners)  # they are corners of the cube


# ---- tampering: refused ---------------------------------------------------------------------------------------

FAR = AABB((4, -1, -1), (6, 1, 1))
X = (1, 0, 0)
ABOVE = (((0, ((0, 1),)),), ())
REFUSED: dict[str, tuple[Claim, Proxy, Proxy]] = {
    "no shares": (Separated(X), SLABS, FAR),
    "shares of the other": (Separated(X, None, ABOVE[::-1]), SLABS, FAR),
    "another plane": (Separated(X, None, (((0, ((1, 1),)),), ())), SLABS, FAR),
    "opposite plane": (Separated(X, None, (((0, ((3, 1),)),), ())), SLABS, FAR),
    "negative share": (Separated(X, None, (((0, ((3, -1),)),), ())), SLABS, FAR),
    "share beside n": (Separated(X, None, (((0, ((0, 1), (1, 1e-9))),), ())), SLABS, FAR),
    "zero share": (Separated(X, None, (((0, ((0, 0),)),), ())), SLABS, FAR),
    "plane that is not there": (Separated(X, None, (((0, ((6, 1),)),), ())), SLABS, FAR),
    "plane -1": (Separated(X, None, (((0, ((-1, 1),)),), ())), SLABS, FAR),
    "plane 1.0": (Separated(X, None, (((0, ((0.0, 1),)),), ())), SLABS, FAR),  # type: ignore[arg-type]
    "direction beside the shares": (Separated((1, 1e-9, 0), None, ABOVE), SLABS, FAR),
    "swapped": (Separated(X, None, ABOVE), FAR, SLABS),
    "a bound though they touch": (Separated(X, None, ABOVE), SLABS, AABB((1, -1, -1), (2, 1, 1))),
    "escape though apart": (Escape(X, ABOVE), SLABS, FAR),
    "point outside by a last bit": (Near((math.nextafter(1, 2), 0, 0), (4, 0, 0)), SLABS, FAR),
    "point by coordinates": (Near((1, 0, 0), (4, 0, 0)), TETRAHEDRON, FAR),
    "weights for planes": (Near(((0, 1),), (4, 0, 0)), SLABS, FAR),
    "weights for a box": (Near((4, 0, 0), ((0, 1),)), SLABS, FAR),
    "negative weight": (Near(((0, 2), (1, -1)), (4, 0, 0)), TETRAHEDRON, FAR),
    "no weight": (Near((), (4, 0, 0)), TETRAHEDRON, FAR),
    "zero weights": (Near(((0, 0),), (4, 0, 0)), TETRAHEDRON, FAR),
    "vertex that is not there": (Near(((4, 1),), (4, 0, 0)), TETRAHEDRON, FAR),
    "hit elsewhere": (Common(((0, 1),), 2), Ray((-4, 0, 0), (2, 0, 0)), TETRAHEDRON),
    "hit without weights": (Common(None, 2.5), Ray((-4, 0, 0), (2, 0, 0)), TETRAHEDRON),
    "free a last bit too long": (
        Separated(X, math.nextafter(1.5, 2), ((), ((0, ((3, 1),)),))),
        Ray((-4, 0, 0), (2, 0, 0)),
        SLABS,
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_false_claims_are_refused(name: str) -> None:
    claim, a, b = REFUSED[name]
    with pytest.raises(InvalidCertificate):
        one(claim, a, b)


def test_true_claims_of_the_same_kind_hold() -> None:
    assert one(Separated(X, None, ABOVE), SLABS, FAR) == (3, INF)
    assert one(Separated((2, 0, 0), None, (((0, ((0, 0.125),)),), ())), SLABS, FAR) == (3, INF)
    assert one(Escape(X, ABOVE), SLABS, AABB((0.5, -1, -1), (2, 1, 1))) == (-0.5, INF)
    assert one(Near((1, 0, 0), (4, 0, 0)), SLABS, FAR) == (-INF, 3)
    free = Separated(X, 1.5, ((), ((0, ((3, 1),)),)))
    assert one(free, Ray((-4, 0, 0), (2, 0, 0)), SLABS) == (1.5, INF)


DEEP = KDOP([*CORNERS, *np.eye(3)], [-1] * 7, [1.5] * 7), TETRAHEDRON.translated((-0.75, 0.1, 0.2))
POLYTOPE = next(claim for claim in certify(*DEEP).claims if isinstance(claim, Core))


def test_every_facet_and_every_weight_matters() -> None:
    lower, upper = check(certify(*DEEP), *DEEP)
    for i in range(len(POLYTOPE.triangles)):
        triangles = POLYTOPE.triangles[:i] + POLYTOPE.triangles[i + 1 :]
        with pytest.raises(InvalidCertificate, match="not closed"):
            one(replace(POLYTOPE, triangles=triangles), *DEEP)
    for i, (p, q) in enumerate(POLYTOPE.pairs):
        moved: Any = tuple(c * (1 + 1e-6) for c in p), ((1 - q[0][0], 1),)  # type: ignore[operator, index]
        for changed in ((moved[0], q), (p, moved[1])):
            pairs = (*POLYTOPE.pairs[:i], changed, *POLYTOPE.pairs[i + 1 :])
            try:
                assert one(replace(POLYTOPE, pairs=pairs), *DEEP)[1] >= lower
            except InvalidCertificate:
                continue
    assert upper < 0


def test_a_certificate_is_for_its_own_shapes() -> None:
    certificate = certify(*DEEP)
    smaller = KDOP(DEEP[0].directions, DEEP[0].lower * (1 - 1e-6), DEEP[0].upper * (1 - 1e-6))
    with pytest.raises(InvalidCertificate):
        check(Certificate((POLYTOPE,)), smaller, DEEP[1])
    with pytest.raises(InvalidCertificate):
        check(certificate, DEEP[1], DEEP[0])
    with pytest.raises(InvalidCertificate):
        check(certificate, CUBE, DEEP[1])


BAD: list[tuple[str, dict[str, Any]]] = [
    ("KDOP", {"directions": [(0, 0, 1)], "lower": [0.0, 0.0], "upper": [1.0]}),
    ("KDOP", {"directions": [(0, 0, 0)], "lower": [0.0], "upper": [1.0]}),
    ("KDOP", {"directions": [], "lower": [], "upper": []}),
    ("KDOP", {"directions": [(0, 0, 1)], "lower": [math.nan], "upper": [1.0]}),
    ("ConvexPolyhedron", {"numbers": [(0, 0, 1, 1)], "position": (0, 0, 0), "rotation": (0, 0, 0, 1)}),
    ("ConvexPolyhedron", {"given": "planes", "numbers": [(0, 0, 0, 1)], "position": (0, 0, 0), "rotation": TURN}),
    ("ConvexPolyhedron", {"given": "planes", "numbers": [(0, 0, 1)], "position": (0, 0, 0), "rotation": TURN}),
    ("ConvexPolyhedron", {"given": "vertices", "numbers": [], "position": (0, 0, 0), "rotation": TURN}),
    ("ConvexPolyhedron", {"given": "vertices", "numbers": [X], "position": (0, 0, 0), "rotation": (0, 0, 0, 0)}),
    ("Ellipsoid", {"center": (0, 0, 0), "radii": (1, 0, 1), "rotation": TURN}),
    ("Ellipsoid", {"center": (0, 0, 0), "radii": (1, -1, 1), "rotation": TURN}),
    ("Cylinder", {"p": (0, 0, 0), "q": (0, 0, 0), "radius": 1.0}),
    ("Cylinder", {"p": (0, 0, 0), "q": (0, 0, 1), "radius": 0.0}),
]


@pytest.mark.parametrize(("kind", "fields"), BAD)
def test_shapes_without_a_meaning_are_refused(kind: str, fields: dict[str, Any]) -> None:
    shape = type(kind, (), {k: v if isinstance(v, str) else np.array(v, float) for k, v in fields.items()})()
    with pytest.raises(InvalidCertificate):
        check(Certificate(()), shape, FAR)


@pytest.mark.parametrize("shapes", [DEEP, (CUBE, FAR), (TETRAHEDRON, FAR), (Ray((-4, 0, 0), (2, 0, 0)), TETRAHEDRON)])
def test_certificates_survive_json(shapes: tuple[Proxy, Proxy]) -> None:
    certificate = certify(*shapes)
    back = from_json(to_json(certificate))
    assert back == certificate
    assert check(back, *shapes) == check(certificate, *shapes)


def test_depths_below_rounding_have_both_bounds() -> None:
    """The lowest corner, an exact rational, is deeper in the half-space than the double next to it."""
    planes = [[1.0, 0.0, 0.0, -0.984361551484034], [0.0, 1.0, 0.0, -1.2886246898040186]]
    planes += [[0.0, 0.0, 1.0, -0.386763840825874], [-1.0, 0.0, 0.0, -0.984361551484034]]
    planes += [[0.0, -1.0, 0.0, -1.2886246898040186], [0.0, 0.0, -1.0, -0.386763840825874]]
    planes += [[-0.7152188384707374, -0.8609353523061749, -0.9469137291642127, -0.7159834877725338]]
    planes += [[0.16005689071921303, -0.3677901018563934, -0.4840065579773689, -0.3229448605531611]]
    planes += [[0.43747124858450204, 0.40258858929550345, 0.2951885983743088, -0.4041283025721424]]
    place = [1.48178051117685, -0.29781304209480153, 1.6837885440580982]
    turn = [0.11560434513463891, -0.691453101930182, 0.18051907870246509, -0.19306406554256328]
    body = ConvexPolyhedron(planes, place, turn)
    half = HalfSpace([2.6891900907483675, 1.5508312716437305, 0.5676204050110755], -1.1047525927914668)
    lower, upper = check(certify(half, body), half, body)
    assert -1e-16 < lower <= upper < 0
    assert upper - lower < 1e-30
