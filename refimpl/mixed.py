"""Proxies of several types side by side: one batch for each type, so that pairs are answered many at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from refimpl.proxy import Proxy, ShapeError

Ids = NDArray[np.int64]


class Group(NamedTuple):
    """Proxies that fit into one batch, and their numbers among all."""

    shapes: Proxy
    ids: Ids


class Mixed:
    """A sequence of single proxies, kept as one batch for each type and form.

    Parameters
    ----------
    proxies
        Single ones (batch shape ``()``) of any types. Those of one type share a batch where their sizes allow it:
        hulls of equally many vertices, and meshes that are the same.
    """

    def __init__(self, proxies: Sequence[Proxy]) -> None:
        together: dict[object, list[int]] = {}
        for number, proxy in enumerate(proxies):
            if proxy.batch_shape:
                raise ShapeError(f"proxy {number} is a batch of {proxy.batch_shape}: give single proxies")
            together.setdefault((type(proxy), proxy.identity()[0]), []).append(number)
        self._set(
            [
                Group(type(proxies[ids[0]]).unpack(np.stack([proxies[i].pack() for i in ids])), np.array(ids))
                for ids in together.values()
            ],
            len(proxies),
        )

    def _set(self, groups: list[Group], count: int) -> None:
        self.groups = groups
        self._group, self._row = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
        for number, group in enumerate(groups):
            self._group[group.ids], self._row[group.ids] = number, np.arange(len(group.ids))

    def __len__(self) -> int:
        return len(self._group)

    def __getitem__(self, number: int) -> Proxy:
        """Give one of the proxies."""
        return self.groups[int(self._group[number])].shapes[int(self._row[number])]

    def mapped(self, change: Callable[[Proxy, Ids], Proxy]) -> Self:
        """Apply a change to each batch; `change` takes the batch and the numbers of its proxies."""
        made = object.__new__(type(self))
        made._set([Group(change(group.shapes, group.ids), group.ids) for group in self.groups], len(self))
        return made

    def pairs(self, pairs: Ids) -> Iterator[tuple[Ids, Proxy, Proxy]]:
        """Sort pairs by their types.

        Parameters
        ----------
        pairs : (m, 2)
            Numbers of proxies.

        Yields
        ------
        which : (k,)
            Rows of `pairs`.
        first, second
            Their proxies, as two batches of length k.
        """
        kinds = self._group[pairs[:, 0]] * len(self.groups) + self._group[pairs[:, 1]]
        order = np.argsort(kinds, kind="stable")
        starts = np.flatnonzero(np.diff(kinds[order], prepend=-1))
        for which in np.split(order, starts[1:]) if len(order) else ():
            i, j = pairs[which].T
            a, b = (self.groups[int(self._group[ids[0]])].shapes[self._row[ids]] for ids in (i, j))
            yield which, a, b
