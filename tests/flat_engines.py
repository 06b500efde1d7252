"""A small engine of the plane that is right, and others made from it that are wrong on purpose, each in one way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from oracles.course import SIDE
from oracles.engine import (
    NATIVE,
    AnswerRow,
    Engine,
    Kind,
    Row,
    Solver,
    Support,
    Tolerance,
    answer_row,
    unsupported,
)
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST, SWEEP
from refimpl.flat import Disc, FlatPoint, Rectangle

Answer = dict[str, Any]
SAYS: Mapping[str, frozenset[str]] = {
    DISTANCE: frozenset({"distance", "on_a", "on_b", "normal"}),
    CONTACTS: frozenset({"hit", "distance", "on_a", "on_b", "normal"}),
    BOOLEAN: frozenset({"hit"}),
    RAYCAST: frozenset({"hit", "t", "point"}),
    SWEEP: frozenset({"hit", "t", "point"}),
}


class FlatTextbook(Engine):
    """Closed forms for discs and rectangles, and rays against discs."""

    name: ClassVar[str] = "flat-textbook"
    flat: ClassVar[bool] = True

    def versions(self) -> dict[str, str]:
        return {"flat-textbook": "1.0"}

    def warm(self) -> None:
        pass

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        if query == RAYCAST:
            return NATIVE if B is Disc else unsupported("not written")
        return NATIVE if A in (FlatPoint, Disc) and B in (Disc, Rectangle) else unsupported("not written")

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        return NATIVE if A is B is Disc else unsupported("not written")

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        return SAYS[query]

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        return Tolerance.uniform(0.0, 1e-12, "closed forms")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        self.require(query, A, B)
        if query == RAYCAST:
            return lambda a, b: self.told(query, ray_disc(a, b))
        if query == SWEEP:
            return lambda a, b: self.told(query, swept_discs(a, b))
        solve = disc_rectangle if B is Rectangle else disc_disc
        return lambda a, b: self.told(query, self.spoiled(solve(a, b), a, b))

    def told(self, query: str, answer: Answer) -> AnswerRow:
        """What of it the query asks, in three numbers."""
        if query in (BOOLEAN, CONTACTS):
            answer["hit"] = float(answer["distance"] <= 0)
        asked = {name: answer[name] for name in SAYS[query] if query != CONTACTS or answer["hit"] or name == "hit"}
        return answer_row(**{name: (*v, 0.0) if isinstance(v, list) else v for name, v in asked.items()})

    def spoiled(self, answer: Answer, a: Row, b: Row) -> Answer:
        """Where the others go wrong."""
        del a, b
        return answer


def disc_disc(a: Row, b: Row) -> Answer:
    ra, rb = (a[2] if len(a) > 2 else 0.0), b[2]
    gap = math.dist(a[:2], b[:2])
    n = [(y - x) / gap for x, y in zip(a[:2], b[:2], strict=True)] if gap > 0 else [1.0, 0.0]
    return _answer(a, ra, n, gap - (ra + rb), [y - rb * u for y, u in zip(b[:2], n, strict=True)])


def disc_rectangle(a: Row, b: Row) -> Answer:
    centre, radius, lower, upper = a[:2], (a[2] if len(a) > 2 else 0.0), b[:2], b[2:]
    near = [min(max(x, low), high) for x, low, high in zip(centre, lower, upper, strict=True)]
    gap = math.dist(centre, near)
    if gap > 0:
        n = [(y - x) / gap for x, y in zip(centre, near, strict=True)]
    else:
        sides = [(high - x, i, -1.0) for i, (x, high) in enumerate(zip(centre, upper, strict=True))]
        sides += [(x - low, i, 1.0) for i, (x, low) in enumerate(zip(centre, lower, strict=True))]
        gap, axis, sign = min(sides)
        n, near[axis] = [sign * (i == axis) for i in range(2)], (upper if sign < 0 else lower)[axis]
        gap = -gap
    return _answer(a, radius, n, gap - radius, near)


def _answer(a: Row, radius: float, n: list[float], distance: float, on_b: list[float]) -> Answer:
    on_a = [x + radius * u for x, u in zip(a[:2], n, strict=True)]
    return {"distance": distance, "on_a": on_a, "on_b": on_b, "normal": n}


def ray_disc(a: Row, b: Row) -> Answer:
    """Half chord at the nearest point of the line."""
    origin, way, centre, radius = a[:2], a[2:], b[:2], b[2]
    away = [o - c for o, c in zip(origin, centre, strict=True)]
    if math.hypot(*away) <= radius:
        return {"hit": 1.0, "t": 0.0, "point": list(origin)}
    square = math.fsum(d * d for d in way)
    middle = -math.fsum(d * w for d, w in zip(way, away, strict=True)) / square
    nearest = abs(way[0] * away[1] - way[1] * away[0]) / math.sqrt(square)
    if nearest > radius or middle < 0:
        return {"hit": 0.0, "t": math.inf, "point": [math.nan, math.nan]}
    t = middle - math.sqrt((radius - nearest) * (radius + nearest) / square)
    return {"hit": 1.0, "t": t, "point": [o + t * d for o, d in zip(origin, way, strict=True)]}


def swept_discs(a: Row, b: Row) -> Answer:
    """A ray of A's centre, as seen from B, against the disc of both radii."""
    (x, y, r), (u, v), (s, t) = a[:3], a[3:5], a[3 + SIDE : 5 + SIDE]
    found = ray_disc([x, y, u - s, v - t], [*b[:2], r + b[2]]) if (u, v) != (s, t) else {"hit": 0.0, "t": math.inf}
    if (u, v) == (s, t) and math.dist(a[:2], b[:2]) <= r + b[2]:
        found = {"hit": 1.0, "t": 0.0}
    if found["t"] > 1.0:
        return {"hit": 0.0, "t": math.inf, "point": [math.nan, math.nan]}
    time = found["t"]
    centre, other = [x + time * u, y + time * v], [b[0] + time * s, b[1] + time * t]
    gap = math.dist(centre, other)
    near = [p + r * (q - p) / gap if gap > 0 else p for p, q in zip(centre, other, strict=True)]
    inside = gap + min(r, b[2]) <= max(r, b[2])  # the whole of the smaller one is common to both
    return {"hit": 1.0, "t": time, "point": (centre if r < b[2] else other) if inside else near}


# -- wrong on purpose ----------------------------------------------------------------------------------------


class InLine(FlatTextbook):
    """Takes a disc for touching a rectangle whose side's line goes through its centre, as Chipmunk does."""

    def spoiled(self, answer: Answer, a: Row, b: Row) -> Answer:
        if len(b) == 4 and (a[1] in (b[1], b[3]) or a[0] in (b[0], b[2])) and answer["distance"] > 0:
            answer["distance"] = 0.0
        return answer


class WrongSign(FlatTextbook):
    """Tells the depth of a rectangle as a gap, beside a hit, as Chipmunk does of shapes in the other order."""

    def told(self, query: str, answer: Answer) -> AnswerRow:
        row = list(super().told(query, answer))
        if query == CONTACTS and answer["hit"]:
            row[1] = -row[1]
        return row


class Inward(FlatTextbook):
    """Turns normals round near a centre, nearer than 1e-5: another threshold of Chipmunk's."""

    def spoiled(self, answer: Answer, a: Row, b: Row) -> Answer:
        if len(b) == 3 and 0 < math.dist(a[:2], b[:2]) < 1e-5:
            answer["normal"] = [0.0, -1.0]
        return answer


class AtTheEnd(FlatTextbook):
    """Names the far end of a ray that starts inside as its hit point, as Chipmunk does."""

    def told(self, query: str, answer: Answer) -> AnswerRow:
        if query == RAYCAST and answer["t"] == 0.0:
            answer["point"] = [x + 1.0 for x in answer["point"]]
        return super().told(query, answer)


class Standing(FlatTextbook):
    """Lets its nearest points leave the plane."""

    def told(self, query: str, answer: Answer) -> AnswerRow:
        row = list(super().told(query, answer))
        row[7] = row[7] + 0.5
        return row


class Stopping(FlatTextbook):
    """Lets discs that are that move by less than a ten-thousandth of their size miss each other."""

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        solve = super().solver(query, A, B)

        def slow(a: Row, b: Row) -> AnswerRow:
            u, v, s, t = *a[3:5], *a[3 + SIDE : 5 + SIDE]
            if 0 < math.hypot(u - s, v - t) < 1e-4 * a[2]:
                return answer_row(hit=0.0, t=math.inf)
            return solve(a, b)

        return slow if query == SWEEP else solve
