"""Enclosing spheres: the smallest one exactly, and a fast one that is slightly larger.

The smallest enclosing ball is determined by two to four points that it touches and in whose hull its centre lies
(Welzl, Smallest Enclosing Disks, 1991). It is found by pivoting: the smallest ball of the points so far, then the point
farthest outside, until none is outside (Gärtner, Fast and Robust Smallest Enclosing Balls, 1999). Here every ball is
computed in fractions, so that its radius grows strictly, the search ends, and ends right for every input.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.cloud import Cloud
from refimpl.construct.formulas import Exact, Home, inner, less, square
from refimpl.construct.outwards import least_root, nearest
from refimpl.construct.sources import points_of
from refimpl.linear import Array
from refimpl.shapes import Sphere
from refimpl.shapes.polytopes import USUAL_DIRECTIONS

FEW = 2048  # points outside that are gone through before all are asked again
NEAR = Fraction(1, 1 << 24)  # a ball whose centre moves by less than the root of this, in radii, is beside another
LEAST_RADIUS = 5e-324  # a ball has some radius; around a single point, the least there is


class Ball(NamedTuple):
    """Smallest ball of some points: centre Σ weightᵢ·pointᵢ with weights > 0 of sum 1, and the squared radius."""

    center: Exact
    square: Fraction
    touching: Sequence[int]
    weights: Sequence[Fraction]
    home: Home
    """It, or a ball a little beside it from which distances are known."""


def sphere(points: ArrayLike) -> Sphere:
    """Smallest enclosing sphere: the exact one, its centre rounded and its radius then the least that contains all.

    Parameters
    ----------
    points : (n, 3)
        One point has a sphere of the least radius there is.

    Raises
    ------
    ConstructionError
        See `points_of`; and for a sphere beyond the largest double.
    """
    cloud = Cloud(points_of(points))
    ball = smallest_ball(cloud)
    return around(cloud, nearest(ball.center, cloud, "centre"), ball)


def fast_sphere(points: ArrayLike) -> Sphere:
    """Enclosing sphere from the points that are extreme along 13 directions, and its radius the least for its centre.

    Larsson, Fast and Tight Fitting Bounding Spheres, 2008: the smallest ball of these at most 26 points, moved towards
    what is still outside, so that it just reaches it; a few per cent larger than the smallest at most, in practice.
    """
    cloud = Cloud(points_of(points))
    x, y, z = cloud.columns
    heights = (a * x + b * y + c * z for a, b, c in USUAL_DIRECTIONS[26].tolist())
    extreme = sorted({int(i) for h in heights for i in (np.argmin(h), np.argmax(h))})
    center = _moved_outwards(cloud.columns, extreme)
    return around(cloud, nearest([Fraction(v) for v in center.tolist()], cloud, "centre"))


def _moved_outwards(columns: Array, extreme: list[int]) -> Array:
    """Centre of the ball of the extreme points, grown towards the farthest until it contains all but for rounding."""
    few = columns[:, extreme]
    center, radius = few.mean(axis=1), 0.0
    for step in range(2, 64):  # towards the farthest, ever less far: Bădoiu and Clarkson 2003
        gap = few - center[:, None]
        far = int(np.argmax(gap[0] ** 2 + gap[1] ** 2 + gap[2] ** 2))
        center = center + gap[:, far] / step
    radius = float(np.sqrt(np.max(np.sum((few - center[:, None]) ** 2, axis=0))))
    for _ in range(4):
        gap = columns - center[:, None]
        distance = np.sqrt(gap[0] ** 2 + gap[1] ** 2 + gap[2] ** 2)
        far = int(np.argmax(distance))
        if distance[far] <= radius:
            break
        grown = (radius + distance[far]) / 2
        center = center + gap[:, far] * ((distance[far] - grown) / distance[far])
        radius = float(grown)
    return np.asarray(center)


def around(cloud: Cloud, center: Array, ball: Ball | None = None) -> Sphere:
    """Sphere about a centre in doubles, with the least radius that contains all points; near a ball that is known."""
    place = [cloud.inwards(v) for v in center.tolist()]
    home = Home.at(place, Fraction(0)) if ball is None else ball.home
    farthest = cloud.greatest(home.beside(place, home.square)).value + home.square
    return Sphere(center, max(least_root(farthest, cloud, "sphere"), LEAST_RADIUS))


def smallest_ball(cloud: Cloud) -> Ball:
    """Smallest enclosing ball of a cloud, exactly, in its units; each step is one pass over all points."""
    ball, asked = _ball_of({0: cloud.exact(0)}), set[int]()
    while len(outside := cloud.most_positive(ball.home.beside(ball.center, ball.square), FEW)):
        asked |= set(outside.tolist())
        home, ball = ball.home, _pivoted(ball, cloud, sorted({*asked, *ball.touching}))
        moved = less(ball.center, home.center)
        if inner(moved, moved) <= NEAR * ball.square:
            ball = ball._replace(home=home)
    return ball


def _pivoted(ball: Ball, cloud: Cloud, names: list[int]) -> Ball:
    """Smallest ball of some points, and of those that a ball touches."""
    part = Cloud(cloud.points[names], float(np.ldexp(0.5, cloud.exponent)))
    while True:
        value, far = part.greatest(square(ball.center, ball.square))
        if value <= 0:
            return ball
        ball = _ball_of({i: cloud.exact(i) for i in (*ball.touching, names[far])})


def _ball_of(places: dict[int, Exact]) -> Ball:
    """Smallest ball of at most five points: of all subsets' circumballs that contain them, the one that may be it.

    It is the one whose centre has no negative weight and which contains the others.
    """
    for count in range(1, 5):
        for names in combinations(places, count):
            found = _circumball([places[i] for i in names], names)
            if found is not None and all(
                inner(gap, gap) <= found.square for gap in (less(p, found.center) for p in places.values())
            ):
                return found
    raise AssertionError("some subset of the points determines their smallest ball")


def _circumball(corners: Sequence[Exact], names: Sequence[int]) -> Ball | None:
    """Ball through affinely independent points about a centre in the inside of their hull; None if there is none.

    With edges eᵢ from the first point, the centre Σ wᵢ eᵢ solves eᵢ·Σ wⱼ eⱼ = eᵢ·eᵢ / 2.
    """
    start = corners[0]
    edges = [less(corner, start) for corner in corners[1:]]
    shares = solved([[inner(a, b) for b in edges] for a in edges], [inner(a, a) / 2 for a in edges])
    if shares is None:
        return None
    weights = [1 - sum(shares, Fraction(0)), *shares]
    if min(weights) <= 0:
        return None
    way = [sum((w * e[i] for w, e in zip(shares, edges, strict=True)), Fraction(0)) for i in range(3)]
    center = [a + b for a, b in zip(start, way, strict=True)]
    size = Fraction(inner(way, way))
    return Ball(center, size, tuple(names), weights, Home.at(center, size))


def solved(matrix: list[list[Fraction]], right: list[Fraction]) -> list[Fraction] | None:
    """Solve a system of linear equations exactly, by elimination; None where it is singular."""
    n = len(right)
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for i in range(n):
        pivot = next((k for k in range(i, n) if rows[k][i] != 0), None)
        if pivot is None:
            return None
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [v / rows[i][i] for v in rows[i]]
        for k in range(n):
            if k != i and rows[k][i] != 0:
                rows[k] = [a - rows[k][i] * b for a, b in zip(rows[k], rows[i], strict=True)]
    return [row[n] for row in rows]
