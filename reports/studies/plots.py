"""Plots as small SVG files that are the same to the byte on every run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

STYLE: dict[Any, Any] = {
    "svg.hashsalt": "proxyproof",  # names of paths depend on this and on nothing random
    "svg.fonttype": "none",  # text stays text
    "font.family": "sans-serif",
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.constrained_layout.use": True,
    "lines.linewidth": 1.5,
}
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Colours that colour-blind people tell apart (Okabe and Ito 2008)."""
MARKS = ("o", "s", "^", "D", "v", "P")


class StudyUnavailable(RuntimeError):
    """A study needs something that is not installed; the text says what."""


@contextmanager
def figure(path: Path, columns: int = 1, width: float = 6.4, height: float = 3.6) -> Iterator[Sequence[Any]]:
    """Give axes side by side to draw on, and write them to an SVG file."""
    try:
        import matplotlib  # noqa: PLC0415  an extra, and slow to import
        from matplotlib.figure import Figure  # noqa: PLC0415
    except ImportError:
        raise StudyUnavailable("plots need matplotlib: pip install 'proxyproof[studies]'") from None
    with matplotlib.rc_context(STYLE):
        canvas = Figure(figsize=(width, height))
        axes = canvas.subplots(1, columns, squeeze=False)[0]
        yield axes
        canvas.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
