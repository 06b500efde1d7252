"""A browser for the tests of pages: Chromium, wherever it is installed, without a network, its messages kept."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")


@contextmanager
def chromium() -> Iterator[Any]:
    """Start Chromium: the system's, or the one that `playwright install chromium` has put in place."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install '.[test]'")
    with sync_api.sync_playwright() as playwright:
        own = next(filter(None, map(shutil.which, NAMES)), playwright.chromium.executable_path)
        if not Path(own).exists():
            pytest.skip("Chromium is not installed: apt install chromium, or playwright install chromium")
        browser = playwright.chromium.launch(executable_path=own, args=["--no-sandbox"])
        yield browser
        browser.close()


@dataclass
class Visit:
    """A page that was opened, and what it said or asked for while it was."""

    page: Any
    messages: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


@contextmanager
def visit(browser: Any, address: str, **options: Any) -> Iterator[Visit]:
    """Open an address as a reader would who has no network; whatever the page says or fetches is a failure."""
    context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, "offline": True, **options})
    page = context.new_page()
    its = Visit(page)
    page.on("console", lambda message: its.messages.append(message.text))
    page.on("pageerror", lambda error: its.messages.append(str(error)))
    page.on("dialog", lambda dialog: (its.messages.append(dialog.message), dialog.dismiss()))
    page.on("request", lambda request: its.requests.append(request.url))
    page.goto(address)
    yield its
    context.close()
    assert its.messages == []
    documents = {request.partition("#")[0].partition("?")[0] for request in its.requests}
    assert documents == {address.partition("#")[0].partition("?")[0]}
