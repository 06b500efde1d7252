"""Repro scripts, executed as strangers would: they show what the report says, and believe nobody.

Twenty seconds of processor time: each script is a process of its own, which starts another for its engine.
"""

from __future__ import annotations

import copy
import functools
import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oracles.answers import reference_for, said
from oracles.campaign import run_campaign
from oracles.engine import Engine
from oracles.engines import available_engines, load_engine
from oracles.judges import Judges
from oracles.ledger import Ledger
from oracles.ledger.files import SHIPPED
from oracles.ledger.witness import Witness, load_witness
from oracles.outcome import Finding, Kind, Related, Verdict
from oracles.relations import RELATIONS
from oracles.repro import script_of
from oracles.repro.facts import answers_of
from oracles.repro.literals import MANY, Name, Numbers, shortened
from oracles.scene import CONTACTS, DISTANCE, Scene
from refimpl import AABB, Sphere
from reports import folder, repros
from reports.repros import differences, run_script
from tests.wrong_engines import Crashing, Honest, OffByAThousandth, Raising

ROOT = Path(__file__).resolve().parents[1]
MISSING = [name for name, why in available_engines().items() if why]
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}")
TOUCHING = Scene(DISTANCE, Sphere([-1.0, 0.5, 0.0], 0.75), Sphere([1.0, 0.0, 0.25], 1.0), "generic")
LOST_SCENE = replace(TOUCHING, a=Sphere([1.0, 0.5, 0.0], 0.75))
"""The wrong engines are lost where the first coordinate of A is positive."""


@functools.cache
def engine_of(name: str) -> Engine:
    return load_engine(name)


def known_findings() -> dict[str, tuple[str, str]]:
    """A witness of the ledger for each engine and symptom."""
    found: dict[str, tuple[str, str]] = {}
    for path in sorted(SHIPPED.glob("witnesses/*/*.json")):
        told = json.loads(path.read_text("utf-8")).get("finding")
        if told is None:  # of a survey, or of a crowd
            continue
        found.setdefault(f"{told['engine']} {told['symptom']}", (told["engine"], path.stem))
    return found


KNOWN = known_findings()
QUICK = [name for name in KNOWN if not name.endswith("in time")]


@functools.cache
def known(name: str) -> Finding:
    """A witness, with the verdict that its answer has today."""
    engine, stem = KNOWN[name]
    kept = load_witness(SHIPPED, engine, stem)
    assert isinstance(kept, Witness)
    finding = kept.finding
    if finding.verdict.kind is not Kind.WRONG or not finding.answer:
        return finding
    verdict = Judges(engine_of(engine)).convict(finding.scene, answers_of(finding.answer))
    return replace(finding, verdict=verdict)


@functools.cache
def script(name: str) -> str:
    finding = known(name)
    return script_of(engine_of(finding.engine), finding)


def loaded(text: str) -> dict[str, Any]:
    """A script as a module that was imported, not run."""
    found: dict[str, Any] = {"__name__": "script", "__file__": "script.py"}
    exec(compile(text, "script", "exec"), found)
    return found


def lines_of(answer: Mapping[str, Any]) -> list[str]:
    return [f"{name} = {np.asarray(value).tolist()}" for name, value in answer.items()]


# -- wrong as recorded ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", QUICK)
def test_a_script_shows_what_the_report_says(name: str, tmp_path: Path) -> None:
    file = tmp_path / "script.py"
    file.write_text(script(name), "utf-8")
    ran = run_script(file)
    assert list(differences(known(name), ran)) == [], ran.printed


def test_an_engine_that_does_not_come_back_is_ended(tmp_path: Path) -> None:
    name = next(name for name in KNOWN if name.endswith("in time"))
    file = tmp_path / "script.py"
    text = script(name).replace('"--ask", 10, NAMES', '"--ask", 1, NAMES')
    assert text != script(name)
    file.write_text(text, "utf-8")
    ran = run_script(file)
    assert list(differences(known(name), ran)) == []
    assert "no answer within 1 seconds: its process was ended" in ran.printed


def test_every_script_of_a_fresh_run_shows_what_its_report_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = run_campaign(["fcl", "bullet"], budget=0.1, passes=1, pairs=["Point–Box"], seed=5, ledger=Ledger())
    assert len({bucket.engine for bucket in run.buckets}) == 2
    folder.write(run, tmp_path)
    assert repros.main([str(tmp_path)]) == 0, capsys.readouterr().out
    assert f"{len(run.buckets)} of {len(run.buckets)} scripts show" in capsys.readouterr().out
    few = tmp_path / "few"
    folder.write(replace(run, buckets=run.buckets[:4]), few)
    first = next((few / "repro").glob("001-*"))
    first.write_text("print('all is well')\n")
    assert repros.main([str(few), "--jobs", "2"]) == 1
    assert f"{first.name} ends with status 0: all is well" in capsys.readouterr().out


@pytest.mark.soak
def test_every_script_of_a_run_of_all_cells_shows_what_its_report_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Some six hundred scripts, ten minutes: ``pytest -m soak tests/test_repro_scripts.py``."""
    command = [sys.executable, "-m", "reports.cli", "run", "--budget", "20", "--out", str(tmp_path)]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert ran.returncode in (0, 1), ran.stderr
    assert repros.main([str(tmp_path), "--jobs", "2"]) == 0, capsys.readouterr().out


# -- right, missing, tampered with ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", QUICK)
def test_the_right_answer_is_right(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    finding = known(name)
    right = said(reference_for(finding.scene), 0)
    if (finding.engine, finding.scene.query) == ("fcl", CONTACTS) and "on_a" in right:  # it names one point, not two
        right["point"] = right["on_a"]
    assert loaded(script(name))["main"](lines_of(right)) == 0, capsys.readouterr().out
    assert "verdict: right" in capsys.readouterr().out


def changed(value: Any, path: tuple[Any, ...]) -> Iterator[Any]:
    """Copies of plain data that each lack an item of the list at some place."""
    at = value
    for key in path:
        at = at[key]
    for i in range(len(at)):
        new = copy.deepcopy(value)
        inner = new
        for key in path:
            inner = inner[key]
        del inner[i]
        yield new


@pytest.mark.parametrize("name", QUICK)
def test_a_certificate_that_is_tampered_with_does_not_hold(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    module = loaded(script(name))
    if "SIDES" not in module:  # velocities that break a law are not right
        right = dict(module["RIGHT"])
        module["RIGHT"]["velocity_a"] = [x + 1.0 for x in right["velocity_a"]]
        module["RIGHT"]["velocity_b"] = [x + 2.0 for x in right["velocity_b"]]
        tries = [None]
    else:
        sides = module["SIDES"]
        proofs = [(i, kind) for i, side in enumerate(sides) for kind in ("truth", "claim") if side[kind] is not None]
        tries = [new for i, kind in proofs for new in changed(sides, (i, kind, "claims"))]
        for i, kind in proofs:
            narrow = copy.deepcopy(sides)
            low, high = narrow[i][kind]["interval"]
            narrow[i][kind]["interval"] = [low + 1e-3 * max(1.0, abs(low)), high + 2e-3 * max(1.0, abs(low))]
            tries.append(narrow)
    refused = 0
    for new in tries:
        if new is not None:
            module["SIDES"] = new
        status = module["main"](lines_of(known(name).answer if new is None else {}) or ["hit = 1.0"])
        refused += status == 2
        assert ("the certificate does not hold" in capsys.readouterr().out) == (status == 2)
    assert refused >= len(tries) // 2
    assert refused > 0


def test_a_changed_digit_in_the_file_is_noticed(tmp_path: Path) -> None:
    text = script("fcl distance too small")
    file = tmp_path / "script.py"
    where = text.index('"n": [') + 6
    file.write_text(f"{text[:where]}5{text[where:]}" if text[where] != "-" else f"{text[:where]}{text[where + 1 :]}")
    ran = run_script(file)
    assert ran.status == 2
    assert ran.printed.startswith("the certificate does not hold: ")


def test_without_the_engine_one_line_says_so(tmp_path: Path) -> None:
    module = loaded(script("fcl distance too small"))
    assert module["missing"]([["no_such_engine", "pip install it"], ["math", ""]]) == (
        "not installed: no_such_engine (pip install it)"
    )
    file = tmp_path / "script.py"
    file.write_text(script("fcl distance too small").replace('["fcl", ', '["no_such_engine", '), "utf-8")
    ran = run_script(file)
    assert (ran.status, ran.printed) == (2, "not installed: no_such_engine (pip install python-fcl)\n")


MENDED = """
import types

DistanceRequest = Convex = BVHModel = lambda *_, **__: None
Sphere = Box = Capsule = CollisionObject = Transform = lambda *_: None


class DistanceResult:
    pass


def distance(a, b, request, result):
    import numpy as np

    result.min_distance = {distance!r}
    result.nearest_points = np.array({on_a!r}), np.array({on_b!r})
"""


def test_a_mended_engine_is_right(tmp_path: Path) -> None:
    finding = known("fcl distance too small")
    right = said(reference_for(finding.scene), 0)
    (tmp_path / "fcl.py").write_text(MENDED.format(**right), "utf-8")
    file = tmp_path / "script.py"
    file.write_text(script("fcl distance too small"), "utf-8")
    ran = run_script(file, variables={"PYTHONPATH": str(tmp_path)})
    assert ran.status == 0, ran.printed
    assert "verdict: right" in ran.printed
    assert "(not what it answered when this file was written)" in ran.printed


# -- engines of one's own ------------------------------------------------------------------------------------


def of_own(kind: type[Honest], scene: Scene, answer: dict[str, object], verdict: Verdict | None = None) -> str:
    engine = kind()
    given = verdict or Judges(engine).convict(scene, answers_of(answer))
    return script_of(engine, Finding(engine.name, scene, answer, {}, given))


def run_own(text: str, tmp_path: Path) -> repros.Ran:
    file = tmp_path / "script.py"
    file.write_text(text, "utf-8")
    return run_script(file, variables={"PYTHONPATH": str(ROOT)})


def answer_by(kind: type[Honest], scene: Scene) -> dict[str, object]:
    rows = [row.tolist() for row in scene.rows]
    table = np.array([kind().solver(scene.query, type(scene.a), type(scene.b))(*rows)])
    return said(type(answers_of({})).from_table(np.zeros(1, dtype=np.int8), table, {}), 0)


def test_an_engine_of_one_s_own_is_asked_by_its_module(tmp_path: Path) -> None:
    answer = answer_by(OffByAThousandth, TOUCHING)
    text = of_own(OffByAThousandth, TOUCHING, answer)
    assert '["tests", "the module of this engine: ' in text
    ran = run_own(text, tmp_path)
    assert ran.status == 1
    assert "honest answers" in ran.printed
    assert "verdict: WRONG: distance too" in ran.printed
    assert run_script(tmp_path / "script.py").printed.startswith("not installed: ")


def test_an_engine_in_a_file_of_its_own_is_found_in_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, file = tmp_path / "engine", tmp_path / "script.py"
    folder.mkdir()
    (folder / "nearly.py").write_text(NEARLY, "utf-8")
    engine = load_engine(f"{folder / 'nearly.py'}:Nearly")
    finding = Finding("nearly", TOUCHING, {}, {}, Verdict(Kind.CRASHED, "error raised"))
    file.write_text(script_of(engine, finding), "utf-8")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    for current, status, words in ((tmp_path, 2, "not installed: nearly ("), (folder, 1, "RuntimeError: not yet")):
        ran = subprocess.run([sys.executable, file], capture_output=True, text=True, cwd=current, check=False)
        assert (ran.returncode, words in ran.stdout) == (status, True), ran.stdout


NEARLY = """from tests.wrong_engines import Honest

class Nearly(Honest):
    def solver(self, *cell):
        raise RuntimeError("not yet")
"""


@pytest.mark.parametrize(
    ("kind", "words"), [(Crashing, "its process ended with signal"), (Raising, "it raised an error: ")]
)
def test_an_engine_that_is_lost_is_shown_as_lost(kind: type[Honest], words: str, tmp_path: Path) -> None:
    text = of_own(kind, LOST_SCENE, {}, Verdict(Kind.CRASHED, "process lost"))
    ran = run_own(text, tmp_path)
    assert ran.status == 1
    assert words in ran.printed
    assert "verdict: WRONG: there is no answer" in ran.printed


def test_contradictions_are_shown_by_both_calls(tmp_path: Path) -> None:
    engine, relation = Honest(), next(iter(RELATIONS))
    answers = [answer_by(Honest, TOUCHING), answer_by(OffByAThousandth, TOUCHING)]
    moved = replace(TOUCHING, b=AABB([0.5, 0.0, 0.0], [1.0, 1.0, 1.0]))
    answers[1] = answer_by(Honest, moved)
    verdict = Verdict(Kind.INCONSISTENT, "moving both changes the distance", None, 0.5, claim="two answers.")
    finding = Finding("honest", TOUCHING, answers[0], {}, verdict, related=Related(relation, moved, answers[1]))
    ran = run_own(script_of(engine, finding), tmp_path)
    assert ran.status == 1
    assert f"honest answers\n  distance = {answers[0]['distance']!r}" in ran.printed
    assert (
        f"after {RELATIONS[relation].changing}, honest answers\n  distance = {answers[1]['distance']!r}" in ran.printed
    )
    assert "verdict: WRONG: moving both changes the distance, by at least 0.5" in ran.printed


# -- text ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", KNOWN)
def test_scripts_are_plain_and_whole(name: str) -> None:
    text = script(name)
    assert "proxyproof" not in text.split("# ---- 2.")[0].partition('"""\n\nfrom __future__')[2]
    assert text.startswith("#!/usr/bin/env python3\n")
    module = loaded(text)
    assert repr(module["ANSWER"]) == repr(dict(known(name).answer))


def test_literals_read_back_to_the_bit() -> None:
    numbers = Numbers()
    value = {
        "short": [0.1, -0.0, 5e-324, 1.7976931348623157e308, 1, "p/q"],
        "words": 'with "quotes" and \\',
        "none": None,
        "long": [[float(i) / 7.0, -0.0] for i in range(MANY)],
        "wide": [{"x": [0.1] * 9, "y": Name("THERE")}] * 9,
        "ends": [float("inf"), -float("inf")],
    }
    text = numbers.text(value)
    names: dict[str, Any] = {"THERE": "there"}
    exec(
        "import base64, json, zlib, math\n"
        "def unpacked(text):\n    return json.loads(zlib.decompress(base64.b85decode(text)))\n" + numbers.definition(),
        names,
    )
    back = eval(text, names)
    assert json.dumps(back) == json.dumps({**value, "wide": [{"x": [0.1] * 9, "y": "there"}] * 9})
    assert "NUMBERS[0]" in text
    assert max(map(len, text.splitlines())) < 140


def test_what_an_engine_left_unset_may_change() -> None:
    verdict = Verdict(Kind.WRONG, "distance too large", None, 1.0)
    finding = Finding("fcl", TOUCHING, {"distance": 2.0, "on_b": [6.95e-310, 0.0, 0.0]}, {}, verdict)
    said_so = "verdict: WRONG: distance too large, by at least 1.0 (…)"
    assert list(differences(finding, repros.Ran(1, f"  distance = 2.0\n  on_b = [5e-310]\n{said_so}"))) == []
    assert list(differences(finding, repros.Ran(1, f"  distance = 3.0\n{said_so}"))) == [
        "does not show 'distance = 2.0'"
    ]


def test_names_and_words_of_strangers_stay_words(tmp_path: Path) -> None:
    class Stranger(OffByAThousandth):
        name = 'a"""b\\ \u202e{c}\n"); import os #'

        def repro(self, *_: object) -> str:
            return 'x = """two\nlines"""\nprint("distance =", len(x))\nprint("on_a = rubbish")\n'

    answer = answer_by(OffByAThousandth, TOUCHING)
    text = of_own(Stranger, TOUCHING, answer)
    assert "\u202e" not in text
    ran = run_own(text, tmp_path)
    assert ran.status == 1
    assert "  distance = 9.0\n" in ran.printed
    assert "  on_a = rubbish\n" in ran.printed


def test_long_lists_of_an_engine_s_call_are_packed() -> None:
    numbers = Numbers()
    call = f"π = {[0.1] * 200}  # é\nx = f({[[1, -2]] * 100}, [3, 4])\ny = [π, {[1.5] * 300}]\n"
    text = shortened(call, numbers)
    assert text == "π = NUMBERS[2]  # é\nx = f(NUMBERS[1], [3, 4])\ny = [π, NUMBERS[0]]\n"
    assert shortened("x = [1, 2]\n", numbers) == "x = [1, 2]\n"
