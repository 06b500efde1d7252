"""Whatever an engine does to its process costs the scene that did it, and nothing else."""

from __future__ import annotations

import errno
import os
import re
import secrets
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np
import pytest

from oracles.engine import Answers, Engine, EngineUnavailable, Status
from oracles.isolation.processes import children, marked
from oracles.scene import DISTANCE
from oracles.worker import EngineWorker
from refimpl.shapes import Sphere
from tests import hostile_engines as hostile
from tests import ill_mannered_engines as ill_mannered
from tests.wrong_engines import spec

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the limits of memory and processes read /proc")

MIB = 1 << 20
OURS = f"PROXYPROOF_TEST={secrets.token_hex(8)}"
"""Whatever these tests start has this in its environment."""


@pytest.fixture(scope="module", autouse=True)
def environment() -> Iterator[None]:
    name, value = OURS.split("=")
    os.environ[name] = value
    yield
    del os.environ[name]
    assert eventually(lambda: not marked(OURS)), "processes are left"


@pytest.fixture(scope="module")
def shared(environment: None) -> Iterator[EngineWorker]:
    """One worker for all tricks: that it lives through them is half of the test."""
    with EngineWorker(spec(hostile.Hostile), 0.15) as at_work:
        yield at_work


@pytest.fixture(autouse=True)
def nothing_is_left(environment: None) -> Iterator[None]:
    """After each test there are at most the guard, fork server and hand of the shared worker."""
    yield
    assert eventually(lambda: len(marked(OURS)) <= 3), "processes are left"


def eventually(true: Callable[[], bool], seconds: float = 20.0) -> bool:
    end = time.monotonic() + seconds
    while not true():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def ask(at_work: EngineWorker, *x: float) -> Answers:
    a = np.array([[u, 0.0, 0.0, 1.0] for u in x])
    return at_work.answer(DISTANCE, Sphere, Sphere, a, np.broadcast_to([3.0, 0.0, 0.0, 1.0], (len(x), 4)))


def play(at_work: EngineWorker, name: str) -> tuple[Status, str]:
    """What becomes of a trick between innocent scenes, which are answered rightly."""
    x = [-2.0, -300.0, hostile.number_of(name), -200.0, -1.0]
    answers = ask(at_work, *x)
    innocent = [0, 1, 3, 4]
    assert [Status(int(s)) for s in answers.status[innocent]] == [Status.ANSWERED] * 4, answers.errors
    np.testing.assert_array_equal(answers.distance[innocent], [abs(x[i] - 3) - 2 for i in innocent])
    assert set(answers.errors) <= {2}
    text = answers.errors.get(2, "")
    assert len(text) <= 640
    assert text.isprintable()
    return Status(int(answers.status[2])), text


ENDS = {
    "kills_itself": "the process was ended by SIGKILL",
    "sends_itself_a_nameless_signal": f"the process was ended by signal {signal.SIGRTMIN + 5}",
    "kills_its_group": "the process was ended by SIGKILL",
    "kills_its_parent": "the process that had imported the engine was lost",
    "aborts": "ended by SIGABRT",
    "reads_at_zero": "ended by SIGSEGV",
    "overflows_the_stack": "ended by SIGSEGV",
    "leaves_at_once": "ended with exit status 0",
    "leaves": "ended with exit status 0",
    "leaves_with_words": "ended with exit status 1: so long",
    "rubbish_then_abort": r"ended by SIGABRT \(Aborted\): [^\ufffd]*\ufffd[^\ufffd]",
}


@pytest.mark.parametrize("name", ENDS)
def test_a_call_that_ends_its_process(shared: EngineWorker, name: str) -> None:
    status, text = play(shared, name)
    assert status == Status.CRASHED
    assert re.search(ENDS[name], text)


@pytest.mark.parametrize(
    "name", ["stops_itself", "sleeps", "spins", "waits_for_a_lock", "endless_text", "endless_float"]
)
def test_a_call_that_does_not_end(shared: EngineWorker, name: str) -> None:
    assert play(shared, name) == (Status.TIMED_OUT, "no answer within 0.15 s")


RAISED = {
    "BaseException": "BaseException: bare",
    "KeyboardInterrupt": "KeyboardInterrupt: pressed",
    "GeneratorExit": "GeneratorExit: generated",
    "MemoryError": "MemoryError: full",
    "UnspeakableError": r"UnspeakableError: \(its text cannot be had: ZeroDivisionError\)",
    "LongError": "LongError: long long long",
    "StopIteration": "StopIteration: 1",
    "BaseExceptionGroup": "BaseExceptionGroup: many",
}


@pytest.mark.parametrize("name", RAISED)
def test_whatever_is_raised_is_an_error(shared: EngineWorker, name: str) -> None:
    status, text = play(shared, f"raises_{name}")
    assert status == Status.ERROR
    assert re.match(RAISED[name], text)


def test_recursion_without_end_is_an_error(shared: EngineWorker) -> None:
    status, text = play(shared, "recurses")
    assert status == Status.ERROR
    assert text.startswith("RecursionError: maximum recursion depth")


@pytest.mark.parametrize("name", hostile.NONSENSE)
def test_nonsense_is_an_error_with_a_short_text(shared: EngineWorker, name: str) -> None:
    status, text = play(shared, f"answers_{name}")
    assert status == Status.ERROR
    assert text.startswith(hostile.NONSENSE[name][1])


@pytest.mark.parametrize("name", hostile.CHANGES)
def test_what_a_call_leaves_changed_is_said_and_set_back(shared: EngineWorker, name: str) -> None:
    shared.take_incidents()
    status, text = play(shared, f"changes_{name}")
    assert status == Status.ANSWERED
    assert re.fullmatch(f"left changed: {hostile.CHANGES[name][1]}", text)
    assert shared.take_incidents() == {f"{text}: distance Sphere–Sphere": 1}


@pytest.mark.parametrize("name", hostile.UNSEEN)
def test_changes_that_no_answer_depends_on(shared: EngineWorker, name: str) -> None:
    assert play(shared, f"changes_{name}")[0] == Status.ANSWERED


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("forks", "left 1 process running"),
        ("forks_a_spinning_child", "left 1 process running"),
        ("forks_a_daemon", "left 1 process running"),
        ("starts_a_program", "left 1 process running"),
        ("a_thread_spins", "kept the processor busy while no scene was asked"),
    ],
)
def test_what_a_call_leaves_running_is_ended(shared: EngineWorker, name: str, text: str) -> None:
    shared.take_incidents()
    assert play(shared, name) == (Status.ANSWERED, "")
    assert eventually(lambda: len(marked(OURS)) == 2), "the hand is ended with all that it started"
    ask(shared, -1.0)
    assert shared.take_incidents() == {text: 1}


def test_more_children_than_any_engine_needs() -> None:
    with EngineWorker(spec(hostile.Hostile), 10.0) as at_work:
        assert play(at_work, "forks_many") == (Status.CRASHED, "the process started more than 64 others")


def test_a_child_that_returns_to_the_harness_is_ended(shared: EngineWorker) -> None:
    assert play(shared, "forks_and_both_return") == (Status.ANSWERED, "")


def test_tricks_among_thousands_of_scenes_cost_themselves_only(shared: EngineWorker) -> None:
    x = -np.arange(1.0, 4001.0)
    tricks = {
        700: ("changes_upward", Status.ANSWERED, "left changed: the rounding"),
        701: ("changes_flushing", Status.ANSWERED, "left changed: the treatment of tiny"),
        900: ("aborts", Status.CRASHED, "the process was ended by SIGABRT"),
        901: ("answers_endless_generator", Status.ERROR, "answered a repeat"),
        1300: ("kills_its_parent", Status.CRASHED, "the process that had imported"),
        1500: ("spins", Status.TIMED_OUT, "no answer within"),
        3999: ("changes_recursion", Status.ANSWERED, "left changed: the recursion limit"),
    }
    for i, (name, _, _) in tricks.items():
        x[i] = hostile.number_of(name)
    answers = ask(shared, *x)
    assert set(answers.errors) == set(tricks)
    for i, (_, status, text) in tricks.items():
        assert answers.status[i] == status
        assert answers.errors[i].startswith(text)
    innocent = x < 0
    assert not answers.status[innocent].any()
    np.testing.assert_array_equal(answers.distance[innocent], np.abs(x[innocent] - 3) - 2)


def test_a_loss_that_a_fresh_process_does_not_repeat_stays_that_of_its_scene() -> None:
    with EngineWorker(spec(ill_mannered.DiesOfItsPast)) as at_work:
        answers = ask(at_work, *[-1.0] * 600)
        (lost,) = np.flatnonzero(answers.status).tolist()
        assert lost == 499
        assert answers.status[lost] == Status.CRASHED
        assert re.fullmatch(
            r"the process was ended by SIGABRT \(Aborted\).*; not again in a fresh process", answers.errors[lost]
        )


def test_shared_memory_that_is_written_over_is_not_believed(shared: EngineWorker) -> None:
    answers = ask(shared, -1.0, -2.0, hostile.number_of("writes_over_shared_memory"), -3.0)
    assert set(answers.status[:2]) == {Status.CRASHED}
    assert set(answers.status[2:]) <= {Status.ANSWERED, Status.CRASHED, Status.ERROR}
    assert "the engine's process wrote over the memory that it shares with the harness" in answers.errors.values()
    assert play(shared, "aborts")[0] == Status.CRASHED


# -- memory --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["leaks", "leaks_in_a_child", "leaks_shared_memory"])
def test_a_leak_is_stopped(name: str) -> None:
    with EngineWorker(spec(hostile.Hostile), 10.0, memory_limit=150 * MIB) as at_work:
        assert play(at_work, name) == (Status.CRASHED, "the process used more than 150 MiB of memory")


def test_memory_far_beyond_the_limit_is_refused_by_the_system() -> None:
    with EngineWorker(spec(hostile.Hostile), 10.0, memory_limit=150 * MIB) as at_work:
        assert play(at_work, "asks_for_too_much") == (Status.ERROR, "MemoryError: ")


def test_a_gigabyte_of_output() -> None:
    with EngineWorker(spec(hostile.Hostile), 30.0) as at_work:
        assert play(at_work, "floods") == (Status.ANSWERED, "")


# -- processes that are killed -------------------------------------------------------------------------------


def processes_of(at_work: EngineWorker) -> list[int]:
    """The guard, the fork server and, where there is one, the hand."""
    process = at_work._guarded.process
    found = [] if process is None else [process.pid]
    for parent in found:
        found += children(parent)
    return found


def kill(*processes: int) -> None:
    for process in processes:
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)


SLOW, SLOWER = (hostile.number_of(name) for name in ("takes_its_time", "takes_until_it_is_killed"))
GUARD = r"the guard of the engine's process was ended by SIGKILL \(Killed\), and was started again: distance Sphere–S"


@pytest.fixture
def patient(environment: None) -> Iterator[EngineWorker]:
    with EngineWorker(spec(hostile.Hostile), 10.0) as at_work:
        yield at_work


@pytest.mark.parametrize(
    "which", [slice(0, 1), slice(1, 2), slice(2, 3), slice(0, 3)], ids=["guard", "server", "hand", "all"]
)
def test_whatever_is_killed_while_nothing_is_asked_is_replaced(patient: EngineWorker, which: slice) -> None:
    assert ask(patient, -1.0).distance.tolist() == [2.0]
    kill(*processes_of(patient)[which])
    assert ask(patient, -2.0, -3.0).distance.tolist() == [3.0, 4.0]
    assert ask(patient, -2.0, -3.0).distance.tolist() == [3.0, 4.0]
    found = patient.take_incidents()
    assert sum(found.values()) == int(which.start == 0)
    assert all(re.match(GUARD, text) for text in found)


def killer(at_work: EngineWorker, times: int, which: slice, at: int) -> threading.Thread:
    """Kills some of the processes so many times while a scene is asked."""

    killed: set[int] = set()

    def ready() -> bool:
        """A process that is killed keeps its number and its children for a moment: it must not be counted again."""
        found = processes_of(at_work)
        return at_work._guarded.board.at[0] == at and len(found) == 3 and killed.isdisjoint(found)

    def work() -> None:
        for _ in range(times):
            assert eventually(ready)
            chosen = processes_of(at_work)[which]
            killed.update(chosen)
            kill(*chosen)

    thread = threading.Thread(target=work)
    thread.start()
    return thread


@pytest.mark.parametrize("which", [slice(0, 1), slice(0, 3)], ids=["guard", "session"])
def test_a_guard_killed_in_the_middle_of_a_batch(patient: EngineWorker, which: slice) -> None:
    at_kill = killer(patient, 1, which, 1)
    answers = ask(patient, -1.0, SLOW, -200.0)
    at_kill.join()
    assert answers.distance.tolist() == [2.0, SLOW - 5.0, 201.0]
    assert answers.errors == {}
    (text,) = patient.take_incidents()
    assert re.match(GUARD, text)


def test_a_scene_at_which_the_guard_dies_twice_is_lost(patient: EngineWorker) -> None:
    at_kill = killer(patient, 2, slice(0, 1), 1)
    answers = ask(patient, -1.0, SLOWER, -200.0)
    at_kill.join()
    assert answers.status.tolist() == [Status.ANSWERED, Status.CRASHED, Status.ANSWERED]
    assert re.search(r"SIGKILL \(Killed\), twice at this scene", answers.errors[1])


@pytest.mark.parametrize("which", [slice(1, 2), slice(2, 3)], ids=["fork server", "hand"])
def test_a_hand_killed_from_outside_costs_its_scene(patient: EngineWorker, which: slice) -> None:
    at_kill = killer(patient, 1, which, 0)
    answers = ask(patient, SLOWER, -200.0)
    at_kill.join()
    assert answers.status.tolist() == [Status.CRASHED, Status.ANSWERED]
    assert ask(patient, SLOW).status.tolist() == [Status.ANSWERED]


def test_a_guard_that_is_stopped_is_replaced(patient: EngineWorker, monkeypatch: pytest.MonkeyPatch) -> None:
    ask(patient, -1.0)
    monkeypatch.setattr("oracles.isolation.guarded.STALLED", 1.0)
    os.kill(processes_of(patient)[0], signal.SIGSTOP)
    assert ask(patient, -2.0).distance.tolist() == [3.0]
    (text,) = patient.take_incidents()
    assert text.startswith("the guard of the engine's process did nothing for 1 s")


def test_kills_at_any_moment_lose_nothing(patient: EngineWorker) -> None:
    """Scenes that were being asked when the hand was killed may be lost; no other, and no answer is wrong."""
    rng, over, killed = np.random.default_rng(5), threading.Event(), []

    def work() -> None:
        while not over.is_set():
            eventually(lambda: over.is_set() or len(processes_of(patient)) == 3)
            over.wait(rng.uniform(0.0, 0.3))
            chosen = processes_of(patient)
            if chosen:
                killed.append(int(rng.choice(chosen)))
                kill(killed[-1])

    thread = threading.Thread(target=work)
    thread.start()
    try:
        for n in [1, 3, 20_000, 10_000, 1, 1, 5_000]:
            x = -rng.uniform(0.0, 50.0, n)
            answers = ask(patient, *x)
            lost = answers.status != Status.ANSWERED
            assert set(answers.status[lost]) <= {Status.CRASHED}
            assert lost.sum() <= len(killed)
            np.testing.assert_allclose(answers.distance[~lost], 1.0 - x[~lost], rtol=1e-15)
    finally:
        over.set()
        thread.join()


# -- engines that do harm when they are imported -------------------------------------------------------------


@pytest.mark.parametrize(
    ("engine", "text"),
    [
        (ill_mannered.HangsOnWarm, "did not start within 3 s"),
        (ill_mannered.LeaksOnWarm, "used more than 400 MiB to start"),
        (ill_mannered.LeavesOnWarm, "cannot be started: SystemExit: 3"),
        (ill_mannered.RaisesOnSupport, "RaisesOnSupport.support, asked about"),
        (ill_mannered.RubbishSays, "RubbishSays.says, asked about"),
    ],
)
def test_an_engine_that_cannot_be_imported(engine: type[Engine], text: str) -> None:
    with pytest.raises(EngineUnavailable, match=text):
        EngineWorker(spec(engine), memory_limit=400 * MIB, start_limit=3.0)


@pytest.mark.parametrize("engine", [ill_mannered.PrintsOnWarm, ill_mannered.ForksOnWarm])
def test_an_engine_that_prints_or_forks_when_imported(engine: type[Engine]) -> None:
    with EngineWorker(spec(engine), 0.3) as at_work:
        assert play(at_work, "aborts")[0] == Status.CRASHED
        assert play(at_work, "sleeps")[0] == Status.TIMED_OUT


def test_a_state_set_by_the_import_is_the_engine_s_own() -> None:
    with EngineWorker(spec(ill_mannered.RoundsUpFromTheStart)) as at_work:
        assert ask(at_work, -1.0, -2.0).distance.tolist() == [hostile.FE_UPWARD] * 2


def test_a_full_disk_is_no_concern_of_a_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    """No file is made anywhere."""

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    for name in ("TemporaryFile", "NamedTemporaryFile", "mkstemp", "mkdtemp"):
        monkeypatch.setattr(tempfile, name, full)
    monkeypatch.setenv("TMPDIR", "/nowhere")
    with EngineWorker(spec(hostile.Hostile)) as at_work:
        assert play(at_work, "rubbish_then_abort")[0] == Status.CRASHED
        files = {os.path.realpath(f"/proc/{p}/fd/{n}") for p in marked(OURS) for n in os.listdir(f"/proc/{p}/fd")}
        assert not {f for f in files if os.path.isfile(f)}
