"""Rows of the atoms of a mesh, where its placements put them."""

from __future__ import annotations

from collections.abc import Sequence

from . import kernel
from .atoms import HULL, KIND, MATRIX, SHAPE, turned
from .axes import three
from .boxes import axes_of
from .gjk import store
from .polytopes import FACTOR, Row, Scratch
from .vectors import plus, times


@kernel
def put_pieces(
    placements: Sequence[Row],
    middles: Sequence[Row],
    factors: Sequence[Row],
    rows: Sequence[Sequence[Scratch]],
) -> None:
    """Write the rows of the pieces of a mesh in all its placements.

    Parameters
    ----------
    placements
        Where each puts the mesh's origin, and a quaternion.
    middles
        Where the pieces' origins lie in the mesh's frame, each in the unit of its geometry.
    factors
        Lengths of these units, for each placement.
    rows
        Rows of atoms; those of one placement belong together.
    """
    for i in range(len(rows)):
        at, (u, v, w) = three(placements[i], 0), axes_of(placements[i], 3)
        for j in range(len(middles)):
            row, factor = rows[i][j], factors[i][j]
            for k in range(3):
                store(row, MATRIX + 3 * k, (u[k], v[k], w[k]))
            store(row, 0, plus(at, turned(row, times(factor, three(middles[j], 0)))))
            row[FACTOR], row[KIND], row[SHAPE] = factor, HULL, float(j)
