"""Clouds of points that tests of bounding volumes share, and whether a point lies in a proxy, as the checker reads."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np

from refimpl.proof import InvalidCertificate
from refimpl.proof.reading import read
from refimpl.proof.sets import Hull

TURN = np.array([0.3, -0.2, 0.5, 0.7])


def clouds(count: int = 16) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(7)
    ball = rng.normal(size=(count, 3))
    on_sphere = ball / np.linalg.norm(ball, axis=1)[:, None]
    t = rng.random(count)
    return {
        "random": ball,
        "on a sphere": on_sphere,
        "cospherical": np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.1 + 0.7,
        "coplanar": np.stack([t, 1 - t, rng.random(count)], axis=1),
        "coplanar grid": np.array([[x, y, 7.0] for x in range(5) for y in range(5)]),
        "collinear": np.outer(t, [1.0, 2.0, 3.0]),
        "along an axis": np.stack([np.ones(count), t, np.full(count, 2.0)], axis=1),
        "one": np.array([[0.1, 0.2, 0.3]]),
        "one, many times": np.full((count, 3), 0.1),
        "two": np.array([[0.1, 0.2, 0.3], [0.4, 0.2, -0.7]]),
        "far away": ball + 1e9,
        "farther than it is wide": ball + 1e16,
        "tiny": ball * 1e-300,
        "denormal": ball * 1e-320,
        "huge": ball * 1e300,
        "of three scales": ball * [1e150, 1.0, 1e-150],
    }


CLOUDS = clouds()


def lies_in(proxy, point) -> bool:
    """By the checker's reading, in fractions."""
    solid = read(proxy)
    if isinstance(solid, Hull):
        return all(lies_behind(plane, point) for plane in exact_sides(proxy))
    try:
        return solid.member(tuple(float(v) for v in point), True)[1] == 0
    except InvalidCertificate:
        return False


def exact_sides(proxy):
    """Planes of a solid hull that pass through three of its corners, by brute force over all triples."""
    v = [[Fraction(x) for x in row] for row in proxy.vertices.tolist()]
    for a, b, c in combinations(v, 3):
        n = np.cross(np.array(b) - a, np.array(c) - a)
        heights = [sum(n * (np.array(x) - a)) for x in v]
        for side in (1, -1):
            if any(n) and all(side * h <= 0 for h in heights):
                yield Plane(side * n, side * sum(n * np.array(a)))


class Plane:
    def __init__(self, n, level):
        self.n, self.level = n, level


def lies_behind(plane: Plane, point) -> bool:
    return sum(n * Fraction(x) for n, x in zip(plane.n, point.tolist(), strict=True)) <= plane.level


def matrix_of(q):
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
