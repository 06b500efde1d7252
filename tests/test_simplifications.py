"""Hypothesis shrinks scenes of every kind: fewer parts, simpler numbers, simpler motions, several of them at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import find, settings

import oracles.shrink
from oracles.clumsiness import PLAIN, clumsiness, numbers_in, odd_numbers
from oracles.course import Course
from oracles.engine import Answers, Engine, Kind
from oracles.planted.mutants import MUTANTS
from oracles.scene import DISTANCE, IMPACT, SWEEP, Cell, Scene, cells
from oracles.shrink import shrink
from oracles.simplifications import simplifications
from refimpl import AABB, Box, Composite, ConvexPolyhedron, Point, Sphere
from tests.reference_engine import Reference
from tests.test_shrink import Bench, findings
from tests.wrong_engines import OffByAThousandth

BALL = Sphere([3.1, 4.2, 5.3], 0.7)
BALLS = Composite([Sphere([0.3 * k, 0.1, 0.7], 0.1 + 0.1 * k) for k in range(6)])
HULL = ConvexPolyhedron.from_vertices(np.random.default_rng(1).normal(size=(12, 3)), [0.1, 0.2, 0.3], [0, 0, 0, 1])
WAY = Course.translating((0.3, -0.7, 1.1), (0.2, 0.9, -0.4))


def simplest(scene: Scene, fault: Callable[[Scene], bool]) -> Scene:
    """What Hypothesis shrinks a scene to."""
    assert fault(scene)
    often = settings(max_examples=400, database=None, deadline=None)
    return find(simplifications(scene), fault, settings=often, random=Random(1))


def test_numbers_that_are_only_simpler_together_are_and_all_others_are_zero() -> None:
    scene = Scene(DISTANCE, BALL, Box([0.3, -0.9, 0.2], [1.2, 0.8, 0.3], [0, 0, 0, 1]), "generic")

    def fault(one: Scene) -> bool:
        x, y, _, radius = numbers_in(one)[:4]
        return radius > 0.6 and (x in PLAIN) == (y in PLAIN)

    found = simplest(scene, fault)
    assert numbers_in(found)[:4] == [0, 0, 0, 1]
    assert odd_numbers(found) == 0


def test_parts_and_corners_are_left_out() -> None:
    with_one = simplest(Scene(DISTANCE, Point([9.5, 0.3, 0.2]), BALLS, "generic"), lambda one: one.b.magnitude > 1.4)
    assert isinstance(with_one.b, Composite)
    assert len(with_one.b.parts) <= 3  # half of them
    assert odd_numbers(with_one) <= 1
    cut = simplest(Scene(DISTANCE, BALL, HULL, "generic"), lambda one: one.a.magnitude > 1)
    assert isinstance(cut.b, ConvexPolyhedron)
    assert len(cut.b.numbers) <= 8


def test_motions_become_simpler_and_the_bodies_of_an_impact_stay() -> None:
    scene = Scene(SWEEP, BALL, AABB([-1, -1, -1], [1, 1, 1]), "generic", motion=WAY)
    found = simplest(scene, lambda one: one.course is not None and one.course.a.linear[2] > 1)
    assert found.course is not None
    assert sum(x not in PLAIN for x in found.course.pack().tolist()) <= 3
    impact = findings(Bench(MUTANTS["always-elastic"].engine()), _cell("always-elastic"), each=1)[0].scene
    drawn = simplest(impact, lambda one: True)
    assert drawn.a is impact.a
    assert drawn.b is impact.b
    assert clumsiness(drawn) < clumsiness(impact)


class Farther(Reference):
    """Off by a thousandth of the ball's radius."""

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        found = super().answer(query, A, B, rows_a, rows_b)
        return replace(found, distance=found.distance + 1e-3 * np.asarray(rows_a)[:, 3])


def _cell(mutant: str) -> Cell:
    known = MUTANTS[mutant]
    return next(cell for cell in cells() if (cell.query, cell.pair) == (known.query, known.pair))


@pytest.mark.parametrize(
    ("engine", "cell"),
    [
        (OffByAThousandth, Cell(DISTANCE, Sphere, AABB)),
        (Farther, Cell(DISTANCE, Sphere, ConvexPolyhedron)),
        (MUTANTS["always-elastic"].engine, _cell("always-elastic")),
    ],
    ids=["numbers", "corners", IMPACT],
)
def test_findings_of_the_bulk_hunter_shrink_by_hypothesis_alone(
    engine: type[Engine], cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without any of the steps that are tried one by one, in batches."""
    for name in ("passes", "plain_scenes"):
        monkeypatch.setattr(oracles.shrink, name, lambda *_, **__: ())
    bench = Bench(engine())
    found = findings(bench, cell, each=1)[:2]
    small = [shrink(finding, bench) for finding in found]
    simpler = [clumsiness(one.scene) < clumsiness(old.scene) for one, old in zip(small, found, strict=True)]
    assert sum(simpler) >= len(found) / 2 > 0
    assert all(one.verdict.symptom == old.verdict.symptom for one, old in zip(small, found, strict=True))
