"""The table of structures: a row for each, with its idea, when to use it, and what it costs.

Costs are for N objects of one size at equal density, with K answers; d is the dimension. `python -m
tests.benchmarks.broadphase` measures them.
"""

from __future__ import annotations

from dataclasses import dataclass

from refimpl.broadphase.brute import BruteForce
from refimpl.broadphase.bsptree import BSPTree
from refimpl.broadphase.bvh import BVH
from refimpl.broadphase.columns import ColumnSweep
from refimpl.broadphase.grids import ArrayGrid, HashGrid
from refimpl.broadphase.kdtree import KDTree
from refimpl.broadphase.octree import Octree
from refimpl.broadphase.protocol import BroadPhase
from refimpl.broadphase.sweep import SortAndSweep


@dataclass(frozen=True)
class Structure:
    """A row of the table.

    Attributes
    ----------
    make
        The class; called without arguments it gives an empty structure.
    idea
        What is stored, and what a candidate is.
    when
        What it is good for, and what not.
    cost
        Of building, and of all pairs.
    """

    make: type[BroadPhase]
    idea: str
    when: str
    cost: str


# fmt: off
# ruff: noqa: E501  a row of the table is a line
STRUCTURES: dict[str, Structure] = {
    "brute force":    Structure(BruteForce,   "every object against every other",                        "up to some hundreds; as the reference",                             "nothing; N²"),
    "array grid":     Structure(ArrayGrid,    "cells in an array, each with the list of what is in it",  "evenly spread objects of about one size; memory for empty cells",   "N log N; N + K"),
    "hash grid":      Structure(HashGrid,     "the same cells in a hash table",                          "a world without bounds; small moves, which change no cell",         "N log N; N + K"),
    "sort and sweep": Structure(SortAndSweep, "intervals sorted along one axis",                         "objects along a line, or in a plane if few; coherent motion",       "N log N; N^(2 − 1/d) + K"),
    "column sweep":   Structure(ColumnSweep,  "columns of a grid, sorted along the remaining axis",      "the default: everything moves at once, any place, mixed sizes",     "N log N; N log N + K"),
    "octree":         Structure(Octree,       "cells halved along all axes; an object sinks to its size", "objects of all sizes and places; built faster than other trees",    "N log N; N log N + K"),
    "BVH":            Structure(BVH,          "boxes around boxes, parted where they have least surface", "queries and rays; many small moves, which only refit the boxes",    "N log N; N log N + K"),
    "k-d tree":       Structure(KDTree,       "halves of space, parted at the middle of the objects",     "nearest objects; bad where objects are large for their distances", "N log N; N log N + K"),
    "BSP tree":       Structure(BSPTree,      "the same, parted by planes of any direction",              "rows and layers of objects that lie askew",                         "N log N; N log N + K"),
}
# fmt: on


def structure(name: str | type[BroadPhase]) -> type[BroadPhase]:
    """Class of a structure by its name in the table; a class stays what it is."""
    if not isinstance(name, str):
        return name
    if name not in STRUCTURES:
        raise LookupError(f"no structure {name!r}; there are {', '.join(map(repr, STRUCTURES))}")
    return STRUCTURES[name].make
