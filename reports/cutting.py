"""Fitting a text into a limit: parts are taken in the order of their rank, and stay in the order of the text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """A piece of a text that is taken as a whole or not at all.

    Attributes
    ----------
    lines
        Its lines.
    rank
        Lower ranks are taken first; within a rank, once one of a `series` does not fit, none after it is taken.
    headings
        Those above it, outermost first; shown once, before the first part that has them.
    series
        Whether it is one of many alike.
    name
        What is told to be left out without it.
    """

    lines: tuple[str, ...]
    rank: int
    headings: tuple[str, ...] = ()
    series: bool = False
    name: str = ""


def fitting(parts: Sequence[Part], limit: int) -> list[Part]:
    """Those parts that fit into so many bytes with their headings, in their order."""
    taken: set[int] = set()
    paid: set[str] = set()
    ended: set[int] = set()
    room = limit
    for position in sorted(range(len(parts)), key=lambda p: parts[p].rank):
        part = parts[position]
        headings = [heading for heading in part.headings if heading not in paid]
        cost = sum(len(line.encode()) + 1 for line in part.lines) + sum(len(h.encode()) + 2 for h in headings)
        if cost > room or part.rank in ended:
            if part.series:
                ended.add(part.rank)
            continue
        room -= cost
        paid.update(headings)
        taken.add(position)
    return [part for position, part in enumerate(parts) if position in taken]


def put_together(parts: Sequence[Part]) -> Iterator[str]:
    """Lines of the parts, each heading once."""
    shown: set[str] = set()
    for part in parts:
        for heading in part.headings:
            if heading not in shown:
                shown.add(heading)
                yield from (heading, "")
        yield from part.lines
