"""The report's folder: `index.html`, `report.md`, `report.json`, and `repro/` with a script per bucket."""

from __future__ import annotations

import json
import os
import re
import tempfile
from pathlib import Path

from oracles.outcome import Run
from reports import html, markdown
from reports.findings import bucket_views
from reports.summary import report_json

OWN_SCRIPT = re.compile(r"repro/\d{3,}-[A-Za-z0-9-]+\.py")


class FolderError(Exception):
    """The report cannot be written there; the text says why, and the way out."""


def prepare(folder: Path) -> None:
    """Make the folder and see that it can be written to, before a campaign spends its time.

    Raises
    ------
    FolderError
        When it is a file, or may not be written.
    """
    if folder.exists() and not folder.is_dir():
        raise FolderError(f"{str(folder)!r} is a file: name a folder with --out")
    if (folder / "index.html").exists() and not (folder / "report.json").exists():
        raise FolderError(
            f"{str(folder)!r} holds an index.html that is no report of ours: name another folder with --out"
        )
    try:
        (folder / "repro").mkdir(parents=True, exist_ok=True)
        for place in (folder, folder / "repro"):
            with tempfile.TemporaryFile(dir=place):
                pass
    except OSError as error:
        raise FolderError(_refused(folder, error)) from None


def write(run: Run, folder: Path) -> None:
    """Write the whole report, in place of an older one.

    Raises
    ------
    FolderError
        When the folder cannot be written.
    """
    prepare(folder)
    try:
        _remove_old_scripts(folder)
        for view in bucket_views(run):
            if view.repro:
                _replace(folder / view.file, view.repro)
        _replace(folder / "report.json", report_json(run))
        _replace(folder / "report.md", markdown.render(run))
        _replace(folder / "index.html", html.render(run))
    except OSError as error:
        raise FolderError(_refused(folder, error)) from None


def _refused(folder: Path, error: OSError) -> str:
    return f"cannot write to {str(folder)!r} ({error.strerror or error}): name another folder with --out"


def _replace(path: Path, content: str) -> None:
    """Write beside the old file and move over it: a reader never sees half a report."""
    beside = path.with_name(path.name + ".part")
    beside.write_text(content, encoding="utf-8", errors="backslashreplace", newline="\n")
    os.replace(beside, path)


def _remove_old_scripts(folder: Path) -> None:
    """Remove the scripts that the last report in this folder lists, and no file that is not ours."""
    try:
        old = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        listed = [bucket["repro"] for bucket in old["buckets"]]
    except (OSError, ValueError, LookupError, TypeError):
        return
    for name in listed:
        if isinstance(name, str) and OWN_SCRIPT.fullmatch(name):
            (folder / name).unlink(missing_ok=True)
