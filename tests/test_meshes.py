"""A mesh is taken when it bounds a solid, and refused with the place where it does not."""

import numpy as np
import pytest

from refimpl.meshes import MeshError, require_solid, shells, winding_numbers
from refimpl.signs import Points, on_grid
from tests.solids import SOLIDS, box, hollow_box, prism, together, torus, turned

BUTTERFLY = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_solids_are_taken(name, seed):
    vertices, triangles = SOLIDS[name] if seed is None else turned(SOLIDS[name], seed)
    require_solid(vertices, triangles)


@pytest.mark.parametrize("power", [-1000, -300, 300, 990])
def test_any_unit_will_do(power):
    vertices, triangles = turned(torus(), 5)
    require_solid(np.ldexp(vertices, power), triangles)


def test_an_open_mesh_names_the_edge():
    vertices, triangles = box()
    with pytest.raises(MeshError, match=r"open: the edge from vertex \d .* belongs only to face \d+ \(3 such edges\)"):
        require_solid(vertices, triangles[1:])


def test_a_flipped_face_is_named():
    vertices, triangles = box()
    triangles = triangles.copy()
    triangles[5] = triangles[5][::-1]
    with pytest.raises(MeshError, match=r"flipped: the edge .* run through in the same way by its faces .*5"):
        require_solid(vertices, triangles)


def test_an_inside_out_mesh_is_refused():
    vertices, triangles = torus()
    with pytest.raises(MeshError, match=r"flipped: the closed surface of 192 faces .* looks inwards"):
        require_solid(vertices, triangles[:, ::-1])


def test_a_cavity_that_looks_outwards_is_refused():
    inner = box((-0.5,) * 3, (0.5,) * 3)
    with pytest.raises(MeshError, match="looks outwards, but lies inside another surface"):
        require_solid(*together(box((-1,) * 3, (1,) * 3), inner))


def test_a_solid_in_a_cavity_is_taken():
    require_solid(*together(hollow_box(0.5), box((-0.2,) * 3, (0.2,) * 3)))


def test_three_faces_at_an_edge():
    vertices, triangles = box()
    with pytest.raises(MeshError, match=r"not a surface: the edge .* belongs to 3 faces: \d+, \d+, 12"):
        require_solid(vertices, np.concatenate([triangles, [[0, 1, 5]]]))


def test_a_face_without_area():
    vertices, triangles = box()
    with pytest.raises(MeshError, match=r"face 12 .* has no area \(1 such faces\)"):
        require_solid(vertices, np.concatenate([triangles, [[0, 1, 1]]]))


def test_a_face_of_next_to_no_area_is_taken():
    """A needle whose height is one unit in the last place: only exact arithmetic tells it from a line."""
    vertices = np.array([[0.1, 0.1, 0], [0.7, 0.7, 0], [0.3, np.nextafter(0.3, 1), 0], [0.3, 0.3, 1.0]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    require_solid(vertices, triangles)
    vertices[2, 1] = 0.3
    with pytest.raises(MeshError, match="has no area"):
        require_solid(vertices, triangles)


@pytest.mark.parametrize(
    "shift",
    [(0.5, 0.5, 0.5), (1.0, 0.25, 0.25), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0), (0.0, 0.0, 1.0)],
    ids=["through", "face on face", "edge on edge", "corner on corner", "same face"],
)
def test_two_boxes_that_meet(shift):
    other = box(shift, np.add(shift, 1.0))
    with pytest.raises(MeshError, match="meet beyond the corners they share"):
        require_solid(*together(box(), other))


@pytest.mark.parametrize("gap", [2.0**-52, 1e-9, 0.1])
def test_two_boxes_just_apart(gap):
    require_solid(*together(box(), box((1 + gap, 0, 0), (2, 1, 1))))


def test_a_face_that_dents_through_the_opposite_one():
    vertices, triangles = prism(BUTTERFLY)
    vertices = vertices.copy()
    vertices[3] = [-0.5, -0.5, 0.0]
    with pytest.raises(MeshError, match="self-intersecting: face"):
        require_solid(vertices, triangles)


def test_wrong_indices():
    vertices, triangles = box()
    with pytest.raises(MeshError, match="face 0 names vertex 9, but there are 8 vertices"):
        require_solid(vertices, np.where(triangles == 1, 9, triangles))
    with pytest.raises(MeshError, match=r"vertex 8 .* belongs to no face"):
        require_solid(np.concatenate([vertices, [[9.0, 9, 9]]]), triangles)
    with pytest.raises(MeshError, match="no faces"):
        require_solid(vertices, triangles[:0])


def test_surfaces_are_told_apart():
    vertices, triangles = together(box(), torus(), box((5, 5, 5), (6, 6, 6)))
    assert np.bincount(shells(triangles, len(vertices))).tolist() == [12, 192, 12]


def test_winding_numbers_of_points_above_edges_and_corners():
    """On the grid of the box's own coordinates every point is level with some corner, edge or face."""
    vertices, triangles = box((-1, -1, -1), (1, 1, 1))
    steps = np.array([-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0])
    points = np.array([[x, y, z] for x in steps for y in steps for z in steps])
    size = np.max(np.abs(points), axis=1)
    points = points[size != 1.0]
    found = winding_numbers(vertices[triangles], points)
    assert np.array_equal(found == 1, np.max(np.abs(points), axis=1) < 1)
    assert set(found.tolist()) == {0, 1}


def test_winding_numbers_in_a_torus():
    rng = np.random.default_rng(3)
    vertices, triangles = torus(96, 64)
    points = rng.uniform(-1.5, 1.5, (400, 3))
    tube = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1.0, points[:, 2])
    clear = np.abs(tube - 0.4) > 0.01
    found = winding_numbers(vertices[triangles], points[clear])
    assert np.array_equal(found == 1, tube[clear] < 0.4)
    assert found.sum() > 20


def test_signs_are_exact():
    """A point one unit in the last place beside a plane through awkward points, and on it."""
    a, b, c = np.array([0.1, 0.2, 0.3]), np.array([1.1, 0.2, 0.3]), np.array([0.1, 1.2, 0.3])
    above, below = np.array([0.37, 0.41, np.nextafter(0.3, 1)]), np.array([0.37, 0.41, np.nextafter(0.3, 0)])
    points = Points(np.stack([a, b, c, above, below, np.array([0.77, 0.13, 0.3])]))
    rows = np.arange(3)
    assert points.orientation(0 * rows, 0 * rows + 1, 0 * rows + 2, rows + 3).tolist() == [1, -1, 0]


def test_the_grid_holds_the_doubles():
    rng = np.random.default_rng(1)
    numbers = rng.normal(size=50) * 10.0 ** rng.integers(-20, 20, 50)
    whole, exponent = on_grid(np.append(numbers, 0.0))
    assert all(int(w) * 2.0**exponent == x for w, x in zip(whole, [*numbers, 0.0], strict=True))
