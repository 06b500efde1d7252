"""Rows of plain scenes: for findings that do not come again, because an answer depends on what was asked before.

Asked about such a finding's scene alone, a fresh engine is right, so nothing around that scene can be tried. But where
it errs every so often, or after scenes of some kind, it errs as well when plain scenes are asked one after the other;
then the simplest on which it does is the better witness.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from oracles.answers import take
from oracles.clumsiness import PLAIN, clumsiness, odd_numbers
from oracles.forms import batch_of, by_form
from oracles.judges import finding_of
from oracles.motion import Motion
from oracles.outcome import Finding
from oracles.plain import plain_scenes
from oracles.relations import Bench
from oracles.scene import Scene, packed_rows
from oracles.simpler import changeable, rebuilt, with_sides

LIKE = 3
"""Scenes in turn that differ from the one before in one number."""
SOURCE = "plain, after others"


def in_a_row(finding: Finding, bench: Bench, length: int) -> Finding | None:
    """A finding of the same cell, kind and symptom in a row of plain scenes, the simplest; None where there is none.

    Parameters
    ----------
    length
        Scenes in the row of each form.
    """
    found: list[Finding] = []
    plain = plain_scenes(finding.scene.cell, finding.scene.regime)
    for scenes in by_form([scene for scene in plain if not odd_numbers(scene)]):
        bench.renew()
        found += _simplest(finding, bench, list(islice(row_of(scenes), length)))
    return min(found, key=lambda one: clumsiness(one.scene), default=None)


def row_of(scenes: Sequence[Scene]) -> Iterator[Scene]:
    """These scenes in any order, again and again, each followed by some of which each differs from the one before it.

    What an engine keeps of a scene, it may give again to another that is like it. Always the same.
    """
    random = np.random.Generator(np.random.Philox(np.random.SeedSequence([len(scenes)])))
    while True:
        last = scenes[int(random.integers(len(scenes)))]
        yield last
        for _ in range(LIKE):
            last = next(_like(last, random), last)
            yield last


def _like(scene: Scene, random: np.random.Generator) -> Iterator[Scene]:
    """The scene with one number of its proxies changed to another plain one, unless that makes no proxy."""
    side = int(random.integers(2))
    shape = (scene.a, scene.b)[side]
    row = shape.pack()
    row[random.choice(np.flatnonzero(changeable(shape)))] = random.choice(sorted(PLAIN))
    made = rebuilt(shape, row)
    yield from with_sides(scene, *((scene.a, made) if side else (made, scene.b)))


def _simplest(finding: Finding, bench: Bench, scenes: list[Scene]) -> list[Finding]:
    """The simplest of scenes of one form on which a fresh engine fails like that in passing, as a proven finding."""
    cell, wanted = finding.scene.cell, finding.verdict
    a, b = batch_of([scene.a for scene in scenes]), batch_of([scene.b for scene in scenes])
    motions = [scene.motion.pack() for scene in scenes if scene.motion is not None]
    motion = Motion.unpack(np.stack(motions)) if motions else None
    answers = bench.answer(cell, packed_rows(a, b, motion), give_up_after=1)
    screening = bench.judges.screen(cell, a, b, motion, answers)
    alike = (screening.kind == wanted.kind) & (screening.symptom == wanted.symptom) & screening.certain
    for i in sorted(np.flatnonzero(alike).tolist(), key=lambda i: clumsiness(scenes[i])):
        alone = take(answers, [i])
        verdict = bench.judges.convict(scenes[i], alone)
        if (verdict.kind, verdict.symptom) == (wanted.kind, wanted.symptom):
            scene = replace(scenes[i], regime=finding.scene.regime, source=SOURCE)
            return [replace(finding_of(finding.engine, scene, alone, verdict), repeats=False)]
    return []
