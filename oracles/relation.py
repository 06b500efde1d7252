"""What a relation is: a small function from answered scenes to related ones, registered under its name.

The maps are exact, or say how inexact they are, so that two answers that contradict each other need no reference to be
wrong. The docstring of each says why it exists.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from oracles.related import Asked, Carried, Image
from refimpl.shapes import Proxy, ShapeError

Make = Callable[[Asked], Iterator[Image]]


@dataclass(frozen=True)
class Relation:
    """A relation between the answers to two scenes.

    Attributes
    ----------
    changing
        What is done to the scene, as the subject of a sentence.
    family
        What relations that are broken for one reason have in common, as the subject of their symptom.
    contradiction
        What is wrong where the answers are of other queries than the first; empty where it is that they change.
    """

    name: str
    changing: str
    family: str
    contradiction: str
    reason: str
    make: Make

    def symptom(self, aspect: str) -> str:
        """What is wrong: the changed aspect of the answer, or the contradiction."""
        return self.contradiction or f"{self.family} changes the {aspect}"

    @property
    def lost(self) -> str:
        """Symptom of an image that is not answered."""
        return f"{self.family} loses the answer"

    def images(self, asked: Asked) -> Iterator[Image]:
        """Related scenes of a batch; rows for which there is none have infinite errors."""
        try:
            yield from self.make(asked)
        except ShapeError:  # rounding left an image without a set
            return


RELATIONS: dict[str, Relation] = {}

MOTION, SIZE, FORM, ELSEWHERE = "moving both", "scaling both", "writing the same set otherwise", "asking another query"
"""Families: what an engine that keeps distances only roughly breaks all at once."""


def relation(changing: str, family: str = "", contradiction: str = "") -> Callable[[Make], Make]:
    """Register a relation under its function's name; its family is its own, unless it is told."""

    def register(make: Make) -> Make:
        reason = (make.__doc__ or "").strip().splitlines()[0]
        RELATIONS[make.__name__] = Relation(make.__name__, changing, family or changing, contradiction, reason, make)
        return make

    return register


def exactly(shape: Proxy) -> Carried:
    """An image without any error."""
    return shape, np.zeros(len(shape))


def unchanged(side: int, shape: Proxy) -> Carried:
    """The map that keeps both sides."""
    del side
    return exactly(shape)
