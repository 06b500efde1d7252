"""The worker keeps a campaign going whatever an engine does: crash, hang, raise, print, answer nonsense."""

from __future__ import annotations

import math
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from oracles.engine import Answers, Array, Engine, EngineUnavailable, Status
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST
from oracles.worker import EngineWorker
from refimpl.shapes import AABB, KDOP, Point, Ray, Sphere
from tests import wrong_engines as wrong

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


def worker(engine: type[Engine], call_limit: float = 0.2) -> EngineWorker:
    return EngineWorker(wrong.spec(engine), call_limit)


def balls(*x: float) -> tuple[Array, Array]:
    """A unit ball at (x, 0, 0) for each x, and one at (3, 0, 0)."""
    a = np.array([[u, 0.0, 0.0, 1.0] for u in x]).reshape(-1, 4)
    return a, np.broadcast_to([3.0, 0.0, 0.0, 1.0], (len(x), 4))


def ask(engine: type[Engine], *x: float, query: str = DISTANCE, call_limit: float = 0.2) -> Answers:
    with worker(engine, call_limit) as at_work:
        return at_work.answer(query, Sphere, Sphere, *balls(*x))


def statuses(answers: Answers) -> list[Status]:
    return [Status(int(s)) for s in answers.status]


def guard_of(at_work: EngineWorker) -> int:
    process = at_work._guarded.process
    assert process is not None
    return process.pid


def hand_of(at_work: EngineWorker) -> int:
    """Waits for the hand: the child of the fork server, which is the child of the guard."""
    assert eventually(lambda: len(children_of(guard_of(at_work))) == 2)
    return children_of(guard_of(at_work))[1]


def children_of(process: int) -> list[int]:
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, fields = int(entry.parent.name), entry.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == process:
            found += [name, *children_of(name)]
    return found


def alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def eventually(true: Callable[[], bool], seconds: float = 5.0) -> bool:
    end = time.monotonic() + seconds
    while not true():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


# -- answers -------------------------------------------------------------------------------------------------


def test_answers_are_those_of_the_solver_in_every_query() -> None:
    engine = wrong.Honest()
    rng = np.random.default_rng(1)
    with worker(wrong.Honest) as at_work:
        for query, A, B in (
            (DISTANCE, Sphere, AABB),
            (CONTACTS, Point, Sphere),
            (BOOLEAN, Sphere, Sphere),
            (RAYCAST, Ray, Sphere),
        ):
            a, b = rng.uniform(0.1, 2.0, (50, A.width())), rng.uniform(0.1, 2.0, (50, B.width()))
            if B is AABB:
                b[:, 3:] += 2
            answers = at_work.answer(query, A, B, a, b)
            solve = engine.solver(query, A, B)
            rows = np.array([solve(x, y) for x, y in zip(a.tolist(), b.tolist(), strict=True)])
            expected = Answers.from_table(np.zeros(50, np.int8), rows, {})
            for name in ("status", "hit", "distance", "on_a", "on_b", "normal", "t", "point"):
                np.testing.assert_array_equal(getattr(answers, name), getattr(expected, name))
            assert not answers.errors


def test_batches_of_any_size() -> None:
    with worker(wrong.Honest) as at_work:
        assert len(at_work.answer(DISTANCE, Sphere, Sphere, *balls())) == 0
        many = np.linspace(-50, 50, 10_001)
        answers = at_work.answer(DISTANCE, Sphere, Sphere, *balls(*many))
        np.testing.assert_allclose(answers.distance, np.abs(many - 3) - 2, rtol=0, atol=1e-13)


def test_two_engines_work_while_the_parent_does() -> None:
    with worker(wrong.Sleeping, 5.0) as one, worker(wrong.Sleeping, 5.0) as two:
        begin = time.monotonic()
        one.submit(DISTANCE, Sphere, Sphere, *balls(0.5))
        two.submit(DISTANCE, Sphere, Sphere, *balls(0.5))
        assert time.monotonic() - begin < 0.4
        assert one.result().distance[0] == two.result().distance[0] == 0.5


def test_misuse_is_refused_in_words() -> None:
    with worker(wrong.Honest) as at_work:
        with pytest.raises(RuntimeError, match="nothing was submitted"):
            at_work.result()
        with pytest.raises(ValueError, match="rows_b: a Sphere is a row of 4 numbers"):
            at_work.submit(DISTANCE, Sphere, Sphere, np.zeros((2, 4)), np.zeros((2, 3)))
        with pytest.raises(ValueError, match="per scene"):
            at_work.submit(DISTANCE, Sphere, Sphere, np.zeros((2, 4)), np.zeros((3, 4)))
        at_work.submit(DISTANCE, Sphere, Sphere, *balls(0))
        with pytest.raises(RuntimeError, match="take its result first"):
            at_work.submit(DISTANCE, Sphere, Sphere, *balls(0))
        assert at_work.result().distance[0] == 1.0
    with pytest.raises(EngineUnavailable, match="closed"):
        at_work.answer(DISTANCE, Sphere, Sphere, *balls(0))
    with pytest.raises(ValueError, match="call_limit"):
        EngineWorker("fcl", 0.0)


# -- lost and broken answers ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("engine", "fate", "text"),
    [
        (wrong.Crashing, Status.CRASHED, "ended by SIGABRT (Aborted): assertion failed on purpose"),
        (wrong.Leaving, Status.CRASHED, "exit status 7"),
        (wrong.Hanging, Status.TIMED_OUT, "no answer within 0.2 s"),
        (wrong.Raising, Status.ERROR, "ValueError: on purpose"),
    ],
)
def test_a_lost_scene_costs_only_itself(engine: type[Engine], fate: Status, text: str) -> None:
    x = (-1.0, 2.0, 0.0, 1.5, 2.5, -4.0)
    lost = np.array(x) > 0
    with worker(engine) as at_work, worker(wrong.Honest) as honest:
        for query in (DISTANCE, CONTACTS, BOOLEAN):
            answers, right = (w.answer(query, Sphere, Sphere, *balls(*x)) for w in (at_work, honest))
            assert statuses(answers) == [fate if u else Status.ANSWERED for u in lost]
            assert set(answers.errors) == set(np.flatnonzero(lost).tolist())
            assert all(text in message for message in answers.errors.values())
            np.testing.assert_array_equal(answers.distance[~lost], right.distance[~lost])
            np.testing.assert_array_equal(answers.hit[~lost], right.hit[~lost])
            assert np.isnan(answers.distance[lost]).all()


def test_a_shape_that_an_engine_cannot_hold_is_no_error() -> None:
    found = ask(wrong.Picky, -1.0, 1.0, -2.0)
    assert statuses(found) == [Status.ANSWERED, Status.UNSUPPORTED, Status.ANSWERED]
    assert found.errors == {1: "UnsupportedCell: on purpose"}


def test_rows_that_say_their_own_size_pass_as_they_are() -> None:
    balls = np.array([[0.0, 0.0, 0.0, 1.0]] * 2)
    directions = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [1.0, 1.0, 0]])
    slabs = [KDOP(directions[:k], np.zeros(k), np.ones(k)).pack() for k in (3, 4)]
    with worker(wrong.Counting) as at_work:
        for row in slabs:
            found = at_work.answer(DISTANCE, KDOP, Sphere, [row, row], balls)
            assert found.distance.tolist() == [len(row)] * 2


def test_many_crashes_are_cheap_and_leave_nothing_behind() -> None:
    before = len(os.listdir("/dev/fd"))
    begin = time.monotonic()
    answers = ask(wrong.Crashing, *[1.0, -1.0] * 50)
    assert answers.counts()[Status.CRASHED] == answers.counts()[Status.ANSWERED] == 50
    assert time.monotonic() - begin < 10
    assert len(os.listdir("/dev/fd")) == before


def test_a_group_is_given_up_after_so_many_timeouts() -> None:
    with worker(wrong.Hanging, 0.1) as at_work:
        x = [-1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0]
        groups = [7, 7, 3, 7, 7, 7, 3]
        answers = at_work.answer(DISTANCE, Sphere, Sphere, *balls(*x), groups=groups, give_up_after=2)
        lost, skipped = Status.TIMED_OUT, Status.SKIPPED
        assert statuses(answers) == [Status.ANSWERED, lost, lost, lost, skipped, skipped, lost]
        assert answers.counts()[Status.SKIPPED] == 2
        assert statuses(at_work.answer(DISTANCE, Sphere, Sphere, *balls(-1.0), groups=[7])) == [Status.ANSWERED]


def test_a_group_is_given_up_across_chunks() -> None:
    with worker(wrong.Hanging, 0.05) as at_work:
        x = np.full(9000, -1.0)
        x[[10, 8000]] = 1.0
        answers = at_work.answer(DISTANCE, Sphere, Sphere, *balls(*x), give_up_after=1)
        assert statuses(answers)[10] == Status.TIMED_OUT
        assert answers.counts()[Status.SKIPPED] == 9000 - 11


def test_a_process_without_the_processor_is_waited_for_five_limits() -> None:
    """A call that takes wall time but no processor may only be slow: the machine is busy with others."""
    answers = ask(wrong.Sleeping, 0.3, 2.0, -1.0, call_limit=0.15)
    assert statuses(answers) == [Status.ANSWERED, Status.TIMED_OUT, Status.ANSWERED]


def test_nan_is_no_answer() -> None:
    answers = ask(wrong.NotANumber, 2.0, 0.0)
    assert statuses(answers) == [Status.ERROR, Status.ERROR]
    assert answers.errors[0] == "answered distance = nan"
    answers = ask(wrong.NotANumber, 2.0, query=BOOLEAN)
    assert answers.errors[0] == "answered hit = nan"


def test_a_ray_that_misses_owes_no_point() -> None:
    with worker(wrong.Honest) as at_work:
        answers = at_work.answer(RAYCAST, Ray, Sphere, [[0, 0, 0, 0, 1, 0.0]], [[3, 0, 0, 1.0]])
        assert statuses(answers) == [Status.ANSWERED]
        assert (answers.hit[0], answers.t[0]) == (0.0, math.inf)


def test_answers_that_are_not_numbers_are_errors() -> None:
    answers = ask(wrong.Mistyped, -1.0, 0.5, 2.0)
    assert statuses(answers) == [Status.ERROR] * 3
    assert answers.errors[0] == "answered None"
    assert answers.errors[1] == "answered [1.0]"
    assert answers.errors[2].startswith("answered ['yes'")


def test_a_solver_that_cannot_be_made() -> None:
    answers = ask(wrong.RaisingSolver, 1.0, 2.0)
    assert statuses(answers) == [Status.ERROR, Status.ERROR]
    assert set(answers.errors.values()) == {"RuntimeError: no solver on purpose"}
    assert statuses(ask(wrong.CrashingSolver, 1.0, 2.0)) == [Status.CRASHED, Status.CRASHED]
    with worker(wrong.Honest) as at_work:
        answers = at_work.answer(RAYCAST, Ray, AABB, np.ones((1, 6)), np.ones((1, 6)))
        assert "UnsupportedCell" in answers.errors[0]
        assert "not written" in answers.errors[0]


def test_megabytes_of_output_reach_nobody(capfd: pytest.CaptureFixture[str]) -> None:
    with worker(wrong.Noisy, 5.0) as at_work:
        assert statuses(at_work.answer(DISTANCE, Sphere, Sphere, *balls(*range(400)))) == [Status.ANSWERED] * 400
    assert capfd.readouterr() == ("", "")


def test_a_renewed_worker_remembers_nothing() -> None:
    with worker(wrong.Remembering) as at_work:
        at_work.renew()
        assert at_work.answer(DISTANCE, Sphere, Sphere, *balls(-1.0, -1.0)).distance.tolist() == [0, 1]
        assert at_work.answer(DISTANCE, Sphere, Sphere, *balls(-1.0, -1.0)).distance.tolist() == [2, 3]
        at_work.renew()
        assert at_work.answer(DISTANCE, Sphere, Sphere, *balls(-1.0, -1.0)).distance.tolist() == [0, 1]
        assert at_work.answer(DISTANCE, Sphere, Sphere, *balls(-1.0, -1.0)).distance.tolist() == [2, 3]
        assert at_work.incidents == {}


@LINUX
def test_a_hand_that_ended_between_two_batches_is_replaced() -> None:
    with worker(wrong.Honest) as at_work:
        at_work.answer(DISTANCE, Sphere, Sphere, *balls(0.0, 1.0))
        hand = hand_of(at_work)
        os.kill(hand, signal.SIGKILL)
        assert eventually(lambda: not alive(hand))
        assert statuses(at_work.answer(DISTANCE, Sphere, Sphere, *balls(0.0, 1.0))) == [Status.ANSWERED] * 2


def test_an_unknown_query_is_an_error_of_every_scene() -> None:
    answers = ask(wrong.Honest, 0.0, 1.0, query="touch")
    assert statuses(answers) == [Status.ERROR] * 2
    assert answers.errors[1].startswith("ValueError: no query 'touch'")


def test_a_crash_at_the_start_of_a_second_batch_is_put_down_to_its_own_scene() -> None:
    with worker(wrong.Crashing) as at_work:
        at_work.answer(DISTANCE, Sphere, Sphere, *balls(*[-1.0] * 50))
        found = at_work.answer(DISTANCE, Sphere, Sphere, *balls(1.0, -1.0))
        assert statuses(found) == [Status.CRASHED, Status.ANSWERED]


# -- starting ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spec", "text"),
    [
        (wrong.spec(wrong.Missing), "the package nowhere is not installed: pip install nowhere"),
        (wrong.spec(wrong.Failing), "OSError: libnowhere.so"),
        (wrong.spec(wrong.Dying), "bad processor"),
        ("nowhere", "no engine 'nowhere': there are fcl, bullet"),
        ("nowhere.at.all:Engine", "cannot be imported"),
        ("tests.wrong_engines:Nobody", "has no Nobody"),
        ("tests.wrong_engines:LIARS", "is no engine: it gives a tuple"),
    ],
)
def test_an_engine_that_does_not_start_says_why(spec: str, text: str) -> None:
    with pytest.raises(EngineUnavailable, match=re.escape(text)):
        EngineWorker(spec)


def test_an_engine_named_by_its_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("from tests.wrong_engines import Honest\n\ndef make():\n    return Honest()\n", "utf-8")
    with EngineWorker(f"{file}:make") as at_work:
        assert at_work.answer(DISTANCE, Sphere, Sphere, *balls(0.0)).distance[0] == 1.0


# -- ending --------------------------------------------------------------------------------------------------


@LINUX
def test_close_ends_every_process_and_leaves_no_zombie() -> None:
    at_work = worker(wrong.Hanging, 60.0)
    at_work.submit(DISTANCE, Sphere, Sphere, *balls(1.0))
    guard = guard_of(at_work)
    processes = [guard, *children_of(guard), hand_of(at_work)]
    begin = time.monotonic()
    at_work.close()
    at_work.close()
    assert time.monotonic() - begin < 2
    assert eventually(lambda: not any(map(alive, processes)))
    assert guard not in children_of(os.getpid())


@LINUX
def test_a_worker_that_is_forgotten_is_ended() -> None:
    at_work = worker(wrong.Honest)
    guard = guard_of(at_work)
    del at_work
    assert eventually(lambda: not alive(guard))


@LINUX
def test_nothing_outlives_a_killed_parent() -> None:
    script = (
        "import sys\nfrom oracles.worker import EngineWorker\nfrom refimpl.shapes import Sphere\n"
        "w = EngineWorker(sys.argv[1], 60.0)\nrow = [[1.0, 0, 0, 1]]\nw.submit('distance', Sphere, Sphere, row, row)\n"
        "print(w._guarded.process.pid, flush=True)\nw.result()\n"
    )
    command = [sys.executable, "-c", script, wrong.spec(wrong.Hanging)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1]) as parent:
        assert parent.stdout is not None
        guard = int(parent.stdout.readline())
        assert eventually(lambda: len(children_of(guard)) == 2)
        processes = [guard, *children_of(guard)]
        parent.kill()
    assert eventually(lambda: not any(map(alive, processes)))


def test_interrupt_from_another_thread() -> None:
    with worker(wrong.Hanging, 60.0) as at_work:
        threading.Timer(0.2, at_work.interrupt).start()
        begin = time.monotonic()
        with pytest.raises(EngineUnavailable, match="was interrupted"):
            at_work.answer(DISTANCE, Sphere, Sphere, *balls(1.0))
        assert time.monotonic() - begin < 5


@LINUX
def test_ctrl_c_reaches_the_parent_only(tmp_path: Path) -> None:
    """An interrupt of the whole process group: the parent gets it, the worker answers on and prints nothing."""
    script = (
        "import sys, time\nfrom oracles.worker import EngineWorker\nfrom refimpl.shapes import Sphere\n"
        "row = [[-1.0, 0, 0, 1]]\n"
        "with EngineWorker(sys.argv[1]) as w:\n"
        "    try:\n        print('ready', flush=True)\n        time.sleep(30)\n"
        "    except KeyboardInterrupt:\n"
        "        print(w.answer('distance', Sphere, Sphere, row, row).distance[0])\n"
    )
    command = [sys.executable, "-c", script, wrong.spec(wrong.Honest)]
    pipe, root = subprocess.PIPE, Path(__file__).parents[1]
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, cwd=root, start_new_session=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == "ready\n"
        os.killpg(parent.pid, signal.SIGINT)
        out, err = parent.communicate(timeout=20)
    assert (out, err, parent.returncode) == ("-2.0\n", "", 0)
