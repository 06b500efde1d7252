"""Clocks: the reference in batches and alone, an engine in a bare loop, each in microseconds for one pair.

What is counted is the processor's time, so that it matters little what else the machine does; only what threads share
is timed by the clock on the wall, and asks for a machine that does nothing else.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

import refimpl
from oracles.engine import Engine, NoAnswer
from oracles.scene import CONTACTS, DISTANCE, RAYCAST
from refimpl import Ray
from refimpl.threads import SETTING
from tests.benchmarks.scenes import GEOMETRIES

PATIENCE = 1.0
"""Seconds that one measurement may take; what is slower is measured on fewer pairs."""
REPEATS = 3


def query_of(a: Any) -> Callable[[Any, Any], Any]:
    return refimpl.raycast if isinstance(a, Ray) else refimpl.distance


@contextmanager
def threads(number: int | None) -> Iterator[None]:
    """Let batches be shared by so many threads within the block; None is the default."""
    before = os.environ.pop(SETTING, None)
    if number is not None:
        os.environ[SETTING] = str(number)
    yield
    os.environ.pop(SETTING, None)
    if before is not None:
        os.environ[SETTING] = before


def in_batch(a: Any, b: Any, clock: Callable[[], float] = time.process_time) -> float:
    """Best of several runs of the whole batch; what is compiled or derived once is so before."""
    ask, rows = query_of(a), len(a)
    ask(a[:300], b[:300])
    began = clock()
    ask(a[:300], b[:300])
    expected = (clock() - began) / min(300, rows)
    rows = max(300, min(rows, int(PATIENCE / REPEATS / expected)))
    times = []
    for _ in range(REPEATS):
        began = clock()
        ask(a[:rows], b[:rows])
        times.append(clock() - began)
    return 1e6 * min(times) / min(rows, len(a))


def alone(a: Any, b: Any, pairs: int = 40) -> float:
    """Median of single pairs through the door."""
    ask, times = query_of(a), []
    for i in range(min(pairs, len(a))):
        x, y = a[i], b[i]
        ask(x, y)
        began = time.process_time()
        ask(x, y)
        times.append(time.process_time() - began)
        if sum(times) > PATIENCE:
            break
    return 1e6 * float(np.median(times))


def engine_loop(engine: Engine, a: Any, b: Any) -> float | None:
    """One pair after the other, by the adapter's solver, in a child of this process: engines crash."""
    A, B = type(a), type(b)
    queries = (RAYCAST,) if A is Ray else (DISTANCE, CONTACTS)
    query = next((q for q in queries if engine.support(q, A, B)), None)
    if query is None:
        return None
    here, there = multiprocessing.get_context("fork").Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=_loop, args=(there, engine, query, a, b))
    child.start()
    there.close()
    try:
        answered: float | None = here.recv() if here.poll(100.0 * PATIENCE) else None
    except EOFError:
        answered = None
    child.kill()
    child.join()
    return answered


def _loop(channel: Any, engine: Engine, query: str, a: Any, b: Any) -> None:
    engine.warm()
    solve = engine.solver(query, type(a), type(b))
    rows = list(zip(a.pack().tolist(), b.pack().tolist(), strict=True))
    began = time.process_time()
    for row in rows[:GEOMETRIES]:  # hulls and meshes are made now, and kept
        if time.process_time() - began < 2.0 * PATIENCE:
            _answer(solve, row)
    channel.send(1e6 * min(_one_pass(solve, rows) for _ in range(REPEATS)))


def _one_pass(solve: Any, rows: list[Any]) -> float:
    """Seconds a pair, over all rows or as many as patience allows."""
    done, began = 0, time.process_time()
    while done < len(rows) and time.process_time() - began < PATIENCE / REPEATS:
        for row in rows[done : done + 100]:
            _answer(solve, row)
        done += len(rows[done : done + 100])
    return (time.process_time() - began) / done


def _answer(solve: Any, row: Any) -> None:
    try:
        solve(*row)
    except NoAnswer:
        return


def import_seconds() -> float:
    """Median time to import the package, beyond that of starting Python."""

    def run(code: str) -> float:
        began = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        return time.perf_counter() - began

    return float(np.median([run("import refimpl") - run("pass") for _ in range(5)]))
