"""All broad-phase structures side by side: ``python -m tests.benchmarks.broadphase [--write [FOLDER]] [--most N]``.

Balls of one radius at equal density, so that each box meets about six others, from 1e3 to 1e6 (`--most`): seconds to
build, to find all pairs, and to answer a thousand box queries; public libraries beside them; moving objects against
building anew; and the size of a grid's cells against time and memory. Structures take turns, and the least of several
runs counts, in seconds of the processor, so that what else runs on the machine matters little. With `--write` the
tables and plots in reports/studies are made again.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from rich.console import Console
from rich.markdown import Markdown

import reports.studies
from refimpl.broadphase import STRUCTURES, ArrayGrid, BroadPhase, HashGrid
from refimpl.linear import Array
from tests.benchmarks import rivals

RADIUS, DENSITY = 0.5, 0.75
COUNTS = (1_000, 3_000, 10_000, 30_000, 100_000, 1_000_000)
ASKED_AT = 100_000
QUERIES = 1000
PATIENCE = 15.0
"""Seconds that a run may take; structures that would take longer for more objects are not asked."""
REPEATS = 2
CELLS = tuple(2.0 ** (k / 2) for k in range(-6, 8))
"""Edges of cells, in lengths of a box."""
CELLS_AT = 5_000
WORK = ("build", "pairs", "queries")
T = TypeVar("T")


@dataclass
class Course:
    """Seconds of one structure: of each kind of work, by the number of objects; and how many pairs it found."""

    name: str
    public: bool = False
    seconds: dict[str, dict[int, float]] = field(default_factory=lambda: {work: {} for work in WORK})
    pairs: dict[int, int] = field(default_factory=dict)

    def note(self, work: str, count: int, seconds: float) -> None:
        """Keep the least."""
        self.seconds[work][count] = min(seconds, self.seconds[work].get(count, np.inf))

    def total(self, count: int) -> float:
        """Seconds to build and to find all pairs; infinite if it was not asked."""
        return self.seconds["build"].get(count, np.inf) + self.seconds["pairs"].get(count, np.inf)

    def exponent(self, work: str, least: int = 10_000) -> float:
        """Slope of the logarithms of seconds against objects; NaN of fewer than two."""
        points = [(n, s) for n, s in self.seconds[work].items() if n >= least and s > 0]
        if len(points) < 2:
            return float("nan")
        return float(np.polyfit(*np.log(points).T, 1)[0])


@dataclass(frozen=True)
class Moves:
    """Seconds to build, and to follow all objects, or one in a hundred, that move by a tenth of their size."""

    name: str
    build: float
    all: float
    few: float


@dataclass(frozen=True)
class Cells:
    """A plain grid with cells of one size: seconds to build and find all pairs, bytes of its lists."""

    name: str
    size: float
    seconds: float
    memory: int
    chosen: bool


@dataclass(frozen=True)
class Results:
    """All that is measured in a run."""

    courses: list[Course]
    moves: list[Moves]
    cells: list[Cells]


def crowd(count: int) -> Array:
    """Centres of balls at equal density."""
    return np.random.default_rng(count).random((count, 3)) * (count / DENSITY) ** (1 / 3)


def timed(work: Callable[..., T], *arguments: Any) -> tuple[float, T]:
    """Seconds of the processor, and the result."""
    began = time.process_time()
    found = work(*arguments)
    return time.process_time() - began, found


def measure(counts: tuple[int, ...], patience: float = PATIENCE, repeats: int = REPEATS) -> list[Course]:
    """Ask all structures, and all public libraries that are there, for each number of objects in turn."""
    libraries = rivals.available()
    courses = {name: Course(name) for name in STRUCTURES} | {name: Course(name, public=True) for name in libraries}
    for place, count in enumerate(counts):
        center = crowd(count)
        for _ in range(1 if count > ASKED_AT else repeats):
            for name, course in courses.items():
                if place and _expected(course, counts[place - 1], count) > patience:
                    continue
                if course.public:
                    library = libraries[name]
                    seconds, made = timed(library.build, library.prepare(center, RADIUS))
                    course.note("build", count, seconds)
                    seconds, course.pairs[count] = timed(library.count, made)
                    course.note("pairs", count, seconds)
                else:
                    _one(course, STRUCTURES[name].make(), center)
    return list(courses.values())


def _expected(course: Course, before: int, count: int) -> float:
    """Seconds that more objects will take, going on as from the last but one number to the last."""
    now = course.total(before)
    earlier = [n for n in course.pairs if n < before]
    if not earlier or now == np.inf:
        return now
    slope = np.log(now / course.total(earlier[-1])) / np.log(before / earlier[-1])
    return float(now * (count / before) ** slope)


def _one(course: Course, structure: BroadPhase, center: Array) -> None:
    """Build, all pairs, queries."""
    count = len(center)
    lower, upper = center - RADIUS, center + RADIUS
    seconds, _ = timed(structure.build, lower, upper)
    course.note("build", count, seconds)
    seconds, pairs = timed(structure.pairs)
    course.note("pairs", count, seconds)
    course.pairs[count] = len(pairs)
    asked = np.random.default_rng(1).choice(center, QUERIES) + RADIUS
    seconds, _ = timed(structure.query_boxes, asked - RADIUS, asked + RADIUS)
    course.note("queries", count, seconds)


def measure_moves(count: int, repeats: int = REPEATS) -> list[Moves]:
    """Move all objects, and one in a hundred, against building anew."""
    center = crowd(count)
    step = np.random.default_rng(2).uniform(-1, 1, center.shape) * RADIUS / 5
    some = np.arange(0, count, 100)
    found = []
    for name, row in STRUCTURES.items():
        seconds = np.full(3, np.inf)
        for _ in range(repeats):
            structure = row.make()
            build = timed(structure.build, center - RADIUS, center + RADIUS)[0]
            all_ids = structure.ids.copy()
            follow = timed(structure.update, all_ids, center + step - RADIUS, center + step + RADIUS)[0]
            few = timed(structure.update, some, center[some] - RADIUS, center[some] + RADIUS)[0]
            seconds = np.minimum(seconds, [build, follow, few])
        found.append(Moves(name, *seconds.tolist()))
    return found


def measure_cells(count: int, sizes: tuple[float, ...] = CELLS, repeats: int = REPEATS) -> list[Cells]:
    """Plain grids with cells of each size, and those of their own choice."""
    center = crowd(count)
    lower, upper = center - RADIUS, center + RADIUS

    def grids() -> Iterator[tuple[str, ArrayGrid | HashGrid, bool]]:
        for name, make in (("array grid", ArrayGrid), ("hash grid", HashGrid)):
            yield from ((name, make(2 * RADIUS * size, levels=1), False) for size in sizes)
            yield name, make(), True

    found = []
    for name, grid, chosen in grids():
        seconds = min(timed(_both, grid, lower, upper)[0] for _ in range(repeats))
        found.append(Cells(name, grid.cell_size / (2 * RADIUS), seconds, grid.memory, chosen))
    return found


def _both(structure: BroadPhase, lower: Array, upper: Array) -> None:
    structure.build(lower, upper).pairs()


def main(words: list[str] | None = None) -> None:
    """Measure, print, and write if asked to."""
    from tests.benchmarks import broadphase_page  # noqa: PLC0415  it imports this module

    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.broadphase", description=__doc__)
    here = Path(str(reports.studies.__file__)).parent
    parser.add_argument("--write", nargs="?", type=Path, const=here, help="write page and plots into this folder")
    parser.add_argument("--most", type=int, default=COUNTS[-1], help="objects at most")
    options = parser.parse_args(words)
    counts = tuple(n for n in COUNTS if n <= options.most) or (options.most,)
    at = min(ASKED_AT, options.most)
    results = Results(measure(counts), measure_moves(at), measure_cells(min(CELLS_AT, options.most)))
    Console().print(Markdown(broadphase_page.told(results)))
    if options.write:
        broadphase_page.write(results, options.write)
        Console().print(f"written to {options.write}")


if __name__ == "__main__":
    main()
