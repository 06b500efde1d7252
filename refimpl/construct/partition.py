"""Space around a set, cut into boxes that become small where its boundary is.

A function that changes by no more than its argument moves, and is negative inside, tells of a box by its value at the
centre alone: farther from 0 than the half diagonal, and the whole box is on one side (the octrees of adaptively sampled
distance fields; Frisken, Perry, Rockwood and Jones, 2000).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from refimpl.linear import Array, Bools, norm

Field = Callable[[Array, float], Array]
"""Values (n,) at points (n, 3): negative inside a set, and nowhere steeper than 1.

The number is a reach: what is known to be farther than that outside may be given any value beyond it.
"""
SURE = 1 + 2.0**-30  # far more than a value is rounded


@dataclass(frozen=True)
class Boxes:
    """Boxes with disjoint interiors that together fill a larger one.

    Attributes
    ----------
    center, half : (n, 3)
    value : (n,)
        Of the field at the centres.
    """

    center: Array
    half: Array
    value: Array

    @property
    def volume(self) -> Array:
        """Volumes (n,)."""
        return 8 * self.half[:, 0] * self.half[:, 1] * self.half[:, 2]

    @property
    def edge(self) -> Array:
        """Edges (n,) of cubes of the same volume."""
        return np.cbrt(self.volume)

    @property
    def mixed(self) -> Bools:
        """Boxes that may hold points of both sides."""
        return np.abs(self.value) <= SURE * norm(self.half)

    def __getitem__(self, some: Bools) -> Boxes:
        return Boxes(self.center[some], self.half[some], self.value[some])


def partition(field: Field, lower: Array, upper: Array, most: int) -> Boxes:
    """Halve a box along its long edges, again and again, wherever the boundary may be.

    Parameters
    ----------
    field : Field
    lower, upper : (3,)
        Corners of the box.
    most : int
        Boxes with the boundary in them that are not halved further, at most.
    """
    half = upper / 2 - lower / 2
    boxes = Boxes((lower / 2 + upper / 2)[None], half[None], _at(field, (lower / 2 + upper / 2)[None], half))
    done = []
    while True:
        mixed = boxes.mixed
        done.append(boxes[~mixed])
        boxes = boxes[mixed]
        axes = np.flatnonzero(half > 0.7 * np.max(half))
        if not len(boxes.value) or len(boxes.value) * 2 ** (len(axes) - 1) > most:
            break
        center = boxes.center
        half = half.copy()
        for axis in axes.tolist():
            half[axis] /= 2
            step = half * (np.arange(3) == axis)
            center = np.concatenate([center - step, center + step])
        boxes = Boxes(center, np.broadcast_to(half, center.shape), _at(field, center, half))
    done.append(boxes)
    return Boxes(*(np.concatenate([getattr(part, name) for part in done]) for name in ("center", "half", "value")))


def _at(field: Field, center: Array, half: Array) -> Array:
    return field(center, SURE * float(norm(half)))
