"""Mass properties under judgement: volume, barycentre, inertia and principal moments, against their exact values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np

from oracles.scene import readable, shape_from_json, shape_to_json
from oracles.solids import l_shape, star
from oracles.surveys.mass_truth import Truth, truth
from oracles.surveys.survey import Case, Judgement, Library, Survey
from refimpl.linear import Array, apply, rotation_matrix
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Polyhedron,
    Proxy,
    ShapeError,
    Sphere,
)

EACH, CORNERS = 2, 10
"""Solids of each type and regime, and points around which polytopes are put."""
FAR, LARGE, THIN = 2.0**20, 2.0**30, 2.0**-12
MOST_NUMBERS = 1000
"""Of a solid that is read from a file."""
DOUBT = 1e-14
"""Eigenvalues of a matrix that is rounded once are no farther off than this, relative to the largest."""
LONGEST = 400
"""Letters of a fraction that is written out; longer ones are told by their first digits."""

WHAT = {
    "volume": "the volume, relative to itself",
    "barycentre": "the barycentre, by the solid's radius of gyration",
    "inertia": "the inertia tensor about it, of density 1, relative to its largest entry",
    "moments": "the principal moments of mass 1, relative to the largest",
}
"""What an answer may say, and in which unit it is off."""


class Mass(Survey):
    """The solids of a game, and what a library says that they weigh."""

    name = "mass"
    title = "Mass properties"
    about = (
        "Volume, barycentre, inertia tensor about it (in the world's axes, density 1) and principal moments (mass 1), "
        "of each type of solid. They are judged by exact values: polytopes and meshes are integrated in rationals, and "
        "round solids by their formulas with π and roots to 50 digits. An engine is asked for what it has; an answer "
        "is off by the largest of its relative errors."
    )
    questions: ClassVar[Mapping[str, str]] = {
        kind.__name__: "relative error, the largest of what is said"
        for kind in (
            Sphere, Capsule, Cylinder, Ellipsoid, AABB, Box, KDOP, ConvexPolyhedron, Polyhedron, Composite,
        )
    }  # fmt: skip
    regimes: ClassVar[Mapping[str, str]] = {
        "plain": "about 1 in size, near the origin",
        "thin": "flattened to 1/4096, along an axis that is none of the coordinates'",
        "far": "plain, a million lengths from the origin",
        "huge": "plain, a thousand million times as large",
        "tiny": "plain, a thousand million times as small",
    }
    engines: ClassVar[Mapping[str, Library]] = {
        "refimpl": Library("oracles.surveys.mass_engines:Reference", "refimpl", "proxyproof"),
        "trimesh": Library("oracles.surveys.mass_engines:Trimesh", "trimesh", "'proxyproof[meshes]'"),
        "bullet": Library("oracles.surveys.mass_engines:Bullet", "pybullet", "'proxyproof[bullet]'"),
    }
    each = 5.0

    def cases(self, seed: int) -> Sequence[Case]:
        """A few of every type in every regime."""
        rng = np.random.default_rng([seed, 8])
        return [
            _case(regime, _solid(kind, regime, rng))
            for kind in self.questions
            for regime in self.regimes
            for _ in range(EACH)
        ]

    def judge(self, case: Case, answer: Any) -> Judgement:
        """Compare what is said with the exact values."""
        exact = truth(shape_from_json(case.data["solid"]))
        errors = {name: _error(name, exact, answer[name]) for name in WHAT if name in answer}
        if not errors:
            raise ValueError("the answer holds none of " + ", ".join(WHAT))
        worst = max(errors, key=lambda name: math.inf if math.isnan(errors[name]) else errors[name])
        proof = {
            "volume": _told(exact.volume),
            "barycentre": [_told(x) for x in exact.barycentre],
            "inertia": [[_told(x) for x in row] for row in exact.inertia],
        }
        said = _shortly(answer[worst])
        words = f"{worst}: {said} is said, {_shortly(_nearest(worst, exact))} it is: off by {errors[worst]:.3g}"
        return Judgement(errors[worst], words, proof)

    def check(self, case: Case) -> None:
        """Only solids of the survey's types, of a few hundred numbers."""
        solid = case.data["solid"]
        known = solid["type"] == case.question in self.questions
        if not known or len(solid["numbers"]) > MOST_NUMBERS:
            raise ValueError(f"no solid of type {case.question} of at most {MOST_NUMBERS} numbers")
        if not all(0 <= float(case.data[name]) < math.inf for name in ("thin", "away", "size")):
            raise ValueError("thin, away and size must be finite")
        truth(shape_from_json(solid))

    def size(self, case: Case) -> float:
        """Radius of gyration."""
        return float(case.data["size"])

    def simpler(self, case: Case) -> Iterator[Case]:
        """A tetrahedron instead of other polytopes, rounder numbers, nearer places."""
        shape = shape_from_json(case.data["solid"])
        for other in _simpler(shape):
            try:
                made = _case(case.regime, other)
                self.check(made)
            except ValueError:
                continue
            if _length(made) < _length(case):
                yield made

    def written(self, case: Case) -> str:
        """The constructor's call, with every number."""
        return written(shape_from_json(case.data["solid"]))


def written(shape: Proxy) -> str:
    """Constructor call that gives the shape again, to the bit."""
    if isinstance(shape, Polyhedron):
        names = ("vertices", "triangles", "position", "rotation")
        return f"Polyhedron({', '.join(f'{name}={getattr(shape, name).tolist()!r}' for name in names)})"
    if isinstance(shape, Composite):
        return f"Composite([{', '.join(map(written, shape.parts))}])"
    return readable(shape)


def _case(regime: str, shape: Proxy) -> Case:
    """A solid, by how much it is longer than thick and farther away than large, and its radius of gyration."""
    exact = truth(shape)
    central = exact.central
    spread = np.sqrt(np.abs(np.linalg.eigvalsh((central / np.max(np.abs(central))).astype(float))))
    thin = float(spread[-1] / max(spread[0], 1e-9))
    square = _square_of_gyration(exact)
    away = math.sqrt(float(sum(exact.barycentre**2) / square))
    size = math.sqrt(float(square))
    told = {name: float(f"{x:.3g}") for name, x in (("thin", thin), ("away", away), ("size", size))}
    return Case(type(shape).__name__, regime, {"solid": shape_to_json(shape), **told})


def _square_of_gyration(exact: Truth) -> Fraction:
    central = exact.central
    square: Fraction = (central[0, 0] + central[1, 1] + central[2, 2]) / exact.volume
    return square


# -- judging -------------------------------------------------------------------------------------------------


def _nearest(name: str, exact: Truth) -> Any:
    """The true value in doubles."""
    if name == "volume":
        return float(exact.volume)
    if name == "moments":
        unit = (exact.inertia / exact.volume).astype(float)
        return [float(x) for x in np.linalg.eigvalsh(unit)]
    return (exact.barycentre if name == "barycentre" else exact.inertia).astype(float).tolist()


def _error(name: str, exact: Truth, said: Any) -> float:
    """By how much a value is off, at least, in its unit; infinite for what is no number."""
    numbers = np.asarray(said, dtype=np.float64)
    wanted = {"volume": (), "barycentre": (3,), "inertia": (3, 3), "moments": (3,)}[name]
    if numbers.shape != wanted:
        raise ValueError(f"{name}: expected numbers of shape {wanted}, got {numbers.shape}")
    if not np.isfinite(numbers).all():
        return math.inf
    if name == "moments":
        true = np.array(_nearest(name, exact))
        off = float(np.max(np.abs(np.sort(numbers) - true)) / true[-1])
        return max(0.0, off - DOUBT)
    given = np.array([Fraction(x) for x in numbers.ravel().tolist()], dtype=object)
    if name == "volume":
        return float(abs(given[0] - exact.volume) / exact.volume)
    if name == "barycentre":
        return math.sqrt(float(sum((given - exact.barycentre) ** 2) / _square_of_gyration(exact)))
    true_inertia = exact.inertia.ravel()
    return float(max(abs(given - true_inertia)) / max(abs(true_inertia)))


def _told(number: Fraction) -> str:
    """An exact number, or its first digits where it is long."""
    text = str(number)
    if len(text) <= LONGEST:
        return text
    shift = 40 - (len(str(abs(number.numerator))) - len(str(number.denominator)))
    digits = number * Fraction(10) ** shift
    return f"{round(digits)}e{-shift} (rounded)"


def _shortly(value: Any) -> str:
    """A few digits of an answer."""
    return np.array2string(np.asarray(value, dtype=np.float64), precision=4, separator=", ").replace("\n", "")


# -- solids --------------------------------------------------------------------------------------------------


def _solid(kind: str, regime: str, rng: np.random.Generator) -> Proxy:
    turn, place = rng.normal(size=4), rng.normal(size=3)
    if regime == "far":
        place = place * FAR
    scale = {"huge": LARGE, "tiny": 1 / LARGE}.get(regime, 1.0)
    flat = THIN if regime == "thin" else 1.0
    return _make(kind, rng, turn, place, flat).scaled(scale)


def _make(kind: str, rng: np.random.Generator, turn: Array, place: Array, flat: float) -> Proxy:
    sizes = rng.uniform(0.3, 1.5, 3) * [1.0, 1.0, flat]
    way = rng.normal(size=3)
    match kind:
        case "Sphere":
            made: Proxy = Sphere(place, sizes[0])
        case "Capsule" | "Cylinder":
            made = (Capsule if kind == "Capsule" else Cylinder)(place - way, place + way, sizes[2])
        case "Ellipsoid" | "Box":
            made = (Ellipsoid if kind == "Ellipsoid" else Box)(place, sizes, turn)
        case "AABB":
            made = AABB(place - sizes, place + sizes)
        case "Composite":
            rod = Capsule(place + np.array([0.0, 8.0, 0.0]), place + np.array([0.0, 9.0, 0.0]), sizes[1])
            made = Composite([Sphere(place, sizes[0]), Box(place + np.array([8.0, 0.0, 0.0]), sizes, turn), rod])
        case _:
            made = _with_corners(kind, rng, turn, place, flat)
    return made


def _with_corners(kind: str, rng: np.random.Generator, turn: Array, place: Array, flat: float) -> Proxy:
    axes = rotation_matrix(turn)
    if kind == "Polyhedron":
        vertices, triangles = (l_shape, star)[int(rng.integers(2))](0.4)
        return Polyhedron(apply(axes, vertices * [1.0, 1.0, flat]) + place, triangles)
    cloud = apply(axes, rng.normal(size=(CORNERS, 3)) * [1.0, 1.0, flat]) + place
    return KDOP.around(cloud, 14) if kind == "KDOP" else ConvexPolyhedron.from_vertices(cloud)


CORNER = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def _simpler(shape: Proxy) -> Iterator[Proxy]:
    """Solids that may show the same."""
    if isinstance(shape, Polyhedron | ConvexPolyhedron):
        size = float(shape.magnitude)
        for reach in (2.0**k for k in range(0, 31, 2)):
            if reach > 2 * size:
                break
            corners = CORNER + reach
            flat = isinstance(shape, Polyhedron)
            yield Polyhedron(corners, FACES) if flat else ConvexPolyhedron.from_vertices(corners)
        return
    numbers = shape.pack()
    if type(shape).header:
        return
    for digits in (0, 1, 2):
        with np.errstate(divide="ignore"):
            power = np.floor(np.log10(np.abs(numbers)))
        step = 10.0 ** np.where(np.isfinite(power), power - digits, 0.0)
        try:
            yield type(shape).unpack(np.round(numbers / step) * step)
        except ShapeError:  # rounding took its size away
            continue


def _length(case: Case) -> int:
    return sum(len(repr(x)) for x in case.data["solid"]["numbers"])
