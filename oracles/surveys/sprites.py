"""The survey of sprites: two bit masks and an offset; what they have in common is known exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import groupby
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import numpy as np

from oracles.surveys.survey import REFERENCE, Case, Judgement, Library, Survey
from refimpl.linear import Bools

Random = np.random.Generator
Offset = tuple[int, int]

LARGEST = 1024
"""Columns and rows of a mask that is read."""
SOLID = "#"
MOST_INT = 2**31 - 1
"""Largest offset that is asked: engines count in the integers of C."""
SIDES = (1, 2, 31, 32, 33, 63, 64, 65, 100, 129)
"""Around the sides of machine words."""
EACH = 8
"""Cases of each regime and question."""
LONG = 9
"""A run of so many pixels is written by its length."""
TRIED = 18
"""Pixels in common that are tried alone."""


class Pair(NamedTuple):
    """Two masks, the second one moved by an offset (columns, rows)."""

    a: Bools
    b: Bools
    offset: Offset

    def data(self) -> dict[str, Any]:
        """Return it as plain data: a text for each row."""
        return {"a": rows_of(self.a), "b": rows_of(self.b), "offset": list(self.offset)}


def rows_of(mask: Bools) -> dict[str, Any]:
    """A mask as plain data."""
    drawn = np.where(mask, ord(SOLID), ord(".")).astype(np.uint8)
    return {"width": mask.shape[1], "rows": [row.tobytes().decode() for row in drawn]}


def mask_of(data: Mapping[str, Any]) -> Bools:
    """Read it back; raises ValueError, TypeError or LookupError for anything else."""
    width, rows = int(data["width"]), list(data["rows"])
    if not (0 <= width <= LARGEST and len(rows) <= LARGEST):
        raise ValueError(f"expected at most {LARGEST} columns and rows")
    if any(len(row) != width or set(row) - {SOLID, "."} for row in rows):
        raise ValueError("expected rows of # and . that are as long as the mask is wide")
    drawn = np.frombuffer("".join(rows).encode(), dtype=np.uint8)
    return np.asarray(drawn == ord(SOLID)).reshape(len(rows), width)


def pair_of(data: Mapping[str, Any]) -> Pair:
    """Read a pair back; raises as `mask_of` does."""
    x, y = (int(number) for number in data["offset"])
    if max(abs(x), abs(y)) > MOST_INT:
        raise ValueError("expected an offset of 32 bits")
    return Pair(mask_of(data["a"]), mask_of(data["b"]), (x, y))


def common(pair: Pair) -> Bools:
    """Where the first mask is solid and the second, moved, is too: one pixel at a time would say the same."""
    both = np.zeros_like(pair.a)
    (x, y), (height, width) = pair.offset, pair.a.shape
    left, right = max(0, x), min(width, x + pair.b.shape[1])
    top, bottom = max(0, y), min(height, y + pair.b.shape[0])
    if left < right and top < bottom:
        other = pair.b[top - y : bottom - y, left - x : right - x]
        both[top:bottom, left:right] = pair.a[top:bottom, left:right] & other
    return both


# -- regimes -------------------------------------------------------------------------------------------------


def _noise(rng: Random, density: float = 0.5) -> Bools:
    height, width = rng.choice(SIDES, 2)
    return np.asarray(rng.uniform(size=(height, width)) < density)


def _near(rng: Random, a: Bools, b: Bools) -> Offset:
    """So that the boxes overlap, or just do not."""
    low, high = np.negative(b.shape[::-1]), np.array(a.shape[::-1])
    x, y = rng.integers(low, high, endpoint=True).tolist()
    return x, y


def _on_a_pixel(rng: Random, a: Bools, b: Bools) -> Offset:
    """So that a solid pixel lies on a solid one, where there are any."""
    if not (a.any() and b.any()):
        return _near(rng, a, b)
    (row, column), (other_row, other_column) = (rng.choice(np.argwhere(mask)).tolist() for mask in (a, b))
    return column - other_column, row - other_row


def _at_an_edge(rng: Random, a: Bools, b: Bools) -> Offset:
    """By one column or row, or by none."""
    x, y = _near(rng, a, b)
    ends = ((a.shape[1] - 1, 1 - b.shape[1], a.shape[1], -b.shape[1]), (a.shape[0] - 1, 1 - b.shape[0]))
    axis = rng.integers(3)
    return int(rng.choice(ends[0])) if axis != 1 else x, int(rng.choice(ends[1])) if axis != 0 else y


def _round(size: int) -> Bools:
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    return np.asarray(x * x + y * y <= size * size / 4)


def _drawn(density: float) -> Callable[[Random], Pair]:
    def make(rng: Random) -> Pair:
        a, b = _noise(rng, density), _noise(rng, density)
        return Pair(a, b, (_near if rng.uniform() < 0.5 else _on_a_pixel)(rng, a, b))

    return make


def _edges(rng: Random) -> Pair:
    a, b = _noise(rng, 1.0), _noise(rng, 1.0)
    return Pair(a, b, _at_an_edge(rng, a, b))


def _empty(rng: Random) -> Pair:
    a, b = (_noise(rng, density)[: rng.choice([0, 200]), : rng.choice([0, 200])] for density in rng.permutation([0, 1]))
    return Pair(a, b, _near(rng, a, b))


def _large(rng: Random) -> Pair:
    a, b = _round(512), ~_round(512)
    x, y = rng.integers(-300, 300, 2).tolist()
    return Pair(a, b, (x, y))


def _far(rng: Random) -> Pair:
    a, b = _noise(rng, 1.0), _noise(rng, 1.0)
    far = [n * sign for n in (MOST_INT, MOST_INT - 64, 2**30, 2**16, 2**15) for sign in (1, -1)]
    x, y = _near(rng, a, b)
    which = rng.integers(3)
    return Pair(a, b, (int(rng.choice(far)) if which != 1 else x, int(rng.choice(far)) if which != 0 else y))


class Recipe(NamedTuple):
    """How to make a pair, why, and how many."""

    why: str
    make: Callable[[Random], Pair]
    times: int = EACH


REGIMES: Mapping[str, Recipe] = MappingProxyType(
    {
        "noise": Recipe("half of the pixels are solid, sides around those of machine words", _drawn(0.5), 2 * EACH),
        "sparse": Recipe("hardly any pixel is solid: every word has to be looked at", _drawn(0.01), 2 * EACH),
        "edges": Recipe("full masks that overlap by one column or row, or by none", _edges, 2 * EACH),
        "empty": Recipe("masks without a solid pixel, or without any pixel", _empty),
        "large": Recipe("512 × 512 pixels: a disc, and what is left of a square", _large, 2),
        "far": Recipe("offsets up to the largest of 32 bits", _far, 2 * EACH),
    }
)


class Sprites(Survey):
    """Pixel-perfect overlap."""

    name = "sprites"
    title = "Sprites"
    about = (
        "Two bit masks, one of them moved by whole pixels: a pixel that is solid in both, and how many there are. Each "
        "answer is held against plain arrays; of the pixels in common, any is right."
    )
    questions: ClassVar = MappingProxyType(
        {
            "overlap": "A pixel that both have, or that there is none; what is wrong counts as off by 1",
            "area": "How many pixels both have; off by so many",
        }
    )
    regimes: ClassVar = MappingProxyType({name: recipe.why for name, recipe in REGIMES.items()})
    engines: ClassVar = MappingProxyType(
        {
            REFERENCE: Library("oracles.surveys.sprites_engines:Reference", "refimpl", "proxyproof"),
            "pygame": Library(
                "oracles.surveys.sprites_engines:Pygame", "pygame", "pygame-ce (the extra 'sprites')", "pygame-ce"
            ),
        }
    )

    def cases(self, seed: int) -> list[Case]:
        """Every regime, before both questions."""
        found = []
        for number, (regime, recipe) in enumerate(REGIMES.items()):
            rng = np.random.default_rng([seed, number])
            pairs = [recipe.make(rng).data() for _ in range(recipe.times)]
            found += [Case(question, regime, data) for question in self.questions for data in pairs]
        return found

    def judge(self, case: Case, answer: Any) -> Judgement:
        """Compare with the exact truth."""
        both = common(pair_of(case.data))
        area = int(np.count_nonzero(both))
        words = f"pixels that are solid in both: {area}"
        if case.question == "area":
            if isinstance(answer, bool) or not isinstance(answer, int):
                raise TypeError(f"expected a whole number, got {str(answer)[:50]!r}")
            return Judgement(float(abs(answer - area)), words)
        if answer is None:
            return Judgement(float(area > 0), words)
        x, y = (int(number) for number in answer)
        inside = 0 <= x < both.shape[1] and 0 <= y < both.shape[0]
        right = inside and bool(both[y, x])
        return Judgement(float(not right), f"{words}; {(x, y)} is {'one' if right else 'none'} of them")

    def check(self, case: Case) -> None:
        """Refuse anything but two masks and an offset."""
        if case.question not in self.questions:
            raise ValueError(f"no question {case.question!r} about sprites")
        pair_of(case.data)

    def simpler(self, case: Case) -> Iterator[Case]:
        """One pixel of each mask, halves of each mask, and smaller offsets."""
        pair = pair_of(case.data)
        for simple in (*_single(pair), *_halves(pair)):
            if len(simple.a) * simple.a.size + simple.b.size < len(pair.a) * pair.a.size + pair.b.size:
                yield Case(case.question, case.regime, simple.data())

    def written(self, case: Case) -> str:
        """Masks as they are drawn, row by row; #{9} are nine solid pixels."""
        masks = [case.data[name] for name in ("a", "b")]
        sizes = [f"{mask['width']} × {len(mask['rows'])}" for mask in masks]
        drawn = [f"{name} ({size}): {_drawn_rows(mask)}" for name, size, mask in zip("ab", sizes, masks, strict=True)]
        return "; ".join((f"b moved by {tuple(case.data['offset'])}", *drawn))


def _drawn_rows(mask: Mapping[str, Any]) -> str:
    """Rows from the top, with long runs of pixels and of equal rows as numbers."""
    found = []
    for row, same in groupby(mask["rows"]):
        runs = [(pixel, len(list(run))) for pixel, run in groupby(row)]
        drawn = "".join(pixel * count if count < LONG else f"{pixel}{{{count}}}" for pixel, count in runs)
        times = len(list(same))
        found.append(f"{times} rows of {drawn or 'nothing'}" if times > 1 else drawn or "nothing")
    return ", ".join(found) or "no rows"


def _single(pair: Pair) -> Iterator[Pair]:
    """Masks that consist of a pixel that both have."""
    places = np.argwhere(common(pair))
    for y, x in places[:: max(1, len(places) // TRIED)][:TRIED].tolist():
        yield Pair(np.ones((1, 1), dtype=bool), np.ones((1, 1), dtype=bool), (0, 0))
        yield pair._replace(a=pair.a[y : y + 1, x : x + 1], offset=(pair.offset[0] - x, pair.offset[1] - y))
        dx, dy = x - pair.offset[0], y - pair.offset[1]
        yield pair._replace(b=pair.b[dy : dy + 1, dx : dx + 1], offset=(x, y))


def _halves(pair: Pair) -> Iterator[Pair]:
    """One mask cut in half, across or down; the offset keeps the rest where it is."""
    for axis in (0, 1):
        for name, sign in (("a", -1), ("b", 1)):
            mask = getattr(pair, name)
            middle = mask.shape[axis] // 2
            for part, moved in ((slice(0, middle), 0), (slice(middle, None), middle)):
                if middle:
                    x, y = pair.offset[0] + sign * moved * axis, pair.offset[1] + sign * moved * (1 - axis)
                    cut = mask[part] if axis == 0 else mask[:, part]
                    if max(abs(x), abs(y)) <= MOST_INT:
                        yield pair._replace(**{name: cut, "offset": (x, y)})
