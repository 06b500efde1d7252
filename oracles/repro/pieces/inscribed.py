"""Balls in balls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from oracles.repro.pieces.exact import Vector


def positive(matrix: Sequence[Sequence[Any]]) -> bool:
    """Whether xᵀ M x ≥ 0 for all x, for a symmetric matrix: by elimination."""
    if not matrix:
        return True
    (pivot, *row), *lines = matrix
    if pivot < 0 or (pivot == 0 and any(row)):
        return False
    share = [x / pivot for x in row] if pivot else row
    return positive(
        [[m - s * y for m, y in zip(line[1:], row, strict=True)] for s, line in zip(share, lines, strict=True)]
    )


def ball_in_ball(centre: Vector, columns: Sequence[Vector], share: Any) -> bool:
    """Whether ‖centre + Σ uᵢ·columnᵢ‖ ≤ 1 for all ‖u‖ ≤ 1.

    It is when 1 − ‖centre + P u‖² − share·(1 − ‖u‖²), a quadratic form in (1, u), is nowhere negative.
    """
    vectors, diagonal = [centre, *columns], [1 - share, *(share for _ in columns)]
    form = [[-sum(x * y for x, y in zip(u, v, strict=True)) for v in vectors] for u in vectors]
    for i, value in enumerate(diagonal):
        form[i][i] += value
    return positive(form)
