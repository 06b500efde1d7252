"""The guard: does jobs with hands that may be lost, and puts down what became of each scene. Run by the worker.

A loss is blamed on the scene that was being asked. But a call may have left something behind that only the calls
after it die of; so where other scenes were asked since the hand last made sure of its state, all of them are asked
again one by one by a fresh hand, and the loss counts there where it happens again.
"""

from __future__ import annotations

import json
import os
import signal
import time
from multiprocessing.connection import Connection

import numpy as np
from numpy.typing import NDArray

from oracles.engine import Status
from oracles.isolation.board import ASKABLE, CAREFUL_FOR, PENDING, REMARKED, Board, Job, Phase
from oracles.isolation.hands import LOOK, Hands, Limits, NoEngine, ParentLeft
from oracles.isolation.lookout import Fate
from oracles.isolation.processes import adopt_orphans

MOST_STARTS = 10
"""In one batch; an engine that brings down the process that imported it is imported no more often."""
MOST_STUCK = 3
"""Hands that may end in turn without any scene to blame or any answer."""


class Guard:
    """Does what the parent sends."""

    def __init__(self, hands: Hands, board: Board, parent: Connection) -> None:
        self.hands, self.board, self.parent = hands, board, parent
        self.incidents: list[str] = []
        self.next_look = 0.0
        self.doubts: list[tuple[int, int, Fate]] = []
        """Losses that may be those of a scene before: the first it may be, the one it happened at."""

    def serve(self) -> None:
        """Import the engine, say how that went, and do jobs until the parent closes the connection."""
        try:
            self.hands.start()
            self._tell(None)
            while True:
                self._do(self._next())
                self._inspect()
                self._tell(None)
        except NoEngine as refused:
            self._tell(str(refused))
        except (EOFError, OSError, ParentLeft):
            pass
        finally:
            self.hands.end()

    def _tell(self, refused: str | None) -> None:
        self.parent.send_bytes(json.dumps({"refused": refused, "incidents": self.incidents}).encode())
        self.incidents = []

    def _next(self) -> Job:
        """Wait for a job, and see to it that the hand is quiet meanwhile."""
        while not self.hands.idle():
            self._inspect()
        job: Job = self.parent.recv()
        return job

    def _inspect(self) -> None:
        """End a hand that has left something going, though it has nothing to do."""
        if time.monotonic() < self.next_look:
            return
        left = self.hands.left_behind()
        if left:
            self.incidents.append(left)
            self.hands.dismiss()
        self.next_look = time.monotonic() + LOOK

    def _do(self, job: Job) -> None:
        """Have all scenes of a job answered, with as many hands as it takes."""
        board, first, stuck = self.board, self.hands.starts, 0
        board.open(job.size, job.width_a, job.width_b)
        if job.renewed:
            self.hands.dismiss()
        while len(pending := board.pending()):
            if self.hands.starts > first + MOST_STARTS:
                self._skip(pending)
                break
            board.phase[0] = Phase.WAITING
            fate = self.hands.give(job)
            if fate is not None and self._blame(fate):
                stuck = 0
            elif len(board.pending()) == len(pending):
                stuck += 1
            if stuck >= MOST_STUCK:
                board.pin(int(pending[0]), Status.CRASHED, fate.text if fate else "the process does not do its work")
            if fate is not None and fate.status == Status.TIMED_OUT and job.give_up_after is not None:
                self._give_up(job.give_up_after)
        self._settle_doubts()
        self.hands.rest()

    def _blame(self, fate: Fate) -> bool:
        """Put a loss down to its scene; answer whether there was one."""
        board, at, since = self.board, int(self.board.at[0]), int(self.board.since[0])
        pending = board.pending()
        if board.phase[0] == Phase.MAKING:
            for i in pending.tolist():
                board.pin(i, fate.status, fate.text)
            return True
        if board.phase[0] == Phase.WAITING or at not in pending:
            return False
        if 0 <= since < at:
            board.ask_again(since, at)
            board.careful[0] = CAREFUL_FOR
        if fate.status == Status.TIMED_OUT or since == at:
            board.pin(at, fate.status, fate.text)
        else:
            self.doubts.append((since, at, fate))
        return True

    def _settle_doubts(self) -> None:
        """Where a loss did not happen again, it stays that of its scene, unless a scene before it explains it."""
        status = self.board.status
        for since, at, fate in self.doubts:
            if status[at] & ~REMARKED in ASKABLE:
                before = status[since:at]
                if ((before >= REMARKED) | (before == Status.CRASHED) | (before == Status.TIMED_OUT)).any():
                    self.incidents.append(f"{fate.text}; not in the scene's own call, which a fresh process answers")
                else:
                    self.board.pin(at, fate.status, fate.text + "; not again in a fresh process")
        self.doubts = []

    def _give_up(self, after: int) -> None:
        """Skip what is left of groups with so many time-outs; not what is behind, which is only asked again."""
        board, left = self.board, slice(int(self.board.at[0]) + 1, None)
        groups, counts = np.unique(board.groups[board.status == Status.TIMED_OUT], return_counts=True)
        lost = np.isin(board.groups[left], groups[counts >= after])
        board.status[left][lost & (board.status[left] == PENDING)] = Status.SKIPPED

    def _skip(self, pending: NDArray[np.intp]) -> None:
        for i in pending.tolist():
            text = f"not asked: the process that had imported the engine was lost {MOST_STARTS} times in this batch"
            self.board.pin(i, Status.SKIPPED + REMARKED, text)


def main(descriptor: int, memory: int, spec: str, limits: Limits) -> None:
    """Be the guard of an engine; run in a process of its own."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    adopt_orphans()
    parent, board = Connection(descriptor), Board(memory)
    Guard(Hands(spec, limits, board, parent), board, parent).serve()
    os._exit(0)  # there is nothing to tidy up, and Python takes its time over it
