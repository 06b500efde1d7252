"""Sweeps of bodies that turn: against closed forms, fine stepping, themselves run otherwise, and made grazes."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import acos, asin, atan2, cos, findroot, hypot, mp, mpf, sin

from refimpl import (
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
    RigidMotion,
    Sphere,
    Translation,
    distance,
    intersect,
    sweep,
)
from refimpl.sweeps import rigid_march, rigid_pairs
from refimpl.sweeps.rigid_bodies import turning

STILL = (0.0, 0.0, 0.0, 1.0)
NARROW = 1e-9
FLOOR = HalfSpace([0.0, 1.0, 0.0], 0.0)
CORNERS = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
FACES = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]


def spin(rate, center=(0.0, 0.0, 0.0), linear=(0.0, 0.0, 0.0)):
    return RigidMotion(linear, [0.0, 0.0, rate], center)


def encloses(hit, time):
    return bool(hit.hit) and hit.t_lower <= time <= hit.t and hit.t - hit.t_lower <= NARROW


@pytest.mark.parametrize(("rate", "size"), [(3.0, 1.0), (17.0, 1e5), (100.0, 1e-5), (-100.0, 1.0)])
def test_a_sphere_on_an_orbit_meets_a_wall(rate, size):
    """The centre is at 2 cos t‖w‖, and touches the wall behind −1.5 with the radius 0.25."""
    with mp.workdps(50):
        time = acos(mpf(-1.25) / 2) / abs(mpf(rate))
    ball, wall = Sphere([2.0 * size, 0.0, 0.0], 0.25 * size), HalfSpace([1.0, 0.0, 0.0], 1.5 * size)
    hit = sweep(ball, wall, spin(rate))
    assert encloses(hit, time)
    assert np.allclose(hit.normal, [-1.0, 0.0, 0.0], atol=1e-6)
    assert np.allclose(hit.point[0], -1.5 * size, rtol=1e-6)
    assert encloses(sweep(wall, ball, None, spin(rate)), time)
    assert abs(rate) > 20 or not sweep(ball, HalfSpace([1.0, 0, 0], 2.26 * size), spin(rate)).hit


@pytest.mark.parametrize("rate", [1.25, 5.0, 100.0])
def test_a_corner_of_a_spinning_box_meets_the_floor(rate):
    """The lowest corner sinks below the box's middle by hypot·sin(atan(½) + t‖w‖)."""
    box = Box([0.0, 1.1, 0.0], [1.0, 0.5, 0.3], STILL)
    with mp.workdps(50):
        time = (asin(mpf(1.1) / hypot(1, mpf(0.5))) - atan2(mpf(0.5), 1)) / mpf(rate)
    assert encloses(sweep(box, FLOOR, spin(rate, (0.0, 1.1, 0.0))), time)
    assert encloses(sweep(FLOOR, box, spin(-rate, (0.0, 1.1, 0.0))), _turned_floor(rate))


def _turned_floor(rate):
    """The floor turns under the box instead, about the box's middle, to which it stays 1.1 away."""
    with mp.workdps(50):
        return (asin(mpf(1.1) / hypot(1, mpf(0.5))) - atan2(mpf(0.5), 1)) / mpf(rate)


def test_two_spheres_on_orbits_about_far_pivots():
    """Both turn about pivots 1000 away; their distance is a trigonometric equation."""
    a, b = Sphere([-1.0, 0.0, 0.0], 0.25), Sphere([1.0, 0.5, 0.0], 0.5)
    motions = spin(0.002, (-1.0, -1000.0, 0.0)), spin(0.003, (1.0, 1000.0, 0.0))
    with mp.workdps(50):

        def gap(t):
            p, q = mpf(0.002) * t, mpf(0.003) * t
            x, y = 2 + mpf(999.5) * sin(q) + 1000 * sin(p), (1000 - mpf(999.5) * cos(q)) - (-1000 + 1000 * cos(p))
            return hypot(x, y) - mpf(0.75)

        assert gap(1) > 0
        reverse = findroot(lambda t: gap(-t), (0.25, 0.3), solver="anderson")
    assert not sweep(a, b, *motions).hit
    assert encloses(sweep(a, b, *(RigidMotion(m.linear, -m.angular, m.center) for m in motions)), reverse)


def test_thin_rods_that_spin_past_each_other_are_met():
    """Six turns: whoever looks at the ends alone, or in steps, sees nothing."""
    rod = Capsule([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1e-4)
    post = Capsule([0.0, 0.9, -1.0], [0.0, 0.9, 1.0], 1e-4)
    hit = sweep(rod, post, spin(12 * np.pi))
    with mp.workdps(50):
        time = (mp.pi / 2 - asin(mpf(2e-4) / mpf(0.9))) / mpf(12 * np.pi)
    assert encloses(hit, time)
    assert not sweep(rod, Capsule([0.0, 1.0003, -1.0], [0.0, 1.0003, 1.0], 1e-4), spin(12 * np.pi)).hit


def test_contact_at_the_ends_of_time():
    a, b = Sphere([0.0, 0.0, 0.0], 1.0), Box([2.0, 0.0, 0.0], [1.0, 1.0, 1.0], STILL)
    start = sweep(a, b, spin(1.0), spin(2.0, (2.0, 0.0, 0.0)))
    assert start.hit
    assert start.t == start.t_lower == 0
    assert np.all(np.isnan(start.normal))
    assert np.allclose(start.point, [1.0, 0.0, 0.0])
    end = sweep(a, b.translated([0.5, 0.0, 0.0]), RigidMotion([0.5, 0, 0], [1.0, 0, 0], [0.0, 0.0, 0.0]))
    assert end.hit
    assert 1 - NARROW <= end.t_lower <= end.t <= 1
    assert not sweep(a, b.translated([0.5 + 1e-9, 0, 0]), RigidMotion([0.5, 0, 0], [1.0, 0, 0], [0.0, 0, 0])).hit


def test_half_spaces():
    """They stay apart only as long as they face each other exactly."""
    floor, ceiling = FLOOR, HalfSpace([0.0, -2.0, 0.0], 2.0)
    assert not sweep(floor, ceiling, spin(3.0), spin(3.0)).hit
    assert not sweep(floor, ceiling, RigidMotion([0.0] * 3, [0.0, 5.0, 0.0], [1.0, 0.0, 0.0])).hit
    falling = sweep(floor, ceiling, None, RigidMotion([0.0, -4.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 0.0]))
    assert encloses(falling, 0.25)
    tilting = sweep(floor, ceiling, spin(1e-3))
    assert encloses(tilting, tilting.t)
    assert tilting.t_lower == 0
    orbit = sweep(floor, ceiling, spin(3.0), spin(3.0, (1.0, 0.5, 0.0)))  # the ceiling comes round its own pivot
    with mp.workdps(50):  # n·d + 1: the pivots are (1, ½) apart
        time = findroot(lambda t: (-sin(3 * t) + cos(3 * t) / 2) + mpf(1) / 2, 0.3)
    assert encloses(orbit, time)


# ------------------------------------------------------------------------------------- random scenes

COUNT = 16


def _rows(draw, count=COUNT):
    """Shapes of all convex types about the origin, and about a place 3 away."""
    center = lambda: draw.uniform(-1, 1, (count, 3))  # noqa: E731
    away = np.array([3.0, 0.0, 0.0])
    turn = draw.normal(size=(count, 4))
    p = center()
    return {
        Point: Point(center()),
        Sphere: Sphere(center(), draw.uniform(0.1, 1, count)),
        Capsule: Capsule(p, p + draw.normal(size=(count, 3)), draw.uniform(0.05, 0.5, count)),
        HalfSpace: HalfSpace(draw.normal(size=(count, 3)), draw.uniform(-1, 4, count)),
        AABB: AABB(p + away, p + away + draw.uniform(0.1, 1, (count, 3))),
        Box: Box(center() + away, draw.uniform(0.0, 1, (count, 3)), turn),
        KDOP: KDOP.around(draw.normal(size=(count, 8, 3)) * 0.5 + away),
        Ellipsoid: Ellipsoid(center() + away, draw.uniform(0.1, 1, (count, 3)), turn),
        Cylinder: Cylinder(center(), center() + np.array([2.0, 0, 0]), draw.uniform(0.05, 0.5, count)),
        ConvexPolyhedron: ConvexPolyhedron.from_vertices(draw.normal(size=(count, 7, 3)) * 0.6, center() + away, turn),
    }


def _motion(draw, rate, count=COUNT):
    linear, angular, center = draw.normal(size=(3, count, 3))
    return RigidMotion(2 * linear, rate * angular, center)


PAIRS = [
    (Sphere, Box, 3.0),
    (Point, ConvexPolyhedron, 3.0),
    (Capsule, Box, 20.0),
    (HalfSpace, Cylinder, 3.0),
    (HalfSpace, KDOP, 10.0),
    (Sphere, Ellipsoid, 3.0),
    (Cylinder, AABB, 3.0),
    (Capsule, KDOP, 3.0),
]


@pytest.fixture(scope="module")
def swept():
    """Rows of each pair, their motions, and what the sweep answers."""
    draw = np.random.default_rng(7)
    found = []
    for one, other, rate in PAIRS:
        shapes = _rows(draw)
        a, b = shapes[one], shapes[other]
        motions = _motion(draw, rate), _motion(draw, rate)
        found.append((a, b, *motions, sweep(a, b, *motions)))
    return found


def turnable(shape):
    """The same set as a type that turns without a new hull for each place."""
    if isinstance(shape, KDOP):
        return ConvexPolyhedron.from_vertices(shape.hull.vertices)
    return shape.to_box() if isinstance(shape, AABB) else shape


def test_intervals_are_narrow_and_hold_a_contact(swept):
    """At `t` the bodies touch, at `t_lower` they do not; and many do meet on their way."""
    met = 0
    for a, b, one, other, hit in swept:
        late = np.flatnonzero(hit.hit & (hit.t > 0))
        met += len(late)
        assert np.all(hit.t[late] - hit.t_lower[late] <= NARROW)
        assert np.all(np.isinf(hit.t[~hit.hit]) & np.isinf(hit.t_lower[~hit.hit]))
        for times, low, high in ((hit.t, -1e-8, 0.0), (hit.t_lower, 0.0, 1e-8)):
            x, y = (m[late].placed(turnable(s)[late], times[late]) for s, m in ((a, one), (b, other)))
            gaps = distance(x, y).distance
            assert np.all((low <= gaps) & (gaps <= high))
    assert met > 20


def test_fine_stepping_finds_nothing_before(swept):
    for a, b, one, other, hit in swept:
        rows = np.flatnonzero(hit.t > 0)
        end = np.minimum(hit.t_lower, 1.0)[rows, None] * np.linspace(0, 1, 24)[None, :-1]
        x, y = (m[rows, None].placed(turnable(s)[rows, None], end) for s, m in ((a, one), (b, other)))
        assert not np.any(intersect(x, y))


def test_one_row_is_the_pair_alone_bit_for_bit(swept):
    for a, b, one, other, hit in swept[:5]:
        for i in range(0, COUNT, 8):
            alone = sweep(a[i], b[i], one[i], other[i])
            for name in ("hit", "t", "t_lower", "point", "normal"):
                assert np.array_equal(getattr(alone, name), getattr(hit, name)[i], equal_nan=True)
            swapped = sweep(b[i], a[i], other[i], one[i])
            assert swapped.hit == alone.hit
            assert not alone.hit or max(swapped.t_lower, alone.t_lower) <= min(swapped.t, alone.t)


def _part(shape, motion, start, end):
    """The motion between two times as one from 0 to 1, and the shape at its start."""
    length = end - start
    center = motion.center + start * motion.linear
    return motion.placed(turnable(shape), start), RigidMotion(length * motion.linear, length * motion.angular, center)


def test_a_motion_in_two_parts(swept):
    """The first half meets up to half time, or else the second half as the whole does."""
    for a, b, one, other, hit in swept[:3]:
        halves = [[_part(s, m, start, start + 0.5) for s, m in ((a, one), (b, other))] for start in (0.0, 0.5)]
        first, second = (sweep(x, y, m, k) for (x, m), (y, k) in halves)
        expected = np.where(first.hit, first.t / 2, 0.5 + second.t / 2)
        assert np.array_equal(np.isfinite(expected), hit.hit)
        assert np.all(np.abs(expected[hit.hit] - hit.t[hit.hit]) <= 2 * NARROW)


def test_backwards(swept):
    """From the other end of time the first contact is the last: it is no earlier; and none stays none."""
    for a, b, one, other, hit in swept[2:5]:
        (x, _), (y, _) = (_part(s, m, 1.0, 1.0) for s, m in ((a, one), (b, other)))
        back = [RigidMotion(-m.linear, -m.angular, m.center + m.linear) for m in (one, other)]
        found = sweep(x, y, *back)
        assert np.array_equal(found.hit, hit.hit)
        assert np.all(1.0 - found.t_lower[hit.hit] >= hit.t_lower[hit.hit] - NARROW)


def test_rotation_by_nothing_is_translation():
    draw = np.random.default_rng(11)
    shapes = _rows(draw)
    a, b, way = shapes[Capsule], shapes[Box], draw.normal(size=(COUNT, 3)) + np.array([3.0, 0.0, 0.0])
    plain = sweep(a, b, Translation(way))
    rigid = sweep(a, b, RigidMotion(way, np.zeros(3), np.ones(3)))
    assert np.array_equal(plain.hit, rigid.hit)
    assert np.sum(plain.hit) > 3
    assert np.all(np.abs(plain.t[plain.hit] - rigid.t[plain.hit]) <= NARROW)


# --------------------------------------------------------------------------------------------- grazes


def test_no_graze_is_missed():
    """Balls that come no nearer than by an ε to a wall or ball, where ε ≤ 0: none may be answered with "no hit".

    The centre circles at 1 about the origin and is lowest at a known time; the floor is `radius + ε` below that.
    """
    draw = np.random.default_rng(5)
    n = 48
    rate, start = draw.uniform(2, 30, n), draw.uniform(0.1, 1.0, n)
    radius = draw.uniform(0.05, 0.5, n)
    depth = np.concatenate([np.zeros(n // 3), 10.0 ** draw.uniform(-18, -8, n - n // 3)])
    motion = RigidMotion(np.zeros(3), np.stack([0 * rate, 0 * rate, rate], -1), np.zeros(3))
    ball = Sphere(np.stack([-np.sin(start), -np.cos(start), 0 * start], -1), radius)
    reach = np.hypot(ball.center[:, 0], ball.center[:, 1])
    floor = HalfSpace([0.0, 1.0, 0.0], reach + radius - depth)
    hit = sweep(ball, floor, motion)
    assert np.all(hit.hit)
    low = np.mod(-np.pi / 2 - np.arctan2(ball.center[:, 1], ball.center[:, 0]), 2 * np.pi) / rate
    graze = np.arcsin(np.minimum(1.0, np.sqrt(2 * depth / reach))) / rate
    first = low - graze
    assert np.all((hit.t_lower <= first + 1e-9) & (first - 1e-9 <= hit.t) & (first <= 1.6))
    clear = depth > 1e-10  # below, what rounding leaves open is longer than that: about 1e-14 over the rate
    assert np.all(hit.t[clear] - hit.t_lower[clear] <= NARROW)
    assert np.sum(clear) > 3
    away = HalfSpace([0.0, 1.0, 0.0], reach + radius + 1e-13)
    assert not np.any(sweep(ball, away, motion).hit)


def test_an_undecided_graze_of_a_union_leaves_both_ends_open():
    """A ball just grazes a floor, which doubles cannot tell, and later hits a ball: it is one of the two times."""
    ball, floor, post = Sphere([1.0, 0, 0], 0.25), HalfSpace([0.0, 1.0, 0.0], 1.25), Sphere([-1.0, -0.5, 0.0], 0.1)
    graze, later = sweep(ball, floor, spin(-3.0)), sweep(ball, post, spin(-3.0))
    assert graze.t_lower <= np.pi / 6 <= graze.t
    assert later.t - later.t_lower <= NARROW
    both = sweep(ball, Composite([floor, post]), spin(-3.0))
    assert (both.t_lower, both.t) == (graze.t_lower, later.t)
    alone = sweep(Composite([ball]), floor, spin(-3.0))
    assert (alone.hit, alone.t_lower, alone.t) == (True, graze.t_lower, graze.t)


# ------------------------------------------------------------------------------------ unions and means


def test_a_union_meets_with_its_first_piece():
    """A propeller of two blades, and the same as a mesh and as its parts alone."""
    blades = [Box([1.0, 0.0, 0.0], [0.4, 0.05, 0.1], STILL), Box([-1.5, 0.0, 0.0], [0.5, 0.05, 0.1], STILL)]
    post = Sphere([0.0, 1.7, 0.0], 0.2)
    whole = sweep(Composite(blades), post, spin(-4.0))
    each = [sweep(blade, post, spin(-4.0)) for blade in blades]
    assert (each[0].hit, each[1].hit) == (False, True)
    assert (whole.t, whole.t_lower) == (each[1].t, each[1].t_lower)
    solid, hull = Polyhedron(CORNERS, FACES), ConvexPolyhedron.from_vertices(CORNERS)
    motion = RigidMotion([3.0, 1.0, 0.0], [1.0, 2.0, 3.0], [0.5, 0.0, 0.0])
    for other in (Sphere([3.0, 1.0, 0.0], 0.7), FLOOR.translated([0.0, -1.1, 0.0])):
        mesh, convex = sweep(solid, other, motion), sweep(hull, other, motion)
        assert mesh.hit
        assert max(mesh.t_lower, convex.t_lower) <= min(mesh.t, convex.t)


def test_steps_are_few_and_converge_quadratically(swept):
    """Moderate rotations take some ten steps; a constant rate of convergence would take over thirty to 1e-10."""
    a, b, one, other, hit = swept[0]
    rows = np.flatnonzero(hit.t > 0)
    pairs = rigid_pairs.paired(turning(a[rows], one[rows]), turning(b[rows], other[rows]))
    times = rigid_march.first_contacts(pairs, np.ones(len(rows)))
    assert np.all(times.decided)
    assert np.mean(times.steps) < 12
    assert np.max(times.steps) <= 40


@pytest.mark.parametrize(("one", "other"), [(Capsule, Box), (HalfSpace, ConvexPolyhedron), (HalfSpace, Sphere)])
def test_the_gap_never_falls_below_its_bound(one, other):
    """Between two times the gap stays above its chord less λ(1 − λ)·S²/2·bend; a bound of a tenth of that is broken."""
    draw = np.random.default_rng(3)
    shapes = _rows(draw, 40)
    bodies = [turning(shapes[kind], _motion(draw, 3.0, 40)) for kind in (one, other)]
    pairs = rigid_pairs.paired(*bodies)
    t0 = draw.uniform(0, 0.5, 40)
    t1 = t0 + draw.uniform(0.01, 0.5, 40)
    n0, n1 = (n / np.linalg.norm(n, axis=-1)[:, None] for n in draw.normal(size=(2, 40, 3)))
    bend = pairs.bend(n0, n1, t0, t1) * (t1 - t0) ** 2 / 2
    ends, broken = (pairs.gap(n0, t0), pairs.gap(n1, t1)), False
    for share in np.linspace(0.1, 0.9, 9):
        n = (1 - share) * n0 + share * n1
        chord = (1 - share) * ends[0] + share * ends[1]
        gap = pairs.gap(n, t0 + share * (t1 - t0))
        assert np.all(gap >= chord - share * (1 - share) * bend - 1e-9)
        broken |= bool(np.any(gap < chord - share * (1 - share) * bend / 10 - 1e-9))
    assert broken
