"""Flat proxies as Pymunk takes them: shapes of one body that stands at the origin, so that no number is changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from oracles.engine import EngineUnavailable, Kind, Row
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, Rectangle, Segment

CIRCLE, SEGMENT, POLY = "Circle", "Segment", "Poly"


class Placed(NamedTuple):
    """A shape: the middle of a circle, the ends of a segment, or the corners of a polygon, anticlockwise."""

    geometry: str
    points: list[list[float]]
    radius: float = 0.0


def _polygon(row: Row) -> Placed:
    """Vertices as they were given, of which Chipmunk takes the hull; of lines the corners, rounded."""
    return Placed(POLY, ConvexPolygon.unpack(np.array(row)).vertices.tolist())


PLACED: dict[Kind, Callable[[Row], Placed]] = {
    FlatPoint: lambda r: Placed(CIRCLE, [r]),
    Disc: lambda r: Placed(CIRCLE, [r[:2]], r[2]),
    Segment: lambda r: Placed(SEGMENT, [r[:2], r[2:4]], r[4]),
    Rectangle: lambda r: Placed(POLY, [r[:2], [r[2], r[1]], r[2:], [r[0], r[3]]]),
    ConvexPolygon: _polygon,
}


def place(kind: Kind, row: Row) -> Placed:
    """One proxy, given as its row of numbers."""
    return PLACED[kind](row)


def sizes_of(placed: Placed) -> tuple[Any, ...]:
    """What Pymunk's constructor of that name takes behind the body."""
    return {
        CIRCLE: (placed.radius, placed.points[0]),
        SEGMENT: (*placed.points, placed.radius),
        POLY: (placed.points,),
    }[placed.geometry]


def import_pymunk() -> Any:
    """Import the engine.

    Raises
    ------
    EngineUnavailable
        When that fails.
    """
    try:
        import pymunk  # noqa: PLC0415  an optional package
    except ImportError as error:
        raise EngineUnavailable(f"pymunk cannot be imported ({error}): pip install pymunk") from None
    return pymunk


class Maker:
    """Makes Pymunk's shapes, all of one body that cannot move and stands at the origin."""

    def __init__(self, pymunk: Any) -> None:
        self._pymunk = pymunk
        self._body = pymunk.Body(body_type=pymunk.Body.STATIC)

    def __call__(self, placed: Placed) -> Any:
        """Make a shape that can be asked; the caller keeps it while it asks."""
        shape = getattr(self._pymunk, placed.geometry)(self._body, *sizes_of(placed))
        shape.cache_bb()  # without it the engine looks for the shape at no place at all
        return shape


def shape_text(name: str, placed: Placed) -> str:
    """Lines of a script that make a shape."""
    sizes = ", ".join(map(repr, sizes_of(placed)))
    return f"{name} = pymunk.{placed.geometry}(body, {sizes})\n{name}.cache_bb()\n"
