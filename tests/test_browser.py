"""The page as a person uses it: in a browser, from disk, with the keyboard, on a phone, in the dark, on paper."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from oracles.accuracy import Accuracy
from oracles.outcome import Run, State
from reports import cells, findings, html
from reports.plots import plots
from tests.browser import Visit, chromium, visit
from tests.sample_run import sample_run, spread
from tests.test_accuracy_report import ACCURACY
from tests.test_report_hostile import BIDI, NASTY, hostile_run

Open = Callable[..., AbstractContextManager[Visit]]

PHONE = {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def run() -> Run:
    found, names = sample_run(), {"one": "fcl", "two": "bullet"}
    found.accuracy = Accuracy(
        *(
            tuple(dataclasses.replace(item, engine=names[item.engine]) for item in items)
            for items in (ACCURACY.errors, ACCURACY.points, ACCURACY.speeds)
        )
    )
    return found


@pytest.fixture(scope="module")
def file(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "index.html"
    path.write_text(html.render(run), "utf-8")
    return path


@pytest.fixture
def opened(browser: Any, file: Path) -> Open:
    return lambda rest="", **options: visit(browser, file.as_uri() + rest, **options)


def control(page: Any, name: str) -> Any:
    return page.locator(f"#filters [name={name}]")


def shown_rows(page: Any) -> list[tuple[str, str]]:
    """Pair and query of each row that is seen, asked of the page at once."""
    seen = """rows => rows.filter(row => row.checkVisibility())
        .map(row => [row.querySelector("th").innerText, row.querySelector("td").innerText])"""
    return [tuple(row) for row in page.locator("#cells tbody tr").evaluate_all(seen)]


def shown_findings(page: Any) -> list[int]:
    return [int(words) for words in page.locator(".findings > li:visible .no").all_text_contents()]


def numbers(run: Run, wanted: Callable[[Any], bool]) -> list[int]:
    return [number for number, bucket in enumerate(run.buckets, 1) if wanted(bucket)]


# -- opening -------------------------------------------------------------------------------------------------


def test_opens_from_disk_and_says_what_ran(opened: Open, run: Run) -> None:
    with opened() as its:
        page = its.page
        assert page.title() == "proxyproof: discrepancy report"
        assert page.locator(".verdict").inner_text() == findings.headline(run)
        assert page.locator("#shown").inner_text() == f"{2 * len(cells.rows(run))} cells, {len(run.buckets)} findings"
        assert page.locator("#unsettled .tag").all_inner_texts() == ["NEW"] * 9 + ["STALE", "CHANGED"]
        assert page.locator("#accuracy svg.plot:visible").count() == len(plots(run)) == 3
        assert page.evaluate("performance.getEntriesByType('resource').length") == 0


def test_a_pair_opens_to_its_regimes_by_the_keyboard(opened: Open) -> None:
    with opened() as its:
        table = its.page.locator("#accuracy table", has_text="Errors of each pair and query")
        table.evaluate("table => { table.closest('details').open = true }")
        row, rows = table.locator("tbody tr").first, table.locator("tbody tr:visible")
        button, before = row.get_by_role("button"), rows.count()
        assert button.get_attribute("aria-expanded") == "false"
        button.focus()
        its.page.keyboard.press("Enter")
        assert button.get_attribute("aria-expanded") == "true"
        assert rows.count() == before + 3
        tiny = table.locator("tr.more", has_text="tiny")
        assert tiny.locator("td").all_inner_texts()[:4] == [
            "1.0e-09\n2.0e-09",
            "1.0e-06\n2.0e-06",
            "≥ 1.0e-03\n≥ 2.0e-03",
            "–",
        ]
        assert table.locator("tr.more").last.inner_text() == "no error in 2 regimes"
        its.page.keyboard.press("Enter")
        assert rows.count() == before


# -- filters -------------------------------------------------------------------------------------------------


def test_filters_leave_what_was_asked_for(opened: Open, run: Run) -> None:
    with opened() as its:
        page, rows = its.page, cells.rows(run)
        control(page, "engine").select_option("fcl")
        assert shown_findings(page) == numbers(run, lambda bucket: bucket.engine == "fcl")
        assert page.locator("#cells thead .group:visible").all_inner_texts() == ["fcl"]
        control(page, "type").select_option("Box")
        control(page, "query").select_option("distance")
        control(page, "show").select_option("wrong")
        wanted = [
            (row.pair, row.query)
            for row in rows
            if "Box" in row.pair.split("–") and row.query == "distance" and "wrong" in row.cells[0].flags
        ]
        assert shown_rows(page) == wanted
        assert page.locator("#shown").inner_text().startswith(f"{len(wanted)} cell")
        page.get_by_role("button", name="Reset").click()
        assert shown_findings(page) == numbers(run, lambda bucket: True)
        assert "?" not in page.url


@pytest.mark.parametrize(("show", "flag"), [("new", "new"), ("stale", "stale"), ("unsupported", "unsupported")])
def test_what_to_show(opened: Open, run: Run, show: str, flag: str) -> None:
    with opened(f"?show={show}") as its:
        wanted = [(row.pair, row.query) for row in cells.rows(run) if any(flag in cell.flags for cell in row.cells)]
        assert shown_rows(its.page) == wanted
        if show == "new":
            assert shown_findings(its.page) == numbers(run, lambda bucket: bucket.state is State.NEW)


def test_where_engines_differ(opened: Open, run: Run) -> None:
    with opened("?show=differ") as its:
        assert shown_rows(its.page) == [(row.pair, row.query) for row in cells.rows(run) if row.differ]


def test_find_looks_into_what_findings_are_called(opened: Open, run: Run) -> None:
    with opened() as its:
        control(its.page, "find").fill("No Answer In")
        assert shown_findings(its.page) == numbers(run, lambda bucket: bucket.symptom == "no answer in time")


# -- order ---------------------------------------------------------------------------------------------------


def test_columns_sort_by_what_they_hold(opened: Open, run: Run) -> None:
    with opened() as its:
        page = its.page
        head = page.locator("th[data-sort=worst-0]")
        head.get_by_role("button").click()
        assert head.get_attribute("aria-sort") == "descending"
        worst = sorted((row for row in cells.rows(run) if row.cells[0].worst), key=lambda row: -row.cells[0].worst)
        assert shown_rows(page)[: len(worst)] == [(row.pair, row.query) for row in worst]
        assert "sort=-worst-0" in page.url
        head.get_by_role("button").click()
        assert head.get_attribute("aria-sort") == "ascending"
        head.get_by_role("button").click()
        assert head.get_attribute("aria-sort") == "none"
        assert shown_rows(page) == [(row.pair, row.query) for row in cells.rows(run)]


def test_findings_in_another_order(opened: Open, run: Run) -> None:
    with opened("?order=count") as its:
        most = sorted(numbers(run, lambda bucket: True), key=lambda number: -run.buckets[number - 1].count)
        assert shown_findings(its.page) == most


# -- addresses -----------------------------------------------------------------------------------------------


def test_address_keeps_the_filter(opened: Open, run: Run) -> None:
    with opened() as its:
        control(its.page, "engine").select_option("bullet")
        control(its.page, "show").select_option("wrong")
        rows = shown_rows(its.page)
        its.page.reload()
        assert control(its.page, "engine").input_value() == "bullet"
        assert shown_rows(its.page) == rows
        assert 0 < len(rows) < len(cells.rows(run))


def test_link_to_a_finding_opens_it_even_where_the_filter_hides_it(opened: Open, run: Run) -> None:
    bucket = next(bucket for bucket in run.buckets if bucket.engine == "bullet")
    with opened(f"?engine=fcl#b-{bucket.id}") as its:
        article = its.page.locator(f"#b-{bucket.id}")
        assert article.is_visible()
        assert 0 <= article.bounding_box()["y"] < 300
        assert control(its.page, "engine").input_value() == ""


def test_link_to_a_cell_keeps_the_filter(opened: Open, run: Run) -> None:
    with opened("?engine=fcl&show=wrong#c-fcl-distance-Box-Box") as its:
        box = its.page.locator("#c-fcl-distance-Box-Box").bounding_box()
        assert 0 <= box["y"] < 900
        assert all(pair for pair in shown_rows(its.page))
        its.page.locator("#c-fcl-distance-Box-Box a").click()
        first = next(bucket for bucket in run.buckets if (bucket.engine, bucket.pair) == ("fcl", "Box–Box"))
        shown = next(b for b in run.buckets if (b.engine, b.query, b.pair) == ("fcl", "distance", first.pair))
        assert its.page.locator(f"#b-{shown.id}").is_visible()
        assert "engine=fcl" in its.page.url


def test_address_that_means_nothing_shows_everything(opened: Open, run: Run) -> None:
    with opened("?engine=%3Cscript%3E&type=&show=nothing&sort=-x-9&order=y&more=z#%") as its:
        assert shown_findings(its.page) == numbers(run, lambda bucket: True)
        assert shown_rows(its.page) == [(row.pair, row.query) for row in cells.rows(run)]


def test_run_that_asked_nothing_opens(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "index.html"
    path.write_text(html.render(Run(0, 1.0, "", interrupted=True)), "utf-8")
    with visit(browser, path.as_uri() + "?engine=x") as its:
        assert "interrupted" in its.page.locator(".warnings").inner_text()
        assert its.page.locator("#shown").inner_text() == "0 cells, 0 findings"


def test_overview_leads_to_all_that_is_new(browser: Any, run: Run, tmp_path: Path) -> None:
    many = dataclasses.replace(run, buckets=[*run.buckets, *spread(run, 20)])
    path = tmp_path / "index.html"
    path.write_text(html.render(many), "utf-8")
    with visit(browser, path.as_uri()) as its:
        its.page.get_by_role("link", name="All 29 new findings").click()
        assert len(shown_findings(its.page)) == 29
        assert control(its.page, "show").input_value() == "new"


# -- without a mouse, without sight ------------------------------------------------------------------------


def test_all_of_it_works_with_the_keyboard(opened: Open, run: Run) -> None:
    with opened() as its:
        page = its.page
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.className") == "skip"
        assert page.locator(".skip").bounding_box()["width"] > 50
        page.keyboard.press("Enter")
        assert page.url.endswith("#main")
        control(page, "engine").focus()
        page.keyboard.press("ArrowDown")
        assert control(page, "engine").input_value() == "fcl"
        page.locator("th[data-sort=pair] button").focus()
        page.keyboard.press("Enter")
        assert page.locator("th[data-sort=pair]").get_attribute("aria-sort") == "ascending"
        page.locator(".findings > li:visible summary").first.focus()
        page.keyboard.press("Enter")
        assert page.locator(".findings article:visible").count() == 1
        outline = "getComputedStyle(document.activeElement).outlineStyle"
        assert page.evaluate(outline) != "none"


NAMELESS = """() => [...document.querySelectorAll("a, button, select, input, summary, [role=region]")].filter((e) =>
  !e.textContent.trim() && !e.labels?.length && !document.getElementById(e.getAttribute("aria-labelledby"))
).map((e) => e.outerHTML)"""


def test_everything_has_a_name_for_screen_readers(opened: Open) -> None:
    with opened() as its:
        page = its.page
        page.evaluate("document.querySelectorAll('details').forEach((box) => { box.open = true; })")
        assert page.evaluate(NAMELESS) == []
        for role, least in (("combobox", 5), ("searchbox", 1), ("table", 12), ("region", 8), ("navigation", 1)):
            assert page.get_by_role(role, name=re.compile("[a-z]")).count() >= least, role
        assert page.locator("#shown").get_attribute("aria-live") == "polite"
        assert page.locator("td.wrong a", has_text="✗").first.text_content().strip().startswith("✗")
        assert "wrong" in page.locator("#c-fcl-distance-Box-Box a").text_content()


CONTRASTS = """() => {
  const light = (colour) => {
    const [r, g, b] = colour.match(/[0-9.]+/g).map((x) => x / 255)
      .map((x) => x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const colour = getComputedStyle(e).backgroundColor;
      if (!/^rgba.*, 0\\)$/.test(colour)) return colour;
    }
    return "rgb(255, 255, 255)";
  };
  const told = document.querySelectorAll("p, a, td, th, dt, dd, small, .tag, summary span, button, option");
  return [...told].map((element) => {
    const [a, b] = [light(getComputedStyle(element).color), light(behind(element))];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  });
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_stand_out_by_day_and_by_night(opened: Open, scheme: str) -> None:
    with opened(color_scheme=scheme) as its:
        ground = its.page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert ground == {"light": "rgb(255, 255, 255)", "dark": "rgb(20, 24, 28)"}[scheme]
        contrasts = its.page.evaluate(CONTRASTS)
        assert len(contrasts) > 1000
        assert min(contrasts) >= 4.5


# -- without scripts, on a phone, on paper -------------------------------------------------------------------


def test_without_scripts_all_of_it_can_be_read(opened: Open, run: Run) -> None:
    bucket = run.buckets[3]
    with opened(f"#b-{bucket.id}", java_script_enabled=False) as its:
        page = its.page
        assert not page.locator("#filters").is_visible()
        assert not page.get_by_label("Order").is_visible()
        assert page.locator(f"#b-{bucket.id}").is_visible()
        assert shown_findings(page) == numbers(run, lambda bucket: True)
        page.locator(".findings summary").first.click()
        assert page.locator(f"#b-{run.buckets[0].id}").is_visible()
        assert page.locator("#cells tbody tr:visible").count() == len(cells.rows(run))


def test_on_a_phone_the_page_does_not_scroll_sideways(opened: Open) -> None:
    with opened(viewport=PHONE) as its:
        page = its.page
        page.evaluate("document.querySelectorAll('details').forEach((box) => { box.open = true; })")
        assert page.evaluate("document.documentElement.scrollWidth") == 390
        for name in ("engine", "type", "query", "show", "find"):
            assert control(page, name).bounding_box()["height"] >= 36


def test_print_shows_every_finding_and_no_control(opened: Open, run: Run) -> None:
    with opened() as its:
        page = its.page
        page.emulate_media(media="print")
        assert not page.locator("#filters").is_visible()
        assert not page.locator(".command button:visible").count()
        heights = page.locator("article").evaluate_all("found => found.map((e) => e.getBoundingClientRect().height)")
        assert len(heights) == len(run.buckets)
        assert min(heights) > 200
        assert page.pdf()[:5] == b"%PDF-"


def test_command_is_copied(opened: Open, run: Run) -> None:
    view = findings.bucket_views(run)[0]
    with opened(f"#{view.anchor}", permissions=["clipboard-read", "clipboard-write"]) as its:
        its.page.locator(f"#{view.anchor}").get_by_role("button", name="Copy the command").click()
        its.page.get_by_text("Copied").wait_for()
        assert its.page.evaluate("navigator.clipboard.readText()") == f"python {view.file}"


# -- hostile, and many ---------------------------------------------------------------------------------------


def test_hostile_names_and_ten_megabytes_of_error_are_shown_harmlessly(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "index.html"
    path.write_text(html.render(hostile_run(NASTY, error=f"<script>alert(1)</script>{BIDI}" * 400_000)), "utf-8")
    assert path.stat().st_size < 500_000
    with visit(browser, path.as_uri(), viewport=PHONE) as its:
        page = its.page
        page.evaluate("document.querySelectorAll('details').forEach((box) => { box.open = true; })")
        assert page.evaluate("document.documentElement.scrollWidth") == 390
        assert page.locator("img, iframe").count() == 0
        assert page.locator("script").count() == 1
        assert "<script>alert(1)</script>⟨U+202E⟩" in page.locator("article pre").first.text_content()
        control(page, "engine").select_option(index=1)
        assert page.locator(".findings > li:visible").count() == 2


def test_two_hundred_findings_stay_below_two_megabytes(browser: Any, run: Run, tmp_path: Path) -> None:
    many = dataclasses.replace(run, buckets=spread(run, 200))
    path = tmp_path / "index.html"
    path.write_text(html.render(many), "utf-8")
    assert path.stat().st_size < 2_000_000
    with visit(browser, path.as_uri()) as its:
        its.page.wait_for_function("performance.getEntriesByName('first-contentful-paint').length")
        paint = its.page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
        assert 0 < paint < 5000
