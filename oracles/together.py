"""Several numbers of a scene made simpler together: where one of them alone could not be, or for fewer questions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from oracles.clumsiness import PLAIN
from oracles.forms import form_of
from oracles.scene import Scene
from oracles.simpler import changeable, rebuilt, simpler_numbers, with_sides

JOINTLY = 100
"""Scenes in which several numbers are made simpler together."""
ALIKE = 1e-3
"""Numbers whose sizes differ by less, relative to them, are changed together."""
MOST_MERGED = 8
"""Scenes of several changes at once that are tried."""


def jointly_simpler(scene: Scene) -> Iterator[Scene]:
    """The scene with every other odd number simpler, as chance has it; always the same."""
    random = np.random.Generator(np.random.Philox(np.random.SeedSequence([JOINTLY])))
    rows = [(shape, shape.pack(), changeable(shape)) for shape in (scene.a, scene.b)]
    for _ in range(JOINTLY):
        made = []
        for shape, row, mask in rows:
            odd = mask & ~np.isin(row, list(PLAIN)) & (random.random(len(row)) < 0.5)
            made.append(rebuilt(shape, np.where(odd, random.choice([0.0, 0.0, 1.0, -1.0, 0.5, 2.0], len(row)), row)))
        yield from with_sides(scene, *made)


def alike_changed(scene: Scene) -> Iterator[Scene]:
    """The scene with numbers that are nearly as large as each other made equally simple, whatever their signs.

    Where a body is symmetric about an axis, one of them alone could not be changed.
    """
    rows = [shape.pack() for shape in (scene.a, scene.b)]
    row, split = np.concatenate(rows), len(rows[0])
    mask = np.concatenate([changeable(scene.a), changeable(scene.b)]) & (row != 0)
    for first in np.flatnonzero(mask & ~np.isin(row, list(PLAIN))):
        size = abs(float(row[first]))
        group = mask & (np.abs(np.abs(row) - size) <= ALIKE * size)
        if np.count_nonzero(group) > 1 and first == np.flatnonzero(group & ~np.isin(row, list(PLAIN)))[0]:
            for x in simpler_numbers(size):
                changed = np.where(group, np.sign(row) * abs(x), row)
                yield from with_sides(scene, rebuilt(scene.a, changed[:split]), rebuilt(scene.b, changed[split:]))


def merged(scene: Scene, others: Iterable[Scene]) -> Iterator[Scene]:
    """The scene with several changes at once, each of which was made alone in one of the others; the most first."""
    base, split = np.concatenate(scene.rows), len(scene.rows[0])
    made = [base.copy()]
    for other in others:
        row = np.concatenate(other.rows)
        if form_of(other.a) != form_of(scene.a) or form_of(other.b) != form_of(scene.b) or row.shape != base.shape:
            continue
        new = row != base
        if np.any(new & (made[-1] != base)):
            continue
        made.append(np.where(new, row, made[-1]))
    for row in made[:1:-1][:MOST_MERGED]:
        yield from with_sides(scene, rebuilt(scene.a, row[:split]), rebuilt(scene.b, row[split:]))
