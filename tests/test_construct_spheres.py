"""The smallest sphere is the smallest, proven by weights and by brute force; and the arithmetics that find it are sure.

Distances are computed here in fractions, by other formulas than those that built the sphere.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refimpl.construct import ConstructionError, balls, sphere
from refimpl.construct.cloud import QUICK, Cloud
from refimpl.construct.enclosed import EnclosedTwice, grain_of
from refimpl.construct.formulas import Home, near_segment
from refimpl.construct.optimality import Weights, check_sphere, prove_sphere
from tests.clouds import CLOUDS, TURN, lies_in, matrix_of


def smallest_by_brute_force(points) -> Fraction:
    """Least squared radius of all circumspheres of two, three and four points that contain all others."""
    exact = [np.array([Fraction(v) for v in row]) for row in points.tolist()]
    found = []
    for count in (2, 3, 4):
        for chosen in combinations(exact, count):
            edges = [c - chosen[0] for c in chosen[1:]]
            gram = [[sum(a * b) for b in edges] for a in edges]
            shares = cramer(gram, [sum(a * a) / 2 for a in edges])
            if shares is None:
                continue
            center = chosen[0] + sum((s * e for s, e in zip(shares, edges, strict=True)), np.zeros(3, dtype=object))
            squares = [sum((x - center) ** 2) for x in exact]
            if max(squares) == sum((chosen[0] - center) ** 2):
                found.append(max(squares))
    return min(found)


def determinant(m) -> Fraction:
    if len(m) == 1:
        return m[0][0]
    return sum((-1) ** j * m[0][j] * determinant([row[:j] + row[j + 1 :] for row in m[1:]]) for j in range(len(m)))


def cramer(matrix, right):
    whole = determinant(matrix)
    if whole == 0:
        return None
    return [determinant([[*r[:j], b, *r[j + 1 :]] for r, b in zip(matrix, right, strict=True)]) / whole
            for j in range(len(right))]  # fmt: skip


@pytest.mark.parametrize("name", ["random", "on a sphere", "cospherical", "coplanar", "collinear", "far away", "tiny"])
def test_the_smallest_sphere_is_the_smallest(name):
    points = CLOUDS[name][:9]
    proof = prove_sphere(points)
    bound = check_sphere(points, proof)
    assert bound == smallest_by_brute_force(points)
    radius = Fraction(float(sphere(points).radius))
    assert bound <= radius**2
    if name != "far away":  # there the centre is rounded by more than this
        assert radius**2 <= bound * (1 + Fraction(1, 10**14))


def test_a_proof_with_other_weights_proves_less_and_nonsense_is_refused():
    points = CLOUDS["random"]
    proof = prove_sphere(points)
    other = Weights(proof.points, (proof.weights[0] * 2, *proof.weights[1:]))
    assert check_sphere(points, other) < check_sphere(points, proof)
    for bad in (Weights((0,), (Fraction(-1),)), Weights((), ()), Weights((99,), (Fraction(1),))):
        with pytest.raises(ConstructionError):
            check_sphere(points, bad)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(*[st.integers(-3, 3)] * 3), min_size=1, max_size=7), st.sampled_from([1.0, 0.1, 1e-310]))
def test_grids_of_points_have_their_smallest_sphere(grid, unit):
    points = np.array(grid, dtype=float) * unit
    ball = sphere(points)
    assert all(lies_in(ball, x) for x in points)
    least = smallest_by_brute_force(points) if len(set(map(tuple, points.tolist()))) > 1 else Fraction(0)
    assert check_sphere(points, prove_sphere(points)) == least


def hard_clouds() -> dict[str, np.ndarray]:
    """Points of which doubles cannot tell which is farthest."""
    rng = np.random.default_rng(11)
    way = rng.normal(size=(1500, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    angle = rng.random(1500) * 2 * np.pi
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) @ matrix_of(TURN).T
    whole = np.array([[x, y, z] for x in range(-26, 27) for y in range(-26, 27) for z in range(-26, 27)])
    return {
        "on a sphere": way * 0.1 + [0.3, 0.7, -0.2],
        "on a sphere, far away": way + 1e6,
        "on a circle": np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1) @ matrix_of(TURN).T,
        "corners, many times": corners[rng.integers(8, size=1500)] + 0.3,
        "exactly on a sphere": whole[np.sum(whole**2, axis=1) == 26**2].repeat(20, axis=0) / 64,
        "a bit outside": np.concatenate([way, np.nextafter(way[:50], 2 * way[:50])]),
    }


HARD = hard_clouds()


@pytest.mark.parametrize("name", HARD)
def test_spheres_of_points_that_doubles_cannot_tell_apart(name, monkeypatch):
    """Proven by weights; contained by squares in fractions; and one bit less leaves a point outside."""
    monkeypatch.setattr(balls, "FEW", 64)
    points = HARD[name]
    proof, found = prove_sphere(points), sphere(points)
    center, radius = [Fraction(v) for v in found.center.tolist()], Fraction(float(found.radius))
    different = np.unique(points, axis=0).tolist()
    squares = [sum((Fraction(a) - b) ** 2 for a, b in zip(x, center, strict=True)) for x in different]
    assert Fraction(np.nextafter(found.radius, 0)) ** 2 < max(squares) <= radius**2
    least = check_sphere(points, proof)
    exact = [
        sum(w * Fraction(points[i, k]) for i, w in zip(proof.points, proof.weights, strict=True)) for k in range(3)
    ]
    assert all(sum((Fraction(a) - b) ** 2 for a, b in zip(x, exact, strict=True)) <= least for x in different)
    assert least <= radius**2 <= least * (1 + Fraction(2, 10**14 if "far" not in name else 10**9))


def test_a_point_that_is_repeated_is_asked_once(monkeypatch):
    """Eight corners on one sphere, which doubles of every length leave open; in fractions all would take minutes."""
    asked = []
    exact = Cloud.exact
    monkeypatch.setattr(Cloud, "exact", lambda self, i: asked.append(i) or exact(self, i))
    sphere(HARD["corners, many times"])
    assert 8 <= len(asked) < 400 < len(HARD["corners, many times"])


numbers = st.floats(-1, 1).map(lambda v: v if abs(v) > 1e-100 else 0.0)


def taken(arithmetic, columns, grain):
    return [arithmetic(arithmetic.lifted(c), 0.0, grain) for c in columns]


def halves_of(found, count):
    """The numbers that were computed, as sums of two doubles."""
    if isinstance(found, EnclosedTwice):
        parts = found.value.high, found.value.lows
    else:
        high = np.asarray(found.value).astype(float)
        parts = high, np.asarray(found.value - high).astype(float)
    return zip(*(np.broadcast_to(part, count).tolist() for part in parts), strict=True)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=4), st.tuples(*[numbers] * 6))
def test_numbers_lie_in_their_error_bounds(rows, ends):
    points = np.array(rows)
    p, q = ([Fraction(v) for v in end] for end in (ends[:3], ends[3:]))
    near = [(a + b / 1024) / 3 for a, b in zip(p, q, strict=True)]
    for formula in (near_segment(p, q, Fraction(1, 3)), Home.at(p, Fraction(1, 3)).beside(near, Fraction(1, 5))):
        truth = [formula([Fraction(v) for v in row], Fraction) for row in points.tolist()]
        for kind in (*QUICK, EnclosedTwice):
            for grain in (None, grain_of(points)):
                found = formula(taken(kind, points.T.copy(), grain), kind.of)
                for t, (high, low) in zip(truth, halves_of(found, len(truth)), strict=True):
                    assert abs(Fraction(high) + Fraction(low) - t) <= Fraction(found.error)
                    assert Fraction(found.range[0]) <= t <= Fraction(found.range[1])
        cloud = Cloud(points, 1.0)
        truth = [formula(cloud.exact(i), Fraction) for i in range(len(points))]
        assert cloud.greatest(formula).value == max(truth)
        assert cloud.not_positive(formula).tolist() == [t <= 0 for t in truth]
        outside = cloud.most_positive(formula, 2).tolist()
        assert all(truth[i] > 0 for i in outside)
        assert bool(outside) == (max(truth) > 0)


def test_the_greatest_value_is_found_among_equals():
    """Points that doubles cannot tell apart: the last bit of one coordinate decides, or nothing does."""
    points = np.full((5000, 3), 0.1)
    points[1234, 2] = np.nextafter(0.1, 1)
    formula = near_segment([Fraction(3)] * 3, [Fraction(4), Fraction(5), Fraction(6)])
    value, place = Cloud(points).greatest(formula)
    exact = [formula([Fraction(v) / Cloud(points).unit for v in points[i].tolist()], Fraction) for i in (0, 1234)]
    assert value == max(exact)
    assert (place == 1234) == (exact[1] > exact[0])
