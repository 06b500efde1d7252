"""Buckets: findings with one cause, gathered by a key, each shown by its simplest proven scene."""

from __future__ import annotations

from dataclasses import dataclass, field

from oracles.known import KnownFaults
from oracles.outcome import Bucket, Finding, Kind, Severity
from oracles.scene import Scene
from oracles.words import decade_of

KEY = tuple[str, str, str, str, int | None]

_GRAVITY = {severity: rank for rank, severity in enumerate(Severity)}


def clumsiness_of_scene(scene: Scene) -> int:
    """How hard a scene is to take in: characters to read, zeros and ones counting least."""
    numbers = [*scene.a.pack().tolist(), *scene.b.pack().tolist()]
    return sum(0 if x in (0.0, 1.0) else len(f"{x:.17g}") for x in numbers)


@dataclass
class Buckets:
    """All buckets of a run, filled one batch at a time.

    Proofs cost milliseconds, so a bucket is proven on a few of its findings in each regime and the rest is counted;
    the report names both numbers.
    """

    known: KnownFaults
    proofs_per_regime: int = 3
    found: dict[KEY, Bucket] = field(default_factory=dict)
    _tried: dict[tuple[object, ...], int] = field(default_factory=dict)

    def wants_proof(self, engine: str, query: str, pair: str, symptom: str, decade: int | None, regime: str) -> bool:
        """Whether another finding of this kind is worth a proof; counts the answer yes."""
        key = (engine, query, pair, symptom, decade, regime)
        tried = self._tried.get(key, 0)
        self._tried[key] = tried + 1
        return tried < self.proofs_per_regime

    def add_proven(self, finding: Finding) -> Bucket:
        """File a proven finding, and make it the bucket's witness when it is the simplest so far."""
        verdict, scene = finding.verdict, finding.scene
        decade = decade_of(verdict.amount, scene.size)
        key = (finding.engine, scene.query, scene.cell.pair, verdict.symptom, decade)
        bucket = self.found.get(key)
        if bucket is None:
            bucket = Bucket(*key, witness=finding)
            bucket.known = self.known.reason(finding.engine, scene, verdict)
            self.found[key] = bucket
        elif clumsiness_of_scene(scene) < clumsiness_of_scene(bucket.witness.scene):
            bucket.witness = finding
        bucket.proven += 1
        bucket.worst = max(bucket.worst, verdict.amount)
        self._count(bucket, scene.regime)
        return bucket

    def add_counted(
        self, engine: str, query: str, pair: str, symptom: str, decade: int | None, regime: str, amount: float
    ) -> None:
        """Count a finding of the float screening whose bucket has been proven on others."""
        bucket = self.found.get((engine, query, pair, symptom, decade)) or self._nearest(
            engine, query, pair, symptom, decade
        )
        if bucket is not None:
            bucket.worst = max(bucket.worst, amount)
            self._count(bucket, regime)

    def _nearest(self, engine: str, query: str, pair: str, symptom: str, decade: int | None) -> Bucket | None:
        """Bucket of the same symptom in the nearest decade: a proof may lessen an amount across a power of ten."""
        same = [b for k, b in self.found.items() if k[:4] == (engine, query, pair, symptom)]
        return min(same, key=lambda b: abs((b.decade or 0) - (decade or 0)), default=None)

    @staticmethod
    def _count(bucket: Bucket, regime: str) -> None:
        bucket.count += 1
        bucket.regimes[regime] += 1

    def sorted(self) -> list[Bucket]:
        """Reference faults first, then new before known, graver before lighter, more frequent before rarer."""

        def rank(bucket: Bucket) -> tuple[object, ...]:
            verdict = bucket.witness.verdict
            gravity = _GRAVITY[verdict.severity] if verdict.severity else len(_GRAVITY)
            return (
                verdict.kind is not Kind.REFERENCE_WRONG,
                bucket.known is not None,
                gravity,
                -bucket.count,
                bucket.key,
            )

        return sorted(self.found.values(), key=rank)
