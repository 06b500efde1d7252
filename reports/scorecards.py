"""A scorecard as people read it: a table for terminal, page and Markdown, and the page itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

from markupsafe import Markup

from refimpl.construct.kinds import BOUNDING, KINDS, MODEL
from refimpl.construct.scorecard import MOST_FACES_TESTED, Score, Scorecard
from reports import html, text, viewer
from reports.tables import Column, Entry, Table

TITLE = "proxyproof: a model and its proxies"
WORDS = {"translation": "move", "rotation": "turn", "scaling": "scale", "stretching": "stretch"}
"""What each transformation is called in the table."""
NOTHING = "–"
UNTESTED = f"not measured for more than {MOST_FACES_TESTED} faces"
LEAST = 1e-9
"""Share of the diagonal below which a distance is rounding."""

COLUMNS = (
    Column("proxy"),
    Column("build", True),
    Column("numbers", True),
    Column("volume", True),
    Column("out", True),
    Column("back", True),
    Column("survives"),
    Column("test", True),
)
MEANING = (
    ("build", "processor time to build it, once"),
    ("numbers", "doubles in which it is stored"),
    ("volume", "its volume by the model's: what contains the model has at least 1"),
    (
        "out, back",
        "mean distance of its surface from the model's, and of the model's from its, by the model's diagonal",
    ),
    ("survives", "after what it is still of its type: moving, turning, scaling, stretching by a factor for each axis"),
    ("test", "processor time of a test against another of its kind, in a batch of pairs of which half meet"),
)


def time_in_words(seconds: float) -> str:
    """Time with its unit, two or three digits."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)):
        if seconds * factor >= 0.995:
            return f"{seconds * factor:.3g}{text.THIN}{unit}"
    return f"{seconds * 1e9:.0f}{text.THIN}ns" if seconds > 0 else NOTHING


def table(card: Scorecard) -> Table:
    """The scores, a row for each proxy."""
    return Table("What each proxy costs, and what it gives", COLUMNS, tuple(_row(score, card) for score in card.scores))


def caption(card: Scorecard) -> str:
    """What the model is."""
    faces = text.plural(len(card.model.triangles), "face")
    return f"{text.visible(card.name)}: {faces}, volume {card.volume:.4g}, diagonal {card.diagonal:.4g}"


def _row(score: Score, card: Scorecard) -> tuple[Entry, ...]:
    if score.proxy is None:
        return (Entry(score.title, note=text.visible(score.fault)), *[Entry(NOTHING)] * (len(COLUMNS) - 1))
    kept = [WORDS[name] for name, why in score.survives.items() if not why]
    lost = "; ".join(f"{WORDS[name]}: {why}" for name, why in score.survives.items() if why)
    return (
        Entry(score.title, link=score.kind),
        Entry(time_in_words(score.build)),
        Entry(text.count(score.numbers)),
        Entry(f"{score.volume_ratio:.3g}"),
        *(Entry(_share(part, card.diagonal, score)) for part in (score.out, score.back)),
        Entry(", ".join(kept), title=lost),
        Entry(time_in_words(score.test), title=UNTESTED if math.isnan(score.test) else ""),
    )


def _share(part: float, whole: float, score: Score) -> str:
    if score.kind == MODEL or math.isnan(part):
        return NOTHING
    return f"{100 * part / whole if part > LEAST * whole else 0:.2g}{text.THIN}%"


@dataclass(frozen=True)
class Panel:
    """One proxy of the page: its heading, what is said of it, and its figure."""

    kind: str
    title: str
    said: str
    figure: Markup
    files: tuple[str, ...]


def page(card: Scorecard, files: dict[str, tuple[str, ...]], notes: dict[str, tuple[str, ...]]) -> str:
    """Return the page: the table, and each proxy over the model in the report's viewer.

    Parameters
    ----------
    files, notes
        By kind: files beside the page in which the proxy is, and how these differ from it.
    """
    panels = [
        Panel(
            score.kind,
            score.title,
            _told(score, card, notes.get(score.kind, ())),
            viewer.model_figure(card.model, score.proxy, score.title),
            files.get(score.kind, ()),
        )
        for score in card.scores
        if score.proxy is not None
    ]
    return html.page(
        "fit.html.jinja",
        "fit.css",
        title=TITLE,
        name=text.visible(card.name),
        caption=caption(card),
        table=table(card),
        meaning=MEANING,
        panels=panels,
        script=viewer.script(),
    )


def _told(score: Score, card: Scorecard, notes: tuple[str, ...]) -> str:
    """What is worth saying under a heading."""
    if score.kind == MODEL:
        return "The solid that the proxies stand for."
    sure = ", proven to contain every corner" if KINDS[score.kind].use == BOUNDING else ", a collider"
    said = f"{score.type}{sure}. {score.volume_ratio:.3g} times the volume; "
    said += (
        f"its surface is {_share(score.out, card.diagonal, score)} of the diagonal from the model's on average, the "
    )
    said += f"model's {_share(score.back, card.diagonal, score)} from its. {time_in_words(score.test)} a test."
    return " ".join([said, *(f"{note[0].upper()}{note[1:]}." for note in notes)])
