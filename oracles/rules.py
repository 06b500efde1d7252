"""What the answers of one engine are held to: its tolerances, its conventions, the shapes that it effectively uses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from oracles.adapters import effective_of
from oracles.claims import LENGTH, UNIT_ERROR, Questioned
from oracles.course import Course
from oracles.engine import Answers, Bound, Convention, Effective, Engine, Status
from oracles.keeping import rows_of
from oracles.reference import error_of, kept_shape
from oracles.scene import Cell, Scene
from oracles.sweep_claims import SweptRows
from oracles.world import world_of
from refimpl import Proxy, distance
from refimpl.linear import Array, Bools

INSIDE_CONVENTIONS = {Convention.NO_HIT_FROM_INSIDE, Convention.TWO_SIDED_PLANE}


@dataclass(frozen=True)
class Rules:
    """The rules for one engine, as its adapter declares them."""

    engine: Engine

    def conventions(self, cell: Cell) -> Mapping[Convention, str]:
        """Departures from the contract by design."""
        return self.engine.conventions(cell.query, cell.type_a, cell.type_b)

    def allowed(self, cell: Cell, kind: str, size: Array) -> Array:
        """Error that is allowed for claims of a kind, in scenes of some size."""
        if kind == LENGTH:
            return np.full(np.shape(size), UNIT_ERROR)
        tolerance = self.engine.tolerance(cell.query, cell.type_a, cell.type_b)
        bound: Bound = getattr(tolerance, kind)
        return bound.at(size)

    def questioned(self, cell: Cell, a: Proxy, b: Proxy, answers: Answers, course: Course | None = None) -> Questioned:
        """Rows of a cell on the scene's own shapes; of sweeps also on what course."""
        margins, answered = (np.zeros(len(a)), np.zeros(len(a))), answers.status == Status.ANSWERED
        answers = world_of(b).cut(answers)
        waived = frozenset(self.conventions(cell))
        if course is not None:
            return SweptRows(cell.query, a, b, *margins, answers, answered, waived, course=course)
        rows = Questioned(cell.query, a, b, *margins, answers, answered, waived)
        return replace(rows, allowed=self.allowed(cell, "value", rows.size))

    def of_scene(self, scene: Scene, answers: Answers) -> Questioned:
        """The one row of a scene."""
        course = None if scene.course is None else scene.course[None]
        return self.questioned(scene.cell, scene.a[None], scene.b[None], answers, course)

    def effectively(self, cell: Cell, rows: Questioned) -> Questioned:
        """The same on the shapes that the engine effectively uses: the very ones given, where these are the same."""
        given, numbers = (rows.a, rows.b), (rows_of(rows.a), rows_of(rows.b))
        used = effective_of(self.engine, cell, *numbers)
        a, b = (_shape(one, shape, row) for one, shape, row in zip(used, given, numbers, strict=True))
        return replace(rows, a=a, b=b, margin_a=used[0].margin, margin_b=used[1].margin)

    def excused_inside(self, cell: Cell, rows: Questioned) -> Bools:
        """Rays that start inside, where the engine's convention differs: a miss, or a hit on the way out."""
        if not INSIDE_CONVENTIONS & set(self.conventions(cell)):
            return np.zeros(len(rows.a), dtype=bool)
        allowed = self.allowed(cell, "value", rows.size)
        point, world = rows.hit_point(), rows.world
        start = world.point(rows_of(rows.a)[:, : world.axes])
        inside = distance(start, rows.b).distance <= allowed
        surface = np.abs(distance(point, rows.b).distance) <= allowed + error_of(point, rows.b) * rows.size
        return np.asarray(inside & ((rows.answers.hit == 0) | surface))


def _shape(used: Effective, given: Proxy, rows: Array) -> Proxy:
    if used.made is not None:
        return used.made
    same = used.kind is type(given) and used.rows is rows and not used.margin.any()
    return given if same else kept_shape(used.rows, used.kind)
