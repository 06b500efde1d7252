"""Decide queries about moving triangles: ``python -m tests.benchmarks.queries [FOLDER] [--conservative]``.

Reads the format of the public benchmark of Wang et al. 2021 (A Large-Scale Benchmark and an Inclusion-Based Algorithm
for Continuous Collision Detection), of which sample queries are at
https://github.com/Continuous-Collision-Detection/Sample-Queries, and prints for each folder how many answers differ
from its ground truth, and the time a query. Every answer is also proven by its certificate.

All files FOLDER/**/*.csv are read: those in a folder `vertex-face`, or with a name that ends in `vf`, and those in
`edge-edge`, or `ee`. Each point is a row of six whole numbers, numerator and denominator of each coordinate; eight
rows are a query, four points at time 0 (the vertex and the face's corners, or the ends of both edges), then the
same at time 1. The ground truth, 0 or 1, is the seventh column, or a list of booleans in the file
`mma_bool/NAME_mma_bool.json` beside the folder `queries` of NAME.csv. Without FOLDER the queries are those of
`tests.moving`, and their ground truth is that of 50 digits. `--conservative` runs the common method in doubles beside
it (`tests.benchmarks.conservative`), which takes far longer.
"""

from __future__ import annotations

import json
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from refimpl.proof.triangles import check_edge_edge, check_vertex_face
from refimpl.sweeps.triangles import edge_edge, vertex_face
from tests.benchmarks.conservative import collides
from tests.moving import FAMILIES
from tests.truth.moving import first_contact

MAX_BYTES = 256 << 20  # of one file
MAX_DIGITS = 400  # of one number; doubles need up to 325
ROW = re.compile(rf"-?\d{{1,{MAX_DIGITS}}}(,-?\d{{1,{MAX_DIGITS}}}){{5}}(,[01])?", re.ASCII)
ENDINGS = {"vertex-face": "vf", "edge-edge": "ee"}
DECIDE = {"vertex-face": (vertex_face, check_vertex_face), "edge-edge": (edge_edge, check_edge_edge)}

Points = list[list[Any]]


class BadQueries(ValueError):
    """A file is not in the benchmark's format; the text says where."""


@dataclass(frozen=True)
class Query:
    """Four points at time 0 and at time 1, and whether they are known to touch."""

    kind: str
    start: Points
    end: Points
    truth: bool


def own(each: int = 50) -> Iterator[tuple[str, list[Query]]]:
    """Every family of degenerate queries, with what 50 digits say."""
    for kind in DECIDE:
        for name, draw in FAMILIES.items():
            rng = np.random.default_rng([7, *map(ord, name)])
            drawn = [draw(rng) for _ in range(each)]
            yield f"{kind}, {name}", [Query(kind, *q, first_contact(kind, *q) is not None) for q in drawn]


def queries(folder: Path) -> Iterator[tuple[str, list[Query]]]:
    """Every file's queries, and the folder that it is in."""
    found = False
    for path in sorted(folder.rglob("*.csv")):
        kind = kind_of(path)
        if kind is not None:
            found = True
            yield str(path.parent.relative_to(folder)), read(path, kind)
    if not found:
        raise BadQueries(f"{folder}: no file vertex-face/*.csv, edge-edge/*.csv, *vf.csv or *ee.csv in it")


def kind_of(path: Path) -> str | None:
    """What a file's queries are about, by its folder's name or its own."""
    for kind, ending in ENDINGS.items():
        if path.parent.name == kind or path.stem.endswith(ending):
            return kind
    return None


def read(path: Path, kind: str) -> list[Query]:
    """Queries of one file."""
    if path.stat().st_size > MAX_BYTES:
        raise BadQueries(f"{path}: more than {MAX_BYTES >> 20} MiB")
    rows = [row(line, path, i) for i, line in enumerate(path.read_text("ascii").splitlines(), 1) if line[:1] != "#"]
    if len(rows) % 8:
        raise BadQueries(f"{path}: {len(rows)} rows, which is not a multiple of 8")
    blocks = [rows[i : i + 8] for i in range(0, len(rows), 8)]
    truths = truths_of(path, blocks)
    return [
        Query(kind, [p for p, _ in block[:4]], [p for p, _ in block[4:]], truth)
        for block, truth in zip(blocks, truths, strict=True)
    ]


def row(line: str, path: Path, number: int) -> tuple[list[Fraction], bool | None]:
    """A point, and the ground truth if it stands there."""
    words = line.strip().split(",")
    if not ROW.fullmatch(line.strip()) or 0 in map(int, words[1:6:2]):
        raise BadQueries(
            f"{path}, line {number}: expected 6 whole numbers of at most {MAX_DIGITS} digits, denominators not 0, and "
            f"0 or 1 if there is a seventh, got {line[:80]!r}"
        )
    x, y, z = (Fraction(int(words[i]), int(words[i + 1])) for i in (0, 2, 4))
    return [x, y, z], words[6] == "1" if len(words) == 7 else None


def truths_of(path: Path, blocks: list[list[tuple[list[Fraction], bool | None]]]) -> list[bool]:
    """Ground truth of each query, from the rows or from the list beside them."""
    columns = [{truth for _, truth in block} for block in blocks]
    if all(len(column) == 1 and None not in column for column in columns):
        return [bool(column.pop()) for column in columns]
    beside = path.parent.parent / "mma_bool" / f"{path.stem}_mma_bool.json"
    if not beside.is_file():
        raise BadQueries(f"{path}: no ground truth, neither the same for the 8 rows of a query nor in {beside}")
    if beside.stat().st_size > MAX_BYTES:
        raise BadQueries(f"{beside}: more than {MAX_BYTES >> 20} MiB")
    found = json.loads(beside.read_text("ascii"))
    if not isinstance(found, list) or len(found) != len(blocks) or not all(isinstance(t, bool) for t in found):
        raise BadQueries(f"{beside}: expected a list of {len(blocks)} booleans")
    return found


@dataclass
class Count:
    """Answers to the queries of a folder."""

    queries: int = 0
    hits: int = 0
    falsely: int = 0
    missed: int = 0
    conservative_falsely: int = 0
    conservative_missed: int = 0
    seconds: float = 0.0
    conservative_seconds: float = 0.0


def measure(count: Count, query: Query, conservative: bool) -> None:
    """Decide one query, prove the answer, and count it."""
    decide, check = DECIDE[query.kind]
    began = time.process_time()
    found = decide(query.start, query.end)
    count.seconds += time.process_time() - began
    low, high = check(found.certificate, query.start, query.end)
    assert (found.hit and (low, high) == (found.low, found.high)) or (not found.hit and low == float("inf"))
    count.queries += 1
    count.hits += query.truth
    count.falsely += found.hit and not query.truth
    count.missed += query.truth and not found.hit
    if conservative:
        began = time.process_time()
        said = collides(query.kind, query.start, query.end)
        count.conservative_seconds += time.process_time() - began
        count.conservative_falsely += said and not query.truth
        count.conservative_missed += query.truth and not said


def main(arguments: list[str]) -> None:
    """Print a row for each folder or family."""
    folders = [word for word in arguments if not word.startswith("-")]
    conservative = "--conservative" in arguments
    if len(folders) > 1 or set(arguments) - {*folders, "--conservative"} or not all(Path(f).is_dir() for f in folders):
        sys.exit("usage: python -m tests.benchmarks.queries [FOLDER] [--conservative]")
    counts: dict[str, Count] = {}
    try:
        for name, found in queries(Path(folders[0])) if folders else own():
            count = counts.setdefault(name, Count())
            for query in found:
                measure(count, query, conservative)
    except (BadQueries, UnicodeDecodeError, json.JSONDecodeError) as error:
        sys.exit(f"cannot read the queries: {error}")
    if not any(count.queries for count in counts.values()):
        sys.exit("no queries in the files")
    show(counts, conservative)


def show(counts: dict[str, Count], conservative: bool) -> None:
    """Print the table, with a row for all."""
    table = Table("queries of", "number", "collisions", "false", "missed", "ms a query")
    if conservative:
        for title in ("conservative: false", "missed", "ms a query"):
            table.add_column(title)
    total = Count(*(sum(getattr(c, name) for c in counts.values()) for name in Count.__dataclass_fields__))
    for name, c in [*counts.items(), ("all", total)]:
        cells = [c.queries, c.hits, c.falsely, c.missed, f"{c.seconds / max(c.queries, 1) * 1e3:.2f}"]
        more = [
            c.conservative_falsely,
            c.conservative_missed,
            f"{c.conservative_seconds / max(c.queries, 1) * 1e3:.1f}",
        ]
        table.add_row(name, *map(str, cells + (more if conservative else [])))
    Console(width=150).print(table)


if __name__ == "__main__":
    main(sys.argv[1:])
