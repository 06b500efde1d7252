"""What the reference says of the signed distance, in floats for screening and with proof: each pair is asked once.

Two engines and three queries ask about the same pair of shapes again and again, with every claim they make. Where a
search is needed its result is remembered by the shapes' numbers; closed forms are quicker than remembering.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from oracles.clock import timed
from oracles.keeping import MOST_BATCHES, kept_by_rows
from oracles.world import world_of
from refimpl import AABB, Box, Capsule, HalfSpace, Point, Proxy, Ray, Sphere, distance, intersect
from refimpl.flat import Disc, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.linear import Array, Bools, norm
from refimpl.overlaps import nearest, resolve
from refimpl.pairs import CLOSED, ITERATIVE, Rule
from refimpl.proof import Certificate, certify, check
from refimpl.proof.claims import Bound
from refimpl.shapes import Composite, Polyhedron

Kind = type[Proxy]

MOST_REMEMBERED, MOST_PROVEN = 20_000, 1_000
ALONE = 16
"""Batches up to so many rows are remembered in any case: the judge of one answer asks about it again."""
QUICK: set[Kind] = {Point, Ray, Sphere, Capsule, HalfSpace, AABB, Box, FlatPoint, FlatRay, Disc, Segment, Rectangle}
"""Types whose pairs need neither search nor corners nor pieces."""

UNIONS = (Polyhedron, Composite)
"""Types of which an overlap has a depth for each piece, and one of the whole that is known as an interval."""

DIRECT_ERROR, SEARCH_ERROR = 1e-14, 1e-12
"""Bounds on the error of `refimpl.distance`, relative to the scene's size, for closed and finite rules and for
iterative ones; held against 50 digits by the tests."""

_batches: OrderedDict[tuple[int, int], _Known] = OrderedDict()
_remembered: OrderedDict[tuple[object, ...], tuple[float, float]] = OrderedDict()
_proven: OrderedDict[tuple[object, ...], tuple[Certificate, tuple[Bound, Bound]]] = OrderedDict()


def is_quick(x: Kind, y: Kind) -> bool:
    """Whether a pair is answered and proven so fast that it is asked again rather than remembered."""
    return x in QUICK and y in QUICK


def rule_of(x: Kind, y: Kind) -> Rule:
    """Row of the pair table for two types, in either order."""
    table = world_of(x).table
    return table[x, y] if (x, y) in table else table[y, x]


def _is_formula(x: Kind, y: Kind) -> bool:
    """Whether a pair is answered by a formula that reads no corners."""
    return rule_of(x, y).exactness == CLOSED and not (x.header or y.header)


def error_of(x: Proxy, y: Proxy) -> float:
    """By how much the reference may be wrong about these, relative to the scene's size."""
    return SEARCH_ERROR if rule_of(type(x), type(y)).exactness == ITERATIVE else DIRECT_ERROR


def signed(
    x: Proxy, y: Proxy, wanted: Bools, *, above: bool = True, any_depth: Bools | None = None
) -> tuple[Array, Array]:
    """Signed distances from below and above, for the rows of a batch that are wanted; 0 for the others.

    The two differ only for unions that overlap; for large batches of these the one from above is not looked for where
    nobody asks for it, and told to be that from below. In rows of large batches for which `any_depth` will do, an
    overlap of unions, whose way out takes long to find, may be told as 0.
    """
    if (
        isinstance(x, Point) and isinstance(y, Capsule | Segment) and np.array_equal(y.p, y.q)
    ):  # a ball: of radius 0, perhaps
        sigma = np.where(wanted, norm(x.position - y.p) - y.radius, 0.0)
        return sigma, sigma
    if is_quick(type(x), type(y)) or _is_formula(type(x), type(y)):
        with timed("reference"):
            sigma = np.where(wanted, distance(x, y).distance, 0.0)
        return sigma, sigma
    low, high = np.zeros(len(wanted)), np.zeros(len(wanted))
    rows = np.flatnonzero(wanted)
    many = rows.size > ALONE
    if many and any_depth is not None and (isinstance(x, UNIONS) or isinstance(y, UNIONS)):
        quick = rows[any_depth[rows]]
        meeting = quick[intersect(x[quick], y[quick])] if quick.size else quick
        rows = rows[~np.isin(rows, meeting)]
    if many and not above:
        low[rows] = high[rows] = distance(x[rows], y[rows]).distance if rows.size else 0.0
    elif rows.size:
        low[rows], high[rows] = _recalled(x[rows], y[rows])
    return low, high


def kept(x: Proxy, y: Proxy, wanted: Bools, *, enough: Array | float = -math.inf) -> tuple[Array, Array]:
    """The same as `signed`, for two batches that are asked about again: by other queries, and of other engines.

    What was asked once of these very batches is known from then on, row by row. Of large batches of composites that
    overlap a way out, which takes longest, is looked for only in rows whose bound from above is greater than `enough`;
    the others may have −∞ from below.
    """
    key = (id(x), id(y))
    if key not in _batches:
        _batches[key] = _Known.nothing(x, y)
        if len(_batches) > MOST_BATCHES:
            _batches.popitem(last=False)
    _batches.move_to_end(key)
    known = _batches[key]
    if len(x) > ALONE and np.any(enough > -math.inf) and (isinstance(x, Composite) or isinstance(y, Composite)):
        with timed("reference"):
            known.look_from_above(wanted)
        missing = np.flatnonzero(wanted & ~known.rows & (known.high > enough))
    else:
        missing = np.flatnonzero(wanted & ~known.rows)
    if missing.size:
        with timed("reference"):
            part = known.part(missing)
            known.low[missing], known.high[missing] = signed(*part, np.ones(len(missing), dtype=bool))
        known.rows[missing] = True
    return np.where(wanted, known.low, 0.0), np.where(wanted, known.high, 0.0)


def gaps(x: Proxy, y: Proxy, wanted: Bools) -> Array:
    """Signed distances of the rows that are wanted, NaN of others; of overlapping unions the one with a way out."""
    if not wanted.any():
        return np.full(len(wanted), np.nan)
    return np.where(wanted, kept(x, y, wanted)[0], np.nan)


@kept_by_rows
def kept_shape(rows: Array, kind: Kind) -> Proxy:
    """The batch of these rows: the very same each time they are asked for, with all that was derived of it."""
    return kind.unpack(rows)


@dataclass(frozen=True)
class _Known:
    """Signed distances of a pair of batches, of the rows that were asked for; holds the batches, so that ids stay.

    A row's `high` is NaN until something is known of it, its `low` −∞.
    """

    x: Proxy
    y: Proxy
    rows: Bools
    low: Array
    high: Array

    @classmethod
    def nothing(cls, x: Proxy, y: Proxy) -> _Known:
        n = len(x)
        return cls(x, y, np.zeros(n, dtype=bool), np.full(n, -np.inf), np.full(n, np.nan))

    def part(self, rows: NDArray[np.int_]) -> tuple[Proxy, Proxy]:
        """Some of the pairs."""
        return (self.x, self.y) if rows.size == len(self.rows) else (self.x[rows], self.y[rows])

    def look_from_above(self, wanted: Bools) -> None:
        """Ask for gaps, and for the deepest pairs of atoms of unions that overlap."""
        new = np.flatnonzero(wanted & np.isnan(self.high))
        if new.size:
            self.high[new] = nearest(*self.part(new))
            apart = new[self.high[new] >= 0]
            self.low[apart], self.rows[apart] = self.high[apart], True


def _recalled(x: Proxy, y: Proxy) -> tuple[Array, Array]:
    (form_x, rows_x), (form_y, rows_y) = x.identity(), y.identity()
    kinds = type(x), type(y), form_x, form_y
    keys = [(*kinds, a.tobytes(), b.tobytes()) for a, b in zip(rows_x, rows_y, strict=True)]
    new = [i for i, key in enumerate(keys) if key not in _remembered]
    if new:
        found = _asked(x, y) if len(new) == len(keys) else _asked(x[new], y[new])
        for i, low, high in zip(new, *(side.tolist() for side in found), strict=True):
            _remembered[keys[i]] = low, high
    low, high = np.array([_remembered[key] for key in keys]).T
    while len(_remembered) > MOST_REMEMBERED:
        _remembered.popitem(last=False)
    return low, high


def _asked(x: Proxy, y: Proxy) -> tuple[Array, Array]:
    """Ask the reference: an overlap of unions is as deep as its deepest piece at least, and as a way out at most.

    Of composites it is their parts that are held against each other, as a certificate does and as engines do that are
    given so many bodies: the reference may know that these part later, but who tells the deepest is not wrong.
    """
    if not (isinstance(x, UNIONS) or isinstance(y, UNIONS)):
        found = distance(x, y)
        return found.distance, found.distance
    known = resolve(x, y)
    least = known.separation.distance
    depth = known.deepest if isinstance(x, Composite) or isinstance(y, Composite) else known.lower
    return least, np.where(least < 0, -depth, least)


def proven(x: Proxy, y: Proxy) -> tuple[Certificate, tuple[Bound, Bound]]:
    """Certificate of two single proxies, and the interval that the exact checker takes from it.

    Raises
    ------
    InvalidCertificate
        When the checker refuses the reference's own certificate.
    """
    key = (type(x), type(y), x.pack().tobytes(), y.pack().tobytes())
    if key not in _proven:
        certificate = certify(x, y)
        _proven[key] = certificate, check(certificate, x, y)
        if len(_proven) > MOST_PROVEN:
            _proven.popitem(last=False)
    return _proven[key]


def allows(lower: Bound, upper: Bound, value: float, error: float) -> bool:
    """Whether `value` lies in the proven interval, but for the error that the reference is allowed."""
    if math.isinf(value):
        return value == lower == upper or (value < 0 and lower == value)
    slack = Fraction(error)
    return lower - slack <= Fraction(value) <= upper + slack
