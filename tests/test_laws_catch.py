"""The laws themselves under test: each fails on a reference that is wrong on purpose, in the way that it forbids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from refimpl import bounds, collide, distance, intersect, raycast
from refimpl.results import CollisionData, RayHit, Separation
from refimpl.shapes import AABB, Box, Capsule, Composite, Cylinder, Point, Polyhedron, Proxy, Ray, Sphere
from tests import laws, test_laws, test_laws_bounds, test_laws_rays
from tests.conftest import name_of
from tests.laws import Span, span

AABB_OF, BALL_OF, SUPPORT_OF = bounds.aabb, bounds.bounding_sphere, bounds.support


def _of_one_order(a: Proxy, b: Proxy) -> Separation:
    found = distance(a, b)
    return replace(found, distance=found.distance * (1.0 + 4e-16 * (type(a).__name__ < type(b).__name__)))


def _shifted(by: Callable[[Proxy, Proxy, Span], float], low: float = 1.0, high: float = 1.0) -> Any:
    """A reference whose interval, or one end of it, is too far up."""

    def wrong(a: Proxy, b: Proxy) -> Span:
        found = span(a, b)
        more = by(a, b, found)
        return replace(found, low=found.low + low * more, high=found.high + high * more)

    return wrong


def _size(a: Proxy, b: Proxy) -> float:
    return laws.size_of(a, b)


crooked = _shifted(lambda a, b, found: 1e-6 * abs(float(found.normals[0, 0])) * _size(a, b))
with_an_epsilon = _shifted(lambda *_: 1e-9)
unlike_points = _shifted(lambda a, b, _: 0.0 if Point in (type(a), type(b)) else 7.0 * _size(a, b))
farther_when_larger = _shifted(lambda a, b, _: 3.0 * _size(a, b))
surer_than_it_can_be = _shifted(lambda a, b, found: found.low / 2 if found.low < 0 else 0.0, low=-1.0, high=3.0)
"""Of overlaps: a lower bound of the depth that is too large, above the depth itself."""


def blind_to_touching(a: Proxy, b: Proxy) -> Any:
    return intersect(a, b) & (distance(a, b).distance < -1e-2)


def _too_short(part: Callable[[CollisionData], Any]) -> Any:
    """Shifts that leave a part of the way."""

    def wrong(a: Proxy, b: Proxy, **masses: Any) -> CollisionData:
        found = collide(a, b, **masses)
        done = 1.0 - part(found)
        return replace(found, shift_a=done * found.shift_a, shift_b=done * found.shift_b)

    return wrong


by_a_billionth = _too_short(lambda _: 1e-9)
of_the_deepest_pair = _too_short(lambda found: 1.0 - found.least / found.depth if found.depth > 0 else 0.0)
"""The way out of the deepest pieces alone, which leaves others where they are."""

LAWS: dict[str, tuple[str, Any, Any, tuple[tuple[type, type], ...]]] = {
    "orders": ("distance", _of_one_order, test_laws.test_both_orders_agree_to_the_bit,
               ((Sphere, Box), (Box, Composite))),
    "isometries": ("span", crooked, test_laws.test_isometries_keep_the_distance,
                   ((Capsule, Cylinder), (Box, Polyhedron), (Composite, Composite))),
    "isometries of intervals": ("span", surer_than_it_can_be, test_laws.test_isometries_keep_the_distance,
                                ((Polyhedron, Composite),)),
    "scaling": ("span", with_an_epsilon, test_laws.test_scaling_scales_the_distance,
                ((Sphere, Box), (Sphere, Composite))),
    "detours": ("span", unlike_points, test_laws.test_no_detour_by_a_point_is_shorter,
                ((Capsule, Box), (Polyhedron, Polyhedron))),
    "growing": ("span", farther_when_larger, test_laws.test_growing_brings_nothing_farther,
                ((Point, Sphere), (Capsule, Box), (Box, Composite), (Polyhedron, Polyhedron))),
    "growing, hit": ("intersect", lambda a, b: intersect(a, b) & (a.magnitude + b.magnitude < 5.0),
                     test_laws.test_growing_brings_nothing_farther, ((Sphere, Box), (Polyhedron, Composite))),
    "sign": ("intersect", blind_to_touching, test_laws.test_intersect_has_the_sign_of_the_distance,
             ((Sphere, Box), (Sphere, Composite))),
    "free places": ("collide", by_a_billionth, test_laws.test_safe_positions_are_proven_free,
                    ((Sphere, Box), (Cylinder, Cylinder), (Sphere, Polyhedron))),
    "free places of all pieces": ("collide", of_the_deepest_pair,
                                  test_laws.test_safe_positions_are_proven_free, ((Sphere, Composite),)),
}  # fmt: skip


def _later(ray: Any, b: Any) -> RayHit:
    """A hit somewhat behind the surface."""
    found = raycast(ray, b)
    return replace(found, t=found.t * (1 + 1e-9))


def _through_the_small(ray: Any, b: Any) -> RayHit:
    """Misses what is small beside its place."""
    found = raycast(ray, b)
    solid = b if isinstance(ray, Ray) else ray
    small = float(np.max(solid.magnitude)) < 2.0
    return replace(found, hit=found.hit & (not small), t=np.where(small, np.inf, found.t))


def _of_one_ray_order(ray: Any, b: Any) -> RayHit:
    found = raycast(ray, b)
    return replace(found, t=found.t * (1.0 + 4e-16 * isinstance(ray, Ray)))


def _upright(ray: Any, b: Any) -> RayHit:
    """Sooner where the ray goes along the world's axis."""
    found = raycast(ray, b)
    return replace(found, t=found.t * (1 - 1e-7 * abs(ray.direction[2]) / np.abs(ray.direction).sum()))


def _with_a_least_time(ray: Any, b: Any) -> RayHit:
    found = raycast(ray, b)
    return replace(found, point=found.point + 1e-12)


def _late_if_large(ray: Any, b: Any) -> RayHit:
    found = raycast(ray, b)
    return replace(found, t=found.t + 0.5 * float(b.magnitude))


RAY_LAWS: dict[str, tuple[Any, Any]] = {
    "orders": (_of_one_ray_order, test_laws_rays.test_both_orders_agree_to_the_bit),
    "first point": (_later, test_laws_rays.test_a_hit_is_the_first_point_of_the_solid),
    "misses": (_through_the_small,
               test_laws_rays.test_a_hit_is_the_first_point_of_the_solid),
    "isometries": (_upright, test_laws_rays.test_isometries_keep_the_hit),
    "scaling": (_with_a_least_time,
                test_laws_rays.test_scaling_by_powers_of_two_keeps_the_time_to_the_bit),
    "growing": (_late_if_large, test_laws_rays.test_what_is_larger_is_hit_no_later),
}  # fmt: skip


def _narrow_box(shape: Proxy) -> AABB:
    box = AABB_OF(shape)
    return AABB(box.lower, box.upper - 1e-12 * (1.0 + np.abs(box.upper)))


def _small_ball(shape: Proxy) -> Sphere:
    ball = BALL_OF(shape)
    return Sphere(ball.center, ball.radius * 0.5)


BOUND_LAWS: dict[str, Any] = {
    "aabb": _narrow_box,
    "bounding_sphere": _small_ball,
    "support": lambda shape, n: SUPPORT_OF(shape, n) * (1 + 1e-12),
}


def _require_failure(tested: Any, pair: Any) -> None:
    """A law must fail; the search need not make its finding small."""
    brief = settings(max_examples=600, phases=(Phase.generate,))
    with pytest.raises(AssertionError):
        brief(given(data=st.data(), **tested.drawn_from)(tested.law))(pair=pair)


@pytest.mark.parametrize(("name", "pair"), [(name, pair) for name, row in LAWS.items() for pair in row[3]])
def test_a_law_of_pairs_catches_what_breaks_it(name: str, pair: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    part, wrong, tested, _ = LAWS[name]
    monkeypatch.setattr(test_laws, part, wrong)
    _require_failure(tested, pair)


@pytest.mark.parametrize("name", RAY_LAWS)
@pytest.mark.parametrize("kind", [Sphere, Cylinder, Polyhedron, Composite], ids=name_of)
def test_a_law_of_rays_catches_what_breaks_it(name: str, kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong, tested = RAY_LAWS[name]
    monkeypatch.setattr(test_laws_rays, "raycast", wrong)
    _require_failure(tested, (Ray, kind))


@pytest.mark.parametrize("part", BOUND_LAWS)
@pytest.mark.parametrize("kind", [Sphere, Box, Cylinder, Polyhedron, Composite], ids=name_of)
def test_the_law_of_bounds_catches_what_breaks_it(part: str, kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, part, BOUND_LAWS[part])
    tested = test_laws_bounds.test_bounding_volumes_contain_and_supports_agree.hypothesis.inner_test
    brief = settings(max_examples=600, phases=(Phase.generate,))
    with pytest.raises(AssertionError):
        brief(given(data=st.data(), direction=test_laws_bounds.UNIT)(tested))(kind=kind)
