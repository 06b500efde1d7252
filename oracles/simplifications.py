"""Simplifications of a found scene, for Hypothesis to draw and to shrink: the simplest draw is the simplest scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from typing import TypeVar

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from oracles.clumsiness import PLAIN
from oracles.course import Course
from oracles.motion import Motion
from oracles.plain_impacts import simpler_motions
from oracles.plain_sweeps import simpler_courses
from oracles.scene import Scene
from oracles.simpler import changeable, fewer_parts, rebuilt, simpler_numbers
from oracles.world import world_of
from refimpl import Proxy

STAYING = 3
"""How much likelier it is that something stays than that it is made simpler."""
STEPS = 3
"""Simplifications of a motion, one after the other."""

T = TypeVar("T")


def simplifications(scene: Scene) -> st.SearchStrategy[Scene]:
    """The scene without some parts, with any of its odd numbers simpler and with a simpler motion, several at once.

    Each most often stays as it is, so that scenes come up in which the fault is still there. The bodies of an impact
    stay, because they touch where its motion says.
    """
    parts = [list(fewer_parts(shape)) for shape in (scene.a, scene.b)]
    motions = sum(1 for _ in _simpler_motions(scene))

    @st.composite
    def drawn(draw: st.DrawFn) -> Scene:  # without arguments, for Hypothesis would write them out
        found = scene
        if scene.impact is None:
            a, b = (
                _in_simpler_numbers(draw, _one_of(draw, fewer, len(fewer), shape))
                for fewer, shape in zip(parts, (scene.a, scene.b), strict=True)
            )
            found = replace(scene, a=a, b=b)
        for _ in range(STEPS if motions else 0):
            found = replace(found, motion=_one_of(draw, _simpler_motions(found), motions, found.motion))
        return found

    return drawn()


def _in_simpler_numbers(draw: st.DrawFn, shape: Proxy) -> Proxy:
    row = shape.pack().copy()
    for i in np.flatnonzero(changeable(shape)):
        if row[i] not in PLAIN:
            simpler = _simpler_numbers(float(row[i]))
            row[i] = _one_of(draw, simpler, len(simpler), float(row[i]))
    made = rebuilt(shape, row)
    assume(made is not None)
    assert made is not None
    return made


@lru_cache(maxsize=1000)
def _simpler_numbers(x: float) -> list[float]:
    return simpler_numbers(x)


def _simpler_motions(scene: Scene) -> Iterator[Motion | Course]:
    if scene.impact is not None:
        yield from simpler_motions(scene.impact)
    elif scene.course is not None:
        yield from simpler_courses(scene.course, world_of(scene.b).axes)


def _one_of(draw: st.DrawFn, simpler: Iterable[T], count: int, as_it_is: T) -> T:
    """Something simpler, of which there are so many, or most often what there is; the simplest is what comes first.

    What is drawn is its number, so that nothing else has to be made.
    """
    number = draw(_numbers_up_to(count)) if count else 0
    return next(islice(simpler, number, None), as_it_is) if number < count else as_it_is


@lru_cache(maxsize=1000)
def _numbers_up_to(count: int) -> st.SearchStrategy[int]:
    return st.sampled_from(range((1 + STAYING) * count))
