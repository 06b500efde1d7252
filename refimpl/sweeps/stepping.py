"""Static detection of moving proxies: they are put where they are at each time step, and tested there.

That is what the lecture calls static, in contrast to dynamic detection, `refimpl.sweep`. Between two steps nothing is
looked at: a ball of diameter d tunnels through a wall of thickness w when it moves by more than d + w in a step and the
steps happen to fall before and behind it. `reports/studies/README.md` shows when that happens.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from refimpl.linear import Array, Bools
from refimpl.motions import Motion, as_motion
from refimpl.proxy import Proxy
from refimpl.queries import intersect


@dataclass(frozen=True)
class SteppedHit:
    """What stepping sees of two moving proxies.

    Attributes
    ----------
    hit : (...) bool
        Whether they overlap at one of the times looked at. False proves nothing.
    t : (...)
        The first such time, not before the first contact; inf if there is none.
    """

    hit: Bools
    t: Array


def stepped(
    a: Proxy, b: Proxy, motion_a: Motion | None = None, motion_b: Motion | None = None, *, steps: int
) -> SteppedHit:
    """Test two moving proxies for overlap at the times 0, 1/steps, 2/steps, …, 1.

    Parameters
    ----------
    a, b : proxies that `intersect` takes
    motion_a, motion_b : Translation, RigidMotion or None
        None rests. All batch shapes broadcast against each other.
    steps : at least 1

    Raises
    ------
    ValueError
        For less than one step.
    UnsupportedOperation
        For a proxy that cannot be turned, with a `RigidMotion`, and for what `intersect` does not take.
    """
    if steps < 1:
        raise ValueError(f"steps: at least 1, got {steps}")
    from_a, from_b = as_motion(motion_a, a.dimension), as_motion(motion_b, b.dimension)
    shapes = [part.batch_shape for part in (a, b, from_a, from_b)]
    first = np.full(np.broadcast_shapes(*shapes), np.inf)
    for k in range(steps + 1):
        t = k / steps
        overlap = intersect(from_a.placed(a, t), from_b.placed(b, t))
        first = np.where(overlap & np.isinf(first), t, first)
    return SteppedHit(np.isfinite(first)[()], first[()])
