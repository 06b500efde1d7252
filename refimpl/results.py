"""What the queries answer with: arrays whose leading axes are those of the batch."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np

from refimpl.linear import Array, Bools


@dataclass(frozen=True)
class _Answer:
    def __getitem__(self, index: Any) -> Self:
        """Answers at `index` of the batch axes."""
        return type(self)(*(getattr(self, f.name)[index] for f in fields(self)))


@dataclass(frozen=True)
class Separation(_Answer):
    """Signed distance of two proxies, with the features that realise it.

    Attributes
    ----------
    distance : (...)
        σ: the gap when positive, 0 when touching, minus the penetration depth when negative; −inf for two
        half-spaces, which overlap without end unless their planes are parallel and face each other.
    on_a, on_b : (..., 3)
        Witness points, on_b − on_a = distance · normal. NaN where the distance is infinite.
    normal : (..., 3)
        Unit vector from A to B: translating B along it separates. NaN where the distance is infinite.
    """

    distance: Array
    on_a: Array
    on_b: Array
    normal: Array

    def flipped(self) -> Separation:
        """Return the same, seen from the other proxy."""
        return Separation(self.distance, self.on_b, self.on_a, -self.normal)


@dataclass(frozen=True)
class CollisionData(_Answer):
    """What a response needs to know of a collision.

    Attributes
    ----------
    hit : (...) bool
        Whether the proxies intersect; touching counts.
    normal : (..., 3)
        Unit vector from A to B.
    depth : (...)
        Penetration depth, 0 without a hit. Of unions: the length of a translation that separates, where the
        shortest may be one a little shorter.
    least : (...)
        No translation shorter than this separates: the depth itself, but for unions, where the depth is known
        to lie between the two.
    on_a, on_b : (..., 3)
        Contact points: the deepest point of each proxy in the other.
    shift_a, shift_b : (..., 3)
        Translations to overlap-free positions, shared out by inverse mass; 0 without a hit, NaN where the
        overlap has no end.
    """

    hit: Bools
    normal: Array
    depth: Array
    least: Array
    on_a: Array
    on_b: Array
    shift_a: Array
    shift_b: Array


@dataclass(frozen=True)
class RayHit(_Answer):
    """First point of a proxy that a ray meets.

    Attributes
    ----------
    hit : (...) bool
    t : (...)
        Time of the hit in units of the ray's direction; 0 when the ray starts inside, inf on a miss.
    point : (..., 3)
        NaN on a miss.
    normal : (..., 3)
        Outward unit normal; NaN on a miss and when the ray starts inside.
    """

    hit: Bools
    t: Array
    point: Array
    normal: Array


@dataclass(frozen=True)
class SweepHit(_Answer):
    """First contact of two moving proxies.

    Attributes
    ----------
    hit : (...) bool
        Whether the closed sets have a point in common at some time from 0 to 1.
    t : (...)
        First such time: 0 when they overlap from the start, inf when they never meet.
    point : (..., 3)
        A point that both have in common at that time; NaN when they never meet.
    normal : (..., 3)
        Unit vector from A to B at the contact; NaN when they never meet, and when they overlap from the start.
    t_lower : (...)
        No contact is believed to come before this time, t or a rounding error less; inf when they never meet. What is
        proven, `refimpl.proof.certify_sweep` tells.
    """

    hit: Bools
    t: Array
    point: Array
    normal: Array
    t_lower: Array


def where(condition: Bools, yes: Array, no: Array) -> Array:
    """Choose per row, for numbers and vectors alike."""
    extra = np.ndim(yes) - np.ndim(condition)
    return np.where(np.reshape(condition, np.shape(condition) + (1,) * extra), yes, no)
