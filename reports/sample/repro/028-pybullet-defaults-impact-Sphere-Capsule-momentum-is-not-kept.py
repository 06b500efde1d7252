#!/usr/bin/env python3
# pybullet-defaults · impact · Sphere–Capsule · momentum is not kept · fast · 1e-2
"""pybullet-defaults, impact of Sphere (A) and Capsule (B): momentum is not kept.

pybullet-defaults answers velocity_a [37.80571210198698, 0.0, 0.0], angular_a [0.0, 0.0, 0.0], velocity_b
[37.80811210198698, 0.0, 66.08130549999463], angular_b [0.0, 0.0, 0.0]: momentum is not kept. No velocities
nearer than 0.766 to these fulfil the law.

    python FILE                       asks pybullet-defaults, and judges its answer
    python FILE "distance = 3.0" ...  judges this answer instead

The engine is asked in a process of its own, which may crash, and is ended after 10 seconds. What is true need not
be believed: this file holds a certificate, and checks it in exact arithmetic with nothing but the standard library.
Exit status: 1 while the answer is wrong, 0 once it is right, 2 if the engine is not installed or the certificate does
not hold.
"""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from fractions import Fraction
from importlib.util import find_spec
from typing import Any

# ---- 1. The engine, called as its users call it ------------------------------------------------------------------

def ask():
    """Bullet: impact of Sphere (a) and Capsule (b), with its default settings."""

    from importlib.metadata import version

    import pybullet

    print("pybullet", version("pybullet"))
    pybullet.connect(pybullet.DIRECT)

    bodies = []
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=1.0)
    body = pybullet.createMultiBody(1.0, shape, -1, [2.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])
    pybullet.changeDynamics(
        body,
        -1,
        restitution=0.0,
        lateralFriction=0.0,
    )
    pybullet.resetBaseVelocity(body, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    bodies.append(body)

    shape = pybullet.createCollisionShape(pybullet.GEOM_CAPSULE, radius=1.0, height=2.0)
    body = pybullet.createMultiBody(5.0, shape, -1, [0.0, 0.0, 0.0], [-0.0, 0.0, 0.0, 1.0])
    pybullet.changeDynamics(
        body,
        -1,
        restitution=1.0,
        lateralFriction=1.0,
    )
    pybullet.resetBaseVelocity(body, [46.0, 0.0, 67.0], [0.0, 0.0, 0.0])
    bodies.append(body)

    pybullet.stepSimulation()
    for name, body in zip("ab", bodies):
        velocity, angular = pybullet.getBaseVelocity(body)
        print(f"velocity_{name} =", list(velocity))
        print(f"angular_{name} =", list(angular))


# ---- 2. The scene, what was answered, and what proves it wrong ---------------------------------------------------

ANSWER = {
    "velocity_a": [37.80571210198698, 0.0, 0.0],
    "angular_a": [0.0, 0.0, 0.0],
    "velocity_b": [37.80811210198698, 0.0, 66.08130549999463],
    "angular_b": [0.0, 0.0, 0.0],
}
RIGHT = {
    "velocity_a": [38.333333333333336, 0.0, 0.0],
    "angular_a": [0.0, 0.0, 0.0],
    "velocity_b": [38.333333333333336, 0.0, 67.0],
    "angular_b": [0.0, 0.0, 0.0],
}
MOTIONS = [
    {
        "a": {
            "position": [2.0, 0.0, 0.0],
            "velocity": [0.0, 0.0, 0.0],
            "angular_velocity": [0.0, 0.0, 0.0],
            "inverse_mass": 1.0,
            "inertia": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        },
        "b": {
            "position": [0.0, 0.0, 0.0],
            "velocity": [46.0, 0.0, 67.0],
            "angular_velocity": [0.0, 0.0, 0.0],
            "inverse_mass": 0.2,
            "inertia": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        },
        "point": [1.0, 0.0, 0.0],
        "normal": [-1.0, 0.0, 0.0],
        "restitution": 0.0,
        "friction": 0.0,
    },
    {
        "a": {
            "position": [2.0, 0.0, 0.0],
            "velocity": [0.0, 0.0, 0.0],
            "angular_velocity": [0.0, 0.0, 0.0],
            "inverse_mass": 1.0,
            "inertia": [[0.4, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 0.4]],
        },
        "b": {
            "position": [0.0, 0.0, 0.0],
            "velocity": [46.0, 0.0, 67.0],
            "angular_velocity": [0.0, 0.0, 0.0],
            "inverse_mass": 0.2,
            "inertia": [
                [8.333333333333334, 0.0, 0.0],
                [0.0, 8.333333333333334, 0.0],
                [0.0, 0.0, 3.333333333333334],
            ],
        },
        "point": [1.0, 0.0, 0.0],
        "normal": [-1.0, 0.0, 0.0],
        "restitution": 0.0,
        "friction": 0.0,
    },
]
MOST = 0.34
ALLOWED = "pybullet-defaults is allowed an error of 0.34"
SYMPTOM = "momentum is not kept"
NEEDED = [["pybullet", "pip install pybullet"]]
NAMES = ["velocity_a", "angular_a", "velocity_b", "angular_b"]


# ---- 3. The exact checker ----------------------------------------------------------------------------------------

Vector = Sequence[Any]

class Refused(Exception):
    """The certificate does not hold."""

def require(condition: object, text: str) -> None:
    """Refuse what does not meet a condition."""
    if not condition:
        raise Refused(text)

def number(value: Any) -> Fraction:
    """Take a double or an integer as the rational that it is, and a text such as '1/3'."""
    if isinstance(value, str):
        above, _, below = value.partition("/")
        return Fraction(int(above, 0), int(below or "1", 0))
    require(not isinstance(value, float) or math.isfinite(value), f"not a number: {value!r}")
    return Fraction(value)

def vector(values: Any) -> list[Fraction]:
    """Take three numbers."""
    require(len(values) == 3, f"not three numbers: {values!r}")
    return [number(value) for value in values]

def dot(u: Vector, v: Vector) -> Any:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]

def cross(u: Vector, v: Vector) -> list[Any]:
    """Vector product."""
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]

def minus(u: Vector, v: Vector) -> list[Any]:
    """Difference u − v."""
    return [u[0] - v[0], u[1] - v[1], u[2] - v[2]]

def along(u: Vector, t: Any, v: Vector) -> list[Any]:
    """Point u + t v."""
    return [u[0] + t * v[0], u[1] + t * v[1], u[2] + t * v[2]]

def times(t: Any, v: Vector) -> list[Any]:
    """Multiple t v."""
    return [t * v[0], t * v[1], t * v[2]]

def total(v: Vector) -> Any:
    """Sum of the absolute coordinates: at least the length, at most its double."""
    return abs(v[0]) + abs(v[1]) + abs(v[2])

def most(v: Vector) -> Any:
    """Largest absolute coordinate."""
    return max(abs(v[0]), abs(v[1]), abs(v[2]))

def ratio(above: Any, below: Any) -> Any:
    """Quotient; 0 where the divisor is 0."""
    return above / below if below else 0 * above

class Change:
    """What became of one body."""

    def __init__(self, body: Any, velocity: Any, spin: Any, point: Vector) -> None:
        self.before, self.spin_before = vector(body["velocity"]), vector(body["angular_velocity"])
        self.after, self.spin = vector(velocity), vector(spin)
        self.w, self.inertia = number(body["inverse_mass"]), [vector(row) for row in body["inertia"]]
        self.lever = minus(point, vector(body["position"]))
        self.dv, self.dw = minus(self.after, self.before), minus(self.spin, self.spin_before)

    @property
    def moved(self) -> Any:
        """Largest change of any velocity."""
        return max(most(self.dv), most(self.dw) * total(self.lever))

    def at_contact(self, velocity: Vector, spin: Vector) -> list[Any]:
        """Velocity of the point of contact; an immovable body keeps its own."""
        if not self.w:
            velocity, spin = self.before, self.spin_before
        return along(velocity, 1, cross(spin, self.lever))

    def against(self, direction: Vector) -> Any:
        """By how much the contact's velocity along a direction grows, at most, when all velocities change by 1."""
        if not self.w:
            return 0 * self.w
        return total(direction) + ratio(total(cross(self.lever, direction)), total(self.lever))

    def angular(self) -> Any:
        """Breach of I Δω = r × m Δv."""
        reach, found = total(self.lever), [0 * self.w]
        turned = cross(self.lever, self.dv)
        for row, lever, turn in zip(self.inertia, self.lever, turned, strict=True) if self.w else ():
            weight = ratio(1, reach) * self.w * total(row) + reach - abs(lever)
            found.append(ratio(abs(self.w * dot(row, self.dw) - turn), weight))
        return max(found)

    def energy(self) -> tuple[Any, Any]:
        """Energy gained, and by how much, at most, it falls when all velocities change by 1."""
        if not self.w:
            return 0 * self.w, 0 * self.w
        momentum, old = ([dot(row, spin) for row in self.inertia] for spin in (self.spin, self.spin_before))
        moving = (dot(self.after, self.after) - dot(self.before, self.before)) / self.w
        turning = dot(self.spin, momentum) - dot(self.spin_before, old)
        return (moving + turning) / 2, total(self.after) / self.w + ratio(total(momentum), total(self.lever))

    def pushed(self, impulse: Vector) -> list[Any]:
        """Change of the contact's velocity by an impulse there."""
        x, y, z = self.inertia
        turn, volume = cross(self.lever, impulse), dot(x, cross(y, z))
        found = times(self.w, impulse)
        if self.w and volume:
            spin = [dot(turn, cross(y, z)), dot(x, cross(turn, z)), dot(x, cross(y, turn))]
            found = along(found, 1 / volume, cross(spin, self.lever))
        return found

def breaches(motion: Any, answer: Any) -> Iterator[tuple[str, Any]]:
    """Every law of an impact that applies, and by how much velocities break it."""
    point, n = vector(motion["point"]), vector(motion["normal"])
    e, mu = number(motion["restitution"]), number(motion["friction"])
    a = Change(motion["a"], answer["velocity_a"], answer["angular_a"], point)
    b = Change(motion["b"], answer["velocity_b"], answer["angular_b"], point)
    before = [along(c.before, 1, cross(c.spin_before, c.lever)) for c in (a, b)]
    closing = dot(minus(before[1], before[0]), n)
    if closing >= 0 or not (a.w or b.w):
        yield "velocities of bodies that part are changed", max(a.moved, b.moved)
        return
    give = a.against(n) + b.against(n)
    if not (a.moved or b.moved):
        yield "impact missed: no velocity changes", ratio(-(1 + e) * closing, give)
    if not (a.w and b.w):
        yield "immovable body is moved", max(c.moved for c in (a, b) if not c.w)
    impulse = b.dv if b.w >= a.w else times(-1, a.dv)  # by the mass of the lighter body
    yield "the bodies pull at each other", ratio(-dot(impulse, n), total(n))
    if a.w and b.w:
        yield "momentum is not kept", most(along(times(b.w, a.dv), a.w, b.dv)) / (a.w + b.w)
    yield "angular momentum about the contact is not kept", max(a.angular(), b.angular())
    apart = minus(b.at_contact(b.after, b.spin), a.at_contact(a.after, a.spin))
    leaving = dot(apart, n) + e * closing
    yield "bounces faster than its restitution", ratio(leaving, give)
    yield "bounces slower than its restitution", ratio(-leaving, give)
    yield from breaches_of_friction(a, b, n, e, mu, impulse, apart, closing)

def breaches_of_friction(
    a: Change, b: Change, n: Vector, e: Any, mu: Any, impulse: Vector, apart: Vector, closing: Any
) -> Iterator[tuple[str, Any]]:
    """The impulse lies in the cone, gains no energy, and leaves no sliding that it could have stopped."""
    square = dot(n, n)
    aside = along(impulse, -dot(impulse, n) / square, n)
    bound = mu * max(dot(impulse, n), 0)
    room = ratio(bound * bound / square - dot(aside, aside), total(aside) + bound / most(n))
    yield "impulse outside the friction cone", -room / (2 * (1 + mu))
    if all(c.w or not (any(c.before) or any(c.spin_before)) for c in (a, b)):
        (gain_a, slope_a), (gain_b, slope_b) = a.energy(), b.energy()
        yield "energy is gained", ratio(gain_a + gain_b, slope_a + slope_b)
    if mu:
        left = along(apart, -dot(apart, n) / square, n)
        bounce = along(a.pushed(n), 1, b.pushed(n))
        share = ratio(-closing, dot(bounce, n)) * e
        caused = times(share, bounce)
        other = minus(left, along(caused, -dot(caused, n) / square, n))
        sliding = min(most(left), most(other)) / 8
        yield "sliding is not stopped although friction could", min(max(room, 0) / (2 * (1 + mu)), sliding)


# ---- 4. The verdict ----------------------------------------------------------------------------------------------

Answer = dict[str, float | list[float]]

def told(lines: Sequence[str], names: Sequence[str]) -> Answer:
    """Read an answer from lines such as ``distance = 3.0``; what is nan is not said."""
    found: Answer = {}
    for line in lines:
        name, equals, text = line.partition(" = ")
        if equals and name.strip() in names:
            try:
                values = [float(value) for value in text.strip().strip("[]()").split(",")]
            except ValueError:
                continue
            if not all(math.isnan(value) for value in values):
                found[name.strip()] = values if len(values) > 1 else values[0]
    return found

def asked(file: str, question: str, limit: float, names: Sequence[str]) -> tuple[Answer, str]:
    """Run the part of this file that asks the engine; gives its answer, or says why there is none."""
    isolated = ["-I"] if sys.flags.isolated else []
    command = [sys.executable, *isolated, file, question]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return {}, f"no answer within {limit:g} seconds: its process was ended"
    lines = ran.stdout.splitlines()
    answer = told(lines, names)
    for line in lines:
        if line.partition(" = ")[0].strip() not in answer:
            print(" ", line)
    if ran.returncode < 0:
        return {}, f"its process ended with signal {-ran.returncode} ({signal.strsignal(-ran.returncode)})"
    if ran.returncode:
        errors = ran.stderr.strip().splitlines() or [f"exit status {ran.returncode}"]
        return {}, f"it raised an error: {errors[-1]}"
    return answer, "" if answer else "it answered nothing"

def missing(modules: Sequence[tuple[str, str]]) -> str:
    """Say which module is not installed, and how to get it; empty when all are there."""
    lacking = [f"{module} ({how})" for module, how in modules if find_spec(module) is None]
    return f"not installed: {', '.join(lacking)}" if lacking else ""

def print_answer(engine: str, answer: Answer, words: str, recorded: Any) -> None:
    """Show what the engine said."""
    print(f"{engine} answers{'' if answer else f' nothing: {words}'}")
    for name, value in answer.items():
        print(f"  {name} = {value!r}")
    if answer != recorded:
        print("  (not what it answered when this file was written)")

def laws_of(motion: Any, right: Any, allowed: float) -> Any:
    """By how much velocities break the laws of an impact: these must keep them better than the engine has to."""
    broken = max(0, *(by for _, by in breaches(motion, right)))
    require(broken <= allowed, "the velocities said to be right break a law")
    return broken

def print_laws(motion: Any, right: Any) -> None:
    """Show velocities that keep the laws of an impact, and how well they do."""
    print("velocities that keep every law of the impact, checked exactly:")
    for name, value in right.items():
        print(f"  {name} = {value!r}")
    print(f"  broken by no more than {float(laws_of(motion, right, math.inf))!r}")

def verdict(answer: Answer, wrong: tuple[str, Any] | None, allowed: str) -> int:
    """Say whether the answer is right; gives the exit status."""
    if not answer:
        print("verdict: WRONG: there is no answer")
        return 1
    if wrong is None:
        print(f"verdict: right, as far as this file can tell ({allowed})")
        return 0
    symptom, amount = wrong
    size = f", by at least {float(amount)!r}" if amount < math.inf else ""
    print(f"verdict: WRONG: {symptom}{size} ({allowed})")
    return 1

def at_most(amount: Any) -> float:
    """Largest double that is not above an exact number."""
    found = float(amount)
    return found if found <= amount else math.nextafter(found, -math.inf)

def of_impact(answer: Answer, motions: Sequence[Any], allowed: float, symptom: str) -> tuple[str, Any] | None:
    """The law that velocities break for every one of some motions, and by how much."""
    if not answer or set(answer) != {"velocity_a", "angular_a", "velocity_b", "angular_b"}:
        return "a velocity is missing", math.inf
    worst = []
    for motion in motions:
        found = [(name, by) for name, by in breaches(motion, answer) if by > number(allowed)]
        if not found:
            return None
        worst.append((sorted(found, key=lambda law: law[0] != symptom)[0], max(by for _, by in found)))
    return worst[0][0][0], at_most(min(worst[0][0][1], *(most for _, most in worst[1:]), math.inf))

def main(arguments):
    if arguments == ["--ask"]:
        ask()
        return 0
    lacking = "" if arguments else missing(NEEDED)
    if lacking:
        print(lacking)
        return 2
    try:
        laws_of(MOTIONS[0], RIGHT, MOST)
    except (Refused, ArithmeticError, LookupError, TypeError, ValueError) as why:
        print(f"the certificate does not hold: {why}")
        return 2
    answer, words = (told(arguments, NAMES), "") if arguments else asked(__file__, "--ask", 10, NAMES)
    print_answer("pybullet-defaults", answer, words, ANSWER)
    print_laws(MOTIONS[0], RIGHT)
    return verdict(answer, of_impact(answer, MOTIONS, MOST, SYMPTOM), ALLOWED)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
