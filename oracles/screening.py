"""Screening: what the reference in floats says of a whole batch of answers.

Every claim of every answer is tried. What passes with room to spare is right; what does not is a suspect, which the
judge brings before the exact checker.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oracles.claims import NEITHER, NOT_A_NUMBER, Questioned
from oracles.course import Course
from oracles.engine import Answers, Status
from oracles.outcome import Kind
from oracles.reference import is_quick
from oracles.rules import Rules
from oracles.scene import RAYCAST, Cell
from refimpl import Proxy
from refimpl.linear import Array, Bools

TINY = np.finfo(float).tiny
FEW = 4
"""Where less than one row in so many is suspect, and pairs are quick, the others are left out altogether."""
TIMED_OUT, CRASHED, RAISED = "no answer in time", "process lost", "error raised"

_LOST = {
    Status.ANSWERED: (Kind.AGREES, ""),
    Status.ERROR: (Kind.CRASHED, RAISED),
    Status.CRASHED: (Kind.CRASHED, CRASHED),
    Status.TIMED_OUT: (Kind.TIMED_OUT, TIMED_OUT),
    Status.SKIPPED: (Kind.SKIPPED, ""),
    Status.UNSUPPORTED: (Kind.UNSUPPORTED, ""),
}
KINDS = tuple(Kind)
_CODE = {kind: code for code, kind in enumerate(KINDS)}
_NAMED = np.array([*KINDS, None], dtype=object)[:-1]
_FATES = np.array([_CODE[_LOST[status][0]] for status in Status], dtype=np.int8)
_SYMPTOMS = np.array([_LOST[status][1] for status in Status], dtype=object)


@dataclass(frozen=True)
class Screening:
    """What the floats say of one batch.

    Attributes
    ----------
    codes : (n,)
        Number in `KINDS` of each answer's kind: AGREES, CONVENTION, the statuses, or WRONG for a suspect, which is yet
        to be proven.
    symptom : (n,) of str
    amount : (n,)
        Estimated violation, for sorting and counting; a proof comes from `Judge.convict`.
    certain : (n,) bool
        Whether the violation exceeds what the reference itself may err by.
    pressure : (n,)
        Largest error of any claim relative to the tolerance for it: what steers the adversarial hunter.
    error : (n,)
        By how much the value that was answered (signed distance, time of a ray's hit) is off at least, before any
        tolerance: its distance from the reference's value, of a hit that from the surface, less what the reference may
        err by. A length, of impacts a velocity; on the effective shapes, where these speak for the engine, unless it
        declares that the value is not meant to be that. NaN without a value.
    """

    codes: NDArray[np.int8]
    symptom: NDArray[Any]
    amount: Array
    certain: Bools
    pressure: Array
    error: Array

    @classmethod
    def of_fates(cls, answers: Answers) -> Screening:
        """Begin with the rows without an answer; all others agree so far."""
        n = len(answers)
        status = answers.status.astype(np.int64)
        codes, symptom = _FATES[status], _SYMPTOMS[status]
        begun = cls(codes, symptom, np.zeros(n), np.ones(n, dtype=bool), np.zeros(n), np.full(n, np.nan))
        unfit = [i for i in answers.errors if answers.status[i] == Status.ERROR and _is_no_answer(answers, i)]
        if unfit:
            begun.set(np.array(unfit), Kind.WRONG, NOT_A_NUMBER, 0.0, certain=True)
        return begun

    @property
    def kind(self) -> NDArray[Any]:
        """Kind of each row, (n,) of `Kind`."""
        return np.asarray(_NAMED[self.codes])

    def set(self, rows: Any, kind: Kind, symptom: Any, amount: Any, *, certain: Any) -> None:
        """Give some rows their verdict."""
        self.codes[rows] = _CODE[kind]
        self.symptom[rows], self.amount[rows], self.certain[rows] = symptom, amount, certain

    def rows_of(self, kinds: Iterable[Kind]) -> NDArray[np.int_]:
        """Rows of these kinds."""
        return np.flatnonzero(np.isin(self.codes, [_CODE[kind] for kind in kinds]))

    def counts(self, groups: NDArray[np.int_]) -> dict[tuple[int, Kind], int]:
        """How many rows of each group are of each kind, where there are any."""
        return counted(self.codes, groups)


def counted(codes: NDArray[np.int8], groups: NDArray[np.int_]) -> dict[tuple[int, Kind], int]:
    """How many rows of each group have each kind's number in `KINDS`, where there are any."""
    if not len(codes):
        return {}
    table = np.bincount(groups * len(KINDS) + codes, minlength=len(KINDS))
    return {(int(i) // len(KINDS), KINDS[int(i) % len(KINDS)]): int(table[i]) for i in np.flatnonzero(table)}


def fate_of(answers: Answers, i: int) -> tuple[Kind, str]:
    """Verdict on a scene without an answer; `Kind.AGREES` where there is one to be judged."""
    kind, symptom = _LOST[Status(int(answers.status[i]))]
    return (Kind.WRONG, NOT_A_NUMBER) if symptom == RAISED and _is_no_answer(answers, i) else (kind, symptom)


def _is_no_answer(answers: Answers, i: int) -> bool:
    return answers.errors.get(i, "").startswith("answered ")


@dataclass(frozen=True)
class Sides:
    """Both sides of all claims over a batch, the gravest claim first: two rows for each claim.

    Attributes
    ----------
    symptoms : (s,) of str
    conventions : (s,) bool
        Whether breaking the claim is a convention.
    excess : (s, n)
        By how much it is violated.
    violated, certain : (s, n) bool
        Whether at all, and whether beyond doubt.
    pressure, error : (n,)
        As in `Screening`.
    """

    symptoms: NDArray[Any]
    conventions: Bools
    excess: Array
    violated: Bools
    certain: Bools
    pressure: Array
    error: Array

    @classmethod
    def of(cls, rules: Rules, cell: Cell, rows: Questioned, joined: Sides | None = None) -> Sides:
        """Try every claim; with the sides of other shapes, those that can tell what `_judge_jointly` asks of both.

        Once a claim is broken on both, no graver one is, and the others do not count; where nothing is broken that
        counts on the others, nothing does. What is measured is tried all the same, but for a depth that by convention
        is not that of the pair: how far it is off is known of the shapes given, and no other shapes excuse it.
        """
        claims, size, n = list(rows.claims()), rows.size, len(rows.a)
        excess, violated = np.full((2 * len(claims), n), -np.inf), np.zeros((2 * len(claims), n), dtype=bool)
        certain, pressure, error = violated.copy(), np.zeros(n), np.full(n, np.nan)
        open_still = np.ones(n, dtype=bool) if joined is None else joined.counting.any(axis=0)
        for i, whole in enumerate(claims):
            sides, claim = slice(2 * i, 2 * i + 2), whole
            if joined is not None and (whole.measures is None or whole.by_convention):
                claim = replace(whole, made=whole.made & open_still & (not whole.by_convention))
            below, above, doubt = claim.violations()
            allowed = rules.allowed(cell, claim.kind, size)
            excess[sides] = below, above
            violated[sides] = excess[sides] > allowed - doubt
            certain[sides] = excess[sides] > allowed + doubt
            if joined is not None and not claim.by_convention:
                open_still &= ~(joined.violated[sides] & violated[sides]).any(axis=0)
            worst = np.maximum(below, above)
            np.maximum(pressure, worst / np.maximum(allowed, doubt + TINY), out=pressure)
            if claim.measures is not None:
                np.fmax(error, claim.measured(worst, doubt), out=error)
        words = np.array([word for claim in claims for word in (claim.below, claim.above)], dtype=object)
        conventions = np.repeat(np.array([claim.by_convention for claim in claims], dtype=bool), 2)
        return cls(words, conventions, excess, violated, certain, pressure, error)

    def take(self, rows: Any) -> Sides:
        """Pick rows."""
        violated, certain = self.violated[:, rows], self.certain[:, rows]
        picked = self.pressure[rows], self.error[rows]
        return Sides(self.symptoms, self.conventions, self.excess[:, rows], violated, certain, *picked)

    def spread(self, rows: NDArray[np.int_], n: int) -> Sides:
        """Put picked rows back to where they were in a batch of n; nothing is violated in the others."""
        violated, certain = (np.zeros((len(self.symptoms), n), dtype=bool) for _ in range(2))
        excess, pressure, error = np.full((len(self.symptoms), n), -np.inf), np.zeros(n), np.full(n, np.nan)
        violated[:, rows], certain[:, rows], excess[:, rows] = self.violated, self.certain, self.excess
        pressure[rows], error[rows] = self.pressure, self.error
        return Sides(self.symptoms, self.conventions, excess, violated, certain, pressure, error)

    @property
    def counting(self) -> Bools:
        """Violations that are no convention, (s, n)."""
        return np.asarray(self.violated & ~self.conventions[:, None])


def screen(rules: Rules, cell: Cell, a: Proxy, b: Proxy, answers: Answers, course: Course | None = None) -> Screening:
    """Give every row of a batch its verdict by floats."""
    found = Screening.of_fates(answers)
    nominal = rules.questioned(cell, a, b, answers, course)
    if nominal.unusable.any():
        found.set(nominal.unusable, Kind.WRONG, NOT_A_NUMBER, math.inf, certain=True)
    sides = Sides.of(rules, cell, nominal)
    found.pressure[:], found.error[:] = sides.pressure, sides.error
    wrong = np.flatnonzero(sides.violated.any(axis=0) & ~nominal.unusable)
    if wrong.size:
        ours = sides.take(wrong)
        theirs, same = _effectively(rules, cell, nominal, wrong, ours)
        excused = rules.excused_inside(cell, nominal.take(wrong))
        if not same:
            found.error[wrong] = np.fmin(found.error[wrong], theirs.error)
        _judge_jointly(ours, theirs, excused, wrong, found)
    return found


def _effectively(
    rules: Rules, cell: Cell, nominal: Questioned, wrong: NDArray[np.int_], ours: Sides
) -> tuple[Sides, bool]:
    """The sides of the rows that are `wrong` on the shapes that the engine uses, and whether these are the given ones.

    The shapes are made for the whole batch, so that other queries and engines find them, and what is known of them;
    but few rays that are wrong are taken alone, since no other query asks about their targets.
    """
    if not ours.counting.any():
        return ours, True  # what is broken by convention needs no excuse
    few = FEW * wrong.size < len(nominal.a)
    rows = nominal.take(wrong) if few and cell.query == RAYCAST else nominal
    effective = rules.effectively(cell, rows)
    if effective.a is rows.a and effective.b is rows.b:
        return ours, True
    if rows is not nominal:
        return Sides.of(rules, cell, effective, ours), False
    if few and is_quick(type(effective.a), type(effective.b)):
        return Sides.of(rules, cell, effective.take(wrong), ours), False
    everywhere = ours.spread(wrong, len(nominal.a))
    return Sides.of(rules, cell, effective.only(wrong), everywhere).take(wrong), False


def _judge_jointly(ours: Sides, theirs: Sides, excused: Bools, wrong: NDArray[np.int_], found: Screening) -> None:
    """Give the rows with a violated claim their verdict: on the scene's shapes and on the effective ones.

    A claim counts when it is violated on both, by the smaller amount; right on the effective shapes is a convention;
    wrong on both, but in different ways, is a symptom of its own.
    """
    k = np.arange(len(wrong))
    mine, other = ours.counting, theirs.counting
    both = mine & other
    first_mine, first_other, first_both = (side.argmax(axis=0) for side in (mine, other, both))
    any_mine, any_other, any_both = (side.any(axis=0) for side in (mine, other, both))
    right = excused | ~any_mine | ~any_other
    shown = np.where(any_mine, first_mine, ours.violated.argmax(axis=0))
    found.set(wrong[right], Kind.CONVENTION, ours.symptoms[shown[right]], 0.0, certain=True)
    s, t = np.where(any_both, first_both, first_mine), np.where(any_both, first_both, first_other)
    amount = np.minimum(ours.excess[s, k], theirs.excess[t, k])
    certain = ours.certain[s, k] & theirs.certain[t, k]
    symptom = np.where(any_both, ours.symptoms[s], NEITHER)
    bad = ~right
    found.set(wrong[bad], Kind.WRONG, symptom[bad], amount[bad], certain=certain[bad])
