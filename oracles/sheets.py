"""Sheets: one row for each answer of an engine, as it is recorded."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oracles.batch import Batch
from oracles.engine import Answers
from oracles.scene import Cell
from oracles.screening import Screening


class Row(NamedTuple):
    """One answer.

    Attributes
    ----------
    regime, number
        Name the scene within its task.
    status
        As `oracles.engine.Status` counts.
    kind
        Position of the verdict in `oracles.screening.KINDS`.
    amount
        Estimated violation of the gravest claim, as the floats have it.
    pressure
        Largest error of any claim, relative to the tolerance for it.
    error
        By how much the value that was answered is off at least, as `oracles.screening.Screening` has it; NaN where
        there is none.
    size
        Of the scene: its largest coordinate, extent or velocity.
    gap
        Signed distance of the two, of scenes at rest whose error is known; NaN of others.
    aspect
        Aspect ratio of the longer of the two.
    proven
        Whether the verdict is that of a certificate.
    """

    regime: str
    number: int
    status: int
    kind: int
    symptom: str
    amount: float
    pressure: float
    error: float
    size: float
    gap: float
    aspect: float
    proven: bool


@dataclass(frozen=True)
class Sheet:
    """Answers of one engine in one cell; a column for each field of `Row`, texts as positions in `words`."""

    engine: str
    query: str
    pair: str
    words: list[str]
    columns: dict[str, NDArray[Any]]

    @classmethod
    def of_rows(cls, engine: str, cell: Cell, rows: Iterable[Row]) -> Sheet:
        """Put single answers together."""
        listed = list(rows)
        return cls.of_columns(engine, cell, {name: [getattr(row, name) for row in listed] for name in Row._fields})

    @classmethod
    def of_batch(
        cls,
        engine: str,
        cell: Cell,
        batch: Batch,
        answers: Answers,
        screening: Screening,
        proven: NDArray[np.bool_],
        gap: NDArray[np.float64],
    ) -> Sheet:
        """Record a batch with what the screening said of it, and what became of the suspects."""
        columns = {
            "regime": batch.regimes,
            "number": batch.numbers,
            "status": answers.status,
            "kind": screening.codes,
            "symptom": screening.symptom,
            "amount": screening.amount,
            "pressure": screening.pressure,
            "error": screening.error,
            "size": batch.sizes,
            "gap": gap,
            "aspect": batch.aspects,
            "proven": proven,
        }
        return cls.of_columns(engine, cell, columns)

    @classmethod
    def of_columns(cls, engine: str, cell: Cell, columns: dict[str, Any]) -> Sheet:
        """Put columns into the smallest types that keep what matters of them."""
        words = sorted({*columns["regime"], *columns["symptom"]})
        code = {word: i for i, word in enumerate(words)}
        packed = {name: np.array([code[word] for word in columns[name]], np.int16) for name in ("regime", "symptom")}
        with np.errstate(over="ignore"):
            for name, kind in TYPES.items():
                packed[name] = np.asarray(columns[name]).astype(kind)
        return cls(engine, cell.query, cell.pair, words, packed)

    def __len__(self) -> int:
        """Return the number of answers."""
        return len(self.columns["number"])


WORDS: dict[str, type[np.generic]] = dict.fromkeys(("engine", "query", "pair", "regime", "symptom"), np.int32)
TYPES: dict[str, type[np.generic]] = {
    "number": np.int64,
    "status": np.int8,
    "kind": np.int8,
    "amount": np.float64,
    "pressure": np.float32,
    "error": np.float64,
    "size": np.float64,
    "gap": np.float32,
    "aspect": np.float32,
    "proven": np.bool_,
}


def joined(sheets: Sequence[Sheet]) -> tuple[list[str], dict[str, NDArray[Any]]]:
    """All words, and one table of all answers, with the engine, the query and the pair as words of each row."""
    words: list[str] = []
    parts: dict[str, list[NDArray[Any]]] = {name: [np.zeros(0, kind)] for name, kind in (WORDS | TYPES).items()}
    for sheet in sheets:
        for name in ("engine", "query", "pair"):
            parts[name].append(np.full(len(sheet), len(words), WORDS[name]))
            words.append(getattr(sheet, name))
        for name in ("regime", "symptom"):
            parts[name].append(sheet.columns[name].astype(WORDS[name]) + len(words))
        for name in TYPES:
            parts[name].append(sheet.columns[name])
        words += sheet.words
    return words, {name: np.concatenate(columns) for name, columns in parts.items()}
