"""What adapters say of themselves, checked: they are somebody's own code, and only solvers run behind a guard."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from oracles.engine import COLUMNS, NAME, Array, Effective, Engine, EngineUnavailable, Support, Tolerance
from oracles.scene import Cell, cells
from refimpl.shapes import Proxy

LONGEST = 200
"""Characters that are quoted of a wrong answer."""


class UnsoundAdapter(RuntimeError):
    """An adapter said something in the middle of a campaign that cannot be used."""


def require_sound(engine: Engine) -> None:
    """Check what an adapter says of itself, before a campaign trusts it.

    Raises
    ------
    EngineUnavailable
        Names the method and what is wrong with its answer.
    """
    if not (isinstance(engine.name, str) and NAME.fullmatch(engine.name)):
        what = "letters, digits, and any of _ . + - behind the first of them, at most 100"
        raise EngineUnavailable(f"{type(engine).__name__}.name must be {what}, got {shown(engine.name)}")
    try:
        _require_versions(engine)
        for cell in cells():
            _require_sound_in(engine, cell)
    except UnsoundAdapter as unsound:
        raise EngineUnavailable(str(unsound)) from unsound


def _require_versions(engine: Engine) -> None:
    where = f"{type(engine).__name__}.versions"
    versions = _given(where, dict, engine.versions)
    if not all(isinstance(text, str) for item in versions.items() for text in item):
        raise UnsoundAdapter(f"{where} must give texts to texts, got {shown(versions)}")


def _require_sound_in(engine: Engine, cell: Cell) -> None:
    asked = cell.query, cell.type_a, cell.type_b
    if not _given(_where(engine, "support", cell), Support, engine.support, *asked):
        return
    _given(_where(engine, "tolerance", cell), Tolerance, engine.tolerance, *asked)
    _given(_where(engine, "conventions", cell), Mapping, engine.conventions, *asked)
    unknown = _given(_where(engine, "says", cell), frozenset, engine.says, *asked) - set(COLUMNS)
    if unknown:
        text = f"{type(engine).__name__}.says names no columns of an answer: {', '.join(map(str, unknown))}"
        raise UnsoundAdapter(f"{text[:LONGEST]}; there are {', '.join(COLUMNS)}")


def effective_of(engine: Engine, cell: Cell, rows_a: Array, rows_b: Array) -> tuple[Effective, Effective]:
    """Give the shapes that the engine says it effectively uses for scenes of a cell.

    Raises
    ------
    UnsoundAdapter
        When it raises, or says what cannot be shapes.
    """
    where = _where(engine, "effective", cell)
    sides = _given(where, tuple, engine.effective, cell.query, cell.type_a, rows_a, cell.type_b, rows_b)
    if len(sides) != 2 or not all(isinstance(side, Effective) for side in sides):
        raise UnsoundAdapter(f"{where} must give two Effective, got {shown(sides)}")
    for side, rows in zip(sides, (rows_a, rows_b), strict=True):
        if not (isinstance(side.kind, type) and issubclass(side.kind, Proxy)):
            raise UnsoundAdapter(f"{where} must name a type of proxy, got {shown(side.kind)}")
        if side.made is not None:
            _require_batch(where, side, len(rows))
        elif side.rows is not rows:
            _require_numbers(where, "rows", side.rows, 2, len(rows))
        _require_numbers(where, "margin", side.margin, 1, len(rows))
        if (side.margin < 0).any():
            raise UnsoundAdapter(f"{where} must give margins of at least 0, got {float(side.margin.min())!r}")
    return sides[0], sides[1]


def _require_batch(where: str, side: Effective, n: int) -> None:
    if type(side.made) is not side.kind or side.made.batch_shape != (n,):
        raise UnsoundAdapter(f"{where} must give {n} shapes of type {side.kind.__name__}, got {shown(side.made)}")


def _require_numbers(where: str, name: str, value: object, axes: int, n: int) -> None:
    is_array = isinstance(value, np.ndarray) and value.dtype == np.float64 and value.ndim == axes and len(value) == n
    if not is_array:
        raise UnsoundAdapter(f"{where} must give {n} {name} as doubles, got {shown(value)}")
    if not np.isfinite(value).all():  # type: ignore[call-overload]
        raise UnsoundAdapter(f"{where} must give {name} that are finite")


def _where(engine: Engine, method: str, cell: Cell) -> str:
    return f"{type(engine).__name__}.{method}, asked about {cell.query} {cell.pair},"


def _given(where: str, kind: Any, method: Callable[..., Any], *arguments: object) -> Any:
    """What a method gives; refused when it raises or gives something of another kind."""
    try:
        value = method(*arguments)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # an adapter that leaves is not to take a campaign with it
        raise UnsoundAdapter(f"{where} raised {type(error).__name__}: {shown(error, str)}") from error
    if not isinstance(value, kind):
        raise UnsoundAdapter(f"{where} must give a {kind.__name__}, got {shown(value)}")
    return value


def shown(value: object, how: Callable[[object], str] = repr) -> str:
    """Quote a value, cut short; its type, where it has no text."""
    try:
        return how(value)[:LONGEST]
    except Exception:
        return f"a {type(value).__name__}"
