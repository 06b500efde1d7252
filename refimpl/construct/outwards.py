"""Exact numbers rounded to the doubles of a bounding volume: never inwards, and by no more than must be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from refimpl.construct.cloud import Cloud
from refimpl.construct.sources import ConstructionError
from refimpl.linear import Array
from refimpl.proof.points import round_up
from refimpl.proof.vectors import root


def least_above(number: Fraction, cloud: Cloud, what: str) -> float:
    """Least double that is not below a number of a cloud's units."""
    found = round_up(number * cloud.unit)
    if not math.isfinite(found):
        raise ConstructionError(f"the {what} lies beyond the largest float: scale the points down")
    return found


def least_root(square: Fraction, cloud: Cloud, what: str) -> float:
    """Least double whose square is not below a number of a cloud's units squared."""
    found = least_above(root(square)[1], cloud, what)
    below = math.nextafter(found, 0.0)
    return below if found > 0 and (Fraction(below) / cloud.unit) ** 2 >= square else found


def nearest(point: Sequence[Fraction], cloud: Cloud, what: str) -> Array:
    """Point of a cloud's units in doubles of the caller's."""
    try:
        return np.array([float(v * cloud.unit) for v in point])
    except OverflowError:
        raise ConstructionError(f"the {what} lies beyond the largest float: scale the points down") from None
