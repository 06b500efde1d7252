"""Surveys: what engines are asked that is no question about a pair of proxies; each subject by name, loaded when asked.

A survey is a subject with questions, regimes and engines (`oracles.surveys.survey`). Its engines answer in a process of
their own (`oracles.isolation.children`), its judge says of each answer what is proven, and what is wrong is shown by a
smallest witness (`oracles.surveys.judging`).
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from oracles.surveys.survey import Survey

SURVEYS: Mapping[str, str] = MappingProxyType(
    {
        "bounding": "oracles.surveys.bounding:Bounding",
        "mass": "oracles.surveys.mass:Mass",
        "sprites": "oracles.surveys.sprites:Sprites",
    }
)
"""Name of each subject to the class that knows it, as ``module:class``."""


def load_survey(name: str) -> Survey:
    """Make the survey of this name.

    Raises
    ------
    LookupError
        When there is none.
    """
    if name not in SURVEYS:
        raise LookupError(f"no survey {name[:100]!r}: there are {', '.join(SURVEYS) or 'none'}")
    module, _, attribute = SURVEYS[name].partition(":")
    made: Survey = getattr(import_module(module), attribute)()
    return made


def surveyed() -> list[str]:
    """Names of the engines that are asked by any survey."""
    return [engine for name in SURVEYS for engine in load_survey(name).engines]
