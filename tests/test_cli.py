"""The command line: what it accepts, what it refuses and how, and what it leaves."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import types
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from oracles.engine import EngineUnavailable
from oracles.engines import PACKAGES, SHIPPED
from oracles.outcome import Kind, Run, State, Verdict
from refimpl.pairs import PROBES, SOLIDS, TABLE
from reports import cli, verify, vs
from tests.sample_run import sample_run

ROOT = Path(cli.__file__).parents[1]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep a report that lands in the current folder by mistake out of this one."""
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Put a campaign that answers at once in the place of the real one; returns what it was asked."""
    said: dict[str, Any] = {"run": sample_run()}
    said["run"].ledger = []
    for bucket in said["run"].buckets:
        bucket.state = State.EXPECTED

    def run_campaign(engines: Sequence[str], *, listener: Any = None, **options: Any) -> Run:
        said.update(options, engines=list(engines))
        run: Run = said["run"]
        listener.started(engines, 130)
        for elapsed in (1.0, 11.0, 12.0, 59.0, 61.0):
            listener.advanced(run, elapsed)
        if "raises" in said:
            raise said["raises"]
        return run

    campaign = types.ModuleType("oracles.campaign")
    campaign.run_campaign = run_campaign  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "oracles.campaign", campaign)
    engines = types.ModuleType("oracles.engines")
    engines.available_engines = lambda: {"fcl": None, "bullet": None, "other": "not installed"}  # type: ignore[attr-defined]
    engines.load_engine = load_engine  # type: ignore[attr-defined]
    engines.PACKAGES, engines.SHIPPED = PACKAGES, SHIPPED  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "oracles.engines", engines)
    return said


def load_engine(name: str) -> None:
    if name == "broken.py:Engine":
        raise NameError("name 'x' is not defined\nreally")
    if name not in ("fcl", "bullet", "mine.py:Mine"):
        raise EngineUnavailable(f"no engine {name!r}: there are fcl, bullet")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "report"


# -- run -----------------------------------------------------------------------------------------------------


def test_run_leaves_a_complete_report(asked: Any, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", "--out", str(out), "--seed", "7", "--budget", "5"]) == 0
    assert verify.completeness(out) == []
    assert (asked["engines"], asked["budget"], asked["seed"], asked["pairs"]) == (["fcl", "bullet"], 5.0, 7, None)
    printed = capsys.readouterr()
    assert "fcl is wrong in" in printed.out
    assert re.search(r"^bullet +\d(.*\n){5}  raycast +\d", printed.out, re.MULTILINE)
    for bucket in asked["run"].buckets:
        assert bucket.key in printed.out
    assert str(out / "index.html") in printed.out
    assert [line for line in printed.err.splitlines() if line] == [
        "asking fcl and bullet: 130 cells, 5\u202fs",
        *(line for line in printed.err.splitlines() if "compared" in line),
    ]
    assert printed.err.count("compared") == 3


def test_run_writes_the_summary_of_a_step(asked: Any, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    summary = out.parent / "summary.md"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(summary))
    assert cli.main(["run", "--out", str(out)]) == 0
    said = summary.read_text("utf-8")
    assert said.splitlines()[:3] == (out / "report.md").read_text("utf-8").splitlines()[:3]
    assert said.count("\n#### ") == len(asked["run"].buckets)


def test_run_passes_on_what_was_asked(asked: Any, out: Path) -> None:
    pairs = ["--pair", "box-sphere", "--pair", "Sphere–Box", "--pair", "Ray - AABB"]
    assert (
        cli.main(["run", "--engine", "bullet", "--engine", "bullet", *pairs, "--call-limit", "2", "--out", str(out)])
        == 0
    )
    assert (asked["engines"], asked["pairs"], asked["call_limit"]) == (["bullet"], ["Sphere–Box", "Ray–AABB"], 2.0)


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"problems": ["nothing compared in one cell"]}, 1),
        ({"interrupted": True}, 130),
        ({"interrupted": True, "problems": ["nothing compared in one cell"]}, 130),
        ({"reference_wrong": True, "interrupted": True, "problems": ["the reference was proven wrong"]}, 3),
    ],
)
def test_exit_status_tells_what_became_of_it(asked: Any, out: Path, change: dict[str, Any], status: int) -> None:
    run = asked["run"]
    if change.pop("reference_wrong", False):
        run.buckets[0].witness.__dict__["verdict"] = Verdict(Kind.REFERENCE_WRONG, claim="a certificate failed")
    for name, value in change.items():
        setattr(run, name, value)
    assert cli.main(["run", "--out", str(out)]) == status
    assert (out / "index.html").read_text("utf-8").endswith("</html>")
    assert json.loads((out / "report.json").read_text("utf-8"))["interrupted"] == run.interrupted


def test_interrupt_before_the_first_answer(asked: Any, out: Path) -> None:
    asked["raises"] = KeyboardInterrupt()
    assert cli.main(["run", "--out", str(out)]) == 130


# -- bad input -----------------------------------------------------------------------------------------------

BAD = [
    (["run", "--engine", "foo"], "no engine 'foo'"),
    (["run", "--engine", ""], "no engine ''"),
    (["run", "--engine", "broken.py:Engine"], "NameError"),
    (["run", "--budget", "0"], "--budget must be a positive number of seconds, got 0"),
    (["run", "--budget", "-3"], "--budget"),
    (["run", "--budget", "nan"], "--budget"),
    (["run", "--budget", "inf"], "--budget"),
    (["run", "--budget", "soon"], "--budget must be a positive number of seconds, got soon"),
    (["run", "--budget"], "requires an argument"),
    (["run", "--call-limit", "0"], "--call-limit"),
    (["run", "--seed", "-1"], "--seed must be a whole number from 0 to"),
    (["run", "--seed", "1.5"], "got 1.5"),
    (["run", "--seed", "9" * 30], "--seed must be a whole number from 0 to"),
    (["run", "--pair", "Sphere-Cone"], "--pair 'Sphere-Cone' is not in the pair table"),
    (["run", "--pair", "Sphere"], "Sphere, Capsule"),
    (["run", "--pair", "Point-Ray"], "--pair"),
    (["run", "--pair", ""], "--pair"),
    (["run", "--pair", "\x1b[31m\nRay"], "--pair"),
    (["run", "--engine", "\x1b[31m\nfcl"], "no engine"),
    (["run", "--budget", "\x1b[31m\n"], "⟨U+001B⟩"),
    (["--\x1b[31m\n"], "No such option"),
    (["run", "--engine", "mine.py:Mine", "--update-ledger"], "--update-ledger needs --ledger FILE"),
    (["run", "--out", ""], "--out must name a folder"),
    (["run", "--out", "a\0b"], "--out must name a folder"),
    (["run", "--database", ""], "--database must name a folder"),
    (["run", "--database", "/dev/null/kept"], "--database /dev/null/kept: "),
    (["run", "--frobnicate"], "No such option"),
    (["run", "surplus"], "unexpected extra argument"),
    (["walk"], "No such command 'walk'"),
    (["--loud"], "No such option"),
    (["table", "--html"], "No such option"),
]


@pytest.mark.parametrize(("arguments", "named"), BAD, ids=[ascii(" ".join(a)) for a, _ in BAD])
def test_bad_input_gets_one_clear_line(
    asked: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    named: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert printed.err.startswith("proxyproof: ")
    assert "\x1b" not in printed.err
    assert named in printed.err
    assert "budget" not in asked
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_folder_that_cannot_be_written_is_refused_before_the_run(
    asked: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str], place: str
) -> None:
    (tmp_path / "file").write_text("mine")
    assert cli.main(["run", "--out", str(tmp_path / place)]) == 2
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1
    assert "--out" in printed
    assert "budget" not in asked
    assert (tmp_path / "file").read_text() == "mine"


def test_engine_that_is_lost_at_the_start_is_named(asked: Any, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked["raises"] = EngineUnavailable("the engine 'fcl' cannot be imported: no such library")
    assert cli.main(["run", "--out", str(out)]) == 2
    assert "proxyproof: the engine 'fcl' cannot be imported" in capsys.readouterr().err.splitlines()[-1]


def test_no_engine_installed(
    asked: Any, out: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.modules["oracles.engines"], "available_engines", lambda: {"fcl": "missing"})
    assert cli.main(["run", "--out", str(out)]) == 2
    assert "pip install python-fcl pybullet" in capsys.readouterr().err


# -- table, help, version ------------------------------------------------------------------------------------


def test_table_shows_every_row_of_the_pair_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["table"]) == 0
    printed = capsys.readouterr().out
    matrix, legend, *_ = printed.split("\n\n")
    assert sum(len(re.findall(r"\b[cfi]\d+\b", line)) for line in matrix.splitlines()) == len(TABLE)
    named = {pair for line in legend.splitlines() for pair in re.findall(r"\w+–\w+", line)}
    assert named == {f"{a.__name__}–{b.__name__}" for a, b in TABLE}
    for rule in TABLE.values():
        assert rule.algorithm in legend


def test_table_marks_fit_their_rule() -> None:
    matrix = vs.matrix()
    names = {algorithm.mark: algorithm for algorithm in matrix.algorithms}
    for (a, b), rule in TABLE.items():
        mark = matrix.cells[matrix.rows.index(a.__name__)][matrix.columns.index(b.__name__)]
        assert mark.endswith(vs.EARLY) == (rule.meets is not None)
        assert names[mark.rstrip(vs.EARLY)].name == rule.algorithm
        assert mark[0] == rule.exactness[0]


def test_table_in_markdown(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["table", "--markdown"]) == 0
    blocks = [block.splitlines() for block in capsys.readouterr().out.split("\n\n") if block.startswith("|")]
    matrix, *others = blocks
    assert len(matrix) == 2 + len(PROBES) + len(SOLIDS)
    assert {row.count("|") for row in matrix} == {len(SOLIDS) + 2}
    assert sum(len(re.findall(r"\b[cfi]\d+\b", row)) for row in matrix) == len(TABLE)
    named = [row.split("|")[1].strip() for row in others[-1][2:]]
    assert named == [f"{a.__name__}–{b.__name__}" for a, b in TABLE]
    assert all(len({row.count("|") for row in block}) == 1 for block in blocks)


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"], ["run", "--help"], ["table", "--help"]])
def test_help_is_short(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(arguments) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "Usage: proxyproof" in printed.out
    assert len(printed.out.splitlines()) < 45


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("proxyproof ")


@pytest.mark.parametrize("command", ["--help", "table"])
def test_light_commands_import_nothing_heavy(command: str) -> None:
    program = (
        "import sys; from reports import cli; status = cli.main(sys.argv[1:]); "
        "heavy = {'hypothesis', 'jinja2', 'fcl', 'pybullet', 'oracles.campaign'} & set(sys.modules); "
        "sys.exit(status or bool(heavy) and str(heavy))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, command], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_output_that_knows_no_greek(encoding: str) -> None:
    command = [sys.executable, "-m", "reports.cli", "table"]
    environment = {"PYTHONIOENCODING": encoding, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_reader_that_goes_away_is_no_error() -> None:
    command = f"{sys.executable} -m reports.cli table | head -c 1"
    done = subprocess.run(["/bin/sh", "-c", command], capture_output=True, cwd=ROOT, check=False)
    assert done.stderr == b""
