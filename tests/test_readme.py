"""The README does what it says: its code runs, its table is fresh, CI runs its test line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from oracles.adapters import require_sound
from oracles.engine import Answers, faults
from oracles.engines import load_engine
from oracles.judges import Judges
from oracles.outcome import Kind
from oracles.scene import BOOLEAN, DISTANCE, Scene
from refimpl import Sphere
from reports import cli

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text("utf-8")


def test_the_pair_table_is_fresh(capsys: pytest.CaptureFixture[str]) -> None:
    cli.main(["table", "--markdown"])
    shown = re.search(r"<!-- pair table: .*? -->\n(.*?)<!-- end of pair table -->", README, re.DOTALL)
    assert shown
    assert shown[1].strip() == capsys.readouterr().out.strip(), "stale: paste what `proxyproof table --markdown` prints"


def test_the_example_runs_and_says_the_truth() -> None:
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert code
    space: dict[str, object] = {}
    for statement in code[1].splitlines():
        said = re.search(r"^(refimpl\.(?:intersect|distance)|check|respond)\(.*?  # (\S+)", statement)
        if not said:
            exec(statement, space)
            continue
        value = eval(statement, space)
        if said[2] == "False":
            assert not value
        elif said[2] in ("0.5,", "1.0"):
            assert value == float(said[2].strip(","))
        elif said[1] == "respond":
            assert value.tolist() == [1, 0, 2]
        elif said[2] == "(100000,)":
            assert value == (100_000,)
        else:
            assert value[0] == value[1] == np.float64(0.5)


def test_the_adapter_to_start_from_is_sound_and_right(tmp_path: Path) -> None:
    text = (ROOT / "oracles" / "engines" / "README.md").read_text("utf-8")
    code = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    assert code
    (tmp_path / "mine.py").write_text(code[1], "utf-8")
    engine = load_engine(f"{tmp_path / 'mine.py'}:Mine")
    require_sound(engine)
    a, b = Sphere([1, 2, 3], 0.5), Sphere([1, 6, 6], 1.5)
    for query in (DISTANCE, BOOLEAN):
        row = np.array([engine.solver(query, Sphere, Sphere)(a.pack().tolist(), b.pack().tolist())])
        assert faults(query, engine.says(query, Sphere, Sphere), row) == {}
        answers = Answers.from_table(np.zeros(1, dtype=np.int8), row, {})
        assert Judges(engine).convict(Scene(query, a, b, "generic"), answers).kind is Kind.AGREES


def test_ci_runs_the_test_line() -> None:
    line = re.search(r"<!-- test line -->\n```sh\n(.*?)\n```", README)
    assert line
    assert "pytest" in line[1]
    script = (ROOT / ".ci" / "run").read_text("utf-8")
    assert "<!-- test line -->" in script
    assert re.search(r"proxyproof run .*--out", script)


def test_every_file_that_the_readme_names_is_there() -> None:
    for name in re.findall(r"\(([\w/.]+\.png)\)|`((?:refimpl|oracles)/[\w/.]*)`", README):
        path = ROOT / (name[0] or name[1])
        assert path.exists(), path
