"""Placements: how two bodies stand to each other, and by how much they are apart.

Some are arrangements of the bodies in the making; others move the finished second proxy along the normal, until it
is as far from the first as was drawn; some do both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oracles.bodies import IDENTITY, Body
from oracles.builds import Bodies
from oracles.draws import Draws
from oracles.reference import UNIONS
from oracles.world import world_of
from refimpl import HalfSpace, Proxy, Ray, distance
from refimpl.linear import Array, Bools, apply, dot, norm, quaternion_product, rotation_matrix, scale

STEPS = 4
"""Unions are moved in so many steps: past one piece, there may be the next."""
ANGLES = (0.0, 1e-1, 1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-11, 1e-13, 1e-15, 1.0)

Pair = tuple[Proxy, Proxy]
Gap = tuple[Array, Bools]
"""Signed distances, in the bodies' unit, and the rows that are to have them; the others stay as they are."""


@dataclass(frozen=True)
class Placement:
    """How two bodies stand to each other.

    Attributes
    ----------
    reason
        Why it exists.
    arrange
        Puts the bodies where they are to be, but for the gap.
    gap
        Draws the gap; None leaves it to chance.
    faces
        Whether two half-spaces face each other; without that their distance is nearly never finite.
    """

    reason: str
    arrange: Callable[[Draws, Body, Body], Bodies] | None = None
    gap: Callable[[Draws], Gap] | None = None
    faces: bool = False


@dataclass(frozen=True)
class Draft:
    """A pair before it is moved to the gap that was drawn for it; the second proxy moves, where `moved` says so."""

    a: Proxy
    b: Proxy
    gap: Array
    moved: Bools

    def settled(self) -> Pair:
        """Move B along the normal until the signed distance is about `gap`; pairs without end stay."""
        b, rows = self.b, np.flatnonzero(self.moved)
        for _ in range(STEPS if isinstance(self.a, UNIONS) or isinstance(b, UNIONS) else 1):
            if not rows.size:
                break
            sigma, normal = signed_gap(self.a[rows], b[rows])
            ends = np.isfinite(sigma)
            move = np.where(ends, self.gap[rows] - np.where(ends, sigma, 0.0), 0.0)
            shift = np.zeros_like(b.reference_point)
            shift[rows] = scale(move, np.where(ends[:, None], normal, 0.0))
            b = b.translated(shift)
            rows = rows[np.abs(move) > 1e-12 * b.magnitude[rows]]
        return self.a, b


def signed_gap(a: Proxy, b: Proxy) -> tuple[Array, Array]:
    """Signed distance and normal; a ray counts as a segment that reaches past the other."""
    if isinstance(a, Ray):
        far = 2.0 + (norm(b.reference_point - a.origin) + 4.0 * b.magnitude) / norm(a.direction)
        a = world_of(a).rounded(a.origin, a.at(far), np.zeros(len(a)))
    found = distance(a, b)
    return found.distance, found.normal


def facing(a: Proxy, b: Proxy) -> Pair:
    """Turn a second half-space exactly against the first: only then is their distance finite."""
    if isinstance(a, HalfSpace) and isinstance(b, HalfSpace):
        place = b.reference_point
        normal = -2.0 * a.normal
        return a, HalfSpace(normal, -dot(normal, place))
    return a, b


# -- gaps ----------------------------------------------------------------------------------------------------


def _everywhere(gap: Array) -> Gap:
    return gap, np.ones(len(gap), dtype=bool)


def _none(draws: Draws) -> Gap:
    return _everywhere(np.zeros(draws.n))


def _of_all_decades(draws: Draws) -> Gap:
    return _everywhere(
        10.0 ** -draws.choice(range(1, 16)) * draws.choice((1.0, -1.0)) * draws.uniform(1.0, 9.0),
    )


def _close(draws: Draws) -> Gap:
    moved = draws.choice((0.0, 1.0, 1.0)) == 1
    return draws.choice((0.1, 1.0)) * draws.uniform(-1.0, 1.0), moved


def _little_or_loose(draws: Draws) -> Gap:
    gap = draws.choice((0.0, 1.0, 1e-9, -1e-9, 1e-3, -1e-3)) * draws.uniform(0.1, 1.0)
    return gap, draws.choice((0.0, 1.0)) == 0


def _of_a_stack(draws: Draws) -> Gap:
    return _everywhere(draws.choice((0.0, 1e-12, -1e-12, 1e-6, -1e-6, 1e-3, -1e-3, 0.5)))


# -- arrangements --------------------------------------------------------------------------------------------


def _inside(draws: Draws, a: Body, b: Body) -> Bodies:
    offset = scale(draws.uniform(0.0, 0.5), draws.uniform(-1.0, 1.0, 3)) * a.extents
    return a, replace(b, place=a.place + offset)


def _centred(draws: Draws, a: Body, b: Body) -> Bodies:
    same_size, same_pose = draws.choice((1.0, 0.0)) == 1, draws.choice((1.0, 0.0)) == 1
    extents = np.where(same_size[:, None] & (a.extents > 0), a.extents, b.extents)  # not every type can be flat
    rotation = np.where(same_pose[:, None], a.rotation, b.rotation)
    return a, replace(b, place=a.place, extents=extents, rotation=rotation)


def _nearly_parallel(draws: Draws, a: Body, b: Body) -> Bodies:
    """Turn the second by nothing, by a tiny angle or by more, about an axis of the first."""
    upright = draws.choice((0.0, 1.0)) == 1
    rotation = np.where(upright[:, None], IDENTITY, a.rotation)
    angle = draws.choice(ANGLES)
    axis = np.eye(3)[draws.choice((0, 1, 2)).astype(int)]
    turn = np.concatenate([scale(angle / 2, axis), np.ones((draws.n, 1))], axis=-1)
    near = a.place + scale(draws.choice((1.0, 2.0, 0.0)), b.place)
    return replace(a, rotation=rotation), replace(b, rotation=quaternion_product(rotation, turn), place=near)


def _stacked(draws: Draws, a: Body, b: Body) -> Bodies:
    axis = draws.choice((2, 0, 1)).astype(int)
    along = np.arange(3) == axis[:, None]
    offset = np.where(along, scale(draws.choice((1.0, -1.0)), a.extents + b.extents), 0.0)
    slide = np.where(along, 0.0, draws.choice((0.0, 0.5, -0.25, 1.0), 3))
    upright = np.broadcast_to(IDENTITY, a.rotation.shape)
    return replace(a, rotation=upright), replace(b, place=a.place + offset + slide, rotation=upright)


def _on_the_surface(draws: Draws, a: Body, b: Body) -> Bodies:
    axis, side = draws.choice((0, 1, 2)), draws.choice((1.0, -1.0))
    way = np.where(np.arange(3) == axis[:, None], scale(side, b.extents), 0.0)
    return replace(a, place=b.place + apply(rotation_matrix(b.rotation), way), back=np.zeros(draws.n)), b


FREE = Placement("Wherever chance puts them: apart, across each other, one in the other.")
NEAR = Placement("Up to a tenth of the unit, or the unit, apart or inside: the other's surface is close.", gap=_close)

PLACEMENTS: dict[str, Placement] = {
    "free": FREE,
    "near": NEAR,
    "touching": Placement("At distance 0 up to rounding: resting contact, where a boolean flips.", gap=_none),
    "nearly_touching": Placement(
        "Gaps and overlaps of 1e-1 to 1e-15: below an engine's tolerances and margins.", gap=_of_all_decades
    ),
    "deep": Placement("One inside the other or nearly so: many faces compete for the least depth.", _inside),
    "concentric": Placement(
        "Equal centres, equal or turned poses, equal or other sizes: no direction is preferred.", _centred
    ),
    "on_surface": Placement(
        "The first's centre, where a ray starts, on the other's surface: neither outside nor inside.", _on_the_surface
    ),
    "parallel_edges": Placement(
        "Edges parallel or at angles down to 1e-15: cross products vanish or lose their digits.",
        _nearly_parallel,
        _little_or_loose,
        faces=True,
    ),
    "face_on_face": Placement(
        "Stacked squarely, with a gap or overlap of 0 or a little: whole faces are nearest.",
        _stacked,
        _of_a_stack,
        faces=True,
    ),
}
