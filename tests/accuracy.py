"""Print the worst errors of the reference: ``python -m tests.accuracy [scenes] [seed] [--write] [types or pairs]``.

Each distance is held against 50 digits (`tests.truth`) and against its proven interval, over every regime, relative to
the scene's largest coordinate, extent or distance; rays by how far the hit point is from the surface; unions where
they are apart, and without the regime of whole models, whose truth takes minutes. `--write` keeps the numbers for the
pair table in the README. Names of types or pairs (``Box``, ``Sphere-Box``) choose among the pairs.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import refimpl
from oracles.draws import NumpyDraws
from oracles.regimes import REGIMES
from refimpl import Point, Ray
from refimpl.pairs import ITERATIVE, TABLE
from refimpl.proof import certify, check
from tests import truth

MEASURED = Path(refimpl.__file__).parents[1] / "reports" / "measured.json"
UNIONS = {"Polyhedron", "Composite"}


@dataclass
class Worst:
    """Worst of what was seen of a pair; errors and widths are relative to the scene's size."""

    scenes: int = 0
    error: float = 0.0
    regime: str = ""
    interval: float = 0.0
    wide: int = 0
    wrong: int = 0
    proof_ms: list[float] = field(default_factory=list)

    def see(self, error: float, regime: str) -> None:
        self.scenes += 1
        if error >= self.error:
            self.error, self.regime = error, regime


def measure(pair: tuple[type, type], n: int, seed: int) -> Worst:
    """Try `n` scenes of each regime."""
    worst = Worst()
    unions = {kind.__name__ for kind in pair} & UNIONS
    for index, (regime, make) in enumerate(REGIMES.items()):
        if unions and regime == "models":
            continue
        a, b = make(NumpyDraws(seed, (index, 5), n), *pair)
        rows: Iterator[float] = _hits(a, b, worst) if pair[0] is Ray else _distances(a, b, worst)
        for error in rows:
            worst.see(error, regime)
    return worst


def _distances(a: Any, b: Any, worst: Worst) -> Iterator[float]:
    found, hits = refimpl.distance(a, b).distance, refimpl.intersect(a, b)
    for i in np.flatnonzero(np.isfinite(found)):
        true = truth.signed_distance(a[i], b[i])
        size = truth.scene_scale(a[i], b[i], true) or 1.0
        worst.wrong += abs(true) > 1e-12 * size and bool(hits[i]) != (true <= 0)
        if true <= 0 and {type(a).__name__, type(b).__name__} & UNIONS:
            continue  # the depth of unions is known between bounds only
        began = time.perf_counter()
        lower, upper = check(certify(a[i], b[i]), a[i], b[i])
        worst.proof_ms.append(1e3 * (time.perf_counter() - began))
        width = float(upper - lower) / size
        worst.interval = max(worst.interval, width)
        worst.wide += width > 1e-10
        yield float(abs(true - float(found[i])) / size)


def _hits(rays: Any, b: Any, worst: Worst) -> Iterator[float]:
    found = refimpl.raycast(rays, b)
    for i in range(len(rays)):
        span = truth.ray_interval(rays[i], b[i])
        if bool(found.hit[i]) != (span is not None):
            worst.wrong += 1  # of a grazing ray: held against the surface by the tests
        elif span is not None and span[0] > 0:
            point = found.point[i]
            size = max(float(b[i].magnitude), float(rays[i].magnitude), float(np.abs(point).max())) or 1.0
            yield float(abs(truth.signed_distance(Point(point), b[i]))) / size


def merge(measured: dict[str, dict[str, Any]]) -> None:
    """Add numbers by pair to those that are kept."""
    kept = json.loads(MEASURED.read_text("utf-8")) if MEASURED.exists() else {"pairs": {}}
    for pair, numbers in measured.items():
        kept["pairs"].setdefault(pair, {}).update(numbers)
    order = {f"{a.__name__}–{b.__name__}": i for i, (a, b) in enumerate(TABLE)}
    kept["pairs"] = dict(sorted(kept["pairs"].items(), key=lambda item: order.get(item[0], len(order))))
    MEASURED.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", "utf-8")


def chosen(words: list[str]) -> list[tuple[type, type]]:
    """Pairs of the table that a word names; all of them without words."""
    wanted = {word.replace("–", "-") for word in words}
    pairs, known = [], set()
    for a, b in TABLE:
        names = {a.__name__, b.__name__, f"{a.__name__}-{b.__name__}"}
        known |= names
        if not wanted or names & wanted:
            pairs.append((a, b))
    if not wanted <= known:
        raise SystemExit(f"no type or pair of the table: {', '.join(sorted(wanted - known))}")
    return pairs


def main(arguments: list[str]) -> None:
    """Measure, and print the table."""
    numbers = [int(word) for word in arguments if word.isdigit()]
    n, seed = [*numbers, *(20, 1)[len(numbers) :]]
    words = [word for word in arguments if not word.isdigit() and not word.startswith("-")]
    table = Table("pair", "class", "scenes", "worst error / s", "in regime", "widest interval / s", "wrong", "proof ms")
    classes: dict[str, float] = {}
    for pair in track(chosen(words), description="measuring", transient=True):
        worst, exactness = measure(pair, n, seed), TABLE[pair].exactness
        name = "–".join(kind.__name__ for kind in pair)
        classes[exactness] = max(classes.get(exactness, 0.0), worst.error)
        if "--write" in arguments:
            merge({name: {"error": worst.error} | ({} if pair[0] is Ray else {"interval": worst.interval})})
        proof = f"{np.median(worst.proof_ms):.0f}" if worst.proof_ms else ""
        width = f"{worst.interval:.1e}" + (f" ({worst.wide} > 1e-10)" if worst.wide else "")
        shown = (f"{worst.error:.1e}", worst.regime, "" if pair[0] is Ray else width, str(worst.wrong), proof)
        table.add_row(name, exactness, str(worst.scenes), *shown)
    Console(width=140).print(table)
    for exactness, error in classes.items():
        print(f"worst error, {exactness}: {error:.2e} (allowed {1e-12 if exactness == ITERATIVE else 1e-14:.0e})")
    print(f"double precision rounds by {math.ulp(1.0) / 2:.2e}")


if __name__ == "__main__":
    main(sys.argv[1:])
