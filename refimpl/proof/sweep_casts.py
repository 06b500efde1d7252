"""When a translation brings two convex proxies together: a ray cast against their Minkowski difference.

A rests and B moves by v, so they meet when t·v lies in A ⊖ B. A supporting plane of A ⊖ B tells a time before which
they do not meet; points of A ⊖ B whose hull the ray enters tell a time when they do. Each step asks for the farthest
point beyond the plane through the last three, which takes the place of one of them: a simplex method whose columns
are support points (van den Bergen 2004; Snethen 2008). On polytopes it ends at the time itself, for everything is in
integers; on round ones it ends when the times are as near to each other as is asked for.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any, NamedTuple

from refimpl.proof.bodies import Mix
from refimpl.proof.exact import Vertex, smallest
from refimpl.proof.points import AXES, ZERO, Vector, along, dot, exact, minus, opposite, rationals, root
from refimpl.proof.rays import Hit, tube
from refimpl.proof.rays_curved import cylinder, ellipsoid
from refimpl.proof.rays_polytopes import entry, shares_of
from refimpl.proof.reaches import Pairs, Reach
from refimpl.shapes import Cylinder, Ellipsoid, HalfSpace, Point, Proxy

NARROW = Fraction(1, 1 << 46)
"""Of the time from 0 to 1: an interval as narrow is narrow enough for round proxies."""
STEPS = 250
EARLY = Fraction(1, 1 << 80)  # of a time: so much before a graze there is a plane that leaves a gap until then
SHORTLY = (46, 40, 32, 24, 16, 8, 2)  # bits of a time: so near to a graze a plane is looked for
MOST = 9  # points that are kept while the time stays what it is
FINE = 120  # bits of the times at which features are asked for

Ends = tuple[tuple[Vector, Mix], tuple[Vector, Mix]]


class Miss(NamedTuple):
    """A plane across `normal`, from A to B, keeps them apart at all times."""

    normal: Vector


class Contact(NamedTuple):
    """The first contact is at a time from `low` to `high`.

    Up to `low` a plane across `normal`, from A to B, keeps them apart; at `high` the `ends`, a point of A and one of B
    where they are at the start, are in one place.
    """

    low: Fraction
    normal: Vector
    high: Fraction
    ends: Ends


class Near(NamedTuple):
    """Points of A ⊖ B as seen from a path, their weights, and a direction to it; zero if they carry a point of it."""

    carriers: list[Vertex]
    weights: Sequence[int]
    normal: Vector


class Undecided(Exception):
    """They come so near to each other that it takes too long to tell whether they touch."""


def approach(pairs: Pairs, path: Sequence[Vector], nearest: bool = False) -> Near:
    """Points of A ⊖ B whose hull comes near to a path, and a direction, from A ⊖ B to it, of a plane between them.

    The path is the hull of one or two points. The search of Gilbert, Johnson and Keerthi (1988) ends with the first
    plane that leaves a gap, wider than what round proxies are drawn in; or, to find the `nearest` points of a polytope,
    when no plane leaves a wider one.
    """

    def beyond(n: Vector) -> Vertex:
        vertex, end = pairs.support(n), min(path, key=lambda p: dot(n, p))
        return vertex._replace(y=minus(vertex.y, end))

    simplex = [beyond(opposite(pairs.way) if any(pairs.way) else AXES[0])]
    for _ in range(STEPS):
        simplex, weights, direction = smallest(simplex)
        if not any(direction):
            return Near(simplex, weights, ZERO)
        new = beyond(opposite(direction))
        height = dot(direction, new.y)
        if height >= dot(direction, simplex[0].y) if nearest else _is_beyond(direction, height, pairs.slack) > 0:
            return Near(simplex, weights, opposite(direction))
        simplex.append(new)
    raise Undecided


def flat(pairs: Pairs, narrow: Fraction = Fraction(0)) -> Contact | Miss:
    """First contact of proxies that are apart at the start, by their support points alone."""
    near = approach(pairs, [ZERO, pairs.way])
    if any(near.normal):
        return Miss(near.normal)
    if not any(pairs.way):
        return _inside(pairs)
    chosen = list({v.y: v for v in map(_itself, near.carriers)}.values())
    low, best = Fraction(-1), ZERO
    last: Fraction | None = None
    for step in range(STEPS):
        time, across, found = entry([v.y for v in chosen], pairs.way)
        new = pairs.support(opposite(across))
        drawn = pairs.slack * root(Fraction(dot(across, across)))[1] if pairs.slack else 0
        bound = Fraction(dot(across, new.y) - drawn) / dot(across, pairs.way)
        low, best = max((low, best), (bound, opposite(across)), key=lambda pair: pair[0])
        known = {v.y: v for v in chosen}
        held = [known[y] for y in found]
        if time < 0:
            return _inside(pairs)
        if time - low <= narrow or step == STEPS - 1:
            return Contact(min(low, time), best, time, pairs.mean(held, shares_of(found, pairs.way)))
        recent = chosen[-MOST:] if time == last else []  # lest it goes round
        chosen = list({v.y: v for v in (*held, *recent, new)}.values())
        last = time
    raise Undecided


def _inside(pairs: Pairs) -> Contact:
    """Contact at the start."""
    near = approach(pairs, [ZERO])
    if any(near.normal):
        raise Undecided
    return Contact(Fraction(0), ZERO, Fraction(0), pairs.mean(near.carriers, near.weights))


def pointed(point: Point, shape: Cylinder | Ellipsoid, way: Vector) -> Contact | Miss:
    """First contact of a point that rests and a round proxy that moves: where the point, as a ray, enters."""
    origin, course = rationals(point.position), opposite(way)
    hit = (cylinder if isinstance(shape, Cylinder) else ellipsoid)(origin, course, shape)  # type: ignore[arg-type]
    if not isinstance(hit, Hit):
        return Miss(hit.normal)
    low, n = hit.low, hit.normal(hit.low)
    if dot(n, way) >= 0:
        low = low * (1 - EARLY)
        n = hit.normal(low)
    return Contact(low, n, hit.high, ((origin, ()), (along(origin, hit.high, course), ())))


def _itself(vertex: Vertex) -> Vertex:
    """A point of A ⊖ B as it is."""
    return vertex._replace(y=minus(vertex.a, vertex.b))


def clear_until(pairs: Pairs, time: Fraction) -> Iterator[tuple[Fraction, Vector]]:
    """Times shortly before one, with planes that leave a gap until then: the later, the fewer are found."""
    for bits in SHORTLY:
        early = time * (1 - Fraction(1, 1 << bits))
        with suppress(Undecided):
            near = approach(pairs, [ZERO, along(ZERO, early, pairs.way)])
            if any(near.normal):
                yield early, near.normal


def rounded(pairs: Pairs, radius: Fraction) -> Contact | Miss:
    """First contact of polytopes, of which `pairs` is the difference, widened by balls of together this radius.

    The nearest feature of the difference decides: a corner or an edge, around which the ray meets a capsule, or a
    facet. It is the one that is nearest at a time before the contact, up to which planes have shown that there is none.
    """
    room = radius * pairs.unit
    start = _touching(pairs, [Fraction(0)], radius)
    if start is not None:
        return Contact(Fraction(0), ZERO, *start)
    near = approach(pairs, [ZERO, pairs.way], nearest=True)
    if _is_beyond(near.normal, -dot(near.normal, near.carriers[0].y), room) > 0:
        return Miss(near.normal)
    low = Fraction(0)
    for _ in range(STEPS):
        near = approach(pairs, [along(ZERO, low, pairs.way)], nearest=True)
        hit = _feature([_itself(v).y for v in near.carriers], pairs.way, room, near.normal)
        if hit is not None and low <= hit.high <= 1:
            n = opposite(hit.normal(hit.low))
            if dot(n, pairs.way) == 0:  # it grazes; no plane that leaves a gap before leaves one until then
                hit = hit._replace(low=hit.low * (1 - EARLY))
                n = opposite(hit.normal(hit.low))
            gap = hit.low * dot(n, pairs.way) - dot(n, pairs.support(n).y)
            ends = _touching(pairs, [hit.high, hit.within], radius) if _is_beyond(n, gap, room) >= 0 else None
            if ends is not None:
                return Contact(hit.low, n, *ends)
        rate = dot(near.normal, pairs.way)
        if rate >= 0:
            return Miss(near.normal)
        length = root(Fraction(dot(near.normal, near.normal)))[1]
        later = (dot(near.normal, pairs.support(near.normal).y) + room * length) / rate
        low, before = Fraction(int(later * (1 << FINE)), 1 << FINE), low
        if low <= before:
            break
    raise Undecided


def _is_beyond(n: Vector, height: Any, room: Any) -> int:
    """Sign of how much farther than `room` along a direction a plane is, whose height is given in its length."""
    if height < 0 or not any(n):
        return -1
    beyond = height * height - room * room * dot(n, n)
    return int(beyond > 0) - int(beyond < 0)


def _feature(points: Sequence[Vector], way: Vector, room: Fraction, n: Vector) -> Hit | None:
    """When the ray from 0 comes within a distance of a corner, an edge or a facet's plane across n."""
    if len(points) < 3:
        return tube(exact(ZERO), exact(way), exact(points[0]), exact(points[-1]), room)
    rate = dot(n, way)
    if rate >= 0:
        return None
    least, most = root(Fraction(dot(n, n)))
    level = dot(n, points[0])
    early, late = (Fraction(level + room * length) / rate for length in (most, least))
    return Hit(early, late, late, lambda _: opposite(n))


def _touching(pairs: Pairs, times: Sequence[Fraction], radius: Fraction) -> tuple[Fraction, Ends] | None:
    """The first of some times at which they meet, with a point of both between the nearest points of the cores.

    There is none where the ray comes to a facet's plane beside the facet.
    """
    for late in times:
        near = approach(pairs, [along(ZERO, late, pairs.way)], nearest=True)
        (x, mix), (y, other) = pairs.mean(near.carriers, near.weights)
        shift = along(ZERO, Fraction(late) / pairs.unit, pairs.way)
        across = minus(along(y, 1, shift), x)
        if dot(across, across) <= radius * radius:
            on_a = along(x, pairs.reaches[0].body.radius / radius, across)
            return late, ((on_a, mix), (minus(on_a, shift), other))
    return None


def landing(half: HalfSpace, other: Proxy, way: Vector) -> Contact | Miss:
    """First contact of a half-space that rests and another proxy that moves: its lowest point lands."""
    n, k = rationals(half.normal), Fraction(half.k.tolist())
    point, mix, slack = _lowest(other, n)
    height, rate = dot(n, point) + k, -dot(n, way)
    if height <= 0:
        return Contact(Fraction(0), ZERO, Fraction(0), ((point, ()), (point, mix)))
    if height - slack > 0 >= rate:
        return Miss(tuple(half.normal.tolist()))
    if rate <= 0:
        raise Undecided
    low, high = (height - slack) / rate, height / rate
    return Contact(low, tuple(half.normal.tolist()), high, ((along(point, high, way), ()), (point, mix)))


def _lowest(shape: Proxy, n: Vector) -> tuple[Vector, Mix, Fraction]:
    """Least far point along n, its corner if it is one, and how much less far at most the proxy reaches, times ‖n‖."""
    if not isinstance(shape, HalfSpace):
        return Reach(shape, True).extreme(opposite(n))
    m = rationals(shape.normal)  # the opposite direction, for half-spaces that are apart
    return along(ZERO, -Fraction(shape.k.tolist()) / dot(m, m), m), (), Fraction(0)
