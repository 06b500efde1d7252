"""What became of surveys, as plain data of `report.json`, and back: witnesses are judged anew when they are read."""

from __future__ import annotations

from typing import Any

from oracles.surveys import load_survey
from oracles.surveys.judging import SurveyCount
from oracles.surveys.keeping import restored, shown_from_json, shown_to_json, text_in

TEXTS = ("survey", "engine", "question", "regime", "calls", "promise", "absent")
WHOLE = ("asked", "right", "undecided", "known", "wrong", "lost")


def survey_data(count: SurveyCount) -> dict[str, Any]:
    """Return the counts, and the witnesses with what is proven of them."""
    return {**count.counted(), "witnesses": [shown_to_json(shown) for shown in count.witnesses]}


def survey_from(data: Any) -> SurveyCount:
    """Read it back, and judge the witnesses anew.

    Raises
    ------
    LookupError, TypeError, ValueError
        For anything else, for a subject that there is none of, and for a witness that shows nothing.
    """
    data = restored(data)
    count = SurveyCount("", "")
    for name in TEXTS:
        setattr(count, name, text_in(data[name]))
    for name in WHOLE:
        setattr(count, name, int(data[name]))
    count.worst, count.tolerance = float(data["worst"]), float(data["tolerance"])
    count.errors = [text_in(item) for item in data["errors"]]
    count.explained = {text_in(name): int(number) for name, number in data["explained"].items()}
    load_survey(count.survey)
    count.witnesses = [shown_from_json(count.survey, item) for item in data["witnesses"]]
    return count
