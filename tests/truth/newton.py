"""Newton's method on the sphere, or on a great circle of it, at the working precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mpmath import mp, mpf  # type: ignore[import-untyped]

from tests.truth.bodies import Body
from tests.truth.rationals import Vector, applied, cross, dot, minus, perpendicular, plus, real, scaled

STEPS = 40


@dataclass(frozen=True)
class Smooth:
    """Ellipsoids M of the smooth function w·n + Σ √(n·M n), in mpf."""

    ellipsoids: list[Any]

    @classmethod
    def of(cls, a: Body, b: Body) -> Smooth:
        given = [body.ellipsoid for body in (a, b) if body.ellipsoid is not None]
        return cls([tuple(tuple(real(x) for x in row) for row in M) for M in given])

    def polished(self, w: Vector, arc: Vector | None, n: Any) -> Vector:
        """Lead n to the local minimum next to it; as far as it falls, for every direction is a bound."""
        w = _real(w)
        e = None if arc is None else _unit(_real(arc))
        n = _on(e, tuple(mpf(float(x)) for x in n))
        value = self._value(w, n)
        for _ in range(STEPS):
            step = self._step(w, e, n)
            size = mp.sqrt(dot(step, step))
            for halving in range(60):
                trial = _on(e, plus(n, scaled(mpf(2) ** -halving, step)))
                lower = self._value(w, trial)
                if lower < value:
                    break
            else:
                return n
            n, value = trial, lower
            if size < mpf(10) ** (-mp.dps // 2 - 2):
                break
        return n

    def _value(self, w: Vector, n: Vector) -> mpf:
        return dot(w, n) + sum(mp.sqrt(max(dot(n, applied(M, n)), mpf(0))) for M in self.ellipsoids)

    def _step(self, w: Vector, e: Vector | None, n: Vector) -> Vector:
        """Newton's step within the tangent plane; against the gradient where h is not convex."""
        gradient = w
        terms = []
        for M in self.ellipsoids:
            image = applied(M, n)
            square = dot(n, image)
            if square > mpf(10) ** (10 - mp.dps) * (M[0][0] + M[1][1] + M[2][2]):  # else at the tip of a disk
                s = mp.sqrt(square)
                terms.append((M, image, s))
                gradient = plus(gradient, scaled(1 / s, image))
        level = dot(gradient, n)
        u = cross(e, n) if e is not None else _unit(perpendicular(n))

        def second(x: Vector, y: Vector) -> mpf:
            bent = sum((dot(x, applied(M, y)) - dot(x, image) * dot(y, image) / s**2) / s for M, image, s in terms)
            return bent - level * dot(x, y)

        p, a = dot(gradient, u), second(u, u)
        if e is not None:
            return scaled(-p / a if a > 0 else -p / (abs(a) + abs(level)) if a or level else -p, u)
        v = cross(n, u)
        q, b, c = dot(gradient, v), second(u, v), second(v, v)
        middle, radius = (a + c) / 2, mp.sqrt(((a - c) / 2) ** 2 + b * b)
        shift = max(mpf(0), radius - middle) * (1 + mpf(2) ** -20)
        if middle + shift - radius <= 0:
            shift += (abs(middle) + radius) * mpf(10) ** (-mp.dps // 2) or mpf(1)
        a, c = a + shift, c + shift
        determinant = a * c - b * b
        return plus(scaled(-(c * p - b * q) / determinant, u), scaled(-(a * q - b * p) / determinant, v))


def _real(v: Vector) -> Vector:
    return real(v[0]), real(v[1]), real(v[2])


def _unit(v: Vector) -> Vector:
    return scaled(1 / mp.sqrt(dot(v, v)), v)


def _on(e: Vector | None, n: Any) -> Vector:
    """Unit vector next to n, at right angles to e if there is one."""
    return _unit(n if e is None else minus(n, scaled(dot(e, n), e)))
