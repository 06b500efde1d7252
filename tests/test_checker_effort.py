"""Hostile certificates: whatever their numbers and sizes are, they are checked or refused soon."""

from __future__ import annotations

import time
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from refimpl.proof import (
    Certificate,
    Common,
    Core,
    Cover,
    Escape,
    Inscribed,
    InvalidCertificate,
    Near,
    Part,
    Piece,
    Separated,
    Split,
    certify,
    check,
    checker,
    rational,
)
from refimpl.shapes import Box, ConvexPolyhedron, Cylinder, Ellipsoid, Polyhedron, Proxy, Ray, Sphere
from tests import solids
from tests.benchmarks.proofs import SCENES, trusted_lines
from tests.test_checker import OF_IMPACTS, OF_PLANE, OF_SETS, OF_SWEEPS

SOON = 4.0
"""Seconds of this process: four times of what is meant by soon, for a slow machine."""
TURN = (1, 2, 3, 4)
EGG = Ellipsoid((0, 0, 0), (1, 2, 3), TURN)
CAN = Cylinder((0, 0, 0), (1, 2, 3), 0.5)
BOX = Box((0.1, 0.2, 0.3), (1, 2, 3), TURN)
RING = Polyhedron(*solids.torus(48, 10), (0.1, 0.2, 0.3), TURN)
BEAD = Sphere((0.1, 0.2, 0.3), 0.4)
GEM = ConvexPolyhedron(
    np.concatenate([solids.torus(20, 20)[0] / 1.4 + [[0.01, 0.02, 0.03]], -np.ones((400, 1))], axis=1)
)
RAY = Ray((0, 0, 0), (1, 2, 3))
ZERO = (0, 0, 0)
UNIT = ((Fraction(1, 9), 0, 0), (0, Fraction(1, 9), 0), (0, 0, Fraction(1, 9)))
NOTHING = (ZERO, ZERO, ZERO)
TETRAHEDRON = ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2))
CORNERS = ((0.1, 0.1, 0.1), (0.1, -0.1, -0.1), (-0.1, 0.1, -0.1), (-0.1, -0.1, 0.1))


def long_numbers(bits: int, count: int) -> list[Any]:
    """Vectors of rationals, all different."""
    rng = np.random.default_rng(bits)

    def one() -> Fraction:
        top, bottom = (int.from_bytes(rng.bytes(bits // 8), "big") | 1 for _ in range(2))
        return Fraction(top, bottom)

    return [(one(), one(), one()) for _ in range(count)]


def ring_claims() -> tuple[Any, ...]:
    return certify(RING, BEAD).claims


def piece() -> Part:
    """A ball in the tube of the ring, by a tree of planes."""
    found = certify(RING, Sphere((0.1, 0.2, 0.3), 3.0)).claims
    return next(claim for claim in found if isinstance(claim, Part))


MANY: dict[str, Callable[[], tuple[tuple[Any, ...], Proxy, Proxy]]] = {
    "directions": lambda: ((Escape((1, 2, 3)),), EGG, CAN),
    "points outside": lambda: ((Near((3.1, 3.2, 3.3), (3.1, 3.2, 3.3)),), EGG, CAN),
    "points of a box": lambda: ((Near((3.1, 3.2, 3.3), (3.1, 3.2, 3.3)),), BOX, BOX),
    "points behind planes": lambda: ((Near(ZERO, ZERO),), GEM, GEM),
    "ellipsoids": lambda: ((Inscribed(ZERO, UNIT, ZERO, NOTHING, 0.05, (0.5, 0.5, 0.5)),), EGG, EGG),
    "facets": lambda: ((Core(tuple((c, ZERO) for c in CORNERS), TETRAHEDRON * 500),), EGG, EGG),
    "pairs": lambda: ((Core(tuple((c, ZERO) for c in CORNERS) * 1000, TETRAHEDRON),), EGG, CAN),
    "trees": lambda: (ring_claims(), RING, BEAD),
    "pieces": lambda: ((piece(),), RING, Sphere((0.1, 0.2, 0.3), 3.0)),
    "hits": lambda: ((Common(None, 0.125),), RAY, EGG),
    "free rays": lambda: ((Separated((-1, -2, -3), 1),), Ray((9, 18, 27), (1, 2, 3)), RING),
}


@pytest.mark.parametrize("name", MANY)
def test_repeated_claims_are_refused_before_long(name: str) -> None:
    claims, a, b = MANY[name]()
    check(Certificate(claims), a, b)  # once, they hold
    began = time.process_time()
    with pytest.raises(InvalidCertificate, match="too much work"):
        check(Certificate(claims * (rational.MAX_ITEMS // len(claims))), a, b)
    assert time.process_time() - began < SOON


LONG: dict[str, Callable[[Any], tuple[Any, Proxy, Proxy]]] = {
    "near": lambda v: (Near(v, v), EGG, CAN),
    "near boxes": lambda v: (Near(v, v), BOX, BOX),
    "escape": lambda v: (Escape(v), EGG, BOX),
    "core": lambda v: (Core(((v, v[::-1]),) * 4, TETRAHEDRON), EGG, CAN),
    "inscribed": lambda v: (Inscribed(v, (v, v, v), v, (v, v, v), v[0], v), CAN, EGG),
    "cover": lambda v: (Cover(Separated((1, 2, 3)), v, ((), (v,))), RING, BEAD),
    "piece": lambda v: (Part((0, Piece((v, v[::-1], ZERO, (1, 0, 0)), Separated(v))), None, Near(v, v)), RING, BEAD),
    "hit": lambda v: (Common(None, v[0]), RAY, CAN),
    "free": lambda v: (Separated(v, abs(v[0])), RAY, RING),
    "weights": lambda v: (Near(tuple(enumerate(map(abs, v))), ZERO), ConvexPolyhedron.from_vertices(CORNERS), EGG),
}


@pytest.mark.parametrize("bits", [600, 2400, 8000, rational.MAX_BITS - 8])
@pytest.mark.parametrize("name", LONG)
def test_long_numbers_are_checked_or_refused_before_long(name: str, bits: int) -> None:
    vectors = long_numbers(bits, 8)
    claims, a, b = tuple(LONG[name](v)[0] for v in vectors), *LONG[name](vectors[0])[1:]
    began = time.process_time()
    for number in (1, 200):
        try:
            check(Certificate(claims * number), a, b)
        except InvalidCertificate:
            continue
    assert time.process_time() - began < SOON


def test_endless_trees_are_refused_before_long() -> None:
    leaf = Separated((1, 0, 0))
    chain: Any = leaf
    for _ in range(20_000):
        chain = Split(0, (), (leaf, chain))
    doubled: Any = leaf
    for _ in range(200):  # the same branches twice: two to the 200 leaves
        doubled = Split(1, (0,), (doubled, doubled))
    wide = Split(0, tuple(range(960)) * 60, (leaf, leaf))
    for _ in range(100):
        wide = Split(0, tuple(range(960)) * 60, (wide, leaf))
    for tree in (chain, doubled, wide):
        began = time.process_time()
        with pytest.raises(InvalidCertificate):
            check(Certificate((Cover(tree, places=((), (BEAD.reference_point.tolist(),))),)), RING, BEAD)
        assert time.process_time() - began < SOON


def test_the_limit_grows_with_the_shapes_and_leaves_honest_certificates_room() -> None:
    """The hardest proofs of the benchmark need less than half of what is allowed."""
    for name in ("tori linked", "balls that overlap deeply"):
        a, b = SCENES[name]()
        certificate = certify(a, b)
        with rational.effort(1 << 62) as spent:
            sides = checker.Union(checker.parts_of(a)), checker.Union(checker.parts_of(b))
            size = spent()
            for claim in certificate.claims:
                checker.bounds_of(claim, sides)
            used = spent() - size
        assert used < (checker.EFFORT + checker.EFFORT_PER_ITEM * size) / 2


def test_work_is_counted_for_each_check_alone() -> None:
    claims = tuple(Near((3.1, 3.2, 3.3), (3.1, 3.2, 3.3)) for _ in range(1000))
    for _ in range(5):
        check(Certificate(claims), EGG, CAN)


# ---- the size of what has to be believed ---------------------------------------------------------------------------


def test_what_has_to_be_believed_stays_small() -> None:
    """All lines of the trusted files, docstrings and blank lines among them."""
    assert trusted_lines(OF_SETS) <= 1225
    assert trusted_lines(OF_PLANE) <= 120
    assert trusted_lines(OF_IMPACTS) <= 400
    assert trusted_lines(OF_SWEEPS) <= 1000
