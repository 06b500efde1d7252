"""A finding told in a sentence: what the engine says and what is true, in digits that tell them apart."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles import claims
from oracles.outcome import Bucket, Finding, Kind, Severity, State, Verdict
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, TYPES, Scene
from refimpl import AABB, KDOP, Box, Capsule, Composite, Cylinder, Ellipsoid, HalfSpace, Point, Ray, Sphere, flat
from reports.brief import FEWEST, MOST, digits, digits_to_differ, in_brief, pair_in_brief, simplest
from reports.story import TOLD, fact, story
from tests.sample_impact import FLAT
from tests.sample_run import STONE, WEDGE

CUBE = Box([0, 0, 0], [0.5, 0.5, 0.5], [0, 0, 0, 1])
AWAY = Box([0, 4, 0], [0.5, 0.5, 0.5], [0, 0, 0, 1])
APART = Scene(DISTANCE, CUBE, AWAY, "aligned")
FINITE = st.floats(-1e300, 1e300)


def finding(
    scene: Scene, symptom: str, lower: float, upper: float, said: float | None = None, **more: object
) -> Finding:
    verdict = Verdict(Kind.WRONG, symptom, Severity.LARGE, 0.25, lower, upper)
    answer = {} if said is None else {"distance": said}
    plain = Finding("FCL", scene, answer, {"normal": [0.0, 1.0, 0.0]}, verdict)
    return dataclasses.replace(plain, **more)


def test_two_cubes_three_apart() -> None:
    found = finding(APART, claims.LONG, 3.0, 3.0, 3.16227766)
    assert fact(found) == "FCL says a gap of 3.162 for two unit cubes 3 apart along y; it is 3, proven."
    bucket = Bucket("FCL", DISTANCE, "Box–Box", claims.LONG, "aligned", -2, found, count=5, regimes=Counter(aligned=5))
    assert story(bucket).endswith("Seen 5 times in this run; no entry of the ledger explains it: it is new.")
    known = dataclasses.replace(bucket, state=State.EXPECTED, entry="a-cause")
    assert story(known).endswith("Seen 5 times in this run; known as a-cause.")


@pytest.mark.parametrize(
    ("symptom", "lower", "upper", "said", "words"),
    [
        (claims.SHORT, 0.5, 0.5, 0.0, "says a distance of 0 for two unit cubes; they are 0.5 apart, proven"),
        (claims.LONG, -0.5, -0.5, 0.25, "0.25 for two unit cubes; they overlap by 0.5, proven"),
        (claims.LONG, 0.0, 0.0, 1e-9, "says a gap of 1e-09 for two unit cubes; they touch, proven"),
        (claims.LONG, -1e-18, 1e-19, 1e-9, "they touch, to within 1e-18, proven"),
        (claims.LONG, -0.498, -0.492, -0.274, "a depth of 0.274 for two unit cubes; it is between 0.492 and 0.498"),
        (claims.MISSED, -0.5, -0.5, None, "says that two unit cubes do not touch; they overlap by 0.5, proven"),
        (claims.FALSE, 0.125, 0.125, None, "says that two unit cubes touch; they are 0.125 apart, proven"),
        (claims.MISSED, -math.inf, -math.inf, None, "they overlap without end, proven"),
        (claims.STUCK, -0.5, -0.5, 1.0, "B moved so far along it, they still overlap by 0.5, proven"),
        (claims.NOT_A_NUMBER, 1.0, 1.0, math.nan, "FCL gives two unit cubes an answer that is not a number."),
        ("something else", math.nan, math.nan, None, "something else, by at least 0.25, proven"),
    ],
)
def test_what_is_said_and_what_is_true(
    symptom: str, lower: float, upper: float, said: float | None, words: str
) -> None:
    told = fact(finding(APART, symptom, lower, upper, said, reference={}))
    assert words in told
    assert told.startswith("FCL ")


@pytest.mark.parametrize("symptom", TOLD)
def test_every_symptom_has_a_sentence_without_gaps(symptom: str) -> None:
    told = fact(finding(dataclasses.replace(APART, query=CONTACTS), symptom, 0.5, 0.5))
    assert told.endswith(", proven.")
    assert "two unit cubes" in told
    assert not set("{}") & set(told)


@pytest.mark.parametrize("kind", [kind for kind in Kind if kind is not Kind.WRONG])
def test_answers_that_never_came_or_contradict_each_other(kind: Kind) -> None:
    verdict = Verdict(kind, "a symptom", lower=-1.0, upper=-1.0)
    told = fact(finding(dataclasses.replace(APART, query=BOOLEAN), "", 0.0, 0.0, verdict=verdict))
    lost = {Kind.TIMED_OUT: "does not answer in time for two unit cubes, which overlap by 1."}
    assert lost.get(kind, "a symptom") in told


def test_impact_names_the_law_and_the_least_change() -> None:
    told = fact(finding(FLAT, "energy is gained", 0.25, 0.25))
    assert "energy is gained; no velocities nearer than 0.25 to its answer fulfil the law, proven" in told


def test_shapes_in_brief() -> None:
    turned = [0, 0, 0, 1]
    said = {
        "a point": Point([0, 0, 0]),
        "a ray": Ray([0, 0, 0], [1, 0, 0]),
        "a half-space": HalfSpace([0, 0, 1], 0),
        "a sphere of radius 0.5": Sphere([0, 0, 0], 0.5),
        "a capsule of radius 0.25 and length 3": Capsule([0, 0, 0], [0, 0, 3], 0.25),
        "a cylinder of radius 0.25 and height 3": Cylinder([0, 0, 0], [0, 0, 3], 0.25),
        "an AABB of 1 × 2 × 3": AABB([0, 0, 0], [1, 2, 3]),
        "a box of side 4": Box([0, 0, 0], [2, 2, 2], turned),
        "an ellipsoid of radii 1, 2, 3": Ellipsoid([0, 0, 0], [1, 2, 3], turned),
        "a KDOP of 3 slabs": KDOP([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0], [1, 1, 1]),
        "a convex polyhedron of 120 vertices": STONE,
        "a mesh of 4 triangles": WEDGE,
        "a union of 2 parts": Composite([CUBE, AWAY]),
        "a point of the plane": flat.FlatPoint([0, 0]),
        "a ray of the plane": flat.FlatRay([0, 0], [1, 0]),
        "a disc of radius 0.5": flat.Disc([0, 0], 0.5),
        "a segment of length 5 and radius 0.25": flat.Segment([0, 0], [3, 4], 0.25),
        "a rectangle of 1 × 2": flat.Rectangle([0, 0], [1, 2]),
        "a convex polygon of 3 corners": flat.ConvexPolygon.from_vertices([[0, 0], [1, 0], [0, 1], [0.25, 0.25]]),
    }
    assert {type(shape).__name__ for shape in said.values()} == TYPES.keys()
    assert [in_brief(shape) for shape in said.values()] == list(said)
    assert pair_in_brief(AWAY, WEDGE) == "a unit cube and a mesh of 4 triangles"
    assert pair_in_brief(WEDGE, WEDGE) == "two meshes of 4 triangles"


@given(FINITE, FINITE)
def test_digits_tell_numbers_apart(said: float, true: float) -> None:
    count = digits_to_differ(said, true)
    assert FEWEST < count <= MOST
    assert (digits(said, count) != digits(true, count)) == (said != true)


@given(FINITE, st.floats(0.0, 1e300))
def test_simplest_number_lies_in_its_interval(lower: float, width: float) -> None:
    upper = lower + width
    found = simplest(lower, upper)
    assert lower <= found <= upper
    assert significant(found) <= significant(lower + (upper - lower) / 2)


def significant(number: float) -> int:
    return len(Decimal(repr(number)).normalize().as_tuple().digits)
