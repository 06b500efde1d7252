"""Run a scalar kernel over a batch: by Python, or compiled by numba where that is worth it.

Compiling takes seconds, once for each machine and version; what comes out is kept in the user's cache folder. So a
few pairs are left to Python, and without numba all are. Both give the same bits: the kernels use only
operations that IEEE 754 rounds exactly (+ − × ÷ and the square root), and numba neither fuses nor reorders them.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from refimpl.once import compiled_once

COMPILED = "refimpl._compiled_kernels"
WORTH_COMPILING = 256
"""Rows of a batch from which compiling pays, even when it has to be done first."""


_in_use: set[str] = set()
_rows_ahead: ContextVar[int] = ContextVar("_rows_ahead", default=0)


@contextmanager
def batch_of(rows: int) -> Iterator[None]:
    """Tell what is called within that it works on parts of a batch of so many rows."""
    token = _rows_ahead.set(max(rows, _rows_ahead.get()))
    try:
        yield
    finally:
        _rows_ahead.reset(token)


def module_for(name: str, rows: int) -> ModuleType:
    """Give the module `refimpl.kernels.name` as it is, or compiled: when there are many rows and numba is here.

    What has been compiled once in this process serves few rows as well.
    """
    many = max(rows, _rows_ahead.get()) >= WORTH_COMPILING
    if (many or name in _in_use) and (package := _compiled_package()) is not None:
        _in_use.add(name)
        return importlib.import_module(f"{package}.{name}")
    return importlib.import_module(f"refimpl.kernels.{name}")


def is_compiled(module: ModuleType) -> bool:
    """Whether this is the compiled copy of a kernel module."""
    return module.__name__.startswith(COMPILED)


@cache
def _compiled_package() -> str | None:
    """Load the kernels a second time, under another name, so that each is compiled when it is first called."""
    if os.environ.get("PROXYPROOF_COMPILE", "1") == "0" or importlib.util.find_spec("numba") is None:
        return None
    import numba  # noqa: PLC0415  half a second that only large batches need

    sources = Path(__file__).parent / "kernels"
    config: Any = numba.config
    before = config.CACHE_DIR
    try:
        # numba looks only at a kernel's own file to tell whether its cache is stale, not at those that it calls
        kept = _cache_folder(sources, numba.__version__)
        config.CACHE_DIR = str(kept)
        spec = importlib.util.spec_from_file_location(
            COMPILED, sources / "__init__.py", submodule_search_locations=[str(sources)]
        )
        assert spec is not None
        assert spec.loader is not None
        package = importlib.util.module_from_spec(spec)
        sys.modules[COMPILED] = package
        spec.loader.exec_module(package)
        for source in sorted(sources.glob("[!_]*.py")):
            module = importlib.import_module(f"{COMPILED}.{source.stem}")
            for kernel in vars(module).values():
                if hasattr(kernel, "py_func") and kernel.__module__ == module.__name__:
                    compiled_once(kernel, kept)
    finally:
        config.CACHE_DIR = before
    return COMPILED


def _cache_folder(sources: Path, version: str) -> Path:
    """Folder for compiled kernels that is another one as soon as any of their sources changes."""
    digest = hashlib.sha256(version.encode())
    for source in sorted(sources.glob("*.py")):
        digest.update(source.read_bytes())
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "proxyproof" / f"kernels-{digest.hexdigest()[:16]}"


def numbers(rows: Any, module: ModuleType) -> Any:
    """Rows of a batch in the form that a kernel reads fastest: arrays when compiled, lists of floats when not."""
    return rows if is_compiled(module) else rows.tolist()


def buffer(size: int, module: ModuleType, whole: bool = False) -> Any:
    """Scratch space of a kernel: `size` zeros, floats or whole numbers."""
    if is_compiled(module):
        return np.zeros(size, dtype=np.int64 if whole else np.float64)
    return [0 if whole else 0.0] * size
