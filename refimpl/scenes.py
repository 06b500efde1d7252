"""Two batches of unions as pairs of convex atoms: which of them matter, and what the door says of them.

Two ways to the same answers: scalar kernels (`small_scenes`), where the unions have few atoms; and row by row, by
trees of boxes, where they have many.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from refimpl.atoms import Group, candidates, groups, leaves
from refimpl.escapes import Pairs, joined_pairs
from refimpl.linear import Array
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.shapes import Polyhedron
from refimpl.signs import Indices
from refimpl.small_scenes import SmallScene

FEW_FACES = 256  # meshes of so many faces, or convex ones, are cut into pieces without asking what they meet
FEW_PAIRS = 1024  # so many pairs of atoms are looked at without a tree
FIRST = 16  # pairs that are answered first, the most promising ones


def ask(x: Proxy, y: Proxy) -> Separation:
    """Signed distance of two batches, by the door."""
    from refimpl.queries import distance  # noqa: PLC0415  the door needs the pair table, which names unions

    return distance(x, y)


class LargeScene:
    """Row by row: faces of meshes as long as they are apart, pieces where they overlap, and trees of boxes."""

    def __init__(self, a: Proxy, b: Proxy) -> None:
        self.a, self.b = a, b
        self.pair_count = np.inf
        self._pieces: dict[int, tuple[list[Group], list[Group]]] = {}

    def pieces(self, row: int) -> tuple[list[Group], list[Group]]:
        """Atoms of a row."""
        if row not in self._pieces:
            self._pieces[row] = groups(leaves(self.a[row])), groups(leaves(self.b[row]))
        return self._pieces[row]

    def pairs(self, rows: Indices, moves: Array, within: Array | float = 0.0) -> Pairs:
        """Pairs whose boxes meet, or are so near, after B has moved in some rows; they count these rows from 0."""
        found = []
        bounds = np.broadcast_to(within, len(rows))
        for row in np.unique(rows).tolist():
            places = np.flatnonzero(rows == row)
            xs, ys = self.pieces(row)
            found += [_moved_pairs(x, y, places, moves[places], bounds[places]) for x in xs for y in ys]
        return joined_pairs(found)

    def nearest(self, rows: Indices) -> Pairs:
        """The nearest pair of each row, or some pair that overlaps."""
        found = []
        for place, row in enumerate(rows.tolist()):
            nearest = nearest_atoms(
                groups(leaves(self.a[row]), surfaces=True), groups(leaves(self.b[row]), surfaces=True)
            )
            found.append(nearest._replace(row=np.full(1, place)))
        return joined_pairs(found)


def _moved_pairs(x: Group, y: Group, places: Indices, moves: Array, bounds: Array) -> Pairs:
    """Near pairs of two groups after several moves of the second, answered by one call."""
    near = [
        candidates(x, y.shifted(move), float(bound), nearest=False) for move, bound in zip(moves, bounds, strict=True)
    ]
    i, j = (np.concatenate([pair[side] for pair in near]) for side in (0, 1))
    which = np.repeat(np.arange(len(places)), [len(pair[0]) for pair in near])
    if not len(i):
        return joined_pairs([])
    answer = ask(x.proxies[i], y.proxies[j].translated(moves[which]))
    return Pairs(places[which], x.numbers[i], y.numbers[j], answer)


def nearest_atoms(xs: Sequence[Group], ys: Sequence[Group], within: float = np.inf) -> Pairs:
    """Nearest pair of atoms of two unions, or some pair that overlaps; none where no pair is as near as `within`."""
    best = joined_pairs([])
    for x in xs:
        for y in ys:
            i, j, least = candidates(x, y, within)
            start, size = 0, FIRST
            while start < len(i) and least[start] <= within:
                some = slice(start, start + size)
                answer = ask(x.proxies[i[some]], y.proxies[j[some]])
                row = np.array([np.argmin(answer.distance)])
                if not len(best.row) or answer.distance[row] < best.found.distance:
                    best = Pairs(
                        np.zeros(1, dtype=np.int64), x.numbers[i[some][row]], y.numbers[j[some][row]], answer[row]
                    )
                    within = min(within, float(best.found.distance[0]))
                    if within < 0:
                        return best
                start, size = start + size, 2 * size
    return best


def scene(a: Proxy, b: Proxy) -> SmallScene | LargeScene:
    """The way that fits two batches."""
    count = 1
    for x in (a, b):
        own = 0
        for leaf in leaves(x):
            if isinstance(leaf, Polyhedron):
                if len(leaf.triangles) > FEW_FACES and not leaf.solid.is_convex:
                    return LargeScene(a, b)
                own += len(leaf.pieces)
            else:
                own += 1
        count *= own
    return SmallScene(a, b) if count <= FEW_PAIRS else LargeScene(a, b)
