"""Ledgers and witnesses of strangers: each mistake is one clear line, and nothing is read that should not be."""

from __future__ import annotations

import json
import os
import pickle
from datetime import date
from pathlib import Path
from typing import Any

import pytest

from oracles.ledger import Entry, FirstSeen, Ledger, LedgerError, Witness
from oracles.ledger.reading import FIELDS, MOST_BYTES
from oracles.ledger.witness import LARGEST, load_witness, path_of, text_of
from oracles.ledger.writing import Changes, write
from oracles.outcome import Finding, Kind, Severity, Verdict
from oracles.scene import DISTANCE, Scene
from refimpl import Sphere
from refimpl.proof import certify, check
from reports import cli
from tests.wrong_engines import Honest, spec

HEAD = '[[entry]]\nengine = "e"\nname = "n"\ncause = "c"\n'

BAD = [
    ("[[entry", "is not TOML"),
    ("a = " + "[" * 100_000, "nested too deeply"),
    ("colour = 1", "unknown 'colour'; a ledger has engine, [[entry]] and [[retired]]"),
    ("engine = 3", "engine must be an engine's name, got 3"),
    ('engine = "../up"', "engine must be an engine's name"),
    ('engine = "refimpl"', "what speaks against the reference can never be listed"),
    ("entry = 3", "entry must be tables, each under [[entry]]"),
    ("[entry]\nname = 'n'", "entry must be tables, each under [[entry]]"),
    ("[[entry]]\ncause = 'c'", "entry 1: name is missing"),
    ("[[entry]]\nname = 'n'", "entry 1 ('n'): cause is missing"),
    ("[[entry]]\nname = 'n'\ncause = 'c'", "entry 1 ('n'): engine is missing, here and at the top of the file"),
    ("[[entry]]\nname = 'N M'\ncause = 'c'", "name must be small letters, digits and dashes"),
    (HEAD + HEAD, "two entries of e are named 'n'"),
    (HEAD + "colour = 'red'\nshape = 1", "unknown 'colour', 'shape'; known are engine, name, cause, query"),
    ('[[entry]]\nengine = "e"\nname = "n"\ncause = "  "', "cause must be a text"),
    ('[[entry]]\nengine = "e"\nname = "n"\ncause = "' + "x" * 5000 + '"', "cause is longer than 4000 characters"),
    (HEAD + "query = 3", "query must be a text"),
    (HEAD + "pair = ['*', 3]", "pair must be a text"),
    (HEAD + "query = ['distance', 'distnace']", "query 'distnace' fits no query; there are distance, contacts, "),
    (HEAD + f"pair = {['*'] * 65}", "pair has more than 64 items"),
    (HEAD + f"symptom = '{'*a' * 200}'", "symptom is longer than 200 characters"),
    (HEAD + "decades = 3", "decades must be the first and the last decade, as in [-3, 0], got 3"),
    (HEAD + "decades = [0, -3]", "decades must be the first and the last decade"),
    (HEAD + "decades = [-3.0, 0]", "decades must be the first and the last decade"),
    (HEAD + "at_most = '1'", "at_most must be a positive number, got '1'"),
    (HEAD + "within = true", "within must be a positive number, got True"),
    (HEAD + "within = nan", "within must be a positive number, got nan"),
    (HEAD + "larger_than = -1", "larger_than must be a positive number, got -1"),
    (HEAD + "versions = 'about 3'", "versions must be as in PEP 440, such as '>=1.2,<2', got 'about 3'"),
    (HEAD + "upstream = 'javascript:alert(1)'", "upstream must be a link with http or https"),
    (HEAD + "upstream = 'https://a b'", "upstream must be a link with http or https"),
    (HEAD + "witnesses = ['../../../etc/passwd']", "witnesses must be an id of 12 hexadecimal digits"),
    (HEAD + "witnesses = ['0123456789AB']", "witnesses must be an id of 12 hexadecimal digits"),
    (HEAD + "witnesses = ['0123456789ab']", "cannot be read: No such file or directory"),
    (HEAD + "first_seen = 2026-01-31", "first_seen must be { date = 2026-01-31, version = '1.0' }"),
    (HEAD + "first_seen = { date = 2026-01-31T00:00:00, version = '1' }", "first_seen.date must be a date"),
    (HEAD + "first_seen = { date = 2026-01-31, version = 1 }", "first_seen.version must be a text"),
    ("[[retired]]\nengine = 'e'", "retired 1: name is missing"),
    ("[[retired]]\nname = 'n'", "retired 1: engine is missing"),
    ("[[retired]]\nengine = 'e'\nname = 'n'\nwhy = 'x'", "retired 1: unknown 'why'; known are engine, name, since"),
    ("# " + "x" * MOST_BYTES, "is larger than 1000000 bytes"),
    ("[[retired]]\nengine = 'e'\nname = 'n'\n" * 2001, "more than 2000 tables [[retired]]"),
]


@pytest.mark.parametrize(("text", "said"), BAD, ids=[said[:60] for _, said in BAD])
def test_each_mistake_is_one_clear_line(
    text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "own.toml"
    path.write_text(text, "utf-8")
    assert cli.main(["run", "--engine", spec(Honest), "--ledger", str(path), "--out", str(tmp_path / "r")]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert printed.err.startswith("proxyproof: ")
    assert said in printed.err
    assert str(path.parent) in printed.err
    assert list(tmp_path.iterdir()) == [path]


def test_pairs_may_be_written_with_any_dash(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(HEAD + 'pair = ["Sphere-Box", "Ray—*", "*–KDOP", "sphere-size"]', "utf-8")
    (entry,) = Ledger.load([own], shipped=False).entries
    assert entry.pair == ("Sphere–Box", "Ray–*", "*–KDOP", "sphere-size")


def test_what_is_no_ordinary_file_is_not_read(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    missing, binary = tmp_path / "missing.toml", tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    for path, said in (
        (pipe, "is no ordinary file"),
        (tmp_path, "is no ordinary file"),
        (Path("/dev/zero"), "is no ordinary file"),
        (missing, "No such file"),
        (binary, "is not TOML"),
    ):
        with pytest.raises(LedgerError, match=said):
            Ledger.load([path])
    assert Ledger.load([missing], shipped=False, create=True).entries == ()


def test_the_same_name_in_two_files_is_refused(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / f"{name}.toml").write_text(HEAD, "utf-8")
    with pytest.raises(LedgerError, match=r"two.toml: e has an entry 'n' in .*one.toml, too"):
        Ledger.load([tmp_path / "one.toml", tmp_path / "two.toml"])


def test_an_update_that_cannot_be_written_is_refused_before_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "nowhere" / "own.toml"
    assert cli.main(["run", "--engine", spec(Honest), "--ledger", str(path), "--update-ledger"]) == 2
    assert "cannot be written: name a file of your own with --ledger FILE" in capsys.readouterr().err


def test_entries_in_brackets_cannot_be_edited(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('entry = [{engine = "e", name = "n", cause = "c"}]\n', "utf-8")
    found = Changes()
    found.of(path).remove.append(("e", "n"))
    with pytest.raises(LedgerError, match="each entry must stand under a line"):
        write(found)
    assert "cause" in path.read_text("utf-8")


# -- what is written reads back ------------------------------------------------------------------------------


def test_what_is_written_reads_back(tmp_path: Path) -> None:
    witness = a_witness()
    given = Entry(
        "e",
        "n",
        'A cause with "quotes", a \\ and σ, ' + "which is long, " * 20 + "and ends.",
        query=("distance",),
        pair=("Sphere–*", "*–Box"),
        symptom=("distance too *",),
        degeneracy=("touching", "near*"),
        regime=("tiny",),
        decades=(-9, -3),
        at_most=0.5,
        within=1e-3,
        thinner_than=2.0,
        larger_than=1e-300,
        smaller_than=1e300,
        slower_than=0.1,
        versions=">=1,<2",
        upstream=("https://example.org/1",),
        witnesses=(witness.id,),
        first_seen=FirstSeen(date(2026, 1, 31), "1.5"),
    )
    path = tmp_path / "own.toml"
    found = Changes()
    found.of(path).add.append(given)
    found.witnesses.append((tmp_path, witness))
    write(found)
    ledger = Ledger.load([path], shipped=False)
    (read,) = ledger.entries
    assert all(getattr(read, name) == getattr(given, name) for name in FIELDS)
    assert text_of(ledger.witnesses["e", witness.id]) == text_of(witness)
    assert pickle.loads(pickle.dumps(ledger)).entries == ledger.entries
    assert {p.name for p in tmp_path.rglob("*") if p.is_file()} == {"own.toml", f"{witness.id}.json"}


def a_witness() -> Witness:
    scene = Scene(DISTANCE, Sphere([0.1, 0.0, 0.0], 1.0), Sphere([1.0 / 3.0, 0.0, 3.0], 1.0), "generic", "here")
    certificate = certify(scene.a, scene.b)
    lower, upper = map(float, check(certificate, scene.a, scene.b))
    verdict = Verdict(Kind.WRONG, "distance too large", Severity.LARGE, 0.1, lower, upper, "so", certificate)
    said: dict[str, object] = {"distance": float("nan"), "on_a": [0.1, float("inf"), -float("inf")]}
    return Witness(Finding("e", scene, said, {"distance": lower}, verdict), "key", "1.5")


def test_a_witness_reads_back_with_its_proof(tmp_path: Path) -> None:
    witness = a_witness()
    path = path_of(tmp_path, "e", witness.id)
    path.parent.mkdir(parents=True)
    path.write_text(text_of(witness), "utf-8")
    read = load_witness(tmp_path, "e", witness.id)
    assert read.id == witness.id
    assert text_of(read) == text_of(witness)
    assert read.finding.verdict.certificate == witness.finding.verdict.certificate


HOSTILE: list[tuple[Any, str]] = [
    ("{", "is no witness"),
    ("[" * 100_000, "nested too deeply"),
    ("3", "its format is not proxyproof-witness-1"),
    ("1" * 10_000, "is no witness"),
    (" " * (LARGEST + 1), f"is larger than {LARGEST} bytes"),
    ({"format": "proxyproof-witness-2"}, "its format is not proxyproof-witness-1"),
    ({"key": 3}, "key and version must be texts"),
    ({"version": "x" * 1000}, "key and version must be texts of at most 200 characters"),
    ({"finding": None}, "is no witness"),
    ({"finding engine": "../../e"}, "is the witness"),
    ({"finding engine": 3}, "not a text"),
    ({"finding claim": "x" * 10_000}, "not a text of at most 2000 characters"),
    ({"finding kind": "fine"}, "is not a valid Kind"),
    ({"finding amount": "much"}, "is no witness"),
    ({"finding lower": 1.5}, "the certificate proves only"),
    ({"finding certificate": None}, "no certificate proves it wrong"),
    ({"finding certificate": {"claims": []}}, "is no witness"),
    ({"finding answer": []}, "is no witness"),
    ({"finding answer": {"distance": "x" * 100}}, "is no witness"),
    ({"finding scene": None}, "is no witness"),
    ({"finding proof_scene": 3}, "is no witness"),
    ({"radius": -1.0}, "is no witness"),
    ({"radius": 2.0}, "the certificate"),
    ({"radius": 1e400}, "is no witness"),
    ({"radius": [[1.0]]}, "is no witness"),
    ({"type": "os.system"}, "unknown type 'os.system'"),
]


@pytest.mark.parametrize(("change", "said"), HOSTILE, ids=[f"{str(change)[:30]}" for change, _ in HOSTILE])
def test_a_witness_that_is_none_is_refused(change: Any, said: str, tmp_path: Path) -> None:
    witness = a_witness()
    data = json.loads(text_of(witness))
    if isinstance(change, dict):
        for name, value in change.items():
            if name == "radius":
                data["finding"]["scene"]["a"]["numbers"][3] = value
            elif name == "type":
                data["finding"]["scene"]["a"]["type"] = value
            elif name.startswith("finding "):
                data["finding"][name.removeprefix("finding ")] = value
            else:
                data[name] = value
    path = path_of(tmp_path, "e", witness.id)
    path.parent.mkdir(parents=True)
    path.write_text(change if isinstance(change, str) else json.dumps(data), "utf-8")
    with pytest.raises(LedgerError) as caught:
        load_witness(tmp_path, "e", witness.id)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_names_that_lead_elsewhere_are_refused(tmp_path: Path) -> None:
    for engine, name in (("..", "0123456789ab"), ("a/b", "0123456789ab"), ("e", "../123456789"), ("", "0123456789ab")):
        with pytest.raises(LedgerError, match="no witness can be kept"):
            path_of(tmp_path, engine, name)
