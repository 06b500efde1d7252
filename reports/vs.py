"""The pair table as the lecture's triangular "VS" matrix, with a legend; for `proxyproof table` and the README.

The measured numbers beside it (worst error, times, rates) are those that ``python -m tests.accuracy --write`` and
``python -m tests.benchmarks --write`` left in `measured.json`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import refimpl
from refimpl import flat
from refimpl.flat.pairs import PROBES as FLAT_PROBES
from refimpl.flat.pairs import SOLIDS as FLAT_SOLIDS
from refimpl.pairs import CLOSED, FINITE, ITERATIVE, PROBES, SOLIDS
from refimpl.sweeps.methods import methods_of

MEASURED = Path(__file__).parent / "measured.json"

EARLY = "+"
"""Marks pairs whose `intersect` has a cheaper test of its own."""

LETTERS = {CLOSED: "c", FINITE: "f", ITERATIVE: "i"}

EXPLANATION = (
    ("c", "closed form"),
    ("f", "finite: a bounded number of features or axes"),
    ("i", "iterative: a search that ends when its proven gap has closed to rounding"),
    (EARLY, "intersect has a cheaper test of its own"),
)


@dataclass(frozen=True)
class Algorithm:
    """An algorithm with its mark, such as c7, and the pairs that use it."""

    mark: str
    name: str
    pairs: tuple[str, ...]


@dataclass(frozen=True)
class Matrix:
    """Types against types: `cells[row][column]` is a mark, empty below the diagonal."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    algorithms: tuple[Algorithm, ...]


def matrix(*, in_plane: bool = False) -> Matrix:
    """Lay out `refimpl.table()`, or `refimpl.flat.table()`."""
    table, probes, solids = (flat.table(), FLAT_PROBES, FLAT_SOLIDS) if in_plane else (refimpl.table(), PROBES, SOLIDS)
    pairs: dict[tuple[str, str], list[str]] = {}
    for (a, b), rule in table.items():
        pairs.setdefault((LETTERS[rule.exactness], rule.algorithm), []).append(f"{a.__name__}–{b.__name__}")
    numbers = dict.fromkeys(LETTERS.values(), 0)
    marks: dict[tuple[str, str], str] = {}
    for letter, algorithm in sorted(pairs, key=lambda key: key[0]):
        numbers[letter] += 1
        marks[letter, algorithm] = f"{letter}{numbers[letter]}"

    def cell(a: type[refimpl.Proxy], b: type[refimpl.Proxy]) -> str:
        rule = table.get((a, b))
        if rule is None:
            return ""
        return marks[LETTERS[rule.exactness], rule.algorithm] + (EARLY if rule.meets is not None else "")

    kinds = (*probes, *solids)
    return Matrix(
        rows=tuple(kind.__name__ for kind in kinds),
        columns=tuple(kind.__name__ for kind in solids),
        cells=tuple(tuple(cell(a, b) for b in solids) for a in kinds),
        algorithms=tuple(Algorithm(mark, key[1], tuple(pairs[key])) for key, mark in marks.items()),
    )


def as_text() -> str:
    """Return the matrices of space and of the plane, each with its legend, for a terminal."""
    words = [f"{mark:<5}{meaning}" for mark, meaning in EXPLANATION]
    return "\n".join([*_in_lines(matrix()), "", *_in_lines(matrix(in_plane=True)), "", *words]) + "\n"


def _in_lines(vs: Matrix) -> list[str]:
    first = max(map(len, ("VS", *vs.rows)))
    widths = [max(len(name), *(len(row[i]) for row in vs.cells)) for i, name in enumerate(vs.columns)]
    lines = [
        "  ".join([heading.ljust(first), *(text.ljust(w) for text, w in zip(row, widths, strict=True))]).rstrip()
        for heading, row in [("VS", vs.columns), *zip(vs.rows, vs.cells, strict=True)]
    ]
    widest = max(len(algorithm.name) for algorithm in vs.algorithms)
    legend = [f"{a.mark:<5}{a.name:<{widest}}  {', '.join(a.pairs)}" for a in vs.algorithms]
    return [*lines, "", *legend]


def as_markdown() -> str:
    """Return the matrix, its legend and the measured numbers in GitHub-flavoured Markdown."""
    vs = matrix()
    lines = [f"| VS | {' | '.join(vs.columns)} |", f"| --- |{' --- |' * len(vs.columns)}"]
    lines += [f"| **{name}** | {' | '.join(row)} |" for name, row in zip(vs.rows, vs.cells, strict=True)]
    words = "; ".join(f"**{mark}** {meaning}" for mark, meaning in EXPLANATION)
    return "\n".join([*lines, "", f"{words}.", "", *_details()]) + "\n"


def _details() -> list[str]:
    """One line for each pair: algorithm, worst error seen, and times; folded away."""
    vs, measured = matrix(), _measured()
    by_pair = {pair: algorithm for algorithm in vs.algorithms for pair in algorithm.pairs}
    lines = [
        f"<details><summary>All {len(by_pair)} pairs: algorithm, worst error seen, time</summary>",
        "",
        "Error relative to the scene's size, against 50 digits; median time of one pair alone, and of one in batches",
        "of 10 000; how many times the rate of python-fcl and PyBullet the latter is. Everything in one thread. How",
        "`sweep` finds the first contact of moving proxies, in translation and in rigid motion.",
        "",
        "| pair | | algorithm | worst error | alone | in a batch | × FCL | × Bullet | translation | rigid motion |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for a, b in refimpl.table():
        pair = f"{a.__name__}–{b.__name__}"
        algorithm, seen = by_pair[pair], measured.get(pair, {})
        columns = [
            _number(seen.get("error"), "{:.0e}"),
            _number(seen.get("alone_us"), "{:.0f} µs"),
            _number(seen.get("batch_us"), "{:.2g} µs"),
            _number(seen.get("fcl"), "{:.1f}"),
            _number(seen.get("bullet"), "{:.1f}"),
            *(methods_of(a, b) or ("–", "–")),
        ]
        lines.append(f"| {pair} | {algorithm.mark} | {algorithm.name} | {' | '.join(columns)} |")
    return [*lines, "", "</details>"]


def _number(value: float | None, form: str) -> str:
    return "–" if value is None else form.format(value)


@cache
def _measured() -> dict[str, dict[str, float | None]]:
    """Numbers by pair; none where nothing was measured."""
    if not MEASURED.exists():
        return {}
    pairs: dict[str, dict[str, float | None]] = json.loads(MEASURED.read_text("utf-8"))["pairs"]
    return pairs
