"""Findings brought home: the same scene at the origin and at size 1, where an error near the tolerance is plain.

Far away, an engine may keep one promise by a hair and break the next, so that the symptom is a matter of chance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from oracles.degeneracy import length_of
from oracles.engine import Bound
from oracles.judges import finding_of
from oracles.outcome import Finding, Kind
from oracles.relations import Bench
from oracles.scene import Scene
from refimpl import ShapeError

BY_CHANCE = 30.0
"""Errors of up to so many tolerances are near enough to it."""


def at_home(finding: Finding, bench: Bench) -> Finding:
    """The finding at the origin and at size 1, where it is near the tolerance and the engine fails there as well."""
    if finding.verdict.kind is not Kind.WRONG or finding.related or not _is_near_tolerance(finding, bench):
        return finding
    for scene in _closer(finding.scene):
        first, second = scene.rows
        answers = bench.answer(scene.cell, (first[None], second[None]))
        verdict = bench.judges.convict(scene, answers)
        if verdict.kind is Kind.WRONG:
            return finding_of(finding.engine, scene, answers, verdict)
    return finding


def _is_near_tolerance(finding: Finding, bench: Bench) -> bool:
    scene, cell = finding.scene, finding.scene.cell
    tolerance = bench.engine.tolerance(cell.query, cell.type_a, cell.type_b)
    bounds: tuple[Bound, ...] = (tolerance.value, tolerance.witness, tolerance.boolean)
    return 0 < finding.verdict.amount <= BY_CHANCE * max(float(bound.at(scene.size)) for bound in bounds)


def _closer(scene: Scene) -> Iterator[Scene]:
    """Moved to the origin; then scaled by a power of ten, too."""
    if scene.motion is not None:
        return
    try:
        with np.errstate(all="ignore"):
            offset = -scene.b.reference_point
            a, b = scene.a.translated(offset), scene.b.translated(offset)
            factor = 10.0 ** -np.round(np.log10(length_of(scene)))
            if np.any(offset != 0):
                yield replace(scene, a=a, b=b)
            if 0 < factor < np.inf and factor != 1:
                yield replace(scene, a=a.scaled(factor), b=b.scaled(factor))
    except ShapeError:
        return
