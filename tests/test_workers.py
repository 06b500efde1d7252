"""The same findings whoever does the work: any number of processes, a Dask cluster, killed and gone on with."""

from __future__ import annotations

import mmap
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import suppress
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from oracles.campaign import run_campaign
from oracles.cluster import Cluster, ClusterUnavailable
from oracles.executors import Crew, Here
from oracles.ledger import Ledger
from oracles.outcome import Run
from oracles.store import FOLDER, RecordError
from reports import html, junit, markdown, sarif, terminal
from reports.findings import bucket_views
from reports.summary import report_json
from tests.test_executors import gone
from tests.wrong_engines import Crashing, HangingFarOut, OffByAShare, Slow, spec

PAIRS = ["Sphere–Sphere"]
EXAMPLES = 25
"""Of each attack: enough to find the fault, and to shrink it."""
ROOT = Path(__file__).parents[1]


def campaign(executor: Executor | None = None, **options: Any) -> Run:
    options = {
        "engines": [spec(OffByAShare)],
        "budget": 60.0,
        "seed": 3,
        "passes": 2,
        "pairs": PAIRS,
        "examples": EXAMPLES,
    } | options
    return run_campaign(ledger=Ledger(), executor=executor, **options)


def findings(run: Run) -> list[object]:
    """Everything that may not depend on who did the work."""
    buckets = [
        (b.key, b.count, b.proven, b.worst, dict(b.regimes), b.witness.scene.id, b.witness.verdict.claim, b.repro)
        for b in run.buckets
    ]
    accuracy = run.accuracy.errors, run.accuracy.points
    return [run.digest, buckets, dict(run.counts), dict(run.hunters), run.problems, accuracy]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, Path]:
    """What an undisturbed run finds, and its folder."""
    folder = tmp_path_factory.mktemp("recorded")
    run = campaign(folder=folder)
    assert run.buckets
    assert run.problems == []
    assert run.hunters["hypothesis"] > 20
    tasks = [path.name.partition("-")[0] for path in (folder / FOLDER).iterdir()]
    assert Counter(tasks) >= Counter(bulk=2, hunt=1, shrink=1)
    return run, folder


@pytest.fixture
def undisturbed(recorded: tuple[Run, Path]) -> Run:
    return recorded[0]


@pytest.fixture
def record(recorded: tuple[Run, Path], tmp_path: Path) -> Path:
    """The undisturbed run's folder, to be changed."""
    return shutil.copytree(recorded[1], tmp_path / "record")


@pytest.fixture
def every(recorded: tuple[Run, Path]) -> int:
    """How many tasks the undisturbed run took."""
    return len(list((recorded[1] / FOLDER).iterdir()))


def test_every_report_says_where_the_time_went(undisturbed: Run) -> None:
    parts = {"scenes", f"engine {undisturbed.engines[0]}", "reference", "judge", "store"}
    assert parts <= set(undisturbed.timing)
    assert all(undisturbed.timing[part] > 0 for part in parts)
    printed, views = StringIO(), bucket_views(undisturbed)
    terminal.print_summary(undisturbed, Console(width=100, file=printed))
    pages = [html.render(undisturbed), markdown.render(undisturbed), report_json(undisturbed), printed.getvalue()]
    pages += [junit.render(undisturbed, views), sarif.render(undisturbed, views)]
    for page in pages:
        assert [part for part in parts if part not in page] == []


@pytest.mark.parametrize("executor", [lambda: Crew(3), lambda: ThreadPoolExecutor(2)])
def test_the_same_seed_finds_the_same_with_any_workers(undisturbed: Run, executor: Callable[[], Executor]) -> None:
    assert findings(campaign(executor())) == findings(undisturbed)


def test_another_seed_has_another_digest(undisturbed: Run) -> None:
    assert campaign(passes=1).digest != undisturbed.digest
    assert campaign(passes=1).digest == campaign(passes=1).digest != campaign(passes=1, seed=4).digest


# -- gone on with ----------------------------------------------------------------------------------------------


class Impatient:
    """Ends the run after so many tasks, as Ctrl-C does."""

    def __init__(self, tasks: int) -> None:
        self.left = tasks

    def started(self, engines: object, cells: int) -> None:
        pass

    def advanced(self, run: Run, elapsed: float) -> None:
        self.left -= 1
        if self.left <= 0:
            self.since = time.monotonic()
            raise KeyboardInterrupt


@pytest.mark.parametrize(("tasks", "executor"), [(1, Here), (3, lambda: Crew(2))])
def test_an_interrupted_run_goes_on_to_the_same_end(
    undisturbed: Run, every: int, tmp_path: Path, tasks: int, executor: Callable[[], Executor]
) -> None:
    first = campaign(executor(), folder=tmp_path, listener=Impatient(tasks))
    assert first.interrupted
    assert first.digest != undisturbed.digest
    second = campaign(executor(), folder=tmp_path, resume=True)
    assert second.recalled >= tasks
    assert findings(second) == findings(undisturbed)
    third = campaign(executor(), folder=tmp_path, resume=True)
    assert third.recalled == every
    assert findings(third) == findings(undisturbed)


def test_a_run_goes_on_beyond_its_end(undisturbed: Run, tmp_path: Path) -> None:
    first = campaign(folder=tmp_path, passes=1)
    second = campaign(folder=tmp_path, resume=True)
    assert second.recalled >= 1
    assert second.counts > first.counts
    assert findings(second) == findings(undisturbed)


def test_a_run_with_a_budget_goes_on_with_a_new_one(tmp_path: Path) -> None:
    first = campaign(folder=tmp_path, passes=None, budget=1.0)
    recorded = len(list((tmp_path / FOLDER).glob("*.parquet")))
    second = campaign(Crew(2), folder=tmp_path, passes=None, budget=1.0, resume=True)
    assert 0 < second.recalled <= recorded  # what is shrunk depends on all that was found
    assert second.counts > first.counts
    again = campaign(folder=tmp_path, passes=None, budget=1e-9, resume=True)
    assert again.recalled > recorded
    assert findings(again)[1:4] == findings(second)[1:4]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"seed": 4}, "seed was 3, is 4"),
        ({"engines": [spec(Crashing)]}, "engines was"),
        ({"pairs": ["Point–Sphere"]}, "pairs was"),
        ({"call_limit": 0.25}, "call limit was 0.5, is 0.25"),
    ],
)
def test_a_record_of_other_options_is_refused(record: Path, change: Any, named: str) -> None:
    with pytest.raises(RecordError, match=named):
        campaign(folder=record, resume=True, **change)


def test_a_damaged_file_costs_its_task_and_a_line(undisturbed: Run, every: int, record: Path) -> None:
    path = sorted((record / FOLDER).iterdir())[1]
    path.write_bytes(path.read_bytes()[:-7])
    found = campaign(folder=record, resume=True)
    assert found.recalled == every - 1
    assert [path.name in line for line in found.problems] == [True]
    assert findings(found)[:4] == findings(undisturbed)[:4]


# -- kill −9 -------------------------------------------------------------------------------------------------


def killing(processes: Callable[[], list[int]], stop: threading.Event, times: int) -> None:
    """Kill one of the processes now and then."""
    chance = random.Random(5)
    while times and not stop.wait(chance.uniform(0.2, 1.0)):
        found = processes()
        if found:
            times -= 1
            with suppress(ProcessLookupError):
                os.kill(chance.choice(found), signal.SIGKILL)


@pytest.fixture
def killer() -> Iterator[Callable[..., None]]:
    stop, threads = threading.Event(), []

    def start(processes: Callable[[], list[int]], times: int = 2) -> None:
        threads.append(threading.Thread(target=killing, args=(processes, stop, times)))
        threads[-1].start()

    yield start
    stop.set()
    for thread in threads:
        thread.join()


def below(process: int) -> list[int]:
    """Processes that this one has started, and those that they have."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == process and fields[0] != "Z":
            found += [int(entry.parent.name), *below(int(entry.parent.name))]
    return found


def test_workers_are_killed_and_nothing_is_lost(undisturbed: Run, killer: Callable[..., None]) -> None:
    crew = Crew(2)
    killer(lambda: crew.processes)
    assert findings(campaign(crew)) == findings(undisturbed)


def test_engines_are_killed_and_nothing_is_lost(killer: Callable[..., None]) -> None:
    """Both the process that holds the engine and the one that watches it."""
    crew = Crew(2)
    killer(lambda: [child for worker in crew.processes for child in below(worker)], 4)
    run = campaign(crew)
    assert run.total(engine="honest") > 0
    lost = [line for line in run.problems if "failed" in line]
    assert lost == []


START = """
from reports.cli import command

if __name__ == "__main__":
    command()
"""


def started(folder: Path, *options: str, engine: type = OffByAShare) -> subprocess.Popen[str]:
    """`proxyproof run` in a session of its own."""
    script = folder / "start.py"
    script.write_text(START)
    pairs = [word for pair in PAIRS for word in ("--pair", pair)]
    command = [
        sys.executable,
        script,
        "run",
        "--engine",
        spec(engine),
        *pairs,
        "--seed",
        "3",
        "--examples",
        str(EXAMPLES),
        *options,
    ]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "ignore"}
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=folder,
        env=environment,
        start_new_session=True,
    )


def wait_for_files(folder: Path, number: int, process: subprocess.Popen[str]) -> set[str]:
    """Names of the recorded files, once there are so many."""
    while process.poll() is None:
        found = {path.name for path in (folder / "out" / FOLDER).glob("*.parquet")}
        if len(found) >= number:
            return found
        time.sleep(0.02)
    raise AssertionError(process.communicate()[0])


@pytest.mark.parametrize("workers", ["0", "2"])
def test_the_campaign_is_killed_and_goes_on(undisturbed: Run, tmp_path: Path, workers: str) -> None:
    options = ("--passes", "2", "--workers", workers, "--out", "out")
    for files in (1, 2):
        resume = ("--resume", "out") if files > 1 else ()
        with started(tmp_path, *(options[:-2] if resume else options), *resume) as process:
            recorded = wait_for_files(tmp_path, files, process)
            children = below(process.pid)
            process.kill()
        assert children
        assert all(gone(child) for child in children)
        assert recorded <= {path.name for path in (tmp_path / "out" / FOLDER).iterdir()}
    run = campaign(folder=tmp_path / "out", resume=True)
    assert run.recalled >= len(recorded)
    assert findings(run)[:4] == findings(undisturbed)[:4]


@pytest.mark.parametrize("workers", ["0", "2"])
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_in_seconds_with_a_report(tmp_path: Path, how: signal.Signals, workers: str) -> None:
    with started(tmp_path, "--budget", "600", "--workers", workers, "--out", "out") as process:
        wait_for_files(tmp_path, 2, process)
        children, began = below(process.pid), time.monotonic()
        if how == signal.SIGINT:
            os.killpg(process.pid, how)  # as a terminal does
            time.sleep(0.1)
            os.killpg(process.pid, how)  # and once more
        else:
            process.send_signal(how)
        printed = process.communicate(timeout=30)[0]
        assert time.monotonic() - began < 10
    assert process.returncode == 130, printed
    assert (tmp_path / "out" / "index.html").read_text().endswith("</html>")
    assert "interrupted" in printed
    assert re.search(r"honest · \w+ · Sphere–Sphere", printed)
    assert "Traceback" not in printed
    assert all(gone(child) for child in children)


@pytest.mark.parametrize("workers", ["0", "2"])
def test_ctrl_c_within_a_call_that_takes_long(tmp_path: Path, workers: str) -> None:
    """An engine that sleeps for seconds, in the bulk and below Hypothesis."""
    options = ("--budget", "600", "--workers", workers, "--call-limit", "60", "--out", "out")
    with started(tmp_path, *options, engine=Slow) as process:
        while not (tmp_path / "out" / "manifest.json").exists():  # written when the engines have started
            assert process.poll() is None, process.communicate()[0]
            time.sleep(0.05)
        time.sleep(1)
        os.killpg(process.pid, signal.SIGINT)
        began = time.monotonic()
        printed = process.communicate(timeout=30)[0]
        assert time.monotonic() - began < 10
    assert process.returncode == 130, printed
    assert "interrupted" in printed


# -- a full disk -----------------------------------------------------------------------------------------------


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=128k", "tmpfs", str(place)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("may not mount a small disk here")
    yield place
    subprocess.run(["umount", str(place)], check=True)


def test_a_full_disk_ends_the_record_and_not_the_run(undisturbed: Run, small_disk: Path) -> None:
    run = campaign(Crew(2), folder=small_disk)
    assert findings(run)[:4] == findings(undisturbed)[:4]
    assert len(run.problems) == 1
    assert re.search("the record ends before the run.*No space left", run.problems[0])
    assert not list((small_disk / FOLDER).glob("*.part"))
    kept = len(list((small_disk / FOLDER).glob("*.parquet")))
    assert kept > 0
    again = campaign(folder=small_disk, resume=True)
    assert again.recalled == kept
    assert findings(again)[:4] == findings(undisturbed)[:4]


def test_a_report_for_which_there_is_no_room_is_shown_all_the_same(tmp_path: Path, small_disk: Path) -> None:
    free = shutil.disk_usage(small_disk).free
    (small_disk / "ballast").write_bytes(b"x" * (free - 4 * mmap.PAGESIZE))
    with started(tmp_path, "--passes", "1", "--workers", "0", "--out", str(small_disk)) as process:
        printed = process.communicate(timeout=120)[0]
    assert process.returncode == 1, printed
    assert "the report is not written" in printed
    assert "the record ends before the run" in printed
    assert re.search(r"honest · \w+ · Sphere–Sphere", printed)


# -- Dask ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as found:
        yield found


@pytest.mark.filterwarnings("default")
def test_a_dask_cluster_of_which_a_worker_is_killed(
    undisturbed: Run, cluster: Any, killer: Callable[..., None]
) -> None:
    def workers() -> list[int]:
        return [nanny.pid for nanny in cluster.workers.values() if nanny.pid]

    assert len(workers()) == 2
    before = workers()
    killer(workers, 1)
    run = campaign(Cluster(cluster.scheduler_address))
    assert findings(run) == findings(undisturbed)
    assert workers() != before


@pytest.mark.filterwarnings("default")
def test_a_dask_cluster_is_left_as_it_was(cluster: Any) -> None:
    impatient = Impatient(2)
    run = campaign(Cluster(cluster.scheduler_address), passes=None, budget=600.0, listener=impatient)
    assert time.monotonic() - impatient.since < 20
    assert run.interrupted
    assert run.buckets
    for nanny in cluster.workers.values():
        engines = [p for p in below(nanny.pid) if b"oracles.isolation" in Path(f"/proc/{p}/cmdline").read_bytes()]
        assert all(gone(process, within=30.0) for process in engines)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x", "", "127.0.0.1:notaport"])
@pytest.mark.filterwarnings("default")
def test_no_cluster_is_one_clear_line(monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("oracles.cluster.CONNECT_LIMIT", 1.0)
    with pytest.raises(ClusterUnavailable, match=r"^no Dask scheduler answers at") as refused:
        Cluster(address)
    assert "\n" not in str(refused.value)


def test_slow_and_lost_engines_do_not_hold_a_crew_up() -> None:
    run = campaign(Crew(2), engines=[spec(HangingFarOut)], passes=1, call_limit=0.05)
    assert {bucket.symptom for bucket in run.buckets} == {"no answer in time"}
    assert run.problems == []
