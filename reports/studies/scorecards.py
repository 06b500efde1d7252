"""Study: scorecards of models that PyBullet ships: ``python -m reports.studies.scorecards [FOLDER]``.

A robot's link, the bunny, a car's chassis and the duck; the last three as they are or after repairs that are named.
Times are of one machine, and so this is a page of its own: ``scorecards.md``, of which tests compare the form only.
The pictures are the viewer's, photographed in Chromium.
"""

from __future__ import annotations

import io
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from rich.progress import track

from refimpl.construct.kinds import KINDS
from refimpl.construct.scorecard import Scorecard, scorecard
from refimpl.loading import load_polyhedron
from refimpl.shapes import AABB, Proxy
from reports import scorecards, viewer
from reports.markdown import table_lines
from reports.studies.plots import StudyUnavailable

HERE = Path(__file__).parent
SHOWN = ("aabb", "sphere", "least_box", "ellipsoid", "kdop18", "hull", "capsules", "decomposition")
"""Kinds that are in the picture, row by row."""
COLUMNS, WIDE, HIGH = 4, 280, 232
COLOURS = 96
DRAWN = """() => [...document.querySelectorAll('canvas')].every((canvas) => canvas.width
    && canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((x) => x))"""
"""Whether every figure has been painted: the graphics card is read back some time after it was asked."""
UPRIGHT = (1.0, 0.0, 0.0, 1.0)
"""Turns y upwards to z upwards."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


class Model(NamedTuple):
    """One model of PyBullet's data: its name here, its file, the repairs that make a solid of it, and what is seen."""

    name: str
    file: str
    repairs: tuple[str, ...]
    text: str
    y_up: bool = False


MODELS = (
    Model(
        "link",
        "kuka_iiwa/meshes/link_0.stl",
        ("merge_near", "fill_holes"),
        "The foot of a KUKA iiwa. Some corners stand twice in the file, a hair's breadth apart, and faces are missing.",
    ),
    Model("bunny", "bunny.obj", (), "A solid as it is."),
    Model(
        "chassis",
        "racecar/meshes/chassis.STL",
        ("merge_near",),
        "The body of a racing car, almost a block. Its corners stand once for each face, not always the same.",
    ),
    Model(
        "duck",
        "duck.obj",
        ("drop_crossing", "fill_holes", "drop_crossing", "fill_holes"),
        "The duck's beak runs through itself in one face; without it and its neighbours the rim is closed anew, twice.",
        y_up=True,
    ),
)

TEXT = (
    "What `proxyproof fit` says of models that PyBullet ships. Times are of one machine: their order "
    "tells something. Bounding volumes contain every corner, proven in exact arithmetic; colliders stand for the model "
    "and reach beyond it here and there, or not everywhere to its surface."
)


def cards(
    models: tuple[Model, ...] = MODELS, kinds: tuple[str, ...] = tuple(KINDS)
) -> Iterator[tuple[Model, Scorecard]]:
    """Measure all models."""
    if find_spec("pybullet_data") is None:
        raise StudyUnavailable("the models are PyBullet's: pip install 'proxyproof[studies]'")
    import pybullet_data  # noqa: PLC0415  an extra

    root = Path(pybullet_data.getDataPath())
    for model in track(models, description="models", transient=True):
        solid = load_polyhedron(root / model.file, repairs=model.repairs)
        yield model, scorecard(solid, kinds, name=model.file)


def upright(shape: Proxy) -> Proxy:
    """Turn what stands on its back; an AABB as a box."""
    return (shape.to_box() if isinstance(shape, AABB) else shape).rotated(UPRIGHT)


@contextmanager
def browser() -> Iterator[Any]:
    """Chromium, wherever it is installed."""
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415  an extra
    except ImportError:
        raise StudyUnavailable("pictures need playwright and Chromium: pip install 'proxyproof[test]'") from None
    with sync_playwright() as playwright:
        own = next(filter(None, map(shutil.which, BROWSERS)), playwright.chromium.executable_path)
        if not Path(own).exists():
            raise StudyUnavailable("pictures need Chromium: apt install chromium, or playwright install chromium")
        started = playwright.chromium.launch(executable_path=own, args=["--no-sandbox"])
        yield started
        started.close()


STYLE = (
    "body { margin: 0; background: #fff; font: 14px system-ui, sans-serif; color: #1b2128 }"
    f"main {{ display: grid; grid-template-columns: repeat({COLUMNS}, {WIDE}px); gap: 4px; padding: 4px }}"
    "section { margin: 0 } h3 { font-size: 14px; font-weight: 600; margin: 0 0 2px } figure.scene { margin: 0 }"
    f".scene > canvas, .scene > svg {{ height: {HIGH}px }} .scene-tools, figcaption {{ display: none }}"
)


def gallery(card: Scorecard, *, y_up: bool = False) -> str:
    """A page with some of the proxies over the model, as they are photographed."""
    model = card.model.rotated(UPRIGHT) if y_up else card.model
    parts = ""
    for kind in (kind for kind in SHOWN if kind in card.proxies):
        proxy, title = card.proxies[kind], KINDS[kind].title
        figure = viewer.model_figure(model, upright(proxy) if y_up else proxy, title)
        parts += f"<section><h3>{escape(title)}</h3>{figure}</section>"
    head = f'<meta charset="utf-8"><style>{viewer.style()}{STYLE}</style>'
    return f"<!DOCTYPE html>{head}<main>{parts}</main><script>{viewer.script()}</script>"


def photograph(started: Any, page: str, path: Path) -> None:
    """Take a picture of a page once its figures are drawn, in few colours."""
    from PIL import Image  # noqa: PLC0415  comes with matplotlib

    opened = started.new_page(viewport={"width": COLUMNS * (WIDE + 4) + 4, "height": 900}, color_scheme="light")
    opened.set_content(page)
    opened.wait_for_function("document.querySelectorAll('figure:not(.live)').length === 0")
    opened.wait_for_function(DRAWN)
    taken = Image.open(io.BytesIO(opened.locator("main").screenshot()))
    opened.close()
    taken.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def told(model: Model, card: Scorecard) -> str:
    """A section of the page."""
    data = 'python -c "import pybullet_data as d; print(d.getDataPath())"'
    repairs = "".join(f" --repair {name}" for name in model.repairs)
    lines = [f"## {model.name.capitalize()}", "", model.text, ""]
    lines += ["```", f'proxyproof fit "$({data})/{model.file}"{repairs}', "```", ""]
    lines += [f"![The {model.name} and some of its proxies](scorecard-{model.name}.png)", ""]
    lines += [scorecards.caption(card), "", *table_lines(scorecards.table(card)), ""]
    return "\n".join(lines)


def main(arguments: list[str]) -> None:
    """Write the page and its pictures."""
    folder = Path(arguments[0]) if arguments else HERE
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with browser() as started:
            parts = []
            for model, card in cards():
                photograph(started, gallery(card, y_up=model.y_up), folder / f"scorecard-{model.name}.png")
                parts.append(told(model, card))
    except StudyUnavailable as error:
        sys.exit(str(error))
    meaning = "\n".join(f"- {name}: {words}" for name, words in scorecards.MEANING)
    head = f"# Scorecards of models\n\nMade by `python -m reports.studies.scorecards`.\n\n{TEXT}\n\n{meaning}\n\n"
    (folder / "scorecards.md").write_text(head + "\n".join(parts), encoding="utf-8")
    print(folder / "scorecards.md")


if __name__ == "__main__":
    main(sys.argv[1:])
