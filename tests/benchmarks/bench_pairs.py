"""Single cells under pytest-benchmark: ``pytest tests/benchmarks/bench_pairs.py -n 0``."""

from __future__ import annotations

from typing import Any

import pytest

from refimpl.pairs import TABLE
from tests.benchmarks import rates, scenes
from tests.conftest import name_of


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_one_pair_alone(pair: Any, benchmark: Any) -> None:
    a, b = scenes.batch_of(pair, 8)
    benchmark(rates.query_of(a), a[0], b[0])


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_a_batch_of_a_thousand(pair: Any, benchmark: Any) -> None:
    a, b = scenes.batch_of(pair, 1000)
    benchmark.pedantic(rates.query_of(a), (a, b), rounds=3, warmup_rounds=1)
