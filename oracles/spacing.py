"""Scenes with their second proxy moved along the normal: to the gap that they had, or to another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from oracles.forms import batch_of, by_form
from oracles.placements import Draft, signed_gap
from oracles.scene import Scene
from refimpl import ShapeError


def gap_of(scene: Scene) -> float:
    """By how much the two are apart, as `kept_apart` takes it; 0 where that has no end."""
    sigma, _ = signed_gap(scene.a[None], scene.b[None])
    return float(sigma[0]) if np.isfinite(sigma[0]) else 0.0


def kept_apart(scenes: list[Scene], gaps: list[float], *, moving_a: bool = False) -> list[Scene]:
    """The scenes with B moved along the normal to each of the gaps, gap by gap; or with A moved instead."""
    found: list[Scene] = []
    for group in by_form(scenes):
        every = [scene for _ in gaps for scene in group]
        a, b = batch_of([scene.a for scene in every]), batch_of([scene.b for scene in every])
        try:
            with np.errstate(all="ignore"):
                _, placed = Draft(a, b, np.repeat(gaps, len(group)), np.ones(len(every), dtype=bool)).settled()
        except (ShapeError, ValueError):
            continue
        if moving_a:
            moves = b.reference_point - placed.reference_point
            found += [replace(scene, a=scene.a.translated(move)) for scene, move in zip(every, moves, strict=True)]
        else:
            found += [replace(scene, b=placed[i]) for i, scene in enumerate(every)]
    return found
