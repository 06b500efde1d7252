"""The report's folder: each form of the report, and below it scripts and issue texts, one for each bucket."""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from oracles.outcome import Run
from reports import broad_phase, html, issues, junit, markdown, sarif, viewer
from reports.accuracy_data import as_csv
from reports.findings import bucket_views
from reports.summary import SCHEMA, report_json, schema

BELOW = {"repro": "py", "issues": "md", "pictures": "svg"}
"""Folders with a file for each bucket, and how those end."""

OWN = re.compile(r"\d{3,}-[A-Za-z0-9-]+\.")
"""What their names begin with."""


class FolderError(Exception):
    """The report cannot be written there; the text says why, and the way out."""


def prepare(folder: Path) -> None:
    """Make the folder and see that it can be written to, before a campaign spends its time.

    Raises
    ------
    FolderError
        When it is a file, or may not be written.
    """
    if (folder / "index.html").exists() and not (folder / "report.json").exists():
        raise FolderError(
            f"{str(folder)!r} holds an index.html that is no report of ours: name another folder with --out"
        )
    for place in (folder, *(folder / name for name in BELOW)):
        require_writable(place)


def require_writable(folder: Path) -> None:
    """Make a folder, and see that it can be written to; raises `FolderError`."""
    if folder.exists() and not folder.is_dir():
        raise FolderError(f"{str(folder)!r} is a file: name a folder with --out")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
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
        _remove_old(folder)
        for name, content in contents(run):
            _replace(folder / name, content)
    except OSError as error:
        raise FolderError(_refused(folder, error)) from None


def contents(run: Run) -> Iterator[tuple[str, str]]:
    """Each file of the report: its path within the folder, and its text."""
    views = bucket_views(run)
    for bucket, view, issue in zip(run.buckets, views, issues.issues(run, views), strict=True):
        if view.repro:
            yield view.file, view.repro
        yield view.issue, issue
        yield view.picture, viewer.picture(bucket)
    yield from broad_phase.scripts(run).items()
    yield "report.json", report_json(run)
    yield "accuracy.csv", as_csv(run)
    yield SCHEMA, schema()
    yield "junit.xml", junit.render(run, views)
    yield "report.sarif", sarif.render(run, views)
    yield "report.md", markdown.render(run, beside=True)
    yield "index.html", html.render(run)


def _refused(folder: Path, error: OSError) -> str:
    return f"cannot write to {str(folder)!r} ({error.strerror or error}): name another folder with --out"


def _replace(path: Path, content: str | bytes) -> None:
    """Write beside the old file and move over it: a reader never sees half a report."""
    beside = path.with_name(path.name + ".part")
    beside.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", errors="backslashreplace"))
    os.replace(beside, path)


def write_files(folder: Path, files: Mapping[str, str | bytes], own: str) -> None:
    """Write files that are no report of a campaign, in place of older ones.

    Parameters
    ----------
    own
        The one of them by which a folder is known to hold such files: another one's page is not overwritten.

    Raises
    ------
    FolderError
        When the folder cannot be written, or is somebody else's.
    """
    if folder.exists() and not folder.is_dir():
        raise FolderError(f"{str(folder)!r} is a file: name a folder with --out")
    if (folder / "index.html").exists() and not (folder / own).exists():
        raise FolderError(f"{str(folder)!r} holds an index.html that is not ours: name another folder with --out")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            _replace(folder / name, content)
    except OSError as error:
        raise FolderError(_refused(folder, error)) from None


def _remove_old(folder: Path) -> None:
    """Remove what the last report in this folder has for each bucket, and no file that is not ours."""
    try:
        old = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        listed = [Path(bucket["repro"]).stem for bucket in old["buckets"]]
        crowds = [
            broad_phase.script_path(str(count["engine"]), str(count["regime"]), str(witness["entry"]))
            for count in old.get("crowds", [])
            for witness in count["witnesses"]
        ]
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return
    for path in crowds:
        (folder / path).unlink(missing_ok=True)
    for stem in listed:
        for name, ending in BELOW.items():
            if OWN.fullmatch(f"{stem}."):
                (folder / name / f"{stem}.{ending}").unlink(missing_ok=True)
