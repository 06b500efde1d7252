"""Replaying a witness: the engine is asked the same scene again, and judged anew."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from oracles.engine import Answers
from oracles.fault import Fault
from oracles.judges import finding_of
from oracles.ledger.entry import Entry, fault_in
from oracles.ledger.files import Ledger
from oracles.ledger.witness import AnyWitness, Witness
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
    """A witness, the verdict on what the engine says now, and the finding where that is one; of no scene the fault."""

    witness: AnyWitness
    kind: Kind
    finding: Finding | None
    other: Fault | None = None

    @property
    def fault(self) -> Fault | None:
        """What the ledger goes by, where the engine fails still."""
        found = self.finding
        return self.other if found is None else fault_in(found.engine, found.scene, found.verdict)


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
    fault = replayed.fault
    if fault is None:
        return Fate.PASSES
    return Fate.FAILS if entry.explains(fault) else Fate.CHANGED


def to_replay(ledger: Ledger, engine: str) -> list[AnyWitness]:
    """Witnesses of the entries that are about an engine as it is, each once, in a fixed order."""
    wanted = {
        name: ledger.witnesses[engine, name]
        for entry in ledger.entries
        if entry.engine == engine and ledger.applies(entry)
        for name in entry.witnesses
    }
    return list(wanted.values())
