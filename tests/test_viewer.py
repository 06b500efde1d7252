"""Pictures of buckets as data and as still SVG: every type, any size, whatever an engine answers."""

from __future__ import annotations

import json
import math
import re
import xml.etree.ElementTree as ET
from fractions import Fraction
from html.parser import HTMLParser
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from oracles.motion import Motion, Moving
from oracles.outcome import Kind
from oracles.scene import BOOLEAN, IMPACT, RAYCAST, Scene
from refimpl import (
    AABB,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Proxy,
    Ray,
    Sphere,
    distance,
)
from refimpl.pairs import TABLE
from refimpl.proof import Certificate, Common, Escape, Near, Separated, certify
from reports import viewer
from reports.viewer.cut import nearest
from reports.viewer.frame import VIEWS, best_view, farthest
from reports.viewer.meshes import polygons
from reports.viewer.page import SCRIPTS, UNITS
from reports.viewer.scene import Picture, picture_of
from reports.viewer.solids import Lathe, Mesh, Plane, Solid, solids
from tests.sample_impact import FLAT
from tests.sample_run import sample_run
from tests.viewed import KINDS, points, stone, torus, viewed

PAIRS = list(TABLE)
TYPICAL_SVG, LARGEST_SVG, LARGEST_DATA = 1_500, 3_500, 4_500
LARGEST_SCRIPT = 25 * 1024
IDS = [f"{a.__name__}-{b.__name__}" for a, b in PAIRS]


def dumped(bucket: Any) -> str:
    return json.dumps(viewer.scene_data(bucket), allow_nan=False, separators=(",", ":"))


def numbers_of(data: Any) -> list[float]:
    """Every number of the bodies and marks."""
    if isinstance(data, list):
        return [x for item in data for x in numbers_of(item)]
    return [] if isinstance(data, str) else [data]


def bodies(picture: Picture) -> list[Solid]:
    return [*picture.a, *picture.b]


# -- every type ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("A", "B"), PAIRS, ids=IDS)
def test_every_pair_is_drawn_within_its_frame(A: type[Proxy], B: type[Proxy]) -> None:
    bucket = viewed(KINDS[A], KINDS[B], answer=points([0.5, 0, 0], [1, 0, 0]), reference=points([0, 0, 0], [1, 0, 0]))
    picture, data = picture_of(bucket), viewer.scene_data(bucket)
    assert picture.a
    assert picture.b
    for part in bodies(picture):
        if isinstance(part, Plane):
            assert abs(part.foot @ part.normal) < 1
        elif not getattr(part, "endless", False):
            assert farthest(part, np.zeros(3)) <= 1
    drawn = numbers_of([data["a"], data["b"], data["marks"]])
    assert all(math.isfinite(x) and abs(x) <= 3 * UNITS for x in drawn)
    assert {mark[0] for mark in data["marks"]} == {"engine", "truth"}
    assert len(dumped(bucket)) < LARGEST_DATA


@pytest.mark.parametrize(("A", "B"), PAIRS, ids=IDS)
def test_the_still_picture_is_well_formed_and_small(A: type[Proxy], B: type[Proxy]) -> None:
    bucket = viewed(KINDS[A], KINDS[B], answer=points([0.5, 0, 0], [1, 0, 0]))
    svg = viewer.static_svg(bucket)
    root = ET.fromstring(svg)
    assert root.attrib["role"] == "img"
    assert root[0].tag == "title"
    assert A.__name__ in (root[0].text or "")
    assert not any(name in element.attrib for element in root.iter() for name in ("style", "id", "onload"))
    classes = " ".join(element.attrib.get("class", "") for element in root.iter()).split()
    assert {"a", "b", "engine"} <= set(classes)
    assert len(svg) < (TYPICAL_SVG if not {A.__name__, B.__name__} & {"Composite", "KDOP"} else LARGEST_SVG)
    assert not re.search(r"nan|inf", re.sub(r"<title>.*</title>", "", svg))


def test_the_same_bucket_gives_the_same_picture() -> None:
    for first, second in zip(sample_run().buckets, sample_run().buckets, strict=True):
        assert dumped(first) == dumped(second)
        assert viewer.static_svg(first) == viewer.static_svg(second)
        assert viewer.picture(first) == viewer.picture(second)


# -- faces ---------------------------------------------------------------------------------------------------


def faces_of(shape: Proxy) -> Mesh:
    (mesh,) = solids(shape, 0)[0]
    assert isinstance(mesh, Mesh)
    return mesh


@pytest.mark.parametrize(
    ("shape", "sizes"),
    [
        (Box([1, 2, 3], [1, 2, 3], [0, 0, 0, 1]), [4] * 6),
        (ConvexPolyhedron.from_vertices([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), [3] * 4),
        (ConvexPolyhedron.from_vertices([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), [4] * 2),
        (ConvexPolyhedron.from_vertices([[0, 0, 0], [1, 0, 0]]), [2]),
        (ConvexPolyhedron.from_vertices([[1, 2, 3]]), [1]),
    ],
    ids=["box", "tetrahedron", "square", "segment", "point"],
)
def test_faces_are_the_polygons_of_the_hull(shape: Proxy, sizes: list[int]) -> None:
    mesh = faces_of(shape)
    assert sorted(len(face) for face in mesh.faces) == sizes
    middle = mesh.vertices.mean(axis=0)
    for face in mesh.faces:
        ring = mesh.vertices[list(face)]
        if len(face) > 2:
            normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
            assert normal @ (ring[0] - middle) >= 0
            assert np.ptp(ring @ normal) < 1e-12


def test_polygons_of_every_polytope_close_its_surface() -> None:
    for shape in KINDS.values():
        if hasattr(shape, "hull"):
            _, faces = polygons(shape.hull)
            edges = [(f[k - 1], f[k]) for f in faces for k in range(len(f))]
            assert len(edges) == len(set(edges))
            assert {(j, i) for i, j in edges} == set(edges)


def test_a_hull_of_many_corners_is_drawn_with_some_of_them_and_says_so() -> None:
    shape = stone(500)
    picture = picture_of(viewed(shape, Sphere([3, 0, 0], 1)))
    (mesh,) = solids(shape, 0)[0]
    assert isinstance(mesh, Mesh)
    given = {tuple(v) for v in shape.vertices.tolist()}
    assert all(tuple(v) in given for v in mesh.vertices.tolist())
    assert f"A is drawn with the hull of {len(mesh.vertices)} of 500 corners." in picture.notes
    volume = np.ptp(mesh.vertices, axis=0)
    assert (volume > 1.8).all()
    assert len(dumped(viewed(shape, shape.translated([3, 0, 0])))) < 2 * LARGEST_DATA


def test_a_mesh_of_many_triangles_is_drawn_with_fewer_and_says_so() -> None:
    ring = torus(40, 20)
    picture = picture_of(viewed(Sphere([0, 0, 0], 0.5), ring))
    (mesh,) = picture.b
    assert isinstance(mesh, Mesh)
    assert 40 <= len(mesh.faces) <= 128
    assert f"B is drawn with {len(mesh.faces)} of 1600 triangles." in picture.notes
    hole = np.hypot(*(mesh.vertices - mesh.vertices.mean(axis=0))[:, :2].T)
    assert hole.min() > 0.3 * hole.max()


def test_few_triangles_and_corners_are_drawn_as_they_are() -> None:
    for shape in (torus(6, 5), stone(30)):
        assert solids(shape, 0)[1] == []


def test_of_very_many_parts_the_largest_are_drawn() -> None:
    many = Composite([Sphere([k, 0, 0], 0.25 + k / 128) for k in range(40)])
    picture = picture_of(viewed(many, Sphere([0, 3, 0], 1)))
    assert "A is drawn with 24 of 40 parts." in picture.notes
    assert len(picture.a) == 24


# -- any size ------------------------------------------------------------------------------------------------

SIZED = [(Sphere, Box), (Capsule, Cylinder), (HalfSpace, Ellipsoid), (AABB, ConvexPolyhedron), (Point, Composite)]


@pytest.mark.parametrize("power", [-900, -40, 40, 900])
@pytest.mark.parametrize("pair", SIZED, ids=lambda pair: f"{pair[0].__name__}-{pair[1].__name__}")
def test_a_scene_of_any_size_gives_the_same_picture(pair: tuple[type[Proxy], type[Proxy]], power: int) -> None:
    def data(exponent: int) -> dict[str, Any]:
        a, b = (KINDS[kind].times_power(exponent) for kind in pair)
        said = {"on_a": [math.ldexp(0.5, exponent), 0.0, 0.0], "on_b": [math.ldexp(1.0, exponent), 0.0, 0.0]}
        return viewer.scene_data(viewed(a, b, answer=said, reference=said))

    usual, other = data(0), data(power)
    assert other.pop("size") == pytest.approx(math.ldexp(usual.pop("size"), power), rel=1e-5)
    assert other == usual


def test_at_the_end_of_the_doubles_there_is_a_picture_but_no_scale() -> None:
    top = math.ldexp(1.0, 1023)
    data = viewer.scene_data(viewed(Sphere([top, top, 0], top), AABB([-top] * 3, [top] * 3)))
    assert data["size"] is None
    assert len(data["a"]) == len(data["b"]) == 1


T = 5e-324
EXTREMES = [
    Sphere([0, 0, 0], T),
    Sphere([1e308, 0, 0], 1e308),
    Ray([0, 0, 0], [1e300, 0, 0]),
    Ray([1e308, 0, 0], [0, 0, 1e-310]),
    HalfSpace([1e-320, 0, 0], 0),
    HalfSpace([1e300, 1e300, 0], 1e300),
    Capsule([0, 0, 0], [T, 0, 0], 0),
    Capsule([-1e308, 0, 0], [1e308, 0, 0], T),
    Cylinder([0, 0, 0], [T, 0, 0], 1e300),
    Cylinder([-1e308, 0, 0], [1e308, 0, 0], 1),
    Ellipsoid([0, 0, 0], [1e308, T, 1]),
    AABB([0, 0, 0], [0, 0, 0]),
    Box([0, 0, 0], [1e-160, 1e160, 1], [1e-200, 0, 0, 1e200]),
    ConvexPolyhedron.from_vertices([[0, 0, 0], [1e-300, 0, 0], [0, 1e300, 0], [1, 1, 1]]),
    Composite([Sphere([0, 0, 0], T), HalfSpace([0, 0, 1], 1e308)]),
]


@pytest.mark.parametrize("number", range(len(EXTREMES)))
def test_the_ends_of_the_doubles_break_no_picture(number: int) -> None:
    shape = EXTREMES[number]
    others = [Sphere([0, 0, 0], 1), Box([1, 0, 0], [1, 0, T], TURN), EXTREMES[number - 1], EXTREMES[1]]
    for other in others:
        far = points([1e308, -1e308, T], [1, 1, 1])
        bucket = viewed(shape, other, answer=far, reference=far, interval=(T, 1e308))
        data = viewer.scene_data(bucket)
        assert all(abs(x) <= 10 * UNITS for x in numbers_of([part[1] for part in (*data["a"], *data["b"])]))
        json.dumps(data, allow_nan=False)
        ET.fromstring(viewer.static_svg(bucket))


def test_far_away_the_picture_is_the_same() -> None:
    far = np.array([2.0**40, -(2.0**41), 2.0**39])
    boxes = Box([0, 0, 0], [1, 0.5, 2], TURN), Sphere([3, 0, 0], 1)
    near, away = (picture_of(viewed(*(b.translated(shift) for b in boxes))) for shift in (0 * far, far))
    for one, other in zip(bodies(near), bodies(away), strict=True):
        assert np.allclose(one.corners(), other.corners(), atol=1e-3)


TURN = (0.25, 0.5, -0.125, 0.75)


@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e9, 1e12])
@pytest.mark.parametrize("kind", [Sphere, Box, AABB, Ellipsoid, Cylinder, Capsule, Composite])
def test_beside_a_giant_the_small_one_is_shown_large(kind: type[Proxy], ratio: float) -> None:
    small = Sphere([0, 0, ratio + 1.5], 1)
    giant: dict[type[Proxy], Proxy] = {
        Sphere: Sphere([0, 0, 0], ratio),
        Box: Box([0, 0, 0], [ratio] * 3, [0, 0, 0, 1]),
        AABB: AABB([-ratio] * 3, [ratio] * 3),
        Ellipsoid: Ellipsoid([0, 0, 0], [2 * ratio, 3 * ratio, ratio]),
        Cylinder: Cylinder([0, 0, -ratio], [0, 0, ratio], ratio),
        Capsule: Capsule([-ratio, 0, ratio - 1], [ratio, 0, ratio - 1], 1),
        Composite: Composite([Box([0, 0, 0], [ratio] * 3, [0, 0, 0, 1]), Sphere([ratio, 0, 0], ratio)]),
    }
    picture = picture_of(viewed(small, giant[kind]))
    (ball,) = picture.a
    assert isinstance(ball, Lathe)
    assert ball.reach(np.array([0, 0, 1.0])) > 0.5
    assert "The picture shows the surroundings of the smaller of the two." in picture.notes
    assert any("far larger than the picture" in note for note in picture.notes)
    below = ball.center[2] - 1.5 * ball.reach(np.array([0.0, 0.0, 1.0]))
    heights = [part.foot[2] if isinstance(part, Plane) else part.corners()[:, 2].max() for part in picture.b]
    assert max(heights) == pytest.approx(below, abs=0.01)
    assert all(np.abs(part.corners()).max(initial=0) < 15 for part in picture.b)


def test_within_a_giant_nothing_else_is_seen_and_that_is_said() -> None:
    for giant in (Sphere([0, 0, 0], 1e6), AABB([-1e6] * 3, [1e6] * 3), Cylinder([0, 0, -1e6], [0, 0, 1e6], 1e6)):
        picture = picture_of(viewed(Sphere([0, 0, 0], 1), giant))
        assert picture.b == []
        assert "B is far larger than the picture and surrounds all that is seen." in picture.notes


def test_what_is_too_small_is_a_dot_and_that_is_said() -> None:
    picture = picture_of(viewed(Sphere([0, 0, 0], 1e-6), Sphere([1e3, 0, 0], 1e-6)))
    assert {type(part).__name__ for part in bodies(picture)} == {"Dot"}
    assert "A is too small for this picture: it is drawn as a dot." in picture.notes


def test_a_gap_below_a_pixel_is_told() -> None:
    a, b = Sphere([0, 0, 0], 1), AABB([1 + 2.0**-40, -1, -1], [3, 1, 1])
    (note,) = picture_of(viewed(a, b, interval=(2.0**-40, 2.0**-40))).notes[:1]
    assert note.startswith("The gap of 9.09e-13 is 3e-13 of the picture's radius")
    notes = picture_of(viewed(a, b, interval=(0.5, 0.5))).notes
    assert not any("gap" in note for note in notes)


@pytest.mark.parametrize("thin", [0.0, 1e-9, 1e-300])
def test_slivers_are_drawn_flat(thin: float) -> None:
    picture = picture_of(viewed(Box([0, 0, 0], [1, 1, thin], TURN), Sphere([0, 0, 2], 0.5)))
    (sheet,) = picture.a
    assert isinstance(sheet, Mesh)
    assert len(sheet.faces) == 6
    assert farthest(sheet, sheet.vertices.mean(axis=0)) > 0.3


def test_a_rod_thinner_than_a_pixel_is_a_line() -> None:
    for shape in (
        Capsule([0, 0, 0], [1, 0, 0], 1e-9),
        Cylinder([0, 0, 0], [1, 0, 0], 1e-9),
        Capsule([0] * 3, [1] * 3, 0),
    ):
        picture = picture_of(viewed(shape, Sphere([0, 2, 0], 1)))
        assert [type(part).__name__ for part in picture.a] == ["Line"]


@pytest.mark.parametrize(
    "shape",
    [
        Ellipsoid([0.5, 0, 1], [3, 1, 0.25], TURN),
        Sphere([1, 1, 1], 2),
        Capsule([0, 0, 0], [1, 2, 3], 0.5),
        Cylinder([0, 0, 0], [1, 2, 3], 0.5),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_the_nearest_point_of_a_round_body_is_the_references(shape: Proxy) -> None:
    (lathe,) = solids(shape, 0)[0]
    assert isinstance(lathe, Lathe)
    for place in np.random.default_rng(1).normal(scale=3, size=(40, 3)):
        true = distance(Point(place), shape)
        foot, normal = nearest(lathe, place)
        if true.distance > 0:
            assert np.allclose(foot, true.on_b, atol=1e-6)
            assert np.allclose(normal, -true.normal, atol=1e-6)


# -- views ---------------------------------------------------------------------------------------------------


def test_views_are_right_handed_and_show_normals_from_the_side() -> None:
    for view in VIEWS:
        right, up, eye = view.axes
        assert np.allclose(np.cross(right, up), eye)
        assert up[2] > 0
    for normal in np.eye(3):
        eye = best_view([normal], [normal]).axes[2]
        assert 0.05 < eye @ normal < 0.5


# -- answers -------------------------------------------------------------------------------------------------

STRANGE: list[Any] = [
    math.nan,
    math.inf,
    "1, 2, 3",
    b"abc",
    None,
    [1, 2],
    [1, 2, 3, 4],
    ["a", "b", "c"],
    [math.nan, 0, 0],
    [math.inf, 0, 0],
    [1e308, 1e308, 1e308],
    [10**400, 0, 0],
    [Fraction(1, 3), 0, 0],
    [[1], [2], [3]],
    {"x": 1},
    np.array([0.5, np.nan, 0]),
    np.zeros(3),
    np.zeros((3, 3)),
    [True, False, True],
    [None, None, None],
    [0.0, -0.0, 5e-324],
]


@pytest.mark.parametrize("value", STRANGE, ids=lambda value: f"{type(value).__name__} {str(value)[:12]}")
def test_strange_answers_leave_the_picture_whole(value: Any) -> None:
    names = ("hit", "distance", "on_a", "on_b", "normal", "t", "point", "velocity_a", "angular_b", 7)
    answer = dict.fromkeys(names, value)
    for a, b, query in (
        (KINDS[Sphere], KINDS[Box], ""),
        (KINDS[Ray], KINDS[Box], RAYCAST),
        (KINDS[Sphere], KINDS[Box], BOOLEAN),
    ):
        bucket = viewed(a, b, query, answer=answer, reference=answer)
        data = viewer.scene_data(bucket)
        assert all(abs(x) <= 4 * UNITS for x in numbers_of([data["a"], data["b"], data["marks"]]))
        ET.fromstring(viewer.static_svg(bucket))
        ET.fromstring(viewer.picture(bucket))
        json.dumps(data, allow_nan=False)


@pytest.mark.parametrize("answer", [None, [], "none", 3.5, math.nan], ids=str)
def test_no_answer_at_all_leaves_the_bodies(answer: Any) -> None:
    bucket = viewed(KINDS[Sphere], KINDS[Box], answer=answer, reference=answer, kind=Kind.CRASHED)
    data = viewer.scene_data(bucket)
    assert data["a"]
    assert data["marks"] == []
    assert ["engine", "fcl: distance too large"] in data["said"]
    assert "The engine names nothing that could be drawn here." in picture_of(bucket).notes


def test_a_point_far_off_is_told_and_not_drawn() -> None:
    picture = picture_of(viewed(KINDS[Sphere], KINDS[Box], answer=points([1e6, 0, 0], [0, 0, 0])))
    assert [mark.label for mark in picture.marks if mark.kind == "dot"] == ["b"]
    assert any(note.startswith("The engine's point on A lies outside the picture, ") for note in picture.notes)


def test_both_answers_stand_in_the_corner_with_as_many_digits_as_tell_them_apart() -> None:
    a, b = KINDS[Sphere], KINDS[Box]

    def said(answer: object, reference: object, query: str = "", **more: Any) -> list[list[str]]:
        found: list[list[str]] = viewer.scene_data(viewed(a, b, query, answer=answer, reference=reference, **more))[
            "said"
        ]
        return found

    assert said({"distance": 3.162278}, {"distance": 3.0}) == [
        ["engine", "fcl: distance 3.162"],
        ["truth", "true: distance 3"],
    ]
    assert said({"distance": 1.0000001}, {"distance": 1.0})[0][1] == "fcl: distance 1.0000001"
    assert said({"distance": math.nan}, {"distance": 1.0})[0][1] == "fcl: not a number"
    assert said({"distance": 3.0}, {"distance": 1.0}, interval=(2.0, 2.0001))[1][1] == "true: distance 2"
    assert said({"distance": 3.0}, {"distance": 1.0}, interval=(0.5, 2.0))[1][1] == "true: distance 1"
    assert said({"distance": 1.5}, {"distance": 1.5})[0][1] == "fcl: distance 1.5, distance too large"
    assert said({"distance": -0.5}, {"distance": -math.inf})[1][1] == "true: overlap without end"
    assert said({"hit": False}, {"hit": True}, BOOLEAN)[0][1] == "fcl: no overlap"
    assert said({"hit": False}, {"hit": True}, BOOLEAN, interval=(-0.75, -0.75))[1][1] == "true: overlap, depth 0.75"


def test_a_ray_hits_where_its_time_says() -> None:
    ray, ball = Ray([-4, 0, 0], [2, 0, 0]), Sphere([0, 0, 0], 1)
    picture = picture_of(viewed(ray, ball, answer={"t": 2.0}, reference={"t": 1.5, "point": [-1, 0, 0]}))
    scale = picture.size
    spots = {mark.layer: mark.at * scale for mark in picture.marks if mark.kind == "dot"}
    (body,) = picture.b
    assert isinstance(body, Lathe)
    assert spots["engine"] == pytest.approx(body.center * scale, abs=1e-9)
    assert spots["truth"] == pytest.approx(body.center * scale - [1, 0, 0], abs=1e-9)


def test_an_impact_shows_velocities_before_and_after() -> None:
    said = {"velocity_b": [0.5, 0.0, 0.25], "angular_b": [0.0, 0.5, 0.0]}
    true = {"velocity_b": [0.5, 0.0, 1.0], "angular_b": [0.0, 0.0, 0.0]}
    bucket = viewed(FLAT.a, FLAT.b, answer=said, reference=true)
    finding = bucket.witness
    object.__setattr__(finding, "scene", FLAT)
    picture = picture_of(bucket)
    arrows = {(m.layer, m.label): m.to - m.at for m in picture.marks if m.kind in ("arrow", "spin")}
    assert set(arrows) == {("given", "v"), ("given", "n"), ("truth", "v′"), ("engine", "v′"), ("engine", "ω′")}
    before = arrows["given", "v"]
    assert before / before[0] == pytest.approx([1, 0, -4])
    assert np.linalg.norm(arrows["engine", "v′"]) / np.linalg.norm(before) == pytest.approx(
        math.hypot(0.5, 0.25) / math.hypot(0.5, 2)
    )
    assert "The longest arrow v is a velocity of 2.06." in picture.notes


def test_bodies_at_rest_have_no_arrows() -> None:
    still = Moving(np.zeros(3), np.zeros(3), np.zeros(3), np.array(1.0), np.eye(3))
    motion = Motion(still, still, np.zeros(3), np.array([1.0, 0, 0]), np.array(0.5), np.array(0.0))
    scene = Scene(IMPACT, Sphere([-1, 0, 0], 1), Sphere([1, 0, 0], 1), "head_on", "", motion)
    bucket = viewed(scene.a, scene.b)
    object.__setattr__(bucket.witness, "scene", scene)
    assert {mark.label for mark in picture_of(bucket).marks} == {"", "n"}


# -- proofs --------------------------------------------------------------------------------------------------


def test_the_separating_plane_lies_between_the_two() -> None:
    a, b = Sphere([0, 0, 0], 1), Box([4, 1, 0], [1, 1, 1], TURN)
    true = distance(a, b)
    picture = picture_of(viewed(a, b, reference={"on_a": true.on_a, "on_b": true.on_b}, certificate=certify(a, b)))
    (plane,) = [mark for mark in picture.marks if mark.kind == "plane"]
    on_a, on_b = (mark.at for mark in picture.marks if mark.layer == "truth" and mark.kind == "dot")
    assert on_a @ plane.to < plane.at @ plane.to < on_b @ plane.to
    assert plane.at @ plane.to == pytest.approx((on_a + on_b) / 2 @ plane.to, abs=1e-3)


@pytest.mark.parametrize("power", [-900, 0, 900])
def test_claims_are_drawn_at_any_size(power: int) -> None:
    unit = Fraction(2) ** power
    a, b = Sphere([0, 0, 0], 2).times_power(power), AABB([1, -1, -1], [3, 1, 1]).times_power(power)
    point = (Fraction(3, 2) * unit, Fraction(0), Fraction(0))
    claims = (Common(point), Near(point, (unit, unit, unit)), Escape((10**400, 0, 0)), Separated((0, 0, 0)))
    found = [m for m in picture_of(viewed(a, b, certificate=Certificate(claims))).marks if m.layer == "proof"]
    assert [(m.kind, m.label) for m in found] == [("dot", "common point"), ("line", ""), ("plane", "way out")]
    assert found[0].at == pytest.approx(found[1].at)
    assert found[2].at[0] > found[0].at[0]


def test_the_proofs_own_proxies_are_drawn_where_they_belong_to_the_scene() -> None:
    a, b = KINDS[Sphere], KINDS[Box]
    witness = Scene("distance", Point([3, 0, 0]), b, "generic")
    length = Scene("distance", Point([0.5, 0, 0]), Sphere([0, 0, 0], 1), "generic")
    moved = Scene("distance", a, b.translated([1, 0, 0]), "generic")
    grown = Scene("distance", Point([0.5, 0, 0.25]), Sphere([0.5, 0, 0], 1), "generic")
    scenes = (None, witness, moved, length, grown)
    said = points([0.5, 0, 0.25], [1, 1, 1])
    assert [len(picture_of(viewed(a, b, proof_scene=scene, answer=said)).ghost) for scene in scenes] == [0, 1, 1, 0, 2]


# -- the page's part -----------------------------------------------------------------------------------------


class Figure(HTMLParser):
    """The attributes of what a figure consists of."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))


HOSTILE = "</figure><script>alert(1)</script>' \" onload='x' & &lt; \u202e \ud800 \x00 ]]> ${7} `"


def test_a_figure_holds_its_data_and_obeys_nobody() -> None:
    for claim in ("plain", HOSTILE):
        bucket = viewed(KINDS[Sphere], KINDS[Box], engine=claim, claim=claim, answer=points([0, 0, 0], [1, 0, 0]))
        source = str(viewer.figure(bucket))
        found = Figure(source)
        names = [tag for tag, _ in found.tags]
        assert names[:2] == ["figure", "svg"]
        assert "script" not in names
        assert set(names) <= {"figure", "svg", "title", "path", "circle", "ellipse", "text", "figcaption"}
        assert json.loads(found.tags[0][1]["data-scene"] or "") == viewer.scene_data(bucket)
        assert set(found.tags[0][1]) == {"class", "data-scene"}
        source.encode("utf-8")


def test_a_file_stands_alone() -> None:
    for claim in ("plain", HOSTILE):
        source = viewer.picture(viewed(KINDS[HalfSpace], KINDS[Box], claim=claim, engine=claim))
        root = ET.fromstring(source)
        assert [child.tag.removeprefix("{http://www.w3.org/2000/svg}") for child in root][:3] == [
            "title",
            "desc",
            "style",
        ]
        assert root.attrib["width"]
        style = root[2].text or ""
        assert set(re.findall(r"var\((--\w+)\)", style)) <= set(re.findall(r"(--\w+):", style))
        assert not re.search(r"https?:(?!//www\.w3\.org/2000/svg)|url\(|@import", source)


def test_the_script_is_small_and_keeps_to_itself() -> None:
    script = viewer.script()
    assert len(script.encode()) <= LARGEST_SCRIPT
    for word in (
        "eval",
        "innerHTML",
        "Function(",
        "http",
        "setAttribute('style",
        "document.write",
        "console",
        "import(",
    ):
        assert word not in script
    assert script.startswith("(() => {\n'use strict';")
    assert "</" not in script


def test_making_the_script_small_changes_no_text_in_it() -> None:
    own = "\n".join(files("reports.viewer").joinpath(name).read_text(encoding="utf-8") for name in SCRIPTS)
    texts = re.findall(r"'[^'\n]*'", "\n".join(line for line in own.splitlines() if not line.strip().startswith("//")))
    assert len(texts) > 100
    assert all(text in viewer.script() for text in texts)


def test_the_style_defines_what_it_uses() -> None:
    style = viewer.style()
    used = set(re.findall(r"var\((--\w+)\)", style))
    assert used == {"--a", "--b", "--engine", "--truth", "--proof"}
    for scheme in style.split("prefers-color-scheme: dark")[:2]:
        assert used <= set(re.findall(r"(--\w+):", scheme))
    assert style.count("{") == style.count("}")
