"""Bounding volumes contain, and support functions are right: held against exact sets, drawn by Hypothesis."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf  # type: ignore[import-untyped]

from refimpl import bounds
from refimpl.pairs import TABLE
from refimpl.shapes import HalfSpace, Proxy, Ray
from tests.conftest import name_of
from tests.laws import EXAMPLES, drawn
from tests.truth.bodies import Body
from tests.truth.rationals import DIGITS, UNIT_VECTORS, opposite, real
from tests.truth.unions import pieces_of

BOUNDED = [kind for kind in dict.fromkeys(kind for pair in TABLE for kind in pair) if kind not in (Ray, HalfSpace)]
UNIT = st.tuples(*[st.floats(-1.0, 1.0, allow_subnormal=False)] * 3).filter(lambda v: max(map(abs, v)) > 0.01)


def bodies_of(shape: Proxy) -> list[Body]:
    """Exact convex pieces of a bounded shape; of a mesh its triangles, of which its hull is the hull."""
    return [piece for piece in pieces_of(shape) if isinstance(piece, Body)]


def reach(bodies: list[Body], n: Any, length: Any) -> mpf:
    """Support function of a union, at the working precision."""
    return max(body.support(n) + real(body.radius) * length for body in bodies)


@pytest.mark.parametrize("kind", BOUNDED, ids=name_of)
@settings(max_examples=max(EXAMPLES * 2 // 5, 1))
@given(data=st.data(), direction=UNIT)
def test_bounding_volumes_contain_and_supports_agree(kind: Any, data: Any, direction: Any) -> None:
    """Containment is exact; the support function is held against 60 digits."""
    pair = next(p for p in TABLE if kind in p and p[0] is not Ray)
    shape = next(x for x in drawn(data, pair) if isinstance(x, kind))
    bodies, box, ball = bodies_of(shape), bounds.aabb(shape), bounds.bounding_sphere(shape)
    with mp.workdps(DIGITS):
        for i, axis in enumerate(UNIT_VECTORS):
            assert reach(bodies, axis, 1) <= mpf(float(box.upper[i]))
            assert -reach(bodies, opposite(axis), 1) >= mpf(float(box.lower[i]))
        n = tuple(mpf(float(x)) for x in direction)
        length = mp.sqrt(sum(x * x for x in n))
        h = reach(bodies, n, length)
        center = [mpf(float(c)) for c in ball.center]
        assert h <= sum(c * x for c, x in zip(center, n, strict=True)) + mpf(float(ball.radius)) * length
        size = float(shape.magnitude) or 1.0
        assert abs(h - float(bounds.support(shape, direction))) <= 1e-14 * size * float(length) * 3
        for body in bodies:
            for corner in body.points if body.ellipsoid is None else ():
                offset = [real(x) - c for x, c in zip(corner, center, strict=True)]
                assert mp.sqrt(sum(x * x for x in offset)) + real(body.radius) <= mpf(float(ball.radius))
