"""Numbers and foreign texts in the form in which people read them; every report takes them from here.

Names, error texts and answers come from engines: a report shows them, whatever they hold, without obeying them.
Escaping belongs to the format that is written; making the invisible visible and cutting to length happen here.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

THIN = "\u202f"
"""Narrow space that does not break: between groups of three digits."""

LINE, BLOCK = 300, 4000
"""Longest foreign text shown in a line and in a block, in characters."""

READABLE_BITS = 64
"""Longest numerator and denominator that people are shown."""

INVISIBLE = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}
"""Unicode categories of control, bidirectional, surrogate and private characters, and of line separators."""

NON_FINITE = {math.inf: "Infinity", -math.inf: "-Infinity"}


def count(number: int) -> str:
    """Digits in groups of three: 1 234 567."""
    return f"{number:,}".replace(",", THIN)


def number(value: float | Fraction) -> str:
    """Every bit of a number: the shortest decimal that reads back as the same double, or a fraction.

    A fraction too long to be read is given by the nearest double, after ≈.
    """
    if not isinstance(value, Fraction):
        return repr(float(value))
    nearest = _nearest(value)
    if math.isfinite(nearest) and Fraction(nearest) == value:
        return repr(nearest)
    short_enough = max(value.numerator.bit_length(), value.denominator.bit_length()) <= READABLE_BITS
    return f"{value.numerator}/{value.denominator}" if short_enough else f"≈ {nearest!r}"


def short(value: float | Fraction) -> str:
    """Three significant digits, for reading and not for reproducing."""
    return f"{_nearest(value) if isinstance(value, Fraction) else float(value):.3g}"


def _nearest(value: Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def seconds(value: float) -> str:
    """Time as people give it: tenths below 100 s, whole seconds above."""
    digits = 1 if abs(value) < 100 and value != round(value) else 0
    return f"{value:.{digits}f}{THIN}s"


def share(part: float, whole: float) -> str:
    """Part of a whole in per cent; empty when there is no whole."""
    return f"{100 * part / whole:.0f}{THIN}%" if whole > 0 else ""


def plural(amount: int, noun: str, many: str = "") -> str:
    """Count with its noun: "1 bucket", "1 234 buckets"."""
    return f"{count(amount)} {noun if amount == 1 else many or noun + 's'}"


def visible(text: object, limit: int = LINE) -> str:
    """One harmless line of foreign text: cut to `limit`, with everything invisible written as ⟨U+202E⟩."""
    return "".join(map(_shown, _cut(str(text), limit).replace("\r\n", "\n").replace("\n", " ⏎ ")))


def block(text: object, limit: int = BLOCK) -> str:
    """Harmless lines of foreign text: like `visible`, but line breaks and tabs stay."""
    lines = _cut(str(text), limit).replace("\r\n", "\n").expandtabs(4)
    return "".join(c if c == "\n" else _shown(c) for c in lines)


def _shown(character: str) -> str:
    if unicodedata.category(character) in INVISIBLE:
        return f"⟨U+{ord(character):04X}⟩"
    return character


def _cut(text: str, limit: int) -> str:
    """Keep the start and the end: errors say at their end what happened."""
    if len(text) <= limit:
        return text
    head, tail = limit * 3 // 4, limit // 4
    return f"{text[:head]} … {count(len(text) - head - tail)} characters left out … {text[-tail:]}"


def plain(value: object, limit: int = BLOCK) -> Any:
    """Data that JSON can hold: numpy becomes lists, a number that is not finite becomes its name.

    "NaN", "Infinity" and "-Infinity" are strings, as JSON has no such numbers. Texts are made visible and cut to
    `limit`.
    """
    value = value.tolist() if hasattr(value, "tolist") else value
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else NON_FINITE.get(value, "NaN")
    if isinstance(value, Mapping):
        return {visible(k): plain(v, limit) for k, v in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(v, limit) for v in value]
    return block(value, limit)


def full(value: object, limit: int = BLOCK) -> str:
    """One value of an answer in full precision, as people read it."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, float | Fraction):
        return number(value)
    if isinstance(value, Mapping):
        return _cut(", ".join(f"{visible(k)} = {full(v, limit)}" for k, v in value.items()), limit)
    if isinstance(value, list | tuple):
        open_, close = ("(", ")") if all(isinstance(v, int | float | Fraction) for v in value) else ("[", "]")
        return _cut(open_ + ", ".join(full(v, limit) for v in value) + close, limit)
    return visible(value, limit)
