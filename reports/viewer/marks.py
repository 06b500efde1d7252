"""What is drawn onto the bodies: points and arrows of the answers, and what the proof rests on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from oracles.scene import Scene
from oracles.world import is_flat
from refimpl import support
from refimpl.linear import Array, norm
from refimpl.proof import Certificate, Common, Escape, Near, Part, Separated
from refimpl.proof.claims import Place
from refimpl.shapes import HalfSpace, Proxy, Ray
from reports.viewer.frame import Frame

LAYERS = ("given", "proof", "truth", "engine")
"""What is drawn over what comes before it; given are the velocities before an impact."""

NEAR = 2.5
"""How far off, in radii of the picture, a point may lie and still be drawn."""

ARROW = 0.42
"""Length of a normal."""

FASTEST = 0.7
"""Length of the largest velocity, and of the largest angular velocity."""

SLIGHT = 0.02
"""Arrows shorter than this are left out."""


@dataclass(frozen=True)
class Mark:
    """One thing drawn in one layer, placed in the picture.

    Attributes
    ----------
    kind : {"dot", "line", "arrow", "spin", "plane"}
    at : (3,)
        Where it is or starts; of a plane the middle of what is drawn.
    to : (3,)
        Where it ends; of a plane its normal.
    """

    layer: str
    kind: str
    at: Array
    to: Array
    label: str = ""


@dataclass
class Marks:
    """Everything drawn onto the bodies, and in words what could not be drawn."""

    marks: list[Mark] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def vector(value: object) -> tuple[float, float, float] | None:
    """Three finite numbers, or None: answers may hold anything."""
    value = value.tolist() if isinstance(value, np.ndarray) else value
    if not isinstance(value, Sequence) or isinstance(value, str | bytes) or len(value) != 3:
        return None
    numbers = [_number(x) for x in value]
    return None if any(x is None for x in numbers) else (numbers[0] or 0.0, numbers[1] or 0.0, numbers[2] or 0.0)


def _number(value: object) -> float | None:
    """Return a finite number, or None."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number | Fraction):
        return None
    try:
        found = float(value)
    except OverflowError:
        return None
    return found if math.isfinite(found) else None


def direction(value: object) -> Array | None:
    """Unit vector of three numbers, exact or not; None where they give none."""
    if not isinstance(value, Sequence | np.ndarray) or len(value) != 3:
        return None
    try:
        exact = [Fraction(x) for x in (value.tolist() if isinstance(value, np.ndarray) else value)]
    except (TypeError, ValueError, OverflowError):
        return None
    largest = max(map(abs, exact))
    if largest == 0:
        return None
    v = np.array([float(x / largest) for x in exact])
    return np.asarray(v / norm(v))


def of_answer(layer: str, answer: Mapping[str, object], scene: Scene, frame: Frame, spare: Array) -> Marks:
    """Points and normal of one answer; a normal of an answer without points stands at `spare`."""
    found = Marks()
    places = {name: _placed(layer, name, answer.get(name), frame, found) for name in ("on_a", "on_b", "point")}
    if places["point"] is None and isinstance(scene.a, Ray):
        places["point"] = _at_time(layer, scene.a, answer.get("t"), frame, found)
    on_a, on_b, point = places["on_a"], places["on_b"], places["point"]
    if on_a is not None and on_b is not None:
        found.marks.append(Mark(layer, "line", on_a, on_b))
    for name, place in (("a", on_a), ("b", on_b), ("p", point)):
        if place is not None:
            found.marks.append(Mark(layer, "dot", place, place, name))
    way = direction(vector(answer.get("normal")))
    if way is not None:
        start = next((p for p in (on_a, point, on_b) if p is not None), spare)
        found.marks.append(Mark(layer, "arrow", start, start + ARROW * way, "n"))
    return found


def _placed(layer: str, name: str, value: object, frame: Frame, found: Marks) -> Array | None:
    """A point of an answer in the picture, if it is one and lies near."""
    place = vector(value)
    if place is None:
        return None
    point = frame.point(place)
    if point is None or norm(point) > NEAR:
        whose = "The engine's" if layer == "engine" else "The true"
        away = "out of reach" if point is None else f"{float(norm(point)):.3g} times its radius from the middle"
        found.notes.append(f"{whose} {WORDS[name]} lies outside the picture, {away}")
        return None
    return point


WORDS = {"on_a": "point on A", "on_b": "point on B", "point": "contact point"}


def _at_time(layer: str, ray: Ray, time: object, frame: Frame, found: Marks) -> Array | None:
    """Where a ray is at a time."""
    t = _number(time)
    if t is None:
        return None
    place = [Fraction(o) + Fraction(t) * Fraction(d) for o, d in zip(*_numbers(ray), strict=True)]
    point = frame.point(place)
    if point is None or norm(point) > NEAR:
        found.notes.append(f"The {'engine’s' if layer == 'engine' else 'true'} hit lies outside the picture")
        return None
    return point


def _numbers(ray: Ray) -> tuple[list[float], list[float]]:
    return ray.origin.tolist(), ray.direction.tolist()


VELOCITIES = (("velocity_a", "a", "v"), ("angular_a", "a", "ω"), ("velocity_b", "b", "v"), ("angular_b", "b", "ω"))


def of_impact(scene: Scene, engine: Mapping[str, object], truth: Mapping[str, object], frame: Frame) -> Marks:
    """Velocities before (the proof's layer: what is given) and after, from each centre of mass; and the contact."""
    found = Marks()
    motion = scene.impact
    if motion is None:
        return found
    before: dict[str, object] = {}
    for side, body in (("a", motion.a), ("b", motion.b)):
        before |= {f"velocity_{side}": body.velocity, f"angular_{side}": body.angular_velocity}
    told = [("given", before), ("truth", truth), ("engine", engine)]
    sizes = {
        sign: max((_length(said.get(name)) for _, said in told for name, _, s in VELOCITIES if s == sign), default=0.0)
        for sign in "vω"
    }
    if sizes["ω"] * frame.size < SLIGHT**2 * sizes["v"]:
        sizes["ω"] = 0.0
    for layer, said in told:
        for name, side, sign in VELOCITIES:
            start, value = frame.point(getattr(motion, side).position.tolist()), vector(said.get(name))
            if value is None or start is None or norm(start) > NEAR or not sizes[sign] > 0:
                continue
            arrow = FASTEST * np.array([x / sizes[sign] for x in value])
            if norm(arrow) >= SLIGHT:
                kind, word = ("arrow" if sign == "v" else "spin"), sign + ("" if layer == "given" else "′")
                found.marks.append(Mark(layer, kind, start, start + arrow, word))
    contact, normal = frame.point(motion.point.tolist()), direction(motion.normal)
    if contact is not None and normal is not None and norm(contact) <= NEAR:
        found.marks.append(Mark("given", "dot", contact, contact, ""))
        found.marks.append(Mark("given", "arrow", contact, contact + ARROW / 2 * normal, "n"))
    if sizes["v"] > 0:
        found.notes.append(f"The longest arrow v is a velocity of {sizes['v']:.3g}")
    if sizes["ω"] > 0:
        found.notes.append(f"The longest arrow ω is an angular velocity of {sizes['ω']:.3g}")
    return found


def of_course(scene: Scene, frame: Frame) -> Marks:
    """The ways of both proxies of a sweep, from where they are at t = 0; none of a scene at rest."""
    found = Marks()
    if scene.course is None:
        return found
    for name, shape, side in (("A", scene.a, scene.course.a), ("B", scene.b, scene.course.b)):
        start = frame.point(np.asarray(shape.reference_point).tolist())
        end = frame.point((np.asarray(shape.reference_point) + side.linear).tolist())
        if start is None or end is None or norm(start) > NEAR:
            continue
        way = end - start
        if norm(way) > NEAR:
            way *= NEAR / norm(way)
        if norm(way) >= SLIGHT:
            found.marks.append(Mark("given", "arrow", start, start + way, f"{name}’s way"))
        if side.angular.any():
            found.notes.append(f"{name} turns as well, by {float(norm(side.angular)):.3g} radians")
    found.notes.append("A and B are drawn at t = 0, and faintly where they meet")
    return found


def at_contact(scene: Scene, truth: Mapping[str, object], engine: Mapping[str, object]) -> tuple[Proxy, Proxy] | None:
    """Both proxies of a sweep as they are at the first contact, or, where there is none, when the engine has one."""
    times = [_number(said.get("t")) for said in (truth, engine)]
    time = next((t for t in times if t is not None and 0 <= t <= 1), None)
    return None if scene.course is None or time is None else scene.course.at(scene.a, scene.b, time)


def _length(value: object) -> float:
    found = vector(value)
    return 0.0 if found is None else math.hypot(*found)


def of_proof(certificate: object, scene: Scene, frame: Frame) -> Marks:
    """Separating planes, common points and witnesses of a certificate on `scene`."""
    found = Marks()
    if not isinstance(certificate, Certificate):
        return found
    for claim in certificate.claims:
        found.marks += _of_claim(claim.claim if isinstance(claim, Part) else claim, scene, frame)
    return found


def _of_claim(claim: object, scene: Scene, frame: Frame) -> Iterator[Mark]:
    match claim:
        case Separated() | Escape():
            yield from _plane(claim, scene, frame)
        case Near():
            ends = [_point(place, frame) for place in (claim.a, claim.b)]
            if ends[0] is not None and ends[1] is not None:
                yield Mark("proof", "line", ends[0], ends[1])
        case Common():
            point = None if claim.p is None else _point(claim.p, frame)
            if claim.p is None and claim.time is not None and isinstance(scene.a, Ray):
                point = _on_ray(scene.a, claim.time, frame)
            if point is not None:
                yield Mark("proof", "dot", point, point, "common point")


def _on_ray(ray: Ray, time: float | Fraction, frame: Frame) -> Array | None:
    found = frame.point([Fraction(o) + Fraction(time) * Fraction(d) for o, d in zip(*_numbers(ray), strict=True)])
    return found if found is not None and norm(found) <= NEAR else None


def _point(place: Place, frame: Frame) -> Array | None:
    """A place given by coordinates; those given by weights of corners are not drawn."""
    if len(place) != 3 or any(isinstance(x, tuple) for x in place):
        return None
    found = frame.point(place)
    return found if found is not None and norm(found) <= NEAR else None


def _plane(claim: Separated | Escape, scene: Scene, frame: Frame) -> Iterator[Mark]:
    """The plane in the middle between the two; of a way out, the one that B is moved beyond."""
    n = direction(claim.n)
    if n is None:
        return
    of_a, of_b = _level(scene.a, n, frame, claim), _level(scene.b, -n, frame, None)
    levels = [level for level in (of_a, None if of_b is None else -of_b) if level is not None]
    if not levels:
        return
    level = levels[0] if isinstance(claim, Escape) else sum(levels) / len(levels)
    if abs(level) <= 1.2:
        parting = "separating line" if is_flat(scene.b) else "separating plane"
        yield Mark("proof", "plane", level * n, n, "way out" if isinstance(claim, Escape) else parting)


def _level(shape: Proxy, n: Array, frame: Frame, claim: Separated | Escape | None) -> float | None:
    """How far a shape reaches along n from the middle of the picture; None where it has no end or that is unknown."""
    if isinstance(shape, HalfSpace):
        foot = frame.point(shape.reference_point.tolist())
        own = direction(shape.normal)
        return float(n @ foot) if foot is not None and own is not None and n @ own > 1 - 1e-9 else None
    if isinstance(shape, Ray):
        until = claim.until if isinstance(claim, Separated) else None
        ends = [frame.point(shape.origin.tolist()), None if until is None else _on_ray(shape, until, frame)]
        return max((float(n @ end) for end in ends if end is not None), default=None)
    with np.errstate(all="ignore"):
        height = float(support(shape, n))
    if not math.isfinite(height):
        return None
    middle = Fraction(2) ** frame.exponent * sum(
        Fraction(c) * Fraction(x) for c, x in zip(frame.center.tolist(), n.tolist(), strict=True)
    )
    return float((Fraction(height) - middle) / Fraction(2) ** frame.exponent) / frame.radius
