"""The child that answers for an engine (`oracles.isolation.children`). It imports little but what its maker does."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

from oracles.isolation.processes import accept_limits, end_with

LONGEST = 500
"""Characters of a reason."""

Answerer = Callable[[Any], Any]
"""Answers one question; whatever it raises is its answer, too."""


def serve() -> None:
    """Be the child: answer the questions on standard input; what the engine prints goes elsewhere.

    It ends with its parent, even if it hangs by then, and gets no more memory than its parent says.
    """
    end_with(int(sys.argv[4]))
    accept_limits(int(sys.argv[5]))
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    answerer = _made(*sys.argv[2:4])
    print("ready", file=out, flush=True)
    for line in sys.stdin:
        try:
            said = {"answer": answerer(json.loads(line)), "lost": ""}
            text = json.dumps(said)
        except Exception as error:  # whatever an engine raises is its answer
            text = json.dumps({"answer": None, "lost": f"{type(error).__name__}: {error}"[:LONGEST]})
        print(text, file=out, flush=True)


def _made(maker: str, spec: str) -> Answerer:
    """Make what answers; where that fails, each question is told so."""
    module, _, function = maker.partition(":")
    try:
        return getattr(import_module(module), function)(spec)  # type: ignore[no-any-return]
    except Exception as error:
        failed = error

        def fail(_: Any) -> Any:
            raise failed

        return fail
