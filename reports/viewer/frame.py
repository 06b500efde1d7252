"""What part of space a picture shows, and from where it is seen."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.linear import Array, norm
from reports.viewer.solids import Dot, Lathe, Line, Plane, Solid

MARGIN = 1.12
NEARLY = 25.0
"""A body so many times smaller than the other would hardly be seen: the picture then shows its surroundings ..."""

CLOSE = 8.0
"""... where the true points lie within so many of its radii."""

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


def choose(exponent: int, a: list[Solid], b: list[Solid], anchors: list[Array], gap: float) -> Frame:
    """Frame of two bodies.

    Parameters
    ----------
    anchors
        True points, scaled; brought in where they are near.
    gap
        Gap or depth, scaled; NaN where it is not known.
    """
    ball_a, ball_b = _ball(a), _ball(b)
    smaller, larger = sorted((ball_a, ball_b), key=lambda ball: ball[1])
    away = max([float(norm(x - smaller[0])) for x in anchors], default=gap)
    if math.isnan(away):
        away = max(0.0, float(norm(smaller[0] - larger[0])) - smaller[1] - larger[1])
    focused = smaller[1] > 0 and larger[1] > NEARLY * smaller[1] and away < CLOSE * smaller[1]
    seen = (a if smaller is ball_a else b) if focused else [*a, *b]
    center, radius = _ball(seen)
    needed = [] if focused else [*_feet(a, center), *_feet(b, center)]
    near = [x for x in anchors if focused or radius <= 0 or norm(x - center) < REACH * radius]
    center, radius = _ball([*seen, *map(Dot, [*needed, *near])])
    return Frame(exponent, center, MARGIN * radius if radius > 0 else 1.0, focused)


Ball = tuple[Array, float]


def _ball(parts: list[Solid]) -> Ball:
    """A ball around bodies, of those without end around what they begin with; around nothing, one of radius −1."""
    if not any(len(part.corners()) for part in parts):
        return np.zeros(3), -1.0
    corners = np.concatenate([part.corners() for part in parts])
    center = corners.min(axis=0) / 2 + corners.max(axis=0) / 2
    return center, max(farthest(part, center) for part in parts)


def farthest(part: Solid, center: Array) -> float:
    """How far the points of a body are from a centre, at most; 0 for a plane."""
    if isinstance(part, Plane):
        return 0.0
    if not isinstance(part, Lathe):
        return float(norm(part.corners() - center).max())
    sizes = norm(part.axes)
    sweep = part.axes[2] * (part.half if part.kind == "rod" else 1.0 if part.kind == "can" else 0.0)
    ends = np.stack([part.center + sweep, part.center - sweep]) - center
    return float(norm(ends).max() + (sizes[0] if part.kind == "can" else sizes.max()))


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
FROM_ABOVE = View(-90.0, 90.0)
"""With x to the right and y upwards: how the plane is looked at."""
VIEWS = [View(USUAL.azimuth + turn, rise) for rise in (22.0, 38.0, 8.0) for turn in range(0, 360, 15)]
EYES = np.array([view.axes[2] for view in VIEWS])
TILT = 0.25
"""Cosine of the angle at which a contact normal is best seen: nearly from the side."""


def best_view(across: list[Array], outward: list[Array]) -> View:
    """The view that shows these directions from the side, and planes from the side to which `outward` points."""
    sideways = np.max([abs(abs(EYES @ n) - TILT) for n in across], axis=0) if across else np.zeros(len(VIEWS))
    behind = np.sum([EYES @ n < 0.05 for n in outward], axis=0) if outward else np.zeros(len(VIEWS))
    return VIEWS[int(np.argmin(np.round(sideways + behind, 1)))]


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
