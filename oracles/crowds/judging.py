"""The judge of broad phases: which pairs are missing, which are false alarms, and the smallest crowd that shows it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from oracles.crowds.asking import Answer, ask
from oracles.crowds.boxes import BoxCrowd, Ids, Pair
from oracles.crowds.engine import BroadPhaseEngine
from oracles.crowds.repro import crowd_script
from refimpl.linear import Array, Bools
from refimpl.proof import Certificate, certify

DIGITS = (1, 2, 3, 6)
"""To which the numbers of a witness may be rounded."""
MOST_ROUNDS = 12
"""Of asking whether a smaller crowd shows the same."""


@dataclass(frozen=True)
class Witness:
    """A small crowd of which an engine misses a pair.

    Attributes
    ----------
    crowd : BoxCrowd
    pair : (int, int)
        Bodies of the crowd.
    depth : float
        Proven: their bounding boxes overlap by this much, and more than may be rounded.
    certificate : Certificate
        Of the signed distance of the two bounding boxes.
    script : str
        Python text that asks the engine alone, and shows that the pair is missing; empty where there is none.
    """

    crowd: BoxCrowd
    pair: Pair
    depth: float
    certificate: Certificate
    script: str = ""


@dataclass
class CrowdCount:
    """What became of the crowds of one regime before one engine.

    Attributes
    ----------
    crowds, bodies : int
        Asked, all together.
    pairs : int
        Pairs of bodies whose bounding boxes overlap by more than may be rounded, or touch where nothing has to be
        rounded and the engine promises that: all must be named.
    missing : int
        Of these, what the engine left out.
    beyond_limit : int
        Left out too, but of a body about which the engine says that it promises nothing.
    close : int
        Other pairs whose boxes touch up to rounding: either answer is right.
    extra : int
        Named, although the boxes are apart.
    false_alarms : int
        Of these, what is farther apart than the margin that the engine declares.
    nearest, not_nearest : int
        Crowds, thinned out, of which the nearest pair was asked, and those of which another one was given.
    lost : int
        Crowds without an answer.
    """

    engine: str
    regime: str
    crowds: int = 0
    bodies: int = 0
    pairs: int = 0
    missing: int = 0
    beyond_limit: int = 0
    close: int = 0
    extra: int = 0
    false_alarms: int = 0
    nearest: int = 0
    not_nearest: int = 0
    lost: int = 0
    widest: float = 0.0
    """The largest gap between boxes of a pair that was named."""
    errors: list[str] = field(default_factory=list)
    """Why crowds were lost, each reason once."""
    calls: str = ""
    margin: float = 0.0
    margin_why: str = ""
    limit: str = ""
    """What the engine says of its broad phase (`oracles.crowds.engine`)."""
    witness: Witness | None = None
    """Of a missing pair; where there is none, of one beyond the limit."""

    def counted(self) -> dict[str, object]:
        """Return everything but the witness, as plain data."""
        return {name: value for name, value in vars(self).items() if name != "witness"}

    @property
    def wrong(self) -> bool:
        """Whether the engine broke its promise."""
        return self.missing > 0 or self.not_nearest > 0 or self.lost > 0


def weigh(count: CrowdCount, solver: BroadPhaseEngine, crowd: BoxCrowd, answer: Answer) -> list[Pair]:
    """Add one answer to the counts; gives the pairs that are missing, those that the limit excuses last."""
    count.crowds += 1
    count.bodies += len(crowd)
    if answer.lost:
        count.lost += 1
        count.errors += [answer.lost] * (answer.lost not in count.errors)
        return []
    if solver.finds_nearest:
        count.nearest += 1
        count.not_nearest += not _is_nearest(crowd.thinned(), answer.nearest)
    upper, depth, slack, named = _pairs(crowd, answer)
    must = depth > slack
    if solver.closed:
        must |= crowd.exact()[upper] & (depth >= 0)
    count.pairs += int(np.count_nonzero(must))
    count.close += int(np.count_nonzero((np.abs(depth) <= slack) & ~must))
    extra = named & (depth < -slack)
    count.extra += int(np.count_nonzero(extra))
    count.false_alarms += int(np.count_nonzero(extra & (depth < -slack - solver.margin)))
    count.widest = max(count.widest, float(np.max(-depth, where=extra, initial=0.0)))
    excused = _excused(solver, crowd)
    found = [_list(crowd, must & ~named & pardon) for pardon in (~excused, excused)]
    count.missing += len(found[0])
    count.beyond_limit += len(found[1])
    return found[0] + found[1]


def _is_nearest(crowd: BoxCrowd, pair: Pair | None) -> bool:
    """Whether no pair's boxes are nearer to each other, but for rounding."""
    if pair is None:
        return len(crowd) < 2
    gaps = crowd.gaps()
    least = float(np.min(gaps[_upper(crowd)]))
    return bool(gaps[pair] <= least + 4 * float(np.max(crowd.slack())))


def _upper(crowd: BoxCrowd) -> tuple[Ids, Ids]:
    i, j = np.triu_indices(len(crowd), 1)
    return i, j


def _pairs(crowd: BoxCrowd, answer: Answer) -> tuple[tuple[Ids, Ids], Array, Array, Bools]:
    """Rows and columns of every pair i < j; its depth, what may be rounded of that, and whether it was named."""
    named = np.zeros((len(crowd), len(crowd)), dtype=bool)
    if answer.pairs:
        named[tuple(np.array(sorted(answer.pairs)).T)] = True
    upper = _upper(crowd)
    return upper, crowd.depths()[upper], crowd.slack()[upper], named[upper]


def _excused(solver: BroadPhaseEngine, crowd: BoxCrowd) -> Bools:
    large = solver.beyond_limit(crowd)
    i, j = _upper(crowd)
    return np.asarray(large[i] | large[j])


def _list(crowd: BoxCrowd, which: Bools) -> list[Pair]:
    i, j = _upper(crowd)
    return list(zip(i[which].tolist(), j[which].tolist(), strict=True))


# -- witnesses -----------------------------------------------------------------------------------------------

Asker = Callable[[Sequence[BoxCrowd]], list[Answer]]


def witness_of(asker: Asker, crowd: BoxCrowd, pair: Pair, *, closed: bool) -> Witness | None:
    """Prove that a pair is missing, in the smallest crowd in which it is; None where the proof does not hold.

    First the pair is tried alone, with numbers as round as they can be. If the engine misses it only among others,
    these are left out as long as the engine, asked anew each time, goes on missing the pair.

    Parameters
    ----------
    closed
        Whether touching is enough where nothing has to be rounded.
    """
    ids = np.array([*pair, *(n for n in range(len(crowd)) if n not in pair)])
    best = crowd.some(ids)  # the pair is now 0, 1
    alone = best.some(np.arange(2))
    found = _first_missing(asker, [*_simpler(alone), alone], closed)
    if found is None:
        for _ in range(MOST_ROUNDS):
            smaller = _first_missing(asker, _smaller(best), closed)
            if smaller is None:
                break
            best = smaller
        found = _first_missing(asker, [*_simpler(best), best], closed)
    if found is None:
        return None
    proof = certify(found.box(0), found.box(1))
    if not _promised(found, -float(proof.upper), closed):
        return None
    return Witness(found, (0, 1), -float(proof.upper), proof)


def _promised(crowd: BoxCrowd, depth: float, closed: bool) -> bool:
    """Whether boxes of the first two bodies that overlap by this much must be named."""
    return depth > crowd.slack()[0, 1] or bool(closed and crowd.exact()[0, 1] and depth >= 0)


def _first_missing(asker: Asker, tries: Sequence[BoxCrowd], closed: bool) -> BoxCrowd | None:
    """Give the first of some crowds of which the engine misses the first two."""
    wanted = [crowd for crowd in tries if _promised(crowd, float(crowd.depths()[0, 1]), closed)]
    for crowd, answer in zip(wanted, asker(wanted) if wanted else (), strict=True):
        if not answer.lost and (0, 1) not in answer.pairs:
            return crowd
    return None


def _smaller(crowd: BoxCrowd) -> list[BoxCrowd]:
    """The first two bodies with fewer of the others: the fewest first."""
    others = np.arange(2, len(crowd))
    tries: list[Ids] = []
    parts = 2
    while parts <= min(len(others), 16):
        chunks = np.array_split(others, parts)
        if parts == 2:
            tries += chunks
        tries += [np.concatenate([c for k, c in enumerate(chunks) if k != leave]) for leave in range(parts)]
        parts *= 2
    kept = [np.concatenate([[0, 1], some]).astype(np.int64) for some in tries if len(some) < len(others)]
    return [crowd.some(ids) for ids in sorted(kept, key=len)]


def _simpler(crowd: BoxCrowd) -> list[BoxCrowd]:
    """The same with rounder numbers, or with nothing moved, or as boxes only: the simplest first."""

    def rounded() -> Iterator[BoxCrowd]:
        for still in (True, False):
            for boxes in (True, False):
                for digits in DIGITS:
                    center, half, before = (_rounded(x, digits) for x in (crowd.center, crowd.half, crowd.before))
                    if np.all(half > 0) and len(np.unique(center, axis=0)) == len(crowd):
                        balls = np.zeros_like(crowd.balls) if boxes else crowd.balls
                        yield replace(crowd, balls=balls, center=center, half=half, before=center if still else before)

    return list(rounded())


def _rounded(values: Array, digits: int) -> Array:
    """Numbers to so many digits of the largest of them."""
    decade = int(np.floor(np.log10(np.max(np.abs(values), initial=1e-300))))
    return np.asarray(np.round(values, digits - 1 - decade))


def judged(
    engine: str, solver: BroadPhaseEngine, crowds: Sequence[BoxCrowd], answers: Sequence[Answer], asker: Asker
) -> list[CrowdCount]:
    """Weigh the answers on crowds of several regimes, with a witness for each regime that has a missing pair."""
    counts: dict[str, CrowdCount] = {}
    said: dict[str, Any] = {name: getattr(solver, name) for name in ("calls", "margin", "margin_why", "limit")}
    for crowd, answer in zip(crowds, answers, strict=True):
        count = counts.setdefault(crowd.regime, CrowdCount(engine, crowd.regime, **said))
        before = count.missing
        missing = weigh(count, solver, crowd, answer)
        if missing and (count.witness is None or count.missing > before == 0):
            found = witness_of(asker, crowd, missing[0], closed=solver.closed)
            if found is not None:
                text = crowd_script(solver, engine, found.crowd, found.pair)
                count.witness = replace(found, script=text)
    return list(counts.values())


def question(spec: str, engine: str, solver: BroadPhaseEngine, crowds: Sequence[BoxCrowd]) -> list[CrowdCount]:
    """Ask an engine's broad phase about some crowds, and judge what it says."""

    def asker(some: Sequence[BoxCrowd]) -> list[Answer]:
        return ask(spec, some)

    return judged(engine, solver, crowds, asker(crowds), asker)
