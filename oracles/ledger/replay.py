"""Replaying a witness: the engine is asked the same scene again, and judged anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from oracles.answers import reference_for, said
from oracles.engine import Answers
from oracles.judges import Judges
from oracles.ledger.entry import Entry
from oracles.ledger.files import Ledger
from oracles.ledger.witness import Witness
from oracles.outcome import FINDINGS, Finding, Kind
from oracles.scene import Scene


class Fate(StrEnum):
    """What became of a witness."""

    FAILS = "fails as before"
    CHANGED = "fails otherwise"
    PASSES = "passes now"
    NOT_ASKED = "could not be asked"


@dataclass(frozen=True)
class Replayed:
    """A witness, the verdict on what the engine says now, and the finding where that is one."""

    witness: Witness
    kind: Kind
    finding: Finding | None


def replay(witness: Witness, ask: Callable[[Scene], Answers], judges: Judges) -> Replayed:
    """Have the engine asked, which may be lost by it, and judge what it says."""
    scene, cell = witness.scene, witness.scene.cell
    if not judges.engine.support(cell.query, cell.type_a, cell.type_b):
        return Replayed(witness, Kind.UNSUPPORTED, None)
    answers = ask(scene)
    verdict = judges.convict(scene, answers)
    if verdict.kind not in FINDINGS:
        return Replayed(witness, verdict.kind, None)
    name = "refimpl" if verdict.kind is Kind.REFERENCE_WRONG else witness.engine
    reference = said(reference_for(scene), 0)
    finding = Finding(name, scene, said(answers, 0), reference, verdict, answers.errors.get(0, ""))
    return Replayed(witness, verdict.kind, finding)


def fate(replayed: Replayed, entry: Entry) -> Fate:
    """What a replay says of an entry: whether what is found now still has its cause, as far as it reaches."""
    if replayed.kind in (Kind.UNSUPPORTED, Kind.SKIPPED):
        return Fate.NOT_ASKED
    finding = replayed.finding
    if finding is None:
        return Fate.PASSES
    same = entry.covers(finding.engine, finding.scene, finding.verdict)
    return Fate.FAILS if same else Fate.CHANGED


def to_replay(ledger: Ledger, engine: str) -> list[Witness]:
    """Witnesses of the entries that are about an engine as it is, each once, in a fixed order."""
    wanted = {
        name: ledger.witnesses[engine, name]
        for entry in ledger.entries
        if entry.engine == engine and ledger.applies(entry)
        for name in entry.witnesses
    }
    return list(wanted.values())
