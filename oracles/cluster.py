"""A Dask cluster that does the tasks; needs the extra `dask`."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any, ParamSpec, TypeVar

from oracles.tasks import release

P = ParamSpec("P")
T = TypeVar("T")

CONNECT_LIMIT = 10.0
"""Seconds until the scheduler must have answered."""


class ClusterUnavailable(RuntimeError):
    """There is no cluster to be had; the text says why, and the way out."""


@contextmanager
def uncollected() -> Iterator[None]:
    """Collect no garbage within the block, but all of it before.

    A client that found no scheduler closes itself when it is collected. While another starts, it would wait for ever:
    both need the lock of distributed's loop.
    """
    gc.collect()
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


class Cluster(Executor):
    """Workers of a Dask cluster, each of which must have this package and the engines.

    The scheduler gives the task of a worker that is lost to another. Workers of one thread each are best: a process
    does one task at a time.

    Raises
    ------
    ClusterUnavailable
        When `distributed` is not installed, or there is no scheduler at this address, or no worker.
    """

    def __init__(self, address: str) -> None:
        try:
            distributed: Any = import_module("distributed")
        except ImportError:
            raise ClusterUnavailable("--dask needs distributed: pip install 'proxyproof[dask]'") from None
        try:
            with uncollected():
                self._client = distributed.Client(address, timeout=CONNECT_LIMIT, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            said = str(error).strip() or type(error).__name__
            raise ClusterUnavailable(f"no Dask scheduler answers at {address!r}: {said}") from None
        self.size = sum(self._client.nthreads().values())
        if not self.size:
            self._client.close()
            raise ClusterUnavailable(f"the Dask cluster at {address!r} has no workers")
        self._pool: Executor = self._client.get_executor(pure=False)

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Give a task to the cluster."""
        return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster, and leave nothing behind on it: engines end when the task at hand is done."""
        self._pool.shutdown(wait=wait and not cancel_futures)
        with suppress(OSError, RuntimeError, TimeoutError):
            self._client.run(release)
        self._client.close()
