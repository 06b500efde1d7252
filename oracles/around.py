"""Candidates around a scene: everything that shrinking tries to make it simpler, the boldest first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain, islice

from oracles.clumsiness import AT_A_GLANCE, numbers_of, odd_numbers
from oracles.likeness import Failing
from oracles.plain_bodies import PLAIN_BODIES, plain_pairs
from oracles.plain_impacts import restaged, simpler_motions
from oracles.plain_sweeps import around_sweep
from oracles.scene import Scene
from oracles.simpler import moved, nudged, simpler_proxies
from oracles.spacing import gap_of, kept_apart
from oracles.together import alike_changed, jointly_simpler
from oracles.views import views

AT_ONCE = 80
"""Candidates that are asked before one looks whether one of them will do."""
LOST_AT_ONCE = 8
"""The same where each may cost the engine."""
NEAR = 12
"""Plain scenes of which the bodies are brought to each of the gaps."""
NUDGED = 10
"""Odd numbers of which each is nudged; a scene of more is made simpler before its error is made to grow."""
ELSEWHERE = frozenset({"far away", "huge", "tiny"})
"""What is special about where a scene is: then it is moved before anything else."""
GAPS = [sign * 10.0**-k for k in range(16) for sign in (1.0, -1.0)]
"""Steps on which errors that grow with a gap or an overlap grow."""


def passes(best: Failing, *, growing: bool = False) -> Iterator[Iterable[Scene]]:
    """Candidates around a scene, the boldest first; or, of a slight error that is to grow, those next to it."""
    scene = best.scene
    if not best.strain and odd_numbers(scene) == 0:
        if best.slightness and scene.motion is None:
            yield kept_apart([scene], GAPS)
        return
    if scene.impact is not None:
        yield restaged(scene)
        yield (replace(scene, motion=motion) for motion in simpler_motions(scene.impact))
        return
    if scene.course is not None:
        yield from around_sweep(scene)
        return
    elsewhere = bool(best.special & ELSEWHERE)
    if elsewhere:
        yield moved(scene)
    if odd_numbers(scene) > AT_A_GLANCE:
        yield views(scene)
    nudging = bool(best.slightness) and growing and odd_numbers(scene) <= NUDGED
    if nudging:
        yield nudged(scene)
    yield alike_changed(scene)
    yield changed(scene)
    if not elsewhere:
        yield moved(scene)
    yield jointly_simpler(scene)
    yield kept_apart([scene], GAPS)
    gaps = list(dict.fromkeys([float(f"{gap_of(scene):.0e}"), 0.0]))
    yield kept_apart(list(beside_plain(scene)), gaps)
    if best.slightness or "nearly touching" in best.special:
        yield kept_apart(list(islice(plain_pairs(scene.cell), NEAR)), GAPS)
    yield from (kept_apart(some, gaps) for some in _in_parts(changed(scene)))
    if odd_numbers(scene) > AT_A_GLANCE:
        yield from (kept_apart(some, gaps[:1], moving_a=True) for some in _in_parts(changed(scene)))
    if best.slightness and not nudging:
        yield nudged(scene)


def beside_plain(scene: Scene) -> Iterator[Scene]:
    """One of both proxies as it is, beside a plain one of the other's type, where the other was."""
    for a in PLAIN_BODIES[scene.cell.type_a]:
        yield replace(scene, a=a.translated(scene.a.reference_point - a.reference_point))
    for b in PLAIN_BODIES[scene.cell.type_b]:
        yield replace(scene, b=b.translated(scene.b.reference_point - b.reference_point))


def changed(scene: Scene) -> Iterator[Scene]:
    """One of both proxies simpler, first the one of more numbers."""
    a = (replace(scene, a=a) for a in simpler_proxies(scene.a))
    b = (replace(scene, b=b) for b in simpler_proxies(scene.b))
    yield from chain(b, a) if len(numbers_of(scene.b)) > len(numbers_of(scene.a)) else chain(a, b)


def _in_parts(scenes: Iterator[Scene]) -> Iterator[list[Scene]]:
    while some := list(islice(scenes, AT_ONCE)):
        yield some
