"""The whole way through, on engines that are right or wrong on purpose: each is found, and named rightly."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import oracles.audit
from oracles import bulk, claims
from oracles.buckets import Buckets
from oracles.campaign import run_campaign
from oracles.clumsiness import odd_numbers
from oracles.engine import Answers
from oracles.judge import CRASHED, RAISED, TIMED_OUT, Judge
from oracles.ledger import Entry, Ledger
from oracles.outcome import FINDINGS, Kind, Run, Severity, State, Verdict
from oracles.regimes import REGIMES
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST, Scene
from refimpl.proof import check
from tests.wrong_engines import (
    CrashingFarOut,
    FlippedNormal,
    HangingFarOut,
    Honest,
    LeavingFarOut,
    MissedContact,
    NotANumber,
    OffByAThousandth,
    RaisingFarOut,
    spec,
)

PAIRS = ["Sphere–Sphere", "Ray–Sphere"]
NOTHING = Ledger()


def campaign(engine: type[Honest], *, budget: float = 2.0, pairs: list[str] | None = None, **options: object) -> Run:
    options = {"call_limit": 0.3, "seed": 3, "ledger": NOTHING} | options
    return run_campaign([spec(engine)], budget=budget, pairs=pairs or PAIRS, **options)  # type: ignore[arg-type]


def symptoms(run: Run) -> set[tuple[str, str]]:
    return {(b.query, b.symptom) for b in run.buckets}


def test_a_right_engine_gives_no_finding_and_every_cell_is_compared() -> None:
    run = campaign(
        Honest, passes=2, examples=40, pairs=[*PAIRS, "Point–Sphere", "Sphere–AABB", "Point–AABB", "Sphere–Box"]
    )
    assert [(b.key, b.witness.verdict.claim) for b in run.buckets] == []
    assert (run.problems, run.passes) == ([], 2)
    assert run.total(engine="honest", kinds=(Kind.AGREES,)) > 3000
    assert run.total(engine="honest", kinds=FINDINGS) == 0
    for regime in REGIMES:
        assert run.total(engine="honest", regime=regime, query=RAYCAST, kinds=(Kind.AGREES,)) > 0
    assert run.support["honest", DISTANCE, "Sphere–Box"].kind == "unsupported"
    assert run.total(pair="Sphere–Box") == 0, "scenes were drawn that nobody answers"
    assert run.total(engine="refimpl", kinds=(Kind.AGREES,)) > 50
    assert {"scenes", "engine honest", "judge", "audit", "hunt"} <= set(run.timing)


WRONG = [
    (OffByAThousandth, {(DISTANCE, claims.LONG), (CONTACTS, claims.LONG), (RAYCAST, claims.RAY_LATE)}),
    (FlippedNormal, {(DISTANCE, claims.OVERSHOT), (CONTACTS, claims.STUCK), (RAYCAST, claims.TILTED)}),
    (MissedContact, {(BOOLEAN, claims.MISSED), (CONTACTS, claims.MISSED), (RAYCAST, claims.RAY_MISSED)}),
    (NotANumber, {(query, claims.NOT_A_NUMBER) for query in (DISTANCE, CONTACTS, BOOLEAN, RAYCAST)}),
    (CrashingFarOut, {(query, CRASHED) for query in (DISTANCE, CONTACTS, BOOLEAN, RAYCAST)}),
    (LeavingFarOut, {(query, CRASHED) for query in (DISTANCE, CONTACTS, BOOLEAN, RAYCAST)}),
    (RaisingFarOut, {(query, RAISED) for query in (DISTANCE, CONTACTS, BOOLEAN, RAYCAST)}),
    (HangingFarOut, {(query, TIMED_OUT) for query in (DISTANCE, CONTACTS, BOOLEAN, RAYCAST)}),
]


@pytest.mark.parametrize(("engine", "expected"), WRONG, ids=lambda x: x.__name__ if isinstance(x, type) else "")
def test_each_wrong_engine_is_found_and_named(engine: type[Honest], expected: set[tuple[str, str]]) -> None:
    run = campaign(engine, passes=1, **({"call_limit": 0.05} if engine is HangingFarOut else {}))
    found = symptoms(run)
    assert expected <= found
    also = {FlippedNormal: {claims.STUCK}, OffByAThousandth: {claims.RAY_OFF}}  # in another pose, or past a grazed ball
    words = {symptom for _, symptom in expected} | also.get(engine, set())
    assert {symptom for _, symptom in found} <= words, found
    assert run.problems == []
    for bucket in run.buckets:
        verdict, scene = bucket.witness.verdict, bucket.witness.scene
        assert bucket.count >= bucket.proven >= 1
        assert sum(bucket.regimes.values()) == bucket.count
        assert bucket.repro
        compile(bucket.repro, "repro", "exec")
        shown = verdict.proof_scene or scene
        lower, upper = check(verdict.certificate, shown.a, shown.b)
        assert verdict.lower <= lower <= upper <= verdict.upper


@pytest.mark.parametrize("proven", [True, False])
def test_what_is_counted_is_in_a_bucket_also_where_a_proof_names_it_otherwise(
    proven: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    convict, other = Judge.convict, "not what floats saw"

    def named_otherwise(self: Judge, scene: Scene, answers: Answers) -> Verdict:
        found = convict(self, scene, answers)
        if found.symptom != claims.LONG:
            return found
        return dataclasses.replace(found, symptom=other) if proven else Verdict(Kind.CONVENTION, claims.LONG)

    monkeypatch.setattr(Judge, "convict", named_otherwise)
    monkeypatch.setattr(bulk, "MOST", 40)
    run = campaign(OffByAThousandth, passes=1, examples=0, pairs=["Sphere–Sphere"])
    wrong = run.total(kinds=FINDINGS)
    assert sum(bucket.count for bucket in run.buckets) == wrong
    assert (wrong > 200) == proven, "what no proof speaks against was counted"
    assert (run.total(kinds=(Kind.CONVENTION,)) > 200) != proven
    assert claims.LONG not in {bucket.symptom for bucket in run.buckets}


def test_a_wrong_boolean_is_graver_than_a_wrong_number() -> None:
    run = campaign(MissedContact, passes=1, pairs=["Sphere–Sphere"])
    assert {b.witness.verdict.severity for b in run.buckets} == {Severity.BOOLEAN}
    run = campaign(OffByAThousandth, passes=1, pairs=["Sphere–Sphere"])
    assert Severity.BOOLEAN not in {b.witness.verdict.severity for b in run.buckets}
    amounts = [b.witness.verdict.amount for b in run.buckets if b.degeneracy == "generic"]
    assert amounts == pytest.approx([1e-3] * len(amounts), rel=1e-6)
    assert amounts


def test_the_amount_is_proven_and_no_larger_than_the_error() -> None:
    run = campaign(OffByAThousandth, pairs=["Sphere–Sphere"], passes=2, examples=40)
    for bucket in run.buckets:
        verdict = bucket.witness.verdict
        size = max(1.0, bucket.witness.scene.size)
        assert verdict.amount <= 1e-3 + 1e-15 * size
        assert verdict.amount >= 1e-3 - 1e-14 * size
        answered = bucket.witness.answer["distance"]
        assert answered - verdict.upper == pytest.approx(1e-3, abs=1e-14 * size)  # type: ignore[operator]


def test_witnesses_are_the_simplest_found() -> None:
    run = campaign(OffByAThousandth, pairs=["Sphere–Sphere"], passes=2)
    assert {odd_numbers(bucket.witness.scene) for bucket in run.buckets} == {0}


def test_a_wrong_reference_stops_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    true = oracles.audit.distance

    def off(a: object, b: object) -> object:
        found = true(a, b)  # type: ignore[arg-type]
        return type(found)(found.distance + 1e-9, found.on_a, found.on_b, found.normal)

    monkeypatch.setattr(oracles.audit, "distance", off)
    run = campaign(Honest, budget=30.0)
    assert run.reference_wrong
    assert run.seconds < 20
    assert run.buckets[0].engine == "refimpl"
    assert run.buckets[0].entry is None
    assert len(run.problems) == 1
    assert "the reference was proven wrong" in run.problems[0]


def test_the_reference_can_never_be_listed() -> None:
    found = Buckets(Ledger((Entry("refimpl", "never", "never"), Entry("*", "nor", "so"))))
    run = campaign(OffByAThousandth, pairs=["Sphere–Sphere"], budget=0.5)
    finding = run.buckets[0].witness
    wrong = type(finding.verdict)(Kind.REFERENCE_WRONG, "reference outside its proof", Severity.GROSS, math.inf)
    bucket = found.add_proven(type(finding)("refimpl", finding.scene, {}, {}, wrong))
    assert bucket.entry is None


def test_entries_explain_findings_only_as_far_as_they_go() -> None:
    wide = Entry(
        "honest",
        "off",
        "Off on purpose.",
        query=("distance", "contacts"),
        pair=("Sphere–*",),
        symptom=("distance too *",),
    )
    run = campaign(OffByAThousandth, passes=1, ledger=Ledger((wide,)))
    by_query = {b.query: (b.entry, b.state, b.cause) for b in run.buckets}
    assert by_query[DISTANCE] == by_query[CONTACTS] == ("off", State.EXPECTED, "Off on purpose.")
    assert by_query[RAYCAST] == (None, State.NEW, "")
    narrow = Ledger((dataclasses.replace(wide, at_most=1e-9),))
    found = campaign(OffByAThousandth, passes=1, ledger=narrow, pairs=PAIRS[:1]).buckets
    assert {b.entry for b in found} == {None}, "what explains a part of a bucket does not explain it"
    elsewhere = Ledger((dataclasses.replace(wide, decades=(-300, -30)),))
    assert {b.entry for b in campaign(OffByAThousandth, passes=1, ledger=elsewhere, pairs=PAIRS[:1]).buckets} == {None}


def test_the_same_seed_brings_the_same_scenes_and_verdicts() -> None:
    first, second = (campaign(OffByAThousandth, budget=1e-9, pairs=["Sphere–Sphere"]) for _ in range(2))
    assert first.counts == second.counts
    assert [b.key for b in first.buckets] == [b.key for b in second.buckets]
    assert [b.witness.scene.id for b in first.buckets] == [b.witness.scene.id for b in second.buckets]


def test_an_interrupt_ends_with_what_was_found() -> None:
    class Impatient:
        def started(self, engines: object, cells: int) -> None:
            assert cells == 4, "those that it answers"

        def advanced(self, run: Run, elapsed: float) -> None:
            if elapsed > 1:
                raise KeyboardInterrupt

    run = campaign(OffByAThousandth, budget=60.0, listener=Impatient())
    assert run.interrupted
    assert run.seconds < 20
    assert run.buckets
    assert all(b.repro for b in run.buckets)


def test_seeds_are_whole_numbers_that_matter() -> None:
    one, two = (campaign(OffByAThousandth, budget=1e-9, seed=s, pairs=["Sphere–Sphere"]) for s in (1, 2))
    assert one.digest != two.digest
    assert np.isfinite([b.worst for b in one.buckets]).all()
