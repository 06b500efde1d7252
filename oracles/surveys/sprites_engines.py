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
        a, b = pygame_mask(pair.a), pygame_mask(pair.b)
        return a.overlap_area(b, pair.offset) if case.question == "area" else a.overlap(b, pair.offset)


def pygame_mask(solid: Bools) -> Any:
    """The same mask for pygame: of an image that is opaque where it is solid."""
    import pygame  # noqa: PLC0415

    if not solid.size:
        return pygame.mask.Mask(solid.shape[::-1])
    image = np.repeat(np.where(solid, 255, 0).astype(np.uint8)[..., None], 4, axis=-1)
    return pygame.mask.from_surface(pygame.image.frombuffer(image.tobytes(), solid.shape[::-1], "RGBA"), 127)
