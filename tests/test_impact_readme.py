"""The lecture's formulas, slide by slide: the examples beside them say the truth."""

from __future__ import annotations

import doctest
from pathlib import Path

from refimpl import impacts

README = Path(str(impacts.__file__)).with_name("README.md")


def test_every_example_says_the_truth() -> None:
    found = doctest.testfile(str(README), module_relative=False, encoding="utf-8")
    assert found.failed == 0
    assert found.attempted > 40


def test_every_public_function_has_an_example() -> None:
    text = README.read_text("utf-8")
    functions = [name for name in impacts.__all__ if callable(getattr(impacts, name)) and name[0].islower()]
    assert functions
    assert [name for name in functions if f"{name}(" not in text] == []
