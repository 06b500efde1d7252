"""The ellipsoid of least volume around points, by ascent in its dual problem.

Each point has a weight; the ellipsoid that their weighted covariance gives, enlarged, contains all points, and the
greatest determinant of the covariance gives the smallest one (Khachiyan, Rounding of Polytopes in the Real Number Model
of Computation, 1996; with steps away from points that do not matter: Todd and Yıldırım, On Khachiyan's Algorithm for
the Computation of Minimum-Volume Enclosing Ellipsoids, 2007).
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.cloud import Cloud
from refimpl.construct.extreme import centred, dimension, on_hull
from refimpl.construct.formulas import columns_of
from refimpl.construct.membership import across_ellipsoid
from refimpl.construct.outwards import least_above, nearest
from refimpl.construct.sources import ConstructionError, points_of
from refimpl.linear import Array
from refimpl.principal import principal_axes, quaternion_of
from refimpl.proof.vectors import root
from refimpl.shapes import Ellipsoid

STEPS = 20_000
FEW = 512  # points among which weights are searched at a time
CLOSE = 1e-9  # relative distance from the optimality conditions at which the ascent ends


def ellipsoid(points: ArrayLike) -> Ellipsoid:
    """Ellipsoid of least volume around points (n, 3) that do not lie in a plane, its volume within 10⁻⁸ of the least.

    Centre and axes are rounded, and then all radii enlarged by the same factor until every point is inside.

    Raises
    ------
    ConstructionError
        See `points_of`; for coplanar points, around which every ellipsoid can be made flatter; and for one beyond the
        largest double.
    """
    cloud = Cloud(points_of(points))
    inside, middle = centred(cloud)
    if dimension(inside)[0] < 3:
        raise ConstructionError(
            "the points lie in a plane, up to rounding: no ellipsoid is the smallest around them; use a box or capsule"
        )
    size = float(np.max(np.abs(inside)))
    center, shape, _ = least_ellipsoid(on_hull(inside) / size)
    axes, radii = principal_axes(shape)
    return _enlarged(cloud, center * size + middle, radii * size, quaternion_of(axes))


def least_ellipsoid(points: Array) -> tuple[Array, Array, Array]:
    """Centre, matrix that maps the unit ball to the ellipsoid about it, and weights (n,), of sum 1, of the points."""
    low = points.mean(axis=0)
    across, triangle = np.linalg.qr(points - low)  # and not by a covariance, whose squares would drown what is thin
    size = np.sqrt(len(points))
    x, whitening = across * size, triangle.T / size
    lifted = np.concatenate([x, np.ones((len(x), 1))], axis=1)
    weights = _ascended_among(lifted)
    center = weights @ x
    spread = (x - center).T @ ((x - center) * weights[:, None]) * 3
    return whitening @ center + low, np.asarray(whitening @ np.linalg.cholesky(spread)), weights


def _ascended_among(lifted: Array) -> Array:
    """The same weights as of all points, searched among few of them, to which those farthest outside are added."""
    n, d = lifted.shape
    chosen = np.unique(np.concatenate([np.argsort(lifted @ way)[-1:] for way in _ways(d)])) if n > FEW else np.arange(n)
    while True:
        weights = np.zeros(n)
        weights[chosen] = _ascended(lifted[chosen])
        inverse = np.linalg.inv(lifted.T @ (lifted * weights[:, None]))
        leverage = np.einsum("ni,ij,nj->n", lifted, inverse, lifted)
        outside = np.flatnonzero(leverage > d * (1 + 2 * CLOSE))
        if not len(np.setdiff1d(outside, chosen)):
            return weights
        farthest = outside[np.argsort(leverage[outside])[-FEW:]]
        chosen = np.union1d(np.flatnonzero(weights), farthest)


def _ways(dimension: int) -> Array:
    """Directions all around, always the same."""
    return np.random.default_rng(0).normal(size=(FEW, dimension))


def _ascended(lifted: Array) -> Array:
    """Weights that make the determinant of Σ weight·y yᵀ greatest, y being points with a coordinate 1 added."""
    n, d = lifted.shape
    weights = np.full(n, 1 / n)
    inverse = np.linalg.inv(lifted.T @ (lifted * weights[:, None]))
    leverage = np.einsum("ni,ij,nj->n", lifted, inverse, lifted)
    for step in range(1, STEPS):
        far = int(np.argmax(leverage))
        present = np.flatnonzero(weights > 0)
        near = int(present[np.argmin(leverage[present])])
        above, below = leverage[far] / d - 1, 1 - leverage[near] / d
        if max(above, below) <= CLOSE:
            break
        i, kappa = (far, leverage[far]) if above >= below else (near, leverage[near])
        beta = (kappa - d) / (d * (kappa - 1)) if kappa > 1 else -np.inf
        beta = max(beta, -weights[i] / (1 - weights[i])) if i == near and above < below else beta
        weights = weights * (1 - beta)
        weights[i] = max(weights[i] + beta, 0.0)
        if step % 64 == 0:
            inverse = np.linalg.inv(lifted.T @ (lifted * weights[:, None]))
            leverage = np.einsum("ni,ij,nj->n", lifted, inverse, lifted)
            continue
        way = inverse @ lifted[i]
        factor = beta / (1 - beta + beta * kappa)
        inverse = (inverse - factor * np.outer(way, way)) / (1 - beta)
        leverage = (leverage - factor * (lifted @ way) ** 2) / (1 - beta)
    return np.asarray(weights / weights.sum())


def _enlarged(cloud: Cloud, center: Array, radii: Array, rotation: Array) -> Ellipsoid:
    """Ellipsoid with all radii enlarged by one factor, rounded outwards, that contains all points exactly."""
    place = nearest([Fraction(v) for v in center.tolist()], cloud, "centre")
    exact = [cloud.inwards(v) for v in place.tolist()]
    columns, size = columns_of(rotation)
    lengths = [Fraction(v) for v in radii.tolist()]
    ways = [[v / (r * size) for v in way] for way, r in zip(columns, lengths, strict=True)]
    beyond = cloud.greatest(across_ellipsoid(exact, ways)).value + 1
    factor = root(beyond)[1]
    return Ellipsoid(place, [least_above(factor * r, cloud, "ellipsoid") for r in lengths], rotation)
