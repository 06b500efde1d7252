"""The hand: the process that calls the engine, scene by scene. It may be lost at any moment.

All that it leaves is on the board: the scene that it is at, and the answers and texts so far.
"""

from __future__ import annotations

import os
import struct
import time
import traceback
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from oracles.engine import WIDTH, Engine, Solver, Status, UnsupportedCell
from oracles.isolation.board import CAREFUL_FOR, LONGEST_TEXT, PENDING, REMARKED, Board, Job, Phase
from oracles.isolation.processes import accept_limits, end_with
from oracles.isolation.state import State

BLOCK_TIME = 0.01
"""Seconds of asking after which the state of the process is compared."""
SMALLEST_BLOCK, LARGEST_BLOCK = 16, 1024
HARD_LIMIT = 4
"""The system refuses memory beyond so many times what the guard allows, should the guard be too slow."""
ROW = struct.Struct(f"{WIDTH}d")
DONE = b"d"

Scene = tuple[int, list[float], list[float]]
"""Number of a scene, and the packed proxies as the solver takes them."""


class Worn(Exception):
    """Something was left changed that could not be set back: another hand has to go on."""


def be_the_hand(engine: Engine, board: Board, guard: Connection, memory_limit: int, parent: int) -> NoReturn:
    """Answer jobs until the connection closes; never returns."""
    try:
        _settle(memory_limit, parent)
        Hand(engine, board, guard).serve()
    except (EOFError, OSError, Worn):
        os._exit(0)
    except SystemExit as left:
        if left.code is None or isinstance(left.code, int):
            os._exit((left.code or 0) & 0xFF)
        with suppress(BaseException):
            os.write(2, str(left.code)[:LONGEST_TEXT].encode("utf-8", "replace"))
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(1)


def _settle(memory_limit: int, parent: int) -> None:
    """Take a session of one's own, whose signals reach nobody else; end with the parent; accept limits."""
    end_with(parent)
    os.setsid()
    accept_limits(HARD_LIMIT * memory_limit)


class Hand:
    """Does jobs, one after the other."""

    def __init__(self, engine: Engine, board: Board, guard: Connection) -> None:
        self.engine, self.board, self.guard = engine, board, guard
        self.solvers: dict[tuple[str, type, type], Solver] = {}
        self.state = State()
        self.block = SMALLEST_BLOCK
        self.number = os.getpid()
        self.forked: list[bool] = []
        os.register_at_fork(after_in_child=lambda: self.forked.append(True))

    def serve(self) -> NoReturn:
        """Do what the guard sends."""
        while True:
            job: Job = self.guard.recv()
            self.board.open(job.size, job.width_a, job.width_b)
            solve = self._solver(job)
            if solve is not None:
                self._answer(solve)
            os.write(self.guard.fileno(), DONE)

    def _solver(self, job: Job) -> Solver | None:
        """Make a solver, or have all scenes marked with the error."""
        board, cell = self.board, (job.query, job.A, job.B)
        board.phase[0] = Phase.MAKING
        try:
            solve = self.solvers.get(cell) or self.engine.solver(*cell)
            board.promise(self.engine.says(*cell))
        except SystemExit:
            raise
        except BaseException as error:  # whatever an engine raises is its answer
            for i in board.pending().tolist():
                board.pin(i, Status.ERROR, said(error))
            return None
        self._end_if_forked()
        self.solvers[cell] = solve
        board.phase[0] = Phase.ASKING
        return solve

    def _answer(self, solve: Solver) -> None:
        """Ask block by block; one that has left something changed is asked again, scene by scene."""
        board, pending, done = self.board, self.board.pending(), 0
        while done < len(pending):
            careful = int(board.careful[0])
            block = pending[done : done + (min(self.block, careful) if careful > 0 else self.block)]
            begin = time.perf_counter()
            if careful > 0 or len(block) == 1:
                for scene in self._scenes(block):
                    self._check_alone(solve, scene)
            elif not self._check_together(solve, block):
                continue
            done += len(block)
            self._pace(len(block), time.perf_counter() - begin)

    def _scenes(self, block: NDArray[np.intp]) -> list[Scene]:
        """Read scenes off the board."""
        board = self.board
        return list(zip(block.tolist(), board.rows_a[block].tolist(), board.rows_b[block].tolist(), strict=True))

    def _check_alone(self, solve: Solver, scene: Scene) -> None:
        """Ask a scene, and say what its call has left changed."""
        board = self.board
        changed, sound = self._asked(solve, [scene])
        if changed:
            self._remark(scene[0], changed)
        board.careful[0] = CAREFUL_FOR if changed else max(0, int(board.careful[0]) - 1)
        if not sound:
            raise Worn

    def _check_together(self, solve: Solver, block: NDArray[np.intp]) -> bool:
        """Ask a block; where it has left something changed, its answers do not count. Whether they do."""
        board = self.board
        changed, sound = self._asked(solve, self._scenes(block))
        if changed:
            board.status[block] = PENDING
            board.careful[0] = CAREFUL_FOR
        if not sound:
            raise Worn
        return not changed

    def _asked(self, solve: Solver, scenes: list[Scene]) -> tuple[list[str], bool]:
        """Ask some scenes; what they have left changed, and whether it could be set back."""
        board = self.board
        board.since[0] = scenes[0][0]
        used = time.process_time_ns()
        self._ask(solve, scenes)
        board.spent[0] += time.process_time_ns() - used
        board.asked[0] += len(scenes)
        self._end_if_forked()
        return self.state.restore()

    def _ask(self, solve: Solver, scenes: list[Scene]) -> None:
        """Ask some scenes: the inner loop of all screening, so each line of it is counted."""
        board, forked = self.board, self.forked
        memory, start, pack = board.memory, board.answers_start, ROW.pack_into
        at, status = memoryview(board.at.data), memoryview(board.status.data)
        for i, a, b in scenes:
            at[0] = i
            try:
                answer = solve(a, b)
            except SystemExit:
                raise
            except BaseException as error:  # whatever an engine raises is its answer
                fate = Status.UNSUPPORTED if isinstance(error, UnsupportedCell) else Status.ERROR
                board.pin(i, fate, said(error))
                continue
            if forked:
                os._exit(0)
            try:
                pack(memory, start + i * ROW.size, *(answer if type(answer) is tuple else numbers(answer)))
            except SystemExit:
                raise
            except BaseException:  # conversion to numbers runs code of the engine's too
                board.pin(i, Status.ERROR, described(answer))
            else:
                status[i] = 0

    def _pace(self, scenes: int, seconds: float) -> None:
        """Choose the next block so that it takes about the right time, and grows by no more than four times."""
        wanted = scenes * BLOCK_TIME / max(seconds, 1e-9)
        self.block = int(min(max(wanted, SMALLEST_BLOCK), LARGEST_BLOCK, 4 * max(scenes, SMALLEST_BLOCK)))

    def _remark(self, i: int, changed: list[str]) -> None:
        """Say what the call of a scene has left changed, whatever became of the scene."""
        said_now = f"left changed: {', '.join(changed)}"
        if self.board.status[i] == Status.ANSWERED:
            self.board.pin(i, Status.ANSWERED + REMARKED, said_now)
        else:
            self.board.write_text(i, f"{self.board.text(i)[: LONGEST_TEXT // 2]}; {said_now}")

    def _end_if_forked(self) -> None:
        """End a child of a fork that returned to us as if it were its parent."""
        if self.forked or os.getpid() != self.number:
            os._exit(0)


def numbers(answer: object) -> Sequence[float]:
    """Take an answer that is no tuple: a list or a row of an array, nothing that has to be run to be read."""
    if isinstance(answer, (tuple, list)):
        return answer
    if isinstance(answer, np.ndarray) and answer.ndim == 1:
        row: list[float] = answer.tolist()
        return row
    raise TypeError


def described(answer: object) -> str:
    """Say what an engine answered in place of numbers, in few words whatever it is."""
    try:
        if isinstance(answer, np.ndarray):
            return f"answered an array of shape {answer.shape} of {answer.dtype}"
        if isinstance(answer, (list, tuple, dict, set, str, bytes)) and len(answer) > WIDTH:
            return f"answered a {type(answer).__name__} of {len(answer)}, not {WIDTH} numbers"
        if answer is None or type(answer) in (list, tuple, dict, set, str, bytes, int, float, complex, bool):
            return f"answered {answer!r}"[:LONGEST_TEXT]
    except SystemExit:
        raise
    except BaseException as error:
        return f"answered a {type(answer).__name__} whose text cannot be had ({type(error).__name__})"[:LONGEST_TEXT]
    return f"answered a {type(answer).__name__}"[:LONGEST_TEXT]


def said(error: BaseException) -> str:
    """Type and text of an exception, cut short."""
    try:
        text = str(error)[:LONGEST_TEXT]
    except SystemExit:
        raise
    except BaseException as worse:
        text = f"(its text cannot be had: {type(worse).__name__})"
    return f"{type(error).__name__}: {text}"[:LONGEST_TEXT]
