"""Convex pieces of concave solids: their volumes add up exactly, they are disjoint, and they cover the solid."""

from fractions import Fraction

import numpy as np
import pytest

from refimpl.bsp import bounds_convex, convex_pieces
from refimpl.meshes import six_volumes, winding_numbers
from refimpl.signs import Points
from tests.solids import SOLIDS, box, prism, torus, turned

CASES = [(name, seed) for name in SOLIDS for seed in (None, 1, 2, 3)]


def mesh_of(name, seed):
    return SOLIDS[name] if seed is None else turned(SOLIDS[name], seed)


def exact_six_volumes(vertices, triangles):
    points = Points(vertices)
    return Fraction(six_volumes(points, triangles)) * Fraction(2) ** (3 * points.grid_exponent)


def heights(piece, points):
    """Signs of the exact heights of exact points (x, y, z, w) above the planes."""
    return [[a * x + b * y + c * z + d * w for a, b, c, d in piece.planes] for x, y, z, w in points]


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_volumes_add_up_exactly(name, seed):
    vertices, triangles = mesh_of(name, seed)
    pieces = convex_pieces(vertices, triangles)
    assert sum(piece.six_volumes() for piece in pieces) == exact_six_volumes(vertices, triangles)
    assert all(piece.six_volumes() > 0 for piece in pieces)


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_planes_and_corners_agree(name, seed):
    """Every corner is behind all planes, and exactly on those whose facets name it."""
    for piece in convex_pieces(*mesh_of(name, seed)):
        on = [{corner for corner, row in enumerate(heights(piece, piece.corners)) if row[i] == 0}
              for i in range(len(piece.planes))]  # fmt: skip
        assert all(h <= 0 for row in heights(piece, piece.corners) for h in row)
        assert on == [set(loop) for loop in piece.facets]
        assert len(piece.corners) - sum(map(len, piece.facets)) // 2 + len(piece.facets) == 2  # Euler
        exact = [[float(Fraction(c, corner[3])) for c in corner[:3]] for corner in piece.corners]
        assert np.array_equal(piece.vertices, exact)


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_pieces_are_the_solid(name, seed):
    """A point that is on no plane is in as many pieces as the surface winds around it: none, or one."""
    vertices, triangles = mesh_of(name, seed)
    pieces = convex_pieces(vertices, triangles)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    points = np.random.default_rng(7).uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (200, 3))
    exact = [(*(Fraction(c) for c in p), Fraction(1)) for p in points.tolist()]
    inside = sum(np.array([all(h < 0 for h in row) for row in heights(piece, exact)], dtype=int) for piece in pieces)
    around = winding_numbers(vertices[triangles], points)
    assert np.array_equal(inside, around)
    assert 0 < np.sum(around) < len(points)


@pytest.mark.parametrize(("name", "least"), [("box", 1), ("L", 2), ("U", 3), ("hollow", 6), ("two", 2)])
@pytest.mark.parametrize("seed", [None, 1])
def test_few_pieces(name, least, seed):
    """Turned, the rounded faces of a box are not quite flat: it may need more pieces, but never fewer."""
    count = len(convex_pieces(*mesh_of(name, seed)))
    assert count == least if seed is None else count >= least


def test_convex_meshes_are_one_piece():
    assert bounds_convex(*box())
    assert not bounds_convex(*torus())
    vertices, triangles = box((-1, -2, -3), (1, 2, 3))
    (piece,) = convex_pieces(vertices, triangles)
    assert sorted(map(tuple, piece.vertices.tolist())) == sorted(map(tuple, vertices.tolist()))
    assert len(piece.planes) == 6
    assert sorted(len(loop) for loop in piece.facets) == [4] * 6


def test_a_dent_of_one_unit_in_the_last_place_is_seen():
    outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.0), (0.0, 1.0)]
    assert bounds_convex(*prism(outline))
    outline[3] = (0.5, float(np.nextafter(1.0, 0.0)))
    assert not bounds_convex(*prism(outline))
    assert sum(p.six_volumes() for p in convex_pieces(*prism(outline))) == exact_six_volumes(*prism(outline))


@pytest.mark.parametrize("power", [-900, 300])
def test_any_unit_will_do(power):
    vertices, triangles = turned(SOLIDS["U"], 4)
    plain, scaled = convex_pieces(vertices, triangles), convex_pieces(np.ldexp(vertices, power), triangles)
    assert len(plain) == len(scaled)
    for one, other in zip(plain, scaled, strict=True):
        assert np.array_equal(np.ldexp(one.vertices, power), other.vertices)
