"""The door: four questions about any two proxies, in either order, alone or in batches.

Here, and nowhere else, the arguments are put into the order of the pair table, batches are flattened and cut into
pieces that fit the processor's cache, and lengths are scaled by a power of two, which is exact, so that squares
neither overflow nor vanish.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeVar

import numpy as np

from refimpl.linear import Array, Bools, as_floats, largest, power_of_two, scale
from refimpl.pairs import TABLE, Rule
from refimpl.results import CollisionData, RayHit, Separation, where
from refimpl.shapes import Box, HalfSpace, Proxy, Ray, ShapeError, UnsupportedOperation

CHUNK = 1024

P = TypeVar("P", bound=Proxy)


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
    x, y = (b, a) if swapped else (a, b)
    rows_x, rows_y, batch = _rows(x, y)
    found = []
    for u, v, _ in _chunks(type(x), rows_x, type(y), rows_y):
        if isinstance(u, Ray):
            found.append(np.isfinite(rule.function(u, v)[0]))
        elif rule.meets is not None:
            found.append(rule.meets(*(_canonical(u, v)[:2] if type(u) is type(v) else (u, v))))
        else:
            found.append(_ordered(rule, u, v).distance <= 0)
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
    rule, swapped = _rule(a, b, "distance")
    x, y = (b, a) if swapped else (a, b)
    if isinstance(x, Ray):
        raise UnsupportedOperation(
            f"a Ray has no distance from a {type(y).__name__}: use raycast, or a Capsule of radius 0"
        )
    rows_x, rows_y, batch = _rows(x, y)
    parts = []
    for u, v, exponent in _chunks(type(x), rows_x, type(y), rows_y):
        found = _ordered(rule, u, v)
        with np.errstate(over="ignore", under="ignore"):  # what no double can hold becomes infinite, or 0
            on_a, on_b = (np.ldexp(w, exponent[:, None]) for w in (found.on_a, found.on_b))
            parts.append(Separation(np.ldexp(found.distance, exponent), on_a, on_b, found.normal))
    columns = [np.concatenate([getattr(p, n) for p in parts]) for n in ("distance", "on_a", "on_b", "normal")]
    whole = Separation(*(c.reshape(batch + c.shape[1:])[()] for c in columns))
    return whole.flipped() if swapped else whole


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
    found = distance(a, b)
    hit = found.distance <= 0
    depth = np.where(hit, 0.0 - found.distance, 0.0)
    heavier = np.maximum(wa, wb)
    share_b = (wb / heavier) / (wa / heavier + wb / heavier)
    ends = np.where(np.isfinite(depth), depth, np.nan)
    push_a, push_b = scale(-(1.0 - share_b) * ends, found.normal), scale(share_b * ends, found.normal)
    batch = np.shape(push_a)[:-1]
    hit = np.broadcast_to(hit, batch)
    moves = (where(hit, push, np.zeros_like(push))[()] for push in (push_a, push_b))
    normal, on_a, on_b = (np.broadcast_to(v, (*batch, 3)) for v in (found.normal, found.on_a, found.on_b))
    return CollisionData(hit[()], normal, np.broadcast_to(depth, batch)[()], on_a, on_b, *moves)


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
    x, y = (b, ray) if swapped else (ray, b)
    if not isinstance(x, Ray):
        raise UnsupportedOperation(f"raycast needs a Ray and a solid, got {type(ray).__name__} and {type(b).__name__}")
    rows_x, rows_y, batch = _rows(x, y)
    times, points, normals, exponents = [], [], [], []
    for u, v, exponent in _chunks(type(x), rows_x, type(y), rows_y):
        t, normal = rule.function(u, v)
        with np.errstate(over="ignore"):
            points.append(u.pack()[:, :3] + scale(np.where(np.isfinite(t), t, 0.0), u.pack()[:, 3:]))
        times.append(t)
        normals.append(normal)
        exponents.append(exponent)
    t, point, normal, exponent = (np.concatenate(parts) for parts in (times, points, normals, exponents))
    hit = np.isfinite(t)
    with np.errstate(over="ignore"):  # a time or place that no double can hold becomes infinite
        point = np.where(hit[:, None], np.ldexp(point, exponent[:, None]), np.nan)
        normal = np.where((hit & (t > 0))[:, None], normal, np.nan)
        t = np.ldexp(t, exponent - power_of_two(largest(rows_x[:, 3:])))
    return RayHit(*(np.asarray(c).reshape(batch + c.shape[1:])[()] for c in (hit, t, point, normal)))


def _rule(a: Proxy, b: Proxy, query: str) -> tuple[Rule, bool]:
    """Row of the table for these types, and whether they come in the other order."""
    for x in (a, b):
        if not isinstance(x, Proxy):
            raise TypeError(f"{query} needs two proxies, got {type(x).__name__}: {x!r}")
    pair = type(a), type(b)
    if pair in TABLE:
        return TABLE[pair], False
    if pair[::-1] in TABLE:
        return TABLE[pair[::-1]], True
    raise UnsupportedOperation(
        f"{query}: {pair[0].__name__} against {pair[1].__name__} is not a cell of the pair table"
    )


def _rows(x: Proxy, y: Proxy) -> tuple[Array, Array, tuple[int, ...]]:
    """Rows of numbers of both, broadcast to a common batch and flattened."""
    try:
        batch = np.broadcast_shapes(x.batch_shape, y.batch_shape)
    except ValueError:
        raise ShapeError(f"batch shapes {x.batch_shape} and {y.batch_shape} do not broadcast") from None
    packed = (np.broadcast_to(s.pack(), (*batch, type(s).width())).reshape(-1, type(s).width()) for s in (x, y))
    return *packed, batch  # type: ignore[return-value]


def _chunks(
    kind_x: type[Proxy], rows_x: Array, kind_y: type[Proxy], rows_y: Array
) -> Iterator[tuple[Proxy, Proxy, Array]]:
    """Pieces of the batch that fit the cache, scaled, with the exponent by which answers are scaled back."""
    for start in range(0, max(len(rows_x), 1), CHUNK):
        part = slice(start, start + CHUNK)
        x, y = kind_x._trusted(*kind_x._split(rows_x[part])), kind_y._trusted(*kind_y._split(rows_y[part]))
        yield _normalised(x, y)


def _normalised(x: P, y: Proxy) -> tuple[P, Proxy, Array]:
    """Both scaled by 2^−e, so that their largest number is about 1, and e."""
    exponent = power_of_two(np.maximum(x.magnitude, y.magnitude))
    return type(x)._trusted(*_times_power(x, -exponent)), type(y)._trusted(*_times_power(y, -exponent)), exponent


def _times_power(x: Proxy, exponent: Array) -> list[Array]:
    """Fields of `x` times 2^exponent, where they are lengths; a ray's direction and a normal are brought to about 1."""
    if isinstance(x, Ray):
        own = power_of_two(largest(x.direction))
        return [np.ldexp(x.origin, exponent[:, None]), np.ldexp(x.direction, -own[:, None])]
    if isinstance(x, HalfSpace):
        own = power_of_two(largest(x.normal))
        return [np.ldexp(x.normal, -own[:, None]), np.ldexp(x.k, exponent - own)]
    columns = type(x)._split(x.pack())
    for i in range(len(columns) - isinstance(x, Box)):  # a box's last field is its rotation
        columns[i] = np.ldexp(columns[i], exponent[:, None] if columns[i].ndim == 2 else exponent)
    return columns


def _canonical(x: P, y: P) -> tuple[P, P, Bools]:
    """Two proxies of one type in the order of their numbers, and whether that is the other order."""
    rows_x, rows_y = x.pack(), y.pack()
    first = np.argmax(rows_x != rows_y, axis=-1)[:, None]
    later = (np.take_along_axis(rows_x, first, axis=-1) > np.take_along_axis(rows_y, first, axis=-1))[:, 0]
    kind = type(x)
    u = kind._trusted(*kind._split(np.where(later[:, None], rows_y, rows_x)))
    v = kind._trusted(*kind._split(np.where(later[:, None], rows_x, rows_y)))
    return u, v, later


def _ordered(rule: Rule, x: Proxy, y: Proxy) -> Separation:
    """Apply a rule; two proxies of one type are first put in a canonical order, so that both orders agree."""
    if type(x) is not type(y):
        found: Separation = rule.function(x, y)
        return found
    u, v, later = _canonical(x, y)
    found = rule.function(u, v)
    back = found.flipped()
    names = ("distance", "on_a", "on_b", "normal")
    return Separation(*(where(later, getattr(back, n), getattr(found, n)) for n in names))


def _inverse_mass(name: str, value: Any) -> Array:
    mass = as_floats(value)
    if not np.all(np.isfinite(mass) & (mass >= 0)):
        raise ValueError(f"{name} must be finite and at least 0, got {mass.tolist()!r}")
    return mass
