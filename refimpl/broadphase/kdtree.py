"""k-d tree: cells are parted across one axis after the other, that along which their objects are spread most."""

from __future__ import annotations

import numpy as np

from refimpl.broadphase.partition import PartitionTree
from refimpl.linear import Array


class KDTree(PartitionTree):
    """The tree (Bentley 1975, Multidimensional Binary Search Trees Used for Associative Searching), here over boxes."""

    @staticmethod
    def _ways(spread: Array) -> Array:
        """Give the axes, that of the greatest variance first."""
        variances = np.diagonal(spread, axis1=1, axis2=2)
        return np.eye(spread.shape[1])[np.argsort(-variances, axis=1).T]
