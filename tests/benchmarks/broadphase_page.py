"""The page of the broad-phase benchmark: tables in Markdown, and two plots."""

from __future__ import annotations

import math
import platform
from pathlib import Path

import numpy as np

from reports.studies.plots import COLOURS, MARKS, figure
from tests.benchmarks.broadphase import ASKED_AT, WORK, Cells, Course, Results

PAGE = "broadphase.md"


def told(results: Results) -> str:
    """All tables."""
    counts = sorted({n for course in results.courses for n in course.pairs})
    at = max((n for n in counts if n <= ASKED_AT), default=0)
    parts = [
        "# Broad phase, measured",
        "Made by `python -m tests.benchmarks.broadphase --write`; seconds of the processor, numpy "
        f"{np.__version__}, Python {platform.python_version()}. The numbers are this machine's.",
        f"## {at} balls of equal density",
        "Building and all pairs; the factor is against the fastest public library that gives the same pairs of boxes, "
        "and the one that gives pairs of balls of one radius only. `FCL` calls Python for each pair.",
        compared(results.courses, at),
        "## Growth",
        "Exponents of seconds against the number of objects, from 10 000 on; 1 is linear. Queries are a thousand "
        "boxes: 0 is independent of the number. – means: not asked, for it would take too long.",
        growth(results.courses, counts),
        "![Seconds against objects](broadphase.svg)",
        "## Moving objects against building anew",
        "All objects, or one in a hundred, move by a tenth of their size.",
        moving(results),
        "## The size of a grid's cells",
        "Small cells hold each object many times, and an array has room for all of them, empty or not; large cells "
        "hold many objects that are all compared. Crosses are the sizes that the grids choose themselves.",
        cells(results.cells),
        "![Seconds and memory against the size of cells](cells.svg)",
    ]
    return "\n\n".join(parts) + "\n"


def compared(courses: list[Course], at: int) -> str:
    """Table: seconds at one number of objects, and factors to the public libraries."""
    public = [course for course in courses if course.public and at in course.pairs]
    of_boxes = [c.total(at) for c in public if c.name != "scipy cKDTree, balls"]
    of_balls = [c.total(at) for c in public if c.name == "scipy cKDTree, balls"]
    lines = ["| structure | build s | pairs s | both s | pairs | × boxes | × balls |", "| --- " * 7 + "|"]
    for course in sorted((c for c in courses if at in c.pairs), key=lambda c: c.total(at)):
        both = course.total(at)
        factors = [_short(both / min(rivals)) if rivals else "–" for rivals in (of_boxes, of_balls)]
        build, pairs = (_short(course.seconds[work][at]) for work in ("build", "pairs"))
        name = f"*{course.name}*" if course.public else course.name
        lines.append(f"| {name} | {build} | {pairs} | {_short(both)} | {course.pairs[at]} | {' | '.join(factors)} |")
    return "\n".join(lines)


def growth(courses: list[Course], counts: list[int]) -> str:
    """Table: exponents, and seconds for building and all pairs at each number of objects."""
    lines = ["| structure | build | pairs | queries | " + " | ".join(f"{n:.0e}" for n in counts) + " |"]
    lines.append("| --- " * (4 + len(counts)) + "|")
    for course in courses:
        exponents = " | ".join(_short(course.exponent(work)) for work in WORK)
        seconds = " | ".join(_short(course.total(n)) for n in counts)
        lines.append(f"| {course.name} | {exponents} | {seconds} |")
    return "\n".join(lines)


def moving(results: Results) -> str:
    """Table: seconds to follow motion, and how many times as fast as building that is."""
    lines = ["| structure | build s | all move s | × faster | 1 % move s | × faster |", "| --- " * 6 + "|"]
    for row in results.moves:
        values = [row.build, row.all, row.build / max(row.all, 1e-9), row.few, row.build / max(row.few, 1e-9)]
        lines.append(f"| {row.name} | {' | '.join(map(_short, values))} |")
    return "\n".join(lines)


def cells(found: list[Cells]) -> str:
    """Table: sizes of cells, seconds and memory."""
    lines = ["| grid | cell, in box lengths | seconds | MB |", "| --- " * 4 + "|"]
    for row in found:
        size = f"{row.size:.3g}{' (chosen)' if row.chosen else ''}"
        lines.append(f"| {row.name} | {size} | {_short(row.seconds)} | {row.memory / 1e6:.3g} |")
    return "\n".join(lines)


def _short(value: float) -> str:
    return f"{value:.2g}" if math.isfinite(value) else "–"


def draw(courses: list[Course], path: Path) -> None:
    """Seconds against objects, log-log, a panel for each kind of work; public libraries dashed."""
    with figure(path, columns=len(WORK), width=11.0, height=4.2) as axes:
        for axis, work in zip(axes, WORK, strict=True):
            for i, course in enumerate(courses):
                points = sorted(course.seconds[work].items())
                if points:
                    axis.loglog(
                        *zip(*points, strict=True), color=COLOURS[i % len(COLOURS)], marker=MARKS[i // 2 % len(MARKS)],
                        markersize=4, linestyle="--" if course.public else "-", label=course.name,
                    )  # fmt: skip
            axis.set_title(work if work != "queries" else "1 000 box queries", fontsize="medium")
            axis.set_xlabel("objects")
        axes[0].set_ylabel("seconds of the processor")
        axes[1].legend(fontsize="x-small")


def draw_cells(found: list[Cells], path: Path) -> None:
    """Time and memory against the size of cells."""
    with figure(path, columns=2, width=9.0) as axes:
        for i, name in enumerate(dict.fromkeys(row.name for row in found)):
            fixed = [row for row in found if row.name == name and not row.chosen]
            for axis, value in zip(axes, ("seconds", "memory"), strict=True):
                sizes = [row.size for row in fixed]
                axis.loglog(sizes, [getattr(row, value) for row in fixed], COLOURS[i], marker=MARKS[i], label=name)
                for row in found:
                    if row.name == name and row.chosen:
                        axis.loglog([row.size], [getattr(row, value)], "x", color=COLOURS[i], markersize=10)
        for axis, label in zip(axes, ("seconds to build and find all pairs", "bytes of the cells' lists"), strict=True):
            axis.set_xlabel("edge of a cell, in lengths of a box")
            axis.set_ylabel(label)
        axes[0].legend(fontsize="small")


def write(results: Results, folder: Path) -> None:
    """Write the page and its plots."""
    folder.mkdir(parents=True, exist_ok=True)
    draw(results.courses, folder / "broadphase.svg")
    draw_cells(results.cells, folder / "cells.svg")
    (folder / PAGE).write_text(told(results), encoding="utf-8")
