"""How fast a browser shows a report: ``python -m tests.benchmarks.page [INDEX.HTML]...``.

Prints, of each page, its size, the median time from opening it to the first paint and to the end of its script, and
how long one change of a filter takes; without a page, of the tests' sample with 200 findings and with 700.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from reports import html
from tests.browser import chromium, visit
from tests.sample_run import sample_run, spread

ROUNDS = 5

TIMES = """async () => {
  const paint = () => performance.getEntriesByName("first-contentful-paint")[0];
  while (!paint()) await new Promise(requestAnimationFrame);
  const began = performance.now();
  const engine = document.querySelector("#filters [name=engine]");
  engine.selectedIndex = 1;
  engine.dispatchEvent(new Event("input", { bubbles: true }));
  document.body.getBoundingClientRect();
  const filtered = performance.now() - began;
  return [paint().startTime, performance.getEntriesByType("navigation")[0].domContentLoadedEventEnd, filtered];
}"""


def measured(browser: Any, page: Path) -> str:
    """One line on a page."""
    rounds = []
    for _ in range(ROUNDS):
        with visit(browser, page.absolute().as_uri()) as its:
            rounds.append(its.page.evaluate(TIMES))
    paint, loaded, filtered = (median(column) for column in zip(*rounds, strict=True))
    size = page.stat().st_size / 1e6
    return f"{size:6.2f} MB  {paint:6.0f} ms to the first paint  {loaded:6.0f} ms loaded  {filtered:6.0f} ms to filter"


def samples(folder: Path) -> Iterator[Path]:
    """Pages of 200 and of 700 findings."""
    run = sample_run()
    for count in (200, 700):
        path = folder / f"{count}.html"
        path.write_text(html.render(dataclasses.replace(run, buckets=spread(run, count))), "utf-8")
        yield path


def main(names: list[str]) -> None:
    """Print a line for each page."""
    with chromium() as browser, TemporaryDirectory() as folder:
        for page in map(Path, names) if names else samples(Path(folder)):
            print(f"{page.name:20} {measured(browser, page)}")


if __name__ == "__main__":
    main(sys.argv[1:])
