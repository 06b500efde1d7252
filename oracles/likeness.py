"""Scenes on which an engine fails: which of them is the better witness, and which may show the same fault."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from oracles.clumsiness import AT_A_GLANCE, Clumsiness, clumsiness, numbers_in
from oracles.degeneracy import FREE, features, length_of
from oracles.outcome import Finding
from oracles.scene import Scene
from oracles.words import decade_of
from refimpl import Ray
from refimpl.linear import norm

GROSS = -2
"""Decade from which on it does not matter how large an error is, relative to the scene."""
UP, DOWN = 2.01, 1.01
"""By how many decades the error may grow and fall in a step."""


def key_of(scene: Scene) -> bytes:
    """Every bit of a scene's numbers; types and query are those of the cell."""
    return b"|".join(row.tobytes() for row in scene.rows)


@dataclass(frozen=True, eq=False)
class Failing:
    """A scene on which an engine fails, and by how much; and its `gaps_of`, where they are known."""

    scene: Scene
    amount: float
    gaps: tuple[float, ...] = ()

    @cached_property
    def key(self) -> bytes:
        """The scene's numbers."""
        return key_of(self.scene)

    @cached_property
    def size(self) -> float:
        """The scene's size."""
        return self.scene.size

    @cached_property
    def special(self) -> frozenset[str]:
        """What is special about the scene."""
        return features(self.scene, self.gaps)

    @property
    def strain(self) -> int:
        """In how many ways it is special that simple scenes are not."""
        return len(self.special - FREE)

    @cached_property
    def slightness(self) -> int:
        """How many decades the error is below those that are gross; 0 also where it has no size."""
        decade = decade_of(self.amount, self.size)
        return 0 if decade is None else max(0, GROSS - decade)

    @cached_property
    def plainness(self) -> tuple[int, int, int, Clumsiness, float, list[float]]:
        """What is better comes first, among scenes that are as special as each other."""
        simple = clumsiness(self.scene)
        beyond = max(0, simple[0] - AT_A_GLANCE)
        return _decades_from_one(self.scene), beyond, self.slightness, simple, -self.amount, numbers_in(self.scene)

    @property
    def _has_amount(self) -> bool:
        return 0 < self.amount < math.inf and 0 < self.size < math.inf

    def is_like(self, other: Failing) -> bool:
        """Whether the error grows and falls by no more than it may in a step, as a length or relative to the scene.

        Of gross errors it does not matter.
        """
        if not (self._has_amount and other._has_amount):
            return self._has_amount == other._has_amount
        if not (self.slightness or other.slightness):
            return True
        absolute = math.log10(other.amount) - math.log10(self.amount)
        relative = absolute - math.log10(other.size) + math.log10(self.size)
        return any(-DOWN <= jump <= UP for jump in (absolute, relative))

    def best_of(self, others: Iterable[Failing]) -> Failing | None:
        """The best scene that is better than this one, and may show the same fault; none if there is none."""
        found: Failing | None = None
        for other in self.better_of(filter(self.is_like, others)):
            if found is None or other.strain < found.strain:
                found = other
            if not found.strain:
                break  # whatever follows is less plain
        return found

    def better_of(self, others: Iterable[Failing]) -> Iterator[Failing]:
        """Scenes that are better than this one, and special in no way in which it is not; the plainest first."""
        for other in sorted(others, key=lambda one: one.plainness):
            if not self.strain and other.plainness >= self.plainness:
                return
            if self._is_worse_than(other):
                yield other

    def may_go_to(self, other: Failing) -> bool:
        """Whether the other is better, and may show the same fault."""
        return self._is_worse_than(other) and self.is_like(other)

    def _is_worse_than(self, other: Failing) -> bool:
        better = (other.strain, other.plainness) < (self.strain, self.plainness)
        return better and other.special <= self.special | FREE


def failing(finding: Finding) -> Failing:
    """The finding's own scene."""
    return Failing(finding.scene, finding.verdict.amount)


def come_together(findings: Sequence[Finding]) -> list[Finding]:
    """For each of some findings with one symptom in one cell the best of them that may show the same fault."""
    own = [failing(finding) for finding in findings]
    ends = []
    for start in own:
        end, better = start, start.best_of(own)
        while better is not None:
            end, better = better, better.best_of(own)
        ends.append(findings[own.index(end)])
    return ends


def _decades_from_one(scene: Scene) -> int:
    """How many decades beyond 0.1 and 10 the larger body and a ray's direction are, of impacts the speed."""
    sizes = [scene.size if scene.impact is not None else length_of(scene)]
    if isinstance(scene.a, Ray):
        sizes.append(float(norm(scene.a.direction)))
    return max(int(abs(math.log10(size))) if 0 < size < math.inf else 0 for size in sizes)
