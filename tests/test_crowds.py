"""Crowds: the pipeline and PyBullet name the same pairs, and a pair that either of them loses is caught."""

from __future__ import annotations

import dataclasses
from collections import Counter

import numpy as np
import pytest

from oracles.crowds.making import KINDS, Crowd, thrown
from oracles.crowds.touching import Compared, compared
from oracles.engines.bullet_crowd import BulletCrowd
from refimpl import Box, Sphere, certify
from refimpl.bounds import aabb
from refimpl.volumes import is_endless
from reports.cli import main
from tests.test_world import LowerCellOnly

pytest.importorskip("pybullet")

COUNT = 40
NEAR_0 = 1e-8
"""Effective distances that Bullet may read as a gap or as an overlap."""


@pytest.fixture(scope="module")
def crowd() -> Crowd:
    return thrown(COUNT, seed=11)


@pytest.fixture(scope="module")
def found(crowd: Crowd) -> Compared:
    return compared(crowd)


def test_a_crowd_has_every_type_static_bodies_and_close_pairs(crowd: Crowd) -> None:
    types = Counter(type(proxy).__name__ for proxy in crowd.proxies)
    assert set(types) == {*KINDS, "HalfSpace"}
    assert 1 <= crowd.static.sum() < 20
    assert [proxy.pack().tolist() for proxy in thrown(COUNT, seed=11).proxies] == [
        p.pack().tolist() for p in crowd.proxies
    ]


def test_the_pipeline_and_bullet_touch_the_same_pairs(found: Compared) -> None:
    assert found.far_named == ()
    assert found.wrong == []
    decided = Counter(one.decided for one in found.close)
    assert decided[True] > 15
    assert decided[False] > 15
    for one in found.in_between:
        assert one.decided is None
        assert one.engine == (one.effective <= 0) or abs(one.effective) < NEAR_0, "the margins do not explain it"


def test_every_pair_is_accounted_for(crowd: Crowd, found: Compared) -> None:
    count, static = len(crowd), int(crowd.static.sum())
    assert found.far + len(found.close) == count * (count - 1) // 2 - static * (static - 1) // 2
    boxes = {n: aabb(proxy) for n, proxy in enumerate(crowd.proxies) if not is_endless(proxy)}
    close = {one.pair for one in found.close}
    for i, a in boxes.items():
        for j, b in boxes.items():
            if i < j and not (crowd.static[i] and crowd.static[j]) and (i, j) not in close:
                assert np.max(np.maximum(a.lower - b.upper, b.lower - a.upper)) > 9e-3


def test_a_broad_phase_that_loses_pairs_is_found_out() -> None:
    wrong = compared(thrown(16, seed=11), LowerCellOnly()).wrong
    assert wrong
    assert all(one.reference_wrong and not one.reference and one.upper < 0 for one in wrong)
    assert not any(one.engine_wrong for one in wrong)


def test_a_pair_that_bullet_loses_or_invents_is_found_out(crowd: Crowd, monkeypatch: pytest.MonkeyPatch) -> None:
    honest = BulletCrowd.touching
    apart = (0, 1)

    def dishonest(self: BulletCrowd) -> dict[tuple[int, int], float]:
        pairs = honest(self)
        return {pair: pairs[pair] for pair in sorted(pairs)[1:]} | {apart: -0.1}

    small = Crowd(
        (Sphere([0, 0, 0], 1), Sphere([9, 0, 0], 1), Box([0, 0, 1.5], [1, 1, 1], [0, 0, 0, 1])), np.zeros(3, bool)
    )
    assert compared(small).wrong == []
    monkeypatch.setattr(BulletCrowd, "touching", dishonest)
    found = compared(small)
    assert [one.pair for one in found.wrong] == [(0, 2)]
    assert found.wrong[0].engine_wrong
    assert found.far_named == (apart,)


def test_the_command_prints_tables_and_tells_wrong_by_its_status(
    found: Compared, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = [found, dataclasses.replace(found, far_named=((0, 1),))]
    monkeypatch.setattr("oracles.crowds.touching.compared", lambda crowd: answers[len(crowd) - 2])
    assert main(["touching", "--bodies", "2"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith(f"# {COUNT} bodies, 0 pairs wrong or missed")
    assert f" {found.far + sum(one.decided is False for one in found.close)} |" in shown
    assert all(one.types in shown for one in found.in_between)
    assert main(["touching", "--bodies", "3"]) == 1
    assert "1 pair wrong or missed" in capsys.readouterr().out


def test_proofs_are_of_the_proxies_as_they_were_given(crowd: Crowd, found: Compared) -> None:
    one = next(one for one in found.close if one.decided)
    a, b = (crowd.proxies[number] for number in one.pair)
    proof = certify(a, b)
    assert (proof.lower, proof.upper) == (one.lower, one.upper)
