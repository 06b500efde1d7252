#!/usr/bin/env python3
# fcl · contacts · Box–Box · normal and depth move too far · generic · 1e-12
"""fcl, contacts of Box (A) and Box (B): normal and depth move too far.

fcl answers a signed distance of -136.40014662892517: normal and depth move too far; once B is moved along its
normal by its depth or gap, the signed distance is proven to be between 1.4379600450100082e-09 and
1.4379605606846397e-09, not 0. It is wrong by at least 1.44e-09.

    python FILE                       asks fcl, and judges its answer
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
from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from importlib.util import find_spec
from typing import Any

# ---- 1. The engine, called as its users call it ------------------------------------------------------------------

def ask():
    """FCL: contacts of Box (a) and Box (b); of several objects the nearest or deepest counts."""

    from importlib.metadata import version

    import fcl
    import numpy as np

    print("python-fcl", version("python-fcl"))
    a_shape = fcl.Box(610.0, 610.0, 1222.0)
    a = [
        fcl.CollisionObject(a_shape, fcl.Transform(np.array([[-0.33333333333333326, -0.6666666666666666, 0.6666666666666666], [0.6666666666666666, 0.33333333333333337, 0.6666666666666666], [-0.6666666666666666, 0.6666666666666666, 0.33333333333333337]]), np.array([0.0, 0.0, 0.0]))),
    ]
    b_shape = fcl.Box(180.0, 180.0, 180.0)
    b = [
        fcl.CollisionObject(b_shape, fcl.Transform(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), np.array([0.0, 0.0, 440.0]))),
    ]

    request = fcl.CollisionRequest(num_max_contacts=20, enable_contact=True)
    results = [(x, y, fcl.CollisionResult()) for x in a for y in b]
    for x, y, result in results:
        fcl.collide(x, y, request, result)
    print("hit =", float(any(result.is_collision for *_, result in results)))
    contacts = [contact for *_, result in results for contact in result.contacts]
    if contacts:
        deepest = max(contacts, key=lambda contact: contact.penetration_depth)
        print("distance =", repr(-float(deepest.penetration_depth)))
        print("normal =", deepest.normal.tolist())  # from a to b
        print("point =", deepest.pos.tolist())


# ---- 2. The scene, what was answered, and what proves it wrong ---------------------------------------------------

A = {
    "type": "Box",
    "center": [0.0, 0.0, 0.0],
    "half_extents": [305.0, 305.0, 611.0],
    "rotation": [0.0, 1.0, 1.0, 1.0],
}
B = {
    "type": "Box",
    "center": [0.0, 0.0, 440.0],
    "half_extents": [90.0, 90.0, 90.0],
    "rotation": [0.0, 0.0, 0.0, 1.0],
}
ANSWER = {
    "hit": 1.0,
    "distance": -136.40014662892517,
    "normal": [-0.0, -0.447213595499958, 0.8944271909999159],
    "point": [28.999999999999922, 59.49999999999997, 411.0],
}
HELD = {"owed": ["distance", "hit", "normal", "point"], "hit": 6.11e-10, "witness": 6.11e-10}
SIDES = [
    {
        "symptom": "normal and depth move too far",
        "margins": [0.0, 0.0],
        "truth": {
            "about": "the signed distance of A and B is {}",
            "kind": "solids",
            "x": A,
            "y": B,
            "margin": 0.0,
            "interval": [-136.40014662748717, -136.40014662748712],
            "claims": [
                {"kind": "escape", "n": [0.0, -0.5, 1.0], "faces": [[], []]},
                {
                    "kind": "core",
                    "pairs": [
                        [[712.3333333333334, 102.33333333333333, 203.66666666666666], [-90.0, 90.0, 530.0]],
                        [[-712.3333333333334, -102.33333333333333, -203.66666666666666], [90.0, 90.0, 530.0]],
                        [[-305.6666666666667, -305.6666666666667, -610.3333333333334], [-90.0, 90.0, 530.0]],
                        [[-509.0, -509.0, 203.0], [-90.0, 90.0, 350.0]],
                        [[102.33333333333333, 712.3333333333334, 203.66666666666666], [90.0, -90.0, 350.0]],
                        [[305.6666666666667, 305.6666666666667, 610.3333333333334], [-90.0, 90.0, 350.0]],
                        [[305.6666666666667, 305.6666666666667, 610.3333333333334], [90.0, -90.0, 350.0]],
                        [[-509.0, -509.0, 203.0], [90.0, -90.0, 350.0]],
                        [[305.6666666666667, 305.6666666666667, 610.3333333333334], [90.0, 90.0, 350.0]],
                        [[-509.0, -509.0, 203.0], [90.0, 90.0, 350.0]],
                    ],
                    "triangles": [
                        [2, 0, 3],
                        [0, 2, 4],
                        [2, 1, 4],
                        [0, 4, 5],
                        [3, 0, 5],
                        [5, 4, 6],
                        [4, 1, 7],
                        [6, 4, 7],
                        [3, 5, 8],
                        [5, 6, 8],
                        [6, 7, 8],
                        [1, 2, 9],
                        [2, 3, 9],
                        [3, 8, 9],
                        [7, 1, 9],
                        [8, 7, 9],
                    ],
                },
            ],
        },
        "claim": {
            "about": "once B is moved along its normal by its depth or gap, the signed distance is {}, not 0",
            "kind": "solids",
            "x": A,
            "y": {
                "type": "Box",
                "center": [0.0, -61.0000000006431, 562.0000000012861],
                "half_extents": [90.0, 90.0, 90.0],
                "rotation": [0.0, 0.0, 0.0, 1.0],
            },
            "margin": 0.0,
            "interval": [1.4379600450100082e-09, 1.4379605606846397e-09],
            "claims": [
                {"kind": "separated", "n": [0.0, -0.5, 1.0], "faces": [[], []]},
                {
                    "kind": "near",
                    "a": [28.99999999999998, 28.99999999999998, 472.0],
                    "b": [28.99999999999998, 28.999999999356902, 472.00000000128614],
                },
            ],
            "low": 0.0,
            "high": 0.0,
            "cap": math.inf,
            "rounding": 6.075140390771703e-13,
            "symptom": "normal and depth move too far",
            "allowed": 6.11e-10,
        },
    },
]
ALLOWED = "fcl is allowed an error of hit 6.11e-10, witness 6.11e-10"
NEEDED = [["fcl", "pip install python-fcl"], ["numpy", "pip install numpy"]]
NAMES = ["hit", "distance", "on_a", "on_b", "normal", "t", "point"]


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

def root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose a square root, to 160 bits; both ends are equal where it is rational."""
    product = square.numerator * square.denominator
    shift = max(0, 160 - product.bit_length() // 2)
    low, scale = math.isqrt(product << 2 * shift), square.denominator << shift
    return Fraction(low, scale), Fraction(low + (low * low != product << 2 * shift), scale)

def length(v: Vector) -> tuple[Fraction, Fraction]:
    """Enclose the length of a vector."""
    return root(Fraction(dot(v, v)))

class Solid:
    """A convex core and the `radius` of a ball around each of its points."""

    radius = Fraction(0)
    centre: Vector = ()

    def member(self, place: Any, widened: bool = False) -> tuple[list[Fraction], Any]:
        """Read a point of the certificate, and find how far at most it lies outside the core, or the solid."""
        x = vector(place)
        square, radius = self.square(x), self.radius if widened else 0
        return x, 0 if square <= radius * radius else root(Fraction(square))[1] - radius

    def outside(self, x: Vector) -> Any:
        """How far a point is outside, at least; 0 where that cannot be told without a search."""
        return max(0, root(Fraction(self.square(x)))[0] - self.radius)

def columns_of(rotation: Any) -> list[list[Any]]:
    """Columns of the rotation matrix of a quaternion (x, y, z, w) of any length: exactly rational."""
    x, y, z, w = (number(value) for value in rotation)
    square = x * x + y * y + z * z + w * w
    require(square, "a rotation must not be 0")
    return [
        times(1 / square, [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)]),
        times(1 / square, [2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)]),
        times(1 / square, [2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y]),
    ]

class Bricks(Solid):
    """centre + Σ tᵢ·axisᵢ with all |tᵢ| ≤ 1, for three axes at right angles."""

    def __init__(self, centre: Vector, axes: Sequence[Vector]) -> None:
        self.centre, self.axes = centre, axes

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x: at a corner."""
        return dot(n, self.centre) + sum(abs(dot(n, axis)) for axis in self.axes)

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point: what is left of it without its nearest point."""
        rest = minus(x, self.centre)
        for axis in self.axes:
            if any(axis):
                rest = along(rest, -min(max(dot(rest, axis) / dot(axis, axis), -1), 1), axis)
        return dot(rest, rest)

def box(shape: Any) -> Bricks:
    """All center + R y with |yᵢ| ≤ half_extentsᵢ."""
    half, columns = vector(shape["half_extents"]), columns_of(shape["rotation"])
    return Bricks(vector(shape["center"]), [times(h, column) for h, column in zip(half, columns, strict=True)])

def shares_of(faces: Any, atom: int = 0) -> Any:
    """Shares of the planes of one atom of a side, where a claim gives any."""
    return {int(i): shares for i, shares in faces}.get(atom, ())

Interval = tuple[Any, Any]

def room_along(claim: Any, a: Solid, b: Solid) -> tuple[Vector, Any]:
    """The direction n of a claim, and the room that planes across it leave between two cores, times ‖n‖."""
    n, (of_a, of_b) = vector(claim["n"]), claim["faces"]
    require(any(n), "a direction must not be 0")
    return n, -(a.support(n, shares_of(of_a)) + b.support(times(-1, n), shares_of(of_b)))

def sign_of(room: Any, n: Vector, radius: Any) -> Any:
    """Sign of room/‖n‖ − radius, without a root."""
    return room * room - radius * radius * dot(n, n) if room >= 0 else -1

def width_of(room: Any, n: Vector, radius: Any) -> Any:
    """At most room/‖n‖ − radius, by less than 2⁻¹⁵⁰ of it."""
    low, high = length(n)
    return room / (high if room > 0 else low) - radius

def separated(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≥ L > 0: planes across n leave a gap."""
    n, room = room_along(claim, a, b)
    require(sign_of(room, n, a.radius + b.radius) > 0, "the planes across n leave no gap")
    return width_of(room, n, a.radius + b.radius), math.inf

def escape(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≥ −D: moving B by D along n separates the two."""
    n, room = room_along(claim, a, b)
    require(sign_of(room, n, a.radius + b.radius) <= 0, "the planes across n leave a gap")
    return width_of(room, n, a.radius + b.radius), math.inf

def near(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≤ ‖p − q‖, as p lies in A and q in B."""
    (p, beyond_a), (q, beyond_b) = a.member(claim["a"], True), b.member(claim["b"], True)
    return -math.inf, length(minus(p, q))[1] + beyond_a + beyond_b

def ball_inside(points: Sequence[Vector], triangles: Any) -> Fraction:
    """Square of the radius of a ball around 0 in the hull of some points.

    The triangles are a closed surface, all of which turn their inner side to 0: so it winds around 0, and no ray from
    0 leaves the hull before it meets the plane of one of them.
    """
    edges: Counter[tuple[int, int]] = Counter()
    squares = []
    for i, j, k in triangles:
        require(min(i, j, k) >= 0, "no such point")
        edges.update([(i, j), (j, k), (k, i)])
        normal = cross(minus(points[j], points[i]), minus(points[k], points[i]))
        height = dot(normal, points[i])
        require(height > 0, "a triangle does not turn its inner side to 0")
        squares.append(Fraction(height * height) / dot(normal, normal))
    require(squares and all(n == edges[j, i] for (i, j), n in list(edges.items())), "the surface is not closed")
    least: Fraction = min(squares)
    return least

def core(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≤ −r: a polytope of points p − q, with p in A and q in B, holds a ball of radius r around 0."""
    found = [(a.member(p), b.member(q)) for p, q in claim["pairs"]]
    points = [minus(p, q) for (p, _), (q, _) in found]
    outside = max(beyond_a + beyond_b for (_, beyond_a), (_, beyond_b) in found)
    if len(points) == 1 and not claim["triangles"]:
        upper = length(points[0])[1] + outside - a.radius - b.radius
    else:
        upper = outside - root(ball_inside(points, claim["triangles"]))[0] - a.radius - b.radius
    require(upper <= 0, "the points do not prove that the shapes meet")
    return -math.inf, upper

MEANING: dict[str, Any] = {
    "Box": box,
}

CHECKS: dict[str, Any] = {
    "separated": separated,
    "escape": escape,
    "near": near,
    "core": core,
}

def read(shape: Any) -> Any:
    """Take one shape by the name of its type: what its numbers mean, exactly."""
    return MEANING[shape["type"]](shape)

def interval_of(claims: Any, a: Any, b: Any, least: Any = -math.inf) -> Interval:
    """Interval in which the signed distance of two shapes lies, or the time of a hit, by all claims together."""
    bounds = [CHECKS[claim["kind"]](claim, a, b) for claim in claims]
    lower, upper = max([least, *(low for low, _ in bounds)]), min([math.inf, *(high for _, high in bounds)])
    require(lower <= upper, "its claims contradict each other")
    return lower, upper

def of_solids(claims: Any, x: Any, y: Any) -> Interval:
    """Proven interval of the signed distance of two convex shapes."""
    return interval_of(claims, read(x), read(y))

KINDS: dict[str, Any] = {
    "solids": of_solids,
}

def proven(proof: Any) -> Interval:
    """Check a certificate, which must prove the interval that is stated with it."""
    lower, upper = KINDS[proof["kind"]](proof["claims"], proof["x"], proof["y"])
    low, high = proof["interval"]
    known = math.nextafter(low, -math.inf) <= lower and upper <= math.nextafter(high, math.inf)
    require(known, "it proves less than is stated with it")
    return lower, upper


# ---- 4. The verdict ----------------------------------------------------------------------------------------------

Error = tuple[str, Any, float]
"""What is wrong, by how much at least, and how much the engine is allowed."""

def of_value(answer: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of a hit and of a distance, by what is proven of the signed distance."""
    lower, upper = (bound - number(side["truth"]["margin"]) for bound in side["truth"]["exact"])
    hit, distance = answer.get("hit"), answer.get("distance")
    if "hit" in held and hit is not None:
        yield ("false contact", lower, held["hit"]) if hit else ("missed contact", -upper, held["hit"])
    if "distance" in held and hit != 0:
        if distance is None:
            yield "not a number", math.inf, 0.0
        elif distance == -math.inf and held.get("no depth"):
            yield "distance too small", lower, held["distance"]
        else:
            yield "distance too small", lower - distance_of(distance), held["distance"]
            yield "distance too large", distance_of(distance) - upper, held["distance"]

def distance_of(value: float) -> Any:
    """A distance as it is answered, exactly."""
    return number(value) if math.isfinite(value) else value

def of_claim(_: Any, side: Any, __: Any) -> Iterator[Error]:
    """Error of a claim low ≤ σ(x, y) − margin ≤ high, which the recorded answer makes."""
    proof = side["claim"]
    lower, upper = proof["exact"]
    low, high = proof["low"], proof["high"]
    under = number(low) - (upper - number(proof["margin"])) if math.isfinite(low) else -math.inf
    over = lower - number(proof["margin"]) - number(high) if math.isfinite(high) else -math.inf
    excess = min(max(under, over), distance_of(proof["cap"]))
    yield proof["symptom"], excess - number(proof["rounding"]), proof["allowed"]

def of_numbers(answer: Any, _: Any, held: Any) -> Iterator[Error]:
    """Errors of what is no number, or one that no scene can have, or is not there though there is a hit."""
    if answer.get("distance") == -math.inf:  # has neither witnesses nor a normal
        return
    owed = held["owed"] if answer.get("hit") != 0 else ["hit"]
    for name, value in {**dict.fromkeys(owed, math.nan), **answer}.items():
        endless = name in ("t", "distance") and math.isinf(value)
        inside = name == "normal" and answer.get("t") == 0
        numbers = value if isinstance(value, list) else [value]
        if not endless and not inside and not all(abs(x) < 1e150 for x in numbers):
            yield "not a number", math.inf, 0.0

def of_points(answer: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of witnesses, contact point and normal, as far as they can be told without a search."""
    distance, allowed = answer.get("distance"), held["witness"]
    if distance is None or not math.isfinite(distance):
        return
    shapes = [(side["truth"][name], margin) for name, margin in zip("xy", side["margins"], strict=True)]
    for name, shape, margin in (("on_a", *shapes[0]), ("on_b", *shapes[1])):
        if name in answer and shape["type"] not in ("Composite", "Polyhedron"):
            yield "witness off its shape", read(shape).outside(vector(answer[name])) - number(margin), allowed
    if "on_a" in answer and "on_b" in answer:
        low, high = length(minus(vector(answer["on_a"]), vector(answer["on_b"])))
        yield "witnesses farther apart than the distance", low - abs(number(distance)), allowed
        yield "witnesses nearer than the distance", abs(number(distance)) - high, allowed
    for shape, margin in shapes if "point" in answer else ():
        if shape["type"] not in ("Composite", "Polyhedron"):
            beyond = read(shape).outside(vector(answer["point"])) - number(margin) - max(0, -number(distance))
            yield "contact point farther from a shape than the depth", beyond, allowed
    if "normal" in answer:
        low, high = length(vector(answer["normal"]))
        yield "normal shorter than 1", 1 - high, 1e-6
        yield "normal longer than 1", low - 1, 1e-6

TRIALS: dict[str, Any] = {
    "numbers": of_numbers,
    "claim": of_claim,
    "value": of_value,
    "points": of_points,
}

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

def proofs_of(sides: Any) -> list[Any]:
    """Check every certificate; the exact intervals join those that are stated."""
    found = []
    for side in sides:
        proofs = {name: side[name] for name in ("truth", "claim") if side[name] is not None}
        found.append(side | {name: proof | {"exact": proven(proof)} for name, proof in proofs.items()})
    return found

def print_answer(engine: str, answer: Answer, words: str, recorded: Any) -> None:
    """Show what the engine said."""
    print(f"{engine} answers{'' if answer else f' nothing: {words}'}")
    for name, value in answer.items():
        print(f"  {name} = {value!r}")
    if answer != recorded:
        print("  (not what it answered when this file was written)")

def print_proofs(sides: Any) -> None:
    """Show what the certificates prove."""
    print("proven, by the certificates in this file:")
    for proof in [side[name] for side in sides for name in ("truth", "claim") if side[name] is not None]:
        low, high = proof["interval"]
        print(" ", proof["about"].format(repr(low) if low == high else f"from {low!r} to {high!r}"))

def errors_of(answer: Answer, recorded: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of an answer on one pair of shapes.

    What was recorded is tried by the claim that it breaks. Any other answer is tried by what is proven of the shapes
    themselves, and by what else can be told exactly.
    """
    same = answer == recorded and side["claim"] is not None
    for name, trial in TRIALS.items():
        if name in ("numbers", "seconds") or (name == "claim") == same:
            yield from trial(answer, side, held)

def wrong_by(answer: Answer, recorded: Any, sides: Any, held: Any) -> tuple[str, Any] | None:
    """What is wrong with an answer on every pair of shapes, and the least amount; None if it is right on one."""
    worst: list[tuple[str, Any]] = []
    for side in sides:
        found = [(name, by) for name, by, allowed in errors_of(answer, recorded, side, held) if by > allowed]
        if not found and (side["truth"] is not None or answer == recorded):
            return None
        worst += sorted(found, key=lambda error: error[0] != side["symptom"])[:1]
    return (worst[0][0], min(by for _, by in worst)) if worst else None

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

def main(arguments):
    if arguments == ["--ask"]:
        ask()
        return 0
    lacking = "" if arguments else missing(NEEDED)
    if lacking:
        print(lacking)
        return 2
    try:
        sides = proofs_of(SIDES)
    except (Refused, ArithmeticError, LookupError, TypeError, ValueError) as why:
        print(f"the certificate does not hold: {why}")
        return 2
    answer, words = (told(arguments, NAMES), "") if arguments else asked(__file__, "--ask", 10, NAMES)
    print_answer("fcl", answer, words, ANSWER)
    print_proofs(sides)
    return verdict(answer, wrong_by(answer, ANSWER, sides, HELD), ALLOWED)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
