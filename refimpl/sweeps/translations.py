"""The first contact of convex proxies in translation.

Only the relative translation matters: A rests, B moves by v. Where A ⊖ B is a proxy, and the contact so the hit of a
ray, the ray is cast; the others advance by planes. A plane that leaves a gap between A and B shows that they do not
meet until its own gap has closed; the next plane is taken at that time. This is Newton's method for the root of the
signed distance, a convex function of time: it comes from the left and never passes the first contact (van den Bergen
2004; Mirtich and Canny 1995). When B no longer comes nearer to a plane, there is no contact at all.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from refimpl.algorithms.nearest import nearest_on_segment
from refimpl.bounds import aabb
from refimpl.linear import Array, Bools, dot, largest, norm, power_of_two, scale, unit_or
from refimpl.motions import Motion, Translation
from refimpl.queries import distance, raycast
from refimpl.results import SweepHit, where
from refimpl.shapes import AABB, Capsule, Point, Proxy, Ray, Sphere
from refimpl.sweeps.overlaps import common_points

STEPS = 80
"""Planes; a contact that grazes takes one for each bit of its time."""
DOUBT = 2.0**-46
"""Part of the scene by which two proxies may be apart in doubles and in truth touch, and more."""
GRAZE = 2.0**-11
"""Part of its speed at which B comes nearer to A, at a contact that doubles do not tell well."""
LATER = 64.0
"""So many times `DOUBT` deep they should be, soon after they meet."""
ROUNDING = 2.0**-50
"""Part of the scene by which two proxies may overlap in doubles and in truth be apart."""


class Advance(NamedTuple):
    """What is found for each row: see `SweepHit`, with the point and the normal where A rests.

    In doubt is whether two proxies that come as near as rounding errors touch, or when; then this is their nearest
    approach in doubles.
    """

    t: Array
    point: Array
    normal: Array
    t_lower: Array
    doubtful: Bools

    def at(self, rows: Any) -> Advance:
        """What is found for some rows."""
        return Advance(*(column[rows] for column in self))


def sweep_translation(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> SweepHit:
    """First contacts of convex proxies in translation; everything with one batch axis, of the same length.

    Where doubles do not tell whether two proxies touch that pass each other, exact numbers do.
    """
    found, doubtful = in_doubles(x, y, motion_x, motion_y)
    return decided(found, doubtful, x, y, motion_x, motion_y)


def in_doubles(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> tuple[SweepHit, Bools]:
    """First contacts of convex proxies in translation, and which of them are in doubt: those may be none, or later."""
    assert isinstance(motion_x, Translation)
    assert isinstance(motion_y, Translation)
    found = advance(x, y, motion_y.vector - motion_x.vector)
    hit = np.isfinite(found.t)
    with np.errstate(over="ignore"):
        point = found.point + scale(np.where(hit, found.t, 0.0), motion_x.vector)
    start = np.flatnonzero(found.t == 0)
    if len(start):
        point[start] = common_points(x[start], y[start])
    normal = where(found.t > 0, found.normal, np.full(3, np.nan))
    return SweepHit(hit, found.t, point, normal, found.t_lower), found.doubtful


def decided(found: SweepHit, doubtful: Bools, x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> SweepHit:
    """What exact numbers tell of the rows in doubt; contact, where they do not tell either."""
    from refimpl.proof.sweep_search import certify_sweep  # noqa: PLC0415  it needs `advance`

    if not np.any(doubtful):
        return found
    hit, t, early = np.array(found.hit), np.array(found.t), np.array(found.t_lower)
    point, normal = np.array(found.point), np.array(found.normal)
    for i in np.flatnonzero(doubtful):
        proof = certify_sweep(x[i], y[i], motion_x[i], motion_y[i])
        early[i] = float(proof.lower)
        if proof.lower > 1:
            hit[i], t[i], point[i], normal[i] = False, np.inf, np.nan, np.nan
        elif proof.upper <= 1:
            hit[i], t[i] = True, float(proof.upper)
            point[i], normal[i] = _touching(x[i], y[i], motion_x[i], motion_y[i], t[i])
    return SweepHit(hit, t, point, normal, early)


def _touching(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion, t: float) -> tuple[Array, Array]:
    """Point and normal of a contact at a time; no normal at the start."""
    u, v = motion_x.placed(x, t), motion_y.placed(y, t)
    if t == 0:
        return common_points(u[None], v[None])[0], np.full(u.dimension, np.nan)
    near = distance(u, v)
    return 0.5 * (near.on_a + near.on_b), near.normal


def doubts(found: SweepHit, x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> Bools:
    """Which contacts in translation rounding may have made, or moved."""
    assert isinstance(motion_x, Translation)
    assert isinstance(motion_y, Translation)
    way = motion_y.vector - motion_x.vector
    size = np.maximum(np.maximum(x.magnitude, y.magnitude), largest(way))
    shallow = _shallow(found.t, found.normal, x, y, way, size)
    start = np.flatnonzero(found.t == 0)
    if len(start):
        shallow[start] = distance(x[start], y[start]).distance > -ROUNDING * size[start]
    return shallow


def advance(x: Proxy, y: Proxy, way: Array) -> Advance:
    """First contacts of convex proxies with one batch axis, of which `x` rests and `y` moves by `way` (N, 3).

    Lengths are scaled by a power of two, which is exact, so that no place overflows.
    """
    exponent = power_of_two(np.maximum(np.maximum(x.magnitude, y.magnitude), largest(way)))
    found = _advanced(x.times_power(-exponent), y.times_power(-exponent), np.ldexp(way, -exponent[:, None]))
    with np.errstate(over="ignore"):
        return found._replace(point=np.ldexp(found.point, exponent[:, None]))


def _advanced(x: Proxy, y: Proxy, way: Array) -> Advance:
    cast: Cast | None = _point if isinstance(x, Point) else CASTS.get((type(x), type(y)))
    if cast is None:
        return _by_planes(x, y, way)
    moving = np.any(way != 0, axis=-1)
    if not moving.all():  # a ray has a direction
        found = _nothing(len(x))
        for rows, function in ((moving, _advanced), (~moving, _by_planes)):
            if rows.any():
                _put(found, np.flatnonzero(rows), function(x[rows], y[rows], way[rows]))
        return found
    found = cast(x, y, way)
    missed = np.flatnonzero(~np.isfinite(found.t))
    if len(missed):  # planes tell how nearly
        near = _by_planes(x[missed], y[missed], way[missed])
        _put(found, missed[near.doubtful], near.at(near.doubtful))
    return found


def _nothing(count: int) -> Advance:
    never, nowhere = np.full(count, np.inf), np.full((count, 3), np.nan)
    return Advance(never, nowhere, nowhere.copy(), never.copy(), np.zeros(count, dtype=bool))


def _put(found: Advance, rows: Any, part: Advance) -> None:
    for column, values in zip(found, part, strict=True):
        column[rows] = values


# ----------------------------------------------------------------------------------------- by planes


def _by_planes(x: Proxy, y: Proxy, way: Array) -> Advance:
    """Newton's method on the signed distance."""
    found = _nothing(len(x))
    size = np.maximum(np.maximum(x.magnitude, y.magnitude), largest(way))
    active, t, least = np.arange(len(x)), np.zeros(len(x)), np.full(len(x), np.inf)
    for _ in range(STEPS):
        w = way[active]
        apart = distance(x[active], y[active].translated(scale(t[active], w)))
        gap, speed = apart.distance, -dot(apart.normal, w)
        met, nearer = gap <= 0, gap < least[active]
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            later = np.where(speed > 0, t[active] + gap / speed, np.inf)
            early = later - DOUBT * size[active] / speed
        rows = active[nearer]  # the nearest so far, with the last plane that left a gap
        least[rows], found.t[rows] = gap[nearer], t[rows]
        found.point[rows] = 0.5 * (apart.on_a + apart.on_b)[nearer]
        rows = active[nearer & ~met]
        found.normal[rows], found.t_lower[rows] = apart.normal[nearer & ~met], early[nearer & ~met]
        gone = ~met & (later > 1)
        found.doubtful[active[gone]] = least[active[gone]] <= DOUBT * size[active[gone]]
        found.doubtful[active[met]] = (speed <= GRAZE * norm(w))[met]
        going = ~met & ~gone & (later > t[active])
        t[active] = np.where(going, later, t[active])
        _forget(found, active[gone & ~found.doubtful[active]])
        active = active[going]
        if not len(active):
            break
    found.doubtful[active] = True
    shallow = _shallow(found.t, found.normal, x, y, way, size)
    found.doubtful[:] = np.where(found.t == 0, least > -ROUNDING * size, found.doubtful | shallow)
    found.t_lower[:] = np.where(found.t > 0, np.clip(found.t_lower, 0.0, found.t), found.t)
    return found


def _shallow(t: Array, normal: Array, x: Proxy, y: Proxy, way: Array, size: Array) -> Bools:
    """Whether what meets does not overlap a little later by more than rounding, as it would at such a speed."""
    meets = np.isfinite(t) & (t > 0)
    with np.errstate(invalid="ignore"):
        speed = -dot(normal, way)
        shallow = meets & (speed <= GRAZE * norm(way))
    rows = np.flatnonzero(meets & ~shallow)
    if len(rows):
        later = t[rows] + LATER * DOUBT * size[rows] / speed[rows]
        depth = -distance(x[rows], y[rows].translated(scale(later, way[rows]))).distance
        shallow[rows] = depth < DOUBT * size[rows]
    return shallow


def _forget(found: Advance, rows: Any) -> None:
    """Nothing is found in some rows."""
    _put(found, rows, _nothing(len(rows)))


# ------------------------------------------------------------------------------------------ by rays


def _ray(ray: Ray, solid: Proxy) -> tuple[Array, Array, Array, Bools]:
    """Times up to 1 of a ray's first hits, the inward normal, a time that is surely earlier, and whether it grazes."""
    found = raycast(ray, solid)
    t = np.where(found.t <= 1, found.t, np.inf)
    size = np.maximum(np.maximum(ray.magnitude, solid.magnitude), largest(ray.direction))
    speed = np.abs(dot(found.normal, ray.direction))
    with np.errstate(divide="ignore", invalid="ignore"):
        early = np.where((t > 0) & (t <= 1), np.maximum(t - DOUBT * size / speed, 0.0), t)
    grazes = np.isfinite(t) & (t > 0) & (speed <= GRAZE * norm(ray.direction))
    return t, -found.normal, early, grazes


def _answer(t: Array, point: Array, normal: Array, early: Array, grazes: Bools) -> Advance:
    hit = np.isfinite(t)
    nowhere = np.full(3, np.nan)
    return Advance(t, where(hit, point, nowhere), where(hit & (t > 0), normal, nowhere), early, grazes)


def _point(x: Point, y: Proxy, way: Array) -> Advance:
    """A point against any solid: it is itself the ray."""
    t, normal, early, grazes = _ray(Ray(x.position, -way), y)
    return _answer(t, x.position, normal, early, grazes)


def _round(center: Array, radius: Array, core: Callable[[Array], Array], grown: Proxy, way: Array) -> Advance:
    """A ball against a proxy that is a core widened by a ball: its centre against the one grown by its radius."""
    t, normal, early, grazes = _ray(Ray(center, -way), grown)
    shift = scale(np.where(np.isfinite(t), t, 0.0), way)
    straight, apart = unit_or(core(center - shift) + shift - center, np.zeros(3))
    reach = np.minimum(radius, apart)
    return _answer(t, center + where(t > 0, scale(radius, normal), scale(reach, straight)), normal, early, grazes)


def _sphere_sphere(x: Sphere, y: Sphere, way: Array) -> Advance:
    return _round(x.center, x.radius, lambda _: y.center, Sphere(y.center, x.radius + y.radius), way)


def _sphere_capsule(x: Sphere, y: Capsule, way: Array) -> Advance:
    grown = Capsule(y.p, y.q, x.radius + y.radius)
    return _round(x.center, x.radius, lambda centre: nearest_on_segment(centre, y.p, y.q), grown, way)


def _aabb_aabb(x: AABB, y: AABB, way: Array) -> Advance:
    """Two boxes: the origin against their difference."""
    lower, upper = y.lower - x.upper, y.upper - x.lower
    t, normal, early, grazes = _ray(Ray(np.zeros_like(way), -way), AABB(lower, upper))
    shift = scale(np.where(np.isfinite(t), t, 0.0), way)
    low, high = np.maximum(x.lower, y.lower + shift), np.minimum(x.upper, y.upper + shift)
    return _answer(t, 0.5 * (low + high), normal, early, grazes)


Cast: TypeAlias = Callable[[Any, Any, Array], Advance]
CASTS: dict[tuple[type[Proxy], type[Proxy]], Cast] = {
    (Sphere, Sphere): _sphere_sphere,
    (Sphere, Capsule): _sphere_capsule,
    (AABB, AABB): _aabb_aabb,
}
"""Pairs of solids whose difference is a proxy."""


def earliest(x: Proxy, y: Proxy, motion_x: Motion, motion_y: Motion) -> Array:
    """Times before which boxes around bounded proxies in translation do not meet; inf for never."""
    assert isinstance(motion_x, Translation)
    assert isinstance(motion_y, Translation)
    way = motion_y.vector - motion_x.vector
    u, v = (AABB(s.position, s.position) if isinstance(s, Point) else aabb(s) for s in (x, y))
    slack = DOUBT * np.maximum(np.maximum(u.magnitude, v.magnitude), norm(way))[:, None]
    grown = AABB(v.lower - u.upper - slack, v.upper - u.lower + slack)
    still = np.all(way == 0, axis=-1)
    found = raycast(Ray(np.zeros_like(way), np.where(still[:, None], 1.0, -way)), grown)
    return np.where((found.t <= 1) & (~still | (found.t == 0)), found.t, np.inf)
