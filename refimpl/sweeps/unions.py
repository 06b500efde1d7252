"""The first contact of unions: the first over all pairs of their convex pieces, whatever the motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields

import numpy as np

from refimpl.atoms import Group, groups, leaves
from refimpl.linear import Array
from refimpl.motions import Motion
from refimpl.results import SweepHit
from refimpl.shapes import Composite, Polyhedron, Proxy
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
            for early, i, j in in_turn(one, other, motion_a, motion_b, earliest):
                if early >= best.t:
                    continue
                count = (len(i),)
                moved = motion_a.broadcast_to(count), motion_b.broadcast_to(count)
                hit = convex(one.proxies[i], other.proxies[j], *moved)
                first = int(np.argmin(hit.t))
                least = min(least, float(np.min(hit.t_lower)))
                best = hit[first] if hit.t[first] < best.t else best
    return SweepHit(best.hit, best.t, best.point, best.normal, np.minimum(best.t, least))


NEVER = SweepHit(np.False_, np.float64(np.inf), np.full(3, np.nan), np.full(3, np.nan), np.float64(np.inf))  # type: ignore[arg-type]


def in_turn(
    one: Group, other: Group, motion_a: Motion, motion_b: Motion, earliest: Earliest
) -> Iterator[tuple[float, Indices, Indices]]:
    """Pairs of atoms that may meet, some at a time, with a time before which none of them nor of the next ones do.

    Of many pairs, those of some atoms of A come after those of others, and times begin anew.
    """
    step = max(PAIRS // len(other), 1)
    for begin in range(0, len(one), step):
        some = np.arange(begin, min(begin + step, len(one)))
        i, j = np.repeat(some, len(other)), np.tile(np.arange(len(other)), len(some))
        early, count = np.zeros(len(i)), (len(i),)
        if one.tree is not None and other.tree is not None:
            moved = motion_a.broadcast_to(count), motion_b.broadcast_to(count)
            early = earliest(one.proxies[i], other.proxies[j], *moved)
        order = np.argsort(early, kind="stable")
        order = order[np.isfinite(early[order])]
        start, many = 0, FIRST
        while start < len(order):
            chosen = order[start : start + many]
            yield float(early[chosen[0]]), i[chosen], j[chosen]
            start, many = start + many, 2 * many
