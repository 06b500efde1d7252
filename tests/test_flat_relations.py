"""Relations in the plane: engines that break one are caught by it, and by nothing that they keep."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from itertools import product
from typing import Any, ClassVar

import numpy as np
import pytest

from oracles.engine import Kind
from oracles.growth import grown, growth
from oracles.images import MIRRORED, QUARTER, TURNED, moved, rewritten
from oracles.outcome import Kind as Verdicts
from oracles.relations import RELATIONS, Relations, question
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, SWEEP, Cell
from refimpl import Proxy
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.linear import norm
from refimpl.proof import check
from tests import test_sweep_relations as sweeping
from tests.flat_scenes import some, whole
from tests.reference_engine import Desk, FlatReference
from tests.test_relations import Spoil, Spoiled, _apart, _off, _widest, broken, compared, related, told

DISCS, DISC_SEGMENT = Cell(DISTANCE, Disc, Disc), Cell(DISTANCE, Disc, Segment)


class FlatSpoiled(Spoiled):
    """The reference of the plane, spoiled in one cell."""

    flat: ClassVar[bool] = True


class FlatMoving(sweeping.Moving):
    """The same for sweeps."""

    flat: ClassVar[bool] = True


# -- right engines -------------------------------------------------------------------------------------------


def asked(found: Relations) -> set[str]:
    return {key[1] for key, n in found.counts.items() if n and key[3] is Verdicts.AGREES}


def test_the_reference_breaks_none_and_all_that_are_of_the_plane_are_asked() -> None:
    names = set[str]()
    for pair in ((FlatPoint, Segment), (Disc, Rectangle), (Segment, ConvexPolygon)):
        found = related(FlatReference(), Cell(DISTANCE, *pair), 2)
        assert told(found) == []
        assert compared(found) > 450
        names |= asked(found)
    found = related(FlatReference(), Cell(RAYCAST, FlatRay, Segment), 2)
    assert told(found) == []
    names |= asked(found)
    found = sweeping.related(FlatMoving(), Cell(SWEEP, FlatPoint, Rectangle), 1)
    assert told(found) == []
    names |= asked(found)
    found = related(FlatReference(), Cell(IMPACT, Disc, Rectangle), 1)
    assert told(found) == []
    of_space = {"turned", "finer_mesh", "as_ellipsoid", "as_composite"}
    assert names | asked(found) == set(RELATIONS) - of_space


# -- engines that break one ------------------------------------------------------------------------------------


def _handed(a: Any, b: Any) -> Any:
    """On which side of a segment a disc is, as seen from its first end: what turning and moving keep."""
    along, away = b.q - b.p, a.center - b.p
    return along[:, 0] * away[:, 1] < along[:, 1] * away[:, 0]


BOTH = ["swapped", "mirrored", "quarter_turned", "translated", "scaled_up", "scaled_down", "same_sets"]
FAULTS: list[tuple[Cell, Callable[[Any, Any], Any], set[str]]] = [
    (DISCS, lambda a, b: a.radius > b.radius, {"swapped"}),
    (DISCS, lambda a, b: _widest(a, b) == 1, {"quarter_turned"}),
    (DISCS, lambda a, b: norm(a.center + b.center) > 8 * norm(_apart(a, b)), {"translated"}),
    (DISCS, lambda a, b: np.minimum(a.radius, b.radius) > 100, {"scaled_up", "scaled_down"}),
    (DISC_SEGMENT, lambda a, b: norm(a.center - b.p) < 0.9 * norm(a.center - b.q), {"same_sets"}),
    (DISC_SEGMENT, _handed, {"mirrored", "same_sets"}),
]


@pytest.mark.parametrize(("cell", "where", "expected"), FAULTS)
def test_a_broken_relation_is_found_and_no_other(cell: Cell, where: Any, expected: set[str]) -> None:
    found = related(FlatSpoiled(cell, _off(where)), cell, 4, BOTH)
    assert broken(found) == expected


ELSEWHERE: list[tuple[str, Cell, Cell]] = [
    ("as_capsule", Cell(DISTANCE, Disc, Rectangle), Cell(DISTANCE, Segment, Rectangle)),
    ("as_capsule", Cell(DISTANCE, FlatPoint, Rectangle), Cell(DISTANCE, Segment, Rectangle)),
    ("as_box", Cell(DISTANCE, FlatPoint, Disc), Cell(DISTANCE, Disc, Rectangle)),
    ("as_kdop", Cell(DISTANCE, Disc, Rectangle), Cell(DISTANCE, Disc, ConvexPolygon)),
    ("as_hull", Cell(DISTANCE, Disc, Rectangle), Cell(DISTANCE, Disc, ConvexPolygon)),
    ("as_hull", Cell(DISTANCE, Disc, Segment), Cell(DISTANCE, Disc, ConvexPolygon)),
    ("queries", Cell(DISTANCE, Disc, Rectangle), Cell(CONTACTS, Disc, Rectangle)),
    ("segment", Cell(RAYCAST, FlatRay, Rectangle), Cell(DISTANCE, Segment, Rectangle)),
    ("arrival", Cell(RAYCAST, FlatRay, Rectangle), Cell(DISTANCE, FlatPoint, Rectangle)),
    ("witnesses", Cell(DISTANCE, Segment, Rectangle), Cell(DISTANCE, FlatPoint, Rectangle)),
]


@pytest.mark.parametrize(("name", "cell", "other"), ELSEWHERE)
def test_an_error_in_one_cell_shows_against_another(name: str, cell: Cell, other: Cell) -> None:
    found = related(FlatSpoiled(other, _off(lambda a, b: a.magnitude >= 0)), cell, 1, [name])
    assert broken(found) == {name}
    assert {f.verdict.kind for f in found.findings} == {Verdicts.WRONG}
    assert all(f.scene.cell == other for f in found.findings)


def _flipped(query: str, a: Any, b: Any, columns: dict[str, Any]) -> None:
    columns["normal"] *= -1


def _forgets_large(query: str, a: Any, b: Any, columns: dict[str, Any]) -> None:
    columns["hit"] = np.where(b.radius > a.radius, 0, columns["hit"])


@pytest.mark.parametrize(
    ("name", "cell", "spoil"), [("normals", DISCS, _flipped), ("larger", Cell(BOOLEAN, Disc, Disc), _forgets_large)]
)
def test_an_engine_that_contradicts_itself_is_found(name: str, cell: Cell, spoil: Spoil) -> None:
    assert broken(related(FlatSpoiled(cell, spoil), cell, 3, [name])) == {name}


@pytest.mark.parametrize(
    ("name", "cell", "other"),
    [
        ("flight", Cell(SWEEP, FlatPoint, Disc), Cell(RAYCAST, FlatRay, Disc)),
        ("as_capsule", Cell(SWEEP, Disc, Rectangle), Cell(SWEEP, Segment, Rectangle)),
    ],
)
def test_sweeps_are_held_against_rays_and_other_types(name: str, cell: Cell, other: Cell) -> None:
    late = sweeping._late(lambda a, b, c: a.magnitude >= 0)
    found = sweeping.related(FlatMoving(other, late), cell, 1, [name])
    assert {(f.scene.cell, f.verdict.kind) for f in found.findings} == {(other, Verdicts.WRONG)}


def test_a_late_contact_is_far_from_the_other_by_the_engines_own_distance() -> None:
    cell = Cell(SWEEP, Disc, Rectangle)
    late = sweeping._late(lambda a, b, c: norm(c.a.linear - c.b.linear) > 0)
    found = sweeping.related(FlatMoving(cell, late), cell, 1, ["contact", "backwards"])
    assert broken(found) >= {"contact"}


def test_a_wrong_order_carries_the_proof_of_the_second() -> None:
    engine = FlatSpoiled(Cell(DISTANCE, Rectangle, Disc), _off(lambda a, b: a.magnitude > 0), one_way=True)
    finding = related(engine, Cell(DISTANCE, Disc, Rectangle), 1, ["swapped"]).findings[0]
    verdict, other = finding.verdict, finding.related
    assert verdict.kind is Verdicts.INCONSISTENT
    assert other is not None
    assert (type(other.scene.a), type(other.scene.b)) == (Rectangle, Disc)
    assert verdict.proof_scene is not None
    lower, upper = check(verdict.certificate, verdict.proof_scene.a, verdict.proof_scene.b)
    assert verdict.lower <= lower <= upper <= verdict.upper
    assert question(Desk(FlatReference()), "swapped", finding.scene) is None


# -- the maps themselves, in fractions ------------------------------------------------------------------------------

TYPES = (FlatPoint, Disc, Segment, Rectangle, ConvexPolygon)
DIRECTIONS = [(1, 0), (0, 1), (-1, 0), (0, -1), (3, 4), (-4, 3), (-3, -4), (4, -3)]
"""Of whole length, 1 or 5."""


def support(shape: Any, x: int, y: int) -> Fraction:
    """Greatest n·x over a proxy, exactly; of lines over all corners that they have in common."""
    length = 5 if x * y else 1
    radius = Fraction(float(getattr(shape, "radius", 0.0)))
    if isinstance(shape, Rectangle):
        points = list(product(*zip(shape.lower.tolist(), shape.upper.tolist(), strict=True)))
    elif isinstance(shape, ConvexPolygon):
        points = corners_of(shape)
    else:
        ends = (shape.p, shape.q) if isinstance(shape, Segment) else (shape.reference_point,)
        points = [tuple(end.tolist()) for end in ends]
    return max(x * Fraction(u) + y * Fraction(v) for u, v in points) + length * radius


def corners_of(shape: ConvexPolygon) -> list[Any]:
    """Vertices, or all meets of two lines that no other cuts off."""
    if shape.given == "vertices":
        return [tuple(v) for v in shape.numbers.tolist()]
    lines = [[Fraction(n) for n in line] for line in shape.numbers.tolist()]
    found = []
    for (a, b, k), (c, d, m) in product(lines, lines):
        if det := a * d - b * c:
            u, v = (b * m - d * k) / det, (c * k - a * m) / det
            if all(n * u + o * v + p <= 0 for n, o, p in lines):
                found.append((u, v))
    return found


def shapes(kind: Any, count: int) -> list[Any]:
    rng = np.random.default_rng(TYPES.index(kind))
    return [make(kind, rng) for make in (some, whole) for _ in range(count)]


@pytest.mark.parametrize("kind", TYPES)
def test_images_are_what_they_say(kind: Kind) -> None:
    offset, kept = np.array([0.3, -1e3]), Counter[str]()
    for shape in shapes(kind, 6):
        batch = shape[None]
        away, along = moved(batch, offset[None]), moved(batch, np.array([[0.0, 8.0]]))
        turned = {name: axes(batch)[0] for name, axes in (("quarter", QUARTER), ("mirror", MIRRORED))}
        same = rewritten(batch)
        for x, y in DIRECTIONS:
            here = support(shape, x, y)
            length = 5 if x * y else 1
            for name, image, way in (("away", away, offset), ("along", along, (0.0, 8.0))):
                if np.isfinite(image.error[0]):
                    there = here + x * Fraction(float(way[0])) + y * Fraction(float(way[1]))
                    assert abs(support(image.shape[0], x, y) - there) <= length * Fraction(float(image.error[0]))
                    kept[name] += 1
            assert support(turned["quarter"], -y, x) == here
            assert support(turned["mirror"], -x, y) == here
            assert same is None or support(same[0], x, y) == here
    assert QUARTER.keeps_the_plane
    assert not TURNED.keeps_the_plane
    assert kept["along"] > 0
    assert kept["away"] > 0
    assert (rewritten(shapes(kind, 1)[0][None]) is None) == (kind in (FlatPoint, Disc, Rectangle))


@pytest.mark.parametrize("kind", TYPES[1:])
def test_grown_proxies_contain_the_given_ones(kind: Kind) -> None:
    by, reaching = np.array([0.125]), 0
    for shape in shapes(kind, 6):
        batch: Proxy = shape[None]
        larger = grown(batch, by)
        least, most = growth(batch, larger, by)
        for x, y in DIRECTIONS:
            length = 5 if x * y else 1
            more = support(larger[0], x, y) - support(shape, x, y)
            assert length * Fraction(float(least[0])) <= more
            assert most[0] == np.inf or more <= length * Fraction(float(most[0]))
        reaching += any(support(larger[0], x, y) > support(shape, x, y) for x, y in DIRECTIONS)
    assert reaching > 8
