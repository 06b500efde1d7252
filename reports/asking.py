"""Asking an engine a finding's scene again: in its guarded process, judged as in a run."""

from __future__ import annotations

from dataclasses import dataclass

from oracles.adapters import require_sound
from oracles.answers import said
from oracles.bench import Bench
from oracles.engine import Answers
from oracles.ledger.replay import replay
from oracles.ledger.witness import Witness
from oracles.outcome import FINDINGS, Bucket, Kind
from oracles.scene import Scene


@dataclass(frozen=True)
class Again:
    """What came of asking again.

    Attributes
    ----------
    answer, error
        What the engine said, or its last words; both empty where a relation was asked, and held.
    claim
        What is wrong, where something is.
    """

    engine: str
    versions: dict[str, str]
    kind: Kind
    answer: dict[str, object]
    error: str
    claim: str

    @property
    def wrong(self) -> bool:
        """Whether it is proven wrong still."""
        return self.kind in FINDINGS


class _Attentive(Bench):
    """A bench that keeps what its engine said last."""

    last_answer: dict[str, object]
    last_error = ""

    def ask(self, scene: Scene) -> Answers:
        """Have one scene answered, and keep the answer."""
        answers = super().ask(scene)
        self.last_answer, self.last_error = said(answers, 0), answers.errors.get(0, "")
        return answers


def ask_again(bucket: Bucket, spec: str, call_limit: float) -> Again:
    """Have an engine answer a bucket's scene, or the two scenes whose answers contradicted each other.

    Raises
    ------
    EngineUnavailable
        When it cannot be started, or its adapter is not sound.
    """
    bench = _Attentive(spec, call_limit)
    bench.last_answer = {}
    try:
        require_sound(bench.engine)
        replayed = replay(Witness(bucket.witness, bucket.key, ""), bench)
    finally:
        bench.close()
    finding = replayed.finding
    answer, error = bench.last_answer, bench.last_error
    if finding is not None:
        answer, error = finding.answer, finding.text
    claim = "" if finding is None else finding.verdict.claim
    return Again(bench.name, bench.engine.versions(), replayed.kind, answer, error, claim)
