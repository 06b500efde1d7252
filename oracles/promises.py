"""What an engine's answer says of the signed distance, within what the engine promises.

Whatever the query, an answer bounds the signed distance of the shapes that the engine effectively uses: a distance
from both sides, a hit from above, a miss from below. Two answers contradict each other where the bounds that they put
on the same number exclude each other, and no reference is needed to see it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from oracles.adapters import effective_of
from oracles.claims import OTHER_DEPTHS
from oracles.engine import Answers, Convention, Effective, Engine, Status
from oracles.reference import UNIONS
from oracles.rules import INSIDE_CONVENTIONS, Rules
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST, Cell
from refimpl.linear import Array
from refimpl.shapes import Proxy


@dataclass(frozen=True)
class Bounds:
    """Bounds on a number for every row, −∞ and ∞ where nothing is said."""

    low: Array
    high: Array

    @classmethod
    def none(cls, n: int) -> Bounds:
        """Say nothing."""
        return cls(np.full(n, -np.inf), np.full(n, np.inf))

    def take(self, rows: NDArray[np.int_]) -> Bounds:
        """Pick rows."""
        return Bounds(self.low[rows], self.high[rows])

    def times(self, factor: float) -> Bounds:
        """Bounds on a multiple."""
        return Bounds(factor * self.low, factor * self.high)

    def excess(self, other: Bounds) -> Array:
        """By how much the two exclude each other; −∞ where they could not, whatever the numbers."""
        with np.errstate(invalid="ignore"):
            apart = np.fmax(self.low - other.high, other.low - self.high)
        return np.where(np.isnan(apart), -np.inf, apart)


@dataclass(frozen=True)
class Used:
    """The shapes that an engine effectively uses for one side: those of `effective`.

    Attributes
    ----------
    own
        The scene's own proxies.
    """

    effective: Effective
    own: Proxy
    rows: Array

    @property
    def margin(self) -> Array:
        """By how much the shapes are grown, (n,)."""
        return self.effective.margin

    @cached_property
    def same(self) -> bool:
        """Whether they are the scene's own, but for the margin."""
        rows = self.effective.rows
        return self.effective.kind is type(self.own) and (rows is self.rows or np.array_equal(rows, self.rows))

    @cached_property
    def given(self) -> bool:
        """Whether they are the scene's own."""
        return self.same and not self.margin.any()

    @cached_property
    def shape(self) -> Proxy:
        """The shapes themselves, without the margin."""
        return self.own if self.same else self.effective.kind.unpack(self.effective.rows)

    def agrees_with(self, other: Used) -> bool:
        """Whether both are made of one proxy in one way."""
        ours, theirs = self.effective, other.effective
        alike = self.own is other.own and ours.kind is theirs.kind and np.array_equal(ours.margin, theirs.margin)
        return alike and ((self.given and other.given) or np.array_equal(ours.rows, theirs.rows))


def used(engine: Engine, cell: Cell, a: Proxy, b: Proxy) -> tuple[Used, Used]:
    """Both sides of a batch as the engine effectively uses them."""
    rows = a.pack(), b.pack()
    found = effective_of(engine, cell, *rows)
    return Used(found[0], a, rows[0]), Used(found[1], b, rows[1])


def bounds_of(engine: Engine, cell: Cell, a: Proxy, b: Proxy, answers: Answers) -> Bounds:
    """What the answers say of σ of the effective shapes; of a ray, as of the segment that reaches past the other.

    Nothing is said by what the engine declares to be its own convention, nor by the depth of a union, which may be
    that of one pair of pieces, or of a way out.
    """
    n = len(answers)
    size = np.maximum(a.magnitude, b.magnitude)
    rules = Rules(engine)
    conventions = set(rules.conventions(cell))
    answered = answers.status == Status.ANSWERED
    low, high = np.full(n, -np.inf), np.full(n, np.inf)
    if cell.query in (BOOLEAN, CONTACTS, RAYCAST):
        room = rules.allowed(cell, "boolean", size)
        high = np.where(answered & (answers.hit == 1), room, high)
        if cell.query != RAYCAST or not conventions & INSIDE_CONVENTIONS:
            low = np.where(answered & (answers.hit == 0), -room, low)
    said = answered & ~np.isnan(answers.distance)
    if cell.query == CONTACTS:
        said &= (answers.hit == 1) & (not conventions & OTHER_DEPTHS)
    if cell.query in (DISTANCE, CONTACTS):
        room, value = rules.allowed(cell, "value", size), answers.distance
        of_union = issubclass(cell.type_a, UNIONS) or issubclass(cell.type_b, UNIONS)
        some = (value == -np.inf) & (Convention.NO_DEPTH in conventions)
        vague = (value < 0) & (some | of_union)
        with np.errstate(invalid="ignore"):
            low = np.where(said & ~vague, np.maximum(low, value - room), low)
            high = np.where(said, np.minimum(high, np.where(vague, 0.0, value) + room), high)
    return Bounds(low, high)
