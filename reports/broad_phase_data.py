"""What became of crowds, as plain data of `report.json`, and back."""

from __future__ import annotations

from typing import Any

from oracles.crowds.boxes import BoxCrowd
from oracles.crowds.judging import CrowdCount, Witness
from refimpl.proof import check
from refimpl.proof.wire import certificate_to_json, from_json

TEXTS = ("engine", "regime", "calls", "margin_why", "limit")
WHOLE = (
    "crowds",
    "bodies",
    "pairs",
    "missing",
    "beyond_limit",
    "close",
    "extra",
    "false_alarms",
    "nearest",
    "not_nearest",
    "lost",
)


def crowd_data(count: CrowdCount) -> dict[str, Any]:
    """Return the counts, and the witness with its proof."""
    found = count.witness
    witness = None
    if found is not None:
        witness = {
            "crowd": found.crowd.to_json(),
            "pair": list(found.pair),
            "depth": found.depth,
            "certificate": certificate_to_json(found.certificate),
        }
    return {**count.counted(), "witness": witness}


def crowd_from(data: Any) -> CrowdCount:
    """Read it back, and check the proof of the witness.

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
    count.witness = None if data["witness"] is None else _witness(data["witness"])
    return count


def _witness(data: Any) -> Witness:
    crowd, certificate = BoxCrowd.from_json(data["crowd"]), from_json(data["certificate"])
    i, j = (int(number) for number in data["pair"])
    if not 0 <= i < j < len(crowd):
        raise ValueError(f"a crowd of {len(crowd)} has no bodies {i} and {j}")
    depth, proven = float(data["depth"]), -check(certificate, crowd.box(i), crowd.box(j))[1]
    if not 0 <= depth <= proven:
        raise ValueError(f"the certificate proves an overlap of {float(proven)!r}, not {depth!r}")
    return Witness(crowd, (i, j), depth, certificate)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"expected a text, got {str(value)[:50]!r}")
    return value
