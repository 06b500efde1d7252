"""What part of space a picture shows, and from where it is seen."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.linear import Array, norm
from reports.viewer.solids import Line, Plane, Solid

MARGIN = 1.12
NEARLY = 25.0
"""A body so many times smaller than the other would hardly be seen: the picture then shows its surroundings."""

REACH = 4.0
"""How far off, in radii of what is shown, a true witness may lie and still be brought into the picture."""


@dataclass(frozen=True)
class Frame:
    """A ball of space, in lengths times 2^−exponent: what fills the picture.

    Attributes
    ----------
    focused
        Whether only the surroundings of the smaller body are shown.
    """

    exponent: int
    center: Array
    radius: float
    focused: bool = False

    @property
    def size(self) -> float:
        """The ball's radius in the scene's own lengths; may be infinite."""
        return _ldexp(self.radius, self.exponent)

    def place(self, points: Array) -> Array:
        """Scaled points in the picture, whose radius is 1."""
        return np.asarray((points - self.center) / self.radius)

    def point(self, place: Sequence[Any]) -> Array | None:
        """A point of the world in the picture: exact until it is scaled; None where it is out of reach."""
        scale = Fraction(2) ** -self.exponent
        scaled = [_nearest(Fraction(x) * scale - Fraction(c)) for x, c in zip(place, self.center.tolist(), strict=True)]
        found = np.array(scaled) / self.radius
        return found if np.isfinite(found).all() else None

    def length(self, value: float) -> float:
        """A length of the world in radii of the picture."""
        return float(np.ldexp(value, -self.exponent)) / self.radius


def _ldexp(value: float, exponent: int) -> float:
    try:
        return math.ldexp(value, exponent)
    except OverflowError:
        return math.inf


def _nearest(value: Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def exponent_of(magnitudes: Iterable[float]) -> int:
    """Power of two by which lengths are divided, so that none is far from 1."""
    return int(np.frexp(max(magnitudes, default=0.0))[1])


def choose(exponent: int, a: list[Solid], b: list[Solid], anchors: list[Array]) -> Frame:
    """Frame of two bodies; `anchors` are true points, brought in where they are near."""
    ball_a, ball_b = (_ball(np.concatenate([part.corners() for part in side])) for side in (a, b))
    smaller, larger = sorted((ball_a, ball_b), key=lambda ball: ball[1])
    gap = float(norm(smaller[0] - larger[0])) - smaller[1] - larger[1]
    focused = smaller[1] > 0 and larger[1] > NEARLY * smaller[1] and gap < NEARLY * smaller[1]
    bounded = [ball for ball in (ball_a, ball_b) if ball[1] >= 0]
    center, radius = smaller if focused else _around(bounded) if bounded else (np.zeros(3), -1.0)
    needed = [] if focused else [*_feet(a, center), *_feet(b, center)]
    near = [x for x in anchors if radius <= 0 or norm(x - center) < REACH * radius]
    points = np.stack([*needed, *near]) if needed or near else np.empty((0, 3))
    center, radius = _around([(center, radius)] * (radius >= 0) + [(x, 0.0) for x in points])
    return Frame(exponent, center, MARGIN * radius if radius > 0 else 1.0, focused)


Ball = tuple[Array, float]


def _ball(corners: Array) -> Ball:
    """A ball around points; of no points, one of radius −1."""
    if not len(corners):
        return np.zeros(3), -1.0
    low, high = corners.min(axis=0), corners.max(axis=0)
    return low / 2 + high / 2, float(norm(high / 2 - low / 2))


def _around(balls: list[Ball]) -> Ball:
    """A ball around balls."""
    if not balls:
        return np.zeros(3), 0.0
    if len(balls) == 1:
        return balls[0]
    low = np.min([center - radius for center, radius in balls], axis=0)
    high = np.max([center + radius for center, radius in balls], axis=0)
    center = low / 2 + high / 2
    return center, max(float(norm(c - center)) + radius for c, radius in balls)


def _feet(side: list[Solid], center: Array) -> list[Array]:
    """What of endless bodies has to be seen: the points nearest to the middle."""
    found = []
    for part in side:
        if isinstance(part, Plane):
            found.append(center - ((center - part.foot) @ part.normal) * part.normal)
        elif isinstance(part, Line) and part.endless:
            way = part.end - part.start
            found.append(part.start + max(0.0, float((center - part.start) @ way)) * way)
    return found


@dataclass(frozen=True)
class View:
    """Where a picture is seen from: angles in degrees, z upwards."""

    azimuth: float
    elevation: float

    @property
    def axes(self) -> Array:
        """Unit vectors to the right, upwards, and towards the eye, in rows."""
        turn, rise = math.radians(self.azimuth), math.radians(self.elevation)
        right = [-math.sin(turn), math.cos(turn), 0.0]
        eye = [math.cos(rise) * math.cos(turn), math.cos(rise) * math.sin(turn), math.sin(rise)]
        return np.array([right, np.cross(eye, right), eye])


USUAL = View(-50.0, 22.0)
VIEWS = [View(USUAL.azimuth + turn, rise) for rise in (22.0, 38.0, 8.0) for turn in range(0, 360, 15)]
TILT = 0.25
"""Cosine of the angle at which a contact normal is best seen: nearly from the side."""


def best_view(across: list[Array], outward: list[Array]) -> View:
    """The view that shows these directions from the side, and planes from the side to which `outward` points."""

    def cost(item: tuple[int, View]) -> tuple[float, int]:
        number, view = item
        eye = view.axes[2]
        sideways = max((abs(abs(float(eye @ n)) - TILT) for n in across), default=0.0)
        behind = sum(float(eye @ n) < 0.05 for n in outward)
        return round(sideways + behind, 1), number

    return min(enumerate(VIEWS), key=cost)[1]


def clipped(line: Line, reach: float) -> Line | None:
    """The part of a placed line within a ball around the middle; None where it passes by."""
    way = line.end - line.start
    length = float(norm(way))
    if length == 0:
        return line
    unit = way / length
    middle = -float(line.start @ unit)
    room = reach * reach - float(norm(line.start + middle * unit)) ** 2
    if room <= 0:
        return None
    low, high = max(0.0, middle - math.sqrt(room)), middle + math.sqrt(room)
    high = high if line.endless else min(high, length)
    if high <= low:
        return None
    return replace(line, start=line.start + low * unit, end=line.start + high * unit, endless=line.endless)
