"""Proxies of any types, numbered through: their bounding boxes, and the narrow test of pairs of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from refimpl.bounds import aabb
from refimpl.linear import Array, Bools
from refimpl.proxy import Proxy, ShapeError
from refimpl.queries import intersect
from refimpl.shapes import Composite, HalfSpace, Ray
from refimpl.signs import Indices


@dataclass(frozen=True)
class Numbered:
    """Proxies in the order in which they were given, those of one type in batches.

    Attributes
    ----------
    batches : proxies with one batch axis
    batch, place : (N,) int64
        In which batch a proxy is, and where.
    """

    batches: tuple[Proxy, ...]
    batch: Indices
    place: Indices

    @classmethod
    def of(cls, proxies: Proxy | Iterable[Proxy]) -> Numbered:
        """Number one proxy or many, alone or in batches; batches are counted through, row by row.

        Those with a fixed number of coordinates come together by type; a hull, mesh or composite stays the batch that
        it was, since its derived data belong to it.
        """
        given = [proxies] if isinstance(proxies, Proxy) else list(proxies)
        for x in given:
            if not isinstance(x, Proxy):
                raise TypeError(f"expected proxies, got {type(x).__name__}: {x!r}")
        kinds: dict[object, list[int]] = {}
        for number, x in enumerate(given):
            lone = x.header > 0 or isinstance(x, Composite)
            kinds.setdefault(number if lone else type(x), []).append(number)
        flat = [x.flattened() for x in given]
        counts = np.array([len(x) for x in flat], dtype=np.int64)
        batch, place = np.zeros(len(flat), dtype=np.int64), np.zeros(len(flat), dtype=np.int64)
        batches = []
        for which, members in enumerate(kinds.values()):
            batch[members] = which
            place[members] = np.cumsum(counts[members]) - counts[members]
            batches.append(_together([flat[number] for number in members]))
        first = np.cumsum(counts) - counts
        owner = np.repeat(np.arange(len(flat)), counts)
        return cls(tuple(batches), batch[owner], place[owner] + np.arange(len(owner)) - first[owner])

    @classmethod
    def by_form(cls, proxies: Sequence[Proxy]) -> Numbered:
        """Number single proxies, those of one type and form together: also hulls of equal sizes, and equal meshes."""
        members: dict[object, list[int]] = {}
        for number, x in enumerate(proxies):
            if x.batch_shape:
                raise ShapeError(f"proxy {number} is a batch of {x.batch_shape}: give single proxies")
            members.setdefault((type(x), x.identity()[0]), []).append(number)
        batch, place = np.zeros(len(proxies), dtype=np.int64), np.zeros(len(proxies), dtype=np.int64)
        batches = []
        for which, numbers in enumerate(members.values()):
            batch[numbers], place[numbers] = which, np.arange(len(numbers))
            batches.append(type(proxies[numbers[0]]).unpack(np.stack([proxies[number].pack() for number in numbers])))
        return cls(tuple(batches), batch, place)

    def __len__(self) -> int:
        return len(self.batch)

    def __getitem__(self, number: int) -> Proxy:
        """Give one of the proxies."""
        return self.batches[int(self.batch[number])][int(self.place[number])]

    def mapped(self, change: Callable[[Proxy, Indices], Proxy]) -> Numbered:
        """Change each batch; `change` takes it and the numbers of its proxies, in its order."""
        changed = []
        for which, proxies in enumerate(self.batches):
            mine = np.flatnonzero(self.batch == which)
            numbers = np.empty_like(mine)
            numbers[self.place[mine]] = mine
            changed.append(change(proxies, numbers))
        return Numbered(tuple(changed), self.batch, self.place)

    def boxes(self) -> tuple[Array, Array]:
        """Corners (N, 3) of the bounding boxes, or (N, 2) of flat proxies."""
        dimensions = {proxies.dimension for proxies in self.batches}
        if len(dimensions) > 1:
            raise ShapeError("proxies of the plane and of space cannot be in one broad phase")
        lower, upper = np.empty((2, len(self), *(dimensions or {3})))
        for which, proxies in enumerate(self.batches):
            mine = self.batch == which
            low, up = boxes_of(proxies)
            lower[mine], upper[mine] = low[self.place[mine]], up[self.place[mine]]
        return lower, upper

    def meet(self, pairs: Indices) -> Bools:
        """Whether the proxies of pairs (M, 2) have a point in common: `intersect`, a batch for each pair of types."""
        found = np.zeros(len(pairs), dtype=bool)
        for some, a, b in self.by_types(pairs):
            found[some] = intersect(a, b)
        return found

    def by_types(self, pairs: Indices) -> Iterator[tuple[Indices, Proxy, Proxy]]:
        """Rows of pairs (M, 2) that are of the same two types, with their first and their second proxies as batches."""
        i, j = pairs[:, 0], pairs[:, 1]
        kinds = self.batch[i] * len(self.batches) + self.batch[j]
        order = np.argsort(kinds, kind="stable")
        for some in np.split(order, np.flatnonzero(np.diff(kinds[order])) + 1) if len(order) else ():
            a, b = self.batches[self.batch[i[some[0]]]], self.batches[self.batch[j[some[0]]]]
            yield some, a[self.place[i[some]]], b[self.place[j[some]]]


def boxes_of(x: Proxy) -> tuple[Array, Array]:
    """Corners of the bounding boxes of proxies, (..., 3) each; unlike `aabb` also of what has no end.

    A half-space has a bound only if its plane is at right angles to an axis; a ray has one at its origin.
    """
    if isinstance(x, HalfSpace):
        return _of_halfspaces(x)
    if isinstance(x, Ray):
        return np.where(x.direction < 0, -np.inf, x.origin), np.where(x.direction > 0, np.inf, x.origin)
    if isinstance(x, Composite):
        lower, upper = zip(*(boxes_of(part) for part in x.parts), strict=True)
        return np.min(lower, axis=0), np.max(upper, axis=0)
    box = aabb(x)
    return box.lower, box.upper


def _of_halfspaces(h: HalfSpace) -> tuple[Array, Array]:
    """Corners: along a normal with a single coordinate n the bound is −k / n, rounded outwards."""
    n = h.normal
    alone = (np.count_nonzero(n, axis=-1) == 1)[..., None] & (n != 0)
    with np.errstate(over="ignore"):
        bound = -h.k[..., None] / np.where(alone, n, 1.0)
        return (
            np.where(alone & (n < 0), np.nextafter(bound, -np.inf), -np.inf),
            np.where(alone & (n > 0), np.nextafter(bound, np.inf), np.inf),
        )


def _together(proxies: list[Proxy]) -> Proxy:
    """One batch of proxies of one type, each with one batch axis."""
    first, *others = proxies
    return first.rebuilt(np.concatenate([x.pack() for x in proxies])) if others else first
