"""`show`, `check`, `replay` and `schema`: a report read again, whoever has written it."""

from __future__ import annotations

import copy
import dataclasses
import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from oracles.outcome import Run, Severity
from oracles.scene import DISTANCE, Scene
from refimpl import Sphere
from reports import cli, findings, reading, summary, text
from tests.sample_run import A_BOX, B_BOX, bucket, sample_run, wrong
from tests.test_report_hostile import NASTY, hostile_run
from tests.wrong_engines import Crashing, Honest, OffByAThousandth, spec


@pytest.fixture(autouse=True)
def elsewhere(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))


def written(run: Run, folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "report.json").write_text(summary.report_json(run), "utf-8")
    return folder


@pytest.fixture(scope="module")
def run() -> Run:
    return sample_run()


@pytest.fixture(scope="module")
def report(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(run, tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def data(report: Path) -> Any:
    return json.loads((report / "report.json").read_text("utf-8"))


def asked(*arguments: object) -> int:
    return cli.main([str(argument) for argument in arguments])


def one_line(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """What is said on bad input: one line."""
    assert asked(*arguments) == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err.count("\n")) == ("", 1)
    assert len(printed.err) < 1100
    return printed.err


# -- reading -------------------------------------------------------------------------------------------------


def test_what_is_read_is_what_was_written(run: Run, data: Any) -> None:
    read = reading.run_from_data(data)
    read.buckets = [reading.bucket_from_data(item) for item in data["buckets"]]
    for its, original in zip(read.buckets, run.buckets, strict=True):
        its.repro = original.repro
    assert json.loads(summary.report_json(read)) == data
    assert findings.bucket_views(read) == findings.bucket_views(run)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "there is no report in"),
        ("", "is not JSON"),
        ("no json", "is not JSON"),
        ("[]", "is not an object"),
        ("{}", "is not of the format"),
        ('{"format": NaN}', "NaN is no number"),
        ('{"a":' * 100_000, "is nested too deeply"),
        ('{"format": "proxyproof-report-1"}', "has no list of buckets"),
        ('{"format": "proxyproof-report-1", "buckets": [1]}', "has no list of buckets"),
        ('{"format": "proxyproof-report-1", "buckets": [{"id": "ab"}]}', "is damaged"),
        ("\xff", "is not JSON"),
    ],
)
def test_what_is_no_report_is_refused_in_one_line(
    tmp_path: Path, content: str | None, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    if content is not None:
        (tmp_path / "report.json").write_bytes(content.encode("latin-1"))
    assert said in one_line(capsys, "show", "ab", "--run", tmp_path)


def test_huge_file_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "report.json").write_text(" " * 2000)
    monkeypatch.setattr(reading, "LARGEST", 1999)
    with pytest.raises(reading.NoReport, match="larger than"):
        reading.read_report(tmp_path)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda its: its.pop("scene"),
        lambda its: its.update(kind="fine"),
        lambda its: its.update(count="many"),
        lambda its: its.update(regimes=[1]),
        lambda its: its.update(answer={"distance": {"a": 1}}),
        lambda its: its["scene"]["a"].update(type="Torus"),
        lambda its: its["scene"]["a"].update(numbers=[0.0, 0.0, 0.0, -1.0]),
        lambda its: its["scene"]["a"].update(numbers="1"),
        lambda its: its["certificate"]["claims"][0].update(kind="trust me"),
        lambda its: its.update(related=7),
        lambda its: its.update(lower="soon"),
    ],
)
def test_damaged_finding_is_named(data: Any, tmp_path: Path, spoil: Any, capsys: pytest.CaptureFixture[str]) -> None:
    spoiled = copy.deepcopy(data)
    spoil(spoiled["buckets"][0])
    (tmp_path / "report.json").write_text(json.dumps(spoiled))
    said = one_line(capsys, "show", 1, "--run", tmp_path)
    assert "bucket 1 (fcl · boolean · Sphere–Capsule" in said
    assert "is damaged" in said


def test_number_beyond_all_doubles_is_damage(data: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = json.dumps(data).replace('"decade": -1', '"decade": 1e400', 1)
    (tmp_path / "report.json").write_text(content)
    assert "is damaged" in one_line(capsys, "show", 1, "--run", tmp_path)


# -- show ----------------------------------------------------------------------------------------------------


def test_show_tells_a_finding_at_length(run: Run, report: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert asked("show", 4, "--run", report) == 0
    said = capsys.readouterr().out
    its, words = run.buckets[3], " ".join(said.split())
    assert said.startswith(f"4. {its.id}  NEW\n")
    for expected in (its.key, "0.21235", "Box(center=[0.1, -0.30000000000000004, 2.0]", "Planes with normal"):
        assert expected in words
    assert f"proxyproof replay {its.id} --run {report}" in said
    assert f"python {report}/repro/004-fcl-distance-Box-Box-distance-too-large.py\n" in said


@pytest.mark.parametrize("number", [1, 9])
def test_show_takes_numbers_ids_and_beginnings(
    run: Run, report: Path, number: int, capsys: pytest.CaptureFixture[str]
) -> None:
    name = run.buckets[number - 1].id
    said = []
    for which in (number, name, name.upper(), f"b-{name}", name[:8]):
        assert asked("show", which, "--run", report / "report.json") == 0
        said.append(capsys.readouterr().out)
    assert len(set(said)) == 1
    assert name in said[0]


def test_show_lists_all(run: Run, report: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert asked("show", "--run", report) == 0
    said = capsys.readouterr().out
    assert all(its.id in said and its.key[:30] in said for its in run.buckets)


def test_show_of_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(Run(0, 1.0, ""), tmp_path)
    assert asked("show", "--run", tmp_path) == 0
    assert capsys.readouterr().out == "no findings\n"
    assert "there are none" in one_line(capsys, "show", "1", "--run", tmp_path)


def test_unknown_and_ambiguous_names_are_told(run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    two = dataclasses.replace(run, buckets=run.buckets[:2])
    folder = written(two, tmp_path)
    data = json.loads((folder / "report.json").read_text("utf-8"))
    for item, name in zip(data["buckets"], ("abc000000000", "abc111111111"), strict=True):
        item["id"] = name
    (folder / "report.json").write_text(json.dumps(data))
    assert "begins the ids of several findings: 1 (abc000000000), 2 (abc111111111)" in one_line(
        capsys, "show", "abc", "--run", folder
    )
    assert asked("show", "abc1", "--run", folder) == 0
    capsys.readouterr()
    for which in ("", "zz", "3", "-"):
        assert "no finding has the number or id" in one_line(capsys, "show", which, "--run", folder)


def test_show_of_hostile_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = written(hostile_run(NASTY), tmp_path)
    data = json.loads((folder / "report.json").read_text("utf-8"))
    for item in data["buckets"]:
        item.update(id=NASTY, key=NASTY, repro=f"repro/{NASTY}", answer={NASTY: 1.0}, reference={NASTY: 1.0})
    (folder / "report.json").write_text(json.dumps(data))
    for arguments in (("show",), ("show", 1)):
        assert asked(*arguments, "--run", folder) == 0
        said = capsys.readouterr().out
        assert text.block(said, 10**9).split() == said.split()


# -- check ---------------------------------------------------------------------------------------------------


def saved(data: Any, tmp_path: Path) -> Path:
    path = tmp_path / "file.json"
    path.write_text(json.dumps(data))
    return path


def test_check_says_what_is_proven(data: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert asked("check", saved(data["buckets"][3], tmp_path)) == 0
    said = " ".join(capsys.readouterr().out.split())
    bounds = findings.interval(
        Scene(DISTANCE, A_BOX, B_BOX, ""), data["buckets"][3]["lower"], data["buckets"][3]["upper"]
    )
    assert f"proven: {bounds}" in said
    assert "Planes with normal" in said


def test_check_of_a_certificate_alone(data: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    alone = {name: data["buckets"][0][name] for name in ("scene", "certificate")}
    assert asked("check", saved(alone, tmp_path)) == 0
    assert "proven: σ = -0.75 (signed distance, exactly)" in capsys.readouterr().out


def test_check_of_a_witness_of_the_ledger(capsys: pytest.CaptureFixture[str]) -> None:
    folder = files("oracles").joinpath("known/witnesses/fcl")
    path = sorted(Path(str(folder)).iterdir())[0]
    assert asked("check", path) == 0
    assert "proven: " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (lambda its: its.update(lower=0.0, upper=1e-3), "the certificate proves only"),
        (lambda its: its["certificate"]["claims"].pop(), "the certificate proves only"),
        (lambda its: its["scene"]["a"]["numbers"].__setitem__(0, 5.0), "certificate"),
        (lambda its: its.update(certificate=None), "no certificate proves it wrong"),
        (lambda its: its["certificate"].update(claims=[{"kind": "trust me"}]), "it is damaged"),
        (lambda its: its["scene"]["a"].update(type="Torus"), "it is damaged"),
        (lambda its: its.update(lower=[]), "it is damaged"),
    ],
)
def test_check_refuses(data: Any, tmp_path: Path, spoil: Any, fault: str, capsys: pytest.CaptureFixture[str]) -> None:
    spoiled = copy.deepcopy(data)
    spoil(spoiled["buckets"][3])
    assert asked("check", saved(spoiled["buckets"][3], tmp_path)) == 1
    said = capsys.readouterr().out
    assert "not proven: " in said
    assert fault in " ".join(said.split())
    assert asked("check", saved(spoiled, tmp_path)) == 1
    assert "; 1 not proven" in capsys.readouterr().out


def test_check_of_a_report(report: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for place in (report, report / "report.json"):
        assert asked("check", place) == 0
        said = "10 findings: 7 certificates proven in exact arithmetic; 3 without, as no answer came\n"
        assert capsys.readouterr().out == said


@pytest.mark.parametrize("content", ["{}", '{"scene": 1}', '{"finding": 1}', '{"buckets": 1}', "[", "1"])
def test_check_of_something_else(tmp_path: Path, content: str, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file.json").write_text(content)
    one_line(capsys, "check", tmp_path / "file.json")


def test_check_of_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "there is no file" in one_line(capsys, "check", tmp_path / "none.json")
    assert "there is no file" in one_line(capsys, "check", tmp_path)
    assert "must name a file" in one_line(capsys, "check", "")


# -- replay --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def balls(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report on two balls, and on two boxes that the small engines do not answer."""
    run = sample_run()
    scene = Scene(DISTANCE, Sphere([1.0, 0.0, 0.0], 1.0), Sphere([4.0, 0.0, 0.0], 1.0), "generic")
    both = (scene, Scene(DISTANCE, A_BOX, B_BOX, "generic"))
    verdicts = [wrong(its, "distance too large", Severity.LARGE, 1e-3) for its in both]
    run.buckets = [
        bucket("own", its, verdict, {"generic": 1}, answer={"distance": 1.001}, reference={"distance": 1.0})
        for its, verdict in zip(both, verdicts, strict=True)
    ]
    return written(run, tmp_path_factory.mktemp("balls"))


@pytest.mark.parametrize(
    ("engine", "status", "words"),
    [
        (Honest, 0, "not wrong: agrees"),
        (OffByAThousandth, 1, "still wrong: "),
        (Crashing, 1, "still wrong: "),
    ],
)
def test_replay_asks_again(
    balls: Path, engine: Any, status: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert asked("replay", 1, "--run", balls, "--engine", spec(engine)) == status
    said = capsys.readouterr().out
    assert words in said
    assert "in the report" in said
    assert ("1.001" in said.split("now")[1]) is True


def test_replay_of_what_cannot_be_asked(balls: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "name it again with --engine" in one_line(capsys, "replay", 1, "--run", balls)
    assert "honest does not answer this distance of Box–Box" in one_line(
        capsys, "replay", 2, "--run", balls, "--engine", spec(Honest)
    )
    assert "no engine 'none'" in one_line(capsys, "replay", 1, "--run", balls, "--engine", "none")
    assert "--call-limit" in one_line(capsys, "replay", 1, "--run", balls, "--call-limit", "0")
    assert "there is no report" in one_line(capsys, "replay", 1)


# -- schema --------------------------------------------------------------------------------------------------


def test_schema_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert asked("schema") == 0
    assert capsys.readouterr().out == summary.schema()
