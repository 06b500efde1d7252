"""Impacts in Pymunk: two bodies that touch, one step, and the velocities after it.

Chipmunk's solver has the formula of an impact once nothing else is asked of it. On Pymunk 7.3.1:

- A step in which nothing goes farther than 1e-15 of the coordinates: bodies are moved before contacts are looked for,
  so that the velocities are off by that way against the radii. Corrections of penetration are velocities of their own,
  and disturb nothing.
- An overlap of 1e-12 of the coordinates: circles that touch exactly are no contact.
- `collision_persistence` stays as it is: 0 forgets contacts before they are solved, and all bodies pass through.
- 1000 iterations: one contact without friction needs one; with friction, off the line of centres, the two impulses take
  turns.

The restitution and the friction of a contact are the products of those of the shapes. Friction ends the sliding that is
left after the bounce, as Bullet's does.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from oracles.engine import AnswerRow, Kind, Row, Solver, Tolerance, answer_row
from oracles.engines.pymunk_shapes import Placed, place, sizes_of
from oracles.motion import WIDTH, Motion, Moving

ITERATIONS = 1000
OVERLAP, WAY = 1e-12, 1e-15
"""How deep A is in B, and how far anything goes in the step, relative to the scene's largest coordinate."""
LONGEST_STEP = 1e-15
TOLERANCE = Tolerance.uniform(
    0.0, 1e-11, "the overlap moves the contact by 1e-12 of the coordinates, levers by as much"
)


class Thrown(NamedTuple):
    """A body as Pymunk is given it, with its shape about its middle; an immovable one has no mass."""

    placed: Placed
    mass: float
    moment: float
    position: list[float]
    velocity: list[float]
    spin: float
    restitution: float
    friction: float


def thrown(A: Kind, row_a: Row, B: Kind, row_b: Row) -> tuple[tuple[Thrown, Thrown], float]:
    """Both bodies of one scene, A a little in B; and how long the step is."""
    motion = Motion.unpack(np.array(row_a[-WIDTH:]))
    a, b = place(A, row_a[:-WIDTH]), place(B, row_b)
    normal = motion.normal[:2] / math.hypot(*motion.normal[:2])
    size = max(float(np.abs(motion.point).max()), *(abs(x) for p in (*a.points, *b.points) for x in p), a.radius)
    shift = (OVERLAP * size * normal).tolist()
    share, friction = float(motion.restitution), float(motion.friction)
    bodies = _thrown(a, motion.a, shift, share, friction), _thrown(b, motion.b, [0.0, 0.0], 1.0, 1.0)
    speed = max(max(map(abs, (*one.velocity, size * one.spin))) for one in bodies)
    return bodies, min(LONGEST_STEP, WAY * size / speed) if speed > 0 else LONGEST_STEP


def _thrown(placed: Placed, body: Moving, shift: list[float], restitution: float, friction: float) -> Thrown:
    x, y = body.position[:2].tolist()
    own = placed._replace(points=[[u - x, v - y] for u, v in placed.points])
    mass = 1.0 / float(body.inverse_mass) if body.inverse_mass > 0 else 0.0
    moment, spin = float(body.inertia[2, 2]), float(body.angular_velocity[2])
    at = [x + shift[0], y + shift[1]]
    return Thrown(own, mass, moment, at, body.velocity[:2].tolist(), spin, restitution, friction)


def solver(pymunk: Any, A: Kind, B: Kind) -> Solver:
    """Return a function that answers one scene, in about 60 µs."""

    def solve(row_a: Row, row_b: Row) -> AnswerRow:
        space = pymunk.Space()
        space.iterations = ITERATIONS
        bodies, (both, step) = [], thrown(A, row_a, B, row_b)
        for one in both:
            body = pymunk.Body(one.mass, one.moment) if one.mass else pymunk.Body(body_type=pymunk.Body.STATIC)
            body.position = one.position[0], one.position[1]
            if one.mass:
                body.velocity, body.angular_velocity = (one.velocity[0], one.velocity[1]), one.spin
            shape = getattr(pymunk, one.placed.geometry)(body, *sizes_of(one.placed))
            shape.elasticity, shape.friction = one.restitution, one.friction
            space.add(body, shape)
            bodies.append(body)
        space.step(step)
        (va, wa), (vb, wb) = (((*body.velocity, 0.0), (0.0, 0.0, body.angular_velocity)) for body in bodies)
        return answer_row(velocity_a=va, angular_a=wa, velocity_b=vb, angular_b=wb)

    return solve


SCRIPT = '''"""Pymunk: impact of {A} (a) and {B} (b)."""

from importlib.metadata import version

import pymunk

print("pymunk", version("pymunk"))
space = pymunk.Space()
space.iterations = {iterations}
bodies = []
{bodies}
space.step({step!r})
for name, body in zip("ab", bodies):
    print(f"velocity_{{name}} =", [*body.velocity, 0.0])
    print(f"angular_{{name}} =", [0.0, 0.0, body.angular_velocity])
'''


def script(A: Kind, row_a: Row, B: Kind, row_b: Row) -> str:
    """Write the script of one scene, with the calls that the solver makes."""
    both, step = thrown(A, row_a, B, row_b)
    bodies = "\n".join(map(_body, both))
    return SCRIPT.format(A=A.__name__, B=B.__name__, iterations=ITERATIONS, bodies=bodies, step=step)


def _body(one: Thrown) -> str:
    made = f"{one.mass!r}, {one.moment!r}" if one.mass else "body_type=pymunk.Body.STATIC"
    moving = f"body.velocity, body.angular_velocity = {tuple(one.velocity)!r}, {one.spin!r}\n" if one.mass else ""
    sizes = ", ".join(map(repr, sizes_of(one.placed)))
    return f"""body = pymunk.Body({made})
body.position = {tuple(one.position)!r}
{moving}shape = pymunk.{one.placed.geometry}(body, {sizes})
shape.elasticity, shape.friction = {one.restitution!r}, {one.friction!r}
space.add(body, shape)
bodies.append(body)
"""
