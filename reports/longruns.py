"""What `proxyproof longruns` says and draws: many impacts in a row, by the reference and by PyBullet."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from html import escape

from oracles.longruns import (
    Cradle,
    Series,
    ball_in_box,
    ball_in_box_of_bullet,
    cradle,
    cradle_of_bullet,
)
from reports import text
from reports.markdown import table_lines
from reports.tables import Column, Entry, Table

BOUNCES = 1000
MARKS = (1, 3, 10, 30, 100, 300, 1000)
"""Numbers of bounces at which the energy is given."""

WIDTH, HEIGHT, MARGIN = 720, 320, 48
COLORS = ("#1f6f4a", "#b3261e", "#8a5a00")
DASHES = ("", "6 3", "2 3")


def measured() -> tuple[list[Series], list[Cradle]]:
    """Let the reference and PyBullet, by default and without damping, go on for 1000 bounces.

    Raises
    ------
    EngineUnavailable
        When PyBullet is not installed.
    """
    engines = [ball_in_box_of_bullet(BOUNCES, damped=damped) for damped in (True, False)]
    cradles = [cradle_of_bullet(damped=damped) for damped in (True, False)]
    return [ball_in_box(BOUNCES), *engines], [cradle(), *cradles]


def as_markdown(boxes: Sequence[Series], cradles: Sequence[Cradle]) -> str:
    """Both tables in Markdown, each below its caption."""
    lines: list[str] = []
    for table in (_energies(boxes), _cradles(cradles)):
        lines += [f"{table.caption}:", "", *table_lines(table), ""]
    return "\n".join(lines).rstrip() + "\n"


def _energies(boxes: Sequence[Series]) -> Table:
    rows = [(Entry(box.name), *(Entry(_energy(box, mark)) for mark in MARKS)) for box in boxes]
    columns = [Column("energy after bounces"), *(Column(str(mark), numeric=True) for mark in MARKS)]
    caption = "A ball in a box, e = 1 and no friction: its energy, as a share of that at the start; – where it rests"
    return Table(caption, tuple(columns), tuple(rows))


def _energy(box: Series, mark: int) -> str:
    return _number(float(box.energy[mark - 1])) if mark <= len(box.energy) else "–"


def _cradles(cradles: Sequence[Cradle]) -> Table:
    rows = [
        tuple(map(Entry, (c.name, *map(_number, c.velocities), _number(c.momentum), _number(c.energy))))
        for c in cradles
    ]
    names = [f"ball {i}" for i in range(1, 6)] + ["momentum", "energy"]
    columns = [Column("velocities a second later"), *(Column(name, numeric=True) for name in names)]
    caption = "Newton's cradle: five balls that touch, the first of which comes in at 1"
    return Table(caption, tuple(columns), tuple(rows))


def _number(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3g}".replace("-", "−")


# -- the drawing -------------------------------------------------------------------------------------------------


def as_svg(boxes: Sequence[Series]) -> str:
    """Energy by bounces, the latter on a logarithmic axis, as one SVG document."""
    size = f'viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>'
    title = "<title>Energy of a ball in a box by bounces, e = 1: the reference keeps it, PyBullet does not</title>"
    back = f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>'
    lines = [head, title, back, *_axes(), *(line for i, box in enumerate(boxes) for line in _curve(i, box)), "</svg>"]
    return "\n".join(lines) + "\n"


def _x(bounce: float) -> float:
    return MARGIN + (WIDTH - 2 * MARGIN) * math.log10(bounce) / math.log10(BOUNCES)


def _y(energy: float) -> float:
    return HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * energy


def _axes() -> Iterator[str]:
    for mark in MARKS:
        yield _line([(_x(mark), _y(0)), (_x(mark), _y(1))], 'stroke="#dddddd"')
        yield _words(_x(mark), _y(0) + 18, str(mark), "middle")
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        yield _line([(_x(1), _y(share)), (_x(BOUNCES), _y(share))], 'stroke="#dddddd"')
        yield _words(_x(1) - 6, _y(share) + 4, f"{share:g}", "end")
    yield _words(_x(BOUNCES), _y(0) + 36, "bounces", "end")
    yield _words(_x(1) - 30, _y(1) - 16, "energy / energy at the start", "start")


def _curve(i: int, box: Series) -> Iterator[str]:
    points = [(_x(n), _y(energy)) for n, energy in enumerate(box.energy.tolist(), 1)]
    shown = [point for n, point in enumerate(points, 1) if n < 50 or n % 25 == 0 or n == len(points)]
    dash = f' stroke-dasharray="{DASHES[i]}"' if DASHES[i] else ""
    yield _line(shown, f'stroke="{COLORS[i]}" stroke-width="2"{dash}')
    at = _y(0.9 - 0.1 * i)
    yield _line([(_x(BOUNCES) - 200, at), (_x(BOUNCES) - 170, at)], f'stroke="{COLORS[i]}" stroke-width="2"{dash}')
    yield _words(_x(BOUNCES) - 162, at + 4, box.name, "start")


def _line(points: Iterable[tuple[float, float]], style: str) -> str:
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{path}" fill="none" {style}/>'


def _words(x: float, y: float, words: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text.visible(words))}</text>'
