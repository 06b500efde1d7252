"""The viewer as a person uses it: 200 scenes on one page, turned by mouse, touch and keys, with WebGL and without."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from oracles.outcome import Bucket
from refimpl.pairs import TABLE
from reports import viewer
from tests.browser import Visit, chromium, visit
from tests.sample_run import sample_run
from tests.viewed import KINDS, points, torus, viewed

SCENES = 200
NO_WEBGL = """
const asked = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind.startsWith('webgl') ? null : asked.call(this, kind, ...rest);
};"""
LOSABLE = """
const asked = HTMLCanvasElement.prototype.getContext;
window.contexts = [];
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  const found = asked.call(this, kind, ...rest);
  if (kind.startsWith('webgl')) contexts.push(found);
  return found;
};"""
DRAWN = """async (figure) => {
  figure.scrollIntoView({ block: 'center' });
  for (let tries = 0; tries < 600; tries++) {
    const canvas = figure.querySelector('canvas');
    if (canvas && canvas.width) {
      const size = `${canvas.width} ${canvas.height}`;
      const { width, height } = canvas;
      window.blanks ||= {};
      blanks[size] ||= Object.assign(document.createElement('canvas'), { width, height }).toDataURL();
      const shown = canvas.toDataURL();
      if (shown !== blanks[size]) return shown;
    }
    await new Promise(requestAnimationFrame);
  }
  return '';
}"""
CHANGED = """async ([figure, before]) => {
  const canvas = figure.querySelector('canvas');
  let [last, still] = ['', 0];
  for (let tries = 0; tries < 300; tries++) {
    await new Promise(requestAnimationFrame);
    const shown = canvas.toDataURL();
    still = shown === last ? still + 1 : 0;
    last = shown;
    if (shown !== before && still > 2) return shown;
  }
  return before;
}"""

BECOME = """async ([figure, wanted]) => {
  const canvas = figure.querySelector('canvas');
  for (let tries = 0; tries < 600 && canvas.toDataURL() !== wanted; tries++) await new Promise(requestAnimationFrame);
  return canvas.toDataURL() === wanted;
}"""


def many() -> list[Bucket]:
    """Two hundred scenes, no two alike: every pair of types, at several places."""
    found = []
    for number in range(SCENES):
        A, B = list(TABLE)[number % len(TABLE)]
        shift = [0.25 * (number // len(TABLE)), 0.5, 0.0]
        a, b = KINDS[A], KINDS[B].translated(shift)
        found.append(viewed(a, b, answer=points([0.5, 0, 0], shift), reference=points([0, 0, 0], [1, 0, 0]), claim=""))
    return found


def page_of(buckets: list[Bucket], prelude: str = "") -> str:
    """The least page around figures, with the security policy of the report's."""
    style = "body{margin:1rem;font:15px sans-serif;background:#fff}" + viewer.style()
    scripts = [prelude, viewer.script()] if prelude else [viewer.script()]
    hashes = [_hash(text) for text in (style, *scripts)]
    policy = f"default-src 'none'; style-src {hashes[0]}; script-src {' '.join(hashes[1:])}"
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Scenes</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}"><style>{style}</style></head><body>'
        + "".join(map(str, map(viewer.figure, buckets)))
        + "".join(f"<script>{text}</script>" for text in scripts)
        + "</body></html>"
    )


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def buckets() -> list[Bucket]:
    boxes = points([1, 0, 0], [2, 0, 0], 1.0)
    return [
        *sample_run().buckets[:4],
        viewed(KINDS[_type("HalfSpace")], torus(16, 8), answer=boxes, reference=points([0, 0, 0], [1, 0, 0])),
        sample_run().buckets[8],
    ]


def _type(name: str) -> Any:
    return next(kind for kind in KINDS if kind.__name__ == name)


@pytest.fixture(scope="module")
def open_page(browser: Any, buckets: list[Bucket], tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("viewer")

    def opened(prelude: str = "", change: Any = None, **options: Any) -> AbstractContextManager[Visit]:
        source = page_of(buckets, prelude)
        path: Path = folder / f"{hashlib.sha256(source.encode()).hexdigest()[:8]}{bool(change)}.html"
        path.write_text(change(source) if change else source, encoding="utf-8")
        return visit(browser, path.as_uri(), **{"viewport": {"width": 400, "height": 700}, **options})

    return opened


@pytest.fixture(scope="module")
def shared(open_page: Any) -> Iterator[Any]:
    """One page for all tests that leave it as they found it."""
    with open_page(has_touch=True, color_scheme="light") as its:
        yield its.page


def figure_of(page: Any, number: int) -> Any:
    return page.query_selector_all("figure.scene")[number]


def canvas_of(page: Any, number: int) -> Any:
    return page.locator("figure.scene").nth(number).locator("canvas")


def drawn(page: Any, figure: Any) -> str:
    shown: str = page.evaluate(DRAWN, figure)
    assert shown
    return shown


def changed(page: Any, figure: Any, before: str) -> str:
    after: str = page.evaluate(CHANGED, [figure, before])
    assert after != before
    return after


def becomes(page: Any, figure: Any, wanted: str) -> None:
    """Wait for a picture that was seen before."""
    assert page.evaluate(BECOME, [figure, wanted])


# -- drawing -------------------------------------------------------------------------------------------------


def test_two_hundred_scenes_are_drawn_each_its_own(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "many.html"
    path.write_text(page_of(many()), encoding="utf-8")
    assert path.stat().st_size < 800_000
    with visit(browser, path.as_uri(), viewport={"width": 360, "height": 700}) as its:
        assert its.page.locator("canvas").count() < 10
        figures = its.page.query_selector_all("figure.scene")
        pictures = [drawn(its.page, figure) for figure in figures]
        assert len(pictures) == len(set(pictures)) == SCENES
        held = its.page.evaluate("[...document.querySelectorAll('canvas')].filter((c) => c.width).length")
        assert held < 10, "figures out of sight give their pixels back"


def test_without_webgl_every_scene_is_drawn_too(open_page: Any) -> None:
    with open_page() as its:
        usual = [drawn(its.page, figure) for figure in its.page.query_selector_all("figure.scene")]
    with open_page(NO_WEBGL) as its:
        plain = [drawn(its.page, figure) for figure in its.page.query_selector_all("figure.scene")]
        assert len(set(plain)) == len(plain)
        assert not set(plain) & set(usual)
        figure = figure_of(its.page, 3)
        before = drawn(its.page, figure)
        canvas_of(its.page, 3).press("ArrowLeft")
        changed(its.page, figure, before)


def test_a_lost_context_is_replaced(open_page: Any) -> None:
    with open_page(LOSABLE) as its:
        figure = figure_of(its.page, 3)
        before = drawn(its.page, figure)
        its.page.evaluate("contexts[0].getExtension('WEBGL_lose_context').loseContext()")
        canvas_of(its.page, 3).press("ArrowLeft")
        changed(its.page, figure, before)
        # a lost context is reported by the browser itself
        its.messages[:] = [text for text in its.messages if "CONTEXT_LOST" not in text]


def test_without_scripts_the_still_picture_stands(open_page: Any) -> None:
    with open_page(java_script_enabled=False) as its:
        assert its.page.locator("canvas").count() == 0
        for picture in its.page.locator("figure.scene > svg").all():
            box = picture.bounding_box()
            assert box["width"] > 300
            assert box["height"] > 200
        colours = its.page.locator("svg .a").first.screenshot()
        assert len(colours) > 100


def test_on_paper_the_still_picture_stands(shared: Any) -> None:
    page = shared
    drawn(page, figure_of(page, 0))
    assert not page.locator("figure.scene > svg").first.is_visible()
    page.emulate_media(media="print")
    assert page.locator("figure.scene > svg").first.is_visible()
    assert not page.locator("canvas").first.is_visible()
    page.emulate_media(media="screen")


def test_the_dark_has_its_own_colours(shared: Any) -> None:
    page = shared
    figure = figure_of(page, 0)
    light = drawn(page, figure)
    page.emulate_media(color_scheme="dark")
    changed(page, figure, light)
    page.emulate_media(color_scheme="light")
    becomes(page, figure, light)


def test_figures_with_broken_data_keep_their_still_picture(open_page: Any) -> None:
    def broken(source: str) -> str:
        return re.sub(r"data-scene='[^']*'", 'data-scene=\'{"a": [["nonsense"\'', source, count=1)

    with open_page(change=broken) as its:
        drawn(its.page, figure_of(its.page, 1))
        assert figure_of(its.page, 0).query_selector("canvas") is None
        assert its.page.locator("figure.scene > svg").first.is_visible()


def test_a_phone_sees_all_of_it(open_page: Any) -> None:
    with open_page(viewport={"width": 360, "height": 740}, device_scale_factor=3) as its:
        drawn(its.page, figure_of(its.page, 0))
        assert its.page.evaluate("document.documentElement.scrollWidth") <= 360
        size = its.page.evaluate("(({width, clientWidth}) => [width, clientWidth])(document.querySelector('canvas'))")
        assert size[0] == pytest.approx(2 * size[1], abs=2), "twice the pixels are enough"


# -- turning -------------------------------------------------------------------------------------------------


def test_keys_turn_zoom_move_and_reset(shared: Any) -> None:
    page, figure = shared, figure_of(shared, 3)
    canvas = canvas_of(page, 3)
    home = before = drawn(page, figure)
    seen = {home}
    for key in ("ArrowRight", "ArrowUp", "+", "Shift+ArrowLeft", "-"):
        canvas.press(key)
        before = changed(page, figure, before)
        seen.add(before)
    assert len(seen) == 6
    canvas.press("0")
    becomes(page, figure, home)
    canvas.press("a")
    assert drawn(page, figure) == home


def test_the_keyboard_reaches_the_picture_and_its_switches(open_page: Any) -> None:
    with open_page() as its:
        page = its.page
        drawn(page, figure_of(page, 0))
        page.keyboard.press("Tab")
        focused = page.evaluate("[document.activeElement.tagName, document.activeElement.getAttribute('aria-label')]")
        assert focused[0] == "CANVAS"
        assert "Sphere A and Capsule B: missed contact" in focused[1]
        assert "arrow keys" in focused[1]
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.textContent") == "A"


def test_the_mouse_turns_moves_and_zooms(shared: Any) -> None:
    page, figure = shared, figure_of(shared, 0)
    home = drawn(page, figure)
    box = canvas_of(page, 0).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.evaluate("document.activeElement.blur()")
    page.mouse.move(x, y)
    page.mouse.wheel(0, 1)
    assert drawn(page, figure) == home, "the wheel belongs to the page until the picture is chosen"
    page.mouse.down()
    page.mouse.move(x + 40, y + 20)
    page.mouse.up()
    turned = changed(page, figure, home)
    page.mouse.wheel(0, -200)
    nearer = changed(page, figure, turned)
    page.mouse.down(button="right")
    page.mouse.move(x, y)
    page.mouse.up(button="right")
    changed(page, figure, nearer)
    page.mouse.dblclick(x, y)
    becomes(page, figure, home)


def test_one_finger_turns_and_two_zoom(shared: Any) -> None:
    page, figure = shared, figure_of(shared, 0)
    home = drawn(page, figure)
    box = canvas_of(page, 0).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    send = page.context.new_cdp_session(page).send

    def touch(kind: str, *places: tuple[float, float]) -> None:
        fingers = [{"x": x + dx, "y": y + dy, "id": i} for i, (dx, dy) in enumerate(places)]
        send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})

    touch("touchStart", (0, 0))
    touch("touchMove", (30, 0))
    touch("touchMove", (60, 0))
    touch("touchEnd")
    turned = changed(page, figure, home)
    touch("touchStart", (-20, 0), (20, 0))
    touch("touchMove", (-40, 0), (40, 0))
    touch("touchMove", (-60, 0), (60, 0))
    touch("touchEnd")
    changed(page, figure, turned)
    canvas_of(page, 0).press("Home")
    becomes(page, figure, home)


# -- layers --------------------------------------------------------------------------------------------------


def test_every_layer_can_be_switched_off_and_on(shared: Any) -> None:
    page, figure = shared, figure_of(shared, 3)
    home = drawn(page, figure)
    buttons = page.locator("figure.scene").nth(3).locator("button[aria-pressed]")
    assert buttons.all_inner_texts() == ["A", "B", "fcl", "truth", "proof"]
    off = []
    for button in buttons.all():
        button.click()
        assert button.get_attribute("aria-pressed") == "false"
        off.append(changed(page, figure, home))
        button.click()
        becomes(page, figure, home)
    assert len(set(off)) == len(off)


def test_an_impact_has_velocities_before_and_after(shared: Any) -> None:
    page = shared
    drawn(page, figure_of(page, 5))
    buttons = page.locator("figure.scene").nth(5).locator("button[aria-pressed]")
    assert buttons.all_inner_texts() == ["A", "B", "bullet", "truth", "before"]


def test_the_reset_button_brings_back_the_first_view(shared: Any) -> None:
    page, figure = shared, figure_of(shared, 3)
    home = drawn(page, figure)
    canvas_of(page, 3).press("ArrowDown")
    changed(page, figure, home)
    page.locator("figure.scene").nth(3).get_by_role("button", name="reset").click()
    becomes(page, figure, home)
