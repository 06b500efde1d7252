"""The ledger over the life of a fault: found, listed, expected, changed, mended, taken out; and on other versions."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from oracles.fault import BROAD_PHASE
from oracles.ledger import Entry, Ledger, Witness
from oracles.ledger.files import SHIPPED
from oracles.ledger.update import UNEXPLAINED, changes
from oracles.ledger.writing import described, write
from oracles.outcome import Kind, Run, State
from oracles.records import unproven
from reports import cli
from tests.wrong_engines import Switched, spec

PAIR = "Sphere–Sphere"


@pytest.fixture
def fault(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Switch the engine's fault, and its version."""

    def switch(fault: str = "", version: str = "1.0") -> None:
        monkeypatch.setenv("SWITCHED_FAULT", fault)
        monkeypatch.setenv("SWITCHED_VERSION", version)

    switch()
    return switch


@pytest.fixture
def own(tmp_path: Path) -> Path:
    return tmp_path / "own.toml"


@pytest.fixture(scope="module")
def updated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a ledger to which a run has added the fault of a thousandth."""
    folder = tmp_path_factory.mktemp("updated")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SWITCHED_FAULT", "1e-3")
        patch.setenv("SWITCHED_VERSION", "1.0")
        assert proxyproof(folder, "--ledger", str(folder / "own.toml"), "--update-ledger")[0] == 0
    return folder


def lists_the_fault(ledger: Path, updated: Path) -> None:
    """Make a ledger in which the fault of a thousandth stands, with its witnesses beside it."""
    shutil.copytree(updated / "witnesses", ledger.parent / "witnesses")
    shutil.copy(updated / "own.toml", ledger)


def proxyproof(tmp_path: Path, *more: str, pair: str = PAIR) -> tuple[int, dict[str, Any]]:
    """Run the command line on the switched engine; gives the exit status and what stands in `report.json`."""
    out = tmp_path / "report"
    run = ["run", "--engine", spec(Switched), "--pair", pair, "--passes", "1", "--workers", "0", "--out", str(out)]
    status = cli.main([*run, *more])
    return status, json.loads((out / "report.json").read_text("utf-8"))


def entries(path: Path) -> list[dict[str, Any]]:
    return list(tomllib.loads(path.read_text("utf-8")).get("entry", [])) if path.exists() else []


def states(data: dict[str, Any]) -> set[str]:
    return {note["state"] for note in data["ledger"]}


def added(printed: str) -> list[dict[str, Any]]:
    """Entries of the text to add that a run has printed."""
    text = printed.partition("# add to ")[2].partition("\n")[2].partition("\nwritten:")[0]
    return list(tomllib.loads(text)["entry"])


def test_the_life_of_a_fault(fault: Any, own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ledger = ("--ledger", str(own))
    own.write_text("# what we know of our engine\n", "utf-8")

    status, data = proxyproof(tmp_path, *ledger)
    assert (status, data["buckets"], data["ledger"]) == (0, [], [])

    fault("1e-3")
    capsys.readouterr()
    status, data = proxyproof(tmp_path, *ledger)
    assert status == 1
    assert {bucket["state"] for bucket in data["buckets"]} == {"NEW"}
    printed = added(capsys.readouterr().out)
    assert len(data["buckets"]) >= len(printed) > 1
    assert {(e["query"], e["pair"], e["symptom"]) for e in printed} == {
        (b["query"], b["pair"], b["symptom"]) for b in data["buckets"]
    }

    status, data = proxyproof(tmp_path, *ledger, "--update-ledger")
    assert status == 0
    written = entries(own)
    assert written == printed
    assert own.read_text("utf-8").startswith("# what we know of our engine\n")
    for entry in written:
        assert entry["engine"] == "switched"
        assert entry["cause"].startswith(UNEXPLAINED)
        assert entry["versions"] == ">=1.0"
        assert entry["first_seen"]["version"] == "1.0"
        for name in entry["witnesses"]:
            assert (tmp_path / "witnesses" / "switched" / f"{name}.json").is_file()

    capsys.readouterr()
    status, data = proxyproof(tmp_path, *ledger)
    assert status == 0
    assert "is not what this run found" not in capsys.readouterr().out
    assert {bucket["state"] for bucket in data["buckets"]} == states(data) == {"expected"}
    assert all(note["seen"] and note["holding"] for note in data["ledger"])
    assert data["hunters"]["replay"] == sum(len(entry["witnesses"]) for entry in written)

    fault("")
    status, data = proxyproof(tmp_path, *ledger)
    assert status == 1
    assert states(data) == {"STALE"}
    text = capsys.readouterr().out
    for entry in written:
        assert f"STALE: switched · {entry['name']}" in text
    gone = text.partition("# take out of ")[2].partition("\n")[2]
    assert tomllib.loads(gone)["entry"] == written
    assert all(block.rstrip() in own.read_text("utf-8") for block in gone.split("[[entry]]")), "not the exact text"

    assert proxyproof(tmp_path, *ledger, "--update-ledger")[0] == 0
    assert entries(own) == []
    assert own.read_text("utf-8").startswith("# what we know of our engine\n")
    assert list((tmp_path / "witnesses" / "switched").iterdir()) == []
    status, data = proxyproof(tmp_path, *ledger)
    assert (status, data["ledger"]) == (0, [])


def test_a_fault_that_changes(fault: Any, own: Path, updated: Path, tmp_path: Path) -> None:
    ledger = ("--ledger", str(own))
    lists_the_fault(own, updated)
    old = entries(own)
    own.write_text(own.read_text("utf-8").replace(UNEXPLAINED, "Someone understood it."), "utf-8")

    fault("flipped")
    status, data = proxyproof(tmp_path, *ledger)
    assert status == 1
    assert states(data) == {"CHANGED"}
    assert "beyond what the entry says" in data["ledger"][0]["why"]

    assert proxyproof(tmp_path, *ledger, "--update-ledger")[0] == 0
    new = entries(own)
    assert {entry["name"] for entry in new}.isdisjoint(entry["name"] for entry in old)
    assert any(entry["cause"].startswith("Someone understood it.") for entry in new), "the history is lost"
    status, data = proxyproof(tmp_path, *ledger)
    assert (status, states(data)) == (0, {"expected"})


def test_a_fault_that_moves_to_other_scenes(fault: Any, own: Path, tmp_path: Path) -> None:
    """Its witnesses pass, but the entry still explains what is found: it gets witnesses that show it."""
    ledger = ("--ledger", str(own))
    fault("1e-3@left")
    assert proxyproof(tmp_path, *ledger, "--update-ledger")[0] == 0
    text = own.read_text("utf-8")
    own.write_text("".join(line for line in text.splitlines(keepends=True) if "decades" not in line), "utf-8")
    before = entries(own)

    fault("1e-3@right")
    status, data = proxyproof(tmp_path, *ledger)
    assert status == 1
    assert states(data) == {"CHANGED"}
    assert "but other findings have its cause" in data["ledger"][0]["why"]
    assert proxyproof(tmp_path, *ledger, "--update-ledger")[0] == 0
    after = entries(own)
    assert [entry["name"] for entry in after] == [entry["name"] for entry in before], "the order is lost"
    assert all(set(a["witnesses"]).isdisjoint(b["witnesses"]) for a, b in zip(after, before, strict=True))
    status, data = proxyproof(tmp_path, *ledger)
    assert (status, states(data)) == (0, {"expected"})


def test_other_versions_and_other_cells_are_unmatched(fault: Any, own: Path, updated: Path, tmp_path: Path) -> None:
    ledger = ("--ledger", str(own))
    lists_the_fault(own, updated)
    own.write_text(own.read_text("utf-8").replace('versions = ">=1.0"', 'versions = ">=1.0,<2"'), "utf-8")

    fault("", version="2.1")
    status, data = proxyproof(tmp_path, *ledger)
    assert (status, states(data)) == (0, {"UNMATCHED"})
    assert data["ledger"][0]["why"] == "it is about versions >=1.0,<2, not 2.1"
    assert data["hunters"].get("replay", 0) == 0

    fault("1e-3", version="2.1")
    status, data = proxyproof(tmp_path, *ledger)
    assert status == 1
    assert {bucket["state"] for bucket in data["buckets"]} == {"NEW"}

    fault("", version="1.1")
    status, data = proxyproof(tmp_path, *ledger, pair="Point–Sphere")
    assert (status, states(data)) == (0, {"UNMATCHED"})
    assert {note["why"] for note in data["ledger"]} == {"none of its cells was asked"}


def test_an_entry_without_witness_that_nothing_fits_is_unmatched(fault: Any, own: Path, tmp_path: Path) -> None:
    own.write_text('[[entry]]\nengine = "switched"\nname = "by-hand"\ncause = "Heard of."\n', "utf-8")
    status, data = proxyproof(tmp_path, "--ledger", str(own))
    assert (status, states(data)) == (0, {"UNMATCHED"})
    assert data["ledger"][0]["why"] == "it has no witness, and no finding fits it"
    fault("1e-3")
    status, data = proxyproof(tmp_path, "--ledger", str(own))
    assert (status, states(data)) == (0, {"expected"})
    assert {bucket["entry"] for bucket in data["buckets"]} == {"by-hand"}
    assert proxyproof(tmp_path, "--ledger", str(own), "--update-ledger")[0] == 0
    (entry,) = entries(own)
    assert entry["witnesses"], "an update gives witnesses to an entry that has none"
    assert entry["cause"] == "Heard of."
    fault("")
    status, data = proxyproof(tmp_path, "--ledger", str(own))
    assert (status, states(data)) == (1, {"STALE"})


def test_engines_that_are_lost_are_witnesses_too(fault: Any, own: Path, tmp_path: Path) -> None:
    fault("lost")
    assert proxyproof(tmp_path, "--ledger", str(own), "--update-ledger")[0] == 0
    status, data = proxyproof(tmp_path, "--ledger", str(own))
    assert (status, states(data)) == (0, {"expected"}), [(b["key"], b["state"]) for b in data["buckets"]]
    assert {bucket["symptom"] for bucket in data["buckets"]} == {"process lost"}


def test_a_second_ledger_is_read_and_the_last_is_written(fault: Any, own: Path, updated: Path, tmp_path: Path) -> None:
    other = tmp_path / "other" / "more.toml"
    other.parent.mkdir()
    lists_the_fault(own, updated)
    fault("flipped")
    assert proxyproof(tmp_path, "--ledger", str(own), "--ledger", str(other), "--update-ledger")[0] == 0
    assert entries(own) == []
    assert entries(other)
    assert {path.stem for path in (tmp_path / "other" / "witnesses" / "switched").iterdir()} == {
        name for entry in entries(other) for name in entry["witnesses"]
    }
    assert proxyproof(tmp_path, "--ledger", str(own), "--ledger", str(other))[0] == 0


def test_entries_of_a_list_that_is_not_ours_are_retired(fault: Any, own: Path, updated: Path, tmp_path: Path) -> None:
    """What a package ships cannot be edited: the user's file says that it is over."""
    shipped = tmp_path / "shipped" / "switched.toml"
    shipped.parent.mkdir()
    lists_the_fault(shipped, updated)
    run = _run(Ledger.load([shipped], shipped=False))
    assert {note.state for note in run.ledger} == {State.STALE}
    theirs = Ledger.load([shipped], shipped=False)
    ledger = Ledger(theirs.entries, theirs.witnesses, own=(own,))
    wanted = changes(run, ledger)
    write(wanted)
    assert "[[retired]]" in described(wanted)
    assert {(r["engine"], r["name"]) for r in tomllib.loads(own.read_text("utf-8"))["retired"]} == {
        entry.key for entry in ledger.entries
    }
    retiring, left = (Ledger.load(files, shipped=False) for files in ([own], [shipped]))
    assert retiring.entries == ()
    assert left.entries


def _run(ledger: Ledger) -> Run:
    from oracles.campaign import run_campaign  # noqa: PLC0415  as the command line does

    return run_campaign([spec(Switched)], budget=1.0, passes=1, seed=0, pairs=[PAIR], ledger=ledger)


# -- the reference -------------------------------------------------------------------------------------------


def test_what_speaks_against_the_reference_is_never_listed(
    fault: Any, own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import oracles.audit  # noqa: PLC0415  to be patched

    true = oracles.audit.distance

    def off(a: Any, b: Any) -> Any:
        found = true(a, b)
        return type(found)(found.distance + 1e-9, found.on_a, found.on_b, found.normal)

    monkeypatch.setattr(oracles.audit, "distance", off)
    own.write_text('[[entry]]\nengine = "switched"\nname = "all"\ncause = "All."\n', "utf-8")
    for more in ((), ("--update-ledger",)):
        status, data = proxyproof(tmp_path, "--ledger", str(own), *more)
        assert status == 3
        assert data["buckets"][0]["kind"] == Kind.REFERENCE_WRONG
        assert data["buckets"][0]["state"] == "NEW"
        assert data["buckets"][0]["entry"] is None
    assert [entry["name"] for entry in entries(own)] == ["all"]
    assert not (tmp_path / "witnesses").exists()


def test_no_entry_can_be_about_the_reference(own: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own.write_text('[[entry]]\nengine = "refimpl"\nname = "all"\ncause = "All."\n', "utf-8")
    assert cli.main(["run", "--engine", spec(Switched), "--ledger", str(own)]) == 2
    assert "what speaks against the reference can never be listed" in capsys.readouterr().err


# -- the shipped ledger --------------------------------------------------------------------------------------


SHIPPED_LEDGER = Ledger.load()


@pytest.mark.parametrize("entry", SHIPPED_LEDGER.entries, ids=lambda entry: "-".join(entry.key))
def test_every_shipped_entry_says_what_goes_wrong_where(entry: Entry) -> None:
    assert not entry.cause.startswith(UNEXPLAINED)
    assert "various" not in entry.cause.lower()
    assert "not understood" not in entry.cause.lower()
    assert len(entry.cause) > 80
    assert entry.versions
    assert entry.first_seen is not None
    assert entry.witnesses


OF_SCENES = [  # of surveys and crowds see test_ledger_studies.py
    (entry.engine, name)
    for entry in SHIPPED_LEDGER.entries
    for name in entry.witnesses
    if not entry.query[0].startswith(("survey", BROAD_PHASE))
]


@pytest.mark.parametrize("key", OF_SCENES, ids="-".join)
def test_every_shipped_witness_carries_what_convicts_the_engine(key: tuple[str, str]) -> None:
    kept = SHIPPED_LEDGER.witnesses[key]
    assert isinstance(kept, Witness)
    finding = kept.finding
    assert finding.verdict.certificate is not None
    assert unproven(finding.verdict, finding.scene) == ""
    (entry,) = [e for e in SHIPPED_LEDGER.entries if e.engine == key[0] and key[1] in e.witnesses]
    assert SHIPPED_LEDGER.match(key[0], finding.scene, finding.verdict) == entry


def test_no_witness_lies_about_that_no_entry_lists() -> None:
    files = {(path.parent.name, path.stem) for path in (SHIPPED / "witnesses").glob("*/*.json")}
    assert files == set(SHIPPED_LEDGER.witnesses)
