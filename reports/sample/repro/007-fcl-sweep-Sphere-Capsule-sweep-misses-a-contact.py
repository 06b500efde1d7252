#!/usr/bin/env python3
# fcl · sweep · Sphere–Capsule · sweep misses a contact · head on · 1e-1
"""fcl, sweep of Sphere (A) and Capsule (B): sweep misses a contact.

fcl answers no hit: sweep misses a contact; the first time at which the two touch is proven to be between
0.8324640763635166 and 0.8324640763635167. It is wrong by at least 0.991.

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
    """FCL: sweep of Sphere (a) and Capsule (b); of several objects the first to meet counts."""

    from importlib.metadata import version

    import fcl
    import numpy as np

    print("python-fcl", version("python-fcl"))
    a_shape0 = fcl.Sphere(1.0)
    a = [
        (fcl.CollisionObject(a_shape0, fcl.Transform(np.array([0.0, 0.0, 0.0]))), fcl.Transform(np.array([-1.6635906956056408, -2.6785756086428174, -5.00286618260875]))),
    ]
    b_shape0 = fcl.Capsule(2.0, 11.327359492631288)
    b = [
        (fcl.CollisionObject(b_shape0, fcl.Transform(np.array([[0.8124909182908949, -0.31618643116941203, -0.4897802042132461], [0.31618643116941203, -0.4668319083832685, 0.8258898897913609], [-0.4897802042132461, -0.8258898897913609, -0.2793228266741634]]), np.array([-2.6906545710432392, -2.809907399583491, -6.966058347306774]))), fcl.Transform(np.array([[0.8124909182908949, -0.31618643116941203, -0.4897802042132461], [0.31618643116941203, -0.4668319083832685, 0.8258898897913609], [-0.4897802042132461, -0.8258898897913609, -0.2793228266741634]]), np.array([-2.6906545710432392, -2.809907399583491, -6.966058347306774]))),
    ]
    request = fcl.ContinuousCollisionRequest(
        toc_err=0.0001,
        ccd_motion_type=fcl.CCDMotionType.CCDM_TRANS,
        gjk_solver_type=fcl.GJKSolverType.GST_INDEP,
        ccd_solver_type=fcl.CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT,
    )
    times = []
    for x, x_end in a:
        for y, y_end in b:
            result = fcl.ContinuousCollisionResult()
            fcl.continuousCollide(x, x_end, y, y_end, request, result)
            if result.is_collide:
                times.append(result.time_of_contact)
    print("hit =", float(len(times) > 0))
    print("t =", repr(min(times, default=float("inf"))))


# ---- 2. The scene, what was answered, and what proves it wrong ---------------------------------------------------

A = {"type": "Sphere", "center": [0.0, 0.0, 0.0], "radius": 1.0}
B = {
    "type": "Capsule",
    "p": [0.08330365170566267, -7.487483241081682, -5.3840633111886795],
    "q": [-5.464612793792141, 1.8676684419146994, -8.548053383424868],
    "radius": 2.0,
}
ANSWER = {"hit": 0.0, "t": math.inf}
HELD = {
    "t": 0.01367788541347979,
    "witness": 0.01367788541347979,
    "hit": 9.548053383424868e-06,
    "owed": ["hit", "t"],
}
SIDES = [
    {
        "symptom": "sweep misses a contact",
        "margins": [0.0, 0.0],
        "truth": None,
        "claim": {
            "about": "where the two are at a time from 0 to 1, their signed distance is {}",
            "kind": "solids",
            "x": {
                "type": "Sphere",
                "center": [-1.6635906956056408, -2.6785756086428174, -5.00286618260875],
                "radius": 1.0,
            },
            "y": B,
            "margin": 0.0,
            "interval": [-0.9907447779005952, -0.9907447779005946],
            "claims": [
                {"kind": "escape", "n": [-0.33252752220091547, -0.5354082061907303, -1.0], "faces": [[], []]},
                {
                    "kind": "core",
                    "pairs": [
                        [
                            [-1.6635906956056408, -2.6785756086428174, -5.00286618260875],
                            [-2.228823996922226, -3.588667338596905, -6.702675261795487],
                        ],
                    ],
                    "triangles": [],
                },
            ],
            "low": 0.0,
            "high": math.inf,
            "cap": math.inf,
            "rounding": 1.9627830871245853e-14,
            "symptom": "sweep misses a contact",
            "allowed": 9.548053383424868e-06,
        },
    },
]
ALLOWED = "fcl is allowed an error of hit 9.548053383424868e-06, t 0.01367788541347979, witness 0.01367788541347979"
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

class Segment(Solid):
    """All points within `radius` of the segment from p to q: a point or ball, where these are one."""

    def __init__(self, p: Vector, q: Vector, radius: Fraction) -> None:
        self.p, self.q, self.radius = p, q, radius
        self.centre = along(p, Fraction(1, 2), minus(q, p))

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x over the segment."""
        return max(dot(n, self.p), dot(n, self.q))

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point from the segment."""
        way = minus(self.q, self.p)
        t = min(max(dot(minus(x, self.p), way) / dot(way, way), 0), 1) if any(way) else 0
        rest = minus(x, along(self.p, t, way))
        return dot(rest, rest)

def sphere(shape: Any) -> Segment:
    """‖x − center‖ ≤ radius."""
    center = vector(shape["center"])
    return Segment(center, center, number(shape["radius"]))

def capsule(shape: Any) -> Segment:
    """All points within `radius` of the segment pq."""
    return Segment(vector(shape["p"]), vector(shape["q"]), number(shape["radius"]))

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

def escape(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≥ −D: moving B by D along n separates the two."""
    n, room = room_along(claim, a, b)
    require(sign_of(room, n, a.radius + b.radius) <= 0, "the planes across n leave a gap")
    return width_of(room, n, a.radius + b.radius), math.inf

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
    "Sphere": sphere,
    "Capsule": capsule,
}

CHECKS: dict[str, Any] = {
    "escape": escape,
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

TRIALS: dict[str, Any] = {
    "numbers": of_numbers,
    "claim": of_claim,
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
