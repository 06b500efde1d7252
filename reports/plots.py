"""Plots of errors against scale, gap and aspect ratio, as SVG of one's own: log-log, a panel for each query.

Text and axes have the colour of the text around them; each engine has a class, `series-1` and so on, for which a page
may set another colour. There are neither styles nor scripts inside.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

from oracles.accuracy import ASPECT, AXES, GAP, SCALE, Point
from oracles.outcome import Run
from oracles.scene import QUERIES
from reports import text
from reports.tables import engines

COLOURS = ("#2f7fbf", "#d9772b", "#3a9a80", "#b5569a")
"""Readable on white and on black, and told apart by colour-blind people."""
MARKS = (
    "M-2.5 0a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0-5 0Z",
    "M-2.3-2.3h4.6v4.6h-4.6Z",
    "M0-3L3 2.4H-3Z",
    "M0-3.2L3.2 0L0 3.2L-3.2 0Z",
)
"""Outlines of marks, so that engines are told apart without colours too."""
WIDTH, HEIGHT = 330, 230
"""Of a panel."""
LEFT, RIGHT, TOP, BOTTOM = 46, 14, 26, 38
LEGEND = 26
ACROSS = 2
"""Panels side by side."""
SLOT = 0.6
"""Decades that 0 and infinity take at the ends of an axis."""
RANKS = ("median", "p99")
"""Errors that are drawn as lines."""
LABELS = 8
"""Most labels on an axis."""
ROOM = 26.0
"""Pixels between a label and one at the end of the axis."""
FEWEST = 20
"""Scenes of a bin whose ranks are drawn; of fewer, only the worst."""
FAR = 100.0
"""Factor between bins that are no neighbours."""
FEWEST_BINS = 3
"""Of a query that is worth a panel."""

TITLES = {
    SCALE: ("Error against scale", "scene's largest coordinate, extent or velocity", "error, as a length"),
    GAP: ("Error against gap", "gap or overlap, relative to the scene's size", "error, relative to the scene's size"),
    ASPECT: ("Error against aspect ratio", "aspect ratio of the longer proxy", "error, relative to the scene's size"),
}
ENDS = {GAP: ("touching", "∞"), ASPECT: ("0", "flat"), SCALE: ("0", "∞")}
"""What 0 and infinity mean across."""


@dataclass(frozen=True)
class Plot:
    """An SVG, with a title and a sentence on what it shows."""

    title: str
    caption: str
    svg: str


def plots(run: Run) -> tuple[Plot, ...]:
    """A plot for each axis of which there is something to be seen."""
    named = engines(run)
    found = []
    for axis in AXES:
        points = _worth_a_panel([p for p in run.accuracy.points if p.axis == axis and p.engine in named])
        if points:
            title, across, up = TITLES[axis]
            caption = (
                f"{up[0].upper()}{up[1:]}, against the {across}: half of the scenes of a bin err by no more than the "
                f"line, 99 % by no more than the dashed one, where there are {FEWEST} scenes or more; marks are the "
                "worst. 0 is below what the reference resolves."
            )
            found.append(Plot(title, caption, _svg(axis, points, named)))
    return tuple(found)


def _worth_a_panel(points: Sequence[Point]) -> list[Point]:
    """Leave out queries of which there is no course to be seen."""
    bins = Counter((point.engine, point.query) for point in points)
    return [point for point in points if max(n for (_, q), n in bins.items() if q == point.query) >= FEWEST_BINS]


# -- axes ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Axis:
    """A logarithmic axis from one pixel to another, with room for 0 and infinity where they occur."""

    low: int
    high: int
    zero: bool
    endless: bool
    start: float
    end: float

    @classmethod
    def over(cls, values: Sequence[float], start: float, end: float) -> Axis:
        """Take in all values, in whole decades."""
        decades = [math.log10(value) for value in values if 0 < value < math.inf] or [0.0]
        low, high = math.floor(min(decades)), math.ceil(max(decades))
        return cls(low, max(high, low + 1), 0.0 in values, math.inf in values, start, end)

    def at(self, value: float) -> float:
        """Pixel of a value."""
        first, last = self.low - SLOT * self.zero, self.high + SLOT * self.endless
        decade = first if value <= 0 else last if value == math.inf else math.log10(value)
        return self.start + (self.end - self.start) * (decade - first) / (last - first)

    def labels(self, ends: tuple[str, str] = ("0", "∞")) -> Iterator[tuple[float, str]]:
        """Pixels and texts: those of the ends, and of decades that have room between them."""
        taken = [(self.at(0.0), ends[0])] * self.zero + [(self.at(math.inf), ends[1])] * self.endless
        yield from taken
        room = {place: ROOM if len(word) > 1 else ROOM / 2 for place, word in taken}
        step = max(1, math.ceil((self.high - self.low) / LABELS))
        for decade in range(-(-self.low // step) * step, self.high + 1, step):
            place = self.at(10.0**decade)
            if all(abs(place - other) > room[other] for other in room):
                yield place, f"1e{decade}" if decade else "1"


# -- panels --------------------------------------------------------------------------------------------------


def _svg(axis: str, points: Sequence[Point], named: Sequence[str]) -> str:
    queries = [query for query in QUERIES if any(point.query == query for point in points)]
    rows = -(-len(queries) // ACROSS)
    width, height = WIDTH * min(ACROSS, len(queries)), LEGEND + HEIGHT * rows
    title, across, _ = TITLES[axis]
    said = "; ".join(_in_words(query, points, named) for query in queries)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="plot" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}" role="img" font-family="sans-serif" font-size="11" fill="currentColor">',
        f"<title>{escape(title)}</title><desc>{escape(said)}</desc>",
        *_legend(named),
    ]
    ups = [rank for point in points for rank in vars(point.errors).values()]
    for number, query in enumerate(queries):
        mine = [point for point in points if point.query == query]
        shift = f"{WIDTH * (number % ACROSS)} {LEGEND + HEIGHT * (number // ACROSS)}"
        x = Axis.over([point.x for point in mine], LEFT, WIDTH - RIGHT)
        y = Axis.over(ups, HEIGHT - BOTTOM, TOP)
        parts += [f'<g transform="translate({shift})">', *_frame(query, across, x, y, axis), *_lines(mine, named, x, y)]
        parts.append("</g>")
    return "".join([*parts, "</svg>"])


def _legend(named: Sequence[str]) -> Iterator[str]:
    place = LEFT
    for number, engine in enumerate(named):
        shown = text.visible(engine, 24)
        yield f'<g {_series(number)} transform="translate({place} 14)"><path d="M0 0h22" fill="none" stroke-width="2"/>'
        yield f'<path d="{_mark(number)}" transform="translate(11 0)"/></g>'
        yield f'<text x="{place + 27}" y="18">{escape(shown)}</text>'
        place += 45 + 7 * len(shown)


def _frame(query: str, across: str, x: Axis, y: Axis, axis: str) -> Iterator[str]:
    """Grid, labels and what the axes are."""
    yield f'<text x="{LEFT}" y="{TOP - 9}" font-weight="600">{escape(query)}</text>'
    grid = [f"M{place:.1f} {TOP}V{HEIGHT - BOTTOM}" for place, _ in x.labels()]
    grid += [f"M{LEFT} {place:.1f}H{WIDTH - RIGHT}" for place, _ in y.labels()]
    yield f'<path d="{"".join(grid)}" fill="none" stroke="currentColor" stroke-opacity=".16"/>'
    yield '<g font-size="9.5" fill-opacity=".8" text-anchor="middle">'
    yield from (
        f'<text x="{place:.1f}" y="{HEIGHT - BOTTOM + 13}">{word}</text>' for place, word in x.labels(ENDS[axis])
    )
    yield f'<text x="{(LEFT + WIDTH - RIGHT) / 2:.0f}" y="{HEIGHT - BOTTOM + 27}">{escape(across)}</text></g>'
    yield '<g font-size="9.5" fill-opacity=".8" text-anchor="end">'
    yield from (f'<text x="{LEFT - 5}" y="{place + 3.5:.1f}">{word}</text>' for place, word in y.labels())
    yield "</g>"


def _lines(points: Sequence[Point], named: Sequence[str], x: Axis, y: Axis) -> Iterator[str]:
    """Of each engine: medians as a line, the 99th percentile dashed, the worst as marks."""
    for number, engine in enumerate(named):
        mine = [point for point in points if point.engine == engine]
        yield f"<g {_series(number)}>"
        stretches = list(_stretches(mine))
        if stretches:
            medians, most = (
                "".join(
                    _path((x.at(point.x), y.at(getattr(point.errors, rank))) for point in part) for part in stretches
                )
                for rank in RANKS
            )
            yield f'<path d="{medians}" fill="none" stroke-width="2" stroke-linecap="round"/>'
            yield f'<path d="{most}" fill="none" stroke-dasharray="5 3"/>'
        for point in mine:
            place = f"{x.at(point.x):.1f} {y.at(point.errors.worst):.1f}"
            yield f'<path d="{_mark(number)}" transform="translate({place})"/>'
        yield "</g>"


def _stretches(points: Sequence[Point]) -> Iterator[list[Point]]:
    """Neighbouring bins with enough scenes; a line across bins of which little is known would say too much."""
    part: list[Point] = []
    for point in points:
        if part and (point.count < FEWEST or not _next_to(part[-1].x, point.x)):
            yield part
            part = []
        if point.count >= FEWEST:
            part.append(point)
    if part:
        yield part


def _next_to(x: float, other: float) -> bool:
    """Whether two medians may be those of neighbouring decades."""
    return x > 0 and other < math.inf and other / x < FAR


def _series(number: int) -> str:
    colour = COLOURS[number % len(COLOURS)]
    return f'class="series-{number % len(COLOURS) + 1}" stroke="{colour}" fill="{colour}" fill-opacity=".35"'


def _mark(number: int) -> str:
    return MARKS[number % len(MARKS)]


def _path(places: Iterable[tuple[float, float]]) -> str:
    """A line, of a single place a dot."""
    words = [f"{across:.1f} {up:.1f}" for across, up in places]
    return f"M{'L'.join(words)}" if len(words) > 1 else f"M{words[0]}h0"


def _in_words(query: str, points: Sequence[Point], named: Sequence[str]) -> str:
    """What a reader hears of a panel: the first and the last median of each engine."""
    said = []
    for engine in named:
        mine = [point for point in points if point.query == query and point.engine == engine]
        if mine:
            first, last = mine[0], mine[-1]
            said.append(
                f"{text.visible(engine)} from {text.short(first.errors.median)} at {text.short(first.x)} "
                f"to {text.short(last.errors.median)} at {text.short(last.x)}"
            )
    return f"{query}, median error: {', '.join(said)}"
