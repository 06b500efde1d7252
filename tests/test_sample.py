"""The committed sample is the report as it is written today, small enough for a repository, and whole."""

from __future__ import annotations

import re
from pathlib import Path

from reports import html, viewer

SAMPLE = Path(__file__).parents[1] / "reports" / "sample"
AGAIN = "stale: make it anew with the command of the README's section on reading reports"


def test_the_sample_has_the_style_and_the_scripts_of_today() -> None:
    page = (SAMPLE / "index.html").read_text(encoding="utf-8")
    assert viewer.script() in page, AGAIN
    assert viewer.style() in page, AGAIN
    assert html.script() in page, AGAIN


def test_the_sample_is_small_and_shows_findings() -> None:
    page = (SAMPLE / "index.html").read_bytes()
    assert len(page) <= 1_000_000
    assert page.count(b'<figure class="scene"') >= 10


def test_what_the_sample_links_to_is_there() -> None:
    notes = (SAMPLE / "report.md").read_text(encoding="utf-8")
    linked = re.findall(r"\]\(((?:pictures|repro|issues)/[^)]+)\)", notes)
    assert linked
    assert [name for name in linked if not (SAMPLE / name).is_file()] == []
