"""Replaying a witness: the engine is asked the same scene again, and judged anew."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from oracles.engine import Answers
from oracles.judges import finding_of
from oracles.ledger.entry import Entry
from oracles.ledger.files import Ledger
from oracles.ledger.witness import Witness
from oracles.outcome import FINDINGS, Finding, Kind
from oracles.relations import Bench as Questioned
from oracles.relations import question
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


class Bench(Questioned, Protocol):
    """One engine, ready to answer a scene or a batch, and to be judged."""

    def ask(self, scene: Scene) -> Answers:
        """Have one scene answered."""


def replay(witness: Witness, bench: Bench) -> Replayed:
    """Have the engine asked, which may be lost by it, and judge what it says; where it contradicted itself, ask so."""
    scene, cell = witness.scene, witness.scene.cell
    if not bench.engine.support(cell.query, cell.type_a, cell.type_b):
        return Replayed(witness, Kind.UNSUPPORTED, None)
    if witness.finding.related is not None:
        finding = question(bench, witness.finding.related.relation, scene)
        return Replayed(witness, finding.verdict.kind if finding else Kind.AGREES, finding)
    answers = bench.ask(scene)
    verdict = bench.judges.convict(scene, answers)
    if verdict.kind not in FINDINGS:
        return Replayed(witness, verdict.kind, None)
    return Replayed(witness, verdict.kind, finding_of(witness.engine, scene, answers, verdict))


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
