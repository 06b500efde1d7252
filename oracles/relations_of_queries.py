"""Relations between queries: what an engine says in one place must fit what it says in another."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oracles.claimed_shapes import past
from oracles.engine import Convention, Status
from oracles.images import has_slabs, moved
from oracles.promises import Bounds
from oracles.reference import UNIONS
from oracles.related import OTHER, Asked, Carried, Image, image_of
from oracles.relation import ELSEWHERE, exactly, relation, unchanged
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, Cell
from refimpl.linear import Array, largest, norm, scale
from refimpl.shapes import HalfSpace, Point, Proxy, Ray

ROUND = 2.0**-50
"""Rounding of a point of a ray, relative to the numbers it is the sum of."""


@relation("asking another query", ELSEWHERE, "two queries contradict each other")
def queries(asked: Asked) -> Iterator[Image]:
    """Distance, contacts and overlap are different code in most engines, and speak of the same two sets."""
    others = {DISTANCE: (CONTACTS, BOOLEAN), CONTACTS: (BOOLEAN,)}.get(asked.cell.query, ())
    for query in others:
        yield image_of(asked, unchanged, query=query)


def _beside(asked: Asked, side: int, shape: Proxy, error: Array, expected: Bounds) -> Image:
    """A shape of its own against one side of the scene, by distance."""
    other = asked.sides[side]
    cell = Cell(DISTANCE, type(shape), type(other))
    errors = error, np.zeros(len(error))
    return Image(cell, shape, other, (None, side), unchanged, errors, expected, alike=OTHER).in_table_order()


@relation(
    "asking for the distance of a ray's segment",
    ELSEWHERE,
    "a ray contradicts the distance of its segment",
)
def segment(asked: Asked) -> Iterator[Image]:
    """A ray up to beyond the proxy is a segment: it hits exactly where that segment's distance is not positive."""
    if not isinstance(asked.a, Ray):
        return
    ray, t = asked.a, asked.answers.t
    reach = past(ray, asked.b)
    reach = np.where((asked.answers.hit == 1) & np.isfinite(t), np.fmax(reach, t), reach)
    with np.errstate(over="ignore", invalid="ignore"):
        end = ray.at(reach)
    usable = largest(end) < 1e150
    end = np.where(usable[:, None], end, ray.origin)
    error = np.where(usable, ROUND * (largest(ray.origin) + largest(end)), np.inf)
    yield _beside(asked, 1, asked.world.rounded(ray.origin, end, np.zeros(len(end))), error, asked.bounds)


@relation("asking for the distance of a ray's hit point", ELSEWHERE, "a ray's hit point is off the proxy")
def arrival(asked: Asked) -> Iterator[Image]:
    """Where a ray arrives, the proxy begins: the engine's own distance of that point is 0."""
    if not isinstance(asked.a, Ray):
        return
    ray, answers, room = asked.a, asked.answers, asked.room("value")
    named = (answers.status == Status.ANSWERED) & (answers.hit == 1) & (answers.t >= 0) & (answers.t < 1e150)
    with np.errstate(over="ignore", invalid="ignore"):
        point = ray.at(np.where(named, answers.t, 0.0))
    named &= largest(point) < 1e150
    point = np.where(named[:, None], point, ray.origin)
    error = np.where(named, ROUND * (largest(ray.origin) + largest(point)), np.inf)
    on_surface = (norm(point - ray.origin) > room + error) & (not isinstance(asked.b, UNIONS))
    yield _beside(asked, 1, asked.world.point(point), error, Bounds(np.where(on_surface, -room, -np.inf), room))


@relation("asking for the distance of a witness", ELSEWHERE, "a witness is off its proxy by its own distance")
def witnesses(asked: Asked) -> Iterator[Image]:
    """Witness points belong to their proxies: the engine's own distance of each is not positive."""
    answers = asked.seen
    if asked.motion is not None or asked.cell.query not in (DISTANCE, CONTACTS):
        return
    for side, (shape, witness) in enumerate(zip(asked.sides, (answers.on_a, answers.on_b), strict=True)):
        said = (answers.status == Status.ANSWERED) & (largest(witness) < 1e150)
        if isinstance(shape, Point) or not said.any():
            continue
        point = asked.world.point(np.where(said[:, None], witness, 0.0))
        nothing = np.full(len(asked), -np.inf)
        error = np.where(said, 0.0, np.inf)
        yield _beside(asked, side, point, error, Bounds(nothing, asked.room("witness")))


@relation("moving B back along the normal", contradiction="moved by its normal and distance, the pair does not touch")
def normals(asked: Asked) -> Iterator[Image]:
    """A normal with its distance is a promise: B moved back by them touches A, by the engine's own distance."""
    answers, query = asked.seen, asked.cell.query
    conventions = asked.engine.conventions(query, asked.cell.type_a, asked.cell.type_b)
    if asked.motion is not None or query not in (DISTANCE, CONTACTS) or Convention.OF_ONE_TRIANGLE in conventions:
        return
    if HalfSpace is asked.cell.type_a is asked.cell.type_b:
        return  # their distance is no length: at the least tilt they overlap without end
    said = (answers.status == Status.ANSWERED) & (np.abs(answers.distance) < 1e150)
    said &= np.isfinite(answers.normal).all(axis=-1)
    if any(isinstance(side, UNIONS) for side in asked.sides):
        said &= answers.distance > 0
    if not said.any():
        return
    move = np.where(said[:, None], -scale(np.where(said, answers.distance, 0.0), answers.normal), 0.0)
    first_moves = has_slabs(asked.b)
    room = asked.room("value")

    def carry(side: int, shape: Proxy) -> Carried:
        if side == (0 if first_moves else 1):
            found = moved(shape, -move if first_moves else move)
            return found.shape, np.where(said, found.error + ROUND * largest(move), np.inf)
        return exactly(shape)

    query = DISTANCE if asked.engine.support(DISTANCE, asked.cell.type_a, asked.cell.type_b) else query
    yield image_of(asked, carry, query=query, expected=Bounds(-room, room), alike=OTHER)
