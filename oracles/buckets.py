"""Buckets: findings with one cause, gathered by a key, each shown by its simplest proven scene.

Findings are first gathered as they come in, by what is special about their own scenes and by the decade of the error.
The simplest of each such pile is shrunk, and the piles whose witnesses then have the same key are one bucket.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from oracles.clumsiness import clumsiness
from oracles.degeneracy import degeneracy
from oracles.ledger.files import Ledger
from oracles.likeness import come_together
from oracles.outcome import Bucket, BucketKey, CountedKey, Finding, Kind, Severity
from oracles.words import decade_of

NOT_REPEATABLE = "not repeatable"
"""Stands for the geometry of findings that do not come again: it is not what they depend on."""

_GRAVITY = {severity: rank for rank, severity in enumerate(Severity)}


def key_of(finding: Finding) -> BucketKey:
    """What findings with one cause have in common."""
    scene, verdict = finding.scene, finding.verdict
    cell = finding.engine, scene.query, scene.cell.pair, verdict.symptom
    if not finding.repeats:
        return *cell, NOT_REPEATABLE, None
    return *cell, degeneracy(scene), decade_of(verdict.amount, scene.size)


@dataclass
class Buckets:
    """All findings of a run, filed one task at a time; the order makes no difference.

    Attributes
    ----------
    piles
        Proven findings with the same key, before any is shrunk; as buckets, each with its simplest finding.
    ends
        What the witness of a pile has been shrunk to.
    counted
        Findings that are beyond doubt, but not proven one by one: how many, and the worst amount.
    """

    ledger: Ledger
    piles: dict[BucketKey, Bucket] = field(default_factory=dict)
    ends: dict[BucketKey, Finding] = field(default_factory=dict)
    counted: dict[CountedKey, tuple[int, float]] = field(default_factory=dict)

    def add_proven(self, finding: Finding) -> Bucket:
        """File a proven finding, and make it the witness of its pile when it is the simplest so far.

        One that no entry of the ledger explains comes before all that are expected, so that none hides among them.
        """
        key, entry = key_of(finding), self._entry(finding)
        pile = self.piles.get(key)
        if pile is None:
            pile = self.piles[key] = Bucket(*key, witness=finding, entry=entry)
        elif (entry is not None, *_rank(finding)) < (pile.entry is not None, *_rank(pile.witness)):
            pile.witness, pile.entry = finding, entry
        pile.proven += 1
        _count(pile, finding.scene.regime, finding.verdict.amount, 1)
        return pile

    def add_counted(self, key: CountedKey, number: int, worst: float) -> None:
        """Count findings of the float screening: to the bucket that those most like them have been proven in."""
        before, worst_before = self.counted.get(key, (0, 0.0))
        self.counted[key] = before + number, max(worst, worst_before)

    def to_shrink(self) -> list[tuple[Finding, ...]]:
        """Witnesses that are yet to be shrunk: those of one engine, cell and symptom together, the simplest first.

        Groups with something new come first; the ledger's own witnesses stay as they are.
        """
        groups: dict[tuple[str, ...], list[Finding]] = {}
        for key in sorted(self.piles, key=lambda key: (self.piles[key].entry is not None, str(key))):
            witness = self.piles[key].witness
            listed = (witness.engine, witness.scene.id) in self.ledger.witnesses
            if key not in self.ends and not listed and witness.verdict.kind is not Kind.REFERENCE_WRONG:
                groups.setdefault(key[:4], []).append(witness)
        return [tuple(sorted(group, key=_rank)) for group in groups.values()]

    def new_to_shrink(self) -> int:
        """How many groups of `to_shrink` have something new."""
        return sum(any(self._entry(finding) is None for finding in group) for group in self.to_shrink())

    def rekey(self, findings: Iterable[Finding], shrunk: Iterable[Finding]) -> None:
        """Take note of what findings of `to_shrink` have been shrunk to."""
        self.ends.update((key_of(old), new) for old, new in zip(findings, shrunk, strict=True))

    def sorted(self) -> list[Bucket]:
        """Piles whose witnesses have been shrunk to scenes of one key, or of which one may be the other's, as one.

        A bucket is expected when the ledger explains all of its piles, by what was found or by what it was shrunk to.
        Reference faults come first, then new before known, graver before lighter, more frequent before rarer.
        """
        merged: dict[BucketKey, Bucket] = {}
        ends = self._ends()
        for pile in self._with_counted():
            end = ends[_key_of_pile(pile)]
            key, entry = key_of(end), self._entry(end) or pile.entry
            bucket = merged.get(key)
            if bucket is None:
                bucket = merged[key] = Bucket(*key, witness=end, entry=entry)
            elif (entry is not None, *_rank(end)) < (bucket.entry is not None, *_rank(bucket.witness)):
                bucket.witness, bucket.entry = end, entry
            bucket.proven += pile.proven
            for regime, number in pile.regimes.items():
                _count(bucket, regime, pile.worst, number)
        return sorted(merged.values(), key=_order)

    def _entry(self, finding: Finding) -> str | None:
        """Name of the ledger's entry that explains a finding; None when it is new."""
        entry = self.ledger.match(finding.engine, finding.scene, finding.verdict)
        return entry.name if entry else None

    def _ends(self) -> dict[BucketKey, Finding]:
        """What the witness of each pile comes to: what it has been shrunk to, and from there the best that is like it.

        So piles come together also where there was no time to shrink; what is new only with what is new as well.
        """
        ends = {key: self.ends.get(key, pile.witness) for key, pile in sorted(self.piles.items(), key=str)}
        groups: dict[tuple[object, ...], list[BucketKey]] = {}
        for key, end in ends.items():
            if end.repeats and not end.related and end.verdict.kind is not Kind.REFERENCE_WRONG:
                same = *key_of(end)[:4], end.verdict.kind, self._entry(end)
                groups.setdefault(same, []).append(key)
        for keys in groups.values():
            ends.update(zip(keys, come_together([ends[key] for key in keys]), strict=True))
        return ends

    def _with_counted(self) -> list[Bucket]:
        """Copies of the piles, with what has been counted added to the nearest of the same cell and symptom.

        A proof may lessen an amount across a power of ten, so that the nearest decade has to do.
        """
        piles = {
            key: replace(pile, regimes=pile.regimes.copy())
            for key, pile in sorted(self.piles.items(), key=lambda x: str(x[0]))
        }
        for counted, (number, worst) in sorted(self.counted.items(), key=str):
            *cell, decade, regime = counted
            same = [key for key in piles if key[:4] == tuple(cell)]
            if same:

                def strangeness(key: BucketKey, decade: int | None = decade, regime: str = regime) -> tuple[int, bool]:
                    return abs((key[5] or 0) - (decade or 0)), regime not in self.piles[key].regimes

                _count(piles[min(same, key=strangeness)], regime, worst, number)
        return list(piles.values())


def _key_of_pile(pile: Bucket) -> BucketKey:
    return pile.engine, pile.query, pile.pair, pile.symptom, pile.degeneracy, pile.decade


def _rank(finding: Finding) -> tuple[object, ...]:
    """The simplest scene first; of equally simple ones always the same."""
    return *clumsiness(finding.scene), finding.scene.id, finding.scene.regime, finding.scene.source


def _count(bucket: Bucket, regime: str, amount: float, number: int) -> None:
    bucket.count += number
    bucket.worst = max(bucket.worst, amount)
    bucket.regimes[regime] += number


def _order(bucket: Bucket) -> tuple[object, ...]:
    verdict = bucket.witness.verdict
    gravity = _GRAVITY[verdict.severity] if verdict.severity else len(_GRAVITY)
    return (
        verdict.kind is not Kind.REFERENCE_WRONG,
        bucket.entry is not None,
        gravity,
        -bucket.count,
        bucket.key,
    )
