"""The page of `proxyproof touching`: the pipeline and PyBullet on one crowd."""

from __future__ import annotations

from collections import Counter

from oracles.crowds.touching import Close, Compared
from refimpl.world import STAGES
from reports import text
from reports.markdown import table_lines
from reports.tables import Column, Entry, Table

MOST = 40
"""Pairs that are listed."""


def stages(found: Compared) -> Table:
    """How many pairs each stage of the pipeline was asked, and how many it left to the next."""
    rows = []
    for name in STAGES[:3]:
        stage = found.stages[name]
        amounts = (text.count(n) for n in (stage.asked, stage.rejected, stage.left))
        rows.append((Entry(name), *map(Entry, amounts), Entry(f"{1e3 * stage.seconds:.1f} ms")))
    columns = ("stage", "pairs", "rejected", "left", "time")
    return Table("The pipeline", tuple(Column(title, title != "stage") for title in columns), tuple(rows))


def judged(found: Compared) -> Table:
    """What the certificates prove of the pairs, and how often each of the two names them."""
    names = {True: "deeper than the margins", False: "farther apart than the margins", None: "in between"}
    rows = []
    for decided, name in names.items():
        some = [one for one in found.close if one.decided is decided]
        far = found.far if decided is False else 0
        named = far and len(found.far_named)
        by_reference, by_engine = sum(one.reference for one in some), sum(one.engine for one in some)
        amounts = (len(some) + far, by_reference, by_engine, sum(one.reference != one.engine for one in some) + named)
        rows.append((Entry(name), *(Entry(text.count(n)) for n in amounts)))
    columns = ("proven to be", "pairs", "refimpl: touch", "PyBullet: touch", "they differ")
    return Table("Pairs of bodies", tuple(Column(title, title != "proven to be") for title in columns), tuple(rows))


def listed(caption: str, pairs: list[Close]) -> Table:
    """Pairs with their proven distance."""
    rows = [
        (
            Entry(f"{one.pair[0]}, {one.pair[1]}"),
            Entry(one.types),
            Entry(f"[{text.short(one.lower)}, {text.short(one.upper)}]"),
            Entry(f"±{text.short(one.margin)}"),
            Entry("touch" if one.reference else "apart"),
            Entry("touch" if one.engine else "apart"),
            Entry("" if one.effective != one.effective else text.short(one.effective)),
        )
        for one in sorted(pairs, key=lambda one: -abs(one.lower))[:MOST]
    ]
    titles = ("bodies", "types", "proven distance", "margin", "refimpl", "PyBullet", "distance of what Bullet holds")
    return Table(caption, tuple(map(Column, titles)), tuple(rows))


def as_markdown(found: Compared) -> str:
    """Return all tables in Markdown, below a verdict."""
    wrong = len(found.wrong) + len(found.far_named)
    by_types = Counter(one.types for one in found.in_between)
    said = f"{text.plural(found.bodies, 'body', 'bodies')}, {text.plural(wrong, 'pair')} wrong or missed"
    parts = [f"# {said}", ""]
    tables = [stages(found), judged(found)]
    tables += [listed("Pairs on which one of the two contradicts the proof", found.wrong)] * bool(found.wrong)
    between = "Pairs within the margins on which the two differ: " + ", ".join(f"{t} {n}" for t, n in by_types.items())
    tables += [listed(between, found.in_between)] * bool(found.in_between)
    for table in tables:
        parts += [f"{table.caption}:", "", *table_lines(table), ""]
    return "\n".join(parts)
