"""Corners of small polytopes in general position: every three rows are tried, for a whole batch at once.

The double description method (`refimpl.cones`) knows no exceptions, but takes its steps one by one. Where doubles
decide every sign with certainty, trying all triples finds the same faces sooner; where one sign is in doubt, it says so
and decides nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from refimpl.linear import Array, cross, dot

MOST = 28
"""Rows up to which trying all triples is quicker."""

DOUBT = 2e-13
"""More than rounding does to a 4 × 4 determinant of numbers up to 1: some 400 units in the last place of 1."""

CHUNK = 1 << 17


@dataclass(frozen=True)
class Simple:
    """Extreme rays of one cone, each of which lies on exactly three rows.

    Attributes
    ----------
    triples : (m, 3) int
        The rows of each ray, ascending.
    signs : (m,) int
        1 where the ray is the triple's vector product in four dimensions, −1 where it is the opposite.
    pairs : (e, 2) int
        Rows that share an edge, ascending.
    before, after : (e,) int
        The two rays of each edge; in the frame (row, other row, third row of a ray) the determinant times the sign is
        positive for `before`.
    """

    triples: Any
    signs: Any
    pairs: Any
    before: Any
    after: Any


@lru_cache(maxsize=32)
def _triples(count: int) -> tuple[Any, Any]:
    """All pairs of rows, and all triples as rows i, j, k with the places of jk, ik and ij among the pairs."""
    i, j = np.triu_indices(count, 1)
    place = np.zeros((count, count), dtype=np.int64)
    place[i, j] = np.arange(len(i))
    a, b, c = (np.array(x) for x in zip(*_ascending(count), strict=True))
    return np.stack([i, j]), np.stack([a, b, c, place[b, c], place[a, c], place[a, b]])


def _ascending(count: int) -> list[tuple[int, int, int]]:
    return [(a, b, c) for a in range(count) for b in range(a + 1, count) for c in range(b + 1, count)]


def products(rows: Array) -> Array:
    """Vector products in four dimensions of all triples of rows (..., f, 4), in ascending order: (..., t, 4)."""
    (i, j), (a, b, c, bc, ac, ab) = _triples(rows.shape[-2])
    n, w = rows[..., :3], rows[..., 3:]
    crosses = cross(n[..., i, :], n[..., j, :])
    z = w[..., b, :] * crosses[..., ac, :] - w[..., a, :] * crosses[..., bc, :] - w[..., c, :] * crosses[..., ab, :]
    return np.concatenate([z, dot(n[..., a, :], crosses[..., bc, :])[..., None]], axis=-1)


def simple_cones(rows: Array, *, upwards: bool) -> list[Simple | None]:
    """Extreme rays of the cones {z : a·z ≤ 0 for every row a}, for those of a batch where doubles are certain.

    Parameters
    ----------
    rows : (b, f, 4)
        Numbers up to 1.
    upwards
        Whether the rays must have a positive last number, as the corners of planes have: z_3 ≥ 0 is one more row.

    Returns
    -------
    list of b
        None where a sign is in doubt or the rays are no closed surface.
    """
    count = rows.shape[-2]
    if not 4 <= count <= MOST:
        return [None] * len(rows)
    found: list[Simple | None] = []
    step = max(1, CHUNK // (_triples(count)[1].shape[1] * count))
    for start in range(0, len(rows), step):
        part = rows[start : start + step]
        signs, certain = _signs(part, products(part), upwards)
        found += [_simple(sign, count) if sure else None for sign, sure in zip(signs, certain, strict=True)]
    return found


def _signs(rows: Array, z: Array, upwards: bool) -> tuple[Any, Any]:
    """1 or −1 where a triple is an extreme ray or its opposite, else 0; and for which cones that is certain.

    Most triples are refused by the first few rows, and leave.
    """
    batch, triples = z.shape[:2]
    cone = np.repeat(np.arange(batch), triples)
    left = np.arange(batch * triples)
    ray = z.reshape(-1, 4)
    may_be_up, may_be_down = np.ones(len(left), dtype=bool), np.ones(len(left), dtype=bool)
    if upwards:
        may_be_up, may_be_down = ray[:, 3] >= -DOUBT, ray[:, 3] <= DOUBT
    close = np.zeros(len(left), dtype=np.int64)
    for i in range(rows.shape[1]):
        a = rows[cone, i]
        value = dot(ray, a) + ray[:, 3] * a[:, 3]
        may_be_up &= value <= DOUBT
        may_be_down &= value >= -DOUBT
        close += np.abs(value) <= DOUBT
        if i % 3 == 2:
            stay = np.flatnonzero(may_be_up | may_be_down)
            left, cone, ray, close = left[stay], cone[stay], ray[stay], close[stay]
            may_be_up, may_be_down = may_be_up[stay], may_be_down[stay]
    stay = may_be_up | may_be_down
    sure = (may_be_up ^ may_be_down) & (close == 3)
    if upwards:
        sure &= np.abs(ray[:, 3]) > DOUBT
    certain = np.ones(batch, dtype=bool)
    certain[cone[stay & ~sure]] = False
    signs = np.zeros(batch * triples, dtype=np.int64)
    signs[left[stay & sure]] = np.where(may_be_up, 1, -1)[stay & sure]
    return signs.reshape(batch, triples), certain


def _simple(signs: Any, count: int) -> Simple | None:
    """Join rays along edges: each pair of rows that meets at a ray must meet at exactly two, in opposite senses."""
    rays = np.flatnonzero(signs)
    a, b, c = _triples(count)[1][:3, rays]
    sign = signs[rays]
    keys = np.concatenate([a * count + b, b * count + c, a * count + c])
    senses = np.concatenate([sign, sign, -sign])
    order = np.argsort(keys, kind="stable")
    keys, senses, who = keys[order], senses[order], order % len(rays) if len(rays) else order
    closed = len(rays) >= 4 and np.array_equal(keys[::2], keys[1::2]) and np.all(keys[2::2] != keys[1:-1:2])
    if not closed or not np.all(senses[::2] + senses[1::2] == 0):
        return None
    first = senses[::2] > 0
    before, after = np.where(first, who[::2], who[1::2]), np.where(first, who[1::2], who[::2])
    pairs = np.stack([keys[::2] // count, keys[::2] % count], axis=1)
    return Simple(np.stack([a, b, c], axis=1), sign, pairs, before, after)
