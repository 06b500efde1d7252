"""A small engine that is right, and others made from it that are wrong on purpose, each in one way.

Name one to a worker with `spec`. Those that are lost (crash, hang, raise) are so only in scenes where the first
coordinate of A is positive, so that the scenes between show whether the campaign goes on.
"""

from __future__ import annotations

import math
import os
import sys
import time
from typing import Any, ClassVar

from oracles.engine import (
    NATIVE,
    AnswerRow,
    Engine,
    EngineUnavailable,
    Kind,
    Row,
    Solver,
    Support,
    Tolerance,
    UnsupportedCell,
    answer_row,
    unsupported,
)
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST
from refimpl.shapes import AABB, Point, Ray, Sphere

Answer = dict[str, Any]

COLUMNS_OF = {DISTANCE: {"distance", "on_a", "on_b", "normal"}, BOOLEAN: {"hit"}, RAYCAST: {"hit", "t"}}
COLUMNS_OF[CONTACTS] = COLUMNS_OF[DISTANCE] | {"hit"}


def spec(engine: type[Engine]) -> str:
    """Name of one of these engines for `load_engine` and `EngineWorker`."""
    return f"{engine.__module__}:{engine.__name__}"


class Honest(Engine):
    """Closed forms for balls against balls and axis-aligned boxes, and rays against balls."""

    name: ClassVar[str] = "honest"

    def versions(self) -> dict[str, str]:
        return {"honest": "1.0"}

    def warm(self) -> None:
        pass

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        wanted = (Ray,) if query == RAYCAST else (Point, Sphere)
        if A in wanted and (B is Sphere or (B is AABB and query != RAYCAST)):
            return NATIVE
        return unsupported("not written")

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        return frozenset(COLUMNS_OF[query])

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        return Tolerance.uniform(0.0, 1e-12, "closed forms")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        self.require(query, A, B)
        if query == RAYCAST:
            return lambda a, b: self.spoil(ray_ball(a, b), a)
        return lambda a, b: self.spoil(of_query(query, ball_box(a, b) if B is AABB else ball_ball(a, b)), a)

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        """Where the others go wrong."""
        return answer_row(**answer)


def ball_ball(a: Row, b: Row) -> Answer:
    ca, cb = a[:3], b[:3]
    ra, rb = (a[3] if len(a) > 3 else 0.0), b[3]
    gap = math.dist(ca, cb)
    n = [(y - x) / gap for x, y in zip(ca, cb, strict=True)] if gap > 0 else [1.0, 0.0, 0.0]
    on_a = [x + ra * u for x, u in zip(ca, n, strict=True)]
    on_b = [x - rb * u for x, u in zip(cb, n, strict=True)]
    return {"distance": gap - (ra + rb), "on_a": on_a, "on_b": on_b, "normal": n}


def ball_box(a: Row, b: Row) -> Answer:
    c, r = a[:3], (a[3] if len(a) > 3 else 0.0)
    lower, upper = b[:3], b[3:]
    near = [min(max(x, lo), up) for x, lo, up in zip(c, lower, upper, strict=True)]
    gap = math.dist(c, near)
    if gap > 0:
        n = [(y - x) / gap for x, y in zip(c, near, strict=True)]
    else:
        faces = [(up - x, i, -1.0) for i, (x, up) in enumerate(zip(c, upper, strict=True))]
        faces += [(x - lo, i, 1.0) for i, (x, lo) in enumerate(zip(c, lower, strict=True))]
        depth, axis, sign = min(faces)
        n = [sign if i == axis else 0.0 for i in range(3)]
        near = [x - depth * u for x, u in zip(c, n, strict=True)]
        gap = -depth
    on_a = [x + r * u for x, u in zip(c, n, strict=True)]
    return {"distance": gap - r, "on_a": on_a, "on_b": near, "normal": n}


def ray_ball(a: Row, b: Row) -> Answer:
    """Half chord at the nearest point of the line: the textbook quadratic loses digits far away."""
    origin, direction, center, radius = a[:3], a[3:], b[:3], b[3]
    away = [o - c for o, c in zip(origin, center, strict=True)]
    if math.hypot(*away) <= radius:
        return {"hit": 1.0, "t": 0.0}
    square = math.fsum(d * d for d in direction)
    middle = -math.fsum(d * w for d, w in zip(direction, away, strict=True)) / square
    nearest = math.hypot(*(w + middle * d for w, d in zip(away, direction, strict=True)))
    if nearest > radius or middle < 0:
        return {"hit": 0.0, "t": math.inf}
    t = middle - math.sqrt((radius - nearest) * (radius + nearest) / square)
    outward = [w + t * d for w, d in zip(away, direction, strict=True)]
    length = math.hypot(*outward)  # of a tiny ball far from the start, not quite its radius
    return {"hit": 1.0, "t": t, "normal": [x / length for x in outward]}


def of_query(query: str, answer: Answer) -> Answer:
    hit = float(answer["distance"] <= 0)
    if query == BOOLEAN:
        return {"hit": hit}
    if query == CONTACTS:
        return {"hit": hit, **answer} if hit else {"hit": hit}
    return answer


# -- wrong answers -------------------------------------------------------------------------------------------


class OffByAThousandth(Honest):
    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        for name in ("distance", "t"):
            if name in answer:
                answer[name] += 1e-3
        return super().spoil(answer, row_a)


class OffByAShare(Honest):
    """Distances of balls are too large by a thousandth of the scene's size: one fault, whatever the scale."""

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        if query == DISTANCE and A is Sphere and B is Sphere:
            return NATIVE
        return unsupported("not written")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        self.require(query, A, B)

        def answer(a: Row, b: Row) -> AnswerRow:
            found = ball_ball(a, b)
            found["distance"] += 1e-3 * max(map(abs, (*a, *b)))
            return answer_row(**found)

        return answer


class FlippedNormal(Honest):
    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        if "normal" in answer:
            answer["normal"] = [-u for u in answer["normal"]]
        return super().spoil(answer, row_a)


class MissedContact(Honest):
    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        if answer.get("hit") == 1:
            answer = {"hit": 0.0, "t": math.inf}
        return super().spoil(answer, row_a)


class NotANumber(Honest):
    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        return super().spoil(dict.fromkeys(answer, math.nan) | vectors(answer), row_a)


def vectors(answer: Answer) -> Answer:
    return {name: [math.nan] * 3 for name in answer if name in ("on_a", "on_b", "normal")}


class Mistyped(Honest):
    """Answers with a word where a number should be, with too few numbers, or with nothing."""

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        return ["yes"] * 15 if row_a[0] > 1 else [1.0] if row_a[0] > 0 else None  # type: ignore[list-item, return-value]


# -- no answers ----------------------------------------------------------------------------------------------


class Crashing(Honest):
    beyond: ClassVar[float] = 0.0
    """A's first coordinate from which on it is lost."""

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        if row_a[0] > self.beyond:
            os.write(2, b"assertion failed on purpose\n")
            os.abort()
        return super().spoil(answer, row_a)


class Leaving(Honest):
    beyond: ClassVar[float] = 0.0

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        if row_a[0] > self.beyond:
            sys.exit(7)
        return super().spoil(answer, row_a)


class Hanging(Honest):
    beyond: ClassVar[float] = 0.0

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        while row_a[0] > self.beyond:
            pass
        return super().spoil(answer, row_a)


class Sleeping(Honest):
    """Takes as many seconds as A's first coordinate says, and no processor time."""

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        time.sleep(max(0.0, row_a[0]))
        return super().spoil(answer, row_a)


class Slow(Honest):
    """Takes ten seconds for any answer, and no processor time."""

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        time.sleep(10.0)
        return super().spoil(answer, row_a)


class Raising(Honest):
    beyond: ClassVar[float] = 0.0

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        if row_a[0] > self.beyond:
            raise ValueError("on purpose")
        return super().spoil(answer, row_a)


class CrashingFarOut(Crashing):
    """As the next three: lost in few scenes, where losing many tells no more and takes longer."""

    beyond = 30.0


class LeavingFarOut(Leaving):
    beyond = 30.0


class HangingFarOut(Hanging):
    beyond = 30.0


class RaisingFarOut(Raising):
    beyond = 30.0


class Picky(Honest):
    """Answers the cell, but cannot hold some of its shapes."""

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        if row_a[0] > 0:
            raise UnsupportedCell("on purpose")
        return super().spoil(answer, row_a)


class Counting(Honest):
    """Answers with the length of the rows, whatever the shapes."""

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        return NATIVE

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        return lambda a, b: answer_row(distance=len(a), on_a=b[:3], on_b=b[:3], normal=b[:3])


class Remembering(Honest):
    """Answers how many scenes it was asked before."""

    def __init__(self) -> None:
        self.asked = 0

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        self.asked += 1
        return super().spoil(answer | {"distance": self.asked - 1.0}, row_a)


class Noisy(Honest):
    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        os.write(1, b"a line that nobody wants to read\n" * 3000)
        print("another\n" * 10000, file=sys.stderr)
        return super().spoil(answer, row_a)


class RaisingSolver(Honest):
    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        raise RuntimeError("no solver on purpose")


class CrashingSolver(Honest):
    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        os.abort()


class Switched(Honest):
    """Right, or wrong in the way that the environment names, as is its version."""

    name: ClassVar[str] = "switched"

    def versions(self) -> dict[str, str]:
        return {"switched": os.environ.get("SWITCHED_VERSION", "1.0")}

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        """Add to distances, or flip normals; on one side only, where the environment names one."""
        fault, _, side = os.environ.get("SWITCHED_FAULT", "").partition("@")
        if (side == "left" and row_a[0] > 0) or (side == "right" and row_a[0] <= 0):
            fault = ""
        if fault == "flipped" and "normal" in answer:
            answer["normal"] = [-u for u in answer["normal"]]
        elif fault == "lost":
            if row_a[0] > 30:
                os.abort()
        elif fault and "distance" in answer:
            answer["distance"] += float(fault) if math.isfinite(answer["distance"]) else 0.0
        return answer_row(**answer)


# -- engines that do not even start --------------------------------------------------------------------------


class Missing(Honest):
    def warm(self) -> None:
        raise EngineUnavailable("the package nowhere is not installed: pip install nowhere")


class Failing(Honest):
    def warm(self) -> None:
        raise OSError("libnowhere.so: cannot open shared object file")


class Dying(Honest):
    def warm(self) -> None:
        os.write(2, b"bad processor\n")
        os.abort()


LIARS: tuple[type[Honest], ...] = (OffByAThousandth, FlippedNormal, MissedContact, NotANumber)
LOSERS: tuple[type[Honest], ...] = (Crashing, Leaving, Hanging, Raising)
