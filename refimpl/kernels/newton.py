"""The greatest gap of two features of bodies, over the unit directions, by Newton's method on the sphere.

Seen from near one direction n, every body is one *feature*: a vertex, a straight edge, a smooth surface or a rim.
Each of them has the support function

    h(n) = c·n + ‖M n‖,  M n = (r₀ a₀·n, r₁ a₁·n, r₂ a₂·n)

with a centre c, orthonormal axes aᵢ and radii rᵢ, of which some or all are 0 (a rim is a flat ellipsoid, a vertex has
no radii), and is the whole truth along a straight edge only for the n at right angles to the edge. Then

    g(n) = (c_B − c_A)·n − ‖M_A n‖ − ‖M_B n‖

is smooth, and its maximum on the sphere, or on a great circle, takes a few steps. On the sphere its gradient is the
part of ∇g across n, its Hessian −(T + g) on that plane, T the Hessian of both norms: the sum of the matrices of
the radii of curvature (Schneider, Convex Bodies: The Brunn–Minkowski Theory, 2.5; Absil, Mahony and Sepulchre,
Optimization Algorithms on Matrix Manifolds, 5.5).
"""

from __future__ import annotations

import math

from . import kernel
from .vectors import Vector, cross, dot, minus, perpendicular, plus, times, unit_or, without

Feature = tuple[Vector, Vector, Vector, Vector, Vector, Vector]
"""Centre; the three axes; the radii; the direction of the straight edge, zero if there is none."""

STEPS = 25
ZERO = (0.0, 0.0, 0.0)


@kernel
def stretched(f: Feature, n: Vector) -> Vector:
    """Vector M n of a feature."""
    return (f[4][0] * dot(f[1], n), f[4][1] * dot(f[2], n), f[4][2] * dot(f[3], n))


@kernel
def gap_of(f: Feature, g: Feature, n: Vector) -> float:
    """Gap of two features along the unit direction `n`."""
    u, v = stretched(f, n), stretched(g, n)
    return dot(minus(g[0], f[0]), n) - (math.sqrt(dot(u, u)) + math.sqrt(dot(v, v)))


@kernel
def curvature(f: Feature, n: Vector, s: Vector, t: Vector) -> tuple[float, float, float, float, float]:
    """Gradient of ‖M n‖ along s and t, and its Hessian (ss, st, tt), written so that nothing cancels."""
    u = stretched(f, n)
    size = math.sqrt(dot(u, u))
    if size == 0.0:
        return (0.0, 0.0, 0.0, 0.0, 0.0)
    u = times(1.0 / size, u)
    along_s, along_t = stretched(f, s), stretched(f, t)
    x, y = cross(along_s, u), cross(along_t, u)
    return (dot(along_s, u), dot(along_t, u), dot(x, x) / size, dot(x, y) / size, dot(y, y) / size)


@kernel
def step_on_sphere(slope: tuple[float, float], hessian: tuple[float, float, float]) -> tuple[float, float]:
    """Newton's step (x, y) uphill; shortened, by a multiple of the unit matrix, where the Hessian is not definite.

    `hessian` is that of −g: (ss, st, tt).
    """
    p, q, r = hessian
    middle, half = (p + r) / 2.0, (p - r) / 2.0
    spread = math.sqrt(half * half + q * q)
    least = middle - spread
    floor = 1e-3 * (abs(middle) + spread)
    shift = 0.0 if least > 0.0 else floor - least
    p, r = p + shift, r + shift
    determinant = p * r - q * q
    if determinant <= 0.0:
        return slope
    return ((r * slope[0] - q * slope[1]) / determinant, (p * slope[1] - q * slope[0]) / determinant)


@kernel
def climb(f: Feature, g: Feature, n: Vector, edge: Vector) -> Vector:
    """Direction of a local maximum of the gap of two features, uphill from `n`.

    With a non-zero `edge`, only over directions at right angles to it.
    """
    bound = dot(edge, edge) > 0.0
    here = gap_of(f, g, n)
    d = minus(g[0], f[0])
    for _ in range(STEPS):
        s = unit_or(cross(edge, n), ZERO) if bound else perpendicular(n)
        t = ZERO if bound else cross(n, s)
        a, b = curvature(f, n, s, t), curvature(g, n, s, t)
        slope = (dot(d, s) - (a[0] + b[0]), 0.0 if bound else dot(d, t) - (a[1] + b[1]))
        p, q, r = here + (a[2] + b[2]), a[3] + b[3], here + (a[4] + b[4])
        if bound:
            curved = abs(p) if p != 0.0 else 1.0
            x, y = slope[0] / curved, 0.0
        else:
            x, y = step_on_sphere(slope, (p, q, r))
        size = math.sqrt(x * x + y * y)
        if not size > 0.0:
            break
        if size > 0.5:
            x, y = 0.5 * x / size, 0.5 * y / size
        better, there = uphill(f, g, n, plus(times(x, s), times(y, t)), here, edge)
        if there < here or size <= 1e-16:
            break
        done = size < 1e-9 and there == here
        n, here = better, there
        if done:
            break
    return n


@kernel
def uphill(f: Feature, g: Feature, n: Vector, step: Vector, here: float, edge: Vector) -> tuple[Vector, float]:
    """End of a step from `n`, halved until the gap does not fall, and the gap there; below `here` if there is none.

    A step below 1e-7 is taken whole: its effect is lost in rounding, and its length is not.
    """
    better, there = n, -math.inf
    for _ in range(12):
        better = unit_or(without(plus(n, step), edge), n)
        there = gap_of(f, g, better)
        if there >= here:
            return better, there
        if dot(step, step) < 1e-14:
            return better, here
        step = times(0.5, step)
    return better, there
