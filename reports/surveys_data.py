"""What became of surveys, as plain data of `report.json`, and back: witnesses are judged anew when they are read."""

from __future__ import annotations

import math
from typing import Any

from oracles.isolation.children import Said
from oracles.surveys import load_survey
from oracles.surveys.judging import Shown, SurveyCount
from oracles.surveys.survey import Case

TEXTS = ("survey", "engine", "question", "regime", "calls", "promise", "absent")
WHOLE = ("asked", "right", "undecided", "known", "wrong", "lost")
NAMES = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}
"""Of numbers that JSON does not have."""


def survey_data(count: SurveyCount) -> dict[str, Any]:
    """Return the counts, and the witness with what is proven of it."""
    found = count.witness
    witness = None
    if found is not None:
        judgement = found.judgement
        witness = {
            "case": found.case.to_json(),
            "answer": found.said.answer,
            "lost": found.said.lost,
            "amount": None if judgement is None else judgement.amount,
            "words": "" if judgement is None else judgement.words,
            "proof": None if judgement is None else judgement.proof,
            "tolerance": found.tolerance,
            "known": found.known,
        }
    return {**count.counted(), "witness": witness}


def survey_from(data: Any) -> SurveyCount:
    """Read it back, and judge the witness anew.

    Raises
    ------
    LookupError, TypeError, ValueError
        For anything else, for a subject that there is none of, and for a witness that shows nothing.
    """
    data = restored(data)
    count = SurveyCount("", "")
    for name in TEXTS:
        setattr(count, name, _text(data[name]))
    for name in WHOLE:
        setattr(count, name, int(data[name]))
    count.worst, count.tolerance = float(data["worst"]), float(data["tolerance"])
    count.errors, count.excuses = ([_text(item) for item in data[name]] for name in ("errors", "excuses"))
    survey = load_survey(count.survey)
    if data["witness"] is not None:
        found = data["witness"]
        case, said = Case.from_json(found["case"]), Said(found["answer"], _text(found["lost"]))
        survey.check(case)
        judgement = None if said.lost else survey.judge(case, said.answer)
        count.witness = Shown(case, said, judgement, float(found["tolerance"]), _text(found["known"]))
        if count.witness.kind not in ("wrong", "known", "lost"):
            raise ValueError(f"a witness of the survey {count.survey} shows nothing wrong")
    return count


def restored(value: Any) -> Any:
    """Plain data with the numbers that are written as texts, because they are not finite."""
    if isinstance(value, dict):
        return {name: restored(item) for name, item in value.items()}
    if isinstance(value, list):
        return [restored(item) for item in value]
    return NAMES.get(value, value) if isinstance(value, str) else value


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"expected a text, got {str(value)[:50]!r}")
    return value
