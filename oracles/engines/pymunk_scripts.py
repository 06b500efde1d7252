"""Scripts that ask Pymunk alone, with the calls that its adapter makes."""

from __future__ import annotations

from oracles.engine import Kind
from oracles.engines.pymunk_shapes import Placed, shape_text
from oracles.scene import BOOLEAN

HEAD = '''"""Pymunk: {what} of {A} and {B}."""

from importlib.metadata import version

import pymunk

print("pymunk", version("pymunk"))
body = pymunk.Body(body_type=pymunk.Body.STATIC)  # at the origin
{shapes}'''

MEET = """
try:
    found = a.shapes_collide(b)
except AssertionError:  # how pymunk tells that the two do not touch
    found = None
print("hit =", float(found is not None))
"""
TELL = """if found is not None:
    deepest = min(found.points, key=lambda point: point.distance)
    print("distance =", repr(deepest.distance))
    print("normal =", [*found.normal, 0.0])  # from a to b
    print("on_a =", [*deepest.point_a, 0.0])
    print("on_b =", [*deepest.point_b, 0.0])
"""
MEASURE = """
found = b.point_query({centre!r})
print("distance =", repr(found.distance - {radius!r}))
if found.point.x == found.point.x:  # it is (nan, nan) on the outline of a polygon
    print("on_b =", [*found.point, 0.0])
x, y = found.gradient
print("normal =", [0.0 - x, 0.0 - y, 0.0])  # to b, where the gradient points away from it
"""
CAST = """
found = b.segment_query({start!r}, {end!r})
print("hit =", float(found is not None))
print("t =", repr(float("inf") if found is None else found.alpha * {reach!r}))
if found is not None:
    print("point =", [*found.point, 0.0])
    if found.alpha > 0:
        print("normal =", [*found.normal, 0.0])
"""

SWEEP = """
found = b.segment_query({start!r}, {end!r}, {radius!r})  # as seen from b
print("hit =", float(found is not None))
print("t =", repr(float("inf") if found is None else found.alpha))
if found is not None:
    print("point =", [p + found.alpha * v for p, v in zip(found.point, {own!r}, strict=True)] + [0.0])
    u, v = found.normal
    if found.alpha > 0:
        print("normal =", [0.0 - u, 0.0 - v, 0.0])  # to b
"""


def contact_script(query: str, kinds: tuple[Kind, Kind], a: Placed, b: Placed) -> str:
    """Ask whether two shapes touch, and where."""
    shapes = shape_text("a", a) + shape_text("b", b)
    return _head(query, kinds, shapes) + MEET + ("" if query == BOOLEAN else TELL)


def distance_script(kinds: tuple[Kind, Kind], ball: Placed, b: Placed) -> str:
    """Ask how far a point or disc is from a shape."""
    ask = MEASURE.format(centre=ball.points[0], radius=ball.radius)
    return _head("distance", kinds, shape_text("b", b)) + ask


def cast_script(kinds: tuple[Kind, Kind], b: Placed, start: list[float], end: list[float], reach: float) -> str:
    """Ask where a segment, which a ray passes in the time `reach`, meets a shape."""
    return _head("raycast", kinds, shape_text("b", b)) + CAST.format(start=start, end=end, reach=reach)


def sweep_script(kinds: tuple[Kind, Kind], ball: Placed, end: list[float], own: list[float], b: Placed) -> str:
    """Ask when a point or disc first meets a shape, both on their ways."""
    ask = SWEEP.format(start=ball.points[0], end=end, radius=ball.radius, own=own)
    return _head("sweep", kinds, shape_text("b", b)) + ask


def _head(what: str, kinds: tuple[Kind, Kind], shapes: str) -> str:
    A, B = kinds
    return HEAD.format(what=what, A=A.__name__, B=B.__name__, shapes=shapes)
