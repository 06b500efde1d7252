"""The pair table as the lecture's triangular "VS" matrix, with a legend; for `proxyproof table` and the README."""

from __future__ import annotations

from dataclasses import dataclass

import refimpl
from refimpl.pairs import CLOSED, PROBES, SOLIDS

EARLY = "+"
"""Marks pairs whose `intersect` has a cheaper test of its own."""

EXPLANATION = (
    ("c", "closed form"),
    ("f", "finite: a bounded number of features or axes"),
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


def matrix() -> Matrix:
    """Lay out `refimpl.table()`."""
    table = refimpl.table()
    pairs: dict[tuple[str, str], list[str]] = {}
    for (a, b), rule in table.items():
        letter = "c" if rule.exactness == CLOSED else "f"
        pairs.setdefault((letter, rule.algorithm), []).append(f"{a.__name__}–{b.__name__}")
    numbers = {"c": 0, "f": 0}
    marks: dict[tuple[str, str], str] = {}
    for letter, algorithm in sorted(pairs, key=lambda key: key[0]):
        numbers[letter] += 1
        marks[letter, algorithm] = f"{letter}{numbers[letter]}"

    def cell(a: type[refimpl.Proxy], b: type[refimpl.Proxy]) -> str:
        rule = table.get((a, b))
        if rule is None:
            return ""
        letter = "c" if rule.exactness == CLOSED else "f"
        return marks[letter, rule.algorithm] + (EARLY if rule.meets is not None else "")

    kinds = (*PROBES, *SOLIDS)
    return Matrix(
        rows=tuple(kind.__name__ for kind in kinds),
        columns=tuple(kind.__name__ for kind in SOLIDS),
        cells=tuple(tuple(cell(a, b) for b in SOLIDS) for a in kinds),
        algorithms=tuple(Algorithm(mark, key[1], tuple(pairs[key])) for key, mark in marks.items()),
    )


def as_text() -> str:
    """Return the matrix and its legend for a terminal."""
    vs = matrix()
    first = max(map(len, ("VS", *vs.rows)))
    widths = [max(len(name), *(len(row[i]) for row in vs.cells)) for i, name in enumerate(vs.columns)]
    lines = [
        "  ".join([heading.ljust(first), *(text.ljust(w) for text, w in zip(row, widths, strict=True))]).rstrip()
        for heading, row in [("VS", vs.columns), *zip(vs.rows, vs.cells, strict=True)]
    ]
    widest = max(len(algorithm.name) for algorithm in vs.algorithms)
    legend = [f"{a.mark:<5}{a.name:<{widest}}  {', '.join(a.pairs)}" for a in vs.algorithms]
    words = [f"{mark:<5}{meaning}" for mark, meaning in EXPLANATION]
    return "\n".join([*lines, "", *legend, "", *words]) + "\n"


def as_markdown() -> str:
    """Return the matrix and its legend in GitHub-flavoured Markdown."""
    vs = matrix()
    lines = [f"| VS | {' | '.join(vs.columns)} |", f"| --- |{' --- |' * len(vs.columns)}"]
    lines += [f"| **{name}** | {' | '.join(row)} |" for name, row in zip(vs.rows, vs.cells, strict=True)]
    legend = [f"- **{a.mark}** {a.name}: {', '.join(a.pairs)}" for a in vs.algorithms]
    words = "; ".join(f"**{mark}** {meaning}" for mark, meaning in EXPLANATION)
    return "\n".join([*lines, "", f"{words}.", "", *legend]) + "\n"
