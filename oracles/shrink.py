"""Shrinking: from the scene that a hunter found to one that a person takes in at a glance, with the same fault.

A candidate is taken only if the engine fails on it in the same way: same symptom, no special geometry that the scene
did not have (`oracles.degeneracy`), and an error that is like the one before, within two decades. So a slight error
does not end in the bucket of a gross one. Better is first what is less special, then nearer to size 1, then the larger
error, so that all decades of one fault come together, and then fewer numbers to read.

Engines answer whole batches, so all candidates of a step are asked at once. Floats screen them; the last one is
convicted by its certificate like any other finding. Findings of one cell and symptom are shrunk together: where one of
them arrives, the next ones often may go at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from oracles.answers import reference_for, said
from oracles.clumsiness import odd_numbers
from oracles.engine import Array
from oracles.likeness import Failing, failing, key_of
from oracles.motion import Motion
from oracles.outcome import Finding, Kind
from oracles.plain import plain_scenes
from oracles.plain_impacts import restaged, simpler_motions
from oracles.reference import is_quick
from oracles.relations import Bench, contradictions, question
from oracles.scene import IMPACT, Cell, Scene, packed_rows
from oracles.simpler import batch_of, by_form, kept_apart, moved, simpler_proxies

TRIES = 3000
"""Scenes that are put before an engine for one finding."""
TRIES_SEARCHED = 600
"""Where the judge has to search for each answer."""
TRIES_LOST = 6
"""Where the engine was lost, or ran out of time, on the scene: each try may cost as much again."""
MOST_STEPS = 40
GIVE_UP_AFTER = 1
"""Candidates of a batch that may run out of time before the rest of it is left."""
GAPS = [sign * 10.0**-k for k in range(16) for sign in (1.0, -1.0)]
"""Steps on which errors that grow with a gap or an overlap grow."""


def shrink(finding: Finding, bench: Bench, *, tries: int | None = None) -> Finding:
    """Find the simplest scene with the same fault; see `shrink_all`."""
    return shrink_all([finding], bench, tries=tries)[0]


def shrink_all(findings: Sequence[Finding], bench: Bench, *, tries: int | None = None) -> list[Finding]:
    """Find for each finding the simplest scene with the same fault; the finding itself where there is none simpler.

    Parameters
    ----------
    findings
        In the order in which they are to be shrunk, of one engine.
    bench
        The engine that failed, and its judges.
    tries
        Scenes to put before the engine for a finding; by default as many as its judge can take in about a second.

    Returns
    -------
    list of Finding
        Each with a verdict of its own; one that does not come again is marked as such.
    """
    groups: dict[tuple[Cell, Kind, str, str], list[int]] = {}
    for i, finding in enumerate(findings):
        relation = finding.related.relation if finding.related else ""
        groups.setdefault((finding.scene.cell, finding.verdict.kind, finding.verdict.symptom, relation), []).append(i)
    found = list(findings)
    for (cell, kind, symptom, relation), numbers in groups.items():
        key = bench, cell, kind, symptom
        search = _OfRelation(*key, relation=relation) if relation else _Search(*key)
        for i, result in zip(numbers, search.shrink([findings[i] for i in numbers], tries), strict=True):
            found[i] = result
    return found


@dataclass
class _Search:
    """All that has been learned of one symptom of an engine in one cell."""

    bench: Bench
    cell: Cell
    kind: Kind
    symptom: str
    known: dict[bytes, Failing] = field(default_factory=dict)
    """Scenes on which the engine fails in this way."""
    asked: set[bytes] = field(default_factory=set)
    exhausted: set[bytes] = field(default_factory=set)
    """Scenes around which nothing simpler is."""
    proven: dict[bytes, Finding | None] = field(default_factory=dict)
    tries: int = 0

    @property
    def lost(self) -> bool:
        """Whether it is no answer at all."""
        return self.kind in (Kind.CRASHED, Kind.TIMED_OUT)

    def shrink(self, findings: list[Finding], tries: int | None) -> list[Finding]:
        """Shrink findings one after the other; what the later ones learn may lead the earlier ones farther."""
        if self.kind is Kind.REFERENCE_WRONG:
            return findings
        if not self.lost:
            self.tries = len(findings)
            self.ask(finding.scene for finding in findings)
        repeats = [self.lost or key_of(finding.scene) in self.known for finding in findings]
        ways = [[failing(finding)] for finding in findings]
        for way, again, finding in zip(ways, repeats, findings, strict=True):
            if again:
                self._go(way, finding.scene.regime, tries)
        found = []
        for way, again, finding in zip(ways, repeats, findings, strict=True):
            if again:
                self._go_on(way)
            found.append(self._prove(finding, way) if again else replace(finding, repeats=False))
        return found

    def _go(self, way: list[Failing], regime: str, tries: int | None) -> None:
        """Find better and better scenes."""
        quick = is_quick(self.cell.type_a, self.cell.type_b)
        self.tries = tries or (TRIES_LOST if self.lost else TRIES if quick else TRIES_SEARCHED)
        self._go_on(way)
        self.ask(plain_scenes(self.cell, regime))
        self._go_on(way)
        for _ in range(MOST_STEPS):
            if self.lost or way[-1].key in self.exhausted or not self._improve(way):
                break

    def _improve(self, way: list[Failing]) -> bool:
        """Try everything around the last scene, until something is better."""
        best = way[-1]
        for candidates in _passes(best):
            self.ask(candidates)
            if self._go_on(way):
                return True
        if self.tries > 0:
            self.exhausted.add(best.key)
        return False

    def _go_on(self, way: list[Failing]) -> bool:
        """Go to the best of what is known and may be gone to, and on from there."""
        start = len(way)
        while True:
            better = way[-1].best_of(self.known.values())
            if better is None:
                return len(way) > start
            way.append(better)

    def ask(self, scenes: Iterable[Scene]) -> None:
        """Put candidates before the engine, as many as are allowed, and keep those on which it fails alike."""
        new: dict[bytes, Scene] = {}
        for scene in scenes:
            if len(new) >= self.tries:
                break
            key = key_of(scene)
            if key not in self.asked:
                new[key] = scene
        self.tries -= len(new)
        self.asked |= new.keys()
        for group in by_form(list(new.values())):
            self._ask(group)

    def _ask(self, group: list[Scene]) -> None:
        a, b = batch_of([scene.a for scene in group]), batch_of([scene.b for scene in group])
        motion = Motion.unpack(_rows_of_motion(group)) if self.cell.query == IMPACT else None
        answers = self.bench.answer(self.cell, packed_rows(a, b, motion), give_up_after=GIVE_UP_AFTER)
        found = self.bench.judges.screen(self.cell, a, b, motion, answers)
        for i, scene in enumerate(group):
            if found.kind[i] is self.kind and found.symptom[i] == self.symptom and found.certain[i]:
                new = Failing(scene, float(found.amount[i]))
                self.known[new.key] = new

    def _prove(self, finding: Finding, way: list[Failing]) -> Finding:
        """Convict the engine on the last scene on the way on which that succeeds."""
        for step in reversed(way[1:]):
            if step.key not in self.proven:
                self.proven[step.key] = self._convict(finding, step.scene)
            found = self.proven[step.key]
            if found is not None:
                origin, regime = finding.scene.source, finding.scene.regime
                source = origin if origin.endswith(", shrunk") else f"{origin}, shrunk"
                return replace(found, scene=replace(found.scene, regime=regime, source=source))
        return finding

    def _convict(self, finding: Finding, scene: Scene) -> Finding | None:
        """The finding on another scene, proven; none where the engine does not fail there in the same way."""
        first, second = scene.rows
        answers = self.bench.answer(self.cell, (first[None], second[None]))
        verdict = self.bench.judges.convict(scene, answers)
        if verdict.kind is not self.kind or verdict.symptom != self.symptom:
            return None
        text = answers.errors.get(0, "")
        return Finding(finding.engine, scene, said(answers, 0), said(reference_for(scene), 0), verdict, text)


@dataclass
class _OfRelation(_Search):
    """The same of answers that contradict each other: each candidate is asked with the scene that is made from it."""

    relation: str = ""

    @property
    def lost(self) -> bool:
        """Whether no answer is what is found."""
        return False

    def _ask(self, group: list[Scene]) -> None:
        for scene, found in zip(group, contradictions(self.bench, self.relation, group), strict=True):
            if found is not None and found[0] == self.symptom:
                new = Failing(scene, found[1])
                self.known[new.key] = new

    def _convict(self, finding: Finding, scene: Scene) -> Finding | None:
        del finding  # which has nothing that another scene's answers do not tell
        found = question(self.bench, self.relation, scene)
        same = found is not None and (found.verdict.kind, found.verdict.symptom) == (self.kind, self.symptom)
        return found if same else None


def _rows_of_motion(group: list[Scene]) -> Array:
    return np.stack([scene.motion.pack() for scene in group if scene.motion is not None])


def _passes(best: Failing) -> Iterator[Iterable[Scene]]:
    """Candidates around a scene, the boldest first."""
    scene = best.scene
    if not best.strain and best.is_gross and odd_numbers(scene) == 0:
        return
    if scene.motion is not None:
        yield [replace(scene, motion=motion) for motion in simpler_motions(scene.motion)]
        yield restaged(scene)
        return
    yield moved(scene)
    yield kept_apart([scene], GAPS)
    changed = [replace(scene, a=x) for x in simpler_proxies(scene.a)]
    changed += [replace(scene, b=y) for y in simpler_proxies(scene.b)]
    yield changed
    yield kept_apart(changed, [0.0])
