"""A failure of a broad phase, and the smallest crowd that is found to show it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from oracles.crowds.asking import Answer
from oracles.crowds.boxes import BoxCrowd, Ids, Pair
from oracles.fault import BROAD_PHASE, Fault
from refimpl.linear import Array, norm
from refimpl.proof import Certificate, certify, check
from refimpl.proof.wire import certificate_to_json, from_json

MISSING, NOT_NEAREST, LOST = "pair missing", "not the nearest pair", "no answer"
"""Symptoms."""
ASKED = {MISSING: "pairs", NOT_NEAREST: "nearest", LOST: "pairs"}
DIGITS = (1, 2, 3, 6)
"""To which the numbers of a witness may be rounded."""
MOST_ROUNDS = 12
"""Of asking whether a smaller crowd shows the same."""

Asker = Callable[[Sequence[BoxCrowd]], list[Answer]]


@dataclass(frozen=True)
class Failure:
    """What is wrong with one answer.

    Attributes
    ----------
    pair
        The one that is missing.
    amount
        By how much its boxes overlap, or how much farther apart than the nearest pair's those are that were named.
    entry
        Name of the ledger's entry that explains it; empty for what is new.
    """

    symptom: str
    pair: Pair | None
    amount: float
    entry: str = ""

    def fault(self, engine: str, crowd: BoxCrowd) -> Fault:
        """What the ledger goes by: the size is the larger diagonal of the pair's boxes, or of any."""
        bodies = slice(None) if self.pair is None else list(self.pair)
        size = 2 * float(np.max(norm(crowd.half[bodies])))
        special = "moved" if crowd.moved else "at rest"
        asked = BROAD_PHASE, ASKED[self.symptom], self.symptom, crowd.regime
        return Fault(engine, *asked, self.amount, size, special)


@dataclass(frozen=True)
class Witness:
    """A small crowd on which a broad phase fails.

    Attributes
    ----------
    crowd : BoxCrowd
    pair : (int, int) or None
        Bodies of the crowd that are missing.
    depth : float
        Proven: their bounding boxes overlap by this much, and more than may be rounded.
    certificate : Certificate or None
        Of the signed distance of the two bounding boxes.
    script : str
        Python text that asks the engine alone, and shows that the pair is missing; empty where there is none.
    symptom, said : str
        What is wrong, and what the engine said where no pair is missing.
    entry : str
        Name of the ledger's entry that explains it; empty for what is new.
    """

    crowd: BoxCrowd
    pair: Pair | None
    depth: float
    certificate: Certificate | None
    script: str = ""
    symptom: str = MISSING
    said: str = ""
    entry: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data, without the script."""
        return {
            "crowd": self.crowd.to_json(),
            "pair": None if self.pair is None else list(self.pair),
            "depth": self.depth,
            "certificate": None if self.certificate is None else certificate_to_json(self.certificate),
            **{name: getattr(self, name) for name in ("symptom", "said", "entry")},
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Witness:
        """Read it back, and check the proof.

        Raises
        ------
        LookupError, TypeError, ValueError
            For anything else, and for a proof that does not hold.
        """
        crowd, depth = BoxCrowd.from_json(data["crowd"]), float(data["depth"])
        symptom, said, entry = (str(data[name])[:1000] for name in ("symptom", "said", "entry"))
        if symptom not in ASKED or (symptom == MISSING) != (data["pair"] is not None):
            raise ValueError(f"a crowd is no witness of {symptom!r}")
        if data["pair"] is None:
            return cls(crowd, None, 0.0, None, "", symptom, said, entry)
        i, j = (int(number) for number in data["pair"])
        if not 0 <= i < j < len(crowd):
            raise ValueError(f"a crowd of {len(crowd)} has no bodies {i} and {j}")
        certificate = from_json(data["certificate"])
        proven = -check(certificate, crowd.box(i), crowd.box(j))[1]
        if not 0 <= depth <= proven:
            raise ValueError(f"the certificate proves an overlap of {float(proven)!r}, not {depth!r}")
        return cls(crowd, (i, j), depth, certificate, "", symptom, said, entry)


Shows = Callable[[BoxCrowd, Answer, Failure], bool]


def witness_of(asker: Asker, shows: Shows, crowd: BoxCrowd, failure: Failure, answer: Answer) -> Witness | None:
    """Find the smallest crowd that shows a failure, and prove a missing pair; None where the proof does not hold.

    First the pair is tried alone, with numbers as round as they can be. If the engine fails only among others, these
    are left out as long as it, asked anew each time, goes on failing. A crowd that costs the engine stays as it is.
    """
    if failure.symptom == LOST:
        return Witness(crowd, None, 0.0, None, "", LOST, answer.lost, failure.entry)
    kept = () if failure.pair is None else failure.pair

    def first(tries: Sequence[BoxCrowd]) -> tuple[BoxCrowd, Answer] | None:
        said = zip(tries, asker(tries) if tries else (), strict=True)
        return next(((one, back) for one, back in said if shows(one, back, failure)), None)

    best = crowd.some(np.array([*kept, *(n for n in range(len(crowd)) if n not in kept)]))  # the pair is now 0, 1
    alone = best.some(np.arange(2))
    found = first([*_simpler(alone), alone])
    if found is None:
        for _ in range(MOST_ROUNDS):
            smaller = first(_smaller(best, len(kept)))
            if smaller is None:
                break
            best = smaller[0]
        found = first([*_simpler(best), best])
    if found is None:
        return None
    said = "" if kept else f"the nearest pair is {found[1].nearest}"
    if not kept:
        return Witness(found[0], None, 0.0, None, "", failure.symptom, said, failure.entry)
    proof = certify(found[0].box(0), found[0].box(1))
    depth = -float(proof.upper)
    return Witness(found[0], (0, 1), depth, proof, entry=failure.entry) if depth >= 0 else None


def _smaller(crowd: BoxCrowd, kept: int) -> list[BoxCrowd]:
    """The first `kept` bodies with fewer of the others: the fewest first."""
    others = np.arange(kept, len(crowd))
    tries: list[Ids] = []
    parts = 2
    while parts <= min(len(others), 16):
        chunks = np.array_split(others, parts)
        if parts == 2:
            tries += chunks
        tries += [np.concatenate([c for k, c in enumerate(chunks) if k != leave]) for leave in range(parts)]
        parts *= 2
    first = np.arange(kept)
    ids = [np.concatenate([first, some]).astype(np.int64) for some in tries if len(some) < len(others)]
    return [crowd.some(some) for some in sorted(ids, key=len)]


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
