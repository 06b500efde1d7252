"""First contact of a moving vertex and face, or of two moving edges, decided exactly, with a certificate.

What excludes a contact at a time, and why nothing else does, `refimpl.proof.triangles` says. The search follows time:
an exclusion that holds now keeps the sets apart until one of its polynomials has a root. Either another exclusion holds
there, and leads on, or that root is the first contact. Each step passes a root, of which there are finitely many.

The queries are those of Wang et al. 2021, A Large-Scale Benchmark and an Inclusion-Based Algorithm for Continuous
Collision Detection. Brochu, Edwards, Bridson 2012, Efficient Geometrically Exact Continuous Collision Detection, decide
whether there is a contact by the parity of crossings, without its time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.proof.rational import whole
from refimpl.proof.triangles import AXES, EdgeEdge, Exclusion, Exclusions, TouchCertificate, VertexFace, holds
from refimpl.proof.vectors import Whole
from refimpl.sweeps.roots import END, Root, earlier, first_root

START = Fraction(0)
WIDTH = Fraction(1, 1 << 40)  # 0.91e-12
NONE = -1


@dataclass(frozen=True)
class Touch:
    """Whether and when moving triangles' features touch.

    Attributes
    ----------
    hit : whether there is a time in [0, 1] at which they have a point in common
    low, high : the first such time is in [low, high], at most 1e-12 wide; None without a hit
    certificate : proves it; for `refimpl.proof.triangles`
    """

    hit: bool
    low: Fraction | None
    high: Fraction | None
    certificate: TouchCertificate

    @property
    def t(self) -> float:
        """First time of contact as a double, at most 1e-12 off; inf without a hit."""
        return math.inf if self.high is None else float(self.high)


def vertex_face(start: Any, end: Any) -> Touch:
    """First time in [0, 1] at which a moving vertex is on a moving face.

    Parameters
    ----------
    start, end : (4, 3) finite floats, ints or Fractions
        The vertex and the corners of the face, at time 0 and at time 1; each moves on a straight line at constant
        velocity [length]. The numbers are taken as the rationals that they are, and nothing is rounded.

    Touching counts, at the face's edges and corners too, and at the times 0 and 1. A face may be degenerate, at any
    time: it is then a segment or a point.

    Raises `ValueError` for other shapes and numbers that are not finite, `TypeError` for what is no number.
    """
    return _first_touch(VertexFace(*_read(start, end)))


def edge_edge(start: Any, end: Any) -> Touch:
    """First time in [0, 1] at which two moving edges have a point in common.

    Parameters
    ----------
    start, end : (4, 3) finite floats, ints or Fractions
        The ends of the one edge and of the other, as in `vertex_face`. An edge may be a point, at any time.
    """
    return _first_touch(EdgeEdge(*_read(start, end)))


def _read(start: Any, end: Any) -> tuple[list[Whole], list[Whole]]:
    """Points at both times, as integers on one common denominator."""
    points = [*_points(start, "start"), *_points(end, "end")]
    grid, _ = whole(points)
    return grid[:4], grid[4:]


def _points(given: Any, what: str) -> Sequence[Sequence[Any]]:
    rows = given.tolist() if isinstance(given, np.ndarray) else [list(row) for row in given]
    if len(rows) != 4 or any(len(row) != 3 for row in rows):
        raise ValueError(f"{what}: must be 4 points of 3 coordinates, got {[len(row) for row in rows]}")
    for x in (x for row in rows for x in row):
        if not isinstance(x, float | int | Fraction | np.integer):
            raise TypeError(f"{what}: {x!r} is not a float, an int or a Fraction")
        if not math.isfinite(x):
            raise ValueError(f"{what}: must be finite, got {x!r}")
    return rows


def _first_touch(exclusions: Exclusions) -> Touch:
    for axis in AXES:  # most often they are apart along an axis all the time
        if holds(exclusions[axis], START, END):
            return Touch(False, None, None, TouchCertificate(((END, axis),)))
    cover: list[tuple[Fraction, int]] = []
    now, which = START, NONE
    root: Root | None = Root((0, 1), START, START)
    while root is not None:
        other = _holding(exclusions, root, which)
        if other == NONE:
            root.narrow(WIDTH)
        cover += _pieces(exclusions, which, now, root.low)
        if other == NONE:
            return Touch(True, root.low, root.high, TouchCertificate(tuple(cover), root.polynomial, root.high))
        cover += _pieces(exclusions, other, root.low, root.high)
        now, which = root.high, other
        root = _end(exclusions[which], now)
    return Touch(False, None, None, TouchCertificate((*cover, *_pieces(exclusions, which, now, END))))


def _holding(exclusions: Exclusions, root: Root, ended: int) -> int:
    """An exclusion that holds at a root, and on the interval that is left of it; `ended` is known not to."""
    for i in range(len(exclusions)):
        if i != ended and _holds_at(exclusions[i], root):
            return i
    return NONE


def _holds_at(exclusion: Exclusion, root: Root) -> bool:
    first, *others = exclusion
    sign = root.sign(first)
    return sign != 0 and all(root.sign(p) == sign for p in others)


def _end(exclusion: Exclusion, now: Fraction) -> Root | None:
    """When an exclusion that holds now ends: at the first root of one of its polynomials, up to time 1."""
    end: Root | None = None
    for p in exclusion:
        root = first_root(p, now, END if end is None else end.high)
        if root is not None:
            end = root if end is None else earlier(end, root)
    return end


def _pieces(exclusions: Exclusions, which: int, low: Fraction, high: Fraction) -> list[tuple[Fraction, int]]:
    """Cut a time on all of which an exclusion holds into pieces on which that is seen at once."""
    pieces = []
    waiting = [(low, high)] if low < high else []
    while waiting:
        low, high = waiting.pop()
        if holds(exclusions[which], low, high):
            pieces.append((high, which))
        else:
            middle = (low + high) / 2
            waiting += [(middle, high), (low, middle)]
    return pieces
