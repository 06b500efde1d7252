"""The judges of one engine: for shapes at rest and on their way, and for impacts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from oracles.answers import reference_for, said
from oracles.audit import audit_of
from oracles.course import Course
from oracles.engine import Answers, Engine
from oracles.impact_judge import ImpactJudge, audit_impact
from oracles.judge import Judge
from oracles.motion import Motion
from oracles.outcome import Finding, Kind, Verdict
from oracles.scene import Cell, Scene
from oracles.screening import Screening
from refimpl import Proxy


@dataclass(frozen=True)
class Judges:
    """Gives each answer to the judge of its query."""

    engine: Engine

    @cached_property
    def _in_space(self) -> Judge:
        return Judge(self.engine)

    @cached_property
    def _of_impacts(self) -> ImpactJudge:
        return ImpactJudge(self.engine)

    def screen(self, cell: Cell, a: Proxy, b: Proxy, motion: Motion | Course | None, answers: Answers) -> Screening:
        """Give every row of a batch its verdict by floats."""
        if isinstance(motion, Motion):
            return self._of_impacts.screen(cell, a, b, motion, answers)
        return self._in_space.screen(cell, a, b, answers, motion)

    def convict(self, scene: Scene, answers: Answers) -> Verdict:
        """Verdict on the one answer in `answers`, with its proof."""
        judge = self._in_space if scene.impact is None else self._of_impacts
        return judge.convict(scene, answers)

    def proven_error(self, scene: Scene, answers: Answers) -> Verdict:
        """How far off the one value in `answers` is proven to be at least; no verdict on whether that is allowed."""
        judge = self._in_space if scene.impact is None else self._of_impacts
        return judge.proven_error(scene, answers)


def audited(scene: Scene) -> Verdict:
    """Try the reference itself on one scene."""
    return audit_of(scene) if scene.impact is None else audit_impact(scene)


def finding_of(engine: str, scene: Scene, answers: Answers, verdict: Verdict) -> Finding:
    """Record a proven finding with both answers; what speaks against the reference is its own."""
    engine = "refimpl" if verdict.kind is Kind.REFERENCE_WRONG else engine
    reference = said(reference_for(scene), 0)
    return Finding(engine, scene, said(answers, 0), reference, verdict, answers.errors.get(0, ""))
