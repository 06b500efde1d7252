"""Buckets: findings with one cause, gathered by a key, each shown by its simplest proven scene."""

from __future__ import annotations

from dataclasses import dataclass, field

from oracles.ledger.files import Ledger
from oracles.outcome import Bucket, Finding, Severity, Verdict
from oracles.reference import is_quick
from oracles.scene import IMPACT, Cell, Scene
from oracles.words import decade_of

KEY = tuple[str, str, str, str, int | None, str | None]

_GRAVITY = {severity: rank for rank, severity in enumerate(Severity)}


def clumsiness_of_scene(scene: Scene) -> int:
    """How hard a scene is to take in: characters to read, zeros and ones counting least."""
    numbers = [x for row in scene.rows for x in row.tolist()]
    return sum(0 if x in (0.0, 1.0) else len(f"{x:.17g}") for x in numbers)


@dataclass
class Buckets:
    """All buckets of a run, filled one batch at a time.

    Proofs cost milliseconds, so a bucket is proven on a few of its findings and the rest is counted; the report names
    both numbers. Those of impacts and of pairs that need a search cost a hundred times more, and each regime does not
    have its own.
    """

    ledger: Ledger
    proofs_per_regime: int = 3
    proofs_of_searched: int = 2
    found: dict[KEY, Bucket] = field(default_factory=dict)
    _tried: dict[tuple[object, ...], int] = field(default_factory=dict)

    def wants_proof(self, engine: str, cell: Cell, symptom: str, decade: int | None, regime: str) -> bool:
        """Whether another finding of this kind is worth a proof; counts the answer yes."""
        quick = is_quick(cell.type_a, cell.type_b) and cell.query != IMPACT
        key = (engine, cell, symptom, decade, regime if quick else "")
        tried = self._tried.get(key, 0)
        self._tried[key] = tried + 1
        return tried < (self.proofs_per_regime if quick else self.proofs_of_searched)

    def add_proven(self, finding: Finding) -> Bucket:
        """File a proven finding, and make it the bucket's witness when it is the simplest so far."""
        verdict, scene = finding.verdict, finding.scene
        key = self._key(finding.engine, scene, verdict)
        bucket = self.found.get(key)
        if bucket is None:
            bucket = self.found[key] = Bucket(*key[:5], witness=finding, entry=key[5])
        elif clumsiness_of_scene(scene) < clumsiness_of_scene(bucket.witness.scene):
            bucket.witness = finding
        bucket.proven += 1
        self._count(bucket, scene.regime, verdict.amount)
        return bucket

    def add_counted(self, engine: str, scene: Scene, verdict: Verdict) -> None:
        """Count a finding of the float screening to the bucket that others have been proven in.

        A proof may lessen an amount across a power of ten, so that the nearest decade has to do.
        """
        wanted = self._key(engine, scene, verdict)

        def strangeness(key: KEY) -> tuple[bool, int]:
            return key[5] != wanted[5], abs((key[4] or 0) - (wanted[4] or 0))

        same = [key for key in self.found if key[:4] == wanted[:4]]
        if same:
            self._count(self.found[min(same, key=strangeness)], scene.regime, verdict.amount)

    def _key(self, engine: str, scene: Scene, verdict: Verdict) -> KEY:
        """What findings with one cause have in common; the entry of the ledger that explains them is part of it."""
        decade = decade_of(verdict.amount, scene.size)
        entry = self.ledger.match(engine, scene, verdict)
        return engine, scene.query, scene.cell.pair, verdict.symptom, decade, entry.name if entry else None

    @staticmethod
    def _count(bucket: Bucket, regime: str, amount: float) -> None:
        bucket.count += 1
        bucket.worst = max(bucket.worst, amount)
        bucket.regimes[regime] += 1

    def sorted(self) -> list[Bucket]:
        """Reference faults first, then new before known, graver before lighter, more frequent before rarer."""

        def rank(bucket: Bucket) -> tuple[object, ...]:
            verdict = bucket.witness.verdict
            gravity = _GRAVITY[verdict.severity] if verdict.severity else len(_GRAVITY)
            return (
                not bucket.against_reference,
                bucket.entry is not None,
                gravity,
                -bucket.count,
                bucket.key,
            )

        return sorted(self.found.values(), key=rank)
