"""Scenes of the flat world, by regime: what makes the pair difficult."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from refimpl.flat import ConvexPolygon, Disc, Flat, FlatPoint, Rectangle, Segment

Random = np.random.Generator


def some(kind: type[Flat], rng: Random, size: float = 1.0, thin: float = 1.0) -> Flat:
    """A proxy about the origin; `thin` squeezes it along y."""
    squeeze = np.array([size, size * thin])
    if kind is FlatPoint:
        return FlatPoint(rng.normal(size=2) * squeeze)
    if kind is Disc:
        return Disc(rng.normal(size=2) * squeeze, size * rng.uniform(0.1, 1))
    if kind is Segment:
        return Segment(*(rng.normal(size=(2, 2)) * squeeze), size * thin * rng.choice([0.0, rng.uniform(0.1, 1)]))
    if kind is Rectangle:
        lower = rng.normal(size=2) * squeeze
        return Rectangle(lower, lower + rng.uniform(0, 2, size=2) * squeeze)
    if rng.random() < 0.6:
        return ConvexPolygon.from_vertices(rng.normal(size=(rng.integers(1, 7), 2)) * squeeze)
    angles = 2 * np.pi * (np.arange(rng.integers(3, 7)) + rng.uniform(0, 0.3, size=1)) / 3
    angles = np.concatenate([2 * np.pi * (np.arange(3) + rng.uniform(0, 0.4, size=3)) / 3, angles[3:]])
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1) / squeeze
    return ConvexPolygon(np.column_stack([normals, -rng.uniform(0.1, 1, size=len(normals))]))


def whole(kind: type[Flat], rng: Random) -> Flat:
    """A proxy of small whole numbers: sides are parallel, corners and sides are in line, shapes touch."""
    if kind is FlatPoint:
        return FlatPoint(rng.integers(-3, 4, size=2))
    if kind is Disc:
        return Disc(rng.integers(-3, 4, size=2), rng.integers(1, 4))
    if kind is Segment:
        return Segment(*rng.integers(-3, 4, size=(2, 2)), rng.integers(0, 2))
    if kind is Rectangle:
        lower = rng.integers(-3, 4, size=2)
        return Rectangle(lower, lower + rng.integers(0, 4, size=2))
    if rng.random() < 0.5:
        return ConvexPolygon.from_vertices(rng.integers(-3, 4, size=(rng.integers(1, 6), 2)))
    normals = np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 2]])
    return ConvexPolygon(np.column_stack([normals, -rng.integers(0, 4, size=6)]))


Scene = tuple[Flat, Flat]
Make = Callable[[type[Flat], type[Flat], Random], Scene]


def _near(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    return some(a, rng), some(b, rng).translated(rng.normal(size=2))


def _apart(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    return some(a, rng), some(b, rng).translated(rng.normal(size=2) * 5)


def _touching(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    """Moved along the normal to where they touch, up to rounding."""
    import refimpl  # noqa: PLC0415

    x, y = _near(a, b, rng)
    found = refimpl.distance(x, y)
    return x, y.translated(-found.distance * found.normal)


def _same_center(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    x, y = some(a, rng), some(b, rng, size=float(rng.choice([1.0, 0.01])))
    return x, y.translated(x.reference_point - y.reference_point)


def _slivers(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    thin = 10.0 ** rng.uniform(-12, -3)
    return some(a, rng, thin=thin), some(b, rng, thin=float(rng.choice([1.0, thin])))


def _far(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    away = rng.normal(size=2) * 1e7
    x, y = _near(a, b, rng)
    return x.translated(away), y.translated(away)


def _scaled(low: float, high: float) -> Make:
    def make(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
        x, y = _near(a, b, rng)
        factor = 10.0 ** rng.uniform(low, high)
        return x.scaled(factor), y.scaled(factor)

    return make


def _unequal(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    small = some(b, rng, size=10.0 ** rng.uniform(-12, -6))
    return some(a, rng), small.translated(rng.normal(size=2))


def _turned(a: type[Flat], b: type[Flat], rng: Random) -> Scene:
    """Whole numbers, turned: sides are parallel up to rounding."""
    x, y = whole(a, rng), whole(b, rng)
    angle = rng.uniform(0, 6)
    return tuple(s if isinstance(s, Rectangle) else s.rotated(angle) for s in (x, y))  # type: ignore[return-value]


REGIMES: dict[str, Make] = {
    "near": _near,
    "apart": _apart,
    "whole": lambda a, b, rng: (whole(a, rng), whole(b, rng)),
    "turned": _turned,
    "touching": _touching,
    "same centre": _same_center,
    "slivers": _slivers,
    "far": _far,
    "tiny": _scaled(-300, -150),
    "huge": _scaled(100, 300),
    "unequal": _unequal,
}
