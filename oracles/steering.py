"""What steers Hypothesis: how near an answer is to being wrong, for each sort of claim, on a scale that can be climbed.

An error counts relative to the engine's tolerance, on the scene's own shapes and on those that the engine effectively
uses, whichever is kinder: where a convention explains it, there is nothing to be found. What the engine does not
promise does not count.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
from hypothesis import target

from oracles import claims
from oracles.engine import Answers, Engine, Status
from oracles.impact_judge import after_of
from oracles.impact_laws import laws
from oracles.rules import Rules
from oracles.scene import Scene
from refimpl.linear import Array

VALUE, NORMAL, WITNESS, BOOLEAN = "value", "normal", "witness", "boolean"

LABELS = {
    claims.MISSED: BOOLEAN,
    claims.FALSE: BOOLEAN,
    claims.RAY_MISSED: BOOLEAN,
    claims.RAY_FALSE: BOOLEAN,
    claims.STUCK: NORMAL,
    claims.OVERSHOT: NORMAL,
    claims.TILTED: NORMAL,
    claims.BRIEF: NORMAL,
    claims.LENGTHY: NORMAL,
    claims.OFF_SHAPE: WITNESS,
    claims.OUTSIDE: WITNESS,
    claims.APART: WITNESS,
    claims.TOGETHER: WITNESS,
    claims.RAY_POINT: WITNESS,
    claims.SWEEP_MISSED: BOOLEAN,
    claims.SWEEP_FALSE: BOOLEAN,
    claims.SWEEP_POINT: WITNESS,
    claims.SWEEP_TILTED: NORMAL,
}
"""Sort of each symptom that is not about the value."""

FINEST = 1e-9
"""Errors below this part of the tolerance are all alike."""
HIGHEST = 300.0
TINY = np.finfo(float).tiny


CALM = 0.5
"""An answer whose claims are all held by so much, relative to the tolerance, needs no further look."""


@dataclass(frozen=True)
class Strain:
    """How near one answer is to being wrong.

    Attributes
    ----------
    pressures
        Symptom and error relative to the tolerance, of each side of each claim; negative where nothing is missing.
    whole
        Whether these are all claims, and on the scene's own shapes: there are no conventions beside them.
    """

    pressures: tuple[tuple[str, float], ...] = ()
    whole: bool = False

    @property
    def worst(self) -> float:
        """The largest, or 0."""
        return max((pressure for _, pressure in self.pressures), default=0.0)

    @property
    def calm(self) -> bool:
        """Whether the answer is right, beyond any need to judge it."""
        return self.whole and self.worst < CALM

    def steer(self, known: Collection[str]) -> None:
        """Tell Hypothesis; where an answer is wrong in a known way, there is nowhere to go."""
        best: dict[str, float] = {}
        for symptom, pressure in self.pressures:
            if math.isfinite(pressure) and not (pressure >= 1 and symptom in known):
                label = LABELS.get(symptom, VALUE)
                best[label] = max(best.get(label, -math.inf), height(pressure))
        for label, score in best.items():
            target(score, label=label)


def height(pressure: float) -> float:
    """A scale with a slope everywhere: decades of an error, and below none how far a claim is from being broken."""
    if pressure > FINEST:
        return min(math.log10(pressure), HIGHEST)
    return math.log10(FINEST) - math.log10(1.0 + max(0.0, -pressure))


def strain(engine: Engine, scene: Scene, answers: Answers) -> Strain:
    """Put every claim of one answer against the tolerance for it."""
    if answers.status[0] != Status.ANSWERED:
        return Strain()
    if scene.impact is not None:
        return Strain(tuple(_of_laws(engine, scene, answers)))
    rules, cell = Rules(engine), scene.cell
    ours = rules.of_scene(scene, answers)
    if ours.unusable[0]:
        return Strain()
    theirs = rules.effectively(cell, ours)
    as_given = theirs.a is ours.a and theirs.b is ours.b
    found = []
    for mine, other in zip(ours.claims(), theirs.claims(), strict=True):
        if mine.by_convention or not mine.made[0]:
            continue
        allowed = rules.allowed(cell, mine.kind, np.array([scene.size]))
        both = [_relative(claim.violations(), allowed) for claim in ((mine,) if as_given else (mine, other))]
        for side, symptom in enumerate((mine.below, mine.above)):
            found.append((symptom, min(relative[side] for relative in both)))
    return Strain(tuple(found), as_given and not rules.conventions(cell))


def _relative(violation: tuple[Array, Array, Array], allowed: Array) -> tuple[float, float]:
    below, above, error = violation
    unit = float(np.maximum(allowed, error + TINY)[0])
    return float(below[0]) / unit, float(above[0]) / unit


def _of_laws(engine: Engine, scene: Scene, answers: Answers) -> Iterator[tuple[str, float]]:
    cell, motion = scene.cell, scene.impact
    assert motion is not None
    motion, after = motion[None], after_of(answers)
    rows = scene.a[None].pack(), scene.b[None].pack()
    effective = engine.effective_motion(cell.type_a, cell.type_b, motion, rows)
    allowed = float(np.maximum(Rules(engine).allowed(cell, "value", motion.speed), TINY)[0])
    for mine, other in zip(laws(motion, after), laws(effective, after), strict=True):
        if mine.applies[0]:
            yield mine.symptom, min(float(mine.amount[0]), float(other.amount[0])) / allowed
