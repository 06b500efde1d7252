"""Relations of sweeps: backwards and by halves, and what an engine says elsewhere of the way and of its end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oracles import sweep_images
from oracles.course import Course
from oracles.images import sum_error
from oracles.promises import Bounds
from oracles.reference import UNIONS
from oracles.related import OTHER, Asked, Carried, Image, image_of
from oracles.relation import ELSEWHERE, exactly, relation
from oracles.scene import DISTANCE, RAYCAST
from refimpl.linear import norm
from refimpl.shapes import Point, Proxy

AHEAD = np.array([1.0, 0.0, 0.0])
HALVES = "splitting a motion in two"


@relation("going back in time")
def backwards(asked: Asked) -> Iterator[Image]:
    """What meets on its way meets on its way back, and both times together are no longer than the way."""
    if isinstance(asked.motion, Course):
        yield sweep_images.backwards(asked)


@relation("going half of the way", HALVES)
def first_half(asked: Asked) -> Iterator[Image]:
    """The first contact does not depend on how far one goes on: fractions of the whole, as thresholds, show."""
    if isinstance(asked.motion, Course):
        yield sweep_images.first_half(asked)


@relation("starting half-way", HALVES)
def second_half(asked: Asked) -> Iterator[Image]:
    """What has not met by the middle meets as if it had begun there: errors that add up along the way show."""
    if isinstance(asked.motion, Course):
        yield sweep_images.second_half(asked)


@relation(
    "asking for the distance at the time of contact",
    ELSEWHERE,
    "a sweep contradicts the distance at its time",
)
def contact(asked: Asked) -> Iterator[Image]:
    """Where two meet for the first time they touch: the engine's own distance there is 0."""
    if not isinstance(asked.motion, Course):
        return
    carry, way = sweep_images.at_contact(asked)
    room = asked.room("value")
    unions = any(isinstance(side, UNIONS) for side in asked.sides)
    bounds = Bounds(np.where((way > 0) & (not unions), -room, -np.inf), room)
    yield image_of(asked, carry, query=DISTANCE, expected=bounds, alike=OTHER)


@relation("asking for the ray of a moving point", ELSEWHERE, "a moving point contradicts its ray")
def flight(asked: Asked) -> Iterator[Image]:
    """A point on its way is a ray as long as that way: other code in most engines, for the same question."""
    course = asked.motion
    if not isinstance(asked.a, Point) or not isinstance(course, Course) or not asked.b.is_solid:
        return
    way = course.a.linear - course.b.linear
    known = ~course.turns & (norm(way) > 0)
    error = np.where(known, norm(sum_error(course.a.linear, -course.b.linear)), np.inf)
    ray = asked.world.ray(asked.a.position, asked.world.vectors(np.where(known[:, None], way, AHEAD)))

    def carry(side: int, shape: Proxy) -> Carried:
        return (ray, error) if side == 0 else exactly(shape)

    yield image_of(asked, carry, query=RAYCAST, expected=Bounds.none(len(asked)), timing=sweep_images.of_ray)
