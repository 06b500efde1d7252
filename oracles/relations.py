"""Questions an engine with itself: asks it related scenes, and files the answers that contradict each other.

Bounds that two answers put on one number are compared with what the engine promises for both, and with what the map
between the scenes is inexact by. Where they exclude each other, one of the two is wrong, whatever is right. Answers
that merely differ, near touching for instance, may both be right within their tolerance.

What the reference can prove is filed as what it is: where it convicts the first answer, the relation tells nothing new,
and is only counted; where the second, that scene is the finding, unless it is no cell of the table, as with swapped
sides. What it cannot prove is an inconsistency, and the two answers are the proof.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from oracles import relations_of_form, relations_of_motion, relations_of_queries, relations_of_space
from oracles.answers import said, take
from oracles.batch import Batch
from oracles.claims import (
    EARLY,
    LATE,
    RAY_LATE,
    RAY_OFF,
    RAY_POINT,
    UNTOUCHED,
    WRONG_BOOLEANS,
)
from oracles.course import Course
from oracles.engine import Answers, Engine, Status, SupportKind
from oracles.judges import Judges, finding_of
from oracles.motion import Motion
from oracles.outcome import FINDINGS, Finding, Kind, Related, RelationKey, Verdict
from oracles.related import Asked, Difference, Image, difference
from oracles.relation import RELATIONS, Relation
from oracles.scene import CONTACTS, DISTANCE, IMPACT, RAYCAST, SWEEP, Cell, Scene, packed_rows
from oracles.words import said_of, severity_of
from oracles.world import world_of
from refimpl.linear import Array, Bools
from refimpl.shapes import Proxy

__all__ = ["RELATIONS", "Relation", "Relations", "question", "relate"]

FAMILIES = (relations_of_space, relations_of_form, relations_of_queries, relations_of_motion)
"""Where the relations stand that are registered."""
LOST = (Status.ERROR, Status.CRASHED, Status.TIMED_OUT)
ABOUT_HITS = set(WRONG_BOOLEANS)
ABOUT_TIMES = {RAY_OFF, RAY_LATE, RAY_POINT, EARLY, LATE, UNTOUCHED}
"""Symptoms that explain why two hits, or times of hits, differ."""
ASPECTS = {
    DISTANCE: "distance",
    CONTACTS: "depth",
    RAYCAST: "time of the hit",
    SWEEP: "time of contact",
    IMPACT: "velocities",
}
HITS = {RAYCAST: "hit", SWEEP: "hit"}
MOST_PROOFS = 3
"""Contradictions of one symptom in a batch that are proven one by one; the others are counted."""


class Bench(Protocol):
    """One engine, ready to answer and to be judged."""

    @property
    def engine(self) -> Engine:
        """What it says of itself."""

    @property
    def judges(self) -> Judges:
        """Who judges it."""

    def answer(
        self,
        cell: Cell,
        rows: tuple[ArrayLike, ArrayLike],
        groups: ArrayLike | None = None,
        give_up_after: int | None = None,
    ) -> Answers:
        """Have a batch answered."""

    def renew(self) -> None:
        """Have the engine forget what it was asked before."""


@dataclass
class Relations:
    """What relations found in a batch: findings, and for each relation how its pairs of answers fared."""

    findings: list[Finding] = field(default_factory=list)
    counts: Counter[RelationKey] = field(default_factory=Counter)


@dataclass(frozen=True)
class _Pair:
    """One relation on one batch: the first scenes and answers, the second ones, and how they differ."""

    relation: Relation
    asked: Asked
    image: Image
    answers: Answers
    found: Difference
    scenes: Sequence[Scene]

    def second(self, i: int) -> Scene:
        """The related scene of a row."""
        image, first = self.image, self.scenes[i]
        motion = None if image.motion is None else image.motion[i]
        about = f"{first.source} ({self.relation.name})"
        return Scene(image.cell.query, image.a[i], image.b[i], first.regime, about, motion)


def relate(
    bench: Bench,
    cell: Cell,
    batch: Batch,
    *,
    answers: Answers | None = None,
    names: Sequence[str] | None = None,
) -> Relations:
    """Ask an engine the scenes of a batch and those related to them, and compare its answers.

    Parameters
    ----------
    answers
        Of the batch itself, where they are known; else it is asked first.
    names
        Of relations, keys of `RELATIONS`; all by default.
    """
    scenes = [batch.scene(cell.query, i) for i in range(len(batch))]
    if answers is None:
        answers = _ask(bench, cell, batch.a, batch.b, batch.motion, batch.groups)
    asked = Asked(bench.engine, cell, batch.a, batch.b, batch.motion, answers)
    found = Relations()
    for name in names or RELATIONS:
        _relate(bench, RELATIONS[name], asked, scenes, found)
    return found


def question(bench: Bench, name: str, scene: Scene) -> Finding | None:
    """Put one relation to one scene; answers its finding, if there is one."""
    motion = None if scene.motion is None else scene.motion[None]
    a, b = scene.a[None], scene.b[None]
    answers = _ask(bench, scene.cell, a, b, motion, None)
    found = Relations()
    _relate(bench, RELATIONS[name], Asked(bench.engine, scene.cell, a, b, motion, answers), [scene], found)
    return found.findings[0] if found.findings else None


def _ask(
    bench: Bench, cell: Cell, a: Proxy, b: Proxy, motion: Motion | Course | None, groups: NDArray[np.int_] | None
) -> Answers:
    return bench.answer(cell, packed_rows(a, b, motion), groups, give_up_after=1)


def _relate(bench: Bench, relation: Relation, asked: Asked, scenes: Sequence[Scene], found: Relations) -> None:
    name, query = asked.engine.name, asked.cell.query
    for image in relation.images(asked):
        support = asked.engine.support(image.cell.query, image.cell.type_a, image.cell.type_b)
        if support.kind is SupportKind.UNSUPPORTED:
            found.counts[name, relation.name, query, Kind.UNSUPPORTED] += len(asked)
            continue
        exists = np.isfinite(image.errors[0] + image.errors[1]) & (asked.answers.status == Status.ANSWERED)
        loose = image.looseness(asked) if exists.any() else np.zeros(len(asked))
        rows = np.flatnonzero(exists & np.isfinite(loose))
        found.counts[name, relation.name, query, Kind.SKIPPED] += int(np.count_nonzero(~exists))
        found.counts[name, relation.name, query, Kind.CONVENTION] += int(np.count_nonzero(exists)) - len(rows)
        if rows.size:
            _file(bench, _compare(bench, relation, asked, image, rows, loose[rows], scenes), found)


def _compare(
    bench: Bench,
    relation: Relation,
    asked: Asked,
    image: Image,
    rows: NDArray[np.int_],
    loose: Array,
    scenes: Sequence[Scene],
) -> _Pair:
    """Ask the engine for the rows that have an image."""
    part, first = image.take(rows), asked.take(rows, take(asked.answers, rows))
    answers = _ask(bench, part.cell, part.a, part.b, part.motion, None)
    part_scenes = [scenes[i] for i in rows]
    return _Pair(relation, first, part, answers, difference(first, part, answers, loose), part_scenes)


def _file(bench: Bench, pair: _Pair, found: Relations) -> None:
    """Give every row its verdict, and prove some of those that are wrong."""
    proofs: Counter[str] = Counter()
    first, second = _suspects(bench, pair)
    for i in range(len(pair.scenes)):
        kind = _at_first_sight(pair, i, first, second)
        if kind is Kind.INCONSISTENT:
            symptom = _symptom(pair, i)
            proofs[symptom] += 1
            if proofs[symptom] <= MOST_PROOFS:
                finding = _finding(bench, pair, i, symptom)
                kind = finding.verdict.kind
                if kind in FINDINGS:
                    found.findings.append(finding)
        found.counts[pair.asked.engine.name, pair.relation.name, pair.asked.cell.query, kind] += 1


def _suspects(bench: Bench, pair: _Pair) -> tuple[Bools, Bools]:
    """Rows whose answers contradict each other or merely differ: which of the two the reference in floats suspects."""
    n, asked, image = len(pair.scenes), pair.asked, pair.image
    rows = np.flatnonzero(pair.found.differs | (pair.found.excess > 0))
    suspects = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    for suspect, cell, a, b, motion, answers in (
        (suspects[0], asked.cell, asked.a, asked.b, asked.motion, asked.answers),
        (suspects[1], image.cell, image.a, image.b, image.motion, pair.answers),
    ):
        if rows.size:
            part = None if motion is None else motion[rows]
            screening = bench.judges.screen(cell, a[rows], b[rows], part, take(answers, rows))
            for k, i in enumerate(rows):
                suspect[i] = screening.kind[k] is Kind.WRONG and _explains(pair, int(i), screening.symptom[k])
    return suspects


def _explains(pair: _Pair, i: int, symptom: str) -> bool:
    """Whether a wrong answer of this symptom is a reason for two answers to differ."""
    if isinstance(pair.asked.motion, Motion) or pair.found.excess[i] > 0:
        return True
    if isinstance(pair.asked.motion, Course):
        return symptom in ABOUT_HITS | ABOUT_TIMES
    hits = pair.asked.answers.hit[i] != pair.answers.hit[i]
    return symptom in (ABOUT_HITS if hits else ABOUT_TIMES)


def _at_first_sight(pair: _Pair, i: int, first: Bools, second: Bools) -> Kind:
    """INCONSISTENT is what is yet to be proven, WRONG what the first answer is, whatever the relation."""
    status = Status(int(pair.answers.status[i]))
    if first[i]:
        return Kind.WRONG
    if status in LOST or pair.found.excess[i] > 0 or second[i]:
        return Kind.INCONSISTENT
    if status is not Status.ANSWERED:
        return Kind.UNSUPPORTED if status is Status.UNSUPPORTED else Kind.SKIPPED
    return Kind.AGREES if pair.found.comparable[i] else Kind.SKIPPED


def _symptom(pair: _Pair, i: int) -> str:
    if pair.answers.status[i] in LOST:
        return pair.relation.lost
    one, two = pair.asked.answers.hit[i], pair.answers.hit[i]
    query = pair.asked.cell.query
    if one in (0, 1) and two in (0, 1) and one != two:
        return pair.relation.symptom(HITS.get(query, "overlap"))
    return pair.relation.symptom(ASPECTS.get(query, "overlap"))


def _finding(bench: Bench, pair: _Pair, i: int, symptom: str) -> Finding:
    """What the reference can prove, as what it is; else the contradiction, where nothing excuses it."""
    scenes = pair.scenes[i], pair.second(i)
    answers = take(pair.asked.answers, [i]), take(pair.answers, [i])
    name = pair.asked.engine.name
    verdicts = [bench.judges.convict(scene, of) for scene, of in zip(scenes, answers, strict=True)]
    for scene, of, verdict in zip(scenes, answers, verdicts, strict=True):
        guilty = verdict.kind in FINDINGS and (verdict.kind is not Kind.WRONG or _explains(pair, i, verdict.symptom))
        if guilty and (type(scene.a), type(scene.b)) in world_of(scene.b).table:
            return finding_of(name, scene, of, verdict)
    told = said_by(scenes[0], answers[0]), said_by(scenes[1], answers[1])
    verdict = _verdict(pair, i, symptom, verdicts, told)
    related = Related(pair.relation.name, scenes[1], said(answers[1], 0))
    text = answers[1].errors.get(0, "")
    return replace(finding_of(name, scenes[0], answers[0], verdict), related=related, text=text)


def said_by(scene: Scene, answers: Answers) -> str:
    """What an engine said, or that it did not."""
    if answers.status[0] != Status.ANSWERED:
        return f"nothing ({answers.errors.get(0, 'no more is known')})"
    if scene.impact is None:
        return said_of(scene.query, answers)
    return ", ".join(f"{name} {value}" for name, value in said(answers, 0).items())


def _verdict(pair: _Pair, i: int, symptom: str, verdicts: list[Verdict], told: tuple[str, str]) -> Verdict:
    """Verdict on the contradiction; with a certificate where the second answer, of no cell of its own, is refuted."""
    excess, scene = float(pair.found.excess[i]), pair.scenes[i]
    name, second = pair.asked.engine.name, verdicts[1]
    claim = f"{name} answers {told[0]}; and after {pair.relation.changing}, {told[1]}: {symptom}."
    if second.kind in FINDINGS and (second.kind is not Kind.WRONG or _explains(pair, i, second.symptom)):
        amount, proof = second.amount or max(excess, 0.0), second.proof_scene or pair.second(i)
        text = f"{claim} The second of the two is proven wrong: {second.claim}"
        bounds = second.lower, second.upper
        certificate = second.certificate
        return Verdict(Kind.INCONSISTENT, symptom, second.severity, amount, *bounds, text, certificate, proof)
    if excess > 0 and pair.image.self_evident(pair.asked):
        text = f"{claim} By what it promises for both, at least one of the two is wrong, by {excess / 2:.3g}."
        return Verdict(Kind.INCONSISTENT, symptom, severity_of(symptom, excess, scene.size), excess, claim=text)
    undecided = any(verdict.kind is Kind.UNDECIDED for verdict in verdicts)
    return Verdict(Kind.UNDECIDED if undecided else Kind.CONVENTION if excess > 0 else Kind.AGREES)
