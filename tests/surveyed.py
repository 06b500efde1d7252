"""A small survey for tests, of square roots, with engines that are right, wrong, crash, hang or say nonsense."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, ClassVar

from oracles.surveys.survey import Case, Judgement, Library, Survey, SurveyEngine

NUMBERS = [0.0, 1.0, 4.0, 2.0, 10.0, 1e9, 123456.789]


class Roots(Survey):
    """Square roots: off by |root² − number|, relative."""

    name, title, about = "roots", "Square roots", "The square of the root has to be the number."
    questions: ClassVar = {"root": "the root of a number; off relative to it", "sign": "whether it is above 0"}
    regimes: ClassVar = {"small": "below 100", "large": "the others"}
    engines: ClassVar = {
        name: Library(f"tests.surveyed:{attribute}", module, "nothing")
        for name, attribute, module in (
            ("right", "Right", "math"),
            ("refimpl", "Halves", "math"),
            ("absent", "Right", "no_such_module_at_all"),
            ("broken", "NoSuchClass", "math"),
        )
    }
    each: ClassVar = 1.5

    def cases(self, seed: int) -> list[Case]:
        regimes = ["small" if number < 100 else "large" for number in NUMBERS]
        pairs = list(zip(NUMBERS, regimes, strict=True))
        return [Case(q, regime, {"number": number}) for q in self.questions for number, regime in pairs]

    def judge(self, case: Case, answer: Any) -> Judgement:
        number = Fraction(case.data["number"])
        if case.question == "sign":
            if not isinstance(answer, bool):
                raise TypeError("expected True or False")
            return Judgement(float(answer != (number > 0)), f"{number} is {'' if number > 0 else 'not '}above 0")
        off = abs(Fraction(answer) ** 2 - number) / max(number, Fraction(1, 10**300))
        return Judgement(float(off), f"the square is {float(Fraction(answer) ** 2)}", {"off": str(off)})

    def check(self, case: Case) -> None:
        if case.question not in self.questions or not 0 <= float(case.data["number"]) < math.inf:
            raise ValueError("expected a number of at least 0")

    def simpler(self, case: Case) -> Iterator[Case]:
        number = case.data["number"]
        yield from (Case(case.question, case.regime, {"number": float(n)}) for n in range(10) if n < number)

    def written(self, case: Case) -> str:
        return f"{case.question}({case.data['number']!r})"


class Right(SurveyEngine):
    """Right."""

    calls: ClassVar = "math.sqrt"
    promise: ClassVar = "correctly rounded"

    def tolerance(self, case: Case) -> float:
        return 1e-15 if case.question == "root" else 0.0

    def answer(self, case: Case) -> Any:
        number = case.data["number"]
        return number > 0 if case.question == "sign" else math.sqrt(number)


class Halves(Right):
    """Wrong: half of the number, right for 0 and 4."""

    def answer(self, case: Case) -> Any:
        return case.data["number"] / 2 if case.question == "root" else super().answer(case)


class Switched(Right):
    """Wrong as SWITCHED_FAULT says: not at all, by half of the number, by all of it, or with no answer."""

    def answer(self, case: Case) -> Any:
        fault = os.environ.get("SWITCHED_FAULT", "")
        if not fault or case.question == "sign":
            return super().answer(case)
        if fault == "silent":
            raise RuntimeError("no roots today")
        return case.data["number"] / 2 if fault == "halves" else case.data["number"]


class NotANumber(Right):
    """Wrong: no number for large ones."""

    def answer(self, case: Case) -> Any:
        return math.nan if case.regime == "large" else super().answer(case)


class Fragile(Right):
    """Ends, hangs, raises, prints and says nonsense."""

    def answer(self, case: Case) -> Any:
        print("a line of the library's own")
        match case.data["number"]:
            case 1.0:
                os.kill(os.getpid(), signal.SIGSEGV)
            case 4.0:
                time.sleep(60)
            case 10.0:
                raise RuntimeError("no roots of ten")
            case 1e9:
                return "a potato"
            case 123456.789:
                return object()
        return super().answer(case)


class Leaking(Right):
    """Takes 256 MiB for the root of one, and keeps them until it is asked again."""

    kept: ClassVar[list[bytearray]] = []

    def answer(self, case: Case) -> Any:
        if case.data["number"] == 1.0:
            for _ in range(16):
                self.kept.append(bytearray(1 << 24))
        self.kept.clear()
        return super().answer(case)


class Slow(Right):
    """Right, after a while in which it waits for the processor."""

    def answer(self, case: Case) -> Any:
        time.sleep(0.4)
        return super().answer(case)
