"""Smallest enclosing circle of points in a plane, in doubles: it only proposes (Welzl 1991, by farthest points)."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from refimpl.linear import Array

Place = tuple[float, float]
ROUNDS = 64
CLOSE = 1 + 1e-12


def smallest_circle(x: Array, y: Array) -> tuple[Place, float]:
    """Centre and radius of a circle about points of coordinates (n,) and (n,) that is the smallest, up to rounding."""
    center: Place = (float(x[0]), float(y[0]))
    corners, radius = [center], 0.0
    for _ in range(ROUNDS):
        square = (x - center[0]) ** 2 + (y - center[1]) ** 2
        far = int(np.argmax(square))
        place = (float(x[far]), float(y[far]))
        if square[far] <= radius * radius * CLOSE or place in corners:
            break
        center, radius, corners = _of_few([*corners, place])
    return center, radius


def _of_few(places: list[Place]) -> tuple[Place, float, list[Place]]:
    """Smallest circle of at most four points, by all pairs and triples, and the points that it touches."""
    best = places[0], math.inf, places
    for count in (2, 3):
        for chosen in combinations(places, count):
            center = _center(chosen)
            if center is None:
                continue
            radius = math.dist(chosen[0], center)
            if radius < best[1] and all(math.dist(place, center) <= radius * CLOSE for place in places):
                best = center, radius, list(chosen)
    return best


def _center(corners: tuple[Place, ...]) -> Place | None:
    """Centre of the circle through two points as a diameter, or through three; None where these are collinear."""
    (x, y), *rest = corners
    edges = [(u - x, v - y) for u, v in rest]
    if len(edges) == 1:
        return x + edges[0][0] / 2, y + edges[0][1] / 2
    (a, b), (c, d) = edges
    twice = 2 * (a * d - b * c)
    if twice == 0:
        return None
    p, q = a * a + b * b, c * c + d * d
    return x + (d * p - b * q) / twice, y + (a * q - c * p) / twice
