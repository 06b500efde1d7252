"""Images of sweeps: courses under maps that the first contact does not notice, and what times they ask for.

Each map is exact, or says by how much it moves a side: halving and negating are, adding and placing round.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from oracles.course import Course
from oracles.images import Axes, moved, sum_error
from oracles.related import Asked, Carried, Carry, Image, equal, image_of
from refimpl.linear import Array, norm, scale
from refimpl.motions import RigidMotion
from refimpl.shapes import Proxy

ROUNDED = 2.0**-52
"""Rounding of a product, relative to it."""


def course_of(asked: Asked) -> Course:
    """The courses of a batch of sweeps."""
    assert isinstance(asked.motion, Course)
    return asked.motion


# -- what the second times must be ---------------------------------------------------------------------------------
# Times of a batch before and after, infinite for a miss; the result is by how much the second contradict the first, in
# the units of the first: infinite where one hits and the other may not.


def no_later(first: Array, second: Array) -> Array:
    """At that time, or before."""
    return np.where(second <= first, 0.0, equal(first, second))


def in_reverse(first: Array, second: Array) -> Array:
    """Backwards it begins where it ended: with the last contact, which comes no sooner than the first."""
    with np.errstate(invalid="ignore"):
        return np.where(np.isinf(first) & np.isinf(second), 0.0, np.fmax(first + second - 1.0, 0.0))


def of_first_half(first: Array, second: Array) -> Array:
    """In half of the time the way goes half as far: a contact comes at twice the time, if it comes by then."""
    return np.where(np.isinf(second), np.fmax(0.5 - first, 0.0), equal(first, second / 2))


def of_second_half(first: Array, second: Array) -> Array:
    """What goes on from the middle, where nothing has touched yet."""
    return equal(first, 0.5 + second / 2)


def of_ray(first: Array, second: Array) -> Array:
    """A ray goes on without end."""
    return equal(first, np.where(second <= 1, second, np.inf))


# -- maps --------------------------------------------------------------------------------------------------------


def _with_errors(carry: Carry, errors: tuple[Array, Array]) -> Carry:
    """The same map, with what the course adds to the error of each side."""

    def carried(side: int, shape: Proxy) -> Carried:
        image, error = carry(side, shape)
        return image, error + errors[side]

    return carried


def _exactly(_: int, shape: Proxy) -> Carried:
    return shape, np.zeros(len(shape))


def exchanged(asked: Asked) -> Image:
    """A becomes B, with its course."""
    course = course_of(asked)
    return image_of(asked, _exactly, sources=(1, 0), motion=Course(course.b, course.a))


def by_axes(asked: Asked, axes: Axes) -> Image:
    """Axes change places; spins are vectors of rotation."""

    def motion(of: RigidMotion) -> RigidMotion:
        return RigidMotion(axes.places(of.linear), axes.spins(of.angular), axes.places(of.center))

    course = course_of(asked)

    def carry(_: int, shape: Proxy) -> Carried:
        return axes(shape), np.zeros(len(shape))

    return image_of(asked, carry, motion=Course(motion(course.a), motion(course.b)))


def elsewhere(asked: Asked, offset: Array) -> Image:
    """Everything is moved, with the centres about which it turns."""
    sides, errors = [], []
    for side in course_of(asked).sides:
        turns = np.any(side.angular != 0, axis=-1)
        sides.append(replace(side, center=side.center + np.where(turns[:, None], offset, 0.0)))
        errors.append(np.where(turns, 2 * norm(sum_error(side.center, offset)), 0.0))

    def carry(_: int, shape: Proxy) -> Carried:
        found = moved(shape, offset)
        return found.shape, found.error

    return image_of(asked, _with_errors(carry, (errors[0], errors[1])), motion=Course(*sides))


def at_another_size(asked: Asked, carry: Carry, factor: float) -> Image:
    """Lengths times a power of two; spins and times stay."""
    course = course_of(asked)
    sides = (replace(side, linear=factor * side.linear, center=factor * side.center) for side in course.sides)
    return image_of(asked, carry, factor=factor, motion=Course(*sides))


def moving_along(asked: Asked, along: Array) -> Image:
    """Both get the same way besides: only how the one moves against the other counts."""
    sides, errors = [], []
    for side in course_of(asked).sides:
        sides.append(replace(side, linear=side.linear + along))
        errors.append(norm(sum_error(side.linear, along)))
    return image_of(asked, _with_errors(_exactly, (errors[0], errors[1])), motion=Course(*sides))


def _gone(asked: Asked, share: float) -> Carry:
    """Both where they are after a share of the time, a power of two; those that turn are left out."""
    course = course_of(asked)

    def carry(side: int, shape: Proxy) -> Carried:
        motion = course.sides[side]
        found = moved(shape, share * motion.linear)
        return found.shape, np.where(np.any(motion.angular != 0, axis=-1), np.inf, found.error)

    return carry


def backwards(asked: Asked) -> Image:
    """From the end to the start."""
    course = course_of(asked)
    back = Course.translating(-course.a.linear, -course.b.linear)
    return image_of(asked, _gone(asked, 1.0), motion=back, timing=in_reverse)


def _half_as_far(course: Course) -> Course:
    sides = (replace(side, linear=side.linear / 2, angular=side.angular / 2) for side in course.sides)
    return Course(*sides)


def first_half(asked: Asked) -> Image:
    """The motion up to its middle."""
    return image_of(asked, _exactly, motion=_half_as_far(course_of(asked)), timing=of_first_half)


def second_half(asked: Asked) -> Image:
    """The motion from its middle on, of what does not meet before."""
    met = np.where(asked.times > 0.5, 0.0, np.inf)
    carry = _with_errors(_gone(asked, 0.5), (met, met))
    return image_of(asked, carry, motion=_half_as_far(course_of(asked)), timing=of_second_half)


def at_contact(asked: Asked, carried: Carry = _exactly) -> tuple[Carry, Array]:
    """Both where they meet, B staying where it was; and the way that A has gone then, as seen from B."""
    course, times = course_of(asked), asked.times
    met = np.isfinite(times) & ~course.turns
    between = course.a.linear - course.b.linear
    with np.errstate(over="ignore", invalid="ignore"):
        way = np.where(met[:, None], scale(np.where(met, times, 0.0), between), 0.0)
    rounding = norm(sum_error(course.a.linear, -course.b.linear)) + 4 * ROUNDED * norm(way)

    def carry(side: int, shape: Proxy) -> Carried:
        if side == 1:
            return carried(side, shape)
        found = moved(shape, way)
        return found.shape, np.where(met, found.error + rounding, np.inf)

    return carry, norm(way)
