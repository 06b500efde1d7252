"""Impacts to test with: of small fractions for the laws, and of doubles over wide ranges for the accuracy."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from hypothesis import strategies as st

from refimpl.impacts import RigidBody, inertia_tensor
from refimpl.impacts.reading import fractions


def parts(low: int, high: int, of: int) -> Any:
    """Fractions low / of, …, high / of: one draw each, where Hypothesis' own take three."""
    return st.integers(low, high).map(lambda k: Fraction(k, of))


NUMBERS = parts(-24, 24, 6)
HEAVY = parts(1, 40, 8)
MASSES = st.one_of(HEAVY, HEAVY, st.just(Fraction(0)))
SHARES = parts(0, 8, 8)
RUBS = st.one_of(parts(0, 20, 10), st.just(Fraction(10)))
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS).map(lambda v: np.array(v, dtype=object))
NORMALS = VECTORS.filter(lambda v: v.any())


@st.composite
def tensors(draw: Any) -> Any:
    """Symmetric positive definite matrices L Lᵀ of fractions."""
    sides = parts(1, 16, 4)
    (a, b, c), (d, e, f) = draw(st.tuples(sides, sides, sides)), draw(VECTORS)
    lower = np.array([[a, 0 * a, 0 * a], [d, b, 0 * a], [e, f, c]], dtype=object)
    return lower @ lower.T


def bodies(masses: Any = MASSES) -> Any:
    """Rigid bodies of fractions."""
    return st.builds(RigidBody, VECTORS, VECTORS, VECTORS, masses, tensors())


@dataclass(frozen=True)
class Scene:
    """Two bodies (or a batch of them) and how they meet."""

    a: RigidBody
    b: RigidBody
    point: Any
    normal: Any
    restitution: Any
    friction: Any

    @property
    def question(self) -> tuple[Any, ...]:
        """Arguments of `impact_of_bodies`."""
        return self.a, self.b, self.point, self.normal, self.restitution, self.friction

    def __getitem__(self, index: Any) -> Scene:
        """One of a batch."""
        rest = (np.asarray(v)[index] for v in (self.point, self.normal, self.restitution, self.friction))
        return Scene(self.a[index], self.b[index], *rest)

    def exact(self) -> Scene:
        """The same numbers, as fractions."""
        rest = (fractions(v) for v in (self.point, self.normal, self.restitution, self.friction))
        return Scene(exactly(self.a), exactly(self.b), *rest)

    def without_friction(self) -> Scene:
        """The same, smooth."""
        return replace(self, friction=0 * self.friction)


def exactly(body: RigidBody) -> RigidBody:
    """The same body, in fractions."""
    fields = (body.position, body.velocity, body.angular_velocity, body.inverse_mass, body.inertia)
    return RigidBody(*(None if f is None else fractions(f) for f in fields))


def scenes(masses: Any = MASSES) -> Any:
    """Impacts of rigid bodies, of fractions."""
    return st.builds(Scene, bodies(masses), bodies(masses), VECTORS, NORMALS, SHARES, RUBS)


def wide_scenes(rng: np.random.Generator, n: int, *, condition: float = 1e6, ratio: float = 1e12) -> Scene:
    """Doubles: inertia of a condition up to that given, inverse masses of any ratio, arms and speeds of 6 decades."""
    a, b = (_wide_body(rng, n, condition, ratio) for _ in range(2))
    normal = rng.normal(size=(n, 3)) * 10 ** rng.uniform(-3, 3, (n, 1))
    friction = rng.choice([0.0, 0.01, 0.3, 1.0, 3.0], n)
    point = (a.position + b.position) / 2 + rng.normal(size=(n, 3)) * 10 ** rng.uniform(-3, 1, (n, 1))
    restitution = np.where(rng.random(n) < 0.3, rng.integers(0, 2, n), rng.random(n))
    return Scene(a, b, point, normal, restitution, friction)


def _wide_body(rng: np.random.Generator, n: int, condition: float, ratio: float) -> RigidBody:
    inverse_mass = ratio ** rng.uniform(-0.5, 0.5, n)
    inverse_mass[rng.random(n) < 0.1] = 0
    gyration = 10 ** rng.uniform(-2, 2, n)
    spread = condition ** rng.uniform(0, 1, (n, 3))
    spread[:, 0], spread[:, 1] = 1, np.where(rng.random(n) < 0.5, condition, spread[:, 1])
    moments = spread * (gyration**2 / np.where(inverse_mass > 0, inverse_mass, 1))[:, None] / condition**0.5
    speeds = 10 ** rng.uniform(-3, 3, (2, n, 1))
    return RigidBody(
        rng.normal(size=(n, 3)) * 10 ** rng.uniform(-1, 2, (n, 1)),
        rng.normal(size=(n, 3)) * speeds[0],
        rng.normal(size=(n, 3)) * speeds[1],
        inverse_mass,
        inertia_tensor(moments, rng.normal(size=(n, 4))),
    )
