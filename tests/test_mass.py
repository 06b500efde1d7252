"""Volume, barycentre and inertia: against quadrature in 30 digits, fractions, sampling and another library."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import trimesh

from refimpl.bounds import aabb
from refimpl.integrals import surface_integrals
from refimpl.linear import apply, rotation_matrix
from refimpl.mass import MassProperties, mass_properties
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Ray,
    Sphere,
    UnsupportedOperation,
)

rng = np.random.default_rng(12)
TURN = np.array([0.1, 0.5, -0.3, 0.7])
MATRIX = rotation_matrix(TURN)
PLACE = np.array([1.0, -2.0, 0.5])
CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
CUBE = np.concatenate([np.concatenate([np.eye(3), -np.eye(3)]), -np.ones((6, 1))], axis=1)
CLOUD = rng.normal(size=(30, 3)) * [1, 2, 0.5]


def check(found, volume, barycentre, inertia, tolerance=1e-14):
    """Compare with known values, each relative to its own size."""
    size = np.max(np.abs(inertia))
    assert abs(found.volume - volume) <= tolerance * volume
    assert np.max(np.abs(found.barycentre - barycentre)) <= tolerance * (1 + np.max(np.abs(barycentre)))
    assert np.max(np.abs(found.inertia - inertia)) <= tolerance * size
    assert np.array_equal(found.inertia, np.swapaxes(found.inertia, -1, -2)) or np.allclose(
        found.inertia, np.swapaxes(found.inertia, -1, -2), rtol=0, atol=1e-16 * size
    )
    assert np.all(np.linalg.eigvalsh(found.inertia) >= 0)


# ---- solids of revolution ----------------------------------------------------------------------------------------


def of_revolution(square_radius, low, high, breaks=()):
    """Volume and moments about the z axis and across it, through the origin: discs of squared radius, by quadrature."""
    knots = [low, *breaks, high]
    volume = mpmath.quad(lambda z: mpmath.pi * square_radius(z), knots)
    along = mpmath.quad(lambda z: mpmath.pi * square_radius(z) ** 2 / 2, knots)
    across = mpmath.quad(lambda z: mpmath.pi * (square_radius(z) ** 2 / 4 + square_radius(z) * z * z), knots)
    return float(volume), np.diag([float(across), float(across), float(along)])


R, H = mpmath.mpf(3) / 4, mpmath.mpf(5) / 4
UP = H * MATRIX[:, 2].astype(float)
ROUND = {
    "sphere": (Sphere(PLACE, 0.75), of_revolution(lambda z: R**2 - z**2, -R, R)),
    "cylinder": (
        Cylinder(PLACE - float(H) * MATRIX[:, 2], PLACE + float(H) * MATRIX[:, 2], 0.75),
        of_revolution(lambda z: R**2, -H, H),
    ),
    "capsule": (
        Capsule(PLACE - float(H) * MATRIX[:, 2], PLACE + float(H) * MATRIX[:, 2], 0.75),
        of_revolution(lambda z: R**2 - max(abs(z) - H, 0) ** 2, -H - R, H + R, (-H, H)),
    ),
    "ellipsoid": (
        Ellipsoid(PLACE, [0.75, 0.75, 1.25], TURN),
        of_revolution(lambda z: R**2 * (1 - (z / H) ** 2), -H, H),
    ),
}


@pytest.mark.parametrize("name", ROUND)
def test_round_solids_agree_with_quadrature(name):
    shape, (volume, inertia) = ROUND[name]
    check(mass_properties(shape), volume, PLACE, MATRIX @ inertia @ MATRIX.T)


def test_a_capsule_without_length_is_a_sphere_and_one_without_radius_is_nothing():
    ball, dot = mass_properties(Capsule(PLACE, PLACE, 0.75)), mass_properties(Capsule(PLACE, [3, 4, 5], 0))
    check(ball, *vars(mass_properties(Sphere(PLACE, 0.75))).values())
    assert dot.volume == 0
    assert np.all(dot.inertia == 0)


# ---- by definition: sums over many points ------------------------------------------------------------------------


def inside(shape, points):
    """Membership by the documented definition."""
    if isinstance(shape, Ellipsoid):
        local = (points - shape.center) @ rotation_matrix(shape.rotation)
        return np.sum((local / shape.radii) ** 2, axis=1) <= 1
    if isinstance(shape, Box):
        return np.all(np.abs((points - shape.center) @ rotation_matrix(shape.rotation)) <= shape.half_extents, axis=1)
    if isinstance(shape, KDOP):
        heights = points @ shape.directions.T
        return np.all((heights >= shape.lower) & (heights <= shape.upper), axis=1)
    local = (points - shape.position) @ rotation_matrix(shape.rotation)
    return np.all(local @ shape.planes[:, :3].T + shape.planes[:, 3] <= 0, axis=1)


SAMPLED = {
    "ellipsoid": Ellipsoid(PLACE, [0.5, 1.0, 1.5], TURN),
    "box": Box(PLACE, [0.5, 1.0, 1.5], TURN),
    "k-DOP": KDOP.around(CLOUD * 0.6, 26),
    "planes": ConvexPolyhedron(np.concatenate([CUBE, [[1, 1, 1, -1.5], [-1, 2, 0.5, -2]]]), PLACE, TURN),
    "vertices": ConvexPolyhedron.from_vertices(CLOUD * 0.6, PLACE, TURN),
}


def sampled(shape, count=300_000):
    """Estimates from points of the box around the shape, and the standard error of each."""
    box = aabb(shape)
    points = rng.uniform(box.lower, box.upper, (count, 3))
    room, points = np.prod(box.upper - box.lower), points[inside(shape, points)]
    share, root = len(points) / count, math.sqrt(len(points))
    middle = points.mean(axis=0)
    r = points - middle
    products = room * share * (np.sum(r * r, axis=1)[:, None, None] * np.eye(3) - r[:, :, None] * r[:, None, :])
    return (
        (room * share, room * math.sqrt(share * (1 - share) / count)),
        (middle, r.std() / root),
        (products.mean(axis=0), (products.std(axis=0).max() + products.mean(axis=0).max()) / root),
    )


def agrees_with_samples(found, estimates, sigmas=6):
    values = (found.volume, found.barycentre, found.inertia)
    return all(np.all(np.abs(v - e) <= sigmas * s) for v, (e, s) in zip(values, estimates, strict=True))


@pytest.mark.parametrize("name", SAMPLED)
def test_properties_are_the_means_over_the_set(name):
    shape = SAMPLED[name]
    found, estimates = mass_properties(shape), sampled(shape)
    assert agrees_with_samples(found, estimates)
    for wrong in (
        replace(found, volume=found.volume * 1.05),
        replace(found, barycentre=found.barycentre + 0.05),
        replace(found, inertia=found.inertia * 1.1),
        replace(found, inertia=MATRIX @ found.inertia @ MATRIX.T),
    ):
        assert not agrees_with_samples(wrong, estimates)


# ---- exact sums --------------------------------------------------------------------------------------------------


def exact_tetrahedra(tetrahedra):
    """Volume, first and second moments of tetrahedra in fractions, by their known barycentres and covariances."""
    volume, first, second = Fraction(0), [Fraction(0)] * 3, [[Fraction(0)] * 3 for _ in range(3)]
    for tetrahedron in tetrahedra:
        p = [[Fraction(x) for x in corner] for corner in tetrahedron]
        u, v, w = ([a - b for a, b in zip(q, p[0], strict=True)] for q in p[1:])
        six = (
            u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])
        )
        part = abs(six) / 6
        volume += part
        mean = [sum(q[i] for q in p) / 4 for i in range(3)]
        for i in range(3):
            first[i] += part * mean[i]
            for j in range(3):
                spread = sum((q[i] - mean[i]) * (q[j] - mean[j]) for q in p) / 20
                second[i][j] += part * (mean[i] * mean[j] + spread)
    return volume, first, second


def fraction_array(numbers):
    flat = [Fraction(float(x)) for x in np.ravel(numbers)]
    out = np.empty(len(flat), dtype=object)
    out[:] = flat
    return out.reshape(np.shape(numbers))


TETRAHEDRON = np.array([[1, 2, 3], [4, 2.5, 3], [1, 5, 2], [0, 1, 7.25]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def l_solid():
    """An L-shaped prism: concave; its mesh, and its two bricks as tetrahedra."""
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    flat = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    vertices = np.array([[*p, z] for z in (0.0, 0.75) for p in outline])
    faces = [[c, b, a] for a, b, c in flat] + [[a + 6, b + 6, c + 6] for a, b, c in flat]
    for i in range(6):
        j = (i + 1) % 6
        faces += [[i, j, j + 6], [i, j + 6, i + 6]]
    bricks = [(np.zeros(3), np.array([3.0, 1, 0.75])), (np.array([0.0, 1, 0]), np.array([1, 2.0, 0.75]))]
    order = [(0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7)]
    tetrahedra = []
    for low, high in bricks:
        corner = [np.where([i >> 2 & 1, i >> 1 & 1, i & 1], high, low) for i in range(8)]
        tetrahedra += [[corner[i].tolist() for i in each] for each in order]
    return vertices, np.array(faces), tetrahedra


MESHES = {"tetrahedron": (TETRAHEDRON, FACES, [TETRAHEDRON.tolist()]), "L": l_solid()}


@pytest.mark.parametrize("name", MESHES)
def test_surface_integrals_are_exact_on_fractions(name):
    vertices, faces, tetrahedra = MESHES[name]
    volume, first, second = surface_integrals(fraction_array(vertices)[faces])
    expected = exact_tetrahedra(tetrahedra)
    assert volume == expected[0]
    assert list(first) == expected[1]
    assert second.tolist() == expected[2]
    flipped = faces[:, ::-1]
    assert surface_integrals(fraction_array(vertices)[flipped])[0] == -expected[0]
    hole = surface_integrals(fraction_array(vertices)[np.delete(faces, len(faces) // 2, axis=0)])
    assert hole[0] != expected[0] or list(hole[1]) != expected[1]


def from_moments(volume, first, second):
    """Properties from exact moments about the origin."""
    middle = [x / volume for x in first]
    central = [[second[i][j] - volume * middle[i] * middle[j] for j in range(3)] for i in range(3)]
    trace = sum(central[i][i] for i in range(3))
    inertia = [[(trace if i == j else 0) - central[i][j] for j in range(3)] for i in range(3)]
    return float(volume), np.array(middle, dtype=float), np.array(inertia, dtype=float)


@pytest.mark.parametrize("name", MESHES)
def test_meshes_have_the_exact_properties(name):
    vertices, faces, tetrahedra = MESHES[name]
    volume, middle, inertia = from_moments(*exact_tetrahedra(tetrahedra))
    check(mass_properties(Polyhedron(vertices, faces)), volume, middle, inertia)
    placed = mass_properties(Polyhedron(vertices, faces, [PLACE] * 3, TURN))
    assert placed.volume.shape == (3,)
    alone = MassProperties(*(x[1] for x in (placed.volume, placed.barycentre, placed.inertia)))
    check(alone, volume, PLACE + MATRIX @ middle, MATRIX @ inertia @ MATRIX.T)


def test_slivers_and_hulls_far_away_keep_their_digits():
    for thin, far in ((1.0, 0.0), (1e-9, 0.0), (1.0, 1e6)):
        points = np.round(CLOUD[:10] * 64) / 64 * [1, 1, 2.0 ** round(math.log2(thin))] + far
        hull = ConvexPolyhedron.from_vertices(points)
        corners = hull.hull.vertices
        fans = [
            [corners[0].tolist(), corners[a].tolist(), corners[b].tolist(), corners[c].tolist()]
            for a, b, c in triangles_of(hull.hull)
        ]
        volume, middle, inertia = from_moments(*exact_tetrahedra(fans))
        check(mass_properties(hull), volume, middle, inertia, 1e-13 if far else 1e-14)


def triangles_of(hull):
    """Each face as a fan about its first corner, found anew from the planes."""
    found = []
    for face in range(len(hull.planes)):
        loop = {int(v): int(w) for v, w, left, _ in hull.edges if left == face}
        loop |= {int(w): int(v) for v, w, _, right in hull.edges if right == face}
        start = next(iter(loop))
        at = loop[start]
        while loop[at] != start:
            found.append((start, at, loop[at]))
            at = loop[at]
    return found


# ---- the same set in other words ---------------------------------------------------------------------------------

SAME = {
    "box as planes": (Box(PLACE, [0.5, 1.0, 2.0], TURN), lambda b: b.to_convex_polyhedron()),
    "box as vertices": (
        Box(PLACE, [0.5, 1.0, 2.0], TURN),
        lambda b: ConvexPolyhedron.from_vertices(CORNERS * b.half_extents, b.center, b.rotation),
    ),
    "AABB as k-DOP": (AABB([-1, 2, 3], [1.5, 5, 3.5]), lambda b: KDOP(np.eye(3), b.lower, b.upper)),
    "sphere as ellipsoid": (Sphere(PLACE, 0.75), lambda s: s.to_ellipsoid()),
    "hull as mesh": (
        ConvexPolyhedron.from_vertices(CLOUD, PLACE, TURN),
        lambda c: Polyhedron(c.hull.vertices, triangles_of(c.hull), c.position, c.rotation),
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_the_same_set_in_other_words_has_the_same_properties(name):
    shape, other = SAME[name]
    found = mass_properties(shape)
    check(mass_properties(other(shape)), found.volume, found.barycentre, found.inertia, 2e-14)
    with pytest.raises(AssertionError):
        check(mass_properties(other(shape).scaled(1.001)), found.volume, found.barycentre, found.inertia, 1e-5)


def test_another_library_agrees():
    hull = ConvexPolyhedron.from_vertices(CLOUD, PLACE, TURN)
    other = trimesh.convex.convex_hull(PLACE + apply(MATRIX, CLOUD))
    check(mass_properties(hull), other.volume, other.center_mass, other.moment_inertia, 1e-12)


@pytest.mark.parametrize("exponent", [-100, -20, 50])
def test_properties_scale_with_their_dimension(exponent):
    for shape in [*SAMPLED.values(), *(s for s, _ in ROUND.values())]:
        found, scaled = mass_properties(shape), mass_properties(shape.times_power(exponent))
        assert scaled.volume == np.ldexp(found.volume, 3 * exponent)
        assert np.array_equal(scaled.barycentre, np.ldexp(found.barycentre, exponent))
        assert np.array_equal(scaled.inertia, np.ldexp(found.inertia, 5 * exponent))


def test_a_row_of_a_batch_is_the_same_alone():
    clouds = np.stack([CLOUD[:9], np.concatenate([CORNERS, CORNERS[:1]]), CLOUD[9:18] * [1, 1, 0]])
    q, place = rng.normal(size=(3, 4)), rng.normal(size=(3, 3))
    for many in (
        ConvexPolyhedron.from_vertices(clouds, place, q),
        KDOP.around(clouds, 18),
        Ellipsoid(place, np.abs(q[:, :3]), q),
        Cylinder(place, q[:, :3], 0.5),
        Box(place, np.abs(q[:, :3]), q),
    ):
        found = mass_properties(many)
        for i in range(3):
            row = type(many).unpack(many[i].pack())  # not filled up to the batch's largest
            alone = mass_properties(row)
            for name in ("volume", "barycentre", "inertia"):
                assert np.array_equal(getattr(found, name)[i], getattr(alone, name), equal_nan=True)


def test_flat_polytopes_have_no_volume_and_no_barycentre():
    for flat in (CORNERS * [1, 1, 0], CORNERS * [1, 0, 0], CORNERS * 0):
        found = mass_properties(ConvexPolyhedron.from_vertices(flat, PLACE, TURN))
        assert found.volume == 0
        assert np.all(np.isnan(found.barycentre))
        assert np.all(found.inertia == 0)
        assert np.all(np.isnan(found.of_mass(1.0)))
    assert mass_properties(Box(PLACE, [1, 2, 0], TURN)).volume == 0


def test_inertia_of_a_mass():
    ball = mass_properties(Sphere([1, 2, 3], 0.5))
    assert np.allclose(ball.of_mass(3.0), 0.4 * 3 * 0.25 * np.eye(3), atol=1e-15)


# ---- unions ------------------------------------------------------------------------------------------------------


def test_a_union_of_parts_side_by_side_is_their_sum():
    """Two bricks that touch are the larger brick."""
    whole = AABB([0, 0, 0], [4, 1, 2])
    union = Composite([AABB([0, 0, 0], [1, 1, 2]), AABB([1, 0, 0], [4, 1, 2])])
    found = mass_properties(whole)
    check(mass_properties(union), found.volume, found.barycentre, found.inertia)
    apart = Composite([Sphere([0, 0, 0], 1), Sphere([4, 0, 0], 1)])
    moved = mass_properties(apart)
    one = mass_properties(Sphere([0, 0, 0], 1))
    expected = 2 * one.inertia + 2 * one.volume * np.diag([0, 4, 4])
    check(moved, 2 * one.volume, np.array([2.0, 0, 0]), expected)
    with pytest.raises(AssertionError):
        check(moved, 2 * one.volume, np.array([2.0, 0, 0]), 2 * one.inertia)


def test_overlapping_parts_are_refused_or_disclosed():
    union = Composite([Sphere([0, 0, 0], 1), Sphere([[1.5, 0, 0], [3, 0, 0]], 1)])
    with pytest.raises(UnsupportedOperation, match=r"parts\[0\] and \[1\] overlap by 0.5: .* count twice"):
        mass_properties(union)
    found = mass_properties(union, allowed_overlap=0.5)
    assert np.allclose(found.volume, 8 / 3 * math.pi)


@pytest.mark.parametrize("shape", [Point([0, 0, 0]), Ray([0, 0, 0], [1, 0, 0]), HalfSpace([0, 0, 1], 0)])
def test_what_is_no_bounded_solid_has_no_mass(shape):
    with pytest.raises(UnsupportedOperation, match=f"a {type(shape).__name__} has no mass properties"):
        mass_properties(shape)


def test_the_length_of_a_quaternion_means_nothing():
    expected = mass_properties(Ellipsoid(PLACE, [1, 2, 3], TURN)).inertia
    for q in (TURN * 2.0**300, TURN * 1e-200):
        assert np.allclose(mass_properties(Ellipsoid(PLACE, [1, 2, 3], q)).inertia, expected, atol=1e-13)
