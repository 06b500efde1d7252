"""Critical directions of a point against an ellipsoid, for many at a time, in doubles: where a search begins.

h(n) = w·n + √(n·M n) is critical on the unit sphere where n ∝ (M + t)⁻¹w and a function of t alone vanishes:
f(t) = Σ aᵢ² wᵢ² / (aᵢ² + t)² − 1 in M's principal frame, a₁ ≥ a₂ ≥ a₃ (Eberly, Distance from a Point to an Ellipsoid).
By its second derivatives a critical point is a minimum only for t > −a₃² (there is one), or between −a₂² and −a₃².
"""

from __future__ import annotations

from typing import Any

import numpy as np

Floats = Any
HALVINGS = 70


def critical_directions(axes: Floats, w: Floats) -> Floats:
    """Directions among which all local minima of h are.

    Parameters
    ----------
    axes : (N, 3, k)
        M = axes axesᵀ, of any rank.
    w : (N, 3)

    Returns
    -------
    (N, 10, 3)
        Unit vectors, in pairs ±n.
    """
    turn, a, _ = np.linalg.svd(axes, full_matrices=True)
    a = np.concatenate([a, np.zeros((len(a), 3 - a.shape[1]))], axis=1)
    y = np.einsum("nij,ni->nj", turn, w)
    gaps = (a - a[:, 2:]) * (a + a[:, 2:])  # aᵢ² − a₃², which does not cancel
    reach = np.linalg.norm(a * y, axis=-1)
    low = np.maximum(a[:, 2] * np.abs(y[:, 2]), 1e-60 * reach) + 1e-290
    outer = _root(a * y, gaps, np.ones(len(a)), low, np.maximum(2.0 * reach, 2.0 * low))
    lowest = _middle(a * y, gaps)
    inner = _root(a * y, gaps, -np.ones(len(a)), np.minimum(low, lowest), lowest)
    found = [_direction(y, gaps, t) for t in (outer, -inner, -lowest)]
    found += list(_polar(a, y, gaps))
    local = np.stack(found, axis=1)
    n = np.einsum("nij,nmj->nmi", turn, local)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.concatenate([n, -n], axis=1)


def _f(ay: Floats, gaps: Floats, d: Floats) -> Floats:
    """f at t = d − a₃²."""
    with np.errstate(all="ignore"):
        terms = ay / (gaps + d[..., None])
        return np.sum(terms * terms, axis=-1) - 1.0


def _root(ay: Floats, gaps: Floats, sign: Floats, low: Floats, high: Floats) -> Floats:
    """Bisect f(sign·d − a₃²) = 0 between f(low) ≥ 0 and f(high) ≤ 0, by geometric means."""
    for _ in range(HALVINGS):
        middle = np.sqrt(low) * np.sqrt(high)
        above = _f(ay, gaps, sign * middle) > 0
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return high


def _middle(ay: Floats, gaps: Floats) -> Floats:
    """Where f, which is convex in d, is least for t = −d − a₃² between the poles −a₂² and −a₃²."""
    low, high = np.full(len(ay), -140.0), np.full(len(ay), 80.0)
    squares, room = ay * ay, gaps[:, 1]
    with np.errstate(all="ignore"):
        for _ in range(HALVINGS):
            x = 0.5 * (low + high)  # log of d / (room − d)
            d, rest = room / (1.0 + np.exp(-x)), room / (1.0 + np.exp(x))
            far = gaps[:, 0] - room + rest
            slope = squares[:, 0] / far**3 + squares[:, 1] / rest**3 - squares[:, 2] / d**3
            low, high = np.where(slope < 0, x, low), np.where(slope < 0, high, x)
        return room / (1.0 + np.exp(-0.5 * (low + high))) + 1e-290


def _direction(y: Floats, gaps: Floats, d: Floats) -> Floats:
    """(M + t)⁻¹y for t = d − a₃², of a length near 1."""
    with np.errstate(all="ignore"):
        n = y / (gaps + d[:, None])
        n /= np.max(np.abs(n), axis=-1, keepdims=True)
    return np.where(np.all(np.isfinite(n), axis=-1)[:, None], n, np.array([0.0, 0.0, 1.0]))


def _polar(a: Floats, y: Floats, gaps: Floats) -> tuple[Floats, Floats]:
    """The limit t = −a₃² for y₃ = 0: (M + t)⁻¹y with a free third component that fulfils f = 0."""
    with np.errstate(all="ignore"):
        flat = a * y / gaps
        flat = np.where(np.isfinite(flat) & (y != 0), flat, 0.0)
        flat[:, 2] = 0.0
        rest = np.sqrt(np.maximum(1.0 - np.sum(flat * flat, axis=-1), 0.0))
        n = a[:, 2:] * y / gaps
        n = np.where(np.isfinite(n), n, 0.0)
    n[:, 2] = rest
    mirrored = n * np.array([1.0, 1.0, -1.0])
    fallback = np.array([0.0, 0.0, 1.0])
    bad = np.max(np.abs(n), axis=-1, keepdims=True) == 0
    return np.where(bad, fallback, n), np.where(bad, fallback, mirrored)
