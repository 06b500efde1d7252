"""The report's folder, and the check that it is complete."""

from __future__ import annotations

import json
import shutil
from importlib.resources import files
from typing import Any

import pytest

from oracles.outcome import FINDINGS, Kind
from oracles.scene import Scene
from reports import folder, verify
from tests.sample_run import sample_run

# -- the folder ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Any:
    place = tmp_path_factory.mktemp("report")
    folder.write(sample_run(), place)
    return place


@pytest.fixture
def report(written: Any, tmp_path: Any) -> Any:
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    return tmp_path


def test_report_json_is_plain_and_exact(written: Any) -> None:
    run = sample_run()
    data = json.loads((written / "report.json").read_text("utf-8"), parse_constant=pytest.fail)
    assert data["format"] == "proxyproof-report-1"
    counts = {(c["engine"], c["query"], c["pair"], c["regime"], Kind(c["verdict"])): c["count"] for c in data["counts"]}
    assert counts == dict(run.counts)
    assert len(data["support"]) == len(run.support)
    for told, its in zip(data["buckets"], run.buckets, strict=True):
        scene = Scene.from_json(told["scene"])
        assert scene.id == its.witness.scene.id == told["scene"]["id"]
        assert float(told["lower"]) == its.witness.verdict.lower
        script = (written / told["repro"]).read_text("utf-8")
        assert its.repro.partition("\n")[2] in script
        assert script.startswith("# ")
    assert data["buckets"][5]["answer"]["distance"] == "NaN"
    assert data["buckets"][5]["amount"] == "Infinity"


def test_old_scripts_go_and_foreign_files_stay(report: Any) -> None:
    foreign = report / "repro" / "mine.py"
    foreign.write_text("pass\n")
    run = sample_run()
    del run.buckets[1:]
    cell = run.buckets[0].engine, run.buckets[0].query, run.buckets[0].pair
    for key in [key for key in run.counts if key[4] in FINDINGS and key[:3] != cell]:
        del run.counts[key]
    folder.write(run, report)
    assert sorted(path.name for path in (report / "repro").iterdir()) == [
        "001-fcl-boolean-Sphere-Capsule-missed-contact.py",
        "mine.py",
    ]
    assert [path.name for path in (report / "issues").iterdir()] == ["001-fcl-boolean-Sphere-Capsule-missed-contact.md"]
    assert verify.completeness(report) == []


def test_tampered_list_of_old_scripts_removes_nothing_else(report: Any) -> None:
    foreign = report / "mine.py"
    foreign.write_text("pass\n")
    data = json.loads((report / "report.json").read_text("utf-8"))
    data["buckets"][0]["repro"] = "repro/../mine.py"
    (report / "report.json").write_text(json.dumps(data))
    folder.write(sample_run(), report)
    assert foreign.exists()


def test_folder_that_cannot_be_written_is_refused_in_one_line(tmp_path: Any) -> None:
    file = tmp_path / "file"
    file.write_text("")
    for place in (file, file / "below"):
        with pytest.raises(folder.FolderError, match="--out") as refused:
            folder.prepare(place)
        assert "\n" not in str(refused.value)


def test_templates_are_shipped() -> None:
    names = {path.name for path in files("reports").joinpath("templates").iterdir()}
    assert {"report.html.jinja", "macros.html.jinja", "report.css"} <= names


# -- completeness --------------------------------------------------------------------------------------------


def change(report: Any, alter: Any) -> None:
    data = json.loads((report / "report.json").read_text("utf-8"))
    alter(data)
    (report / "report.json").write_text(json.dumps(data), "utf-8")


def without_count(data: Any) -> None:
    data["counts"] = [
        c for c in data["counts"] if (c["engine"], c["pair"], c["regime"]) != ("fcl", "AABB–AABB", "deep")
    ]


def only_skipped(data: Any) -> None:
    for entry in data["counts"]:
        if (entry["pair"], entry["regime"]) == ("Ray–Box", "huge"):
            entry["verdict"] = "skipped"


def test_a_written_report_is_complete(report: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert verify.completeness(report) == []
    assert verify.main([str(report)]) == 0
    assert "complete" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("alter", "gap"),
    [
        (without_count, "nothing compared: fcl · distance · AABB–AABB in regime deep"),
        (only_skipped, "nothing compared: bullet · raycast · Ray–Box in regime huge"),
        (lambda data: data.update(interrupted=True), "interrupted"),
        (lambda data: data["problems"].append("a worker was lost"), "a worker was lost"),
        (lambda data: data.update(support=[]), "supports any cell"),
        (lambda data: data["buckets"][0]["scene"]["a"]["numbers"].pop(), "not a scene"),
        (lambda data: data["buckets"][0].update(lower="NaN"), "interval is missing"),
        (lambda data: data["buckets"][0].update(lower=1.0), "interval is empty"),
        (lambda data: data["buckets"][3].update(lower=10.0, upper=11.0), "certificate proves only"),
        (lambda data: data["buckets"][3].update(lower=0.0, upper=1e-3), "certificate proves only"),
        (lambda data: data["buckets"][0]["certificate"]["claims"].pop(), "certificate proves only"),
        (lambda data: data["buckets"][0]["certificate"]["claims"][0].update(kind="trust me"), "certificate is refused"),
        (lambda data: data["buckets"][0].update(certificate=None), "no certificate"),
        (lambda data: data["buckets"][0].update(answer={}), "engine's answer is missing"),
        (lambda data: data["buckets"][0].update(reference={}), "reference's answer is missing"),
        (lambda data: data["buckets"][0].update(claim=""), "what is wrong"),
        (lambda data: data["buckets"][0].update(count=99), "99 times"),
        (lambda data: data["counts"].append({**data["counts"][0], "verdict": "wrong", "count": 3}), "3 findings, but"),
        (lambda data: data["buckets"][0].update(repro="repro/none.py"), "is missing"),
        (lambda data: data["buckets"].append({**data["buckets"][0], "number": 99}), "lacks the buckets [99]"),
    ],
)
def test_gaps_in_the_data_are_found(report: Any, alter: Any, gap: str) -> None:
    change(report, alter)
    found = verify.completeness(report)
    assert any(gap in line for line in found)
    assert verify.main([str(report)]) == 1


def test_gaps_in_the_files_are_found(report: Any) -> None:
    page = (report / "index.html").read_text("utf-8")
    (report / "index.html").write_text(page[: len(page) // 2], "utf-8")
    (report / "report.md").unlink()
    next((report / "repro").glob("002-*")).write_text("print(")
    (report / "junit.xml").write_text("<testsuites>")
    log = json.loads((report / "report.sarif").read_text("utf-8"))
    log["runs"][0]["results"].pop()
    (report / "report.sarif").write_text(json.dumps(log))
    next((report / "issues").glob("003-*")).unlink()
    found = "\n".join(verify.completeness(report))
    for gap in (
        "index.html is empty or cut off",
        "cannot read report.md",
        "does not compile",
        "cannot read junit.xml",
        "report.sarif has other findings",
        "issues/003-bullet-raycast-Ray-Sphere-ray-hits-behind-the-surface.md is missing",
    ):
        assert gap in found


@pytest.mark.parametrize("content", [None, "no json", "[]", '{"format": "other"}', '{"format": "proxyproof-report-1"}'])
def test_no_report_is_no_complete_report(
    tmp_path: Any, content: str | None, capsys: pytest.CaptureFixture[str]
) -> None:
    if content is not None:
        (tmp_path / "report.json").write_text(content)
    assert verify.main([str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
