"""Certificates of first contacts of bodies that turn: what they prove, and that nothing false passes."""

from __future__ import annotations

import dataclasses
import json
import math
from fractions import Fraction

import numpy as np
import pytest
from mpmath import acos, asin, atan2, cos, hypot, mp, mpf, sin, sqrt

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
    Polyhedron,
    RigidMotion,
    Sphere,
    Translation,
    distance,
    sweep,
)
from refimpl.proof.atoms import Directions, atoms_of
from refimpl.proof.claims import Separated
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.rigid import Boxes, Scene, Span, Spans, Touch
from refimpl.proof.rigid_poses import rotation
from refimpl.proof.sweep_search import certify_sweep
from refimpl.proof.sweeps import SweepCertificate, check_sweep
from refimpl.proof.wire import sweep_certificate_from_json, sweep_certificate_to_json

STILL = (0.0, 0.0, 0.0, 1.0)
FLOOR = HalfSpace([0.0, 1.0, 0.0], 0.0)
CORNERS = np.array([[0.5, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]])
FACES = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
THROWN = RigidMotion([3.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.5, 0.0, 0.0])
ROLLING = RigidMotion([0.0, 0.0, 0.0], [1.0, -2.0, 1.0], [3.0, 0.0, 0.0])
NARROW = 1e-9


def spin(rate, center=(0.0, 0.0, 0.0), linear=(0.0, 0.0, 0.0)):
    return RigidMotion(linear, [0.0, 0.0, rate], center)


def _around(seed):
    return KDOP.around(np.random.default_rng(seed).normal(size=(8, 3)) * 0.5)


SLAB = Box([3.0, 0.3, 0.1], [1.0, 0.5, 0.3], [0.1, 0.2, 0.3, 0.4])
SCENES = {
    "orbit": (Sphere([2.0, 0.0, 0.0], 0.25), HalfSpace([1.0, 0.0, 0.0], 1.5), spin(3.0), None),
    "corner": (FLOOR, Box([0.0, 1.1, 0.0], [1.0, 0.5, 0.3], STILL), None, spin(1.25, (0.0, 1.1, 0.0))),
    "boxes": (Box([0.0, 0.0, 0.0], [0.5, 0.6, 0.7], STILL), SLAB, THROWN, ROLLING),
    "round": (Ellipsoid([0.0] * 3, [0.5, 0.6, 0.7]), Cylinder([3.0, 0.3, 0.1], [4.0, 0.5, 0.3], 0.3), THROWN, ROLLING),
    "planes": (_around(0), AABB([3.0, -0.3, -0.1], [4.0, 0.5, 0.3]), THROWN, ROLLING),
    "fast": (
        Capsule([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.01),
        Sphere([1.0, 3.0, 0.0], 0.5),
        RigidMotion([1.0, 2.0, 0.0], [60.0, 70.0, 20.0], [0.0, 0.0, 0.0]),
        None,
    ),
    "mixed": (
        Composite([AABB([0.0] * 3, [0.5] * 3), _around(1)]),
        Composite([HalfSpace([-1.0, 0.0, 0.0], 2.0), Sphere([2.0, 2.0, 2.0], 0.3)]),
        THROWN,
        Translation([0.1, 0.0, 0.0]),
    ),
    "meshes": (Polyhedron(CORNERS, FACES), Polyhedron(CORNERS, FACES, [3.0, 0.2, 0.1]), THROWN, ROLLING),
    "ceiling": (FLOOR, HalfSpace([0.0, -2.0, 0.0], 2.0), spin(3.0), spin(3.0, (1.0, 0.5, 0.0))),
    "large": (
        SLAB.scaled(1e5),
        Sphere([0.0] * 3, 5e4),
        None,
        RigidMotion([3e5, 0.0, 0.0], [1.0, 2.0, 3.0], [1e4, 0, 0]),
    ),
    "hull": (ConvexPolyhedron.from_vertices(CORNERS), SLAB.scaled(0.5), THROWN, None),
    "miss": (Sphere([0.0] * 3, 0.5), SLAB.translated([0.0, 3.0, 0.0]), THROWN, ROLLING),
}


@pytest.fixture(scope="module")
def proven():
    """Certificates of all scenes, and what they prove."""
    found = {}
    for name, scene in SCENES.items():
        certificate = certify_sweep(*scene)
        found[name] = certificate, check_sweep(certificate, *scene)
    return found


def refused(claims, scene):
    with pytest.raises(InvalidCertificate):
        check_sweep(SweepCertificate(tuple(claims)), *scene)


def spans_of(certificate):
    (claim,) = [claim for claim in certificate.claims if isinstance(claim, Spans)]
    return claim


def test_intervals_are_proven_and_narrow(proven):
    for name, (certificate, (lower, upper)) in proven.items():
        hit = sweep(*SCENES[name])
        assert certificate.lower <= lower
        if name == "miss":
            assert lower == upper == math.inf
            assert not hit.hit
            continue
        assert 0 < lower <= upper <= certificate.upper
        assert upper - lower <= NARROW
        assert max(hit.t_lower, lower) <= min(hit.t, upper)


def test_intervals_hold_the_closed_forms(proven):
    with mp.workdps(50):
        expected = {
            "orbit": acos(mpf(-1.25) / 2) / 3,
            "corner": (asin(mpf(1.1) / hypot(1, mpf(0.5))) - atan2(mpf(0.5), 1)) / mpf(1.25),
            "ceiling": 2 * mp.atan(mpf(0.5)) / 3,  # sin 3t = (1 + cos 3t)/2
        }
        for name, time in expected.items():
            lower, upper = proven[name][1]
            assert mpf(lower.numerator) / lower.denominator <= time <= mpf(upper.numerator) / upper.denominator


def test_stepping_finds_nothing_before(proven):
    for name in ("boxes", "round", "meshes", "hull", "miss"):
        a, b, one, other = SCENES[name]
        times = min(float(proven[name][1][0]), 1.0) * np.linspace(0, 1, 30)[:-1]
        for t in times:
            placed = (shape if motion is None else motion.placed(shape, t) for shape, motion in ((a, one), (b, other)))
            assert distance(*placed).distance > 0


@pytest.mark.parametrize(
    "turn", [(0.3, 0.1, 0.2), (30.0, -20.0, 10.0), (1e-9, 0.0, 0.0), (-0.0, 1.0, 0.0), (300.0, 1.0, 2.0)]
)
def test_rotations_are_within_their_error(turn):
    """Rodrigues' formula in 60 digits; the columns are exactly orthonormal, and the axis stays exactly."""
    columns, error = rotation([Fraction(x) for x in turn])
    assert 0 < error < Fraction(1, 10**40)
    for i, u in enumerate(columns):
        assert [sum(x * y for x, y in zip(u, v, strict=True)) for v in columns] == [i == j for j in range(3)]
    assert [sum(c[i] * Fraction(w) for c, w in zip(columns, turn, strict=True)) for i in range(3)] == list(turn)
    with mp.workdps(60):
        w = [mpf(x) for x in turn]
        angle = sqrt(sum(x * x for x in w))
        k = [x / angle for x in w]
        for i in range(3):
            e = [mpf(i == j) for j in range(3)]
            across = [k[1] * e[2] - k[2] * e[1], k[2] * e[0] - k[0] * e[2], k[0] * e[1] - k[1] * e[0]]
            image = [cos(angle) * e[j] + sin(angle) * across[j] + (1 - cos(angle)) * k[i] * k[j] for j in range(3)]
            off = [mpf(c.numerator) / c.denominator - x for c, x in zip(columns[i], image, strict=True)]
            assert sqrt(sum(x * x for x in off)) <= mpf(error.numerator) / error.denominator


def test_what_is_no_rotation_is_refused():
    with pytest.raises(InvalidCertificate, match="turns too often"):
        rotation([Fraction(10) ** 30] * 3)
    for motion in ("spin", Sphere([0.0] * 3, 1.0)):
        with pytest.raises(InvalidCertificate):
            check_sweep(SweepCertificate(()), *SCENES["orbit"][:2], motion, spin(1.0))


def test_certificates_are_the_same_in_json(proven):
    """In files there are only well-formed claims; what they are worth, the checker says again."""
    for certificate, _ in proven.values():
        text = json.dumps(sweep_certificate_to_json(certificate))
        assert sweep_certificate_from_json(json.loads(text)) == certificate
    data = sweep_certificate_to_json(proven["planes"][0])
    data["claims"][0]["of_a"][0][1].pop()
    with pytest.raises(InvalidCertificate):
        sweep_certificate_from_json(data)


def test_tampered_directions_are_refused(proven):
    for name in ("boxes", "round", "fast", "hull"):
        spans = spans_of(proven[name][0])
        for field in ("before", "after"):
            for turned in (lambda n: (n[1], n[2], n[0]), lambda n: tuple(-x for x in n)):
                last = spans.spans[-1]
                leaf = getattr(last, field)
                changed = dataclasses.replace(last, **{field: Separated(turned(leaf.n), None, leaf.faces)})
                refused([Spans((*spans.spans[:-1], changed), spans.places)], SCENES[name])


def test_longer_spans_are_refused(proven):
    """The last span goes on beyond the contact; or many spans are taken as one."""
    for name, (certificate, (_, upper)) in proven.items():
        if name == "miss":
            continue
        given = [claim for claim in certificate.claims if isinstance(claim, Boxes)]
        spans = spans_of(certificate)
        for until in (float(upper) + 1e-9, None):
            longer = dataclasses.replace(spans.spans[-1], until=until)
            refused([*given, Spans((*spans.spans[:-1], longer), spans.places)], SCENES[name])
    spans = spans_of(proven["fast"][0])
    third = len(spans.spans) // 3
    assert third > 3
    refused([Spans((*spans.spans[:third], *spans.spans[-third:]))], SCENES["fast"])
    refused([Spans((*spans.spans, spans.spans[0]))], SCENES["fast"])


def test_the_way_between_is_checked():
    """A rod that sweeps over a ball within a half turn is apart from it at both ends, by wide planes."""
    rod, ball = Box([1.0, 0.0, 0.0], [1.0, 0.01, 0.01], STILL), Sphere([0.0, 1.0, 0.0], 0.2)
    scene = (rod, ball, spin(math.pi), None)
    ends = Separated((-0.3, 1.0, 0.0)), Separated((0.3, 1.0, 0.0))
    apart = Span(*ends, 1.0)
    still = Scene((rod, ball), (None, None))
    still.stays_apart(Span(ends[0], ends[0], 1.0), (still.at(Fraction(0)), still.at(Fraction(1))), Fraction(1))
    refused([Spans((apart,))], scene)
    assert sweep(*scene).hit


def test_another_motion_is_refused(proven):
    for name in ("orbit", "corner", "boxes", "planes", "meshes"):
        a, b, one, other = SCENES[name]
        faster = [m if m is None else RigidMotion(1.1 * m.linear, 1.1 * m.angular, m.center) for m in (one, other)]
        with pytest.raises(InvalidCertificate):
            check_sweep(proven[name][0], a, b, *faster)


def test_contacts_that_are_not_are_refused(proven):
    for name, (certificate, (lower, _)) in proven.items():
        if name == "miss":
            continue
        others = [claim for claim in certificate.claims if not isinstance(claim, Touch)]
        (touch,) = [claim for claim in certificate.claims if isinstance(claim, Touch)]
        for time in (float(lower), float(lower) - 1e-6, -0.1, 1.1, math.nan):
            refused([*others, Touch(time, touch.claim)], SCENES[name])


def test_reach_is_proven(proven):
    """Atoms given by planes have none unless shares of planes show it; false shares are refused."""
    certificate, _ = proven["planes"]
    spans = spans_of(certificate)
    refused([spans], SCENES["planes"])
    (boxes,) = [claim for claim in certificate.claims if isinstance(claim, Boxes)]
    ((atom, six),) = boxes.of_a
    refused([Boxes(((atom, (*six[1:], six[0])),)), spans], SCENES["planes"])
    refused([Boxes(((atom, six[:5]),)), spans], SCENES["planes"])  # type: ignore[arg-type]


def test_what_is_inside_a_mesh_is_not_free():
    """Planes between a ball and all triangles around it do not show that it is outside."""
    ball, mesh = Sphere([0.0, 0.0, 0.0], 0.01), Polyhedron(CORNERS, FACES)
    tree = Directions(0.0, []).build(atoms_of(ball), atoms_of(mesh))
    span = Span(tree, tree, 0.1)
    scene = Scene((ball, mesh), (spin(0.1), None))
    scene.stays_apart(span, (scene.at(Fraction(0)), scene.at(Fraction(1, 10))), Fraction(1, 10))
    refused([Spans((span,), (((0.0, 0.0, 0.0),), ()))], (ball, mesh, spin(0.1), None))
    assert certify_sweep(ball, mesh, spin(0.1)).upper == 0


def test_contact_at_the_start():
    """Touching is enough: at t = 0 poses are exact."""
    scene = (
        Sphere([0.0] * 3, 1.0),
        Box([2.0, 0.0, 0.0], [1.0, 1.0, 1.0], STILL),
        spin(1.0),
        spin(2.0, (2.0, 0.0, 0.0)),
    )
    assert check_sweep(certify_sweep(*scene), *scene) == (0, 0)


def test_a_wheel_rolls_close_to_the_floor():
    """About its own axis a cylinder turns into itself: a few spans do, however fast it spins and however near it is."""
    wheel = Cylinder([0.0, 0.5 + 1e-7, 0.0], [0.0, 0.5 + 1e-7, 1.0], 0.5)
    scene = (wheel, FLOOR, spin(90.0, (0.0, 0.5 + 1e-7, 0.0), (1.0, 0.0, 0.0)), None)
    certificate = certify_sweep(*scene)
    assert check_sweep(certificate, *scene) == (math.inf, math.inf)
    assert len(spans_of(certificate).spans) < 5
    slanted = dataclasses.replace(scene[2], angular=[0.0, 1.0, 90.0])
    refused(certificate.claims, (*scene[:2], slanted, None))


def test_far_from_the_origin_contacts_are_as_narrow():
    far = np.array([1e7, -1e7, 1e7])
    a, b, one, other = SCENES["boxes"]
    moved = (RigidMotion(m.linear, m.angular, m.center + far) for m in (one, other))
    scene = (a.translated(far), b.translated(far), *moved)
    lower, upper = check_sweep(certify_sweep(*scene), *scene)
    assert 0.33 < lower <= upper <= lower + Fraction(NARROW)


def test_an_exact_graze_is_undecided():
    """The ball's lowest place is irrational in time: no proof of contact, and none of its absence."""
    scene = (Sphere([1.0, 0.0, 0.0], 0.25), HalfSpace([0.0, 1.0, 0.0], 1.25), spin(-3.0), None)
    lower, upper = check_sweep(certify_sweep(*scene), *scene)
    with mp.workdps(50):
        time = mp.pi / 6
        assert mpf(float(lower)) <= time <= mpf(float(lower)) + mpf(1e-6)
    assert upper == math.inf
    assert sweep(*scene).hit


def test_random_spans_that_pass_are_free():
    """Whatever span the checker accepts, stepping in doubles finds no contact in it; it accepts many, not all."""
    draw = np.random.default_rng(9)
    accepted = total = 0
    for _ in range(25):
        a = Capsule(*draw.normal(size=(2, 3)) * 0.5, 0.2)
        b = Box(draw.normal(size=3) + np.array([2.0, 0.0, 0.0]), draw.uniform(0.1, 0.6, 3), draw.normal(size=4))
        motions = [RigidMotion(*draw.normal(size=(3, 3)) * np.array([[1.0], [2.0], [0.5]])) for _ in range(2)]
        scene = Scene((a, b), tuple(motions))
        start, length = draw.uniform(0, 0.2), draw.uniform(0.05, 0.8)
        stop = start + length
        ways = [distance(*(m.placed(s, t) for s, m in zip((a, b), motions, strict=True))).normal for t in (start, stop)]
        trees = [Separated(tuple((n + draw.normal(size=3) * 0.01).tolist())) for n in ways]
        moments = scene.at(Fraction(start)), scene.at(Fraction(stop))
        total += 1
        try:
            scene.stays_apart(Span(*trees, stop), moments, Fraction(stop) - Fraction(start))
        except InvalidCertificate:
            continue
        accepted += 1
        t = np.linspace(start, stop, 40)
        assert np.all(distance(*(m.placed(s, t) for s, m in zip((a, b), motions, strict=True))).distance > 0)
    assert 4 < accepted < total - 4


def test_unions_that_both_turn_are_enclosed_as_narrowly_as_others():
    """The planes between a box and the parts of a union hold for the shorter, the nearer these are to each other."""
    place = [0.3, 1.7, 0.2]
    union = Composite([Box([0, 0, 0], [1, 0.5, 0.75], STILL), Sphere([1.2, 0, 0], 0.5)])
    thrown = RigidMotion([0, -0.5, 0], [1.5, -1, 1.5], place)
    turning = RigidMotion([0, 0, 0], [-1.2, 0.7, -0.7], [0, 0, 0])
    found = certify_sweep(Box(place, [0.2, 0.3, 0.4], STILL), union, thrown, turning)
    assert 0 < found.lower < found.upper < found.lower + NARROW
