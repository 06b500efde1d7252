"""The checker alone: known answers, its two trusted facts against sampling, and certificates tampered with."""

from __future__ import annotations

import ast
import math
import sys
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf  # type: ignore[import-untyped]

from refimpl.linear import rotation_matrix
from refimpl.proof import (
    Certificate,
    Claim,
    Common,
    Core,
    Escape,
    InvalidCertificate,
    Near,
    Separated,
    certify,
    check,
    checker,
    rational,
    reading,
    sets,
    vectors,
)
from refimpl.shapes import AABB, KDOP, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Point, Proxy, Ray, Sphere
from tests.truth import ray_interval, signed_distance

INF = math.inf
CUBE = AABB((-1, -1, -1), (1, 1, 1))
FAR_CUBE = AABB((3, -1, -1), (5, 1, 1))
NEAR_CUBE = AABB((0, -1, -1), (2, 1, 1))
TURNED = Box((0.25, 0.5, 0), (1, 2, 0.5), (1, 2, 3, 4))
BALL = Sphere((0, 0, 0), 1)
FAR_BALL = Sphere((3, 4, 0), 2)
FLOOR = HalfSpace((0, 0, 2), 2)
ROD = Capsule((-1, 0, 0), (1, 0, 0), 0.5)
RAY = Ray((-4, 0, 0), (2, 0, 0))
MISSING_RAY = Ray((-4, 3, 0), (2, 0, 0))
TETRAHEDRON = ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2))
"""The faces of the regular tetrahedron (1,1,1), (1,−1,−1), (−1,1,−1), (−1,−1,1), seen from outside."""
CORNERS = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))


def one(claim: Claim, a: Any, b: Any) -> tuple[Any, Any]:
    """Bounds from a single claim."""
    return check(Certificate((claim,)), a, b)


def at_origin(*points: tuple[float, ...]) -> tuple[Any, ...]:
    """Pairs of points of A with B's point at 0."""
    return tuple((p, (0, 0, 0)) for p in points)


# ---- the file ----------------------------------------------------------------------------------------------


OF_SETS = ("checker", "claims", "bounds", "gaps", "unions", "reading", "sets", "rational", "vectors")
OF_PLANE = ("plane",)
OF_IMPACTS = ("impacts", "impact_law")
OF_SWEEPS = ("sweeps", "rigid", "rigid_poses", "rigid_reach", "triangles", "polynomials")
TRUSTED = OF_SETS + OF_PLANE + OF_IMPACTS + OF_SWEEPS


def test_the_trusted_files_need_only_the_standard_library_and_stay_small() -> None:
    folder = Path(str(checker.__file__)).parent
    sources = {name: (folder / f"{name}.py").read_text(encoding="utf-8") for name in TRUSTED}
    assert max(len(source.splitlines()) for source in sources.values()) <= 450
    names = set()
    for node in [node for source in sources.values() for node in ast.walk(ast.parse(source))]:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            names.add(str(node.module))
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in {"__import__", "exec", "eval"}
    assert "fractions" in names
    others = names - {f"refimpl.proof.{name}" for name in TRUSTED}
    assert {name.split(".")[0] for name in others} <= set(sys.stdlib_module_names)


# ---- known answers -----------------------------------------------------------------------------------------

KNOWN = [
    (Separated((1, 0, 0)), CUBE, FAR_CUBE, (2, INF)),
    (Separated((3, 0, 0)), CUBE, FAR_CUBE, (2, INF)),
    (Separated((-1, 0, 0)), FAR_CUBE, CUBE, (2, INF)),
    (Separated((3, 4, 0)), BALL, FAR_BALL, (2, INF)),
    (Separated((0, 0, 1)), FLOOR, BALL.translated((0, 0, 2)), (2, INF)),
    (Separated((0, 0, -0.1)), BALL.translated((0, 0, 2)), FLOOR, (2, INF)),
    (Separated((0, 0, 1)), FLOOR, HalfSpace((0, 0, -0.5), 1), (3, INF)),
    (Escape((1, 0, 0)), CUBE, NEAR_CUBE, (-1, INF)),
    (Escape((0, 1, 0)), CUBE, NEAR_CUBE, (-2, INF)),
    (Escape((1, 0, 0)), CUBE, CUBE.translated((2, 0, 0)), (0, INF)),
    (Escape((3, 4, 0)), BALL, Sphere((3, 4, 0), 6), (-2, INF)),
    (Escape((0, 0, 1)), FLOOR, BALL, (0, INF)),
    (Escape((0, 0, 1)), FLOOR, BALL.translated((0, 0, -2)), (-2, INF)),
    (Escape((0, 0, 7)), ROD, ROD, (-1, INF)),
    (Near((1, 0, 0), (3, 0, 0)), CUBE, FAR_CUBE, (-INF, 2)),
    (Near((1, 0.5, 0.5), (3, 0.5, 0.5)), CUBE, FAR_CUBE, (-INF, 2)),
    (Near((0, 0, 0), (3, 0, 0)), BALL, FAR_CUBE, (-INF, 3)),
    (Near((2, 0, 0), (3, 0, 0)), CUBE, FAR_CUBE, (-INF, 2)),  # 1 outside: 1 + 1
    (Near((0, 0, -1), (1, 2, 1)), FLOOR, Point((0, 2, 1)), (-INF, 4)),  # 1 outside: 3 + 1
    (Common((1, 0, 0)), CUBE, NEAR_CUBE, (-INF, 0)),
    (Common((3, 0, 0)), CUBE, NEAR_CUBE, (-INF, 3)),  # 2 and 1 outside
    (Common((2, 0, 0)), BALL, Sphere((0, 0, 0), 0.5), (-INF, 2.5)),  # 1 and 1.5 outside
    (Core((((0, 0, 0), (3, 4, 0)),)), BALL, Sphere((3, 4, 0), 4), (-INF, 0)),
    (Core(at_origin((0, 0, 0))), BALL, Sphere((0, 0, 0), 2), (-INF, -3)),
    (Core((((0, 0, 0), (3, 4, 0)),)), BALL, Sphere((3, 4, 0), 6), (-INF, -2)),
    (Core((((0, 0, 0), (0, 0, 0)),)), ROD, ROD, (-INF, -1)),
    (Core((((0, 0, 0), (0.25, 0, 0)),)), BALL, Sphere((0, 0, 0), 2), (-INF, -2.5)),  # excess and distance
    (Separated((1, 0, 0), 0), RAY, CUBE, (0, INF)),
    (Separated((1, 0, 0), 1), RAY, CUBE, (1, INF)),
    (Separated((1, 0, 0), 1.5), RAY, CUBE, (1.5, INF)),  # reaches the face just then
    (Separated((-1, 0, 0), 1.5), CUBE, RAY, (1.5, INF)),
    (Separated((0, -1, 0)), MISSING_RAY, CUBE, (INF, INF)),
    (Separated((0, 1, 0)), CUBE, MISSING_RAY, (INF, INF)),
    (Separated((0, -1, 0), 7), MISSING_RAY, CUBE, (7, INF)),
    (Common(None, 1.5), RAY, CUBE, (0, 1.5)),
    (Common(None, Fraction(3, 2)), CUBE, RAY, (0, 1.5)),
    (Common(None, 0), Ray((0, 0, 0), (1, 2, 3)), BALL, (0, 0)),
    (Common(None, 2), Ray((0, 0, 5), (0, 0, -3)), FLOOR, (0, 2)),
]


@pytest.mark.parametrize(("claim", "a", "b", "bounds"), KNOWN)
def test_known_bounds(claim: Claim, a: Proxy, b: Proxy, bounds: tuple[Any, Any]) -> None:
    proven = one(claim, a, b)
    assert proven == bounds
    assert all(isinstance(bound, Fraction) or math.isinf(bound) for bound in proven)


def test_a_polytope_proves_the_distance_of_its_nearest_plane() -> None:
    claim = Core(at_origin(*CORNERS), TETRAHEDRON)
    depth = -one(claim, CUBE, Point((0, 0, 0)))[1]
    assert Fraction(1, 3) - Fraction(1, 2**150) < depth**2 < Fraction(1, 3)
    assert one(claim, CUBE, BALL)[1] == -depth - 1
    inverted = tuple(((0, 0, 0), (-x, -y, -z)) for x, y, z in CORNERS)
    assert one(Core(inverted, TETRAHEDRON), BALL, CUBE)[1] == -depth - 1
    flatter = Core((*at_origin(*CORNERS[:3]), ((-1, -1, 0.5), (0, 0, 0))), TETRAHEDRON)
    assert 0 < -one(flatter, CUBE, Point((0, 0, 0)))[1] < depth


def test_irrational_bounds_are_enclosed_to_many_digits() -> None:
    lower, upper = check(
        Certificate((Separated((1, 1, 1)), Near((0, 0, 0), (1, 1, 1)))), Point((0, 0, 0)), Point((1, 1, 1))
    )
    assert lower**2 < 3 < upper**2
    assert upper - lower < Fraction(1, 2**150)


def test_half_spaces_overlap_without_end_unless_they_are_opposite() -> None:
    wall = HalfSpace((1, 0, 0), 0)
    ways = tuple((w, (0, 0, 0)) if w[2] <= 0 else ((-1, w[1], 0), (-1 - w[0], 0, -w[2])) for w in CORNERS)
    for (u, v), w in zip(ways, CORNERS, strict=True):
        assert tuple(x - y for x, y in zip(u, v, strict=True)) == w
    claim = Core(ways, TETRAHEDRON, directions=True)
    assert one(claim, FLOOR, wall) == (-INF, -INF)
    with pytest.raises(InvalidCertificate, match="unbounded"):
        one(claim, FLOOR, HalfSpace((0, 0, -1), 0))
    with pytest.raises(InvalidCertificate, match="unbounded"):
        one(claim, FLOOR, CUBE)
    with pytest.raises(InvalidCertificate):  # the same as points is another claim
        one(replace(claim, directions=False), FLOOR, CUBE)


def test_claims_work_together_and_believed_bounds_are_ignored() -> None:
    claims = (Escape((0, 1, 0)), Escape((1, 0, 0)), Common((1, 0, 0)), Near((0, 0, 0), (2, 0, 0)))
    assert check(Certificate(claims, lower=5.0, upper=-5.0), CUBE, NEAR_CUBE) == (-1, 0)
    assert check(Certificate((), lower=5.0, upper=6.0), CUBE, NEAR_CUBE) == (-INF, INF)


# ---- the two trusted facts of each type ----------------------------------------------------------------------


def exact(vector: Any) -> tuple[Fraction, ...]:
    return tuple(Fraction(x) for x in np.asarray(vector).tolist())


def grid_of(shape: Proxy, steps: int) -> list[tuple[Fraction, ...]]:
    """Points all over the core of a shape, its corners among them, from its definition."""
    ends = [Fraction(2 * i - steps, steps) for i in range(steps + 1)]
    match shape:
        case Point() | Sphere():
            return [exact(shape.reference_point)]
        case Capsule():
            p, q = exact(shape.p), exact(shape.q)
            return [tuple(((1 - t) * x + (1 + t) * y) / 2 for x, y in zip(p, q, strict=True)) for t in ends]
        case AABB():
            low, high = exact(shape.lower), exact(shape.upper)
            sides = [[((1 - t) * x + (1 + t) * y) / 2 for t in ends] for x, y in zip(low, high, strict=True)]
            return list(product(*sides))
        case Box():
            c, h = exact(shape.center), exact(shape.half_extents)
            q = exact(shape.rotation)
            return [
                tuple(x + y for x, y in zip(c, turned(q, [t * e for t, e in zip(ts, h, strict=True)]), strict=True))
                for ts in product(ends, repeat=3)
            ]
    raise AssertionError(shape)


def turned(q: tuple[Fraction, ...], v: list[Fraction]) -> list[Fraction]:
    """The vector part of q v q⁻¹, by two quaternion products."""

    def times(p: list[Fraction], r: list[Fraction]) -> list[Fraction]:
        (a, b, c, d), (e, f, g, h) = p, r
        return [
            d * e + a * h + b * g - c * f,
            d * f - a * g + b * h + c * e,
            d * g + a * f - b * e + c * h,
            d * h - a * e - b * f - c * g,
        ]

    length = sum(x * x for x in q)
    x, y, z, w = q
    *rest, real = times(times([x, y, z, w], [*v, Fraction(0)]), [-x / length, -y / length, -z / length, w / length])
    assert real == 0
    return rest


SOLIDS = [
    Point((0.5, -0.25, 2)),
    Sphere((0.1, 0.2, 0.3), 0.7),
    Capsule((0, 1, 2), (3, -1, 0.5), 0.25),
    Capsule((1, 1, 1), (1, 1, 1), 0.25),
    AABB((-1, 0, 0.5), (2, 0.25, 3)),
    AABB((-1, 0, 0.5), (2, 0, 3)),
    Box((1, 0, -1), (0.5, 1.5, 0.25), (0.3, -0.2, 0.9, 0.1)),
    Box((1, 0, -1), (0, 1.5, 0), (1, 2, -3, 5)),
]


def square(u: Any, v: Any) -> Fraction:
    return sum(((x - y) ** 2 for x, y in zip(u, v, strict=True)), Fraction(0))


@pytest.mark.parametrize("shape", SOLIDS, ids=lambda s: type(s).__name__)
def test_support_and_distance_agree_with_points_all_over_the_shape(shape: Proxy) -> None:
    body = reading.read(shape)
    assert isinstance(body, sets.Product)
    assert body.radius == Fraction(float(getattr(shape, "radius", 0.0)))
    steps = 8
    points = grid_of(shape, steps)
    spread = max(square(p, points[0]) for p in points)
    assert all(body.square_distance(p) == 0 for p in points)
    rng = np.random.default_rng(5)
    for _ in range(20):
        n = [int(x) for x in rng.integers(-9, 10, 3)]
        assert body.support(n) == max(sum(c * x for c, x in zip(n, p, strict=True)) for p in points)
        away = exact(rng.normal(size=3) * 3)
        nearest = min(square(away, p) for p in points)
        proven = body.square_distance(away)
        assert proven <= nearest  # no point of the shape is nearer than the checker says,
        slack = math.sqrt(spread) * math.sqrt(3) / steps  # and one is about as near
        assert math.sqrt(nearest) <= math.sqrt(proven) + slack
        assert proven > 0 or len(points) > 1


CURVED = [
    Ellipsoid((0.5, -1, 2), (0.5, 1.5, 3), (1, 2, 3, 4)),
    Ellipsoid((0.5, -1, 2), (1e-9, 1.5, 1.5), (1, 2, 3, 4)),
    Cylinder((0.5, -1, 2), (1, 2, 4), 0.75),
    Cylinder((0.5, -1, 2), (0.5, -1, 2.125), 3),
]


def points_of(shape: Any, rng: np.random.Generator, count: int) -> Any:
    """Points all over the surface of an ellipsoid or a cylinder, in floats."""
    u = rng.normal(size=(count, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    if isinstance(shape, Ellipsoid):
        return shape.center + (u * shape.radii) @ rotation_matrix(shape.rotation).T
    way = (shape.q - shape.p) / np.linalg.norm(shape.q - shape.p)
    across, places = np.cross(u, way), rng.choice([0.0, 0.25, 1.0], count)[:, None]
    sizes = np.where(places[:, 0] == 0.25, 1.0, rng.choice([1.0, 0.5], count)) / np.linalg.norm(across, axis=1)
    return shape.p + places * (shape.q - shape.p) + shape.radius * sizes[:, None] * across


@pytest.mark.parametrize("shape", CURVED, ids=lambda s: type(s).__name__)
def test_support_and_membership_agree_with_points_all_over_the_curved(shape: Proxy) -> None:
    solid, rng = reading.read(shape), np.random.default_rng(6)
    assert isinstance(solid, sets.Product)
    points = points_of(shape, rng, 4000)
    middle = shape.reference_point
    for _ in range(20):
        n = [int(x) for x in rng.integers(-9, 10, 3)]
        height, highest = solid.support(n), float(np.max(points @ n))
        assert highest - 1e-12 <= height <= highest + 0.05 * (1 + abs(height))
    for point in points[:60]:
        inner, outer = (middle + f * (point - middle) for f in (1 - 1e-6, 1.25))
        assert solid.member(inner.tolist())[1] == 0
        found, outside = solid.member(outer.tolist())
        assert found == list(exact(outer))
        assert 0 < outside <= 0.25 * np.linalg.norm(point - middle) * (1 + 1e-6)  # as far as it is from `point`
        away = (outer - middle) / np.linalg.norm(outer - middle)
        size = [int(2**40 * c) for c in away]
        gap = float(sum(c * x for c, x in zip(size, found, strict=True)) - solid.support(size)) / np.linalg.norm(size)
        assert float(outside) >= gap * (1 - 1e-9)  # and no less than from a plane that has all of the shape behind it


def test_known_supports_and_members_of_the_curved() -> None:
    egg = reading.read(Ellipsoid((1, 0, 0), (2, 3, 6), (0, 0, 0, 1)))
    assert egg.support([3, 0, 0]) == 9
    assert egg.support([0, 1, 0]) == 3
    assert egg.support([3, 2, 0]) ** 2 > 0
    assert egg.member((3, 0, 0))[1] == 0
    assert egg.member((4, 0, 0))[1] == 1
    assert egg.member((1, 0, -6.5))[1] == Fraction(1, 2)
    can = reading.read(Cylinder((0, 0, 1), (0, 0, 5), 2))
    assert can.support([0, 0, 1]) == 5
    assert can.support([3, 4, 0]) == 10
    assert can.support([0, 0, -2]) == -2
    assert can.member((0, 2, 5))[1] == 0
    assert can.member((0, 5, 9))[1] == 5
    assert can.member((0, 0, 0.5))[1] == Fraction(1, 2)
    ball = reading.read(Ellipsoid((1, 0, 0), (2, 2, 2), (1, 2, 3, 4)))
    assert isinstance(ball, sets.Product)
    assert (ball.factors, ball.radius) == ([], 2)


def test_a_thin_ellipsoid_is_left_by_no_more_than_it_is_thick() -> None:
    """A double's last bit is much, next to a thickness of 1e-9; moving across the sheet mends it."""
    sheet = reading.read(Ellipsoid((0, 0, 0), (1, 1, 1e-9), (0, 0, 0, 1)))
    assert 0 < sheet.member((0.5, 0.5, 1e-9))[1] < 4e-10
    assert 0 < sheet.member((0.6, 0.8 + 1e-12, 0))[1] < 2e-12


def test_positive_semidefinite_matrices_are_told_from_others() -> None:
    rng = np.random.default_rng(2)
    for rank in range(5):
        for _ in range(10):
            rows = rng.integers(-3, 4, (rank, 4)).tolist()
            gram = [[Fraction(sum(row[i] * row[j] for row in rows)) for j in range(4)] for i in range(4)]
            assert vectors.is_positive(gram)
            k = int(rng.integers(4))
            gram[k][k] -= gram[k][k] + Fraction(1, 10**30)
            assert not vectors.is_positive(gram)
    assert not vectors.is_positive([[Fraction(0), Fraction(1)], [Fraction(1), Fraction(5)]])


def test_support_and_distance_of_unbounded_shapes() -> None:
    body = reading.read(HalfSpace((1, 2, -2), 0.75))
    assert isinstance(body, sets.Planes)
    assert body.support([2, 4, -4]) == Fraction(-3, 2)
    for n in ([-1, -2, 2], [1, 2, -1], [1, 0, 0]):
        with pytest.raises(InvalidCertificate, match="unbounded"):
            body.support(n)
    assert body.square_distance(exact((1, 2, -2))) == Fraction(39, 12) ** 2
    assert body.square_distance(exact((-1, -2, 2))) == 0
    ray = reading.read(Ray((1, 2, 3), (0, 0, 2)))
    assert isinstance(ray, sets.Line)
    assert ray.support([1, 0, 0]) == 1
    assert ray.support([1, 0, -1]) == -2
    with pytest.raises(InvalidCertificate, match="unbounded"):
        ray.support([1, 0, 1])


# ---- tampering: refused ----------------------------------------------------------------------------------------

BOXES = (TURNED, Box((1, 0.25, 0.5), (0.75, 1, 1.25), (0.1, 0.2, 0.3, 0.4)))
DEPTH = certify(*BOXES)
POLYTOPE = next(claim for claim in DEPTH.claims if isinstance(claim, Core))
FIRST, *OTHERS = POLYTOPE.triangles
HIT = certify(RAY, FAR_BALL.translated((0, -4, 0)))

REFUSED: dict[str, tuple[Any, Any, Any]] = {
    "missing facet": (replace(POLYTOPE, triangles=tuple(OTHERS)), *BOXES),
    "flipped facet": (replace(POLYTOPE, triangles=(FIRST[::-1], *OTHERS)), *BOXES),
    "facet twice": (replace(POLYTOPE, triangles=(FIRST, *POLYTOPE.triangles)), *BOXES),
    "inside out": (replace(POLYTOPE, triangles=tuple(t[::-1] for t in POLYTOPE.triangles)), *BOXES),
    "collapsed facet": (
        replace(POLYTOPE, triangles=((FIRST[0], FIRST[0], FIRST[1]), *POLYTOPE.triangles)),
        *BOXES,
    ),
    "no facet": (replace(POLYTOPE, triangles=()), *BOXES),
    "index beyond the pairs": (replace(POLYTOPE, triangles=((0, 1, len(POLYTOPE.pairs)), *OTHERS)), *BOXES),
    "negative index": (replace(POLYTOPE, triangles=((-1, 1, 2), *OTHERS)), *BOXES),
    "index true": (replace(POLYTOPE, triangles=((True, 0, 2), *OTHERS)), *BOXES),
    "index 1.0": (Core(POLYTOPE.pairs, ((1.0, 0, 2), *OTHERS)), *BOXES),  # type: ignore[arg-type]
    "short facet": (Core(POLYTOPE.pairs, ((0, 1), *OTHERS)), *BOXES),  # type: ignore[arg-type]
    "polytope of others": (POLYTOPE, BOXES[1], BOXES[0]),
    "polytope beside 0": (
        Core(at_origin(*[(x + 3, y, z) for x, y, z in CORNERS]), TETRAHEDRON),
        NEAR_CUBE,
        CUBE,
    ),
    "0 on a facet": (Core(at_origin((0, 1, 0), (0, -1, 1), (0, -1, -1), (1, 0, 0)), TETRAHEDRON), CUBE, CUBE),
    "pair too far apart": (Core((((0, 0, 0), (3, 4, 0)),)), BALL, Sphere((3, 4, 0), 3.999999)),
    "pair of separate points": (Core((((1, 0, 0), (3, 0, 0)),)), CUBE, FAR_CUBE),
    "no pair": (Core(()), BALL, BALL),
    "separated backwards": (Separated((-1, 0, 0)), CUBE, FAR_CUBE),
    "separated, shapes swapped": (Separated((1, 0, 0)), FAR_CUBE, CUBE),
    "separated though touching": (Separated((1, 0, 0)), CUBE, CUBE.translated((2, 0, 0))),
    "separated though overlapping": (Separated((1, 0, 0)), CUBE, NEAR_CUBE),
    "separated across": (Separated((0, 1, 0)), CUBE, FAR_CUBE),
    "separated by a last bit": (Separated((3, 4, 0)), BALL, Sphere((3, 4, 0), math.nextafter(4.0, 5.0))),
    "escape though separated": (Escape((1, 0, 0)), CUBE, FAR_CUBE),
    "half-space's normal turned": (Separated((1e-300, 0, 1)), FLOOR, BALL.translated((0, 0, 2))),
    "half-space's normal turned back": (Escape((0, 0, -1)), FLOOR, BALL),
    "zero direction": (Escape((0, 0, 0)), CUBE, CUBE),
    "until on a solid": (Separated((1, 0, 0), 1), CUBE, FAR_CUBE),
    "time on a solid": (Common((0, 0, 0), 1), CUBE, CUBE),
    "time alone on a solid": (Common(None, 1), CUBE, CUBE),
    "nothing in common": (Common(None), CUBE, CUBE),
    "hit a millionth early": (Common(None, 1.5 * (1 - 1e-6)), RAY, CUBE),
    "hit a last bit early": (Common(None, math.nextafter(1.5, 0)), RAY, CUBE),
    "hit after it left": (Common(None, 2.6), RAY, CUBE),
    "hit before the start": (Common(None, -3), Ray((0, 0, 0), (1, 0, 0)), CUBE.translated((-3, 0, 0))),
    "free a millionth too long": (Separated((1, 0, 0), 1.5 * (1 + 1e-6)), RAY, CUBE),
    "free a last bit too long": (Separated((1, 0, 0), math.nextafter(1.5, 2)), RAY, CUBE),
    "free for ever": (Separated((1, 0, 0)), RAY, CUBE),
    "free along a face": (Separated((0, -1, 0)), Ray((-4, 1, 0), (2, 0, 0)), CUBE),
    "free along a face for a while": (Separated((0, -1, 0), 2), Ray((-4, 1, 0), (2, 0, 0)), CUBE),
    "free before the start": (Separated((1, 0, 0), -1), RAY, CUBE),
    "free backwards": (Separated((-1, 0, 0), 1), RAY, CUBE),
    "free, shapes swapped": (Separated((1, 0, 0), 1), CUBE, RAY),
    "escape of a ray": (Escape((1, 0, 0)), RAY, CUBE),
    "escape of a ray, backwards": (Escape((-1, 0, 0)), RAY, CUBE),
    "nearness of a ray": (Near((-4, 0, 0), (-1, 0, 0)), RAY, CUBE),
    "core of a ray": (Core((((-1, 0, 0), (-1, 0, 0)),)), RAY, CUBE),
    "point of a ray": (Common((0, 0, 0)), RAY, CUBE),
    "two rays": (Separated((0, -1, 0)), MISSING_RAY, RAY),
    "bounded directions": (Core(at_origin(*CORNERS), TETRAHEDRON, directions=True), CUBE, CUBE),
}


@pytest.mark.parametrize("name", REFUSED)
def test_false_claims_are_refused(name: str) -> None:
    claim, a, b = REFUSED[name]
    with pytest.raises(InvalidCertificate):
        one(claim, a, b)


def test_every_facet_matters() -> None:
    """What the polytope certificate shows for all of its facets, it shows for no smaller set of them."""
    assert one(POLYTOPE, *BOXES)[1] < 0
    for i in range(len(POLYTOPE.triangles)):
        triangles = POLYTOPE.triangles[:i] + POLYTOPE.triangles[i + 1 :]
        with pytest.raises(InvalidCertificate, match="not closed"):
            one(replace(POLYTOPE, triangles=triangles), *BOXES)


# ---- tampering: an honest, weaker bound --------------------------------------------------------------------------


def test_a_moved_witness_widens_the_bound_by_how_far_it_is_outside() -> None:
    claim = Near((1, 0, 0), (3, 0, 0))
    assert one(claim, CUBE, FAR_CUBE) == (-INF, 2)
    for step in (1e-16, 1e-6, 1.0, 1e9):
        moved = replace(claim, a=(1 + step, 0, 0))
        assert one(moved, CUBE, FAR_CUBE)[1] >= 2
    above = replace(claim, a=(1, 0, 1.5))
    assert one(above, CUBE, FAR_CUBE)[1] == Fraction(5, 2) + Fraction(1, 2)
    assert one(Common((1.5, 0, 0)), CUBE, CUBE.translated((2, 0, 0))) == (-INF, Fraction(1, 2))


def test_a_last_bit_outside_is_no_failure() -> None:
    """Doubles cannot hit a turned box's corner: the excess is tiny, and is counted."""
    corner = [float(x) for x in grid_of(TURNED, 1)[0]]
    _, upper = one(Common((corner[0], corner[1], corner[2])), TURNED, TURNED)
    assert 0 < upper < Fraction(1, 2**50)


def test_a_tilted_direction_weakens_the_bound() -> None:
    for tilt in (1e-9, 1e-3, 0.5):
        assert 0 < one(Separated((1, tilt, 0)), CUBE, FAR_CUBE)[0] < 2
        assert one(Escape((1, tilt, 0)), CUBE, NEAR_CUBE)[0] < -1


def test_a_polytope_blown_up_by_a_millionth_proves_less() -> None:
    """Its vertices leave the shapes by more than its facets gain."""
    sigma = signed_distance(*BOXES)
    for factor in (1 + 1e-6, 1 + 1e-3):
        blown: Any = tuple((tuple(factor * x for x in p), q) for p, q in POLYTOPE.pairs)
        upper = one(replace(POLYTOPE, pairs=blown), *BOXES)[1]
        assert mpf(upper.numerator) / upper.denominator > sigma
        assert upper > one(POLYTOPE, *BOXES)[1]


def test_a_certificate_proves_the_truth_of_whatever_it_is_checked_against() -> None:
    """The shapes decide: one a millionth larger or smaller gets its own bounds, or none."""
    for grown in (1 - 1e-6, 1 + 1e-6):
        a = Box(TURNED.center, TURNED.half_extents * grown, TURNED.rotation)
        try:
            lower, upper = check(DEPTH, a, BOXES[1])
        except InvalidCertificate:
            continue
        encloses(lower, upper, signed_distance(a, BOXES[1]))
    lower, upper = check(certify(BALL, FAR_BALL), BALL, Sphere(FAR_BALL.center, 2 * (1 - 1e-6)))
    encloses(lower, upper, signed_distance(BALL, Sphere(FAR_BALL.center, 2 * (1 - 1e-6))))


def encloses(lower: Any, upper: Any, truth: mpf) -> None:
    """Assert lower ≤ truth ≤ upper, the truth being known to 58 digits."""
    with mp.workdps(80):
        slack = abs(truth) * mpf(10) ** -55 if mp.isfinite(truth) else mpf(0)
        low, high = (mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mpf(x) for x in (lower, upper))
        assert low <= truth + slack
        assert high >= truth - slack


# ---- nonsense ------------------------------------------------------------------------------------------------

NONSENSE = [
    math.nan,
    INF,
    -INF,
    None,
    "1",
    "",
    True,
    1j,
    [],
    (1, 2),
    {},
    object(),
    np.array([1.0, 2.0]),
    10 ** (rational.MAX_BITS // 3),
    Fraction(1, 10 ** (rational.MAX_BITS // 3)),
]


@pytest.mark.parametrize("bad", NONSENSE, ids=[type(x).__name__ + str(i) for i, x in enumerate(NONSENSE)])
def test_nonsense_is_refused_wherever_it_stands(bad: Any) -> None:
    vector, point = (0, bad, 1), ((0, 0, 0), (0, bad, 0))
    claims: list[Any] = [
        Separated(vector),
        Separated(bad),
        Escape(vector),
        Escape(bad),
        Near(vector, (0, 0, 0)),
        Near((0, 0, 0), bad),
        Common(vector),
        Common(bad),
        Core((point,)),
        Core((bad,)),
        Core(bad),
        Core((((0, 0, 0), (0, 0, 0)),), (bad,)),
        Core((((0, 0, 0), (0, 0, 0)),), ((0, 0, bad),)),
        Core((((0, 0, 0), bad),)),
        bad,
    ]
    for claim in claims:
        with pytest.raises(InvalidCertificate):
            one(claim, BALL, BALL)
    for claim in (
        Separated((1, 0, 0), bad) if bad is not None else Escape((1, 0, 0)),
        Common(None, bad),
        bad,
    ):
        with pytest.raises(InvalidCertificate):
            one(claim, RAY, CUBE)
    with pytest.raises(InvalidCertificate):
        check(bad, BALL, BALL)


def test_too_much_is_refused() -> None:
    many = rational.MAX_ITEMS + 1
    pair = ((0, 0, 0), (0, 0, 0))
    with pytest.raises(InvalidCertificate, match="items"):
        one(Core((pair,) * many), BALL, BALL)
    with pytest.raises(InvalidCertificate, match="items"):
        check(Certificate((Common((0, 0, 0)),) * many), BALL, BALL)
    size = 1 << rational.MAX_BITS - 1
    parts = [[Fraction(1, size + i)] for i in range(12)]
    with pytest.raises(InvalidCertificate, match="denominator"):
        rational.whole(parts)
    pairs = tuple((tuple(Fraction(1, size + 3 * i + j) for j in range(3)), (0, 0, 0)) for i in range(4))
    with pytest.raises(InvalidCertificate, match="too much work"):
        one(Core(pairs, TETRAHEDRON), CUBE, CUBE)


class Pretender:
    """Looks like a shape by its fields."""

    def __init__(self, **numbers: Any) -> None:
        for name, value in numbers.items():
            setattr(self, name, np.array(value))


BAD_SHAPES: dict[str, list[dict[str, Any]]] = {
    "Sphere": [
        {"center": (0, 0, 0), "radius": -1.0},
        {"center": (0, 0, 0), "radius": math.nan},
        {"center": (0, 0, INF), "radius": 1.0},
        {"center": (0, 0), "radius": 1.0},
        {"center": ((0, 0, 0), (1, 1, 1)), "radius": (1.0, 1.0)},
        {"center": (0, 0, 0)},
    ],
    "Capsule": [{"p": (0, 0, 0), "q": (0, 0, 0), "radius": -1e-300}],
    "AABB": [{"lower": (0, 0, 1), "upper": (1, 1, 0)}],
    "Box": [
        {"center": (0, 0, 0), "half_extents": (1, 1, -1), "rotation": (0, 0, 0, 1)},
        {"center": (0, 0, 0), "half_extents": (1, 1, 1), "rotation": (0, 0, 0, 0)},
        {"center": (0, 0, 0), "half_extents": (1, 1, 1), "rotation": (0, 0, 1)},
    ],
    "HalfSpace": [{"normal": (0, 0, 0), "k": 0.0}, {"normal": (0, 0, 1), "k": math.nan}],
    "Ray": [{"origin": (0, 0, 0), "direction": (0, 0, 0)}],
    "Torus": [{"center": (0, 0, 0), "radius": 1.0}],
}


@pytest.mark.parametrize(("kind", "fields"), [(kind, f) for kind, rows in BAD_SHAPES.items() for f in rows])
def test_shapes_without_a_meaning_are_refused(kind: str, fields: dict[str, Any]) -> None:
    shape = type(kind, (Pretender,), {})(**fields)
    with pytest.raises(InvalidCertificate):
        check(Certificate(()), shape, BALL)
    with pytest.raises(InvalidCertificate):
        check(Certificate(()), BALL, shape)


def test_a_shape_is_read_by_name_and_fields() -> None:
    sphere = type("Sphere", (Pretender,), {})(center=(3, 4, 0), radius=4.0)
    assert one(Escape((3, 4, 0)), BALL, sphere) == (0, INF)


# ---- random tampering ------------------------------------------------------------------------------------------

SCENES: list[tuple[Proxy, Proxy]] = [
    (CUBE, FAR_CUBE),
    BOXES,
    (BALL, FAR_BALL),
    (ROD, TURNED),
    (FLOOR, TURNED),
    (FLOOR, BALL.translated((0.5, 0.25, 3))),
    (CUBE, CUBE.translated((2, 0.5, 0))),
    (FLOOR, HalfSpace((0, 0.25, -1), 0)),
    (RAY, TURNED),
    (RAY, FAR_BALL.translated((0.5, -3, 0.5))),
    (MISSING_RAY, ROD),
    (Ellipsoid((0, 0, 0), (1, 2, 3), (1, 2, 3, 4)), FAR_BALL),
    (Ellipsoid((0, 0, 0), (1, 2, 3), (1, 2, 3, 4)), TURNED),
    (Cylinder((0, 0, 0), (1, 2, 3), 0.5), Cylinder((0, 0, 0), (0, 0, 1), 2)),
    (KDOP(np.eye(3), (-1, -1, -1), (1, 1, 1)), TURNED),
    (RAY, Cylinder((0, 0, 0), (1, 2, 3), 0.5)),
]
NUMBERS = st.one_of(
    st.floats(width=64),
    st.fractions(max_denominator=10**6),
    st.integers(-9, 9),
    st.sampled_from([0.0, -0.0, 1e-300, 1e300, None, "x"]),
)


def leaves(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Places of all numbers in nested tuples and claims."""
    if isinstance(value, tuple):
        return [leaf for i, v in enumerate(value) for leaf in leaves(v, (*path, i))]
    if isinstance(value, Claim):
        return [leaf for name, v in vars(value).items() for leaf in leaves(v, (*path, name))]
    return [path]


def with_leaf(value: Any, path: tuple[Any, ...], change: Any) -> Any:
    """The same with one number changed."""
    if not path:
        return change(value)
    if isinstance(value, tuple):
        return tuple(with_leaf(v, path[1:], change) if i == path[0] else v for i, v in enumerate(value))
    return replace(value, **{path[0]: with_leaf(getattr(value, path[0]), path[1:], change)})


@given(data=st.data())
def test_no_changed_number_makes_a_false_bound(data: Any) -> None:
    a, b = data.draw(st.sampled_from(SCENES))
    if data.draw(st.booleans()):
        a, b = b, a
    claims: Any = certify(a, b).claims
    for _ in range(data.draw(st.integers(1, 3))):
        new, nudge = data.draw(NUMBERS), data.draw(st.sampled_from([None, 1e-15, 1e-6, 0.1]))

        def change(old: Any, new: Any = new, nudge: Any = nudge) -> Any:
            usable = nudge is not None and isinstance(old, int | float | Fraction) and not isinstance(old, bool)
            return float(old) * (1 + nudge) if usable else new

        claims = with_leaf(claims, data.draw(st.sampled_from(leaves(claims))), change)
    try:
        lower, upper = check(Certificate(claims), a, b)
    except InvalidCertificate:
        return
    ray, solid = (a, b) if isinstance(a, Ray) else (b, a)
    if isinstance(ray, Ray):
        times = ray_interval(ray, solid)
        encloses(lower, upper, mpf("inf") if times is None else times[0])
    else:
        encloses(lower, upper, signed_distance(a, b))
