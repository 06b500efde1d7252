"""What became of crowds, as plain data of `report.json`, and back."""

from __future__ import annotations

from typing import Any

from oracles.crowds.failing import Witness
from oracles.crowds.judging import CrowdCount

TEXTS = ("engine", "regime", "calls", "margin_why")
WHOLE = (
    "crowds",
    "bodies",
    "pairs",
    "missing",
    "known",
    "close",
    "extra",
    "false_alarms",
    "nearest",
    "not_nearest",
    "lost",
)


def crowd_data(count: CrowdCount) -> dict[str, Any]:
    """Return the counts, and the witnesses with their proofs."""
    return {**count.counted(), "witnesses": [witness.to_json() for witness in count.witnesses]}


def crowd_from(data: Any) -> CrowdCount:
    """Read it back, and check the proofs of the witnesses.

    Raises
    ------
    LookupError, TypeError, ValueError
        For anything else, and for a proof that does not hold.
    """
    count = CrowdCount("", "")
    for name in TEXTS:
        setattr(count, name, _text(data[name]))
    for name in WHOLE:
        setattr(count, name, int(data[name]))
    count.margin, count.widest = float(data["margin"]), float(data["widest"])
    count.errors = [_text(error) for error in data["errors"]]
    count.explained = {_text(name): int(number) for name, number in data["explained"].items()}
    count.witnesses = [Witness.from_json(item) for item in data["witnesses"]]
    return count


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"expected a text, got {str(value)[:50]!r}")
    return value
