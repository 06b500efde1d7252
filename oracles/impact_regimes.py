"""Regimes of impacts: recipes for two bodies about to touch, as `oracles.regimes` has them for shapes at rest.

Each works for every pair that is staged; its docstring says why it exists.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from oracles.bodies import random_body, round_body
from oracles.builds import FACTORS
from oracles.draws import Draws, log_uniform
from oracles.engine import Engine
from oracles.flat_stages import LEVEL, UPRIGHT, inertia_of
from oracles.impact_stages import CORNER, EDGE, FACE, Staged, stage
from oracles.motion import Motion, Moving
from oracles.world import is_flat
from refimpl import HalfSpace, Proxy, Sphere
from refimpl.linear import Array, dot, norm, scale
from refimpl.mass import mass_properties

Scenes = tuple[Proxy, Proxy, Motion]
ImpactRegime = Callable[[Draws, type[Proxy], type[Proxy]], Scenes]
IMPACT_REGIMES: dict[str, ImpactRegime] = {}

SPEEDS_OF = "speeds_of_"
ROUND_SPEEDS = (1.0, 0.0, -1.0, 2.0, -2.0, 0.5, -0.5)
ROUND_SHARES = (1.0, 0.0, 0.5, 0.25, 0.75)


def regime(function: ImpactRegime) -> ImpactRegime:
    """Register a regime under its function's name."""
    IMPACT_REGIMES[function.__name__] = function
    return function


def impact_reasons(regimes: Mapping[str, ImpactRegime] = IMPACT_REGIMES) -> dict[str, str]:
    """Why each regime exists: the first line of its docstring."""
    return {name: (function.__doc__ or "").strip().splitlines()[0] for name, function in regimes.items()}


def impact_regimes_for(engines: Iterable[Engine]) -> dict[str, ImpactRegime]:
    """The regimes that every pass asks, and one more for each engine that declares thresholds of speed."""
    own = {f"{SPEEDS_OF}{engine.name}": speeds_of(engine) for engine in engines if engine.speed_thresholds}
    return IMPACT_REGIMES | own


@dataclass(frozen=True)
class Recipe:
    """What a regime wants of its scenes.

    Attributes
    ----------
    features
        Where the target may be touched.
    spread
        How far from the feature's middle, from 0 to 1.
    spins
        Largest angular velocity; what would let a flat contact tilt is left out.
    speeds, masses
        Powers of ten of the velocities' scale, and of the masses.
    """

    features: tuple[float, ...] = (FACE,)
    spread: float = 1.0
    spins: float = 0.0
    speeds: tuple[float, float] = (0.0, 0.0)
    masses: tuple[float, float] = (-1.0, 1.0)
    friction: bool = False
    even: bool = False


def _scene(draws: Draws, pair: tuple[type[Proxy], type[Proxy]], recipe: Recipe) -> tuple[Staged, Motion]:
    """Two bodies that touch, with random velocities of which nothing is known yet."""
    bodies = (round_body(draws), round_body(draws)) if recipe.even else (random_body(draws), random_body(draws))
    tilts = HalfSpace in pair and Sphere not in pair and (recipe.friction or recipe.spins > 0)
    features = (CORNER,) if tilts else recipe.features
    where = np.stack([draws.choice(features), np.full(draws.n, recipe.spread)], axis=-1)
    staged = stage(draws, pair, bodies, where)
    pace = log_uniform(draws, *recipe.speeds)
    a, b = (_moving(draws, shape, recipe, pace) for shape in (staged.a, staged.b))
    e = draws.choice(ROUND_SHARES) if recipe.even else draws.uniform(0.0, 1.0)
    mu = (draws.choice((0.25, 0.5, 1.0)) if recipe.even else draws.uniform(0.01, 1.0)) if recipe.friction else 0 * e
    return staged, Motion(a, b, staged.point, staged.normal, e, mu)


def _moving(draws: Draws, shape: Proxy, recipe: Recipe, pace: Array) -> Moving:
    n, none = draws.n, np.zeros((draws.n, 3))
    if isinstance(shape, HalfSpace):
        return Moving(none, none, none, np.zeros(n), np.broadcast_to(np.eye(3), (n, 3, 3)))
    velocity = draws.choice(ROUND_SPEEDS, 3) if recipe.even else draws.uniform(-3.0, 3.0, 3)
    spin = draws.uniform(-recipe.spins, recipe.spins, 3) if recipe.spins else none
    mass = draws.choice((1.0, 2.0, 0.5, 4.0)) if recipe.even else log_uniform(draws, *recipe.masses)
    if is_flat(shape):
        place, inertia = inertia_of(shape, mass)
        return Moving(place, scale(pace, velocity * LEVEL), scale(pace, spin * UPRIGHT), 1 / mass, inertia)
    solid = mass_properties(shape)
    inertia = solid.of_mass(mass)
    inertia = (inertia + np.swapaxes(inertia, -1, -2)) / 2
    return Moving(solid.barycentre, scale(pace, velocity), scale(pace, spin), 1 / mass, inertia)


def _stopped(body: Moving, which: Array) -> Moving:
    """Bodies that cannot be moved, and are at rest, where `which` says so."""
    fixed = which[:, None]
    still = {name: np.where(fixed, 0.0, getattr(body, name)) for name in ("velocity", "angular_velocity")}
    return replace(body, **still, inverse_mass=np.where(which, 0.0, body.inverse_mass))


def _times(body: Moving, factor: Array) -> Moving:
    """Bodies moving so many times as fast; the other way, where it is negative."""
    return replace(
        body, velocity=scale(factor, body.velocity) + 0.0, angular_velocity=scale(factor, body.angular_velocity) + 0.0
    )


def _meeting(motion: Motion, *, part: bool = False) -> Motion:
    """The motion, or its reverse, so that the bodies approach; or part."""
    away = motion.closing >= 0
    sign = np.where(away != part, -1.0, 1.0)
    return replace(motion, a=_times(motion.a, sign), b=_times(motion.b, sign))


def _with_normal_speed(body: Moving, normal: Array, share: Array) -> Moving:
    """Scale the part of the velocity along the normal."""
    along = scale(dot(body.velocity, normal) / dot(normal, normal), normal)
    return replace(body, velocity=body.velocity - along + scale(share, along))


def _random(draws: Draws, pair: tuple[type[Proxy], type[Proxy]], recipe: Recipe) -> Scenes:
    staged, motion = _scene(draws, pair, recipe)
    return staged.a, staged.b, _meeting(motion)


@regime
def head_on(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """Along the normal through the middle of face or side, no spin, no friction: the formulas of one dimension."""
    staged, motion = _scene(draws, (kind_a, kind_b), Recipe(spread=0.0))
    a, b = (replace(body, velocity=scale(body.velocity[:, 0], staged.normal)) for body in (motion.a, motion.b))
    return staged.a, staged.b, _meeting(replace(motion, a=a, b=b))


@regime
def oblique(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """In any direction on any point of a face or side, no spin, no friction: the parallel part has to stay."""
    return _random(draws, (kind_a, kind_b), Recipe())


@regime
def edge_or_corner(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """On an edge, a corner or a cap: the lever is long, and the normal is no axis of the body."""
    return _random(draws, (kind_a, kind_b), Recipe((EDGE, CORNER)))


@regime
def spinning(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """Both spin: the point of contact moves otherwise than the centres."""
    return _random(draws, (kind_a, kind_b), Recipe((FACE, EDGE, CORNER), spins=3.0))


@regime
def rubbing(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """Both spin, with friction from hardly any to much: contacts stick and slide."""
    return _random(draws, (kind_a, kind_b), Recipe((FACE, EDGE, CORNER), spins=3.0, friction=True))


@regime
def round_numbers(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """Equal masses, restitutions of 0 and 1, axes and speeds in round numbers: the lecture's special cases."""
    return _random(draws, (kind_a, kind_b), Recipe(even=True))


@regime
def one_immovable(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """One of the two cannot be moved: its inverse mass is 0."""
    staged, motion = _scene(draws, (kind_a, kind_b), Recipe((FACE, EDGE, CORNER), spins=1.0))
    first = draws.choice((0.0, 1.0)) == 1
    planes = [isinstance(shape, HalfSpace) for shape in (staged.a, staged.b)]
    first = np.full(draws.n, planes[0]) if any(planes) else first
    return staged.a, staged.b, _meeting(replace(motion, a=_stopped(motion.a, first), b=_stopped(motion.b, ~first)))


@regime
def unequal_masses(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """Masses from 1e-3 to 1e3: a light body is thrown back, a heavy one hardly notices."""
    return _random(draws, (kind_a, kind_b), Recipe((FACE, EDGE, CORNER), spins=1.0, masses=(-3.0, 3.0)))


@regime
def grazing(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """Along the surface, with 1e-3 to 1e-9 of the velocity along the normal, or none: almost no impulse."""
    staged, motion = _scene(draws, (kind_a, kind_b), Recipe())
    share = draws.choice((1.0, 1.0, 1.0, 0.0)) * log_uniform(draws, -9.0, -3.0)
    a, b = (_with_normal_speed(body, motion.normal, share) for body in (motion.a, motion.b))
    return staged.a, staged.b, _meeting(replace(motion, a=a, b=b))


@regime
def slow(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """At 1e-6 to 0.1 units of speed: below thresholds from which on engines let bodies bounce."""
    return _random(draws, (kind_a, kind_b), Recipe(speeds=(-6.0, -1.5)))


@regime
def fast(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """At 30 to 3000 units of speed: beyond the limits that engines put on velocities."""
    return _random(draws, (kind_a, kind_b), Recipe(speeds=(1.5, 3.0), spins=1.0))


@regime
def any_normal(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """With normals of length 1e-3 to 1e3: only their direction counts."""
    a, b, motion = _random(draws, (kind_a, kind_b), Recipe((FACE, EDGE, CORNER), spins=1.0))
    return a, b, replace(motion, normal=scale(log_uniform(draws, -3.0, 3.0), motion.normal))


@regime
def parting(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
    """Touching, but moving apart: nothing may change."""
    staged, motion = _scene(draws, (kind_a, kind_b), Recipe(spins=1.0))
    return staged.a, staged.b, _meeting(motion, part=True)


def speeds_of(engine: Engine) -> ImpactRegime:
    """Approaches about the speeds at which an engine, as it declares, takes another way."""
    speeds = engine.speed_thresholds

    def make(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Scenes:
        staged, motion = _scene(draws, (kind_a, kind_b), Recipe((FACE, EDGE, CORNER)))
        wanted = draws.choice(tuple(speeds.values())) * draws.choice(FACTORS)
        closing = np.abs(motion.closing) / norm(motion.normal)
        pace = np.where(closing > 0, wanted / np.where(closing > 0, closing, 1.0), 1.0)
        a, b = (_times(body, pace) for body in (motion.a, motion.b))
        return staged.a, staged.b, _meeting(replace(motion, a=a, b=b))

    named = ", ".join(f"{what} {speed:g}" for what, speed in speeds.items())
    make.__doc__ = f"Approaches about the thresholds of {engine.name}: {named}."
    return make
