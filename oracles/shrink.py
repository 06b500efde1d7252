"""Shrinking: from the scene that a hunter found to one that a person takes in at a glance, with the same fault.

A candidate is taken only if the engine fails on it in the same way: same symptom, no special geometry that the scene
did not have (`oracles.degeneracy`), and an error that is like the one before, within two decades. So a slight error
does not end in the bucket of a gross one. Better is first what is less special, then nearer to size 1, then taken in at
a glance, then the larger error, so that all decades of one fault come together, and then fewer numbers to read.

Engines answer whole batches, so all candidates of a step are asked at once. Floats screen them; the last one is
convicted by its certificate like any other finding. Findings of one cell and symptom are shrunk together: where one of
them arrives, the next ones often may go at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from random import Random

import numpy as np
from hypothesis import HealthCheck, find, settings
from hypothesis.errors import Flaky, NoSuchExample

from oracles.clumsiness import AT_A_GLANCE, clumsiness, odd_numbers
from oracles.engine import Array
from oracles.home import at_home
from oracles.judges import finding_of
from oracles.likeness import Failing, failing, key_of
from oracles.motion import Motion
from oracles.outcome import Finding, Kind
from oracles.plain import plain_scenes
from oracles.plain_bodies import plain_pairs
from oracles.plain_impacts import restaged, simpler_motions
from oracles.reference import is_quick
from oracles.relations import Bench, question
from oracles.scene import IMPACT, Cell, Scene, packed_rows
from oracles.simpler import batch_of, by_form, kept_apart, moved, several_changed, simpler_proxies

TRIES = 1600
"""Scenes that are put before an engine for one finding; for each further one of the same symptom half as many."""
TRIES_SEARCHED = 300
"""Where the judge has to search for each answer."""
TRIES_FORMED = 180
"""Where making a proxy takes time as well: hulls, slabs, meshes, composites."""
TRIES_RELATED = 100
"""Where a relation between two scenes is broken: each try asks the engine twice, on its own."""
TRIES_LOST = 6
"""Where the engine was lost, or ran out of time, on the scene: each try may cost as much again."""
TRIES_LEAST = 200
MOST_STEPS = 40
CAREFULLY = settings(
    max_examples=60, database=None, deadline=None, suppress_health_check=list(HealthCheck), derandomize=False
)
NEAR = 12
"""Plain scenes of which the bodies are brought to each of the gaps."""
AT_ONCE = 150
"""Candidates that are asked before one looks whether one of them will do."""
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
    findings = [at_home(finding, bench) for finding in findings]
    groups: dict[tuple[Cell, Kind, str, str], list[int]] = {}
    for i, finding in enumerate(findings):
        relation = finding.related.relation if finding.related else ""
        groups.setdefault((finding.scene.cell, finding.verdict.kind, finding.verdict.symptom, relation), []).append(i)
    found = list(findings)
    for key, numbers in groups.items():
        search = _SearchOfRelated(bench, *key) if key[3] else _Search(bench, *key)
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
    relation: str = ""
    """Name of the relation between two scenes that is broken, where that is what is wrong."""
    known: dict[bytes, Failing] = field(default_factory=dict)
    """Scenes on which the engine fails in this way."""
    asked: set[bytes] = field(default_factory=set)
    exhausted: set[bytes] = field(default_factory=set)
    """Scenes around which nothing simpler is."""
    proven: dict[bytes, Finding | None] = field(default_factory=dict)
    tries: int = 0
    searched: int = 0
    """Findings for which the engine has been asked."""

    @property
    def lost(self) -> bool:
        """Whether it is no answer at all."""
        return self.kind in (Kind.CRASHED, Kind.TIMED_OUT)

    def shrink(self, findings: list[Finding], tries: int | None) -> list[Finding]:
        """Shrink findings one after the other; what the later ones learn may lead the earlier ones farther."""
        if self.kind is Kind.REFERENCE_WRONG:
            return findings
        ways = [[failing(finding)] for finding in findings]
        if self.lost:
            self.known = {way[0].key: way[0] for way in ways}
        else:
            self.tries = len(findings)
            self.ask(finding.scene for finding in findings)
        repeats = [way[0].key in self.known or self._convict(way[0].scene) is not None for way in ways]
        self.proven = {way[0].key: finding for way, finding in zip(ways, findings, strict=True)}
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
        self._go_on(way)
        if way[-1].key in self.exhausted:
            return
        allowance = self._allowance() if tries is None else tries
        self.tries = max(min(TRIES_LEAST, allowance // 3), allowance >> self.searched)
        self.searched += 1
        self.ask(plain_scenes(self.cell, regime))
        self._go_on(way)
        for _ in range(MOST_STEPS):
            if self.lost or way[-1].key in self.exhausted:
                break
            if not (self._improve(way) or self._improve_jointly(way)):
                break

    def _allowance(self) -> int:
        """How many scenes may be tried for one finding, by what each costs."""
        kinds = self.cell.type_a, self.cell.type_b
        if self.lost:
            return 0 if self.asked else TRIES_LOST
        if any(kind.header for kind in kinds):
            return TRIES_FORMED
        return TRIES if is_quick(*kinds) else TRIES_SEARCHED

    def _improve(self, way: list[Failing]) -> bool:
        """Try everything around the last scene, until something is better."""
        best = way[-1]
        candidates = chain.from_iterable(_passes(best))
        while self.tries > 0 and (some := list(islice(candidates, AT_ONCE))):
            self.ask(some)
            if self._go_on(way):
                return True
        if self.tries > 0:
            self.exhausted.add(best.key)
        return False

    def _improve_jointly(self, way: list[Failing]) -> bool:
        """Have Hypothesis look for several numbers that can be made simpler together, where many are odd."""
        best, formed = way[-1], any(kind.header for kind in (self.cell.type_a, self.cell.type_b))
        if odd_numbers(best.scene) <= AT_A_GLANCE or best.scene.motion is not None or formed:
            return False

        def is_better(scene: Scene) -> bool:
            if clumsiness(scene) >= clumsiness(best.scene) or not self.tries > 0:
                return False
            self.ask([scene])
            found = self.known.get(key_of(scene))
            return found is not None and best.best_of([found]) is found

        try:
            find(several_changed(best.scene), is_better, settings=CAREFULLY, random=Random(0))
        except NoSuchExample:
            return False
        except Flaky:
            pass  # an engine that answers otherwise when asked again; what was found is known
        return self._go_on(way)

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
                self.proven[step.key] = self._convict(step.scene)
            found = self.proven[step.key]
            if found is not None:
                origin, regime = finding.scene.source, finding.scene.regime
                source = origin if origin.endswith(", shrunk") else f"{origin}, shrunk"
                return replace(found, scene=replace(found.scene, regime=regime, source=source))
        return finding

    def _convict(self, scene: Scene) -> Finding | None:
        """A finding on this scene, proven; none where the engine does not fail there in the same way."""
        first, second = scene.rows
        answers = self.bench.answer(self.cell, (first[None], second[None]))
        verdict = self.bench.judges.convict(scene, answers)
        if verdict.kind is not self.kind or verdict.symptom != self.symptom:
            return None
        return finding_of(self.bench.engine.name, scene, answers, verdict)


class _SearchOfRelated(_Search):
    """The same for an engine that contradicts itself about two scenes, of which one is made from the other."""

    def _allowance(self) -> int:
        return TRIES_RELATED

    def _ask(self, group: list[Scene]) -> None:
        for scene in group:
            found = question(self.bench, self.relation, scene)
            if found is not None and found.verdict.symptom == self.symptom:
                new = Failing(scene, found.verdict.amount)
                self.known[new.key] = new

    def _convict(self, scene: Scene) -> Finding | None:
        found = question(self.bench, self.relation, scene)
        return found if found is not None and found.verdict.symptom == self.symptom else None


def _rows_of_motion(group: list[Scene]) -> Array:
    return np.stack([scene.motion.pack() for scene in group if scene.motion is not None])


def _passes(best: Failing) -> Iterator[Iterable[Scene]]:
    """Candidates around a scene, the boldest first."""
    scene = best.scene
    if not best.strain and odd_numbers(scene) == 0:
        if best.slightness and scene.motion is None:
            yield kept_apart([scene], GAPS)
        return
    if scene.motion is not None:
        yield restaged(scene)
        yield (replace(scene, motion=motion) for motion in simpler_motions(scene.motion))
        return
    yield moved(scene)
    yield kept_apart([scene], GAPS)
    if best.slightness or "nearly touching" in best.special:
        yield kept_apart(list(islice(plain_pairs(scene.cell), NEAR)), GAPS)
    yield _changed(scene)
    yield from (kept_apart(some, [0.0]) for some in _in_parts(_changed(scene)))


def _changed(scene: Scene) -> Iterator[Scene]:
    """One of both proxies simpler."""
    yield from (replace(scene, a=a) for a in simpler_proxies(scene.a))
    yield from (replace(scene, b=b) for b in simpler_proxies(scene.b))


def _in_parts(scenes: Iterator[Scene]) -> Iterator[list[Scene]]:
    while some := list(islice(scenes, AT_ONCE)):
        yield some
