"""The first contact of unions: the first over all pairs of their convex pieces, whatever the motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import Any

import numpy as np

from refimpl.atoms import groups, leaves
from refimpl.linear import Array
from refimpl.motions import Motion
from refimpl.results import SweepHit
from refimpl.shapes import Composite, HalfSpace, Polyhedron, Proxy
from refimpl.signs import Indices

UNIONS = (Composite, Polyhedron)
FIRST = 64
"""So many pairs are swept first, of those whose boxes meet first; then as many again as before, and so on."""
PAIRS = 1 << 20
"""So many pairs are looked at together."""

Convex = Callable[[Proxy, Proxy, Motion, Motion], SweepHit]
Earliest = Callable[[Proxy, Proxy, Motion, Motion], Array]


def over_pieces(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion, convex: Convex, earliest: Earliest) -> SweepHit:
    """First contacts of proxies of which one at least is a union.

    Parameters
    ----------
    x, y : Proxy with one batch axis, of the same length
        Solids or points.
    motion_x, motion_y : Motion with the same batch axis
    convex : function
        Sweeps a batch of convex proxies.
    earliest : function
        For each pair of a batch of bounded convex proxies, a time before which they do not meet; inf for never.
    """
    found = [_single(x[i], y[i], motion_x[i], motion_y[i], convex, earliest) for i in range(len(x))]
    columns = (np.array([getattr(hit, field.name) for hit in [*found, NEVER]]) for field in fields(SweepHit))
    return SweepHit(*(column[:-1] for column in columns))


def _single(a: Proxy, b: Proxy, motion_a: Motion, motion_b: Motion, convex: Convex, earliest: Earliest) -> SweepHit:
    """First contact of one pair."""
    best, least = NEVER, np.inf
    for one in groups(leaves(a)):
        for other in groups(leaves(b)):
            for i, j in _blocks(len(one), len(other)):

                def rows(
                    chosen: Any, i: Indices = i, j: Indices = j, u: Proxy = one.proxies, v: Proxy = other.proxies
                ) -> tuple[Proxy, Proxy, Motion, Motion]:
                    count = (len(i[chosen]),)
                    return u[i[chosen]], v[j[chosen]], motion_a.broadcast_to(count), motion_b.broadcast_to(count)

                unbounded = isinstance(one.proxies, HalfSpace) or isinstance(other.proxies, HalfSpace)
                early = np.zeros(len(i)) if unbounded else earliest(*rows(slice(None)))
                order = np.argsort(early, kind="stable")
                start, many = 0, FIRST
                while start < len(order) and early[order[start]] < best.t:
                    hit = convex(*rows(order[start : start + many]))
                    first = int(np.argmin(hit.t))
                    least = min(least, float(np.min(hit.t_lower)))
                    best = hit[first] if hit.t[first] < best.t else best
                    start, many = start + many, 2 * many
    return SweepHit(best.hit, best.t, best.point, best.normal, np.minimum(best.t, least))


NEVER = SweepHit(np.False_, np.float64(np.inf), np.full(3, np.nan), np.full(3, np.nan), np.float64(np.inf))  # type: ignore[arg-type]


def _blocks(m: int, n: int) -> Iterator[tuple[Indices, Indices]]:
    """All pairs, some rows of the first at a time."""
    step = max(PAIRS // n, 1)
    for start in range(0, m, step):
        some = np.arange(start, min(start + step, m))
        yield np.repeat(some, n), np.tile(np.arange(n), len(some))
