"""Witnesses of what is no scene: a case of a survey, a crowd before a broad phase; and what a run found of both."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from oracles.crowds import failing as crowds
from oracles.crowds.judging import COUNTED
from oracles.fault import BROAD_PHASE, survey_query
from oracles.outcome import ID_DIGITS, Run
from oracles.surveys.judging import NO_ANSWER_AT_ALL, Shown
from oracles.surveys.keeping import restored, shown_from_json, shown_to_json
from oracles.surveys.survey import REFERENCE


@dataclass(frozen=True)
class CaseWitness:
    """A case of a survey on which an engine failed."""

    engine: str
    survey: str
    shown: Shown
    version: str = ""

    @property
    def id(self) -> str:
        """Hash of what was asked."""
        return _hash([self.survey, self.shown.case.question, self.shown.case.data])

    @property
    def key(self) -> str:
        """What is wrong, shortly."""
        return _key(self.engine, survey_query(self.survey), self.shown.case.question, self.shown.symptom)

    def parts(self) -> dict[str, Any]:
        """What its file holds of it."""
        return {"engine": self.engine, "survey": self.survey, "case": shown_to_json(self.shown)}


@dataclass(frozen=True)
class CrowdWitness:
    """A crowd on which a broad phase failed."""

    engine: str
    witness: crowds.Witness
    version: str = ""

    @property
    def id(self) -> str:
        """Hash of what was asked."""
        return _hash([self.witness.crowd.to_json(), self.witness.pair])

    @property
    def key(self) -> str:
        """What is wrong, shortly."""
        return _key(self.engine, BROAD_PHASE, crowds.ASKED[self.witness.symptom], self.witness.symptom)

    def parts(self) -> dict[str, Any]:
        """What its file holds of it."""
        return {"engine": self.engine, "crowd": self.witness.to_json()}


def study_from_json(data: dict[str, Any], version: str) -> CaseWitness | CrowdWitness:
    """Read what `parts` gave, and check what it proves; raises whatever damage ends in."""
    data = restored(data)
    if "case" in data:
        return CaseWitness(str(data["engine"]), data["survey"], shown_from_json(data["survey"], data["case"]), version)
    return CrowdWitness(str(data["engine"]), crowds.Witness.from_json(data["crowd"]), version)


def _hash(asked: Any) -> str:
    return sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:ID_DIGITS]


def _key(*words: str) -> str:
    return " · ".join(words)


@dataclass(frozen=True)
class Failed:
    """One failure of a survey's engine or of a broad phase, as a run shows it: what a bucket is to scenes.

    Attributes
    ----------
    regimes
        In which it was seen.
    entry
        Name of the ledger's entry that explains it; empty for what is new.
    """

    query: str
    pair: str
    symptom: str
    regimes: tuple[str, ...]
    entry: str
    claim: str
    witness: CaseWitness | CrowdWitness

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.witness.engine


def failed_in(run: Run) -> Iterator[Failed]:
    """Everything that surveys and crowds show; never of the reference."""
    for count in run.surveys:
        about = count.survey, count.engine, count.question
        mine = [c for c in run.surveys if (c.survey, c.engine, c.question) == about]
        for shown in count.witnesses if count.engine != REFERENCE else ():
            name = "lost" if shown.symptom == NO_ANSWER_AT_ALL else "wrong"
            regimes = [c.regime for c in mine if (c.explained.get(shown.entry) if shown.entry else getattr(c, name))]
            asked = survey_query(count.survey), count.question, shown.symptom
            version = run.engine_versions.get(count.engine, "")
            kept = CaseWitness(count.engine, count.survey, shown, version)
            yield Failed(*asked, tuple(regimes), shown.entry, shown.claim, kept)
    for crowd in run.crowds:
        same = [c for c in run.crowds if c.engine == crowd.engine]
        for one in crowd.witnesses:
            name = COUNTED[one.symptom]
            regimes = [c.regime for c in same if (c.explained.get(one.entry) if one.entry else getattr(c, name))]
            asked = BROAD_PHASE, crowds.ASKED[one.symptom], one.symptom
            claim = one.said or f"two of {len(one.crowd)} bodies are not named, whose boxes overlap by {one.depth:.3g}"
            kept_crowd = CrowdWitness(crowd.engine, one, run.engine_versions.get(crowd.engine, ""))
            yield Failed(*asked, tuple(regimes), one.entry, claim, kept_crowd)


def seen_in(run: Run, engine: str, entry: str) -> int:
    """How many failures of surveys and crowds an entry explains."""
    surveys = [count.explained for count in run.surveys if count.engine == engine]
    return sum(told.get(entry, 0) for told in [*surveys, *(c.explained for c in run.crowds if c.engine == engine)])


def asked_of(run: Run, engine: str) -> list[tuple[str, str]]:
    """What surveys and crowds have asked an engine, as query and pair."""
    asked = [(survey_query(c.survey), c.question) for c in run.surveys if c.engine == engine and not c.absent]
    if any(count.engine == engine for count in run.crowds):
        asked += [(BROAD_PHASE, pair) for pair in sorted(set(crowds.ASKED.values()))]
    return list(dict.fromkeys(asked))
