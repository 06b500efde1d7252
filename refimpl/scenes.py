"""Two batches of unions as pairs of convex atoms: which of them matter, and what the door says of them.

Two ways to the same answers: all pairs of all rows in few large calls, where the unions have few atoms; and row by
row, by trees of boxes, where they have many.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from refimpl.atoms import Group, candidates, groups, leaves, stacked_batches
from refimpl.bounds import aabb
from refimpl.boxtree import SLACK
from refimpl.escapes import Pairs, joined_pairs
from refimpl.linear import Array, norm
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.shapes import HalfSpace, Point, Polyhedron
from refimpl.signs import Indices

FEW_FACES = 256  # meshes of so many faces, or convex ones, are cut into pieces without asking what they meet
FEW_PAIRS = 1024  # so many pairs of atoms are looked at without a tree
FIRST = 16  # pairs that are answered first, the most promising ones


def ask(x: Proxy, y: Proxy) -> Separation:
    """Signed distance of two batches, by the door."""
    from refimpl.queries import distance  # noqa: PLC0415  the door needs the pair table, which names unions

    return distance(x, y)


class Stack:
    """Atoms of a batch of unions: kind by kind one batch of proxies, atom by atom, and in each all rows.

    Attributes
    ----------
    kinds : list of Proxy
        Atom i of row r of a kind is its proxy i·rows + r.
    kind, place : (k,) int
        Of each atom its kind, and its number there; in the order in which contacts name atoms.
    center, half : (k, n, 3)
        Boxes around the atoms; infinite around half-spaces.
    """

    def __init__(self, parts: Sequence[Proxy]) -> None:
        self.rows = len(parts[0])
        self.kinds: list[Proxy] = []
        numbers: list[Indices] = []
        for proxies, own in stacked_batches(parts):
            self.kinds.append(proxies)
            numbers.append(own)
        count = sum(map(len, numbers))
        self.kind, self.place = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
        self.center, self.half = np.zeros((count, self.rows, 3)), np.zeros((count, self.rows, 3))
        for kind, own in enumerate(numbers):
            self.kind[own], self.place[own] = kind, np.arange(len(own))
            center, half = _boxes(self.kinds[kind])
            self.center[own] = center.reshape(len(own), self.rows, 3)
            self.half[own] = half.reshape(len(own), self.rows, 3)

    def __len__(self) -> int:
        return len(self.kind)


def _boxes(x: Proxy) -> tuple[Array, Array]:
    if isinstance(x, HalfSpace):
        return np.zeros((len(x), 3)), np.full((len(x), 3), np.inf)
    if isinstance(x, Point):
        return x.position, np.zeros((len(x), 3))
    box = aabb(x)
    half = (box.upper / 2 - box.lower / 2) + SLACK * np.maximum(np.abs(box.lower), np.abs(box.upper))
    return box.lower / 2 + box.upper / 2, half


class SmallScene:
    """All pairs of atoms of all rows, kind by kind in one call."""

    def __init__(self, a: Proxy, b: Proxy) -> None:
        self.a, self.b = Stack(leaves(a)), Stack(leaves(b))
        self.pair_count = len(self.a) * len(self.b)

    def pairs(self, rows: Indices, moves: Array, within: Array | float = 0.0) -> Pairs:
        """Pairs whose boxes meet, or are so near, after B has moved in some rows; they count these rows from 0."""
        gap, _ = self._boxes_apart(rows, moves)
        row, i, j = np.nonzero(gap <= np.broadcast_to(within, len(rows))[:, None, None])
        return self._answers(rows, row, i, j, moves)

    def nearest(self, rows: Indices) -> Pairs:
        """Pairs that may be the nearest ones, or meet."""
        gap, reach = self._boxes_apart(rows, np.zeros((len(rows), 3)))
        least = np.min(reach, axis=(1, 2))
        row, i, j = np.nonzero(gap <= least[:, None, None])
        return self._answers(rows, row, i, j, np.zeros((len(rows), 3)))

    def _boxes_apart(self, rows: Indices, moves: Array) -> tuple[Array, Array]:
        """Least and largest distances of points of the boxes, (rows, atoms of a, atoms of b)."""
        center_a, center_b = self.a.center[:, rows], self.b.center[:, rows] + moves
        between = np.abs(center_a[:, None] - center_b[None])
        both = self.a.half[:, None, rows] + self.b.half[None][:, :, rows]
        slack = SLACK * (between + np.abs(moves))
        gap, reach = norm(np.maximum(between - both - slack, 0.0)), _length(between + both + slack)
        return np.moveaxis(gap, 2, 0), np.moveaxis(reach, 2, 0)

    def _answers(self, rows: Indices, row: Indices, i: Indices, j: Indices, moves: Array) -> Pairs:
        found = []
        a, b = self.a, self.b
        for kind_a, x in enumerate(a.kinds):
            for kind_b, y in enumerate(b.kinds):
                mine = np.flatnonzero((a.kind[i] == kind_a) & (b.kind[j] == kind_b))
                if not len(mine):
                    continue
                which = row[mine]
                u = x[a.place[i[mine]] * a.rows + rows[which]]
                v = y[b.place[j[mine]] * b.rows + rows[which]]
                if np.any(moves):
                    v = v.translated(moves[which])
                found.append(Pairs(which, i[mine], j[mine], ask(u, v)))
        return joined_pairs(found)


def _length(v: Array) -> Array:
    with np.errstate(invalid="ignore"):
        return np.where(np.any(np.isinf(v), axis=-1), np.inf, norm(v))


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
