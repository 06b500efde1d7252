"""Shapes adjusted until their union shares as much volume as it can with a solid.

The intersection over union of both is a quotient of sums over boxes that are small at the solid's surface. With the
share of each box that is inside a shape as a smooth function of the height of its centre, it has derivatives by the
shapes' numbers, and a quasi-Newton method climbs; the smoothing is wide at first and as narrow as the boxes in the end.
(Fitting a union to a solid's volume, and moving a shape that helps little to where more is missing: Wang, Zhou, Snyder
et al., Variational Sphere Set Approximation for Solid Objects, 2006; there with the sum of outside volumes.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from refimpl.algorithms.surfaces import points_surface
from refimpl.construct.partition import partition
from refimpl.construct.primitives import LEAST, Family
from refimpl.integrals import surface_integrals
from refimpl.linear import Array, cross, norm, power_of_two
from refimpl.solids import Solid

AROUND = 0.5  # of the solid's longest side: so far around it, what a shape covers is counted
STAGES = (4.0, 1.0)
"""Widths of the smoothing, in edges of the smallest boxes."""
THIN = 49_152
"""Boxes at the surface of thin solids, at most."""
SOFT = 1.5
"""Over so many of its edges a box goes from outside to inside of a shape."""


@dataclass(frozen=True)
class Target:
    """What a union is adjusted to, in a frame in which the solid is of size 1 about the origin.

    Attributes
    ----------
    points, edge, weight : (n, 3), (n,), (n,)
        Centres of boxes, their edges, and their volumes.
    depth : (n,)
        Of the centres in the solid; negative outside.
    middle, exponent : (3,), int
        What is x here is middle + 2^exponent x in the solid's frame.
    """

    points: Array
    edge: Array
    weight: Array
    depth: Array
    middle: Array
    exponent: int

    @cached_property
    def inside(self) -> Array:
        """Share of each box inside the solid, (n,), as if its surface were flat."""
        return np.clip(0.5 + self.depth / self.edge, 0.0, 1.0)

    def own(self, points: Array) -> Array:
        """Points of the solid's frame in this one."""
        return np.ldexp(points - self.middle, -self.exponent)

    @property
    def within(self) -> tuple[Array, Array]:
        """Centres of the boxes that have a share inside, and the volumes of these shares."""
        some = self.inside > 0
        return self.points[some], (self.weight * self.inside)[some]


def target_of(solid: Solid, boxes: int) -> Target:
    """Boxes around a solid, `boxes` of them at most at its surface; or so many that it is thicker than they are."""
    lower, upper = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    size, middle = float(np.max(upper - lower)), lower / 2 + upper / 2
    exponent = int(power_of_two(np.asarray(size)))
    boxes = max(boxes, min(round(_needed(solid, exponent)), THIN))
    found = partition(lambda at, _: points_surface(solid, at)[0], lower - AROUND * size, upper + AROUND * size, boxes)
    edge, depth = np.ldexp(found.edge, -exponent), np.ldexp(-found.value, -exponent)
    return Target(np.ldexp(found.center - middle, -exponent), edge, edge**3, depth, middle, exponent)


def _needed(solid: Solid, exponent: int) -> float:
    """How many cubes as large as the mean thickness 2 V / A surround a surface: about 2 A / (2 V / A)²."""
    corners = np.ldexp(solid.corners - solid.corners[0, 0], -exponent)
    area = float(np.sum(norm(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])))) / 2
    return area**3 / (2 * float(surface_integrals(corners)[0]) ** 2)


def loss_of(family: Family, rows: Array, target: Target, width: float) -> tuple[float, Array]:
    """One minus the smoothed intersection over union, and its derivatives by the rows."""
    heights = family.heights(rows, target.points)
    nearest = np.argmin(heights, axis=1)
    loss, by_height = loss_at(target, heights[np.arange(len(nearest)), nearest], width)
    near = np.flatnonzero(by_height)
    which = nearest[near]
    slopes = family.slopes(rows[which], target.points[near]) * by_height[near, None]
    return loss, np.stack([np.bincount(which, column, len(rows)) for column in slopes.T], axis=1)


def loss_at(target: Target, height: Array, width: float) -> tuple[float, Array]:
    """The loss from the heights of all centres over a union, and its derivatives by these.

    Sets that are smoothed alike have the Tanimoto coefficient Σ os / Σ (o² + s² − os), which is the intersection over
    union where nothing is smoothed, and 1 for equal sets only, however much is.
    """
    blur = SOFT * np.maximum(target.edge, width * np.min(target.edge))
    wanted, _ = _share(-target.depth / blur)
    share, slope = _share(height / blur)
    common = float(target.weight @ (wanted * share))
    union = float(target.weight @ (wanted * wanted + share * share)) - common
    by_share = -target.weight * (wanted * union - common * (2 * share - wanted)) / union**2
    return 1 - common / union, by_share * slope / blur


def _share(height: Array) -> tuple[Array, Array]:
    """Smoothed share of a box inside, from the height of its centre; and the derivative."""
    depth = np.clip(0.5 - height, 0.0, 1.0)
    return depth * depth * (3 - 2 * depth), -6 * depth * (1 - depth)


def adjusted(family: Family, rows: Array, target: Target, rounds: int) -> tuple[Array, float]:
    """Rows that have been adjusted to a target, and the loss that is left.

    Parameters
    ----------
    rows : (k, w)
    rounds : int
        Iterations of each stage, at most.
    """
    from scipy.optimize import minimize  # noqa: PLC0415  not needed by those who only ask for distances

    bounds: list[tuple[float | None, None]] = [(None, None)] * rows.shape[1]
    bounds[family.lengths] = [(LEAST, None)] * len(bounds[family.lengths])
    loss = np.inf
    for width in STAGES:
        asked = _flat(family, rows.shape, target, width)
        found = minimize(
            asked, rows.ravel(), jac=True, method="L-BFGS-B", bounds=bounds * len(rows), options={"maxiter": rounds}
        )
        rows, loss = found.x.reshape(rows.shape), float(found.fun)
    return rows, loss


def _flat(
    family: Family, shape: tuple[int, ...], target: Target, width: float
) -> Callable[[Array], tuple[float, Array]]:
    def asked(numbers: Array) -> tuple[float, Array]:
        loss, slopes = loss_of(family, numbers.reshape(shape), target, width)
        return loss, slopes.ravel()

    return asked
