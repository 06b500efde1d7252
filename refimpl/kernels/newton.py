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
from .vectors import Vector, along, cross, dot, minus, perpendicular, plus, times, unit_or, without

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
def slope_on_circle(f: Feature, g: Feature, n: Vector, t: Vector) -> tuple[float, float]:
    """Derivative of the gap of two features at `n` along the unit tangent t, and the second one, negated."""
    a, b = curvature(f, n, t, t), curvature(g, n, t, t)
    return dot(minus(g[0], f[0]), t) - (a[0] + b[0]), gap_of(f, g, n) + (a[2] + b[2])


@kernel
def climb_circle(f: Feature, g: Feature, n: Vector, edge: Vector) -> Vector:
    """Direction at right angles to the unit vector `edge` with a local maximum of the gap of two features.

    Uphill from `n` in growing steps until the slope changes its sign; then by Newton's method within the bracket,
    which is halved instead where that would leave it or gain little. So it ends also where the maximum is sharp.
    Press et al., Numerical Recipes, 9.4.
    """
    t = unit_or(cross(edge, n), ZERO)
    slope, curved = slope_on_circle(f, g, n, t)
    if slope == 0.0:
        return n
    side = math.copysign(1.0, slope)
    step = abs(slope) / curved if curved > 0.0 else 0.1
    low, high, x = 0.0, math.inf, min(max(1.5 * step, 1e-16), 0.5)
    m = n
    for _ in range(3 * STEPS):
        m = unit_or(without(along(n, side * x, t), edge), n)
        slope, curved = slope_on_circle(f, g, m, unit_or(cross(edge, m), t))
        slope = side * slope
        if slope == 0.0:
            return m
        if slope > 0.0:
            low = x
        else:
            high = x
        if high == math.inf:
            if x > 2.0:
                return m
            x = 2.0 * x
            continue
        # an angle v away is v (1 + x²) away on the tangent line
        further = x + (1.0 + x * x) * slope / curved if curved > 0.0 else math.inf
        if not low < further < high or abs(further - x) > 0.25 * (high - low):
            further = low + 0.5 * (high - low)
        if high - low <= 1e-17 or (high - low < 1e-8 and abs(further - x) <= 1e-16):
            return m
        x = further
    return m


@kernel
def climb(f: Feature, g: Feature, n: Vector, edge: Vector) -> Vector:
    """Direction of a local maximum of the gap of two features, uphill from `n`.

    With an `edge`, a unit vector, instead of zero, only over directions at right angles to it.
    """
    if dot(edge, edge) > 0.0:
        return climb_circle(f, g, n, edge)
    here = gap_of(f, g, n)
    d = minus(g[0], f[0])
    for _ in range(STEPS):
        s = perpendicular(n)
        t = cross(n, s)
        a, b = curvature(f, n, s, t), curvature(g, n, s, t)
        slope = (dot(d, s) - (a[0] + b[0]), dot(d, t) - (a[1] + b[1]))
        x, y = step_on_sphere(slope, (here + (a[2] + b[2]), a[3] + b[3], here + (a[4] + b[4])))
        size = math.sqrt(x * x + y * y)
        if not size > 0.0:
            break
        if size > 0.5:
            x, y = 0.5 * x / size, 0.5 * y / size
        better, there = uphill(f, g, n, plus(times(x, s), times(y, t)), here)
        if there < here or size <= 1e-16:
            break
        done = size < 1e-9 and there == here
        n, here = better, there
        if done:
            break
    return n


@kernel
def uphill(f: Feature, g: Feature, n: Vector, step: Vector, here: float) -> tuple[Vector, float]:
    """End of a step from `n`, halved until the gap does not fall, and the gap there; below `here` if there is none.

    A step below 1e-7 is taken whole: its effect is lost in rounding, and its length is not.
    """
    better, there = n, -math.inf
    for _ in range(24):
        better = unit_or(plus(n, step), n)
        there = gap_of(f, g, better)
        if there >= here:
            return better, there
        if dot(step, step) < 1e-14:
            return better, here
        step = times(0.5, step)
    return better, there
