"""Signed distances of points from the solid that a triangle surface bounds."""

from __future__ import annotations

from collections.abc import Sequence

from . import kernel
from .axes import three
from .polytopes import Row, Scratch
from .surface import OUTWARD, foot_on_face, nearest_face, outward_at
from .vectors import Vector, length, minus
from .windings import inside

Spot = tuple[float, Vector, Vector, int, bool]
"""Signed distance of a point; unit normal, outwards, at the nearest point of the surface; that point; where its face is
in the row; whether it is certain on which side of the surface the point is."""
SPOT = 9
"""The same as a row: distance, normal, point, 1 or 0 for certain or not, place of the face."""


@kernel
def height(row: Row, p: Vector, side: int, stack: Scratch) -> Spot:
    """Signed distance of a point that is outside (`side` 1), inside (−1), or one of both (0), which is then found out.

    Inside, the shortest way out ends at the nearest point of the surface, so this is exact on both sides.
    """
    at = nearest_face(row, p, stack)
    foot = foot_on_face(row, at, p)
    gap = length(minus(p, foot))
    sure = True
    if gap == 0.0:
        return 0.0, three(row, at + OUTWARD), foot, at, sure
    if side == 0:
        within, sure = inside(row, p, stack)
        side = -1 if within else 1
    return side * gap, outward_at(row, at, p, foot, float(side)), foot, at, sure


@kernel
def heights(row: Row, points: Sequence[Row], sides: Sequence[int], answers: Sequence[Scratch], stack: Scratch) -> None:
    """Answer a batch of points by a row `SPOT` each."""
    for i in range(len(points)):
        sigma, n, foot, at, sure = height(row, three(points[i], 0), sides[i], stack)
        answer = answers[i]
        answer[0], answer[1], answer[2], answer[3] = sigma, n[0], n[1], n[2]
        answer[4], answer[5], answer[6], answer[7] = foot[0], foot[1], foot[2], 1.0 if sure else 0.0
        answer[8] = at
