"""What the command line's options mean, and why some values are refused."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from oracles.library import Library

LARGEST_SEED = 2**63 - 1
MOST_WORKERS, MOST_PASSES, MOST_EXAMPLES = 1024, 1_000_000, 1_000_000


class BadInput(Exception):
    """The command line asks for what cannot be done; the text names it, and the way out."""


def positive(option: str, unit: str = "") -> Callable[[str], float]:
    """Make the parser of an option that takes a number greater than 0."""

    def parse(said: str) -> float:
        try:
            value = float(said)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0):
            raise BadInput(f"{option} must be a positive number{unit}, got {said!s}")
        return value

    return parse


def seconds(option: str) -> Callable[[str], float]:
    """Make the parser of an option that takes a time."""
    return positive(option, " of seconds")


def whole(option: str, low: int, high: int) -> Callable[[str], int]:
    """Make the parser of an option that takes a whole number."""

    def parse(said: str) -> int:
        try:
            value = int(said)
        except ValueError:
            value = low - 1
        if not low <= value <= high:
            raise BadInput(f"{option} must be a whole number from {low} to {high}, got {said!s}")
        return value

    return parse


def place(option: str, what: str = "folder") -> Callable[[str], Path]:
    """Make the parser of an option that names a folder or a file."""

    def parse(said: str) -> Path:
        if not str(said).strip() or "\0" in str(said):
            raise BadInput(f"{option} must name a {what}, got {str(said)!r}")
        return Path(said)

    return parse


@contextmanager
def reading() -> Iterator[None]:
    """Turn a file that cannot be read as a report into bad input."""
    from reports.reading import NoReport  # noqa: PLC0415

    try:
        yield
    except NoReport as error:
        raise BadInput(str(error)) from None


def library_of(folder: Path | None) -> Library:
    """Models of a user's folder, all of them read, or those that are there without one."""
    from oracles import library  # noqa: PLC0415
    from oracles.meshfiles import ModelError  # noqa: PLC0415

    try:
        return library.shipped() if folder is None else library.of_user(folder)
    except ModelError as error:
        raise BadInput(str(error)) from None


def engines(chosen: Sequence[str] | None) -> list[str]:
    """Engines to question: those asked for, which must load, or all that are installed."""
    from oracles.engine import EngineUnavailable  # noqa: PLC0415
    from oracles.engines import available_engines, load_engine  # noqa: PLC0415

    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())  # an engine of the user's own stands in the folder that he is in
    if not chosen:
        installed = [name for name, missing in available_engines().items() if missing is None]
        if not installed:
            raise BadInput("no engine is installed: pip install python-fcl pybullet (the extra 'engines')")
        return installed
    for name in dict.fromkeys(chosen):
        try:
            load_engine(name)
        except EngineUnavailable as error:
            raise BadInput(str(error)) from None
        except Exception as error:
            # a module of the user's own may raise anything while it is imported
            raise BadInput(f"--engine {name!r} cannot be loaded: {type(error).__name__}: {error}") from error
    return list(dict.fromkeys(chosen))


def pairs(chosen: Sequence[str]) -> list[str]:
    """Names of pairs as the table has them, from any dash, any case and either order."""
    from oracles.scene import TYPES, cells  # noqa: PLC0415

    known = {tuple(cell.pair.casefold().split("–")): cell.pair for cell in cells()}
    found = []
    for name in chosen:
        parts = tuple(part.strip().casefold() for part in re.split("[-–—]", name))
        match = known.get(parts) or known.get(parts[::-1])
        if match is None:
            types = ", ".join(TYPES)
            raise BadInput(
                f"--pair {name!r} is not in the pair table: write A-B with two of {types}; see proxyproof table"
            )
        found.append(match)
    return list(dict.fromkeys(found))
