"""Buckets: findings with one cause, gathered by a key, each shown by its simplest proven scene."""

from __future__ import annotations

from dataclasses import dataclass, field

from oracles.known import KnownFaults
from oracles.outcome import Bucket, CountedKey, Finding, Kind, Severity, Verdict
from oracles.scene import Scene
from oracles.words import decade_of

KEY = tuple[str, str, str, str, int | None, str | None]

_GRAVITY = {severity: rank for rank, severity in enumerate(Severity)}


def clumsiness_of_scene(scene: Scene) -> int:
    """How hard a scene is to take in: characters to read, zeros and ones counting least."""
    numbers = [x for row in scene.rows for x in row.tolist()]
    return sum(0 if x in (0.0, 1.0) else len(f"{x:.17g}") for x in numbers)


@dataclass
class Buckets:
    """All buckets of a run, filled one task at a time.

    A bucket is proven on a few of its findings and the rest is counted; the report names both numbers.
    """

    known: KnownFaults
    found: dict[KEY, Bucket] = field(default_factory=dict)

    def add_proven(self, finding: Finding) -> Bucket:
        """File a proven finding, and make it the bucket's witness when it is the simplest so far."""
        verdict, scene = finding.verdict, finding.scene
        key = self._key(finding.engine, scene, verdict)
        bucket = self.found.get(key)
        if bucket is None:
            bucket = self.found[key] = Bucket(*key[:5], witness=finding, known=key[5])
        elif clumsiness_of_scene(scene) < clumsiness_of_scene(bucket.witness.scene):
            bucket.witness = finding
        bucket.proven += 1
        self._count(bucket, scene.regime, verdict.amount)
        return bucket

    def add_counted(self, key: CountedKey, number: int, worst: float) -> None:
        """Count findings of the float screening to the bucket that others have been proven in.

        A proof may lessen an amount across a power of ten, so that the nearest decade has to do.
        """
        *wanted, decade, regime = key
        same = [bucket for bucket in self.found if bucket[:4] == tuple(wanted)]
        if same:
            nearest = min(same, key=lambda bucket: abs((bucket[4] or 0) - (decade or 0)))
            self._count(self.found[nearest], regime, worst, number)

    def _key(self, engine: str, scene: Scene, verdict: Verdict) -> KEY:
        """What findings with one cause have in common; whether and why they are known is part of it."""
        decade = decade_of(verdict.amount, scene.size)
        reason = self.known.reason(engine, scene, verdict)
        return engine, scene.query, scene.cell.pair, verdict.symptom, decade, reason

    @staticmethod
    def _count(bucket: Bucket, regime: str, amount: float, number: int = 1) -> None:
        bucket.count += number
        bucket.worst = max(bucket.worst, amount)
        bucket.regimes[regime] += number

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
