"""Engines of the survey of sprites: pygame's masks, and this project's sprites."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from oracles.surveys.sprites import pair_of
from oracles.surveys.survey import Case, SurveyEngine
from refimpl.linear import Bools

FIRST = "any pixel that both have may be given; nothing is rounded"


class Reference(SurveyEngine):
    """`refimpl.flat.sprites`."""

    calls: ClassVar[str] = "common_pixel, overlap_area"
    promise: ClassVar[str] = FIRST

    def answer(self, case: Case) -> Any:
        """A pixel or nothing, or how many."""
        from refimpl.flat.sprites import Sprite, common_pixel, intersect, overlap_area  # noqa: PLC0415

        pair = pair_of(case.data)
        a, b = Sprite(pair.a), Sprite(pair.b, pair.offset)
        if case.question == "area":
            return overlap_area(a, b)
        pixel = common_pixel(a, b)
        if intersect(a, b) != (pixel is not None):
            raise AssertionError(f"intersect says {intersect(a, b)}, and the first common pixel is {pixel}")
        return pixel


class Pygame(SurveyEngine):
    """`pygame.mask`, which scans words of C."""

    calls: ClassVar[str] = "pygame.mask.Mask.overlap, overlap_area"
    promise: ClassVar[str] = FIRST

    def answer(self, case: Case) -> Any:
        """A pixel or nothing, or how many."""
        pair = pair_of(case.data)
        a, b = _mask(pair.a), _mask(pair.b)
        return a.overlap_area(b, pair.offset) if case.question == "area" else a.overlap(b, pair.offset)


def _mask(solid: Bools) -> Any:
    import pygame  # noqa: PLC0415

    made = pygame.mask.Mask(solid.shape[::-1])
    for y, x in np.argwhere(solid).tolist():
        made.set_at((x, y))
    return made
