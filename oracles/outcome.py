"""What a campaign leaves: verdicts, buckets of findings, and the counts of everything that was asked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from hashlib import sha256
from typing import TYPE_CHECKING, NamedTuple

from oracles.accuracy import Accuracy, CellKey, Extreme, ExtremeKey
from oracles.scene import Scene
from refimpl.proof import Certificate, SweepCertificate
from refimpl.proof.impacts import ImpactCertificate

if TYPE_CHECKING:
    from oracles.crowds.judging import CrowdCount
    from oracles.fault import Fault
    from oracles.sheets import Sheet
    from oracles.surveys.judging import SurveyCount


ID_DIGITS = 12
"""Hexadecimal digits of a bucket's id."""


class Kind(StrEnum):
    """The judge's word on one answer."""

    AGREES = "agrees"
    CONVENTION = "convention"
    """Right on the shape that the engine effectively uses, or by a documented convention."""
    WRONG = "wrong"
    INCONSISTENT = "inconsistent"
    """Two answers of the engine contradict each other; the second is to a scene made from the first."""
    CRASHED = "crashed"
    """The engine's process ended, or the engine raised an error."""
    TIMED_OUT = "timed out"
    UNSUPPORTED = "unsupported"
    UNDECIDED = "undecided"
    """The proven interval allows both."""
    SKIPPED = "skipped"
    """Not asked: the engine had run out of time on too many scenes of this cell and regime."""
    REFERENCE_WRONG = "reference wrong"
    """A certificate of ours failed, or excludes our own answer: the run stops."""


ANSWERED = (Kind.AGREES, Kind.CONVENTION, Kind.WRONG, Kind.UNDECIDED)
FINDINGS = (Kind.WRONG, Kind.INCONSISTENT, Kind.CRASHED, Kind.TIMED_OUT, Kind.REFERENCE_WRONG)
SUSPECT = (Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT)
"""What a screening may say of an answer that is then weighed alone."""
COMPARED = (
    Kind.AGREES,
    Kind.CONVENTION,
    Kind.WRONG,
    Kind.INCONSISTENT,
    Kind.UNDECIDED,
    Kind.CRASHED,
    Kind.TIMED_OUT,
    Kind.REFERENCE_WRONG,
)


class State(StrEnum):
    """What the ledger says of a bucket, and a run of an entry; first those that ask for something to be done."""

    NEW = "NEW"
    """A bucket that no entry explains."""
    CHANGED = "CHANGED"
    """A witness still fails, but beyond what its entry says."""
    STALE = "STALE"
    """An entry whose witnesses all pass now."""
    EXPECTED = "expected"
    UNMATCHED = "UNMATCHED"
    """An entry of which this run saw nothing."""


class Severity(StrEnum):
    """How wrong an answer is, the worst first; sizes are relative to the scene's."""

    BOOLEAN = "wrong boolean"
    LOST = "no answer"
    GROSS = "gross (over 10 % of the scene)"
    LARGE = "large (over 0.1 %)"
    SMALL = "small"


@dataclass(frozen=True)
class Verdict:
    """The judge's word on one answer, with what proves it.

    Attributes
    ----------
    kind, symptom, severity
        What is wrong, in the words of `oracles.judge`; symptom is empty when nothing is.
    amount
        Proven: the answer is wrong by at least this much (a length, of impacts a velocity; 0 when nothing is wrong).
    lower, upper
        Proven interval of what the certificate is about: the signed distance of the scene (a ray's or a sweep's time
        of the hit), or that of `proof_scene` where there is one; of an impact, by how much velocities would have to
        change to fulfil the law that is broken.
    claim
        One sentence: what the engine said, and what is true.
    certificate
        Proves the interval, or what it was that the answer violates; on `proof_scene`, where that is not the
        scene itself (a witness against its shape, a proxy moved along the engine's normal).
    """

    kind: Kind
    symptom: str = ""
    severity: Severity | None = None
    amount: float = 0.0
    lower: float = float("nan")
    upper: float = float("nan")
    claim: str = ""
    certificate: Certificate | ImpactCertificate | SweepCertificate | None = None
    proof_scene: Scene | None = None


@dataclass(frozen=True)
class Related:
    """The other scene of a relation that an engine broke, with its answer.

    Attributes
    ----------
    relation
        Name, as in `oracles.relations`.
    """

    relation: str
    scene: Scene
    answer: dict[str, object]


@dataclass(frozen=True)
class Finding:
    """A scene on which an engine failed, with its answer and the verdict.

    Attributes
    ----------
    answer
        What the engine said: field name to numbers, only what it said.
    reference
        What `refimpl` says, in the same form.
    related
        What contradicts the answer, where that is the finding.
    """

    engine: str
    scene: Scene
    answer: dict[str, object]
    reference: dict[str, object]
    verdict: Verdict
    text: str = ""
    """The engine's error text or exit signal, where there is one."""
    repeats: bool = True
    """Whether the engine fails again when asked again; found out when the finding is shrunk."""
    related: Related | None = None


@dataclass
class Bucket:
    """Findings with one cause, as far as the key can tell."""

    engine: str
    query: str
    pair: str
    symptom: str
    degeneracy: str
    """What is special about the geometry of the witness: see `oracles.degeneracy`."""
    decade: int | None
    """Decade of the error relative to the scene's size; None for answers that are wrong without an amount."""
    witness: Finding
    count: int = 0
    proven: int = 0
    """How many of the `count` findings have been proven one by one with a certificate."""
    worst: float = 0.0
    regimes: Counter[str] = field(default_factory=Counter)
    entry: str | None = None
    """Name of the entry of the ledger that explains it; None when it is new."""
    state: State = State.NEW
    cause: str = ""
    """What the entry says."""
    call: str = ""
    """The calls of the engine alone, as its users would write them; they print its answer."""
    repro: str = ""
    """A stand-alone script that asks the engine, carries the proof, checks it and judges the answer."""

    @property
    def key(self) -> str:
        """Readable, stable name: engine, query, pair, symptom, degeneracy, decade."""
        parts = [self.engine, self.query, self.pair, self.symptom, self.degeneracy]
        if self.decade is not None:
            parts.append(f"1e{self.decade:+d}")
        return " · ".join(parts)

    @property
    def id(self) -> str:
        """Short name by which runs and reports refer to it: the first digits of the key's SHA-256."""
        return sha256(self.key.encode("utf-8", "surrogatepass")).hexdigest()[:ID_DIGITS]

    @property
    def against_reference(self) -> bool:
        """Whether it speaks against `refimpl` itself."""
        return self.witness.verdict.kind is Kind.REFERENCE_WRONG


@dataclass(frozen=True)
class EntryNote:
    """What a run makes of one entry of the ledger."""

    engine: str
    name: str
    cause: str
    state: State
    why: str
    """Why it has this state, where that needs words."""
    seen: int
    """How many findings of this run it explains."""
    witnesses: int
    holding: tuple[str, ...]
    """Those of its witnesses that still fail as it says."""
    upstream: tuple[str, ...] = ()
    file: str = ""
    versions: str = ""
    """Versions of the engine that have the fault, as in PEP 440."""
    first_seen: str = ""
    """When it was first recorded, and in which version of the engine."""
    cells: tuple[tuple[str, str], ...] = ()
    """(query, pair) of the cells that it is about, where its state asks for something to be done."""


BucketKey = tuple[str, str, str, str, str, int | None]
"""engine, query, pair, symptom, degeneracy, decade"""

CountKey = tuple[str, str, str, str, Kind]
"""engine, query, pair, regime, verdict"""

RelationKey = tuple[str, str, str, Kind]
"""engine, relation, query, verdict on the two answers"""


CountedKey = tuple[str, str, str, str, int | None, str]
"""engine, query, pair, symptom, decade, regime"""


class Met(NamedTuple):
    """What became of a witness of the ledger that is no scene, when the engine was asked again."""

    witness: str
    """Its id."""
    kind: Kind
    fault: Fault | None
    """Where it fails still."""


@dataclass
class Outcome:
    """What a task brings home.

    Attributes
    ----------
    findings
        Proven one by one.
    counted
        Findings of the float screening, beyond doubt but not proven one by one: how many, and the worst amount.
        They belong to the bucket of the proven ones that they are most like.
    incidents
        What happened to the engines' processes though nothing was lost, in sentences, and how often.
    lacking
        Forms that the library of models does not have.
    extremes
        The worst errors of each cell, as floats have them.
    certified
        Of extremes, the errors that are proven; not part of a record.
    efforts
        Of each cell, how many scenes were asked to the end, and the engine's processor seconds for them.
    digest
        Of every answer, to the bit.
    """

    counts: Counter[CountKey] = field(default_factory=Counter)
    findings: list[Finding] = field(default_factory=list)
    counted: dict[CountedKey, tuple[int, float]] = field(default_factory=dict)
    relations: Counter[RelationKey] = field(default_factory=Counter)
    hunters: Counter[str] = field(default_factory=Counter)
    timing: dict[str, float] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    incidents: Counter[str] = field(default_factory=Counter)
    lacking: set[str] = field(default_factory=set)
    extremes: dict[ExtremeKey, Extreme] = field(default_factory=dict)
    certified: dict[ExtremeKey, float] = field(default_factory=dict)
    efforts: dict[CellKey, tuple[int, float]] = field(default_factory=dict)
    digest: str = ""
    crowds: list[CrowdCount] = field(default_factory=list)
    """What became of crowds before an engine's broad phase; not part of a record."""
    surveys: list[SurveyCount] = field(default_factory=list)
    """What became of the questions of a survey; not part of a record."""
    met: list[Met] = field(default_factory=list)
    """What became of the ledger's witnesses of surveys and crowds; not part of a record."""
    sheets: list[Sheet] = field(default_factory=list)
    """Each answer; no longer there once it is in the record."""

    def count(self, key: CountedKey, amount: float) -> None:
        """Add one finding that is not proven."""
        number, worst = self.counted.get(key, (0, 0.0))
        self.counted[key] = number + 1, max(worst, amount)

    def spend(self, efforts: Mapping[CellKey, tuple[int, float]]) -> None:
        """Add what engines took for some scenes."""
        for cell, (asked, seconds) in efforts.items():
            number, spent = self.efforts.get(cell, (0, 0.0))
            self.efforts[cell] = number + asked, spent + seconds


@dataclass(frozen=True)
class SupportNote:
    """Whether an engine answers a cell ("native", "emulated", "unsupported"), and how or why not."""

    kind: str
    reason: str


@dataclass
class Run:
    """One campaign, as the reports need it."""

    seed: int
    budget: float
    started: str
    """UTC, ISO 8601."""
    seconds: float = 0.0
    versions: dict[str, str] = field(default_factory=dict)
    engine_versions: dict[str, str] = field(default_factory=dict)
    """Of each engine, the version that the ledger goes by: the first that its adapter names."""
    engines: list[str] = field(default_factory=list)
    regimes: dict[str, str] = field(default_factory=dict)
    """Name of each regime, and why it exists."""
    counts: Counter[CountKey] = field(default_factory=Counter)
    support: dict[tuple[str, str, str], SupportNote] = field(default_factory=dict)
    """(engine, query, pair) to note, for every cell."""
    buckets: list[Bucket] = field(default_factory=list)
    """Worst severity first."""
    relations: Counter[RelationKey] = field(default_factory=Counter)
    """Pairs of scenes of which one was made from the other."""
    ledger: list[EntryNote] = field(default_factory=list)
    """The entries of the ledger for these engines."""
    hunters: Counter[str] = field(default_factory=Counter)
    """Scenes that each hunter has put before an engine: "replay", "bulk" and "hypothesis"."""
    timing: dict[str, float] = field(default_factory=dict)
    """Seconds spent on scenes, each engine, the reference, judge, proofs, hunts, store: of all workers together."""
    accuracy: Accuracy = field(default_factory=Accuracy)
    crowds: list[CrowdCount] = field(default_factory=list)
    """What became of crowds before the engines' broad phases, by engine and regime."""
    surveys: list[SurveyCount] = field(default_factory=list)
    """What became of surveys, by subject, engine, question and regime."""
    passes: int | None = None
    """So many passes over all cells were asked for, in place of the budget."""
    interrupted: bool = False
    digest: str = ""
    """Of every answer, to the bit: the same for the same work, whatever has done it."""
    recalled: int = 0
    """Tasks whose outcomes come from the record of an earlier run."""
    models: list[str] = field(default_factory=list)
    """Where the regime `models` took its geometry from, and then each file that could not be used, with the reason."""
    problems: list[str] = field(default_factory=list)
    """Sentences on whatever makes this run incomplete: supported cells with nothing compared, lost workers."""
    incidents: Counter[str] = field(default_factory=Counter)
    """Sentences on what happened to the engines' processes though nothing was lost by it, and how often."""

    def total(
        self,
        *,
        engine: str | None = None,
        query: str | None = None,
        pair: str | None = None,
        regime: str | None = None,
        kinds: tuple[Kind, ...] | None = None,
    ) -> int:
        """Sum of the counts that fit; None fits all."""
        wanted = (engine, query, pair, regime)
        return sum(
            n
            for key, n in self.counts.items()
            if all(w is None or w == k for w, k in zip(wanted, key[:4], strict=True))
            and (kinds is None or key[4] in kinds)
        )

    @property
    def reference_wrong(self) -> bool:
        """Whether a proof spoke against `refimpl` itself."""
        return any(x.against_reference for x in self.buckets) or any(x.against_reference for x in self.surveys)

    @property
    def unsettled(self) -> Counter[State]:
        """How many buckets are new, and how many entries stale or changed: none in a run that is as expected."""
        found = Counter(note.state for note in self.ledger if note.state in (State.STALE, State.CHANGED))
        new = sum(bucket.state is State.NEW for bucket in self.buckets)
        return found + Counter({State.NEW: new})
