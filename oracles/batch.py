"""A batch: scenes of one pair of types in all regimes, named so that they can be had again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oracles.draws import NumpyDraws
from oracles.regimes import REGIMES
from oracles.scene import Scene
from refimpl.shapes import Proxy

PairKey = tuple[type[Proxy], type[Proxy]]


@dataclass(frozen=True)
class Batch:
    """Scenes of one pair of types in all regimes."""

    a: Proxy
    b: Proxy
    regimes: list[str]
    groups: NDArray[np.int_]
    source: str

    @classmethod
    def draw(cls, pair: PairKey, seed: int, shard: tuple[int, ...], each: int) -> Batch:
        """`each` scenes of every regime: a pure function of the seed, the shard and the number."""
        rows_a, rows_b, names = [], [], []
        for index, (name, make) in enumerate(REGIMES.items()):
            a, b = make(NumpyDraws(seed, (*shard, index), each), *pair)
            rows_a.append(a.pack())
            rows_b.append(b.pack())
            names += [name] * each
        groups = np.repeat(np.arange(len(REGIMES)), each)
        a, b = pair[0].unpack(np.concatenate(rows_a)), pair[1].unpack(np.concatenate(rows_b))
        return cls(a, b, names, groups, f"bulk {seed}/{'/'.join(map(str, shard))}")

    def scene(self, query: str, i: int) -> Scene:
        """One scene of the batch."""
        return Scene(query, self.a[i], self.b[i], self.regimes[i], f"{self.source}[{i}]")
