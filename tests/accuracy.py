"""Print the worst errors of the reference, pair by pair: ``python -m tests.accuracy [scenes per regime] [seed]``.

Each distance is held against 50 digits (`tests.truth`) and against its proven interval, over every regime, relative to
the scene's largest coordinate, extent or distance.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import refimpl
from oracles.draws import NumpyDraws
from oracles.regimes import REGIMES
from refimpl import Ray
from refimpl.pairs import TABLE
from refimpl.proof import certify, check
from tests import truth


def errors(pair: tuple[type, type], n: int, seed: int) -> Iterator[tuple[str, float, float, bool]]:
    """Regime, error, interval width and whether `intersect` is right, of each scene with a finite distance."""
    for index, (regime, make) in enumerate(REGIMES.items()):
        a, b = make(NumpyDraws(seed, (index, 5), n), *pair)
        found, hits = refimpl.distance(a, b).distance, refimpl.intersect(a, b)
        for i in np.flatnonzero(np.isfinite(found)):
            true = truth.signed_distance(a[i], b[i])
            size = truth.scene_scale(a[i], b[i]) or 1.0
            lower, upper = check(certify(a[i], b[i]), a[i], b[i])
            clear = abs(true) > 1e-14 * size
            yield (
                regime,
                float(abs(true - float(found[i])) / size),
                float(upper - lower) / size,
                not clear or bool(hits[i]) == (true <= 0),
            )


def main(n: int = 20, seed: int = 1) -> None:
    """Measure, and print the table."""
    table = Table("pair", "scenes", "worst error / s", "in regime", "widest interval / s", "wrong intersect")
    pairs = [pair for pair in TABLE if pair[0] is not Ray]
    worst_of_all = 0.0
    for pair in track(pairs, description="measuring", transient=True):
        rows = list(errors(pair, n, seed))
        worst = max(rows, key=lambda row: row[1])
        worst_of_all = max(worst_of_all, worst[1])
        wrong = sum(not right for *_, right in rows)
        name = "–".join(kind.__name__ for kind in pair)
        widest = max(row[2] for row in rows)
        table.add_row(name, str(len(rows)), f"{worst[1]:.1e}", worst[0], f"{widest:.1e}", str(wrong))
    Console(width=110).print(table)
    print(f"worst error: {worst_of_all:.2e}; double precision rounds by {math.ulp(1.0) / 2:.2e}")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
