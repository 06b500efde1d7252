"""Whatever an engine says, a report shows it and does not obey it."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import unicodedata
from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from oracles.outcome import Bucket, EntryNote, Kind, Run, Severity, State, SupportNote, Verdict
from oracles.scene import DISTANCE, Scene
from reports import findings, folder, html, markdown, summary, text
from tests.sample_run import BALL, ROD, Page, bucket, sample_run

BIDI = "".join(map(chr, (0x202E, 0x2066, 0x200F)))
NASTY = (
    "<script>alert(1)</script> \"'><img src=x onerror=alert(1)> & &lt; | a | `b` ``c`` **d** _e_ [f](http://g.example) "
    f"# h\n# i\n- j\r\n```\n| k |\n</details> {BIDI} \x00\x1b[31m\x07 \ud800 \u2028 {{{{ 7 * 7 }}}} {{% if %}} \\"
)
TAME = "a tame name"


def hostile_run(words: str, *, error: str = "") -> Run:
    """Put the same words into every place that an engine or a scene can fill."""
    run = sample_run()
    pair = "Sphere–Capsule"
    run.engines = [words]
    run.versions = {words: words}
    run.regimes = {words: words}
    run.counts = Counter(
        {(words, DISTANCE, pair, words, Kind.AGREES): 7, (words, DISTANCE, pair, words, Kind.WRONG): 3}
    )
    run.support = {
        (words, DISTANCE, pair): SupportNote("emulated", words),
        (words, words, words): SupportNote("unsupported", words),
    }
    run.ledger = [EntryNote(words, words, words, state, words, 1, 1, (words,), (words,), words) for state in State]
    run.problems, run.timing, run.started = [words, "-", "1. x"], {words: 1.0}, words
    scene = Scene(DISTANCE, BALL, ROD, words, words)
    said = {words: words, "normal": [words, {words: 1.5}], "distance": math.nan}
    strange = bucket(
        words,
        scene,
        Verdict(Kind.WRONG, words, Severity.GROSS, 0.5, 0.25, 0.5, words),
        {words: 3},
        answer=said,
        reference=said,
        text=error or words,
        entry=words,
        state=State.EXPECTED,
        cause=words,
        repro=f"print({words!r})\n",
    )
    run.buckets = [strange, dataclasses.replace(strange, entry=None, state=State.NEW)]
    return run


def block_structure(source: str) -> list[tuple[str, str]]:
    """Tokens of a Markdown text, without its words."""
    parser = MarkdownIt("commonmark").enable(["table", "strikethrough"])
    found = []
    for token in parser.parse(source):
        found.append((token.type, token.tag))
        found += [
            (child.type, child.tag) for child in token.children or [] if child.type not in ("text", "text_special")
        ]
    return found


# -- texts ---------------------------------------------------------------------------------------------------


@given(st.text(max_size=400))
def test_visible_hides_nothing_and_shows_nothing_invisible(words: str) -> None:
    shown = text.visible(words)
    assert not {unicodedata.category(c) for c in shown} & text.INVISIBLE
    for character in words.replace("\r\n", "\n"):
        if character != "\n" and unicodedata.category(character) in text.INVISIBLE and len(words) <= text.LINE:
            assert f"⟨U+{ord(character):04X}⟩" in shown


def test_long_text_keeps_its_start_and_its_end() -> None:
    shown = text.block("A" * 5_000_000 + "the last word", limit=1000)
    assert len(shown) < 1100
    assert shown.startswith("AAA")
    assert shown.endswith("the last word")
    assert f"{text.count(5_000_013 - 1000)} characters left out" in shown


@given(st.floats(allow_nan=False))
def test_numbers_read_back_to_the_bit(value: float) -> None:
    assert float(text.number(value)) == value
    assert math.copysign(1.0, float(text.number(value))) == math.copysign(1.0, value)


def test_fractions_are_exact() -> None:
    assert text.number(Fraction(1, 8)) == "0.125"
    assert text.number(Fraction(1, 3)) == "1/3"
    assert text.number(Fraction(1, 3**5000)) == "≈ 0.0"
    assert text.number(Fraction(10) ** 400) == "≈ inf"


def test_plain_data_has_no_number_that_json_lacks() -> None:
    data = text.plain(
        {"a": np.array([1.5, np.nan]), "b": (np.inf, -np.inf), "c": np.float64(0.1), "d": np.bool_(True), 3: {None}}
    )
    assert json.loads(json.dumps(data, allow_nan=False)) == {
        "a": [1.5, "NaN"],
        "b": ["Infinity", "-Infinity"],
        "c": 0.1,
        "d": True,
        "3": [None],
    }


# -- hostile words -------------------------------------------------------------------------------------------


def test_hostile_words_leave_the_structure_of_the_page_alone() -> None:
    nasty, tame = (Page(html.render(hostile_run(words))) for words in (NASTY, TAME))
    assert nasty.tags == tame.tags
    assert [name for name, _ in nasty.attributes] == [name for name, _ in tame.attributes]
    ids = nasty.values("id")
    assert len(ids) == len(tame.values("id"))
    assert all(re.fullmatch(r"[A-Za-z0-9-]+", name) for name in ids)
    assert all(link.startswith(("#", "repro/", "report.", "issues/")) for link in nasty.values("href"))
    assert "<script>alert(1)</script>" in nasty.words
    assert "{{ 7 * 7 }}" in nasty.words


def test_hostile_words_leave_the_structure_of_the_markdown_alone() -> None:
    nasty, tame = (block_structure(markdown.render(hostile_run(words))) for words in (NASTY, TAME))
    assert nasty == tame
    assert not {"html_inline", "link_open", "strong_open"} & {kind for kind, _ in nasty} - {kind for kind, _ in tame}


@pytest.mark.parametrize("render", [html.render, markdown.render])
def test_nothing_invisible_is_written(render: Any) -> None:
    written = render(hostile_run(NASTY))
    assert {c for c in written if unicodedata.category(c) in text.INVISIBLE} <= {"\n"}
    assert "⟨U+202E⟩" in written
    written.encode("utf-8")


@pytest.mark.parametrize("render", [html.render, markdown.render, summary.report_json])
def test_an_error_text_of_ten_megabytes_is_cut(render: Any) -> None:
    written = render(hostile_run(TAME, error="\x1b<b>" * 2_500_000 + "RuntimeError: the end"))
    assert len(written) < 200_000
    assert "RuntimeError: the end" in written


@given(st.text(alphabet=st.sampled_from("ab1 -+=#|`*_[]()<>&~\\!.:\n"), min_size=1, max_size=30))
@example("     a")
@example("1. a")
@example("12) a")
@example("- a")
@example("---")
@example("= =")
@example("+\n+")
@example("a\\|b  ")
@example("<!-- a -->")
@example("&amp; &#35;")
@example("[a]: b")
@example("~~a~~ __a__ a_b_c")
def test_escaped_line_is_one_paragraph_or_cell_that_shows_the_words(words: str) -> None:
    shown = " ".join(words.split())
    line = markdown.escape(words)
    for source, inside in ((line, "paragraph_open"), (f"| a | b |\n| - | - |\n| {line} | x |", "td_open")):
        tokens = MarkdownIt("commonmark").enable(["table", "strikethrough"]).parse(source)
        if shown:
            assert tokens[0].type in ("paragraph_open", "table_open")
        index = next((i for i, token in enumerate(tokens) if token.type == inside), None)
        found = "".join(child.content for child in tokens[index + 1].children or []) if index is not None else ""
        assert " ".join(found.split()) == shown


def test_folded_heading_stands_in_raw_html() -> None:
    assert markdown.folded("<b> & [c]", ["d"])[1] == "<summary>&lt;b&gt; &amp; [c]</summary>"


def test_fence_is_longer_than_any_within() -> None:
    lines = markdown.fenced("```\n````\n")
    assert lines[0] == lines[-1] == "`````"


@pytest.mark.parametrize(
    "names",
    [("../../etc/passwd", "q", "p"), ("", "", ""), ("con\x00", "a/b\\c", "–"), ("x" * 500, "y", "z"), ("Ω", "≈", "✗")],
)
def test_script_names_stay_in_their_folder(names: tuple[str, str, str]) -> None:
    its = sample_run().buckets[0]
    strange = Bucket(*names, "..", "..", None, its.witness)
    name = findings.repro_file(7, strange)
    assert name.startswith("repro/")
    assert folder.OWN.fullmatch(name.removeprefix("repro/").removesuffix("py"))
    assert len(findings.repro_file(7, strange)) < 100
