"""Binary space partition over boxes: cells are parted by planes of any direction.

Each plane lies across the direction in which the centres of a cell's objects are spread most: the principal axis of
their covariance. Rows of things that run askew are so cut across, where planes along the axes would cut them to bits
(Fuchs, Kedem & Naylor 1980, On Visible Surface Generation by A Priori Tree Structures).
"""

from __future__ import annotations

import numpy as np

from refimpl.broadphase.partition import PartitionTree
from refimpl.linear import Array


class BSPTree(PartitionTree):
    """The tree. For the solid that a mesh bounds there is `refimpl.broadphase.solidtree.SolidTree`."""

    @staticmethod
    def _ways(spread: Array) -> Array:
        """Give the principal axes, that of the greatest variance first."""
        _, vectors = np.linalg.eigh(spread)
        return np.asarray(np.clip(np.moveaxis(vectors[:, :, ::-1], 2, 0), -1.0, 1.0))
