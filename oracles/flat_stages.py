"""Flat proxies that touch in a point known by construction, for the regimes of impacts; see `oracles.impact_stages`.

Points, normals and motions have three numbers, as those of space have, of which the third is 0, and spins only that.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from oracles.bodies import Body
from oracles.draws import Draws
from oracles.flat_bodies import SQUARE, turned
from oracles.world import PLANE
from refimpl.flat import ConvexPolygon, Disc, Rectangle, Segment
from refimpl.flat.area import area_properties
from refimpl.linear import Array, norm, scale
from refimpl.shapes import Proxy

FLAT_TARGETS: dict[tuple[type[Proxy], type[Proxy]], type[Proxy]] = {
    (Disc, Disc): Disc,
    (Disc, Segment): Segment,
    (Disc, Rectangle): Rectangle,
    (Disc, ConvexPolygon): ConvexPolygon,
    (Rectangle, ConvexPolygon): Rectangle,
}
"""Pairs that are staged, and which of both is touched in a feature of its own: on a side, or at a corner or cap.

A corner is put only against sides: where two corners touch, there are many normals.
"""
LEVEL, UPRIGHT = np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
"""What is left of velocities in the plane, and of spins."""

Touched = tuple[Proxy, Array, Array]
"""A proxy, a point of its outline, and a direction in which it points outward there, (n, 3) each."""
Place = tuple[Array, Array]
"""A point of an outline and the direction outward, (n, 2)."""


def _on_disc(draws: Draws, body: Body, feature: Array, spread: Array) -> Touched:
    """Anywhere on the circle."""
    del feature, spread
    given = draws.choice((1.0, 0.0, -1.0), 2) if body.even else draws.uniform(-1.0, 1.0, 2)
    length = norm(given)
    usable = np.where((length < 1e-3)[:, None], np.array([0.0, 1.0]), given)
    outward = scale(1.0 / norm(usable), usable)
    place, radius = body.place[:, :2], body.extents[:, 0]
    return Disc(place, radius), PLANE.fill(place + scale(radius, outward)), PLANE.fill(outward)


def _on_box(draws: Draws, body: Body, feature: Array, spread: Array) -> Place:
    """On a side of the box of the body's extents, as far from its middle as `spread` says; or at a corner."""
    along = np.arange(2) == draws.choice((0.0, 1.0))[:, None]
    sign = draws.choice((1.0, -1.0), 2)
    slope = draws.choice((1.0, 0.5), 2) if body.even else draws.uniform(0.2, 1.0, 2)
    taken = np.where((feature == 0.0)[:, None], along, True)
    own = np.where(taken, sign * slope, 0.0)
    aside = draws.choice((0.5, 0.0, -0.5), 2) if body.even else draws.uniform(-0.9, 0.9, 2)
    at = np.where(taken, sign, aside * spread[:, None]) * body.extents[:, :2]
    return at, scale(1.0 / norm(own), own)


def _on_rectangle(draws: Draws, body: Body, feature: Array, spread: Array) -> Touched:
    """On a side, or at a corner."""
    place, half = body.place[:, :2], body.extents[:, :2]
    at, outward = _on_box(draws, body, feature, spread)
    return Rectangle(place - half, place + half), PLANE.fill(place + at), PLANE.fill(outward)


def _on_polygon(draws: Draws, body: Body, feature: Array, spread: Array) -> Touched:
    """On a side of a turned rectangle, or at a corner."""
    at, outward = _on_box(draws, body, feature, spread)
    place, half = body.place[:, :2], body.extents[:, :2]
    shape = ConvexPolygon.from_vertices(place[:, None] + turned(body, SQUARE * half[:, None]))
    return shape, PLANE.fill(place + turned(body, at)), PLANE.fill(turned(body, outward))


def _on_segment(draws: Draws, body: Body, feature: Array, spread: Array) -> Touched:
    """On a side, or on one of the ends, where what points outward leans along the segment; with a radius or without."""
    even, half = body.even, body.extents[:, 0]
    radius = np.where(draws.choice((0.0, 1.0)) == 0, 0.0, body.extents[:, 1])
    lean = draws.choice((1.0, 0.5)) if even else draws.uniform(0.2, 2.0)
    lean = np.where(feature == 0.0, 0.0, draws.choice((1.0, -1.0)) * lean)
    own = np.stack([lean, draws.choice((1.0, -1.0))], axis=-1)
    own = scale(1.0 / norm(own), own)
    aside = spread * (draws.choice((0.5, 0.0, -0.5)) if even else draws.uniform(-0.9, 0.9))
    share = np.where(feature == 0.0, aside, np.sign(lean))
    at = np.stack([share * half, np.zeros_like(half)], axis=-1) + scale(radius, own)
    ends = np.stack([half, np.zeros_like(half)], axis=-1)
    place, reach = body.place[:, :2], turned(body, ends)
    shape = Segment(place - reach, place + reach, radius)
    return shape, PLANE.fill(place + turned(body, at)), PLANE.fill(turned(body, own))


ON: dict[type[Proxy], Callable[[Draws, Body, Array, Array], Touched]] = {
    Disc: _on_disc,
    Segment: _on_segment,
    Rectangle: _on_rectangle,
    ConvexPolygon: _on_polygon,
}
"""Puts a target somewhere: which feature is touched, and how far from its middle."""


def _disc_at(body: Body, point: Array, outward: Array) -> Proxy:
    radius = body.extents[:, 0]
    return Disc((point + scale(radius, outward))[:, :2], radius)


def _corner_at(body: Body, point: Array, outward: Array) -> Proxy:
    """A rhombus that has a corner at the point, as blunt as the body's extents are to each other."""
    out, half = outward[:, :2], body.extents[:, :2]
    across = np.stack([-out[:, 1], out[:, 0]], axis=-1)
    middle, far = scale(half[:, 0], out), scale(2.0 * half[:, 0], out)
    side = scale(half[:, 1], across)
    corners = np.zeros_like(out), middle - side, far, middle + side
    return ConvexPolygon.from_vertices(point[:, None, :2] + np.stack(corners, axis=1))


AGAINST: dict[type[Proxy], Callable[[Body, Array, Array], Proxy]] = {Disc: _disc_at, ConvexPolygon: _corner_at}
"""Puts another proxy against a target at a point."""


def inertia_of(shape: Proxy, mass: Array) -> tuple[Array, Array]:
    """Place of the middle, and moment of inertia about the way out of the plane, in each place of a diagonal."""
    plate = area_properties(shape)
    return PLANE.fill(plate.centroid), (mass * plate.gyration)[:, None, None] * np.eye(3)
