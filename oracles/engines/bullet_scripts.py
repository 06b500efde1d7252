"""Scripts that ask PyBullet alone for one scene, with the calls that `bullet_world` makes."""

from __future__ import annotations

from oracles.engine import Row
from oracles.engines import geometry
from oracles.engines.bullet_shapes import COMPOUND, HULL, MESH, Placed, compound_arguments, ray_at, ray_end
from oracles.engines.bullet_world import FAR, SURFACES, comes_second
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST

SCRIPT = '''"""Bullet: {query} of {A} (a) and {B} (b)."""

from importlib.metadata import version

import pybullet

print("pybullet", version("pybullet"))
pybullet.connect(pybullet.DIRECT)
{body}'''


def script(query: str, names: tuple[str, str], ray: Row, a: list[Placed], b: list[Placed]) -> str:
    """Write the script; `a` is empty for a ray, and `ray` for anything else."""
    if query == RAYCAST:
        body = _cast(ray, b)
    elif query == CONTACTS:
        body = _contacts(a, b)
    else:
        body = _closest(query, a, b)
    return SCRIPT.format(query=query, A=names[0], B=names[1], body=body)


def shape_text(placed: Placed) -> str:
    """Python text that makes the collision shape."""
    if placed.geometry == HULL:
        points = geometry.vertices(placed.key).tolist()
        return f"pybullet.createCollisionShape(\n    pybullet.GEOM_MESH, vertices={points!r}\n)"
    if placed.geometry == MESH:
        vertices, triangles = geometry.mesh(placed.key)
        corners = f"vertices={vertices.tolist()!r},\n    indices={triangles.ravel().tolist()!r}"
        flags = "flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH"
        return f"pybullet.createCollisionShape(\n    pybullet.GEOM_MESH,\n    {corners},\n    {flags},\n)"
    if placed.geometry == COMPOUND:
        types = ", ".join(f"pybullet.{child.geometry}" for child in placed.children)
        sizes = "".join(f"    {name}={values!r},\n" for name, values in compound_arguments(placed).items())
        return f"pybullet.createCollisionShapeArray(\n    shapeTypes=[{types}],\n{sizes})"
    sizes = ", ".join(f"{key}={value!r}" for key, value in placed.sizes.items())
    return f"pybullet.createCollisionShape(pybullet.{placed.geometry}, {sizes})"


def _side(name: str, placed: list[Placed]) -> str:
    """Lines that make the list of one side: shape, position, orientation, and what its radius has too much."""
    text = f"{name} = []  # shape, position, orientation, and the part of its radius that is taken off again\n"
    for part in placed:
        stands = f"{part.position!r}, {part.orientation!r}, {part.extra!r}"
        text += f"shape = {shape_text(part)}\n{name}.append((shape, {stands}))\n"
    return text


BEST = """if not found:
    raise RuntimeError("PyBullet returned no closest point")
distance, on_a, on_b, normal = min(found, key=lambda one: one[0])
print("distance =", repr(distance))
print("on_a =", on_a)
print("on_b =", on_b)
print("normal =", normal)
"""
ADD = """def add(points, first, second, swapped):
    for point in points:
        normal = [-u for u in point[7]]  # from the first to the second
        on_first = [u - first[3] * n for u, n in zip(point[5], normal)]
        on_second = [u + second[3] * n for u, n in zip(point[6], normal)]
        distance = point[8] + (first[3] + second[3])
        if swapped:
            found.append((distance, on_second, on_first, [-u for u in normal]))
        else:
            found.append((distance, on_first, on_second, normal))


found = []  # distance, on a, on b, normal from a to b
"""


def _closest(query: str, a: list[Placed], b: list[Placed]) -> str:
    order = [(i, j, query == DISTANCE and comes_second(x, y)) for i, x in enumerate(a) for j, y in enumerate(b)]
    pairs = ", ".join(f"(b[{j}], a[{i}], True)" if swapped else f"(a[{i}], b[{j}], False)" for i, j, swapped in order)
    text = _side("a", a) + _side("b", b) + ADD
    if any(swapped for *_, swapped in order):
        text += "# Of shapes without bodies, compounds and hulls come back first, and planes and meshes last.\n"
    text += f"""for first, second, swapped in [{pairs}]:
    points = pybullet.getClosestPoints(
        bodyA=-1,
        bodyB=-1,
        distance={FAR if query == DISTANCE else 0.0},
        collisionShapeA=first[0],
        collisionShapeB=second[0],
        collisionShapePositionA=first[1],
        collisionShapePositionB=second[1],
        collisionShapeOrientationA=first[2],
        collisionShapeOrientationB=second[2],
    )
    add(points, first, second, swapped)
"""
    return text + ('print("hit =", float(len(found) > 0))\n' if query == BOOLEAN else BEST)


def _contacts(a: list[Placed], b: list[Placed]) -> str:
    movable = any(part.geometry in SURFACES for part in b)
    text = _side("a", a) + _side("b", b) + _bodies("a", a, movable) + _bodies("b", b, not movable) + ADD
    text += """pybullet.performCollisionDetection()
for first, body_a in zip(a, bodies_a):
    for second, body_b in zip(b, bodies_b):
        add(pybullet.getContactPoints(body_a, body_b), first, second, False)
found = [one for one in found if one[0] <= 0]
print("hit =", float(len(found) > 0))
if found:
"""
    return text + "".join(f"    {line}\n" for line in BEST.splitlines())


def _bodies(name: str, placed: list[Placed], movable: bool) -> str:
    mass = float(movable and not any(part.geometry in SURFACES for part in placed))
    return (
        f"bodies_{name} = [pybullet.createMultiBody({mass!r}, shape, -1, at, turn) for shape, at, turn, _ in {name}]\n"
    )


SWEEP = """body, _, t, point, normal = pybullet.rayTest({start!r}, {end!r})[0]
along = {along!r}  # how b moves, from which the ray is seen
print("hit =", float(body >= 0))
print("t =", repr(t if body >= 0 else float("inf")))
if body >= 0:
    print("normal =", [-u for u in normal])
    print("point =", [u + t * v for u, v in zip(point, along)])
"""


def sweep_script(names: tuple[str, str], ray: Row, along: list[float], b: list[Placed]) -> str:
    """Write the script of a moving Point."""
    ask = SWEEP.format(start=ray[:3], end=ray_at(ray, 1.0), along=along)
    body = f"{_side('b', b)}{_bodies('b', b, True)}{ask}"
    return SCRIPT.format(query="sweep", A=names[0], B=names[1], body=body)


def _cast(ray: Row, b: list[Placed]) -> str:
    end = max(ray_end(ray, part) for part in b)
    return f"""{_side("b", b)}{_bodies("b", b, True)}end = {end!r}  # the ray is past b
body, _, fraction, point, normal = pybullet.rayTest({ray[:3]!r}, {ray_at(ray, end)!r})[0]
print("hit =", float(body >= 0))
print("t =", repr(fraction * end if body >= 0 else float("inf")))
if body >= 0:
    print("normal =", list(normal))
    print("point =", list(point))
"""
