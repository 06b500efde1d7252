"""Counting what the engines of a survey answer, and the smallest case that shows what is wrong."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import islice

from oracles.isolation.child import LONGEST
from oracles.isolation.children import NO_ANSWER, NO_TIME, Said, ask_apart
from oracles.surveys import load_survey
from oracles.surveys.survey import REFERENCE, Case, Judgement, Survey, SurveyEngine

MOST_ROUNDS, MOST_TRIES = 12, 64
"""Of asking whether simpler cases show the same, and cases of one round."""
DAMAGE = (ValueError, TypeError, LookupError, AttributeError, OverflowError)

Asker = Callable[[Sequence[Case]], list[Said]]


@dataclass(frozen=True)
class Shown:
    """A witness: a case, what the engine said of it, and what is proven of that.

    Attributes
    ----------
    said
        The answer, or why there is none.
    judgement
        None where there is no answer.
    tolerance
        By how much the engine's answer may be off here.
    known
        Sentence on the known fault that it is.
    """

    case: Case
    said: Said
    judgement: Judgement | None
    tolerance: float
    known: str = ""

    @property
    def kind(self) -> str:
        """Of "right", "undecided", "known", "wrong" and "lost"."""
        if self.judgement is None:
            return "known" if self.known else "lost"
        if self.judgement.undecided:
            return "undecided"
        if self.judgement.amount <= self.tolerance:  # and not if the amount is no number
            return "right"
        return "known" if self.known else "wrong"


@dataclass
class SurveyCount:
    """What became of one question and regime before one engine.

    Attributes
    ----------
    asked, right, undecided, known, wrong, lost : int
        Cases, and what became of them; `known` are wrong or lost by a fault that the adapter names.
    worst : float
        Largest amount by which an answer is proven to be off, within the tolerance or beyond it.
    tolerance : float
        The largest.
    absent : str
        Why the engine was not asked at all; question and regime are empty then.
    errors, excuses : list of str
        Why cases were lost, and the known faults, each once.
    """

    survey: str
    engine: str
    question: str = ""
    regime: str = ""
    asked: int = 0
    right: int = 0
    undecided: int = 0
    known: int = 0
    wrong: int = 0
    lost: int = 0
    worst: float = 0.0
    tolerance: float = 0.0
    calls: str = ""
    promise: str = ""
    absent: str = ""
    errors: list[str] = field(default_factory=list)
    excuses: list[str] = field(default_factory=list)
    witness: Shown | None = None

    def counted(self) -> dict[str, object]:
        """Return everything but the witness, as plain data."""
        return {name: value for name, value in vars(self).items() if name != "witness"}

    @property
    def failed(self) -> bool:
        """Whether anything is not as it is promised."""
        return self.wrong > 0 or self.lost > 0

    @property
    def against_reference(self) -> bool:
        """Whether the reference itself is proven wrong; an answer that is lost proves nothing."""
        return self.wrong > 0 and self.engine == REFERENCE

    def add(self, shown: Shown) -> None:
        """Count one answer."""
        kind = shown.kind
        self.asked += 1
        setattr(self, kind, getattr(self, kind) + 1)
        self.tolerance = max(self.tolerance, shown.tolerance)
        self.errors += [shown.said.lost] * (kind == "lost" and shown.said.lost not in self.errors)
        self.excuses += [shown.known] * (kind == "known" and shown.known not in self.excuses)
        if shown.judgement is not None:
            amount = shown.judgement.amount
            self.worst = max(self.worst, math.inf if math.isnan(amount) else amount)


def shown(survey: Survey, engine: SurveyEngine, case: Case, said: Said) -> Shown:
    """Judge one answer."""
    judgement = None
    if not said.lost:
        try:
            judgement = survey.judge(case, said.answer)
        except DAMAGE as error:
            said = Said(lost=f"{NO_ANSWER}: {error}"[:LONGEST])
    made = Shown(case, said, judgement, engine.tolerance(case))
    return Shown(case, said, judgement, made.tolerance, engine.known(case)) if made.kind in ("wrong", "lost") else made


def smallest(survey: Survey, engine: SurveyEngine, asker: Asker, first: Shown) -> Shown:
    """Find a simpler case of the same kind, as long as the engine, asked anew each time, goes on failing."""
    best = first
    if first.said.lost.startswith(NO_TIME):  # looking for simpler ones would take long
        return best
    for _ in range(MOST_ROUNDS):
        tries = list(islice(survey.simpler(best.case), MOST_TRIES))
        found = (shown(survey, engine, case, said) for case, said in zip(tries, asker(tries), strict=True))
        simpler = next((one for one in found if one.kind == best.kind), None)
        if simpler is None:
            break
        best = simpler
    return best


def judged(survey: Survey, name: str, engine: SurveyEngine, cases: Sequence[Case], asker: Asker) -> list[SurveyCount]:
    """Ask an engine, count what it says by question and regime, and show for each question what is wrong."""
    cases = [case for case in cases if engine.answers(case.question)]
    counts: dict[tuple[str, str], SurveyCount] = {}
    failing: dict[str, list[Shown]] = {}
    for case, said in zip(cases, asker(cases), strict=True):
        key = case.question, case.regime
        if key not in counts:
            counts[key] = SurveyCount(survey.name, name, *key, calls=engine.calls, promise=engine.promise)
        one = shown(survey, engine, case, said)
        counts[key].add(one)
        if one.kind in ("wrong", "known", "lost"):
            failing.setdefault(case.question, []).append(one)
    for those in failing.values():
        first = min(those, key=_smaller_first)
        counts[first.case.question, first.case.regime].witness = smallest(survey, engine, asker, first)
    return list(counts.values())


def _smaller_first(one: Shown) -> tuple[int, int]:
    """What is wrong before what is lost or known, and the shortest of it."""
    return ("wrong", "lost", "known").index(one.kind), len(json.dumps(one.case.data))


def question(name: str, engine: str, seed: int) -> list[SurveyCount]:
    """Ask one engine of a survey about everything."""
    survey = load_survey(name)
    library = survey.engines[engine]
    absent = library.missing()
    if absent:
        return [SurveyCount(survey.name, engine, absent=absent)]

    def asker(cases: Sequence[Case]) -> list[Said]:
        data = [case.to_json() for case in cases]
        return ask_apart("oracles.surveys.survey:answerer", library.spec, data, survey.each) if data else []

    return judged(survey, engine, library.load(), survey.cases(seed), asker)
