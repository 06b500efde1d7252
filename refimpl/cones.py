"""Corners of a convex cone that is given by its half-spaces, in exact integers.

Vertices from planes and planes from vertices are one task: find the extreme rays of {z : a·z ≤ 0 for every row a}.
For planes the rows are (n, k) and z = (x, t) with t ≥ 0, a corner x/t; for vertices the rows are (v, 1) and z = (n, k),
a face n·x + k ≤ 0 of their hull. The double description method (Motzkin, Raiffa, Thompson and Thrall 1953; Fukuda
and Prodon, Double Description Method Revisited, 1996) takes in one row after the other. It knows no general position:
parallel, repeated and redundant rows, flat, empty and unbounded sets all come out as what they are.

Doubles decide the signs that their error bound allows, integers the others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from refimpl.linear import Array, Bools

Whole = tuple[int, int, int, int]

ROUNDING = 16 * 2.0**-53
TINY = 1e-290  # where products may have lost bits by underflow, no double decides


def product(a: Whole, z: Whole) -> int:
    """Scalar product, exactly."""
    return a[0] * z[0] + a[1] * z[1] + a[2] * z[2] + a[3] * z[3]


def primitive(z: Sequence[int]) -> Whole:
    """Same direction in the smallest whole numbers."""
    divisor = math.gcd(*z)
    x, y, u, w = z
    return (x // divisor, y // divisor, u // divisor, w // divisor) if divisor > 1 else (x, y, u, w)


def nearest_doubles(z: Sequence[int]) -> tuple[float, ...]:
    """Whole numbers divided by a power of two, to at most 1, each rounded correctly."""
    unit = 1 << max(map(abs, z)).bit_length()
    return tuple([n / unit for n in z])  # quicker than a generator, and asked for each face and corner


class Cone:
    """Lines and extreme rays of {z in R⁴ : a·z ≤ 0 for every row a taken in so far}.

    Attributes
    ----------
    lines : list of whole vectors
        A basis of the lines that the cone contains.
    rays : dict
        Extreme rays (modulo the lines) by number.
    active : dict
        For each ray the rows that are 0 on it.
    touching : list
        For each row the rays on which it is 0.
    """

    def __init__(self) -> None:
        self.lines: list[Whole] = [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]
        self.rays: dict[int, Whole] = {}
        self.active: dict[int, set[int]] = {}
        self.touching: dict[int, set[int]] = {}
        self._near: Array = np.zeros((64, 4))
        self._alive: Bools = np.zeros(64, dtype=bool)
        self._free = list(range(63, -1, -1))

    def take_in(self, name: int, row: Whole) -> None:
        """Cut the cone by row·z ≤ 0, a row that will be known by this number."""
        for i, line in enumerate(self.lines):
            if product(row, line):
                self._open_line(name, row, i)
                return
        above, on, below = self._sides(row)
        if above:
            edges = [(u, v) for u in above for v in self._across(u, below) if self._adjacent(u, v)]
            fresh = [self._where_cut(row, u, v) for u, v in edges]
            common = [self.active[u] & self.active[v] for u, v in edges]
            for ray in above:
                self._remove(ray)
        self.touching[name] = set()
        for ray in on:
            self._touch(ray, name)
        if above:
            for cut, rows in zip(fresh, common, strict=True):
                self._touch(self._add(cut, rows), name)

    def _open_line(self, name: int, row: Whole, index: int) -> None:
        """Cut a line: half of it becomes a ray, and all else is slid along it into the plane of the row."""
        line = self.lines.pop(index)
        slope = product(row, line)
        if slope > 0:
            line, slope = (-line[0], -line[1], -line[2], -line[3]), -slope

        def slid(z: Whole) -> Whole:
            height = product(row, z)
            return primitive([height * p - slope * q for p, q in zip(line, z, strict=True)])

        self.lines = [slid(other) for other in self.lines]
        before = set(self.touching)
        self.touching[name] = set()
        for ray in self.rays:
            self.rays[ray] = slid(self.rays[ray])
            self._near[ray] = nearest_doubles(self.rays[ray])
            self._touch(ray, name)
        self._add(line, before)

    def _sides(self, row: Whole) -> tuple[list[int], list[int], Bools]:
        """Rays on which the row is positive; zero; and a mask by number of those on which it is negative."""
        terms = self._near * np.array(nearest_doubles(row))
        value = terms[:, 0] + terms[:, 1] + terms[:, 2] + terms[:, 3]
        np.abs(terms, out=terms)
        allowed = ROUNDING * (terms[:, 0] + terms[:, 1] + terms[:, 2] + terms[:, 3]) + TINY
        below: Bools = value < -allowed
        above: list[int] = np.flatnonzero(value > allowed).tolist()
        on = []
        for ray in np.flatnonzero((np.abs(value) <= allowed) & self._alive).tolist():
            sign = product(row, self.rays[ray])
            if sign > 0:
                above.append(ray)
            elif sign < 0:
                below[ray] = True
            else:
                on.append(ray)
        return above, on, below

    def _across(self, ray: int, below: Bools) -> list[int]:
        """Rays below that may be adjacent: without lines, those share at least two rows."""
        if self.lines:
            return np.flatnonzero(below).tolist()
        met: set[int] = set()
        twice: set[int] = set()
        for name in self.active[ray]:
            others = self.touching[name]
            twice |= met & others
            met |= others
        return [other for other in twice if below[other]]

    def _adjacent(self, u: int, v: int) -> bool:
        """Whether two rays span a face of dimension two: no third ray lies on all rows that both lie on."""
        common = self.active[u] & self.active[v]
        if not common:
            return len(self.rays) == 2
        least = sorted((self.touching[name] for name in common), key=len)
        meet = least[0]
        for others in least[1:]:
            if len(meet) == 2:
                break
            meet = meet & others
        return len(meet) == 2

    def _where_cut(self, row: Whole, u: int, v: int) -> Whole:
        """Ray between u, above, and v, below, on which the row is 0."""
        p, q = self.rays[u], self.rays[v]
        up, down = product(row, p), -product(row, q)
        return primitive([up * b + down * a for a, b in zip(p, q, strict=True)])

    def _add(self, ray: Whole, rows: set[int]) -> int:
        if not self._free:
            size = len(self._near)
            self._near = np.concatenate([self._near, np.zeros((size, 4))])
            self._alive = np.concatenate([self._alive, np.zeros(size, dtype=bool)])
            self._free = list(range(2 * size - 1, size - 1, -1))
        number = self._free.pop()
        self.rays[number] = ray
        self._near[number] = nearest_doubles(ray)
        self._alive[number] = True
        self.active[number] = set()
        for name in rows:
            self._touch(number, name)
        return number

    def _touch(self, ray: int, name: int) -> None:
        self.active[ray].add(name)
        self.touching[name].add(ray)

    def _remove(self, ray: int) -> None:
        for name in self.active.pop(ray):
            self.touching[name].discard(ray)
        del self.rays[ray]
        self._near[ray] = 0.0
        self._alive[ray] = False
        self._free.append(ray)
