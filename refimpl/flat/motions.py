"""Motions in the plane over the time from 0 to 1: translations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from refimpl.linear import Array
from refimpl.motions import Translation
from refimpl.proxy import vector


@dataclass(frozen=True, eq=False, repr=False)
class FlatTranslation(Translation):
    """The motion x(t) = x + t·vector.

    Parameters
    ----------
    vector : (..., 2)
        The way of the whole motion, from t = 0 to 1; zero is rest.
    """

    vector: Array = vector(width=2)

    if TYPE_CHECKING:

        def __init__(self, vector: ArrayLike) -> None: ...
