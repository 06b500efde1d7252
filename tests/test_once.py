"""A kernel is compiled by one of many processes, and nobody waits for ever."""

from __future__ import annotations

import fcntl
import multiprocessing
import time
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from refimpl import Cylinder, Ellipsoid, compiling, distance
from refimpl.once import alone, compiled_once

FORK = multiprocessing.get_context("fork")


class Kernel:
    """Compiles as numba does: reads what is kept, or takes its time and keeps it; and those that it calls first."""

    def __init__(self, name: str, folder: Path, *called: Kernel) -> None:
        self.__name__, self.folder, self.called = name, folder, called

    def compile(self, signature: str) -> None:
        kept, log = self.folder / f"{self.__name__}.kept", self.folder / f"{self.__name__}.log"
        if not kept.exists():
            for kernel in self.called:
                kernel.compile(signature)
            time.sleep(0.2)
            kept.touch()
            with log.open("a") as lines:
                lines.write("compiled\n")


def in_processes(kernels: list[Kernel]) -> None:
    """Compile a kernel in each process, all at once."""
    ready = FORK.Barrier(len(kernels))
    processes = [FORK.Process(target=when_ready, args=(kernel, ready)) for kernel in kernels]
    for process in processes:
        process.start()
    for process in processes:
        process.join(20.0)
        assert process.exitcode == 0


def when_ready(kernel: Kernel, ready: Barrier) -> None:
    ready.wait(20.0)
    kernel.compile("f8")


def times_compiled(folder: Path, name: str) -> int:
    return len((folder / f"{name}.log").read_text().splitlines())


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")  # of its threads, which are not used here
@pytest.mark.parametrize("locked", [True, False])
def test_one_process_compiles_and_the_others_read(tmp_path: Path, locked: bool) -> None:
    deep = Kernel("deep", tmp_path)
    kernels = [Kernel(name, tmp_path, deep) for name in ("left", "right", "right")]
    for kernel in [deep, *kernels] if locked else []:
        compiled_once(kernel, tmp_path)
    in_processes(kernels)
    counts = [times_compiled(tmp_path, name) for name in ("deep", "left", "right")]
    assert (counts == [1, 1, 1]) == locked, counts


def test_a_kernel_within_its_own_compilation_does_not_wait_for_itself(tmp_path: Path) -> None:
    began = time.monotonic()
    with alone(tmp_path / "a.lock"), alone(tmp_path / "b.lock"), alone(tmp_path / "a.lock"):
        pass
    assert time.monotonic() - began < 10


def test_who_is_stopped_or_cannot_lock_holds_nobody_up(tmp_path: Path) -> None:
    passed = 0
    with (tmp_path / "a.lock").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        began = time.monotonic()
        with alone(tmp_path / "a.lock", patience=0.1):
            passed += 1
        assert time.monotonic() - began >= 0.1
    with alone(tmp_path / "a.lock" / "no folder" / "b.lock"):
        passed += 1
    assert passed == 2


def test_what_is_raised_frees_the_lock(tmp_path: Path) -> None:
    def fails(signature: Any) -> None:
        raise TypeError(signature)

    kernel = Kernel("fails", tmp_path)
    kernel.compile = fails  # type: ignore[method-assign]
    compiled_once(kernel, tmp_path)
    with pytest.raises(TypeError, match="f8"):
        kernel.compile("f8")
    (lock,) = tmp_path.glob("*.lock")
    with lock.open() as other:
        fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_compiled_kernels_are_compiled_so() -> None:
    numba: Any = pytest.importorskip("numba")
    some: npt.NDArray[np.float64] = np.arange(3.0 * compiling.WORTH_COMPILING).reshape(-1, 3)
    distance(Ellipsoid(some, [1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0]), Cylinder([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0))
    folder = compiling._cache_folder(Path(compiling.__file__).parent / "kernels", numba.__version__)
    assert any(folder.glob(f"{compiling.COMPILED}*.lock"))
