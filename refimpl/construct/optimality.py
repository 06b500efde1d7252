"""Proofs of how small bounding volumes can be, each verified by a few lines of exact arithmetic.

That a volume contains all points is decided by `contains`. That no smaller one does is proven here, by weights on a few
of the points: a *dual* bound, which holds whatever the weights are, so that their search need not be believed.

For weights λᵢ ≥ 0 of sum 1, mean m = Σ λᵢ xᵢ and covariance C = Σ λᵢ (xᵢ − m)(xᵢ − m)ᵀ of the points:

* A ball about c with radius r contains them, so r² ≥ Σ λᵢ ‖xᵢ − c‖² = tr C + ‖m − c‖² ≥ tr C. The bound is reached when
  the points with weights lie on the sphere and m = c: the centre lies in the hull of the touching points.
* An ellipsoid (x − c)ᵀ A (x − c) ≤ 1 contains them, so 1 ≥ Σ λᵢ (xᵢ − c)ᵀ A (xᵢ − c) ≥ tr(A C) ≥ 3 det(A C)^(1/3), by
  the means of eigenvalues, so that its volume is at least that of the unit ball times √(27 det C). It is reached under
  John's conditions: points with weights lie on its surface, c = m, and A⁻¹ = 3 C (John, Extremum Problems with
  Inequalities as Subsidiary Conditions, 1948; Todd, Minimum-Volume Ellipsoids, 2016, ch. 2).
* A box with half extents hᵢ along axes uᵢ contains them, so hᵢ² ≥ uᵢᵀ C uᵢ, and its volume is at least 8 √(det C), for
  the product of a matrix's diagonal is not below its determinant (Hadamard). Reached by the corners of a box.
* A cylinder of radius r and half height h contains them, so r² ≥ u₁ᵀ C u₁ + u₂ᵀ C u₂ and h² ≥ u₃ᵀ C u₃, and its volume
  is at least 4π √(det C), by the means of the first two. Reached by the two rims of a cylinder.
* A capsule of radius r lies in a cylinder of half height h ≥ r and has the volume 2π r² (h − r/3), at least 2/3 of it.

And no convex volume is smaller than the hull.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.balls import smallest_ball
from refimpl.construct.cloud import Cloud
from refimpl.construct.ellipsoids import least_ellipsoid
from refimpl.construct.extreme import centred, on_hull
from refimpl.construct.polytopes import hull
from refimpl.construct.sources import ConstructionError, points_of
from refimpl.linear import Array
from refimpl.mass import mass_properties
from refimpl.proof.points import round_down
from refimpl.proof.vectors import root
from refimpl.proxy import Proxy
from refimpl.shapes import KDOP, Box, Capsule, Cylinder, Ellipsoid

Exact = Sequence[Fraction]


@dataclass(frozen=True)
class Weights:
    """Some of the points and their weights > 0, up to a common factor."""

    points: tuple[int, ...]
    weights: tuple[Fraction, ...]


def moments(points: Array, proof: Weights) -> tuple[list[Fraction], list[list[Fraction]]]:
    """Mean and covariance of weighted points, exactly; refuses weights that are none."""
    total = sum(proof.weights, Fraction(0))
    if len(proof.points) != len(proof.weights) or min(proof.weights, default=Fraction(0)) <= 0:
        raise ConstructionError("a proof consists of points and as many weights greater than 0")
    if min(proof.points) < 0 or max(proof.points) >= len(points):
        raise ConstructionError(f"a proof names points from 0 to {len(points) - 1}")
    chosen = [[Fraction(v) for v in points[i].tolist()] for i in proof.points]
    parts = [w / total for w in proof.weights]
    mean = [sum((w * x[i] for w, x in zip(parts, chosen, strict=True)), Fraction(0)) for i in range(3)]
    gaps = [[a - b for a, b in zip(x, mean, strict=True)] for x in chosen]
    spread = [
        [sum((w * g[i] * g[j] for w, g in zip(parts, gaps, strict=True)), Fraction(0)) for j in range(3)]
        for i in range(3)
    ]
    return mean, spread


def prove_sphere(points: ArrayLike) -> Weights:
    """Find the touching points of the smallest enclosing sphere, and the weights that make its centre their mean."""
    ball = smallest_ball(Cloud(points_of(points)))
    return Weights(tuple(ball.touching), tuple(ball.weights))


def check_sphere(points: ArrayLike, proof: Weights) -> Fraction:
    """Square below which the squared radius of no enclosing sphere is: the trace of the covariance."""
    _, spread = moments(np.asarray(points, dtype=np.float64), proof)
    return spread[0][0] + spread[1][1] + spread[2][2]


def prove_ellipsoid(points: ArrayLike) -> Weights:
    """Find weights that nearly meet John's conditions, by the search that finds the ellipsoid."""
    cloud = Cloud(points_of(points))
    inside = centred(cloud)[0]
    corners = on_hull(inside)
    names = _names_of(inside, corners)
    weights = least_ellipsoid(corners / float(np.max(np.abs(corners))))[2]
    kept = np.flatnonzero(weights > 1e-12)
    return Weights(tuple(int(names[i]) for i in kept), tuple(Fraction(float(weights[i])) for i in kept))


def _names_of(points: Array, chosen: Array) -> Array:
    """Which points the chosen rows are."""
    place = {row.tobytes(): i for i, row in enumerate(points)}
    return np.array([place[row.tobytes()] for row in chosen])


def check_ellipsoid(points: ArrayLike, proof: Weights) -> Fraction:
    """Number below which the squared product of the radii of no enclosing ellipsoid is: 27 det C."""
    _, c = moments(np.asarray(points, dtype=np.float64), proof)
    return 27 * (
        c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1])
        - c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0])
        + c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0])
    )


def excess_of_ellipsoid(found: Ellipsoid, bound: Fraction) -> float:
    """How much larger an ellipsoid's volume may be than the least, relative to it; from above."""
    product = math.prod((Fraction(r) for r in found.radii.tolist()), start=Fraction(1))
    ratio = root(product * product / bound)[1]
    return -round_down(-(ratio - 1))


def least_volume(points: ArrayLike, kind: type[Proxy], proof: Weights) -> float:
    """Volume below which no box, capsule or cylinder around points is: by their weights, or by their hull.

    The hull's volume is rounded; so the bound holds up to 10⁻¹³ of it.

    Parameters
    ----------
    points : (n, 3)
    kind : Box, Capsule or Cylinder
    proof : Weights
        Any; those of `prove_ellipsoid` make the bound greatest.

    Raises
    ------
    ConstructionError
        For another kind, and for weights that are none.
    """
    if kind not in SHARES:
        raise ConstructionError(
            f"bounds are known for {', '.join(k.__name__ for k in SHARES)}, not for {kind.__name__}"
        )
    by_weights = SHARES[kind] * float(root(check_ellipsoid(points, proof) / 27)[0])
    return max(by_weights, float(mass_properties(hull(points)).volume))


SHARES: dict[type[Proxy], float] = {Box: 8.0, Cylinder: 4 * math.pi, Capsule: 8 / 3 * math.pi}
"""Least volumes around weighted points, in units of the root of their covariance's determinant."""


def check_touching(points: ArrayLike, found: KDOP, names: Sequence[tuple[int, int]]) -> bool:
    """Whether no bound of a k-DOP could be a double farther inwards, by the points that it would cut off.

    Parameters
    ----------
    points : (n, 3)
    found : KDOP
    names : for each slab the point that touches its lower, and the one that touches its upper bound
    """
    given = np.asarray(points, dtype=np.float64)
    for way, low, high, (i, j) in zip(
        found.directions.tolist(), found.lower.tolist(), found.upper.tolist(), names, strict=True
    ):
        least, most = (
            sum(Fraction(a) * Fraction(b) for a, b in zip(way, given[k].tolist(), strict=True)) for k in (i, j)
        )
        if not Fraction(low) <= least < Fraction(math.nextafter(low, math.inf)):
            return False
        if not Fraction(math.nextafter(high, -math.inf)) < most <= Fraction(high):
            return False
    return True
