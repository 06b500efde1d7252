"""Flat proxies that touch in a point known by construction, for the regimes of impacts; see `oracles.impact_stages`.

Points, normals and motions have three numbers, as those of space have, of which the third is 0, and spins only that.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from oracles.bodies import Body
from oracles.draws import Draws
from oracles.flat_bodies import turned
from oracles.world import PLANE
from refimpl.flat import ConvexPolygon, Disc
from refimpl.linear import Array, norm, scale
from refimpl.shapes import Proxy

FLAT_TARGETS: dict[tuple[type[Proxy], type[Proxy]], type[Proxy]] = {
    (Disc, Disc): Disc,
    (Disc, ConvexPolygon): ConvexPolygon,
}
"""Pairs that are staged, and which of both is touched in a feature of its own: a polygon on a side or at a corner."""
LEVEL, UPRIGHT = np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
"""What is left of velocities in the plane, and of spins."""
SQUARE = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])

Touched = tuple[Proxy, Array, Array]
"""A proxy, a point of its outline, and a direction in which it points outward there, (n, 3) each."""


def on_disc(draws: Draws, body: Body, feature: Array, spread: Array) -> Touched:
    """Anywhere on the circle."""
    del feature, spread
    given = draws.choice((1.0, 0.0, -1.0), 2) if body.even else draws.uniform(-1.0, 1.0, 2)
    length = norm(given)
    usable = np.where((length < 1e-3)[:, None], np.array([0.0, 1.0]), given)
    outward = scale(1.0 / norm(usable), usable)
    place, radius = body.place[:, :2], body.extents[:, 0]
    return Disc(place, radius), PLANE.fill(place + scale(radius, outward)), PLANE.fill(outward)


def on_polygon(draws: Draws, body: Body, feature: Array, spread: Array) -> Touched:
    """On a side of a turned rectangle, as far from its middle as `spread` says; or at a corner."""
    place, extents = body.place[:, :2], body.extents[:, :2]
    corners = place[:, None] + turned(body, SQUARE * extents[:, None])
    along = np.arange(2) == draws.choice((0.0, 1.0))[:, None]
    sign = draws.choice((1.0, -1.0), 2)
    slope = draws.choice((1.0, 0.5), 2) if body.even else draws.uniform(0.2, 1.0, 2)
    taken = np.where((feature == 0.0)[:, None], along, True)
    own = np.where(taken, sign * slope, 0.0)
    aside = draws.choice((0.5, 0.0, -0.5), 2) if body.even else draws.uniform(-0.9, 0.9, 2)
    at = np.where(taken, sign, aside * spread[:, None]) * extents
    outward = turned(body, scale(1.0 / norm(own), own))
    return ConvexPolygon.from_vertices(corners), PLANE.fill(place + turned(body, at)), PLANE.fill(outward)


ON: dict[type[Proxy], Callable[[Draws, Body, Array, Array], Touched]] = {Disc: on_disc, ConvexPolygon: on_polygon}


def inertia_of(shape: Proxy, mass: Array) -> tuple[Array, Array]:
    """Place of the middle, and moment of inertia about the way out of the plane, in each place of a diagonal."""
    if isinstance(shape, Disc):
        square = shape.radius**2 / 2.0
    else:
        assert isinstance(shape, ConvexPolygon)
        u, v = shape.vertices[:, 0] - shape.vertices[:, 1], shape.vertices[:, 1] - shape.vertices[:, 2]
        square = (norm(u) ** 2 + norm(v) ** 2) / 12.0  # of a rectangle of these sides
    return PLANE.fill(shape.reference_point), (mass * square)[:, None, None] * np.eye(3)
