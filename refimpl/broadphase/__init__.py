"""Broad phase: which of N things can meet each other, or a box, a point, a ray. One protocol, many structures."""

from refimpl.broadphase.brute import BruteForce
from refimpl.broadphase.bsptree import BSPTree
from refimpl.broadphase.bvh import BVH
from refimpl.broadphase.columns import ColumnSweep
from refimpl.broadphase.door import pairs
from refimpl.broadphase.grids import ArrayGrid, HashGrid
from refimpl.broadphase.kdtree import KDTree
from refimpl.broadphase.octree import Octree
from refimpl.broadphase.protocol import BroadPhase
from refimpl.broadphase.proxies import Numbered, boxes_of
from refimpl.broadphase.solidtree import SolidTree
from refimpl.broadphase.surface import SurfaceTree
from refimpl.broadphase.sweep import SortAndSweep
from refimpl.broadphase.table import STRUCTURES, Structure

__all__ = [
    "BVH",
    "STRUCTURES",
    "ArrayGrid",
    "BSPTree",
    "BroadPhase",
    "BruteForce",
    "ColumnSweep",
    "HashGrid",
    "KDTree",
    "Numbered",
    "Octree",
    "SolidTree",
    "SortAndSweep",
    "Structure",
    "SurfaceTree",
    "boxes_of",
    "pairs",
]
