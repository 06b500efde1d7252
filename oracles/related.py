"""Related scenes: what a relation makes of a batch, and what the second answers must be if the first are right."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from oracles.apart import apart
from oracles.course import Course
from oracles.engine import VELOCITIES, Answers, Engine, Status
from oracles.motion import Motion
from oracles.promises import Bounds, Used, bounds_of, used
from oracles.rules import Rules
from oracles.scene import DISTANCE, IMPACT, RAYCAST, Cell, size_of
from oracles.world import World, world_of
from refimpl.linear import Array, Bools, norm
from refimpl.shapes import Proxy, Ray

EQUAL, GROWN, OTHER = "equal", "grown", "other"
"""How the answers themselves must correspond: alike, as those for larger shapes, or in bounds only."""

ROUNDING = 2.0**-48
"""Rounding of the comparison itself, relative to the largest number in it."""

Carried = tuple[Proxy, Array]
"""A batch of proxies, and by how much each may be off."""
Carry = Callable[[int, Proxy], Carried]
Velocities = tuple[Array, ...]
Timing = Callable[[Array, Array], Array]
"""By how much second times contradict the first; see `oracles.sweep_images`."""


@dataclass(frozen=True)
class Asked:
    """A batch of one cell that the engine has answered."""

    engine: Engine
    cell: Cell
    a: Proxy
    b: Proxy
    motion: Motion | Course | None
    answers: Answers

    def __len__(self) -> int:
        """Return the number of scenes."""
        return len(self.answers)

    @cached_property
    def bounds(self) -> Bounds:
        """What the answers say of the signed distances."""
        if self.motion is not None:
            return Bounds.none(len(self))
        return bounds_of(self.engine, self.cell, self.a, self.b, self.answers)

    @cached_property
    def size(self) -> Array:
        """Largest number of each scene, or largest velocity."""
        return size_of(self.a, self.b, self.motion)

    @property
    def world(self) -> World:
        """The world of both proxies."""
        return world_of(self.b)

    @cached_property
    def seen(self) -> Answers:
        """The answers with the vectors of that world."""
        return self.world.cut(self.answers)

    @property
    def times(self) -> Array:
        """Times of the hits, infinite for a miss, NaN where there is neither."""
        known = np.where(self.answers.hit == 1, self.answers.t, np.inf)
        told = (self.answers.status == Status.ANSWERED) & ~np.isnan(self.answers.hit)
        return np.where(told, known, np.nan)

    @cached_property
    def used(self) -> tuple[Used, Used]:
        """The shapes that the engine effectively uses."""
        return used(self.engine, self.cell, self.a, self.b)

    @property
    def sides(self) -> tuple[Proxy, Proxy]:
        """Both proxies."""
        return self.a, self.b

    def room(self, kind: str) -> Array:
        """What the engine promises: "value", "witness" or "boolean"."""
        return Rules(self.engine).allowed(self.cell, kind, self.size)

    def take(self, rows: NDArray[np.int_], answers: Answers) -> Asked:
        """Pick rows, of which `answers` are the answers."""
        motion = None if self.motion is None else self.motion[rows]
        return replace(self, a=self.a[rows], b=self.b[rows], motion=motion, answers=answers)


@dataclass(frozen=True)
class Image:
    """The scenes to which a relation takes all scenes of a batch.

    Attributes
    ----------
    cell, a, b, motion
        What the engine is to be asked.
    sources
        From which side of the first scene each side is made; None for a shape of its own.
    carry
        What the map makes of a shape on a side: the engine effectively uses images of what it used before.
    errors : two of (n,)
        By how much each side may be off, on the scene's own shapes; infinite where there is no image.
    expected
        Bounds on σ of the image that follow from the first answers.
    factor
        By which lengths, and velocities, are multiplied.
    alike
        `EQUAL`, `GROWN` or `OTHER`.
    timing
        Of sweeps what the second times must be.
    undo
        Gives the second answers' velocities as those of the first scene; takes the answers, and their rows here.
    rows
        Of the batch, where some were taken.
    """

    cell: Cell
    a: Proxy
    b: Proxy
    sources: tuple[int | None, int | None]
    carry: Carry
    errors: tuple[Array, Array]
    expected: Bounds
    motion: Motion | Course | None = None
    factor: float = 1.0
    alike: str = EQUAL
    timing: Timing | None = None
    undo: Callable[[Answers, NDArray[np.int_]], Velocities] | None = None
    rows: NDArray[np.int_] | None = None

    def take(self, rows: NDArray[np.int_]) -> Image:
        """Pick rows."""
        return replace(
            self,
            a=self.a[rows],
            b=self.b[rows],
            errors=(self.errors[0][rows], self.errors[1][rows]),
            expected=self.expected.take(rows),
            motion=None if self.motion is None else self.motion[rows],
            rows=rows,
        )

    def in_table_order(self) -> Image:
        """The same with its sides exchanged, where only that is a cell of the table."""
        pair = self.cell.type_a, self.cell.type_b
        if pair in world_of(self.b).table or self.motion is not None:
            return self
        flipped, carry = Cell(self.cell.query, *pair[::-1]), self.carry
        return replace(
            self,
            cell=flipped,
            a=self.b,
            b=self.a,
            sources=self.sources[::-1],
            carry=lambda side, shape: carry(1 - side, shape),
            errors=self.errors[::-1],
        )

    def looseness(self, asked: Asked) -> Array:
        """By how much σ of the shapes that the engine effectively uses may differ from that of exact images."""
        total = self.errors[0] + self.errors[1]
        if isinstance(self.motion, Motion) or not np.isfinite(total).any():
            return total
        after = self.used_by(asked.engine)
        for side, source in enumerate(self.sources):
            its = None if source is None else asked.used[source]
            total = total + self._departure(side, its, after[side])
        return total

    def used_by(self, engine: Engine) -> tuple[Used, Used]:
        """The shapes that an engine effectively uses."""
        return used(engine, self.cell, self.a, self.b)

    def _departure(self, side: int, before: Used | None, after: Used) -> Array:
        if before is None:
            return np.where(after.given, 0.0, np.full(len(after.margin), np.inf))
        if (before.given and after.given) or (before.agrees_with(after) and self.factor == 1):
            return np.zeros(len(after.margin))
        shape, error = self.carry(side, before.shape)
        return error + apart(shape, after.shape) + np.abs(after.margin - self.factor * before.margin)

    def self_evident(self, asked: Asked) -> bool:
        """Whether the engine effectively uses both scenes' own shapes, so that no convention can excuse it."""
        if self.motion is not None:
            return False
        return all(side.given for side in (*asked.used, *self.used_by(asked.engine)))


def image_of(
    asked: Asked,
    carry: Carry,
    *,
    sources: tuple[int, int] = (0, 1),
    query: str | None = None,
    expected: Bounds | None = None,
    factor: float = 1.0,
    alike: str = EQUAL,
    motion: Course | None = None,
    timing: Timing | None = None,
) -> Image:
    """Make both sides by one map; what is expected is by default what was answered, and courses stay as they are."""
    (a, error_a), (b, error_b) = (carry(side, asked.sides[source]) for side, source in enumerate(sources))
    bounds = asked.bounds.times(factor) if expected is None else expected
    cell = Cell(query or asked.cell.query, type(a), type(b))
    course = asked.motion if motion is None and query is None else motion
    errors = error_a, error_b
    return Image(cell, a, b, sources, carry, errors, bounds, course, factor=factor, alike=alike, timing=timing)


# -- comparing -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Difference:
    """What two batches of answers differ in.

    Attributes
    ----------
    excess : (n,)
        By how much their bounds exclude each other, beyond all that the engine promises and the map is inexact by;
        at most 0 where they do not, −∞ where they could not.
    differs : (n,) bool
        The answers are not alike, though both may be right within their tolerance.
    comparable : (n,) bool
        Whether there is anything to compare.
    """

    excess: Array
    differs: Bools
    comparable: Bools


def difference(asked: Asked, image: Image, answers: Answers, loose: Array) -> Difference:
    """Compare the answers of the image with what the first answers demand."""
    both = (asked.answers.status == Status.ANSWERED) & (answers.status == Status.ANSWERED)
    second = Asked(asked.engine, image.cell, image.a, image.b, image.motion, answers)
    excess = _excess(image.expected, second.bounds, second.size) - loose
    excess = np.where(both, excess, -np.inf)
    differs, told = np.zeros(len(both), dtype=bool), np.isfinite(excess) | (excess == np.inf)
    for part in _unlike(asked, second, image, loose):
        differs |= part[0]
        told |= part[1]
    return Difference(excess, differs & both, told & both)


def _excess(expected: Bounds, found: Bounds, size: Array) -> Array:
    """By how much the bounds exclude each other, but for rounding."""
    ends = np.stack([expected.low, expected.high, found.low, found.high])
    scale_of = np.maximum(np.abs(np.where(np.isfinite(ends), ends, 0.0)).max(axis=0), size)
    return np.asarray(expected.excess(found) - ROUNDING * scale_of)


def _unlike(first: Asked, second: Asked, image: Image, loose: Array) -> Iterator[tuple[Bools, Bools]]:
    """For each kind of answer: where the two are not alike, and where both say it."""
    if image.alike == OTHER:
        return
    if isinstance(first.motion, Course):
        yield _other_times(first, second, image, loose)
        return
    one, two = first.answers, second.answers
    hits = ~np.isnan(one.hit) & ~np.isnan(two.hit) & (first.cell.query != DISTANCE)
    unlike = (one.hit == 1) & (two.hit == 0) if image.alike == GROWN else one.hit != two.hit
    yield hits & unlike, hits
    if first.cell.query == RAYCAST and isinstance(first.a, Ray):
        timed = (one.hit == 1) & (two.hit == 1) & np.isfinite(one.t) & np.isfinite(two.t)
        later = np.where(timed, two.t, 0.0) - np.where(timed, one.t, 0.0)
        away = (later if image.alike == GROWN else np.abs(later)) * norm(first.a.direction)
        yield timed & (away > first.room("value") + second.room("value") / image.factor), timed
    if first.cell.query == IMPACT and image.undo is not None:
        yield _other_velocities(first, second, image)


def _other_times(first: Asked, second: Asked, image: Image, loose: Array) -> tuple[Bools, Bools]:
    """Times that contradict each other by more of the way than is allowed."""
    assert isinstance(first.motion, Course)
    timing = image.timing or equal
    told = ~np.isnan(first.times) & ~np.isnan(second.times)
    contradiction = timing(np.where(told, first.times, 0.0), np.where(told, second.times, 0.0))
    way, room = first.motion.way(first.a, first.b), first.room("value") + second.room("value") / image.factor + loose
    with np.errstate(invalid="ignore"):
        return told & (contradiction > 0) & ~(contradiction * way <= room), told


def equal(first: Array, second: Array) -> Array:
    """By how much times differ that should be the same, infinite for a miss."""
    with np.errstate(invalid="ignore"):
        return np.where(first == second, 0.0, np.abs(second - first))


def _other_velocities(first: Asked, second: Asked, image: Image) -> tuple[Bools, Bools]:
    assert image.undo is not None
    assert image.rows is not None
    assert isinstance(first.motion, Motion)
    levers = [norm(first.motion.point - body.position) for body in first.motion.bodies]
    away = np.zeros(len(first))
    with np.errstate(invalid="ignore"):
        for number, (name, back) in enumerate(zip(VELOCITIES, image.undo(second.answers, image.rows), strict=True)):
            lever = 1.0 if number % 2 == 0 else levers[number // 2]
            away = np.fmax(away, np.abs(getattr(first.answers, name) - back).max(axis=1) * lever)
    room = first.room("value") + second.room("value") / image.factor + image.errors[0] + image.errors[1]
    return away > room, np.ones(len(first), dtype=bool)
