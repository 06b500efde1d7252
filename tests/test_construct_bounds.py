"""Boxes, capsules and cylinders against volumes below which none is; and clouds that are thin, but not flat."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from refimpl.construct import ConstructionError, box, capsule, cylinder, ellipsoid, least_box
from refimpl.construct.optimality import (
    Weights,
    check_ellipsoid,
    excess_of_ellipsoid,
    least_volume,
    prove_ellipsoid,
)
from refimpl.mass import mass_properties
from refimpl.shapes import Box, Capsule, Cylinder, Sphere
from tests.clouds import CLOUDS, TURN, lies_in, matrix_of

MATRIX = matrix_of(TURN)
ANGLE = np.arange(12) * np.pi / 6
RIMS = np.array([[2 * np.cos(a), 2 * np.sin(a), z] for a in ANGLE for z in (-3, 3)]) @ MATRIX.T
CUBOID = np.array([[x, y, z] for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)]) @ MATRIX.T


def volume(found) -> float:
    return float(mass_properties(found).volume)


@pytest.mark.parametrize("name", ["random", "on a sphere", "cospherical"])
def test_no_volume_is_below_its_bound(name):
    points = CLOUDS[name]
    proof = prove_ellipsoid(points)
    for build, kind, most in ((box, Box, 6), (least_box, Box, 4), (capsule, Capsule, 5), (cylinder, Cylinder, 4)):
        ratio = volume(build(points)) / least_volume(points, kind, proof)
        assert 1 - 1e-12 <= ratio < most, (build.__name__, ratio)


def test_bounds_by_weights_are_reached():
    """By the corners of a box and the rims of a cylinder; of these hulls the second is smaller than its cylinder."""
    assert least_volume(CUBOID, Box, prove_ellipsoid(CUBOID)) == pytest.approx(48.0, rel=1e-9)
    bound = least_volume(RIMS, Cylinder, prove_ellipsoid(RIMS))
    assert bound == pytest.approx(24 * np.pi, rel=1e-6)
    assert volume(cylinder(RIMS)) == pytest.approx(bound, rel=1e-6)
    assert volume(least_box(CUBOID)) == pytest.approx(48.0, rel=1e-9)


def test_bounds_hold_for_any_weights_and_any_shape():
    """Shapes whose volume is known, around points drawn inside of them, with weights that nobody chose."""
    rng = np.random.default_rng(2)
    for _ in range(8):
        radius, half = rng.uniform(0.2, 2, size=2)
        extents = rng.uniform(0.2, 2, size=3)
        sides = rng.choice([-1.0, 1.0], size=(9, 3)) * extents
        angle = rng.uniform(0, 2 * np.pi, size=9)
        rims = np.stack([radius * np.cos(angle), radius * np.sin(angle), rng.choice([-half, half], size=9)], axis=1)
        way = rng.normal(size=(9, 3))
        caps = radius * way / np.linalg.norm(way, axis=1)[:, None] + np.sign(way[:, 2:]) * [0, 0, half]
        proof = Weights(tuple(range(9)), tuple(Fraction(v) for v in rng.uniform(0.1, 1, size=9).tolist()))
        for kind, points, truth in (
            (Box, sides, 8 * np.prod(extents)),
            (Cylinder, rims, 2 * np.pi * radius**2 * half),
            (Capsule, caps, 2 * np.pi * radius**2 * half + 4 / 3 * np.pi * radius**3),
        ):
            assert least_volume(points @ MATRIX.T, kind, proof) <= truth * (1 + 1e-12)


def test_what_has_no_bound_is_said():
    with pytest.raises(ConstructionError, match="Sphere"):
        least_volume(CUBOID, Sphere, prove_ellipsoid(CUBOID))


@pytest.mark.parametrize("sizes", [(1, 1, 1e-10), (1, 1e-5, 1e-10), (1, 1e-9, 1e-9)])
def test_thin_clouds_in_general_position(sizes):
    """Their covariance in doubles is singular."""
    points = (np.random.default_rng(0).normal(size=(12, 3)) * sizes) @ MATRIX.T
    found = ellipsoid(points)
    assert all(lies_in(found, x) for x in points)
    excess = excess_of_ellipsoid(found, check_ellipsoid(points, prove_ellipsoid(points)))
    assert 0 <= excess < 1e-4
    for brick in (box(points), least_box(points)):
        assert all(lies_in(brick, x) for x in points)
        assert np.min(brick.half_extents) < 4 * min(sizes)


def test_three_points_nearly_on_a_line():
    """Three points have no solid hull, however far they seem to be off their line."""
    points = np.array([[6.5e-9, -9307.5, 3.9e-6], [3.4e-8, -7990.9, -1.3e-7], [-3.5e-9, 3183.96, -2.3e-6]])
    for build in (least_box, capsule, cylinder):
        assert all(lies_in(build(points), x) for x in points)
    with pytest.raises(ConstructionError, match="plane"):
        ellipsoid(points)
