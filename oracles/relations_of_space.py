"""Relations of space and motion: no place, direction, handedness or size is special, nor a unit of mass or speed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oracles import impact_images, sweep_images
from oracles.course import Course
from oracles.images import MIRRORED, QUARTER, TURNED, Axes, has_slabs, moved
from oracles.motion import Motion
from oracles.related import Asked, Carried, Image, image_of
from oracles.relation import MOTION, SIZE, exactly, relation, unchanged
from oracles.scene import RAYCAST
from oracles.world import PLANE
from refimpl.linear import power_of_two, scale
from refimpl.shapes import Proxy

FAR = np.array([4.0, -8.0, 2.0])
ALONG = np.array([0.0, 8.0, 0.0])
"""How far pairs are moved, relative to the power of two above their size; along an axis where slabs must not round."""
LARGER, SMALLER = 2.0**10, 2.0**-10
TRAIN = np.array([2.0, -1.0, 4.0])
"""Way of what a sweep is seen from, relative to that power of two."""
HEAVIER = 2.0**6
"""By which masses, or velocities, are multiplied."""


@relation("swapping A and B")
def swapped(asked: Asked) -> Iterator[Image]:
    """The order of two proxies means nothing; engines write each pair once, and flip frames, normals and witnesses."""
    if isinstance(asked.motion, Motion):
        yield impact_images.exchanged(asked)
    elif isinstance(asked.motion, Course):
        yield sweep_images.exchanged(asked)
    elif asked.cell.query != RAYCAST:
        yield image_of(asked, unchanged, sources=(1, 0))


def _by_axes(asked: Asked, axes: Axes) -> Iterator[Image]:
    if asked.world is PLANE and not axes.keeps_the_plane:
        return
    if isinstance(asked.motion, Motion):
        yield impact_images.by_axes(asked, axes)
    elif isinstance(asked.motion, Course):
        yield sweep_images.by_axes(asked, axes)
    else:
        yield image_of(asked, lambda _, shape: exactly(axes(shape)))


@relation("turning both", MOTION)
def turned(asked: Asked) -> Iterator[Image]:
    """Space has no preferred axes: x becomes z, z y, y x, exactly; code that treats one axis apart is caught."""
    yield from _by_axes(asked, TURNED)


@relation("turning both by 90 degrees", MOTION)
def quarter_turned(asked: Asked) -> Iterator[Image]:
    """A quarter turn about z takes positive coordinates to negative ones, and edges to other edges, exactly."""
    yield from _by_axes(asked, QUARTER)


@relation("mirroring both", MOTION)
def mirrored(asked: Asked) -> Iterator[Image]:
    """A mirror keeps distances but turns every cross product: an isometry that no change of frame hides."""
    yield from _by_axes(asked, MIRRORED)


@relation("moving both", MOTION)
def translated(asked: Asked) -> Iterator[Image]:
    """Only relative positions count: an origin in the wrong frame, or a fixed threshold, shows far from it."""
    size = np.maximum(asked.a.magnitude, asked.b.magnitude)
    step = np.ldexp(1.0, power_of_two(np.maximum(size, np.finfo(float).tiny)))
    if isinstance(asked.motion, Motion):
        yield impact_images.elsewhere(asked, scale(step, asked.world.level(FAR)))
        return
    offset = scale(step, asked.world.level(ALONG if any(map(has_slabs, asked.sides)) else FAR))
    if isinstance(asked.motion, Course):
        yield sweep_images.elsewhere(asked, offset)
        return

    def carry(_: int, shape: Proxy) -> Carried:
        found = moved(shape, offset)
        return found.shape, found.error

    yield image_of(asked, carry)


def _by_size(asked: Asked, factor: float) -> Iterator[Image]:
    if isinstance(asked.motion, Motion):
        yield impact_images.at_another_size(asked, factor)
        return

    def carry(_: int, shape: Proxy) -> Carried:
        image = shape.scaled(factor)
        back = np.all(image.scaled(1 / factor).pack() == shape.pack(), axis=-1)
        return image, np.where(back, 0.0, np.inf)

    if isinstance(asked.motion, Course):
        yield sweep_images.at_another_size(asked, carry, factor)
        return
    yield image_of(asked, carry, factor=factor)


@relation("scaling both up", SIZE)
def scaled_up(asked: Asked) -> Iterator[Image]:
    """No size is special: lengths times 1024 are exact, and absolute thresholds and float32 show."""
    yield from _by_size(asked, LARGER)


@relation("scaling both down", SIZE)
def scaled_down(asked: Asked) -> Iterator[Image]:
    """As scaling up, towards sizes at which absolute thresholds swallow the scene."""
    yield from _by_size(asked, SMALLER)


@relation("moving along with both bodies")
def moving_along(asked: Asked) -> Iterator[Image]:
    """Galileo's principle: seen from a train, what moves is the same; code that mixes absolute velocities is not."""
    if isinstance(asked.motion, Motion):
        yield impact_images.seen_from_a_train(asked)
    if isinstance(asked.motion, Course):
        step = np.ldexp(1.0, power_of_two(np.maximum(asked.size, np.finfo(float).tiny)))
        yield sweep_images.moving_along(asked, scale(step, asked.world.level(TRAIN)))


@relation("making both bodies heavier")
def heavier(asked: Asked) -> Iterator[Image]:
    """Only the ratio of the masses counts: a unit of mass, or a threshold on one, shows."""
    if isinstance(asked.motion, Motion):
        yield impact_images.heavier(asked, HEAVIER)


@relation("making both bodies quicker")
def quicker(asked: Asked) -> Iterator[Image]:
    """Velocities after an impact are in proportion to those before: thresholds on speed, and clamps, show."""
    if isinstance(asked.motion, Motion):
        yield impact_images.quicker(asked, HEAVIER)
