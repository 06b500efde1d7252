"""The first time at which a ray meets a convex polygon or a segment, widened by a disc."""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.rays import Entry, _outward, _round_span
from refimpl.flat.difference import outline_of, point_outline, radius_of
from refimpl.flat.outlines import Outline
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.polygons import SLACK, separate
from refimpl.flat.shapes import FlatRay, Segment
from refimpl.linear import Array, dot, largest, scale, unit_or


def cast(gap: Array, origin: Array, direction: Array, outline: Outline, radius: Array) -> Entry:
    """First time of rays (n, 2) in widened outlines with one batch axis, and the outward unit normal there.

    A time is that of a side, moved outwards by the radius, or of a disc around a corner: whichever comes first. It is 0
    where the `gap` at the start is none.
    """
    start = gap <= 0
    sharp, sharp_normal = _through(origin, direction, outline)
    if not np.any(radius > 0):
        return np.where(start, 0.0, sharp), sharp_normal
    blunt, blunt_normal = _around(origin, direction, outline, radius)
    t = np.where(start, 0.0, np.where(radius > 0, blunt, sharp))
    return t, np.where((radius > 0)[:, None], blunt_normal, sharp_normal)


def _through(origin: Array, direction: Array, outline: Outline) -> Entry:
    """Against the polygon itself: a line that has corners on both sides enters by the last side that faces it.

    Cyrus and Beck 1978; Ericson, Real-Time Collision Detection, 5.3.8. Sides nearly along the ray are met between the
    first and the last corner. A segment that the ray meets end on has no side that faces it.
    """
    offset = outline.corners - origin[:, None, :]
    way = direction[:, None, :]
    aside = way[..., 0] * offset[..., 1] - way[..., 1] * offset[..., 0]
    times = dot(offset, way) / dot(way, way)
    first, last = np.min(times, axis=1), np.max(times, axis=1)
    speed = dot(outline.normals, way)
    faces = speed < 0
    with np.errstate(over="ignore"):
        enters = np.where(faces, dot(outline.normals, offset) / np.where(faces, speed, 1.0), -np.inf)
    side = np.argmax(enters, axis=1)
    t = np.clip(np.max(enters, axis=1), first, last)
    hit = (np.min(aside, axis=1) <= 0) & (np.max(aside, axis=1) >= 0) & (t >= 0)
    normal = outline.normals[np.arange(len(side)), side]
    against = unit_or(-direction, direction)[0]
    return np.where(hit, t, np.inf), np.where(np.any(faces, axis=1)[:, None], normal, against)


def _around(origin: Array, direction: Array, outline: Outline, radius: Array) -> Entry:
    """Against the polygon widened by a radius > 0: its sides moved outwards, and the discs around its corners."""
    corners, normals = outline.corners, outline.normals
    offset, way, reach = corners - origin[:, None, :], direction[:, None, :], radius[:, None]
    discs, _, outward = _round_span(
        -offset, np.broadcast_to(way, offset.shape), np.broadcast_to(reach, offset.shape[:2])
    )
    step = np.roll(corners, -1, axis=1) - corners
    speed, square = dot(normals, way), dot(step, step)
    faces = (speed < 0) & (square > 0)
    with np.errstate(over="ignore", invalid="ignore"):
        sides = (dot(normals, offset) + reach) / np.where(faces, speed, 1.0)
        place = dot(scale(sides, np.broadcast_to(way, offset.shape)) - offset, step) / np.where(square > 0, square, 1.0)
    sides = np.where(faces & (place >= 0) & (place <= 1), sides, np.inf)
    times = np.concatenate([sides, discs], axis=1)
    times = np.where(times >= 0, times, np.inf)
    first = np.argmin(times, axis=1)
    rows = np.arange(len(first))
    normal = np.concatenate([normals, outward], axis=1)[rows, first]
    return times[rows, first], unit_or(normal, unit_or(-direction, direction)[0])[0]


def ray_segment(ray: FlatRay, s: Segment) -> Entry:
    """First time of a ray in a segment: its sides, moved outwards by the radius, and discs at its ends. Closed form."""
    return _decided(ray, s, outline_of(s), radius_of(s))


def ray_convexpolygon(ray: FlatRay, b: ConvexPolygon) -> Entry:
    """First time of a ray in a convex polygon: the last side that faces it. Finite."""
    return _decided(ray, b, b.outline, np.zeros(len(b)))


def _decided(ray: FlatRay, shape: Segment | ConvexPolygon, outline: Outline, radius: Array) -> Entry:
    """First times and normals; rational numbers tell about a ray that starts at a side or passes a corner."""
    from refimpl.proof.rays import Hit, Miss  # noqa: PLC0415  only what is grazed needs it
    from refimpl.proof.times import direction_of, first_hit  # noqa: PLC0415

    gap = separate(point_outline(ray.origin), outline).distance - radius
    t, normal = cast(gap, ray.origin, ray.direction, outline, radius)
    t, normal = np.array(t), np.array(_outward(normal, ray))
    slack = SLACK * np.maximum(largest(ray.origin), np.max(largest(outline.corners), axis=1))
    doubtful = (np.abs(gap) <= slack) | ((gap > 0) & (np.abs(_room(ray, outline)) <= slack))
    for i in np.flatnonzero(doubtful & (radius == 0)):
        found = first_hit(ray[i], shape[i])[0]
        t[i] = np.inf if isinstance(found, Miss) else float(found.high)
        if isinstance(found, Hit) and found.high > 0:
            inwards = np.array([float(c) for c in direction_of(found.normal(found.high))[:2]])
            normal[i] = unit_or(-inwards, normal[i])[0]
    return t, normal


def _room(ray: FlatRay, outline: Outline) -> Array:
    """How far the line of a ray comes in from the outermost corners; negative where all are on one side of it."""
    offset, way = outline.corners - ray.origin[:, None, :], unit_or(ray.direction, ray.direction)[0][:, None, :]
    aside = way[..., 0] * offset[..., 1] - way[..., 1] * offset[..., 0]
    return np.asarray(np.minimum(-np.min(aside, axis=1), np.max(aside, axis=1)))
