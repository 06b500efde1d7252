"""What the tests of the laws share: scenes, the interval of a signed distance, and what rounding costs an image."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from oracles.regimes import REGIMES
from oracles.scene import DISTANCE, RAYCAST, Cell
from oracles.strategies import scenes
from refimpl import bounds, distance
from refimpl.contacts import contacts
from refimpl.linear import Array, dot, largest
from refimpl.pairs import ITERATIVE, TABLE
from refimpl.shapes import Composite, HalfSpace, Polyhedron, Proxy, Ray, ShapeError
from tests.conftest import name_of

UNIONS = (Polyhedron, Composite)
EXAMPLES = settings.default.max_examples if settings.default else 20
SMALL = [name for name in REGIMES if name != "models"]
"""Regimes of small shapes: laws that build new meshes and hulls of them take these."""
PLACES = st.tuples(*[st.floats(-3.0, 3.0, allow_subnormal=False)] * 3).map(np.array)
QUATERNIONS = st.tuples(*[st.floats(-1.0, 1.0, allow_subnormal=False)] * 4).filter(lambda v: max(map(abs, v)) > 0.01)


def law(pairs: Sequence[tuple[type, type]], **drawn_from: Any) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """A test of each pair: with few scenes, for there are hundreds of pairs and laws, and fewer where unions meet."""

    def tested(function: Callable[..., None]) -> Callable[..., None]:
        quick, slow = (
            settings(max_examples=max(EXAMPLES // part, 1))(given(data=st.data(), **drawn_from)(function))
            for part in (3, 5)
        )

        @pytest.mark.parametrize("pair", pairs, ids=name_of)
        @wraps(function)
        def test(pair: tuple[type, type]) -> None:
            (slow if set(pair) & set(UNIONS) else quick)(pair=pair)

        del test.__wrapped__  # type: ignore[attr-defined]  # or pytest would ask for the law's own arguments
        test.law, test.drawn_from = function, drawn_from  # type: ignore[attr-defined]
        return test

    return tested


@dataclass(frozen=True)
class Span:
    """Where a signed distance lies: low = high but for unions that overlap; and the normals that decide it."""

    low: float
    high: float
    normals: Array


def span(a: Proxy, b: Proxy) -> Span:
    """What the reference knows of σ(a, b): of overlapping unions the lengths of a way out, and of the deepest pair."""
    if not (isinstance(a, UNIONS) or isinstance(b, UNIONS)):
        found = distance(a, b)
        return Span(float(found.distance), float(found.distance), found.normal[None])
    known = contacts(a, b)
    sigma, normals = float(known.separation.distance), [known.separation.normal[None], known.pairs.normal]
    return Span(sigma, sigma if sigma >= 0 else -float(known.depth_interval[0]), np.concatenate(normals))


def promise(pair: tuple[type, type]) -> float:
    """Error that the exactness class of a pair allows, relative to the scene."""
    return 1e-12 if TABLE[pair].exactness == ITERATIVE else 1e-14


def size_of(a: Proxy, b: Proxy, sigma: Any = 0.0) -> float:
    """Largest number of a scene, and its distance."""
    finite = abs(float(sigma)) if math.isfinite(sigma) else 0.0
    return float(max(a.magnitude, b.magnitude, finite)) or 1.0


def drawn(data: Any, pair: tuple[type, type], regimes: Sequence[str] | None = None) -> tuple[Proxy, Proxy]:
    """Draw a scene; numbers that rounding left without a set are none."""
    try:
        scene = data.draw(scenes(Cell(RAYCAST if pair[0] is Ray else DISTANCE, *pair), regimes))
    except ShapeError:
        assume(False)
    return scene.a, scene.b


def shift(before: Proxy, after: Proxy, normals: Sequence[tuple[Any, Any]], offset: Any, factor: float = 1.0) -> float:
    """By how much rounding moved supporting planes of an image: |h(image, m) − (factor·h(shape, n) + offset·m)|.

    Parameters
    ----------
    normals
        Directions n at the shape, and m at the image.
    """
    if isinstance(before, Composite) and isinstance(after, Composite):
        return max(shift(x, y, normals, offset, factor) for x, y in zip(before.parts, after.parts, strict=True))
    everywhere = 4.0 * 2.0**-52 * float(before.magnitude * factor + largest(offset) + after.magnitude)
    if isinstance(before, HalfSpace | Polyhedron):
        return everywhere
    moved = [
        abs(float(bounds.support(after, m) - (factor * bounds.support(before, n) + dot(offset, m))))
        for n, m in normals
        if np.all(np.isfinite(m))
    ]
    return max(moved, default=0.0)
