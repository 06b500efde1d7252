"""Line of sight: whether the segment between two points is free of everything in a scene."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from operator import index

import numpy as np
from numpy.typing import ArrayLike

from refimpl.linear import Bools
from refimpl.lookup.scene import Scene, require_scene
from refimpl.queries import intersect
from refimpl.shapes import Capsule, Point, ShapeError
from refimpl.signs import Indices

NOBODY = -1


@dataclass(frozen=True)
class Sight:
    """Whether one sees the other.

    Attributes
    ----------
    free : (...) bool
    blocker : (...) int64
        Of what is in between, the proxy with the lowest number; −1 where nothing is.
    """

    free: Bools
    blocker: Indices


def line_of_sight(scene: Scene, p: ArrayLike, q: ArrayLike, apart_from: Collection[int] = ()) -> Sight:
    """Whether nothing has a point of the segment pq; touching counts as being in between.

    Parameters
    ----------
    scene : Scene
    p, q : (..., 3)
        Finite; they broadcast. They may be one point.
    apart_from : collection of int
        Numbers of proxies that do not count, as those who look and who are looked at.

    Raises
    ------
    ShapeError
        Names what is none of that.

    Notes
    -----
    The segment is a capsule without a radius, so that `certify(Capsule(p, q, 0), scene[number])` proves each answer.
    """
    first, second = Point(p).position, Point(q).position
    try:
        first, second = np.broadcast_arrays(first, second)
        uncounted = [index(number) for number in apart_from]
    except ValueError:
        raise ShapeError(f"p, q: shapes {first.shape} and {second.shape} do not broadcast") from None
    except TypeError:
        raise ShapeError(f"apart_from: expected numbers of proxies, got {apart_from!r}") from None
    segments = Capsule(first.reshape(-1, 3), second.reshape(-1, 3), np.zeros(first.size // 3))
    with np.errstate(over="ignore"):  # ways that have no end are asked as boxes
        way = segments.q - segments.p
    near = require_scene(scene).near_ways(segments.p, way, 1.0)
    near = near[~np.isin(near[:, 1], uncounted)]
    between = np.zeros(len(near), dtype=bool)
    for some, proxies in scene.by_type(near[:, 1]):
        between[some] = intersect(segments[near[some, 0]], proxies)
    row, place = np.unique(near[between, 0], return_index=True)
    blocker = np.full(len(segments), NOBODY)
    blocker[row] = near[between, 1][place]
    blocker = blocker.reshape(first.shape[:-1])[()]
    return Sight(blocker == NOBODY, blocker)
