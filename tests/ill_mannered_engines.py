"""Engines that do harm when they are imported, describe themselves badly, or answer rightly with bad manners."""

from __future__ import annotations

import ctypes
import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from oracles.engine import AnswerRow, Array, Effective, Kind, Row
from oracles.scene import CONTACTS, DISTANCE
from tests.hostile_engines import FE_UPWARD, NONSENSE, Hostile, UnspeakableError, floods, forks, leaks
from tests.wrong_engines import Answer, Honest, OffByAThousandth

# -- harmful adapters ----------------------------------------------------------------------------------------


class RaisesOnSupport(Honest):
    def _support(self, query: str, A: Kind, B: Kind) -> Any:
        raise SystemExit(0)


class RubbishSays(Honest):
    def says(self, query: str, A: Kind, B: Kind) -> Any:
        return ["distance", 7]


class HangsOnWarm(Honest):
    def warm(self) -> None:
        while True:
            pass


class LeaksOnWarm(Honest):
    def warm(self) -> None:
        leaks(())


class PrintsOnWarm(Hostile):
    def warm(self) -> None:
        floods(())


class ForksOnWarm(Hostile):
    """Starts a process that it needs, and a child that returns to the harness."""

    def warm(self) -> None:
        forks(())
        os.fork()


class LeavesOnWarm(Honest):
    def warm(self) -> None:
        sys.exit(3)


class RoundsUpFromTheStart(Honest):
    """Sets the rounding when it is imported, and answers the rounding that it finds."""

    def warm(self) -> None:
        ctypes.CDLL(None).fesetround(FE_UPWARD)

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        return super().spoil(answer | {"distance": float(ctypes.CDLL(None).fegetround())}, row_a)


# -- right answers with bad manners, in every scene or in some -----------------------------------------------


class DiesOfItsPast(Honest):
    """Aborts in its 500th call, whatever that is about."""

    name: ClassVar[str] = "dies-of-its-past"

    def __init__(self) -> None:
        self.calls = 0

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        self.calls += 1
        if self.calls == 500:
            os.abort()
        return super().spoil(answer, row_a)


class Unhurried(Honest):
    """Right, in its own time."""

    name: ClassVar[str] = "unhurried"

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        time.sleep(0.002)
        return super().spoil(answer, row_a)


class ChangesRounding(Honest):
    name: ClassVar[str] = "changes-rounding"

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        row = super().spoil(answer, row_a)
        ctypes.CDLL(None).fesetround(FE_UPWARD)
        return row


class LeavesAnError(Honest):
    name: ClassVar[str] = "leaves-an-error"

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        np.seterr(all="raise")
        return super().spoil(answer, row_a)


class RaisesOnEffective(OffByAThousandth):
    name: ClassVar[str] = "raises-on-effective"

    def effective(self, query: str, A: Kind, rows_a: Array, B: Kind, rows_b: Array) -> tuple[Effective, Effective]:
        if query == CONTACTS:
            raise SystemExit(UnspeakableError())
        return super().effective(query, A, rows_a, B, rows_b)


class RubbishEffective(OffByAThousandth):
    """Says nothing of itself that can be used, once it is asked in earnest."""

    name: ClassVar[str] = "rubbish-effective"

    def effective(self, query: str, A: Kind, rows_a: Array, B: Kind, rows_b: Array) -> Any:
        given = super().effective(query, A, rows_a, B, rows_b)
        if query == CONTACTS:
            return given[0], Effective(B, rows_b, np.full(len(rows_b), -1.0))
        if query == DISTANCE:
            return given[0], Effective(B, rows_b[:-1] * math.nan, given[1].margin)
        return [*given]

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> Any:
        return 7


class LeavesChildren(Honest):
    """Leaves a child at its first call, and another whenever that is gone."""

    name: ClassVar[str] = "leaves-children"

    def __init__(self) -> None:
        self.child: subprocess.Popen[bytes] | None = None

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        if self.child is None:
            self.child = subprocess.Popen(["sleep", "3600"], start_new_session=True)
        return super().spoil(answer, row_a)


class Rubbish(Honest):
    """Answers nonsense of another kind for each decade of the first coordinate, where that is positive."""

    name: ClassVar[str] = "rubbish"

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        kinds = list(NONSENSE.values())
        if row_a[0] > 0:
            nonsense: AnswerRow = kinds[int(math.log10(row_a[0]) + 400) % len(kinds)][0]
            return nonsense
        return super().spoil(answer, row_a)


class Sleeper(Honest):
    """Sleeps in its first call, once it has left a file in the folder that the environment names."""

    name: ClassVar[str] = "sleeper"

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        Path(os.environ["PROXYPROOF_ASLEEP"]).touch()
        time.sleep(3600)
        return super().spoil(answer, row_a)
