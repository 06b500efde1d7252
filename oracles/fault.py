"""What the ledger of known faults goes by: one failure of an engine, whatever it was that was asked."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from oracles.words import decade_of

BROAD_PHASE = "broad phase"
"""What crowds ask, where scenes have a query."""


@dataclass(frozen=True)
class Fault:
    """One failure: of a scene, of a case of a survey, of a crowd.

    Attributes
    ----------
    query, pair
        What was asked: query and pair of a scene; ``survey NAME`` and the question; ``broad phase`` and what of it.
    amount, size
        By how much the answer is off, as a length, and the largest coordinate or extent that it is held against.
    special
        What is special about the geometry.
    against_reference
        Whether it speaks against `refimpl` itself: no ledger explains that.
    """

    engine: str
    query: str
    pair: str
    symptom: str
    regime: str
    amount: float
    size: float
    special: str = ""
    against_reference: bool = False

    @property
    def decade(self) -> int | None:
        """Decade of the error relative to the size; None without an amount."""
        return decade_of(self.amount, self.size)

    @property
    def degeneracy(self) -> str:
        """What is special about the geometry."""
        return self.special

    @property
    def thinnest(self) -> float:
        """Smallest half extent; infinite where that is no matter."""
        return math.inf

    @property
    def approach(self) -> float:
        """Velocity at which bodies come nearer; infinite where nothing moves."""
        return math.inf


Known = Callable[[Fault], str]
"""Name of the ledger's entry that explains a fault; empty for what is new."""


def unknown(fault: Fault) -> str:
    """Know nothing."""
    del fault
    return ""


def survey_query(name: str) -> str:
    """What stands for the query of a survey's faults."""
    return f"survey {name}"
