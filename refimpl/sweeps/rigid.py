"""First contacts of bodies that move rigidly, by conservative advancement with proven bounds on both sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from refimpl.linear import Array, Bools, cross
from refimpl.motions import Motion
from refimpl.proxy import Proxy
from refimpl.queries import intersect
from refimpl.results import SweepHit
from refimpl.shapes import Composite, HalfSpace, Polyhedron
from refimpl.sweeps.overlaps import common_points
from refimpl.sweeps.rigid_bodies import earliest, turning
from refimpl.sweeps.rigid_march import Times, first_contacts
from refimpl.sweeps.rigid_pairs import Pairs, paired
from refimpl.sweeps.unions import over_pieces

UNIONS = (Composite, Polyhedron)
AT_ONCE = 2.0**-40
"""Two half-spaces that turn out of facing each other meet, far away, at every time after 0."""


def sweep_convex(a: Proxy, b: Proxy, motion_a: Motion, motion_b: Motion) -> tuple[SweepHit, Bools]:
    """First contacts of two batches of convex proxies, with one batch axis each.

    Parameters
    ----------
    a, b : Proxy with one batch axis, of the same length
        Convex solids, or points against solids.
    motion_a, motion_b : Translation or RigidMotion, with the same batch axis

    Returns
    -------
    SweepHit
        The first contact lies between `t_lower` and `t`. Mirtich and Canny, Impulse-based Simulation of Rigid Bodies,
        1995, advance conservatively by a speed; here a step may go as far as the curvature of the gap allows.
    (n,) bool
        Whether that is certain: in a graze that doubles do not decide, `t` is when it has passed.
    """
    if isinstance(b, HalfSpace) and not isinstance(a, HalfSpace):
        found, decided = sweep_convex(b, a, motion_b, motion_a)
        return SweepHit(found.hit, found.t, found.point, -found.normal, found.t_lower), decided
    n = len(a)
    hit, decided, t, t_lower = np.ones(n, dtype=bool), np.ones(n, dtype=bool), np.zeros(n), np.zeros(n)
    point, normal = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
    met = intersect(a, b)
    there = np.flatnonzero(met)
    if len(there):
        point[there] = common_points(a[there], b[there])
    apart = np.flatnonzero(~met)
    if len(apart):
        pairs = paired(turning(a[apart], motion_a[apart]), turning(b[apart], motion_b[apart]))
        times = _halfspaces(pairs) if isinstance(b, HalfSpace) else first_contacts(pairs, np.ones(len(apart)))
        hit[apart], t[apart], t_lower[apart] = np.isfinite(times.lower), times.upper, times.lower
        decided[apart] = times.decided
        point[apart], normal[apart] = _contact(pairs, times)
    return SweepHit(hit, t, point, normal, t_lower), decided


def _halfspaces(pairs: Pairs) -> Times:
    """First contacts of half-spaces that are apart, and so face each other: as soon as they no longer do, they meet."""
    turns = [cross(z.motion.angular, z.shape.normal) for z in (pairs.a, pairs.b)]  # type: ignore[attr-defined]
    still = np.all(turns[0] == 0, axis=-1) & np.all(turns[1] == 0, axis=-1)
    facing = np.flatnonzero(still | np.all(pairs.a.motion.angular == pairs.b.motion.angular, axis=-1))
    n = len(still)
    times = Times(np.zeros(n), np.full(n, AT_ONCE), np.ones(n, dtype=bool), np.zeros(n, dtype=np.int64))
    for column, found in zip(times, first_contacts(pairs.at(facing), np.ones(len(facing))), strict=True):
        column[facing] = found
    return times


def _contact(pairs: Pairs, times: Times) -> tuple[Array, Array]:
    """Points at the times of contact, and the normals just before."""
    hit = np.isfinite(times.upper)
    point, normal = np.full((len(hit), 3), np.nan), np.full((len(hit), 3), np.nan)
    rows = np.flatnonzero(hit)
    if len(rows):
        there = pairs.at(rows)
        point[rows] = there.state(times.upper[rows]).point
        normal[rows] = there.state(times.lower[rows]).normal
    return point, normal


def sweep_rigid(a: Proxy, b: Proxy, motion_a: Motion, motion_b: Motion) -> SweepHit:
    """First contacts of two batches of proxies with one batch axis, of which one at least may turn; see `sweep`."""
    if not (isinstance(a, UNIONS) or isinstance(b, UNIONS)):
        return sweep_convex(a, b, motion_a, motion_b)[0]
    rows = [slice(i, i + 1) for i in range(len(a))]
    return joined([_union(a[row], b[row], motion_a[row], motion_b[row]) for row in rows])


def _union(a: Proxy, b: Proxy, motion_a: Motion, motion_b: Motion) -> SweepHit:
    """First contact of one pair of unions: the first that is certain, but none before any graze that is not."""
    grazes: list[SweepHit] = []

    def certain(*pieces: Any) -> SweepHit:
        found, decided = sweep_convex(*pieces)
        grazes.extend(found[i : i + 1] for i in np.flatnonzero(~decided))
        hit, t = found.hit & decided, np.where(decided, found.t, np.inf)
        return SweepHit(hit, t, found.point, found.normal, found.t_lower)

    found = over_pieces(a, b, motion_a, motion_b, certain, earliest)
    if found.hit[0] or not grazes:
        return found
    first = min(grazes, key=lambda graze: float(graze.t_lower[0]))
    return replace(first, t=np.max([graze.t for graze in grazes], axis=0))


def joined(hits: Sequence[SweepHit]) -> SweepHit:
    """Rows of several answers as one."""
    names = ("hit", "t", "point", "normal", "t_lower")
    if not hits:
        return SweepHit(np.zeros(0, dtype=bool), np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    return SweepHit(*(np.concatenate([getattr(hit, name) for hit in hits]) for name in names))
