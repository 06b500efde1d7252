"""Two proxies that touch in a point known by construction, for the regimes of impacts.

One of the two, the *target*, is touched in a feature of its own: a face or side, an edge, a corner or cap. The other, a
ball, a half-space or a polygon's corner, is put against it there, so that the point and the normal need no search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oracles.bodies import Body
from oracles.draws import Draws
from oracles.flat_stages import AGAINST, FLAT_TARGETS, ON
from oracles.world import is_flat
from refimpl.flat import Disc
from refimpl.linear import Array, apply, cross, dot, norm, rotation_matrix, scale
from refimpl.shapes import Box, Capsule, HalfSpace, Proxy, Sphere

FACE, EDGE, CORNER = 0.0, 1.0, 2.0
"""Features of a box; of a capsule its side, and twice its caps; a ball has only one kind of point."""

TARGETS: dict[tuple[type[Proxy], type[Proxy]], type[Proxy]] = {
    (Sphere, Sphere): Sphere,
    (Sphere, HalfSpace): Sphere,
    (Sphere, Box): Box,
    (Sphere, Capsule): Capsule,
    (Capsule, HalfSpace): Capsule,
    (HalfSpace, Box): Box,
}
"""Pairs that are staged, and which of both is touched in a feature of its own; the first, of two balls."""
STAGED = TARGETS | FLAT_TARGETS
"""The same with those of the plane."""


@dataclass(frozen=True)
class Staged:
    """Pairs that touch, (n, ...).

    Attributes
    ----------
    point, normal : (n, 3)
        Where they touch (of an edge or face that lands flat, the middle), and from A to B, about of length 1.
    """

    a: Proxy
    b: Proxy
    point: Array
    normal: Array


@dataclass(frozen=True)
class _Target:
    """A shape with a point of its surface, and a direction in which it points outward there."""

    shape: Proxy
    point: Array
    outward: Array


def stage(draws: Draws, pair: tuple[type[Proxy], type[Proxy]], bodies: tuple[Body, Body], where: Array) -> Staged:
    """Put one body against the other: where `where` is 0 at the middle of the feature, else up to its ends.

    Parameters
    ----------
    bodies
        What A and B are made of; the place of one of them is not kept.
    where : (n, 2)
        Number of the feature, and how far from its middle the contact may be, from 0 to 1.
    """
    kind = STAGED[pair]
    second = kind is pair[1] and pair[0] is not pair[1]
    own, other = (bodies[1], bodies[0]) if second else bodies
    with_plane = HalfSpace in pair
    feature, spread = where[:, 0], where[:, 1]
    if with_plane:
        spread = np.where(feature == CORNER, spread, 0.0)  # of what lands flat, the middle counts
    if is_flat(kind):
        its = pair[0] if second else pair[1]
        target = _Target(*ON[kind](draws, own, np.where(its is Disc, feature, FACE), spread))
        placed = AGAINST[its](other, target.point, target.outward)
    else:
        target = MAKE[kind](draws, own, feature, spread)
        placed = _plane_at(target) if with_plane else _ball_at(target, other.extents[:, 0])
    a, b = (placed, target.shape) if second else (target.shape, placed)
    normal = -target.outward if second else target.outward
    return Staged(a, b, target.point, normal)


def _ball_at(target: _Target, radius: Array) -> Proxy:
    return Sphere(target.point + scale(radius, target.outward), radius)


def _plane_at(target: _Target) -> HalfSpace:
    return HalfSpace(-target.outward, dot(target.outward, target.point))


def _unit(draws: Draws, *, even: bool) -> Array:
    """Directions of length about 1."""
    given = draws.choice((1.0, 0.0, -1.0), 3) if even else draws.uniform(-1.0, 1.0, 3)
    length = norm(given)
    usable = np.where((length < 1e-3)[:, None], np.array([0.0, 0.0, 1.0]), given)
    return scale(1 / norm(usable), usable)


def _on_ball(draws: Draws, body: Body, feature: Array, spread: Array) -> _Target:
    del feature, spread
    radius, outward = body.extents[:, 0], _unit(draws, even=body.even)
    return _Target(Sphere(body.place, radius), body.place + scale(radius, outward), outward)


def _on_box(draws: Draws, body: Body, feature: Array, spread: Array) -> _Target:
    """The outward direction has one, two or three coordinates that are not 0: a face, an edge, a corner."""
    axis = np.arange(3) == draws.choice((2.0, 0.0, 1.0))[:, None]
    taken = np.where(feature[:, None] == FACE, axis, np.where(feature[:, None] == EDGE, ~axis, True))
    sign = draws.choice((1.0, -1.0), 3)
    slope = draws.choice((1.0, 0.5), 3) if body.even else draws.uniform(0.2, 1.0, 3)
    own = np.where(taken, sign * slope, 0.0)
    aside = draws.choice((0.5, 0.0, -0.5), 3) if body.even else draws.uniform(-0.9, 0.9, 3)
    at = np.where(taken, sign, aside * spread[:, None]) * body.extents
    matrix = rotation_matrix(body.rotation)
    outward = apply(matrix, scale(1 / norm(own), own))
    box = Box(body.place, body.extents, body.rotation)
    return _Target(box, body.place + apply(matrix, at), outward)


def _on_capsule(draws: Draws, body: Body, feature: Array, spread: Array) -> _Target:
    """On the side the outward direction is square to the axis; on a cap it leans along it."""
    matrix = rotation_matrix(body.rotation)
    axis = apply(matrix, np.broadcast_to([0.0, 0.0, 1.0], body.place.shape))
    half, radius = body.extents[:, 2], body.extents[:, 0]
    ends = body.place - scale(half, axis), body.place + scale(half, axis)
    random = _unit(draws, even=False)
    square = random - scale(dot(random, axis), axis)
    square = np.where((norm(square) < 1e-3)[:, None], cross(axis, axis[:, [1, 2, 0]]), square)
    square = scale(1 / norm(square), square)
    lean = np.where(feature == FACE, 0.0, draws.choice((1.0, -1.0)) * draws.uniform(0.2, 2.0))
    outward = square + scale(lean, axis)
    outward = scale(1 / norm(outward), outward)
    share = np.where(feature == FACE, spread * draws.uniform(-0.9, 0.9), np.sign(lean))
    point = body.place + scale(share * half, axis) + scale(radius, outward)
    return _Target(Capsule(*ends, radius), point, outward)


MAKE: dict[type[Proxy], Callable[[Draws, Body, Array, Array], _Target]] = {
    Sphere: _on_ball,
    Box: _on_box,
    Capsule: _on_capsule,
}
