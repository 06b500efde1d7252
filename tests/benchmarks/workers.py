"""How much faster two workers are than one: ``python -m tests.benchmarks.workers [ROUNDS]``.

Both do the same tasks, taken in turns so that whatever else runs on the machine hits both alike; engines are started
and kernels compiled before the clock runs. The ratio asked for is 1.8.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from concurrent.futures import Executor, wait
from itertools import islice

import numpy as np

from oracles.bench import Setup
from oracles.engines import available_engines
from oracles.executors import Crew
from oracles.opening import wanted_pairs
from oracles.plan import later_passes
from oracles.scene import MOVING, Cell, cells_of
from oracles.tasks import Task, perform

ASKED = 1.8
PAIRS = ("Sphere–Box", "Capsule–Capsule", "Sphere–Sphere", "Sphere–Capsule")


def workload(engines: Sequence[str], seed: int) -> list[Task]:
    """Bulk passes and as many hunts: so many that the one that ends last, alone, counts little, as in a run."""
    pairs = wanted_pairs(PAIRS)
    at_rest = [c for p in pairs for c in cells_of(p) if c.query not in MOVING]
    targets = [(engines[0], Cell(c.query, c.type_a, c.type_b)) for c in at_rest]
    asked = [(engine, cell) for engine, cell in targets if not (engine == "fcl" and cell.query == "raycast")]
    return list(islice(later_passes(pairs, asked, seed, None), 6 * len(pairs)))


def seconds(crew: Executor, tasks: Sequence[Task], setup: Setup) -> float:
    """Wall time of all tasks."""
    began = time.perf_counter()
    futures = [crew.submit(perform, task, setup) for task in tasks]
    wait(futures)
    for future in futures:
        future.result()
    return time.perf_counter() - began


def main(arguments: list[str]) -> None:
    """Print each round, and the median of the ratios."""
    rounds = int(arguments[0]) if arguments else 3
    engines = [name for name, missing in available_engines().items() if missing is None][:1]
    setup, ratios = Setup(tuple(engines)), []
    with Crew(1) as one, Crew(2) as two:
        warm = workload(engines, 0)
        seconds(one, warm, setup)
        seconds(two, warm, setup)
        for number in range(1, rounds + 1):
            tasks = workload(engines, number)
            alone, both = seconds(one, tasks, setup), seconds(two, tasks, setup)
            ratios.append(alone / both)
            print(
                f"{len(tasks)} tasks: {alone:.2f} s by one, {both:.2f} s by two workers: × {alone / both:.2f}",
                flush=True,
            )
    print(f"median × {np.median(ratios):.2f} (asked: {ASKED})")


if __name__ == "__main__":
    main(sys.argv[1:])
