"""A case of a survey with what an engine said of it, as plain data and back: it is judged anew when it is read."""

from __future__ import annotations

import math
from typing import Any

from oracles.isolation.children import Said
from oracles.surveys import load_survey
from oracles.surveys.judging import Shown
from oracles.surveys.survey import Case

NAMES = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}
NAMES |= {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
"""Of numbers that JSON does not have, in reports and in the ledger's witnesses."""


def shown_to_json(shown: Shown) -> dict[str, Any]:
    """Return the case, the answer, and what is proven of it."""
    judgement = shown.judgement
    return {
        "case": shown.case.to_json(),
        "answer": shown.said.answer,
        "lost": shown.said.lost,
        "amount": None if judgement is None else judgement.amount,
        "words": "" if judgement is None else judgement.words,
        "proof": None if judgement is None else judgement.proof,
        "tolerance": shown.tolerance,
        "entry": shown.entry,
    }


def shown_from_json(survey: str, data: Any) -> Shown:
    """Read it back, and judge the answer anew.

    Raises
    ------
    LookupError, TypeError, ValueError
        For anything else, for a subject that there is none of, and for an answer that is not wrong.
    """
    subject = load_survey(survey)
    case, said = Case.from_json(data["case"]), Said(data["answer"], text_in(data["lost"]))
    subject.check(case)
    judgement = None if said.lost else subject.judge(case, said.answer)
    found = Shown(case, said, judgement, float(data["tolerance"]), text_in(data["entry"]))
    if not found.failed:
        raise ValueError(f"a witness of the survey {survey} shows nothing wrong")
    return found


def restored(value: Any) -> Any:
    """Plain data with the numbers that are written as texts, because they are not finite."""
    if isinstance(value, dict):
        return {name: restored(item) for name, item in value.items()}
    if isinstance(value, list):
        return [restored(item) for item in value]
    return NAMES.get(value, value) if isinstance(value, str) else value


def text_in(value: Any) -> str:
    """A text, and nothing else."""
    if not isinstance(value, str):
        raise TypeError(f"expected a text, got {str(value)[:50]!r}")
    return value
