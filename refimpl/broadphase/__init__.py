"""Broad phase: which of N things can meet each other, or a box, a point, a ray. One protocol, many structures."""

from refimpl.broadphase.brute import BruteForce
from refimpl.broadphase.protocol import BroadPhase

__all__ = ["BroadPhase", "BruteForce"]
