"""Counting what the engines of a survey answer, and the smallest case that shows what is wrong."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from types import MappingProxyType

from oracles.fault import Fault, Known, survey_query, unknown
from oracles.isolation.child import LONGEST
from oracles.isolation.children import NO_ANSWER, NO_TIME, Said, ask_apart
from oracles.outcome import Kind, Met
from oracles.surveys import load_survey
from oracles.surveys.survey import REFERENCE, Case, Judgement, Survey, SurveyEngine

MOST_ROUNDS, MOST_TRIES = 12, 64
"""Of asking whether simpler cases show the same, and cases of one round."""
DAMAGE = (ValueError, TypeError, LookupError, AttributeError, OverflowError)

Asker = Callable[[Sequence[Case]], list[Said]]

WRONG, NO_ANSWER_AT_ALL = "wrong answer", "no answer"
"""Symptoms, for the ledger."""
KINDS = {"right": Kind.AGREES, "undecided": Kind.UNDECIDED, "wrong": Kind.WRONG, "lost": Kind.CRASHED}
"""Of a witness that is asked again."""


@dataclass(frozen=True)
class Shown:
    """What an engine said of a case, and what is proven of that.

    Attributes
    ----------
    said
        The answer, or why there is none.
    judgement
        None where there is no answer.
    tolerance
        By how much the engine's answer may be off here.
    entry
        Name of the ledger's entry that explains it, where it is wrong or lost; empty for what is new.
    """

    case: Case
    said: Said
    judgement: Judgement | None
    tolerance: float
    entry: str = ""

    @property
    def kind(self) -> str:
        """Of "right", "undecided", "wrong" and "lost"."""
        if self.judgement is None:
            return "lost"
        if self.judgement.undecided:
            return "undecided"
        return "right" if self.judgement.amount <= self.tolerance else "wrong"  # also where the amount is no number

    @property
    def failed(self) -> bool:
        """Whether it is wrong or lost."""
        return self.kind in ("wrong", "lost")

    @property
    def symptom(self) -> str:
        """The same in the ledger's words."""
        return NO_ANSWER_AT_ALL if self.judgement is None else WRONG

    @property
    def claim(self) -> str:
        """What went wrong, in a sentence."""
        return self.said.lost if self.judgement is None else self.judgement.words


@dataclass
class SurveyCount:
    """What became of one question and regime before one engine.

    Attributes
    ----------
    asked, right, undecided, known, wrong, lost : int
        Cases, and what became of them; `known` are wrong or lost by a fault that the ledger has.
    worst : float
        Largest amount by which an answer is proven to be off, within the tolerance or beyond it.
    tolerance : float
        The largest.
    absent : str
        Why the engine was not asked at all; question and regime are empty then.
    errors : list of str
        Why cases were lost, each reason once.
    explained : dict of str to int
        How many cases are known by which entry of the ledger.
    witnesses : list of Shown
        Of each question, symptom and entry a case that shows it, with one of its regimes; new ones as simple as can be.
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
    explained: dict[str, int] = field(default_factory=dict)
    witnesses: list[Shown] = field(default_factory=list)

    def counted(self) -> dict[str, object]:
        """Return everything but the witnesses, as plain data."""
        return {name: value for name, value in vars(self).items() if name != "witnesses"}

    @property
    def failed(self) -> bool:
        """Whether anything is wrong or lost that the ledger does not explain."""
        return self.wrong > 0 or self.lost > 0

    @property
    def against_reference(self) -> bool:
        """Whether the reference itself is proven wrong; an answer that is lost proves nothing."""
        return self.wrong > 0 and self.engine == REFERENCE

    def add(self, shown: Shown) -> None:
        """Count one answer."""
        kind = "known" if shown.entry else shown.kind
        self.asked += 1
        setattr(self, kind, getattr(self, kind) + 1)
        self.tolerance = max(self.tolerance, shown.tolerance)
        self.errors += [shown.said.lost] * (kind == "lost" and shown.said.lost not in self.errors)
        if shown.entry:
            self.explained[shown.entry] = self.explained.get(shown.entry, 0) + 1
        if shown.judgement is not None:
            amount = shown.judgement.amount
            self.worst = max(self.worst, math.inf if math.isnan(amount) else amount)


@dataclass(frozen=True)
class Judge:
    """Judges what one engine says of a survey's cases.

    Attributes
    ----------
    name
        Of the engine.
    known
        What the ledger says of what is wrong or lost.
    """

    survey: Survey
    name: str
    engine: SurveyEngine
    known: Known = unknown

    def shown(self, case: Case, said: Said) -> Shown:
        """Judge one answer."""
        judgement = None
        if not said.lost:
            try:
                judgement = self.survey.judge(case, said.answer)
            except DAMAGE as error:
                said = Said(lost=f"{NO_ANSWER}: {error}"[:LONGEST])
        made = Shown(case, said, judgement, self.engine.tolerance(case))
        return replace(made, entry=self.known(self.fault(made))) if made.failed else made

    def asked(self, cases: Sequence[Case], asker: Asker) -> list[Shown]:
        """Ask, and judge the answers."""
        return [self.shown(case, said) for case, said in zip(cases, asker(cases), strict=True)]

    def met(self, witness: str, shown: Shown) -> Met:
        """What became of a witness of this id that was asked again."""
        return Met(witness, KINDS[shown.kind], self.fault(shown) if shown.failed else None)

    def fault(self, shown: Shown) -> Fault:
        """What the ledger goes by of a case that is wrong or lost."""
        case, size = shown.case, self.survey.size(shown.case)
        amount = 0.0 if shown.judgement is None else shown.judgement.amount * size
        asked = survey_query(self.survey.name), case.question, shown.symptom, case.regime
        return Fault(self.name, *asked, amount, size, self.survey.special(case), self.name == REFERENCE)

    def smallest(self, asker: Asker, first: Shown) -> Shown:
        """Find a simpler case of the same kind, as long as the engine, asked anew each time, goes on failing."""
        best = first
        if first.said.lost.startswith(NO_TIME):  # looking for simpler ones would take long
            return best
        for _ in range(MOST_ROUNDS):
            found = self.asked(list(islice(self.survey.simpler(best.case), MOST_TRIES)), asker)
            simpler = next((one for one in found if (one.kind, one.entry) == (best.kind, best.entry)), None)
            if simpler is None:
                break
            best = simpler
        return best


def counted(judge: Judge, answers: Sequence[Shown], asker: Asker) -> list[SurveyCount]:
    """Count what an engine says by question and regime, and show what is wrong: of what is new the simplest case."""
    engine = judge.engine
    counts: dict[tuple[str, str], SurveyCount] = {}
    failing: dict[tuple[str, str, str], list[Shown]] = {}
    for one in answers:
        key = one.case.question, one.case.regime
        if key not in counts:
            names = judge.survey.name, judge.name
            counts[key] = SurveyCount(*names, *key, calls=engine.calls, promise=engine.promise)
        counts[key].add(one)
        if one.failed:
            failing.setdefault((one.case.question, one.symptom, one.entry), []).append(one)
    for those in failing.values():
        first = min(those, key=lambda one: len(json.dumps(one.case.data)))
        found = first if first.entry else judge.smallest(asker, first)  # the ledger has simple ones of what is known
        counts[first.case.question, first.case.regime].witnesses.append(found)
    return list(counts.values())


def judged(
    survey: Survey,
    name: str,
    engine: SurveyEngine,
    cases: Sequence[Case],
    asker: Asker,
    known: Known = unknown,
) -> list[SurveyCount]:
    """Ask an engine what it answers of some cases, and judge that."""
    judge, wanted = Judge(survey, name, engine, known), [case for case in cases if engine.answers(case.question)]
    return counted(judge, judge.asked(wanted, asker), asker)


def question(
    name: str, engine: str, seed: int, known: Known = unknown, again: Mapping[str, Case] = MappingProxyType({})
) -> tuple[list[SurveyCount], list[Met]]:
    """Ask one engine of a survey about everything, and before that about the ledger's witnesses (`again`, by id)."""
    survey = load_survey(name)
    library = survey.engines[engine]
    absent = library.missing()
    if absent:
        return [SurveyCount(survey.name, engine, absent=absent)], []

    def asker(cases: Sequence[Case]) -> list[Said]:
        data = [case.to_json() for case in cases]
        return ask_apart("oracles.surveys.survey:answerer", library.spec, data, survey.each) if data else []

    judge = Judge(survey, engine, library.load(), known)
    wanted = [case for case in survey.cases(seed) if judge.engine.answers(case.question)]
    first = {name: case for name, case in again.items() if judge.engine.answers(case.question)}
    answers = judge.asked([*first.values(), *wanted], asker)
    met = [judge.met(name, shown) for name, shown in zip(first, answers, strict=False)]
    return counted(judge, answers, asker), met
