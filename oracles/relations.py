"""Questions an engine with itself: asks it related scenes, and files the answers that contradict each other.

Bounds that two answers put on one number are compared with what the engine promises for both, and with what the map
between the scenes is inexact by. Where they exclude each other, one of the two is wrong, whatever is right. The
reference then proves which one, where it can. Answers that merely differ, near touching for instance, may both be
right within their tolerance: they count only when the reference proves one of them wrong.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from oracles import relations_of_form, relations_of_queries, relations_of_space
from oracles.answers import reference_for, said, take
from oracles.batch import Batch
from oracles.claims import RAY_LATE, RAY_OFF, RAY_POINT, WRONG_BOOLEANS
from oracles.engine import Answers, Engine, Status, SupportKind
from oracles.judges import Judges
from oracles.motion import Motion
from oracles.outcome import Finding, Kind, Related, RelationKey, Severity, Verdict
from oracles.related import Asked, Difference, Image, difference
from oracles.relation import RELATIONS, Relation
from oracles.scene import CONTACTS, DISTANCE, IMPACT, RAYCAST, Cell, Scene, packed_rows
from oracles.words import said_of, severity_of
from refimpl.linear import Array
from refimpl.shapes import Proxy

__all__ = ["RELATIONS", "Relation", "Relations", "question", "relate"]

FAMILIES = (relations_of_space, relations_of_form, relations_of_queries)
"""Where the relations stand that are registered."""
LOST = (Status.ERROR, Status.CRASHED, Status.TIMED_OUT)
ABOUT_HITS = set(WRONG_BOOLEANS)
ABOUT_TIMES = {RAY_OFF, RAY_LATE, RAY_POINT}
"""Symptoms that explain why two hits, or times of hits, differ."""
ASPECTS = {DISTANCE: "distance", CONTACTS: "depth", RAYCAST: "time of the hit", IMPACT: "velocities"}
HITS = {RAYCAST: "hit"}
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
    bench: Bench, cell: Cell, a: Proxy, b: Proxy, motion: Motion | None, groups: NDArray[np.int_] | None
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
            pair = _compare(bench, relation, asked, image, rows, loose[rows], scenes)
            _file(bench, pair, found)


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
    screened = _screened(bench, pair)
    for i in range(len(pair.scenes)):
        kind = _at_first_sight(pair, i, screened)
        if kind is Kind.INCONSISTENT:
            symptom = _symptom(pair, i)
            proofs[symptom] += 1
            if proofs[symptom] <= MOST_PROOFS:
                finding = _finding(bench, pair, i, symptom)
                kind = finding.verdict.kind
                if kind in (Kind.INCONSISTENT, Kind.REFERENCE_WRONG):
                    found.findings.append(finding)
        found.counts[pair.asked.engine.name, pair.relation.name, pair.asked.cell.query, kind] += 1


def _screened(bench: Bench, pair: _Pair) -> dict[int, bool]:
    """Rows whose answers merely differ: whether the reference in floats suspects one of the two."""
    rows = np.flatnonzero(pair.found.differs & ~(pair.found.excess > 0))
    if not rows.size:
        return {}
    asked, image = pair.asked, pair.image
    suspect = np.zeros(len(rows), dtype=bool)
    for cell, a, b, motion, answers in (
        (asked.cell, asked.a, asked.b, asked.motion, asked.answers),
        (image.cell, image.a, image.b, image.motion, pair.answers),
    ):
        part = None if motion is None else motion[rows]
        screening = bench.judges.screen(cell, a[rows], b[rows], part, take(answers, rows))
        for k, i in enumerate(rows):
            suspect[k] |= screening.kind[k] is Kind.WRONG and _explains(pair, int(i), screening.symptom[k])
    return dict(zip(rows.tolist(), suspect.tolist(), strict=True))


def _explains(pair: _Pair, i: int, symptom: str) -> bool:
    """Whether a wrong answer of this symptom is a reason for two answers to differ."""
    if pair.asked.motion is not None:
        return True
    hits = pair.asked.answers.hit[i] != pair.answers.hit[i]
    return symptom in (ABOUT_HITS if hits else ABOUT_TIMES)


def _at_first_sight(pair: _Pair, i: int, screened: dict[int, bool]) -> Kind:
    """INCONSISTENT is what is yet to be proven."""
    status = Status(int(pair.answers.status[i]))
    if status in LOST or pair.found.excess[i] > 0 or screened.get(i, False):
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
    """Prove, with the reference, which of two answers is wrong; else by the contradiction, where nothing excuses it."""
    first, second = pair.scenes[i], pair.second(i)
    answers = take(pair.asked.answers, [i]), take(pair.answers, [i])
    verdicts = [bench.judges.convict(scene, of) for scene, of in zip((first, second), answers, strict=True)]
    verdict = _verdict(pair, i, symptom, verdicts, (said_by(first, answers[0]), said_by(second, answers[1])))
    related = Related(pair.relation.name, second, said(answers[1], 0))
    reference = said(reference_for(first), 0)
    text = answers[1].errors.get(0, "")
    return Finding(pair.asked.engine.name, first, said(answers[0], 0), reference, verdict, text, related=related)


def said_by(scene: Scene, answers: Answers) -> str:
    """What an engine said, or that it did not."""
    if answers.status[0] != Status.ANSWERED:
        return f"nothing ({answers.errors.get(0, 'no more is known')})"
    if scene.motion is None:
        return said_of(scene.query, answers)
    return ", ".join(f"{name} {value}" for name, value in said(answers, 0).items())


def _verdict(pair: _Pair, i: int, symptom: str, verdicts: list[Verdict], told: tuple[str, str]) -> Verdict:
    for verdict in verdicts:
        if verdict.kind is Kind.REFERENCE_WRONG:
            return verdict
    excess, scene = float(pair.found.excess[i]), pair.scenes[i]
    lost = pair.answers.status[i] in LOST
    name = pair.asked.engine.name
    claim = f"{name} answers {told[0]}; and after {pair.relation.changing}, {told[1]}: {symptom}."
    for verdict, which, about in zip(verdicts, ("first", "second"), (scene, pair.second(i)), strict=True):
        if verdict.kind in (Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT) and (
            excess > 0 or lost or _explains(pair, i, verdict.symptom)
        ):
            proof = verdict.proof_scene or about
            amount = verdict.amount or max(excess, 0.0)
            text = f"{claim} The {which} of the two is proven wrong: {verdict.claim}"
            bounds = verdict.lower, verdict.upper
            severity = verdict.severity
            return Verdict(Kind.INCONSISTENT, symptom, severity, amount, *bounds, text, verdict.certificate, proof)
    if excess > 0 and pair.image.self_evident(pair.asked):
        text = f"{claim} By what it promises for both, at least one of the two is wrong, by {excess / 2:.3g}."
        severity = severity_of(symptom, excess, scene.size)
        return Verdict(Kind.INCONSISTENT, symptom, severity or Severity.SMALL, excess, claim=text)
    undecided = any(verdict.kind is Kind.UNDECIDED for verdict in verdicts)
    return Verdict(Kind.UNDECIDED if undecided else Kind.CONVENTION if excess > 0 else Kind.AGREES)
