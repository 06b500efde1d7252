"""Asking a broad phase in a process of its own, which may crash or hang."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from oracles.crowds.boxes import BoxCrowd, Pair
from oracles.engines import load_engine
from oracles.isolation.child import Answerer
from oracles.isolation.children import NO_ANSWER, Said, ask_apart

EACH = 5.0
"""Seconds for each crowd."""


@dataclass(frozen=True)
class Answer:
    """What an engine said of one crowd: pairs i < j, or in words why there are none; and the nearest pair."""

    pairs: frozenset[Pair] = frozenset()
    lost: str = ""
    nearest: Pair | None = None


def ask(spec: str, crowds: Sequence[BoxCrowd]) -> list[Answer]:
    """Have the engine of this name or address answer some crowds."""
    said = ask_apart("oracles.crowds.asking:answerer", spec, [crowd.to_json() for crowd in crowds], EACH)
    return [_read(one, crowd) for one, crowd in zip(said, crowds, strict=True)]


def _read(said: Said, crowd: BoxCrowd) -> Answer:
    """What was said, as an answer."""
    if said.lost:
        return Answer(lost=said.lost)
    try:
        pairs = frozenset((int(i), int(j)) for i, j in said.answer["pairs"])
        nearest = _nearest(said.answer["nearest"], len(crowd))
    except (ValueError, LookupError, TypeError):
        return Answer(lost=NO_ANSWER)
    inside = all(0 <= i < j < len(crowd) for i, j in pairs)
    return Answer(pairs, nearest=nearest) if inside else Answer(lost="a pair of bodies that are none")


def _nearest(data: Any, count: int) -> Pair | None:
    if data is None:
        return None
    i, j = (int(number) for number in data)
    if not (0 <= i < count and 0 <= j < count and i != j):
        raise ValueError("no pair of bodies")
    return i, j


def answerer(spec: str) -> Answerer:
    """What answers in the child: the engine's broad phase."""
    solver = load_engine(spec).broad_phase()
    if solver is None:
        raise LookupError("the engine has no broad phase that is asked")

    def answer(question: Any) -> dict[str, object]:
        crowd = BoxCrowd.from_json(question)
        pairs = sorted({(min(pair), max(pair)) for pair in solver.pairs(crowd) if pair[0] != pair[1]})
        return {"pairs": pairs, "nearest": solver.nearest(crowd.thinned())}

    return answer
