"""View-frustum culling: which proxies a frustum cannot show, and never one that it can.

A bounding volume that lies beyond one of the six planes is culled: six support functions, in doubles with a bound on
their error, and in rational numbers where that leaves a doubt. What lies beyond an edge of the frustum is beyond no
plane, so that some of what is not shown is kept; `shows` asks the pair table about the rest.
"""

from __future__ import annotations

import numpy as np

from refimpl.bounds import SLACK
from refimpl.linear import Array, Bools
from refimpl.proof import Certificate, InvalidCertificate, certify, check
from refimpl.proof.points import round_down
from refimpl.proof.sweep_search import separated
from refimpl.proxy import Proxy, ShapeError
from refimpl.queries import distance, intersect
from refimpl.shapes import Composite, ConvexPolyhedron, HalfSpace, Polyhedron, Ray
from refimpl.signs import Indices
from refimpl.supports import support

NONE = -1


def culled_by(frustum: ConvexPolyhedron, volumes: Proxy) -> Indices:
    """Plane of a frustum beyond which volumes lie, without touching it; one of them where there are several.

    Parameters
    ----------
    frustum : ConvexPolyhedron
        A single one of planes, in the world's frame.
    volumes : proxies that have a support function, with any batch axes
        A union counts as its hull.

    Returns
    -------
    (...) int64
        Number of the plane, or −1: it is not known to be out of view.

    Raises
    ------
    ShapeError
        For a frustum that is none, and for what is no solid or point of space.
    """
    planes = planes_of(frustum)
    if not isinstance(volumes, Proxy) or isinstance(volumes, Ray) or volumes.dimension != 3:
        raise ShapeError(f"volumes: expected solids or points of space, got {type(volumes).__name__}")
    flat = volumes.flattened()
    found = np.full(len(flat), NONE)
    size = flat.magnitude
    doubt = []
    for number, (n, k) in enumerate(zip(planes[:, :3], planes[:, 3], strict=True)):
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            height = k - support(flat, -n)
            slack = 2 * SLACK * (np.sum(np.abs(n)) * size + np.abs(k))
            found[(found == NONE) & (height > slack)] = number
            doubt.append((number, np.flatnonzero(np.abs(height) <= slack)))
    for number, rows in doubt:
        for row in rows[found[rows] == NONE].tolist():
            plane = planes[number]
            if _between(HalfSpace(plane[:3], plane[3]), flat[row], plane) is not None:
                found[row] = number
    return found.reshape(volumes.batch_shape)


def shows(frustum: ConvexPolyhedron, volumes: Proxy) -> Bools:
    """Whether volumes have a point in the frustum; where rounding leaves a doubt, they are said to.

    Parameters and shapes are those of `culled_by`.
    """
    kept = np.asarray(culled_by(frustum, volumes) == NONE)
    flat, rows = volumes.flattened(), np.flatnonzero(kept)
    away = rows[~intersect(frustum, flat[rows])] if len(rows) else rows
    if len(away):
        apart = distance(frustum, flat[away]).distance
        slack = SLACK * (float(frustum.magnitude) + flat[away].magnitude)
        kept.reshape(-1)[away[apart > slack]] = False
    return kept


def proof_of_absence(frustum: ConvexPolyhedron, volume: Proxy) -> Certificate | None:
    """Certificate that no point of a single volume is in the frustum: its lower bound is above 0. None without one."""
    culled = culled_by(frustum, volume)
    if culled.shape:
        raise ShapeError(f"volume: expected a single proxy, got a batch of shape {culled.shape}")
    number = int(culled)
    if number == NONE:
        found = certify(frustum, volume)
        return found if found.lower > 0 else None
    return _between(frustum, volume, planes_of(frustum)[number])


def _between(frustum: ConvexPolyhedron | HalfSpace, volume: Proxy, plane: Array) -> Certificate | None:
    """Certificate that a plane's normal separates the two, with a bound above 0 from exact arithmetic; None without."""
    if isinstance(volume, Composite | Polyhedron):  # whose certificates name their parts
        found = certify(frustum, volume)
    else:
        claims = (separated(frustum, volume, tuple(plane[:3].tolist())),)
        try:
            found = Certificate(claims, round_down(check(Certificate(claims), frustum, volume)[0]))
        except InvalidCertificate:
            return None
    return found if found.lower > 0 else None


def planes_of(frustum: ConvexPolyhedron) -> Array:
    """Planes (m, 4) of a frustum, which must be where its planes say; raises ShapeError for anything else."""
    if not isinstance(frustum, ConvexPolyhedron):
        raise ShapeError(f"frustum: expected a ConvexPolyhedron of planes, got {type(frustum).__name__}")
    placed = np.any(frustum.position != 0) or np.any(frustum.rotation[..., :3] != 0)
    if frustum.batch_shape or frustum.given != "planes" or placed:
        raise ShapeError("frustum: expected a single ConvexPolyhedron of planes that is neither moved nor turned")
    return frustum.numbers
