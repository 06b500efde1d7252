"""Dynamic detection: when two moving proxies first meet.

`sweep` is the door. Translations are answered in `translations`, rigid motions in `rigid`, unions of either in
`unions`; `swept` is the volume that a proxy sweeps in translation. `stepped` is static detection, to compare with.
`vertex_face` and `edge_edge` are of moving triangles, whose corners move each in its own way: decided exactly.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from refimpl.flat.base import Flat
from refimpl.flat.sweeps import sweep_flat
from refimpl.motions import Motion, RigidMotion, as_motion
from refimpl.pairs import TABLE
from refimpl.proxy import Proxy, ShapeError, UnsupportedOperation
from refimpl.results import SweepHit
from refimpl.shapes import Point, Ray
from refimpl.sweeps.stepping import SteppedHit, stepped
from refimpl.sweeps.swept import SweptShape, swept
from refimpl.sweeps.translations import decided, doubts, earliest, in_doubles, sweep_translation
from refimpl.sweeps.unions import UNIONS, Convex, over_pieces

__all__ = ["SteppedHit", "SweepHit", "SweptShape", "Touch", "edge_edge", "stepped", "sweep", "swept", "vertex_face"]

if TYPE_CHECKING:
    from refimpl.sweeps.triangles import Touch, edge_edge, vertex_face
else:

    def __getattr__(name: str) -> object:
        """Import what is of moving triangles when it is first named: it brings all proofs with it."""
        if name in ("Touch", "edge_edge", "vertex_face"):
            return getattr(import_module("refimpl.sweeps.triangles"), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


@np.errstate(under="ignore")
def sweep(a: Proxy, b: Proxy, motion_a: Motion | None = None, motion_b: Motion | None = None) -> SweepHit:
    """First time from 0 to 1 at which two moving proxies have a point in common.

    Parameters
    ----------
    a, b : solids, or a point and a solid, in either order
    motion_a, motion_b : Translation, RigidMotion or None
        None rests. All batch shapes broadcast against each other.

    Returns
    -------
    SweepHit
        Touching and grazing counts as contact; proxies that overlap from the start meet at t = 0. One row of a batch
        is answered to the last bit as the pair alone.

    Raises
    ------
    UnsupportedOperation
        For rays, and for two points.
    ShapeError
        Where batch shapes do not broadcast.

    Notes
    -----
    Translations are answered by the cast of a ray where the difference of the proxies is one itself, and by Newton's
    method on the signed distance elsewhere: the time is exact up to the rounding of the places, which
    `refimpl.proof.certify_sweep` overcomes. Rigid motions advance conservatively, unions by their convex pieces.
    """
    for shape in (a, b):
        if not isinstance(shape, Proxy):
            raise TypeError(f"sweep needs two proxies, got {type(shape).__name__}: {shape!r}")
        if isinstance(shape, Ray):
            raise UnsupportedOperation("a Ray does not move: sweep a Point, or use raycast")
    if isinstance(a, Point) and isinstance(b, Point):
        raise UnsupportedOperation("sweep: Point against Point is not a cell of the pair table")
    if a.dimension != b.dimension:
        raise UnsupportedOperation(f"sweep: a {type(a).__name__} is of another world than a {type(b).__name__}")
    from_a, from_b = as_motion(motion_a, a.dimension), as_motion(motion_b, b.dimension)
    shapes = [part.batch_shape for part in (a, b, from_a, from_b)]
    try:
        batch = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ShapeError(f"batch shapes {', '.join(map(str, shapes))} do not broadcast") from None
    x, y = (shape.broadcast_to(batch).flattened() for shape in (a, b))
    found = _flat(x, y, *(motion.broadcast_to(batch).flattened() for motion in (from_a, from_b)))
    t, point, normal, early = (
        column.reshape(batch + column.shape[1:])[()] for column in (found.t, found.point, found.normal, found.t_lower)
    )
    return SweepHit(found.hit.reshape(batch)[()], t, point, normal, early)


def _flat(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> SweepHit:
    """Sweep proxies with one batch axis."""
    if isinstance(x, Flat):
        return sweep_flat(x, y, motion_x, motion_y)
    if isinstance(motion_x, RigidMotion) or isinstance(motion_y, RigidMotion):
        from refimpl.sweeps.rigid import sweep_rigid  # noqa: PLC0415  what only rotations need

        return sweep_rigid(x, y, motion_x, motion_y)
    if isinstance(x, UNIONS) or isinstance(y, UNIONS):
        found = over_pieces(x, y, motion_x, motion_y, _possible, earliest)
        return decided(found, doubts(found, x, y, motion_x, motion_y), x, y, motion_x, motion_y)
    return _in_order(sweep_translation, x, y, motion_x, motion_y)


def _possible(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> SweepHit:
    """Sweep convex pieces in doubles: about what is in doubt, the whole decides."""
    return _in_order(lambda *moving: in_doubles(*moving)[0], x, y, motion_x, motion_y)


def _in_order(function: Convex, x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> SweepHit:
    """Sweep convex proxies in the order of the pair table."""
    if (type(x), type(y)) in TABLE:
        return function(x, y, motion_x, motion_y)
    found = function(y, x, motion_y, motion_x)
    return SweepHit(found.hit, found.t, found.point, -found.normal, found.t_lower)
