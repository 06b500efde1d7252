"""A campaign goes on whatever happens to the processes of its engines, and says what happened."""

from __future__ import annotations

import os
import re
import secrets
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from oracles import claims
from oracles.campaign import run_campaign
from oracles.isolation.processes import children, marked
from oracles.ledger import Ledger
from oracles.outcome import ANSWERED, FINDINGS, Run
from oracles.scene import CONTACTS, DISTANCE
from tests import ill_mannered_engines as ill_mannered
from tests.test_survival import eventually
from tests.wrong_engines import Honest, spec

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the limits of memory and processes read /proc")

ROOT = Path(__file__).parents[1]


@pytest.fixture(autouse=True)
def mark(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """All that a test starts has this in its environment, and is gone after it."""
    value = secrets.token_hex(8)
    monkeypatch.setenv("PROXYPROOF_TEST", value)
    yield f"PROXYPROOF_TEST={value}"
    assert eventually(lambda: not marked(f"PROXYPROOF_TEST={value}")), "processes are left"


def campaign(engine: type[Honest]) -> Run:
    return run_campaign(
        [spec(engine)], budget=0.0, passes=1, seed=3, pairs=["Sphere–Sphere"], call_limit=0.3, ledger=Ledger()
    )


def test_a_campaign_whose_guards_are_killed_completes_and_says_so(mark: str) -> None:
    whole, over, killed = campaign(ill_mannered.Unhurried), threading.Event(), []

    def kill() -> None:
        while len(killed) < 2 and not over.wait(0.05):
            guards = [p for p in children(os.getpid()) if p in marked(mark) and any(map(children, children(p)))]
            for guard in guards:
                os.kill(guard, signal.SIGKILL)
            killed.extend(guards)

    thread = threading.Thread(target=kill)
    thread.start()
    run = campaign(ill_mannered.Unhurried)
    over.set()
    thread.join()
    assert killed
    assert run.problems == []
    assert run.counts == whole.counts
    assert run.digest == whole.digest
    told = [text for text in run.incidents if "SIGKILL (Killed), and was started again" in text]
    assert told
    assert all(text.startswith("unhurried: the guard of the engine's process was ended by SIGKILL") for text in told)


@pytest.mark.parametrize(
    ("engine", "told"),
    [
        (ill_mannered.ChangesRounding, "changes-rounding: left changed: the rounding of numbers (upward)"),
        (ill_mannered.LeavesChildren, "leaves-children: left 1 process running"),
        (ill_mannered.LeavesAnError, "leaves-an-error: left changed: numpy's error state"),
    ],
)
def test_a_right_engine_with_bad_manners_has_no_finding_and_is_named(engine: type[Honest], told: str) -> None:
    run = campaign(engine)
    assert run.buckets == []
    assert run.total(engine=engine.name, kinds=FINDINGS) == 0
    assert run.total(engine=engine.name, kinds=ANSWERED) > 0
    assert any(text.startswith(told) for text in run.incidents)


def test_rubbish_of_many_kinds_is_found_and_named() -> None:
    run = campaign(ill_mannered.Rubbish)
    assert {b.symptom for b in run.buckets} == {claims.NOT_A_NUMBER}
    assert all(len(b.witness.text) < 700 for b in run.buckets)
    assert run.problems == []


def test_what_an_adapter_says_of_itself_is_checked_whenever_it_is_used() -> None:
    run = campaign(ill_mannered.RaisesOnEffective)
    assert run.problems[0].startswith(
        "raises-on-effective cannot be judged: RaisesOnEffective.effective, asked about contacts Sphere–Sphere, raised"
    )
    assert run.total(engine="raises-on-effective", query=CONTACTS) == 0
    assert {(b.query, b.symptom) for b in run.buckets} == {(DISTANCE, claims.LONG)}
    run = campaign(ill_mannered.RubbishEffective)
    text = "\n".join(run.problems)
    assert "contacts Sphere–Sphere, must give margins of at least 0, got -1.0" in text
    assert re.search(r"distance Sphere–Sphere, must give \d+ rows as doubles, got array", text)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_campaign_in_a_call_that_does_not_return_ends_in_seconds(number: signal.Signals, tmp_path: Path) -> None:
    ready = tmp_path / "asleep"
    command = [
        sys.executable,
        "-m",
        "reports.cli",
        "run",
        "--engine",
        spec(ill_mannered.Sleeper),
        "--pair",
        "Sphere-Sphere",
    ]
    command += ["--budget", "600", "--call-limit", "600", "--workers", "1", "--out", str(tmp_path / "out")]
    environment = {**os.environ, "PROXYPROOF_ASLEEP": str(ready)}
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL) as run:
        assert eventually(ready.exists, 60.0)
        begin = time.monotonic()
        os.kill(run.pid, number)
        run.wait(30.0)
    assert time.monotonic() - begin < 15
