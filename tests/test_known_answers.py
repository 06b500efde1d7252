"""Signed distances that are known by construction, without any solver: thousands of scenes for every pair."""

from __future__ import annotations

import numpy as np
import pytest

import refimpl
from refimpl import Ray
from refimpl.pairs import ITERATIVE, TABLE
from tests import truth
from tests.conftest import effort
from tests.tangents import BUILDERS, known_pair, scale_of

CONSTRUCTION = 2e-15
"""What the points, normals and sizes of a scene are rounded by when it is built, relative to the scene."""
ROWS = 256

PAIRS = [(a, b) for a in BUILDERS for b in BUILDERS if a != "Point"]  # a point holds no ball


def chunks(holder: str, other: str) -> int:
    """Batches of a pair: in the quick profile 23 000 scenes of all, in the others thousands of each."""
    return 1 if effort() <= 10 else 2 if "KDOP" in (holder, other) else 3


def promise(a: refimpl.Proxy, b: refimpl.Proxy) -> float:
    """Error that the pair's exactness class allows, relative to the scene."""
    pair = (type(a), type(b))
    rule = TABLE[pair if pair in TABLE else pair[::-1]]
    return 1e-12 if rule.exactness == ITERATIVE else 1e-14


def generator(*names: str) -> np.random.Generator:
    return np.random.default_rng([ord(c) for c in "-".join(names)])


@pytest.mark.parametrize(("holder", "other"), PAIRS)
def test_depths_and_gaps_of_tangent_shapes(holder: str, other: str) -> None:
    """δ from 1e-12 to 1, as depths, gaps and 0."""
    rng = generator("tangent", holder, other)
    for _ in range(chunks(holder, other) * (1 + effort() // 40)):
        signed = 10.0 ** rng.uniform(-12, 0, ROWS) * rng.choice([-1.0, -1.0, 1.0, 0.0], ROWS, p=[0.3, 0.3, 0.3, 0.1])
        a, b = known_pair(holder, other, signed, rng)
        error = np.abs(refimpl.distance(a, b).distance - signed) / scale_of(a, b, signed)
        worst = int(np.argmax(error))
        assert error[worst] <= promise(a, b) + CONSTRUCTION, (error[worst], signed[worst], a[worst], b[worst])
        clear = np.abs(signed) > (promise(a, b) + CONSTRUCTION) * scale_of(a, b, signed)
        assert np.array_equal(refimpl.intersect(a, b)[clear], signed[clear] < 0)


@pytest.mark.parametrize(("holder", "other"), PAIRS)
def test_two_millimetres_on_twenty_centimetres(holder: str, other: str) -> None:
    """Drake publishes its worst errors on such scenes: up to 2e-3 m, at best 1e-15 m; ours stay below 1e-14 m."""
    rng = generator("drake", holder, other)
    signed = 0.002 * rng.choice([-1.0, 1.0], ROWS)
    a, b = known_pair(holder, other, signed, rng, size=0.1)
    error = np.abs(refimpl.distance(a, b).distance - signed)
    worst = int(np.argmax(error))
    assert error[worst] < 1e-14, (error[worst], signed[worst], a[worst], b[worst])


def test_every_type_of_the_table_is_built() -> None:
    solids = {kind for pair in TABLE for kind in pair} - {Ray}
    assert {kind for kind, _ in BUILDERS.values()} >= {
        k for k in solids if k.__name__ not in ("Polyhedron", "Composite")
    }


@pytest.mark.parametrize(("holder", "other"), PAIRS)
def test_the_truth_knows_them_too(holder: str, other: str) -> None:
    """Construction and 50-digit arithmetic, which have nothing in common, agree to the rounding of the scene."""
    rng = generator("truth", holder, other)
    signed = 10.0 ** rng.uniform(-12, 0, 2) * rng.choice([-1.0, 1.0], 2)
    a, b = known_pair(holder, other, signed, rng)
    for i in range(2):
        error = abs(truth.signed_distance(a[i], b[i]) - signed[i])
        assert error <= CONSTRUCTION * scale_of(a, b, signed)[i], (float(error), a[i], b[i])
