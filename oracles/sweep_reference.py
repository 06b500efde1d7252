"""What the reference says of sweeps: first contacts in floats, and with proof; each batch is asked once."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from oracles.clock import timed
from oracles.course import Course
from oracles.engine import COLUMNS, WIDTH, Answers
from oracles.reference import SEARCH_ERROR, signed
from oracles.scene import size_of
from oracles.world import VECTORS, world_of
from refimpl import Proxy, sweep
from refimpl.linear import Array, Bools
from refimpl.motions import Motion
from refimpl.proof import SweepCertificate, certify_sweep, check_sweep
from refimpl.proof.claims import Bound

MOST_KEPT, MOST_PROVEN = 64, 1_000

TIME_ERROR, TURNING_ERROR = 1e-12, 1e-9
"""By how much the reference's time may be off, of translations and of turning bodies."""

STEPS, FACTOR = 24, 2.0
"""Times at which one looks how deep the two have got into each other: so many, each so much later than the one before;
they reach down to a ten-millionth of the way, for bodies that are through each other soon."""

_kept: OrderedDict[tuple[object, ...], FirstContact] = OrderedDict()
_proven: OrderedDict[tuple[object, ...], Proven] = OrderedDict()

Proven = tuple[SweepCertificate, tuple[Bound, Bound]]
"""Certificate, and the interval of the first time of contact that the exact checker takes from it."""


@dataclass(frozen=True)
class FirstContact:
    """First contacts of a batch.

    Attributes
    ----------
    hit : (n,) bool
    lower, t : (n,)
        The two touch at `t`, and not before `lower`; both infinite where they miss each other.
    point, normal : (n, 3)
        NaN where they miss each other; the normal also of what overlaps at the start.
    """

    hit: Bools
    lower: Array
    t: Array
    point: Array
    normal: Array


def first_contacts(a: Proxy, b: Proxy, course: Course) -> FirstContact:
    """First contacts of a batch, by the reference in floats."""
    key = _key(a, b, course)
    if key not in _kept:
        with timed("reference"):
            _kept[key] = _asked(a, b, course)
        if len(_kept) > MOST_KEPT:
            _kept.popitem(last=False)
    _kept.move_to_end(key)
    return _kept[key]


def _asked(a: Proxy, b: Proxy, course: Course) -> FirstContact:
    """Ask for rows that turn, and for those that do not: translations are answered more exactly, and sooner."""
    n, turns = len(a), course.turns
    times, places = np.full((2, n), np.inf), np.full((2, n, world_of(b).axes), np.nan)
    for rows in (np.flatnonzero(~turns), np.flatnonzero(turns)):
        if rows.size:
            found = sweep(a[rows], b[rows], *course[rows].motions_of(b))
            early = np.where(turns[rows], found.t_lower, found.t)  # of translations the time is all but exact
            times[:, rows] = np.where(found.hit, [early, found.t], np.inf)
            places[:, rows] = found.point, found.normal
    return FirstContact(np.isfinite(times[1]), *times, *places)


def proven_sweep(a: Proxy, b: Proxy, course: Course) -> Proven:
    """Certificate of a single sweep, and the interval that the exact checker takes from it.

    Raises
    ------
    InvalidCertificate
        When the checker refuses the reference's own certificate.
    """
    key = _key(a, b, course)
    if key not in _proven:
        motions: tuple[Motion, Motion] = course.motions_of(b)
        certificate = certify_sweep(a, b, *motions)
        _proven[key] = certificate, check_sweep(certificate, a, b, *motions)
        if len(_proven) > MOST_PROVEN:
            _proven.popitem(last=False)
    return _proven[key]


def sweep_answers(a: Proxy, b: Proxy, course: Course) -> Answers:
    """Answer a batch as the reference does."""
    found = first_contacts(a, b, course)
    table = np.full((len(a), WIDTH), np.nan)
    columns = {"hit": found.hit, "t": found.t, "point": found.point, "normal": found.normal}
    for name, values in columns.items():
        table[:, COLUMNS[name]] = world_of(b).fill(values) if name in VECTORS else values[:, None]
    return Answers.from_table(np.zeros(len(a), dtype=np.int8), table, {})


def error_of_time(course: Course) -> Array:
    """By how much the reference's time may be off, (...)."""
    return np.where(course.turns, TURNING_ERROR, TIME_ERROR)


def stands(t: float, interval: tuple[Bound, Bound], a: Proxy, b: Proxy, course: Course) -> bool:
    """Whether the reference's time is within a proven interval, or as near to it as it may be.

    Where bodies graze each other, the rounding of their places moves the time by much more than its own: then they
    touch at that time, or never get into each other, up to that rounding.
    """
    error, (lower, upper) = float(error_of_time(course)), interval
    if t == lower == upper or lower - error <= t <= upper + error:
        return True
    room = SEARCH_ERROR * float(size_of(a, b, course)) + error * float(course.way(a, b))
    if np.isfinite(t):
        return abs(_apart(a, b, course, t)) <= room
    begin = float(upper)
    times = [begin, *(begin + (1.0 - begin) * FACTOR**-power for power in range(STEPS))]
    return min(_apart(a, b, course, time) for time in times) >= -room


def _apart(a: Proxy, b: Proxy, course: Course, t: float) -> float:
    """Signed distance at a time; of overlapping unions that of the deepest pieces."""
    x, y = course.at(a, b, t)
    low, high = signed(x[None], y[None], np.ones(1, dtype=bool))
    return float(high[0] if high[0] < 0 else low[0])


def in_lengths(interval: tuple[Bound, Bound], way: float) -> tuple[Bound, Bound]:
    """An interval of time as one of how far the two move until then."""
    lower, upper = (bound if isinstance(bound, float) else Fraction(way) * bound for bound in interval)
    return lower, upper


def _key(a: Proxy, b: Proxy, course: Course) -> tuple[object, ...]:
    return type(a), type(b), a.sizes, b.sizes, *(part.pack().tobytes() for part in (a, b, course))
