"""A crew of processes: kill −9 costs time and nothing else, and nothing is left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError, wait
from pathlib import Path

import pytest

from oracles.executors import TRIES, Crew, Here, WorkerLost, room


@pytest.fixture
def crew() -> Iterator[Crew]:
    with Crew(2) as found:
        yield found


def double(x: int) -> int:
    return 2 * x


def die_until(marks: str, times: int) -> int:
    """End the process by kill −9 so many times; then answer how often that was."""
    path = Path(marks)
    seen = len(path.read_text()) if path.exists() else 0
    if seen < times:
        path.write_text("x" * (seen + 1))
        os.kill(os.getpid(), signal.SIGKILL)
    return seen


def refuse(text: str) -> None:
    raise KeyError(text)


def closure() -> object:
    return lambda: None


def number_of_process(seconds: float = 0.0) -> int:
    time.sleep(seconds)
    return os.getpid()


def alive(process: int) -> bool:
    """Whether a process is there, and not just its entry in the table."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def gone(process: int, within: float = 10.0) -> bool:
    end = time.monotonic() + within
    while alive(process) and time.monotonic() < end:
        time.sleep(0.05)
    return not alive(process)


def test_tasks_are_done_in_other_processes_that_end_with_the_crew() -> None:
    with Crew(2) as crew:
        assert [crew.submit(double, x).result() for x in range(5)] == [0, 2, 4, 6, 8]
        processes = {f.result() for f in [crew.submit(number_of_process, 0.3) for _ in range(6)]}
        assert processes == set(crew.processes)
        assert len(processes) == 2
        assert os.getpid() not in processes
    assert all(gone(process) for process in processes)


def test_a_killed_process_costs_its_task_nothing_but_time(crew: Crew, tmp_path: Path) -> None:
    lost = crew.submit(die_until, str(tmp_path / "marks"), TRIES - 1)
    others = [crew.submit(double, x) for x in range(20)]
    assert lost.result() == TRIES - 1
    assert [f.result() for f in others] == [2 * x for x in range(20)]


def test_a_task_that_kills_every_process_is_given_up_and_no_other(crew: Crew, tmp_path: Path) -> None:
    lost = crew.submit(die_until, str(tmp_path / "marks"), 100)
    others = [crew.submit(double, x) for x in range(20)]
    with pytest.raises(WorkerLost, match=rf"ended {TRIES} times, with exit status \[-9, -9, -9\]"):
        lost.result()
    assert [f.result() for f in others] == [2 * x for x in range(20)]
    assert crew.submit(double, 21).result() == 42


def test_a_process_killed_from_outside_is_replaced(crew: Crew) -> None:
    pending = [crew.submit(number_of_process, 1.0) for _ in range(2)]
    while len(crew.processes) < 2 or not all(f.running() for f in pending):
        time.sleep(0.05)
    first, second = crew.processes
    os.kill(first, signal.SIGKILL)
    found = {f.result() for f in pending}
    assert second in found
    assert first not in found
    assert len(found) == 2


def test_errors_belong_to_their_tasks(crew: Crew) -> None:
    with pytest.raises(RuntimeError, match="KeyError: 'on purpose'"):
        crew.submit(refuse, "on purpose").result()
    with pytest.raises(Exception, match=r"[Pp]ickle|local object"):
        crew.submit(lambda: 0).result()
    assert crew.submit(double, 1).result() == 2


def test_an_answer_that_cannot_be_sent_is_an_error_of_its_task(crew: Crew) -> None:
    with pytest.raises(RuntimeError, match=r"[Pp]ickle|local object"):
        crew.submit(closure).result()
    assert crew.submit(double, 1).result() == 2


def test_cancelling_ends_at_once_whatever_is_done(crew: Crew) -> None:
    pending = [crew.submit(number_of_process, 60.0) for _ in range(5)]
    while len(crew.processes) < 2:
        time.sleep(0.05)
    processes = crew.processes
    began = time.monotonic()
    crew.shutdown(cancel_futures=True)
    assert time.monotonic() - began < 5
    assert all(gone(process) for process in processes)
    assert len(wait(pending, timeout=5).done) == 5
    for future in pending:
        with pytest.raises((WorkerLost, CancelledError)):
            future.result()


ORPHANS = """
import sys, time
from oracles.executors import Crew
from tests.test_executors import number_of_process

if __name__ == "__main__":
    crew = Crew(2)
    for future in [crew.submit(number_of_process, 0.5) for _ in range(2)]:
        print(future.result(), flush=True)
    busy = [crew.submit(number_of_process, 600.0) for _ in range(2)]
    print("busy", flush=True)
    time.sleep(600)
"""


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_no_orphans_are_left_when_the_parent_is_killed(tmp_path: Path, how: signal.Signals) -> None:
    script = tmp_path / "parent.py"
    script.write_text(ORPHANS)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True, env=environment) as parent:
        assert parent.stdout is not None
        children = [int(parent.stdout.readline()) for _ in range(2)]
        assert parent.stdout.readline() == "busy\n"
        assert all(alive(child) for child in children)
        parent.send_signal(how)
        assert all(gone(child) for child in children)


def test_in_this_process_a_task_is_done_when_it_is_given() -> None:
    here = Here()
    assert here.submit(os.getpid).result() == os.getpid()
    with pytest.raises(KeyError, match="on purpose"):
        here.submit(refuse, "on purpose").result()
    with pytest.raises(KeyboardInterrupt):
        here.submit(signal.raise_signal, signal.SIGINT)


def test_each_worker_has_a_task_and_one_waits(crew: Crew) -> None:
    assert room(Here()) == 1
    assert room(crew) == 3
