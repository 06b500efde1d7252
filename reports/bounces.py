"""The table of `proxyproof bounces`: what PyBullet's default settings make of a restitution."""

from __future__ import annotations

import numpy as np

from oracles.bounces import MOMENTS, Bounces
from refimpl.linear import Array
from reports.markdown import table_lines
from reports.tables import Column, Entry, Table

CAPTION = (
    "Speed of a ball after it has met a plane, as a share of its speed before, in PyBullet with default settings "
    f"(least … most, over {MOMENTS} moments within a step of 1/240 at which it may get there); by the formula it is e"
)
CLOSE = 0.005
"""Shares nearer than this are given as one."""


def table(found: Bounces) -> Table:
    """Rows by restitution, columns by speed."""
    columns = [Column("e"), *(Column(f"at {speed:g}", numeric=True) for speed in found.speeds)]
    rows = [
        (Entry(f"{e:g}"), *(Entry(shares(row)) for row in rows))
        for e, rows in zip(found.restitutions, found.shares, strict=True)
    ]
    return Table(CAPTION, tuple(columns), tuple(rows))


def shares(row: Array) -> str:
    """Least and most of the shares, or one where they are close."""
    least, most = float(np.min(row)), float(np.max(row))
    if most - least < CLOSE:
        return _number(float(np.median(row)))
    return f"{_number(least)} … {_number(most)}"


def _number(share: float) -> str:
    return f"{round(share, 2) + 0.0:.2f}".replace("-", "−")


def as_markdown(found: Bounces) -> str:
    """Return the table in Markdown, below its caption."""
    made = table(found)
    return "\n".join([f"{made.caption}:", "", *table_lines(made)]) + "\n"
