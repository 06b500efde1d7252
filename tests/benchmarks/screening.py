"""Bulk screening against an engine's bare loop: ``python -m tests.benchmarks.screening [--write] [types or pairs]``.

For every pair the same scenes are answered twice: by the engines alone, whose solvers are called in a loop over rows
that are ready, and as a campaign has them answered: drawn, sent to a worker, compared with the reference, judged and
counted. Times are those of the processor, of all processes that take part, in microseconds for one scene and query;
what is compiled once is so before. The last column is the rate of screening by that of the loop.

All 88 pairs are measured with as many scenes as the largest pass of a campaign has, or half of them where there are
most, and a summary names those below a half. ``--each=N`` asks for so many scenes of each regime, ``--engines=fcl`` for
some engines, ``--part=2/4`` for every fourth pair, beginning with the second; names such as ``Box–Polyhedron``, or of
one type, for the pairs with these. With ``--write`` the ratios are kept where those of the reference's rates are.

The bare loop is asked about a part of each batch, and then about more of all until it has taken `ENOUGH`. Scenes in
which the engine hangs or ends its process are no part of the comparison, for a bare loop does not outlive them: where
there are some, a part of the others is asked once more, alone. What a loss costs the campaign (a new process, and
what was asked since the last check once more) stands in a column of its own, `lost`.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oracles.batch import Batch, PairKey
from oracles.bulk import scenes_each
from oracles.clock import watch
from oracles.engine import Answers, Engine, Status
from oracles.engines import load_engine
from oracles.judges import Judges
from oracles.plan import LARGEST_PASS
from oracles.reference import is_quick
from oracles.regimes import regimes_for
from oracles.scene import Cell, cells
from oracles.worker import EngineWorker
from refimpl.compiling import WORTH_COMPILING, batch_of
from refimpl.pairs import TABLE
from tests.accuracy import merge

ENGINES = ("fcl", "bullet")
CALL_LIMIT = 0.1
"""Seconds for a call: those that hang are in neither time."""
LOOP_LIMIT = 60.0
PIECE, ENOUGH = 50, 0.5
"""Rows that the bare loop is asked about at once; seconds after which its rate in a query of a pair is known, once some
rows of every batch were asked."""
MOST_EACH = 400
"""Scenes of a regime: of pairs with a closed form, of which a campaign has twice as many, more change nothing."""
AGAIN = 4
"""One row in so many is asked once more where others were lost."""
HALF = 0.5
"""Rate of screening by that of the loop which is aimed at."""
LOST = (Status.CRASHED, Status.TIMED_OUT, Status.SKIPPED)
PARTS = ("scenes", "engine", "reference", "judge", "count")


@dataclass
class Times:
    """Seconds of the processor for some scenes and queries, by part of the screening, and of the bare loop."""

    asked: int = 0
    bare: float = 0.0
    wall: float = 0.0
    lost: float = 0.0
    parts: Counter[str] = field(default_factory=Counter)

    @contextmanager
    def timed(self, part: str, worker: EngineWorker | None = None) -> Iterator[None]:
        """Add the block's time to a part, and that of the worker's processes."""
        began, wall = _processor(worker), time.perf_counter()
        yield
        self.parts[part] += _processor(worker) - began
        self.wall += time.perf_counter() - wall

    def add(self, other: Times) -> None:
        """Add those of other scenes."""
        self.asked, self.bare, self.wall = self.asked + other.asked, self.bare + other.bare, self.wall + other.wall
        self.lost += other.lost
        self.parts.update(other.parts)

    def scale(self, factor: float) -> None:
        """Take these for those of so many times as many scenes."""
        self.wall *= factor
        for part in self.parts:
            self.parts[part] *= factor

    @property
    def screening(self) -> float:
        """Seconds of all parts."""
        return sum(self.parts.values())

    @property
    def ratio(self) -> float:
        """Rate of the screening by that of the bare loop."""
        return self.bare / max(self.screening, 1e-9)

    def line(self, name: str) -> str:
        """Row of the table."""
        micro = 1e6 / max(self.asked, 1)
        parts = "".join(f"{micro * time:9.1f}" for time in (*(self.parts[part] for part in PARTS), self.lost))
        totals = f"{micro * self.bare:9.1f}{micro * self.screening:9.1f}{parts}"
        rates = f"{self.asked / max(self.screening, 1e-9):9.0f}{self.asked / max(self.wall, 1e-9):9.0f}"
        return f"{name:50}{self.asked:8}{totals}{rates}{self.ratio:7.2f}"


HEADER = f"{'':50}{'asked':>8}" + "".join(
    f"{word:>9}" for word in ("bare", "screened", *PARTS, "lost", "per s", "wall")
) + "  ratio"  # fmt: skip


def _processor(worker: EngineWorker | None) -> float:
    """Processor time of this process, and of those that hold the engine."""
    own = time.process_time()
    return own if worker is None else own + _of_group(worker.process_id)


def _of_group(process: int) -> float:
    """Processor time of a process and all below it, of those that have ended too, as Linux counts it."""
    try:
        ended = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[13:15]
        own = int(Path(f"/proc/{process}/schedstat").read_text(encoding="ascii").split()[0]) / 1e9
    except (OSError, IndexError):
        return 0.0  # it has ended just now: what it took is noise
    gone = sum(map(int, ended)) / os.sysconf("SC_CLK_TCK")
    return own + gone + sum(_of_group(child) for child in _children(process))


def _children(process: int) -> list[int]:
    try:
        text = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="ascii")
    except OSError:
        return []
    return [int(word) for word in text.split()]


@dataclass
class Bench:
    """Engines, their workers and judges."""

    engines: dict[str, Engine]
    workers: dict[str, EngineWorker]
    judges: dict[str, Judges]

    def measure(self, pair: PairKey, number: int, each: int) -> dict[tuple[str, str], Times]:
        """Screen a shard of a pair, and have the same scenes answered in a bare loop: times by engine and query."""
        regimes = regimes_for(self.engines.values())
        drawing = Times()
        Batch.draw(pair, 1, (number,), each, regimes)  # reads the models
        with drawing.timed("scenes"):
            batches = Batch.draw(pair, 1, (number,), each, regimes)
        asked = [
            (name, cell)
            for cell in cells()
            for name, engine in self.engines.items()
            if (cell.type_a, cell.type_b) == pair and batches[0].is_of(cell.query) and engine.support(cell.query, *pair)
        ]
        found = {(name, cell.query): Times() for name, cell in asked}
        answered: dict[tuple[str, str], list[NDArray[np.bool_]]] = {key: [] for key in found}
        for batch in batches:
            for name, cell in asked:
                times = found[name, cell.query]
                answers = self._screen(name, cell, batch, times)
                there = ~np.isin(answers.status, LOST)
                answered[name, cell.query].append(there)
                times.asked += int(there.sum())
        for name in self.engines:
            mine = {key[1]: rows for key, rows in answered.items() if key[0] == name}
            for query, seconds in _bare(name, pair, list(_pieces(batches, mine))).items():
                found[name, query].bare += seconds
        for times in found.values():
            times.parts["scenes"] += drawing.parts["scenes"] / len(found)
            times.wall += drawing.wall / len(found)
        return found

    def _screen(self, name: str, cell: Cell, batch: Batch, times: Times) -> Answers:
        answers, asking = self._answered(name, cell, batch, np.arange(len(batch)))
        there = np.flatnonzero(~np.isin(answers.status, LOST))
        if 0 < len(there) < len(batch):
            whole, again = asking.screening, there[:: max(1, min(AGAIN, len(there) // PIECE))]
            _, asking = self._answered(name, cell, batch, again)
            asking.scale(len(there) / len(again))
            times.lost += whole - asking.screening
        times.add(asking)
        watch.taken()
        judged = Times()
        with judged.timed("judge"), watch.timed("judge"):
            screening = self.judges[name].screen(cell, batch.a, batch.b, batch.motion, answers)
        split = watch.taken()
        judged.parts["reference"] = judged.parts["judge"] * split.get("reference", 0.0) / sum(split.values())
        judged.parts["judge"] -= judged.parts["reference"]
        times.add(judged)
        with times.timed("count"):
            screening.counts(batch.groups)
        return answers

    def _answered(self, name: str, cell: Cell, batch: Batch, rows: NDArray[np.int_]) -> tuple[Answers, Times]:
        worker, times, some = self.workers[name], Times(), [side[rows] for side in batch.rows]
        with times.timed("engine", worker):
            answers = worker.answer(
                cell.query, cell.type_a, cell.type_b, *some, groups=batch.groups[rows], give_up_after=1
            )
        return answers, times


Rows = list[list[float]]


@dataclass(frozen=True)
class Piece:
    """Rows of one query for the bare loop, of both sides; `first` of their batch and query or not."""

    query: str
    a: Rows
    b: Rows
    first: bool


def _pieces(batches: list[Batch], answered: dict[str, list[NDArray[np.bool_]]]) -> Iterator[Piece]:
    """What is to be asked, without what crashes or hangs: some rows of each batch and all regimes, by all queries.

    What an engine keeps of the last few shapes thus serves all queries, as it does in the screening.
    """
    steps = [-(-len(batch) // PIECE) for batch in batches]
    for part in range(max(steps)):
        for i, batch in enumerate(batches):
            rows_a, rows_b = batch.rows
            for query, there in answered.items():
                rows = np.flatnonzero(there[i])[part :: steps[i]]
                if part < steps[i] and len(rows):
                    yield Piece(query, rows_a[rows].tolist(), rows_b[rows].tolist(), part == 0)


def _bare(name: str, pair: PairKey, pieces: list[Piece]) -> Counter[str]:
    """Seconds that the engine alone takes for each query, in a process that knows nothing of the scenes yet.

    A piece that is not asked, or in which the engine is lost all the same, counts like the others of its query.
    """
    context = multiprocessing.get_context("forkserver")
    seconds: Counter[str] = Counter()
    asked: Counter[str] = Counter()
    done: Counter[str] = Counter()
    for piece in pieces:
        asked[piece.query] += len(piece.a)
    at = 0
    while at < len(pieces):
        here, there = context.Pipe(duplex=False)
        child = context.Process(target=_loops, args=(there, name, pair, pieces[at:]))
        child.start()
        there.close()
        try:
            while at < len(pieces) and here.poll(LOOP_LIMIT):
                if (took := here.recv()) is not None:
                    seconds[pieces[at].query] += took
                    done[pieces[at].query] += len(pieces[at].a)
                at += 1
        except EOFError:
            pass
        at += 1
        child.kill()
        child.join()
    return Counter({query: seconds[query] * asked[query] / max(done[query], 1) for query in asked})


def _loops(channel: Any, name: str, pair: PairKey, pieces: list[Piece]) -> None:
    engine = load_engine(name)
    engine.warm()
    solvers = {query: engine.solver(query, *pair) for query in {piece.query for piece in pieces}}
    spent: Counter[str] = Counter()
    for piece in pieces:
        if spent[piece.query] > ENOUGH and not piece.first:
            channel.send(None)
            continue
        solve = solvers[piece.query]
        began = time.process_time()
        for a, b in zip(piece.a, piece.b, strict=True):
            try:
                solve(a, b)
            except Exception:
                continue
        took = time.process_time() - began
        spent[piece.query] += took
        channel.send(took)


def _chosen(arguments: list[str]) -> list[tuple[int, str, PairKey]]:
    """Pairs to be measured, with their numbers and names."""
    named = [(number, "–".join(kind.__name__ for kind in pair), pair) for number, pair in enumerate(TABLE)]
    wanted = {word for word in arguments if not word.startswith("-")}
    if wanted:
        named = [row for row in named if wanted & {row[1], *row[1].split("–")}]
    first, _, step = _option(arguments, "part", "1/1").partition("/")
    return named[int(first) - 1 :: int(step)]


def _option(arguments: list[str], name: str, default: str) -> str:
    return next((word.partition("=")[2] for word in arguments if word.startswith(f"--{name}=")), default)


def _scenes_each(pair: PairKey) -> int:
    each = scenes_each(pair, LARGEST_PASS)
    return min(each, MOST_EACH) if is_quick(*pair) else each


def summary(pairs: dict[str, Times]) -> str:
    """Say how many pairs reach a half, and which do not."""
    below = sorted((times.ratio, name) for name, times in pairs.items() if times.asked and times.ratio < HALF)
    asked = sum(1 for times in pairs.values() if times.asked)
    text = f"{asked - len(below)} of {asked} pairs are screened at {HALF:.0%} of the bare loop's rate or more"
    return text + ("; below: " + ", ".join(f"{name} {ratio:.2f}" for ratio, name in below) if below else "")


def main(arguments: list[str]) -> None:
    """Measure all pairs, or those that are asked for."""
    engines = _option(arguments, "engines", ",".join(ENGINES)).split(",")
    multiprocessing.set_forkserver_preload([__name__, *(f"oracles.engines.{name}_engine" for name in engines)])
    loaded = {name: load_engine(name) for name in engines}
    workers = {name: EngineWorker(name, CALL_LIMIT) for name in engines}
    bench = Bench(loaded, workers, {name: Judges(engine) for name, engine in loaded.items()})
    total, of_engine, of_pair = Times(), {name: Times() for name in engines}, dict[str, Times]()
    print(HEADER)
    for number, name, pair in _chosen(arguments):
        each = int(_option(arguments, "each", str(_scenes_each(pair))))
        together = of_pair[name] = Times()
        with batch_of(WORTH_COMPILING):  # as parts of a campaign, however small
            bench.measure(pair, 10_000 + number, 3)  # compiles and imports
            found = bench.measure(pair, number, each)
        for (engine, query), times in found.items():
            print(times.line(f"{name} {query} {engine}"))
            together.add(times)
            of_engine[engine].add(times)
        print(together.line(name), flush=True)
        if "--write" in arguments and together.asked:
            merge({name: {"screening": together.ratio}})
        total.add(together)
    for engine, times in of_engine.items():
        print(times.line(engine))
    print(total.line("all"))
    print(summary(of_pair), flush=True)
    for worker in workers.values():
        worker.close()


if __name__ == "__main__":
    main(sys.argv[1:])
