"""What an engine's broad phase has to be asked, and what it says of itself."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from oracles.crowds.boxes import BoxCrowd, Pair


class BroadPhaseEngine:
    """A broad phase under judgement.

    Attributes
    ----------
    calls : str
        The functions of the engine that answer.
    margin : float
        Length by which it declares its boxes to be larger than the bodies', both sides together. Pairs that are named
        though their boxes are farther apart are false alarms.
    margin_why : str
    closed : bool
        Whether it promises pairs whose boxes only touch, where no side of a box has to be rounded.
    finds_nearest : bool
        Whether it is asked for the nearest pair, too.
    script : str
        Python text, imports and then a function `pairs(bodies)`, that asks the engine alone (`oracles.crowds.repro`).
    """

    calls: ClassVar[str]
    margin: ClassVar[float] = 0.0
    margin_why: ClassVar[str] = "it declares none"
    closed: ClassVar[bool] = False
    finds_nearest: ClassVar[bool] = False
    script: ClassVar[str] = ""

    def pairs(self, crowd: BoxCrowd) -> Iterable[Pair]:
        """Pairs of bodies that the engine says may touch, in any order, each once or more."""
        raise NotImplementedError

    def nearest(self, crowd: BoxCrowd) -> Pair | None:
        """Pair whose bounding boxes are nearest to each other, where the engine finds that (`finds_nearest`)."""
        del crowd
        return None
