"""The first contact of flat proxies in translation: a ray from the origin against their Minkowski difference.

A rests and B moves by v: they meet at the times t at which t·v lies in A ⊖ B, which is a polygon widened by the sum of
the radii. So every pair is answered by one cast, and nothing is iterated (de Berg et al., Computational Geometry, 13).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.algorithms.rounds import grown
from refimpl.flat.difference import difference, outline_of, radius_of
from refimpl.flat.outlines import Outline
from refimpl.flat.polygons import separate
from refimpl.flat.rays import cast
from refimpl.linear import Array, Bools, dot, largest, norm, power_of_two, scale
from refimpl.motions import Motion, Translation
from refimpl.proxy import Proxy
from refimpl.results import SweepHit, where
from refimpl.sweeps.overlaps import common_points
from refimpl.sweeps.translations import DOUBT, GRAZE, ROUNDING, decided


def sweep_flat(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> SweepHit:
    """First contacts of flat proxies in translation; everything with one batch axis, of the same length.

    Where doubles do not tell whether, or that in time, two proxies touch, exact numbers do.
    """
    assert isinstance(motion_x, Translation)
    assert isinstance(motion_y, Translation)
    way = motion_y.vector - motion_x.vector
    exponent = power_of_two(np.maximum(np.maximum(x.magnitude, y.magnitude), largest(way)))
    u, v = x.times_power(-exponent), y.times_power(-exponent)
    found, doubtful = _in_doubles(u, v, np.ldexp(way, -exponent[:, None]))
    with np.errstate(over="ignore"):
        point = np.ldexp(found.point, exponent[:, None])
        point += scale(np.where(found.hit, found.t, 0.0), motion_x.vector)
    answer = SweepHit(found.hit, found.t, point, found.normal, found.t_lower)
    return decided(answer, doubtful, x, y, motion_x, motion_y)


def _in_doubles(x: Any, y: Any, way: Array) -> tuple[SweepHit, Bools]:
    """First contacts where `x` rests and `y` moves by `way` (n, 2), and which of them are in doubt."""
    of_x, of_y = outline_of(x), outline_of(y)
    outline, radius = difference(of_x, of_y).outline, radius_of(x) + radius_of(y)
    moving = np.any(way != 0, axis=-1)
    gap = separate(of_x, of_y).distance - radius
    t, normal = cast(gap, np.zeros_like(way), where(moving, way, np.ones_like(way)), outline, radius)
    size = np.maximum(np.maximum(x.magnitude, y.magnitude), largest(way))
    closing = np.where(np.isfinite(t), np.abs(dot(normal, way)), 0.0)
    ends = moving & np.isfinite(t) & (np.abs(np.minimum(t, 2.0) - 1) * closing <= DOUBT * size)
    t = np.where((moving & (t <= 1)) | (t == 0), t, np.inf)
    hit = np.isfinite(t)
    with np.errstate(divide="ignore", invalid="ignore"):
        early = np.where(t > 0, np.maximum(t - DOUBT * size / closing, 0.0), t)
    point = np.full(way.shape, np.nan)
    shift = scale(np.where(hit, t, 0.0), way)
    start, later = np.flatnonzero(t == 0), np.flatnonzero(hit & (t > 0))
    there = Outline(of_y.corners + shift[:, None, :], of_y.normals)
    near = grown(separate(of_x, there), radius_of(x), radius_of(y))
    point[later] = (0.5 * (near.on_a + near.on_b))[later]
    if len(start):
        point[start] = common_points(x[start], y[start])
    doubtful = ends | _starts(t, closing, near.distance, size) | _passes(t, closing, way, outline, radius, size)
    normal = where(hit & (t > 0), normal, np.full(2, np.nan))
    return SweepHit(hit, t, point, normal, np.where(hit, early, np.inf)), doubtful


def _starts(t: Array, closing: Array, gap: Array, size: Array) -> Bools:
    """Whether rounding hides that they touch at the start; `gap` is that at the contact, or else at the start."""
    met = np.where(t == 0, gap > -ROUNDING * size, np.where(t < np.inf, t, 0.0) * closing <= ROUNDING * size)
    return np.asarray(np.where(np.isfinite(t), met, gap <= ROUNDING * size))


def _passes(t: Array, closing: Array, way: Array, outline: Outline, radius: Array, size: Array) -> Bools:
    """Whether B passes by A so narrowly that rounding may have made a contact of it, or none."""
    speed = norm(way)
    across = np.stack([-way[:, 1], way[:, 0]], axis=-1) / np.where(speed > 0, speed, 1.0)[:, None]
    aside, along = (dot(outline.corners, v[:, None, :]) for v in (across, way))
    room = np.minimum(radius - np.min(aside, axis=1), radius + np.max(aside, axis=1))
    ahead = np.max(along, axis=1) + radius * speed >= -DOUBT * size * speed
    behind = np.min(along, axis=1) - radius * speed > speed * (speed + DOUBT * size)
    narrow = (np.abs(room) <= DOUBT * size) & ahead & ~behind
    grazes = np.isfinite(t) & (closing <= GRAZE * speed)
    return np.asarray((speed > 0) & (t != 0) & (narrow | grazes))
