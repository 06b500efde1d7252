"""Engines whose answer depends on more than the scene, or that do not always come back with one."""

from __future__ import annotations

import math
import os
import threading
from typing import Any

from oracles.claims import FALSE, LONG, MISSED, NOT_A_NUMBER, SHORT
from oracles.engine import COLUMNS, NOWHERE, AnswerRow, Kind, Row
from oracles.judge import CRASHED, RAISED, TIMED_OUT
from oracles.planted.mutant import Planted, wrong
from oracles.planted.shapes import Ball, Brick, Gap, Plane, Rod, Shape
from oracles.planted.vectors import dot, length, sub
from oracles.scene import BOOLEAN, DISTANCE, IMPACT
from refimpl.shapes import AABB


@wrong(DISTANCE, "Point–Sphere", LONG, SHORT)
class EveryThousandth(Planted):
    """Wrong only every 1 000th call, which is answered with the distance of the call before."""

    remembers = True

    def __init__(self) -> None:
        self.calls, self.last = 0, 0.0

    def ball_ball(self, a: Ball, b: Ball) -> Gap:
        gap = super().ball_ball(a, b)
        self.calls += 1
        before, self.last = self.last, gap.distance
        return gap._replace(distance=before) if self.calls % 1000 == 0 else gap


@wrong(BOOLEAN, "Sphere–AABB", FALSE, MISSED)
class StaleBox(Planted):
    """Stale state: a box with the same lower corner as the one before is taken for the same box."""

    remembers = True

    def __init__(self) -> None:
        self.known: tuple[list[float], Shape] | None = None

    def read(self, kind: Kind, row: Row) -> Shape:
        if kind is not AABB:
            return super().read(kind, row)
        if self.known is None or self.known[0] != row[:3]:
            self.known = row[:3], super().read(kind, row)
        return self.known[1]


@wrong(DISTANCE, "Capsule–HalfSpace", LONG, SHORT)
class CachedByHash(Planted):
    """Stale state: answers are kept by numbers rounded to whole ones, and given again to whoever has the same."""

    remembers = True

    def __init__(self) -> None:
        self.kept: dict[tuple[Any, ...], float] = {}

    def rod_plane(self, a: Rod, b: Plane) -> Gap:
        gap = super().rod_plane(a, b)
        key = tuple(round(min(max(x, -1e9), 1e9)) for x in (*a.p, *a.q, a.radius, *b.normal, b.offset))
        return gap._replace(distance=self.kept.setdefault(key, gap.distance))


@wrong(DISTANCE, "Point–AABB", LONG, SHORT)
class SlowlyDrifting(Planted):
    """Answers depend on history: each call leaves a trace of 1e-11 that adds up in all later ones."""

    remembers = True

    def __init__(self) -> None:
        self.drift = 1.0

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        self.drift *= 1 + 1e-11
        return gap._replace(distance=gap.distance * self.drift)


@wrong(DISTANCE, "Point–HalfSpace", LONG, SHORT)
class OtherThread(Planted):
    """Answers depend on the thread: every second call is made in one that has not heard of the plane yet."""

    remembers = True

    def __init__(self) -> None:
        self.calls, self.plane_of_thread = 0, {True: 0.0, False: 0.0}

    def ball_plane(self, a: Ball, b: Plane) -> Gap:
        found: list[Gap] = []
        self.calls += 1

        def solve() -> None:
            main = threading.current_thread() is threading.main_thread()
            if main:
                self.plane_of_thread = {True: b.offset, False: self.plane_of_thread[True]}
            found.append(super(OtherThread, self).ball_plane(a, b._replace(offset=self.plane_of_thread[main])))

        if self.calls % 50:
            solve()
        else:
            other = threading.Thread(target=solve)
            other.start()
            other.join()
        return found[0]


@wrong(DISTANCE, "Sphere–Sphere", NOT_A_NUMBER)
class NotANumberWhenConcentric(Planted):
    """Not a number in one place: the normal of concentric balls is 0 by 0."""

    def ball_ball(self, a: Ball, b: Ball) -> Gap:
        gap = super().ball_ball(a, b)
        return gap._replace(normal=(math.nan, math.nan, math.nan)) if a.center == b.center else gap


@wrong(DISTANCE, "Point–Capsule", RAISED)
class RaisesOnAxis(Planted):
    """Raises in one place: a point on the axis of a rod is divided by its distance from it."""

    def ball_rod(self, a: Ball, b: Rod) -> Gap:
        foot = self.foot(a.center, b.p, b.q)
        assert 1.0 / length(sub(a.center, foot)) > 0
        return super().ball_rod(a, b)


@wrong(DISTANCE, "Capsule–Capsule", TIMED_OUT)
class HangsWhenParallel(Planted):
    """Hangs rarely: of exactly parallel rods, the loop over the crossing never ends."""

    def rod_rod(self, a: Rod, b: Rod) -> Gap:
        while abs(dot(a.axis, b.axis)) == 1.0:
            pass
        return super().rod_rod(a, b)


@wrong(DISTANCE, "AABB–AABB", CRASHED)
class CrashesWhenEqual(Planted):
    """Crashes rarely: boxes with the same centre end the process."""

    def upright_upright(self, a: Brick, b: Brick) -> Gap:
        if a.center == b.center:
            os.abort()
        return super().upright_upright(a, b)


@wrong(DISTANCE, "Sphere–Capsule", NOT_A_NUMBER)
class NotANumberAfterOverlap(Planted):
    """Leaves traces: after a deep overlap, the next answer is not a number."""

    remembers = True

    def __init__(self) -> None:
        self.deep = False

    def distance(self, gap: Gap) -> AnswerRow:
        before, self.deep = self.deep, gap.distance < -2.0
        return super().distance(gap._replace(distance=math.nan) if before else gap)


@wrong(DISTANCE, "Sphere–HalfSpace", LONG, SHORT)
class BufferReused(Planted):
    """Stale state: the radius is kept in a buffer of ten, of which one place is written a call late."""

    remembers = True

    def __init__(self) -> None:
        self.radii, self.calls = [1.0] * 10, 0

    def ball_plane(self, a: Ball, b: Plane) -> Gap:
        place = self.calls % 10
        self.calls += 1
        if place != 7:
            self.radii[place] = a.radius
        gap = super().ball_plane(a._replace(radius=self.radii[place]), b)
        self.radii[place] = a.radius
        return gap


@wrong(IMPACT, "Sphere–Capsule", NOT_A_NUMBER)
class SpinsNotTold(Planted):
    """The angular velocities after an impact are not told."""

    def impact(self, row: Row) -> AnswerRow:
        told = list(super().impact(row))
        for name in ("angular_a", "angular_b"):
            told[COLUMNS[name]] = NOWHERE
        return told
