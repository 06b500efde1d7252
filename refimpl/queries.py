"""The door: four questions about any two proxies, in either order, alone or in batches.

Here, and nowhere else, the arguments are put into the order of the pair table, batches are flattened and cut into
pieces that fit the processor's cache, and lengths are scaled by a power of two, which is exact, so that squares
neither overflow nor vanish.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain, pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from refimpl.compiling import batch_of
from refimpl.flat.pairs import TABLE as FLAT_TABLE
from refimpl.linear import Array, Bools, as_floats, largest, power_of_two, scale
from refimpl.pairs import CLOSED, TABLE, Rule
from refimpl.results import CollisionData, RayHit, Separation, where
from refimpl.shapes import Composite, Polyhedron, Proxy, Ray, ShapeError, UnsupportedOperation
from refimpl.shapes.polytope import Deriving
from refimpl.threads import in_threads, shares

CHUNK = 1024
UNIONS = (Composite, Polyhedron)

P = TypeVar("P", bound=Proxy)
R = TypeVar("R")
Columns = tuple[NDArray[Any], ...]


@np.errstate(under="ignore")
def intersect(a: Proxy, b: Proxy) -> Bools:
    """Whether two proxies have a point in common; touching counts.

    The cheapest test for the pair, often without a root: where the signed distance is within rounding of 0, its
    sign may differ from this answer.

    Parameters
    ----------
    a, b : proxies, in either order
        Their batch shapes broadcast against each other.

    Returns
    -------
    (...) bool
        The common batch shape.
    """
    rule, swapped = _rule(a, b, "intersect")
    x, y, batch = _flat(*((b, a) if swapped else (a, b)))

    def met(u: Proxy, v: Proxy, _: Array) -> Bools:
        if isinstance(u, Ray):
            return np.asarray(np.isfinite(rule.function(u, v)[0]))
        return _ordered(rule, u, v, False)[0] <= 0 if rule.meets is None else _meets(rule.meets, u, v)

    found = _in_parts(rule, x, y, rule.whole and rule.meets is None, met)
    return np.concatenate(found).reshape(batch)[()]


@np.errstate(under="ignore")
def distance(a: Proxy, b: Proxy) -> Separation:
    """Signed distance with witness points and normal.

    Parameters
    ----------
    a, b : solids, or a point and a solid, in either order
        Their batch shapes broadcast against each other.

    Returns
    -------
    Separation
        Positive: the gap; negative: minus the length of the shortest translation of `b` after which the two
        only touch. (a, b) and (b, a) answer the same distance to the last bit, and one row of a batch the same
        as the pair alone.

    Raises
    ------
    UnsupportedOperation
        For a ray (use `raycast`), and for two points or rays.
    """
    return _found(a, b, "distance", False)[0]


@np.errstate(under="ignore")
def collide(a: Proxy, b: Proxy, inverse_mass_a: Any = 1.0, inverse_mass_b: Any = 1.0) -> CollisionData:
    """Collision data: hit or not, normal, depth, contact points, and the way to overlap-free positions.

    Parameters
    ----------
    a, b : solids, or a point and a solid, in either order
    inverse_mass_a, inverse_mass_b : (...), at least 0
        Share out the shift; 0 is the immovable body. Not both may be 0.

    Returns
    -------
    CollisionData
        Moving A by `shift_a` and B by `shift_b` leaves them touching, up to rounding.
    """
    wa, wb = _inverse_mass("inverse_mass_a", inverse_mass_a), _inverse_mass("inverse_mass_b", inverse_mass_b)
    if np.any((wa == 0) & (wb == 0)):
        raise ValueError("inverse_mass_a and inverse_mass_b are both 0: two immovable bodies cannot be moved apart")
    found, least = _found(a, b, "collide", True)
    hit = found.distance <= 0
    depth = np.where(hit, 0.0 - found.distance, 0.0)
    heavier = np.maximum(wa, wb)
    share_b = (wb / heavier) / (wa / heavier + wb / heavier)
    ends = np.where(np.isfinite(depth), depth, np.nan)
    push_a, push_b = scale(-(1.0 - share_b) * ends, found.normal), scale(share_b * ends, found.normal)
    batch = np.shape(push_a)[:-1]
    hit = np.broadcast_to(hit, batch)
    moves = (where(hit, push, np.zeros_like(push))[()] for push in (push_a, push_b))
    normal, on_a, on_b = (np.broadcast_to(v, push_a.shape) for v in (found.normal, found.on_a, found.on_b))
    depth, least = (np.broadcast_to(length, batch)[()] for length in (depth, least))
    return CollisionData(hit[()], normal, depth, least, on_a, on_b, *moves)


@np.errstate(under="ignore")
def raycast(ray: Ray, b: Proxy) -> RayHit:
    """First point of a solid on a ray; both argument orders are understood.

    Parameters
    ----------
    ray : Ray
    b : a solid

    Returns
    -------
    RayHit
        A grazing ray hits. t = 0, without a normal, when the ray starts inside.
    """
    rule, swapped = _rule(ray, b, "raycast")
    x, y, batch = _flat(*((b, ray) if swapped else (ray, b)))
    if not isinstance(x, Ray):
        raise UnsupportedOperation(f"raycast needs a Ray and a solid, got {type(ray).__name__} and {type(b).__name__}")

    def hit_at(u: Ray, v: Proxy, exponent: Array) -> Columns:
        t, normal = rule.function(u, v)
        with np.errstate(over="ignore"):
            return t, u.at(np.where(np.isfinite(t), t, 0.0)), normal, exponent

    parts = _in_parts(rule, x, y, rule.whole, hit_at)
    t, point, normal, exponent = (np.concatenate(column) for column in zip(*parts, strict=True))
    hit = np.isfinite(t)
    with np.errstate(over="ignore"):  # a time or place that no double can hold becomes infinite
        point = np.where(hit[:, None], np.ldexp(point, exponent[:, None]), np.nan)
        normal = np.where((hit & (t > 0))[:, None], normal, np.nan)
        t = np.ldexp(t, exponent - power_of_two(largest(x.direction)))
    return RayHit(*(np.asarray(c).reshape(batch + c.shape[1:])[()] for c in (hit, t, point, normal)))


def _rule(a: Proxy, b: Proxy, query: str) -> tuple[Rule, bool]:
    """Row of the table for these types, and whether they come in the other order."""
    for x in (a, b):
        if not isinstance(x, Proxy):
            raise TypeError(f"{query} needs two proxies, got {type(x).__name__}: {x!r}")
    pair = type(a), type(b)
    table = TABLE if a.dimension == 3 else FLAT_TABLE
    if pair in table:
        return table[pair], False
    if pair[::-1] in table:
        return table[pair[::-1]], True
    raise UnsupportedOperation(
        f"{query}: {pair[0].__name__} against {pair[1].__name__} is not a cell of the pair table"
    )


def _found(a: Proxy, b: Proxy, query: str, bounded: bool) -> tuple[Separation, Array]:
    """Signed distance; and a length below which no translation separates, which means nothing unless `bounded`."""
    rule, swapped = _rule(a, b, query)
    x, y, batch = _flat(*((b, a) if swapped else (a, b)))
    if isinstance(x, Ray):
        raise UnsupportedOperation(
            f"a Ray has no distance from a {type(y).__name__}: use raycast, or a Capsule of radius 0"
        )

    def answered(u: Proxy, v: Proxy, exponent: Array) -> Columns:
        return _scaled_back(_ordered(rule, u, v, bounded), exponent)

    parts = _in_parts(rule, x, y, rule.whole, answered)
    *columns, least = (
        np.concatenate(column).reshape((*batch, *column[0].shape[1:]))[()] for column in zip(*parts, strict=True)
    )
    found = Separation(*columns)
    return found.flipped() if swapped else found, least


def _in_parts(rule: Rule, x: P, y: Proxy, whole: bool, answer: Callable[[P, Proxy, Array], R]) -> list[R]:
    """What is answered for the chunks of a batch, in their order; by several threads where a search takes the time."""

    def answered(some: slice) -> list[R]:
        return [answer(u, v, exponent) for u, v, exponent in _chunks(x[some], y[some], whole)]

    with batch_of(len(x)):
        found = in_threads(answered, [slice(None)] if rule.exactness == CLOSED else shares(len(x)))
    return list(chain.from_iterable(found))


def _meets(meets: Callable[[Any, Any], Bools], x: Proxy, y: Proxy) -> Bools:
    """Apply a cheaper test, in the same order as the distance where both types are the same."""
    if type(x) is not type(y):
        return meets(x, y)
    (found,) = _by_order(_later(x, y), lambda u, v: (meets(u, v),), x, y)
    return found


def _scaled_back(columns: Columns, exponent: Array) -> Columns:
    """Lengths times 2^exponent; what no double can hold becomes infinite, or 0."""
    distance, on_a, on_b, normal, least = columns
    with np.errstate(over="ignore", under="ignore"):
        on_a, on_b = (np.ldexp(w, exponent[:, None]) for w in (on_a, on_b))
        return np.ldexp(distance, exponent), on_a, on_b, normal, np.ldexp(least, exponent)


def _flat(x: P, y: Proxy) -> tuple[P, Proxy, tuple[int, ...]]:
    """Both with one batch axis, of the same length, and the common batch shape."""
    try:
        batch = np.broadcast_shapes(x.batch_shape, y.batch_shape)
    except ValueError:
        raise ShapeError(f"batch shapes {x.batch_shape} and {y.batch_shape} do not broadcast") from None
    for shape in (x, y):
        if isinstance(shape, Deriving) and shape.derives_first:
            shape.derived()  # once, for all slices of the batch, and kept for the next question
    return x.broadcast_to(batch).flattened(), y.broadcast_to(batch).flattened(), batch


def _chunks(x: P, y: Proxy, whole: bool) -> Iterator[tuple[P, Proxy, Array]]:
    """Pieces of the batch that fit the cache, scaled, with the exponent by which answers are scaled back.

    The largest number of each pair is brought to about 1. Some rules do that themselves and take the batch `whole`. So
    do unions: their pieces come through this door again, one by one.
    """
    rows = len(x)
    if whole or isinstance(x, UNIONS) or isinstance(y, UNIONS):
        still = power_of_two(np.zeros(rows))
        yield (x.times_power(still) if isinstance(x, Ray) else x), y, still
        return
    pieces = max(-(-rows // CHUNK), 1)
    ends = [rows * i // pieces for i in range(pieces + 1)]
    for start, end in pairwise(ends):
        u, v = (x, y) if pieces == 1 else (x[start:end], y[start:end])
        exponent = power_of_two(np.maximum(u.magnitude, v.magnitude))
        yield u.times_power(-exponent), v.times_power(-exponent), exponent


def _ordered(rule: Rule, x: Proxy, y: Proxy, bounded: bool) -> Columns:
    """Apply a rule; two proxies of one type are first put in a canonical order, so that both orders agree."""
    if type(x) is not type(y) or rule.symmetric:
        return _columns(rule, x, y, bounded)
    later = _later(x, y)
    distance, on_x, on_y, normal, least = _by_order(later, lambda u, v: _columns(rule, u, v, bounded), x, y)
    on_a, on_b = where(later, on_y, on_x), where(later, on_x, on_y)
    return distance, on_a, on_b, where(later, -normal, normal), least


def _columns(rule: Rule, x: Proxy, y: Proxy, bounded: bool) -> Columns:
    """What a rule answers: distance, witness points, normal, and, if `bounded`, the least length of a way out."""
    if bounded and rule.bounds is not None:
        found, least = rule.bounds(x, y)
    else:
        found = rule.function(x, y)
        least = np.maximum(-found.distance, 0.0)
    return found.distance, found.on_a, found.on_b, found.normal, least


def _later(x: Proxy, y: Proxy) -> Bools:
    """Where the first of two proxies of one type comes later in the order of their forms and numbers."""
    (form_x, rows_x), (form_y, rows_y) = x.identity(), y.identity()
    if form_x != form_y:
        return np.full(len(x), repr(form_x) > repr(form_y))
    later, equal = np.zeros(len(x), dtype=bool), np.ones(len(x), dtype=bool)
    for u, v in zip(rows_x.T, rows_y.T, strict=True):  # nearly always the first column decides
        later |= equal & (u > v)
        equal &= u == v
        if not equal.any():
            break
    return later


def _by_order(later: Bools, function: Callable[[Any, Any], Columns], x: Proxy, y: Proxy) -> Columns:
    """Columns that a function answers for (y, x) in the rows that are `later`, and for (x, y) in all others."""
    if not later.any():
        return function(x, y)
    if later.all():
        return function(y, x)
    straight, turned = function(x[~later], y[~later]), function(y[later], x[later])
    columns = []
    for u, v in zip(straight, turned, strict=True):
        column = np.empty(later.shape + u.shape[1:], dtype=u.dtype)
        column[~later], column[later] = u, v
        columns.append(column)
    return tuple(columns)


def _inverse_mass(name: str, value: Any) -> Array:
    mass = as_floats(value)
    if not np.all(np.isfinite(mass) & (mass >= 0)):
        raise ValueError(f"{name} must be finite and at least 0, got {mass.tolist()!r}")
    return mass
