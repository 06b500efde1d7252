"""The fork server: imports the engine once, and makes hands, each as fresh as the import left it."""

from __future__ import annotations

import gc
import os
import traceback
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.reduction import recv_handle
from typing import NoReturn

from oracles.adapters import require_sound
from oracles.engine import EngineUnavailable
from oracles.engines import load_engine
from oracles.isolation.board import Board
from oracles.isolation.hand import be_the_hand, said
from oracles.isolation.processes import end_with

READY = b""
"""Anything else that the server says at first is the reason why there is no engine."""


def be_the_server(spec: str, board: Board, guard: Connection, memory_limit: int, parent: int) -> NoReturn:
    """Load the engine, say how that went, and make hands until the connection closes; never returns."""
    try:
        end_with(parent)
        _serve(spec, board, guard, memory_limit)
    except (EOFError, OSError):
        os._exit(0)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(1)


def _serve(spec: str, board: Board, guard: Connection, memory_limit: int) -> None:
    number = os.getpid()
    try:
        engine = load_engine(spec)
        engine.warm()
        require_sound(engine)
    except EngineUnavailable as error:
        refused = said_plainly(error)
    except BaseException as error:  # one's own engine may raise anything, and end only itself
        refused = f"{spec} cannot be started: {said(error)}"
    else:
        refused = ""
    if os.getpid() != number:
        os._exit(0)  # a child of a fork that returned to us as if it were its parent
    guard.send_bytes(refused.encode("utf-8", "replace"))
    gc.freeze()  # hands share these pages as long as nobody counts references in them
    while True:
        descriptor = recv_handle(guard)
        hand = os.fork()
        if not hand:
            guard.close()
            be_the_hand(engine, board, Connection(descriptor), memory_limit, number)
        os.close(descriptor)
        guard.send_bytes(str(hand).encode())
        guard.send_bytes(str(_ended(hand)).encode())


def said_plainly(error: EngineUnavailable) -> str:
    """Text of a refusal, which names the engine itself."""
    text = ""
    with suppress(Exception):
        text = str(error)
    return text[:2000] or "the engine is not available, and says no more"


def _ended(hand: int) -> int:
    """Wait for the end of a hand; its exit status, or minus the signal that ended it."""
    try:
        return os.waitstatus_to_exitcode(os.waitpid(hand, 0)[1])
    except ChildProcessError:  # the engine has told the system that it does not care for children
        return 0
