"""Shrinking: from the scene that a hunter found to one that a person takes in at a glance, with the same fault.

A candidate is taken only if the engine fails on it in the same way: same symptom, no special geometry that the scene
did not have (`oracles.degeneracy`), and an error that is like the one before, within two decades, or grows to it along
a path (`oracles.paths`). So a slight error does not end in the bucket of a gross one. Better is first what is less
special, then nearer to size 1, then taken in at a glance, then the larger error, so that all decades of one fault come
together, and then fewer numbers to read.

Engines answer whole batches, so all candidates of a step are asked at once. Where no single step leads farther,
Hypothesis shrinks: it draws several at once from a strategy of simplifications (`oracles.simplifications`), and the
steps go on from what it comes to. Floats screen the scenes; the last one is convicted by its certificate like any other
finding, by a fresh engine that was asked nothing before. Findings of one cell and symptom are shrunk together: where
one of them arrives, the next ones often may go at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from random import Random

from hypothesis import HealthCheck, find, settings
from hypothesis.errors import Flaky, NoSuchExample

from oracles.allowance import MOST_LOST, MOST_LOST_AGAIN, is_formed, tries_for, tries_of_next
from oracles.around import AT_ONCE, LOST_AT_ONCE, passes
from oracles.clumsiness import clumsiness, odd_numbers
from oracles.home import at_home
from oracles.inquiry import Inquiry, InquiryOfRelated
from oracles.likeness import Failing, failing, key_of
from oracles.outcome import Finding, Kind
from oracles.paths import SHARES, leads, path
from oracles.plain import plain_scenes
from oracles.relations import Bench
from oracles.rows import in_a_row
from oracles.scene import Cell, Scene
from oracles.search import Enough
from oracles.simplifications import simplifications
from oracles.together import merged

MOST_STEPS = 40
KEPT = 3
"""One try in so many is kept for paths."""
MOST_PATHS = 8
"""Paths that are tried from one scene to better ones."""
DRAWN, MOST_DRAWN = 10, 60
"""One try in so many is kept for Hypothesis, and no more than so many for a finding, for it asks one scene at a time;
`LOST_AT_ONCE` where that may cost the engine."""


def _drawing(tries: int) -> settings:
    """So many examples, which are the same every time."""
    return settings(
        max_examples=tries,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        derandomize=False,
    )


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
        about = InquiryOfRelated(bench, *key[:3], relation=key[3]) if key[3] else Inquiry(bench, *key[:3])
        search = _Search(about)
        for i, result in zip(numbers, search.shrink([findings[i] for i in numbers], tries), strict=True):
            found[i] = result
    return found


@dataclass
class _Search:
    """Findings of one symptom on their way to simpler scenes."""

    about: Inquiry
    exhausted: set[bytes] = field(default_factory=set)
    """Scenes around which nothing simpler is."""
    tried: set[bytes] = field(default_factory=set)
    """Starts and ends between which a path was looked for."""
    proven: dict[bytes, Finding | None] = field(default_factory=dict)
    kept: int = 0
    """Tries that are kept for paths."""
    drawn: int = 0
    """Tries that are kept for Hypothesis."""
    searched: int = 0
    """Findings for which the engine has been asked."""
    passing: list[Finding | None] | None = None
    """What came in a row of plain scenes, once that was tried."""
    growing: bool = False
    """Whether slight errors are to become larger before they become simpler."""

    def shrink(self, findings: list[Finding], tries: int | None) -> list[Finding]:
        """Shrink findings one after the other; what the later ones learn may lead the earlier ones farther."""
        if self.about.kind is Kind.REFERENCE_WRONG:
            return findings
        ways = [[failing(finding)] for finding in findings]
        if self.about.lost:
            self.about.known = {way[0].key: way[0] for way in ways}
        else:
            self.about.tries = len(findings)
            self.about.ask(finding.scene for finding in findings)
        repeats = [way[0].key in self.about.known or self.about.convict(way[0].scene) is not None for way in ways]
        if self.about.lost:  # and would be again
            self.proven = {way[0].key: finding for way, finding in zip(ways, findings, strict=True)}
        for way, again, finding in zip(ways, repeats, findings, strict=True):
            if again:
                self._go(way, finding.scene.regime, tries)
        self.searched, self.growing = 1, True
        for way, again, finding in zip(ways, repeats, findings, strict=True):
            if again and tries is None and way[-1].slightness:
                self._go(way, finding.scene.regime, tries)  # few are left, and the others have shown the way
        found = []
        for way, again, finding in zip(ways, repeats, findings, strict=True):
            if again:
                self._go_on(way)
            found.append(self._prove(finding, way) if again else self._in_passing(finding))
        return found

    def _in_passing(self, finding: Finding) -> Finding:
        """What does not come again, as it comes in a row of plain scenes, where it does."""
        if self.passing is None:
            allowed = self._allowed()
            self.passing = [] if self.about.lost or finding.related else [in_a_row(finding, self.about.bench, allowed)]
        better = next((one for one in self.passing if one is not None), finding)
        simpler = better if clumsiness(better.scene) < clumsiness(finding.scene) else finding
        return replace(simpler, scene=replace(simpler.scene, regime=finding.scene.regime), repeats=False)

    def _allowed(self) -> int:
        """How many scenes may be tried for a finding."""
        return tries_for(self.about.cell, lost=self.about.lost, related=isinstance(self.about, InquiryOfRelated))

    def _go(self, way: list[Failing], regime: str, tries: int | None) -> None:
        """Find better and better scenes."""
        self._go_on(way)
        if way[-1].key in self.exhausted:
            return
        allowed = tries_of_next(self._allowed() if tries is None else tries, self.searched)
        self.kept = allowed // KEPT
        self.drawn = min(allowed // DRAWN, LOST_AT_ONCE if self.about.lost else MOST_DRAWN)
        self.about.tries = allowed - self.kept - self.drawn
        self.about.losses = MOST_LOST - MOST_LOST_AGAIN if self.searched else 0
        self.searched += 1
        while self._try_some(way, self._plain(regime)) and self.about.lost:
            pass
        self._take_path(way)
        for _ in range(MOST_STEPS):
            if way[-1].key in self.exhausted:
                break
            if not (self._improve(way) or self._improve_by_drawing(way) or self._take_path(way)):
                break

    def _plain(self, regime: str) -> Sequence[Scene]:
        """Plain scenes, of all sorts, for which no more than half of the tries are spent."""
        plain = plain_scenes(self.about.cell, regime)
        return plain[:: 1 + 2 * len(plain) // max(1, self.about.tries)] if is_formed(self.about.cell) else plain

    def _take_path(self, way: list[Failing]) -> bool:
        """Go where a path leads: from a slight error to a better scene where it is not like this one."""
        last = way[-1]
        if not last.slightness:
            return False
        unlike = (
            one for one in self.about.known.values() if not last.is_like(one) and last.key + one.key not in self.tried
        )
        ends = list(islice(last.better_of(unlike), min(MOST_PATHS, self.kept // len(SHARES))))
        self.tried |= {last.key + end.key for end in ends}
        paths = [(end, path(last.scene, end.scene)) for end in ends]
        left, self.about.tries = self.about.tries, self.kept
        self.about.ask(scene for _, scenes in paths for scene in scenes)
        self.kept, self.about.tries = self.about.tries, left
        for end, scenes in paths:
            steps = [self.about.known[key] for key in map(key_of, scenes) if key in self.about.known]
            if scenes and len(steps) == len(scenes) and leads([last, *steps, end]):
                way.append(end)
                self._go_on(way)
                return True
        return False

    def _improve(self, way: list[Failing]) -> bool:
        """Try everything around the last scene, until something is better."""
        best = way[-1]
        candidates = chain.from_iterable(passes(best, growing=self.growing))
        while self.about.tries > 0 and (some := list(islice(candidates, LOST_AT_ONCE if self.about.lost else AT_ONCE))):
            if self._try_some(way, some):
                return True
        if self.about.tries > 0:
            self.exhausted.add(best.key)
        return False

    def _try_some(self, way: list[Failing], scenes: Sequence[Scene]) -> bool:
        """Go on to one of these; where the engine is lost on some of them, the rest may be asked after that."""
        best = way[-1]
        while self.about.ask(scenes):
            if not self.about.lost and best.scene.motion is None:
                found = [self.about.known[key] for key in map(key_of, scenes) if key in self.about.known]
                steps = sorted((one for one in found if best.may_go_to(one)), key=lambda one: one.plainness)
                self.about.ask(merged(best.scene, (one.scene for one in steps)))
            if self._go_on(way):
                return True
        return False

    def _improve_by_drawing(self, way: list[Failing]) -> bool:
        """Have Hypothesis look for simplifications that only together leave the fault, and shrink what it finds."""
        best = way[-1]
        if not (best.strain or odd_numbers(best.scene)) or self.about.is_spent or not self.drawn > 0:
            return False

        def is_better(scene: Scene) -> bool:
            if not self.about.tries > 0:
                raise Enough
            if clumsiness(scene) >= clumsiness(best.scene):
                return False
            self.about.ask([scene])
            found = self.about.known.get(key_of(scene))
            return found is not None and best.best_of([found]) is found

        left, self.about.tries = self.about.tries, self.drawn
        # flaky: an engine may answer otherwise when asked again; what was found is known
        with suppress(NoSuchExample, Enough, Flaky):
            find(simplifications(best.scene), is_better, settings=_drawing(self.drawn), random=Random(0))
        self.drawn, self.about.tries = self.about.tries, left
        return self._go_on(way)

    def _go_on(self, way: list[Failing]) -> bool:
        """Go to the best of what is known and may be gone to, and on from there."""
        start = len(way)
        while True:
            better = way[-1].best_of(self.about.known.values())
            if better is None:
                return len(way) > start
            way.append(better)

    def _prove(self, finding: Finding, way: list[Failing]) -> Finding:
        """Convict the engine on the last scene on the way on which that succeeds; else it does not come again."""
        for step in reversed(way[1:]):
            if step.key not in self.proven:
                self.proven[step.key] = self.about.convict(step.scene)
            found = self.proven[step.key]
            if found is not None:
                origin, regime = finding.scene.source, finding.scene.regime
                source = origin if origin.endswith(", shrunk") else f"{origin}, shrunk"
                return replace(found, scene=replace(found.scene, regime=regime, source=source))
        comes_again = self.about.lost or self.about.convict(finding.scene) is not None
        return finding if comes_again else self._in_passing(finding)
