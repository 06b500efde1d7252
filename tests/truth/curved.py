"""Signed distance of two bodies of which one or both are curved: every local minimum of h, then 50 digits.

A sum of two ellipsoids is the intersection of the ellipsoids M_A/(1 − β) + M_B/β over 0 < β < 1 (Kurzhanski and
Vályi, Ellipsoidal Calculus for Estimation and Control, 2.2). So min over n of h is the min over β of a point's depth
in one ellipsoid, whose critical directions are roots of one monotone function, and the search is along one line.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import mp, mpf  # type: ignore[import-untyped]

from tests.truth.bodies import Body
from tests.truth.cells import Cell, Search, both_signs, cells, fixed_directions, units
from tests.truth.critical import critical_directions
from tests.truth.newton import Smooth
from tests.truth.rationals import DIGITS, across, dot, in_floats, in_reals, opposite, real

Floats = Any
ODDS = np.linspace(-48.0, 48.0, 385)
"""Grid of log(β / (1 − β)): at the optimum the ratio of the two bulges, which slivers make 1e-20."""
ZOOMS, ALTERNATIONS = 9, 8
FLAT = 1e-14
"""What a plateau of h rises and falls by in doubles."""
NEAR, EQUAL = 1e-8, 1e-12
"""How far above the least h, relative to the scene, a critical direction may seem to be and still count."""


@dataclass(frozen=True)
class Candidate:
    """A direction in doubles, the cell in which it is critical (None: exactly given), and h there."""

    height: float
    n: Any
    cell: Cell | None


def curved_distance(a: Body, b: Body) -> mpf:
    """Signed distance of two bodies without their radii, to 50 digits."""
    search, pieces = Search.of(a, b), cells(a, b)
    exact = [n for n in both_signs(list(fixed_directions(a, b))) if any(n)]
    heights = search.height(units(exact)) if exact else []
    fixed = [Candidate(float(h), n, None) for h, n in zip(heights, exact, strict=True)]
    free = _free_candidates(search, pieces)
    least = min(c.height for c in (*fixed, *free))
    with mp.workdps(DIGITS):
        found = [_height(a, b, c.n) for c in fixed if c.height <= least + EQUAL]
        smooth = Smooth.of(a, b)
        for candidate in _distinct([c for c in free if c.height <= least + NEAR]):
            cell = candidate.cell
            assert cell is not None
            n = smooth.polished(cell.w, cell.arc, candidate.n)
            found += [_height(a, b, n), _height(a, b, in_reals(candidate.n))]
        return -min(found)


def _height(a: Body, b: Body, n: Any) -> mpf:
    """h(n) for an exact or a polished direction of any length, at the working precision."""
    return (a.support(n) + b.support(opposite(n))) / mp.sqrt(real(dot(n, n)))


def _distinct(candidates: list[Candidate], most: int = 12) -> list[Candidate]:
    """The lowest candidates, without those that repeat a direction in the same cell."""
    chosen: list[Candidate] = []
    for c in sorted(candidates, key=lambda c: c.height):
        if not any(c.cell == d.cell and np.abs(c.n - d.n).max() < 1e-7 for d in chosen):
            chosen.append(c)
        if len(chosen) == most:
            break
    return chosen


def _free_candidates(search: Search, pieces: list[Cell]) -> list[Candidate]:
    """Local minima of h in all cells."""
    if not pieces:
        return []
    w, bases = _in_doubles(search, pieces)
    both = search.axes_a.size and search.axes_b.size
    if not both:
        axes = np.concatenate([search.axes_a, search.axes_b], axis=1)
        n = critical_directions(_with_bases(np.broadcast_to(axes, (len(w), *axes.shape)), bases), w)
        heights = search.height(n)
        rows = np.argwhere(heights <= heights.min() + NEAR)
        return [Candidate(float(heights[i, j]), n[i, j], pieces[i]) for i, j in rows]
    return _along_the_odds(search, pieces, w, bases)


def _in_doubles(search: Search, pieces: list[Cell]) -> tuple[Floats, Floats]:
    """Each cell's w, without its part along the arc's normal, and a long axis along that normal."""
    w, bases = [], []
    for cell in pieces:
        if cell.arc is None:
            w.append(in_floats(cell.w, search.unit))
            bases.append([0.0, 0.0, 0.0])
        else:
            e = cell.arc
            square = sum(x * x for x in e)
            w.append(in_floats(across(e, cell.w), search.unit * square))
            bases.append((4.0 * units([e])[0]).tolist())
    return np.array(w), np.array(bases)


def _with_bases(axes: Floats, bases: Floats) -> Floats:
    """Axes with what lies along each arc's normal replaced by something long, which no minimum on the arc feels."""
    square = np.sum(bases * bases, axis=-1)
    along = np.einsum("nik,ni->nk", axes, bases) / np.where(square > 0, square, 1.0)[:, None]
    return np.concatenate([axes - bases[:, :, None] * along[:, None, :], bases[:, :, None]], axis=2)


def _at(search: Search, odds: Floats, w: Floats, bases: Floats) -> tuple[Floats, Floats]:
    """Critical directions and h for odds (N,), w (N, 3)."""
    share = 1.0 / (1.0 + np.exp(-odds)), 1.0 / (1.0 + np.exp(odds))
    parts = [
        axes[None] / np.sqrt(s)[:, None, None] for axes, s in ((search.axes_a, share[1]), (search.axes_b, share[0]))
    ]
    axes = np.concatenate(parts, axis=2)
    size = np.maximum(np.abs(axes).max(axis=(1, 2)), 1.0)  # the long axis stays the longest
    n = critical_directions(_with_bases(axes, bases * size[:, None]), w)
    return n, search.height(n)


def _along_the_odds(search: Search, pieces: list[Cell], w: Floats, bases: Floats) -> list[Candidate]:
    """Scan β for every cell and every branch of critical directions, then zoom into the lowest local minima."""
    cell = np.repeat(np.arange(len(w)), len(ODDS))
    n, heights = _at(search, np.tile(ODDS, len(w)), w[cell], bases[cell])
    heights = heights.reshape(len(w), len(ODDS), -1)
    padded = np.pad(heights, ((0, 0), (1, 1), (0, 0)), constant_values=np.inf)
    local = (heights <= padded[:, :-2] + FLAT) & (heights <= padded[:, 2:] + FLAT)
    local[:, 1:] &= ~local[:, :-1]  # of a plateau, its beginning
    local |= heights == heights.min(axis=1, keepdims=True)
    s, t = search.bulges(n)
    margin = 0.2 * np.minimum(s, t).reshape(heights.shape) + 1e-6
    local &= heights <= heights.min() + margin
    rows = _lowest_of_each(np.where(local, heights, np.inf))
    which, branch = rows[:, 0], rows[:, 2]
    middle, half = ODDS[rows[:, 1]], np.full(len(rows), ODDS[1] - ODDS[0])
    steps = np.linspace(-1.0, 1.0, 9)
    for _ in range(ZOOMS):
        grid = middle[:, None] + half[:, None] * steps
        repeated = np.repeat(which, len(steps))
        n, heights = _at(search, grid.ravel(), w[repeated], bases[repeated])
        pick = np.arange(len(grid))[:, None] * len(steps) + np.arange(len(steps))
        mine = heights[pick, branch[:, None]]
        best = np.argmin(mine, axis=1)
        middle = grid[np.arange(len(grid)), best]
        half = half / 3.0
        chosen, values = n[pick[np.arange(len(grid)), best], branch], mine[np.arange(len(grid)), best]
    scanned = [Candidate(float(h), m, pieces[i]) for h, m, i in zip(values, chosen, which, strict=True)]
    return scanned + _from_flat_limits(search, pieces, w, bases)


def _from_flat_limits(search: Search, pieces: list[Cell], w: Floats, bases: Floats) -> list[Candidate]:
    """Alternate between the best direction for the odds and the best odds for the direction.

    Where both bodies are thin and lie alike, as two disks in one plane do, all odds but a narrow range are equally
    bad. Then the odds of the limit are close: those of the direction in which w lies once a thin axis is left out.
    """
    starts = [w]
    for axes in (search.axes_a, search.axes_b):
        for g in (axes / np.linalg.norm(axes, axis=0)).T:
            along = np.sum(w * g, axis=-1, keepdims=True) * g
            starts += [w - along, along]
        if axes.shape[1] == 2:
            third = np.cross(axes[:, 0], axes[:, 1])
            third /= np.linalg.norm(third)
            starts.append(w - np.sum(w * third, axis=-1, keepdims=True) * third)
    which = np.tile(np.arange(len(w)), len(starts))
    n = np.concatenate(starts)
    found = []
    for _ in range(ALTERNATIONS):
        s, t = search.bulges(n)
        odds = np.clip(np.log((t + 1e-300) / (s + 1e-300)), ODDS[0], ODDS[-1])
        choices, heights = _at(search, odds, w[which], bases[which])
        best = np.argmin(heights, axis=1)
        n, low = choices[np.arange(len(n)), best], heights[np.arange(len(n)), best]
        found += [Candidate(float(h), m, pieces[i]) for h, m, i in zip(low, n, which, strict=True)]
    return found


def _lowest_of_each(heights: Floats, most: int = 3) -> Floats:
    """Rows (cell, odds, branch) of the lowest local minima of every cell and branch; the others are infinite."""
    order = np.argsort(heights, axis=1, kind="stable")[:, :most]
    cell, _, branch = np.indices(order.shape)
    rows = np.stack([cell, order, branch], axis=-1).reshape(-1, 3)
    return rows[np.isfinite(heights[tuple(rows.T)])]
