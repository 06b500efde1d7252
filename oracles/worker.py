"""Engines answer in another process: a crash or a hang becomes the scene's status, and the campaign goes on."""

from __future__ import annotations

import os
import sys
import weakref
from collections import Counter
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from oracles import course, motion
from oracles.engine import Answers, Array, EngineUnavailable, Kind, Status, faults
from oracles.isolation.board import NOWHERE_YET, PENDING, REMARKED, Job
from oracles.isolation.guarded import Guarded, GuardLost
from oracles.isolation.hands import Limits
from oracles.scene import IMPACT, SWEEP, Scene

BEHIND = {IMPACT: motion.WIDTH, SWEEP: course.WIDTH}
"""Numbers of the motion, that stand behind those of A."""
MEMORY_LIMIT = 2 << 30
START_LIMIT = 120.0
MOST_RESTARTS = 10
"""Guards lost in one batch after which the rest of it is skipped."""


class EngineWorker:
    """One engine in a process of its own, with limits of time and memory for each call.

    Parameters
    ----------
    engine_spec : str
        Name of a shipped engine, ``module:attribute`` or ``path/to/file.py:attribute``.
    call_limit : float
        Seconds of processor time for one scene; five times as long for one that waits. On a busy machine a slow call
        is no hang.
    memory_limit : int
        Bytes that the engine and all that it starts may use beyond what it takes once it is imported.
    start_limit : float
        Seconds until the engine must be imported.

    Attributes
    ----------
    incidents : Counter of str
        What happened to the engine's process besides what each scene's text tells, in sentences, and how often.
    effort : (int, float)
        How many scenes of the last batch were asked to the end, and the seconds of processor time that the engine and
        its adapter took for them: all that guards them is left out.

    Raises
    ------
    EngineUnavailable
        When the engine cannot be started, or its adapter is not sound; the text says why.

    Notes
    -----
    A scene that crashes or hangs costs its own answer only. Each gets its status, the text of what happened in
    `Answers.errors`, and a fresh process takes the next scene. Neither what the engine prints nor Ctrl-C
    gets through: the process has no terminal. What the engine starts ends with it. Whichever process is killed
    (`oracles.isolation` lists them), what was answered before is kept, and the rest asked again; a scene at which the
    guard was lost twice counts as crashed. Use as a context manager, or `close`.

    There is no defence against an engine that means harm and has the user's rights: it may kill or write whatever
    the user may.
    """

    def __init__(
        self,
        engine_spec: str,
        call_limit: float = 1.0,
        *,
        memory_limit: int = MEMORY_LIMIT,
        start_limit: float = START_LIMIT,
    ) -> None:
        if not hasattr(os, "fork"):
            raise EngineUnavailable(f"engines are run in forked processes, which {sys.platform} does not have")
        for name, value in (("call_limit", call_limit), ("memory_limit", memory_limit), ("start_limit", start_limit)):
            if not 0 < value < float("inf"):
                raise ValueError(f"{name} must be a positive number, got {value!r}")
        self.engine_spec = engine_spec
        self.incidents: Counter[str] = Counter()
        self.effort = (0, 0.0)
        self._job: Job | None = None
        self._renewed = False
        self._careful: Counter[tuple[str, Kind, Kind]] = Counter()
        self._guarded = Guarded(engine_spec, Limits(call_limit, memory_limit, start_limit))
        self._end = weakref.finalize(self, self._guarded.end)
        try:
            self._guarded.start()
        except BaseException:
            self._end()
            raise

    def answer(
        self,
        query: str,
        A: Kind,
        B: Kind,
        rows_a: ArrayLike,
        rows_b: ArrayLike,
        *,
        groups: ArrayLike | None = None,
        give_up_after: int | None = None,
    ) -> Answers:
        """Have a batch of scenes of one cell answered.

        Parameters
        ----------
        rows_a, rows_b : (n, width)
            Packed proxies; of impacts and sweeps, the motion's numbers behind A's.
        groups : (n,) of int, optional
            Label of each scene's group; all one group by default.
        give_up_after : int, optional
            Skip what is left of a group in this batch after so many time-outs.
        """
        self.submit(query, A, B, rows_a, rows_b, groups=groups, give_up_after=give_up_after)
        return self.result()

    def ask(self, scene: Scene) -> Answers:
        """Have one scene answered."""
        rows = (row[None] for row in scene.rows)
        return self.answer(scene.query, type(scene.a), type(scene.b), *rows)

    def submit(
        self,
        query: str,
        A: Kind,
        B: Kind,
        rows_a: ArrayLike,
        rows_b: ArrayLike,
        *,
        groups: ArrayLike | None = None,
        give_up_after: int | None = None,
    ) -> None:
        """Start on a batch, as `answer` does, and return at once; `result` waits for it."""
        a = _rows(A, rows_a, "rows_a", BEHIND.get(query, 0))
        b = _rows(B, rows_b, "rows_b")
        labels = np.zeros(len(a), np.int64) if groups is None else np.asarray(groups).astype(np.int64)
        if not len(a) == len(b) == len(labels) or labels.ndim != 1:
            raise ValueError(f"one group and one row of each side per scene, got {len(a)}, {len(b)}, {labels.shape}")
        if self._job is not None:
            raise RuntimeError("the worker is at work on another batch: take its result first")
        if not self._end.alive:
            raise EngineUnavailable(f"the worker of {self.engine_spec} is closed")
        self._job = Job(query, A, B, len(a), a.shape[1], b.shape[1], give_up_after, self._renewed)
        self._renewed = False
        self._guarded.board.fill(a, b, labels, self._careful[query, A, B])
        self._guarded.ask(self._job)

    def result(self) -> Answers:
        """Wait for the batch that was submitted."""
        if self._job is None:
            raise RuntimeError("nothing was submitted")
        job, self._job = self._job, None
        lost_at: Counter[int] = Counter()
        while True:
            try:
                self.incidents.update(self._guarded.listen())
                break
            except GuardLost as how:
                self._restart(job, str(how), lost_at)
        return self._answers(job)

    def _answers(self, job: Job) -> Answers:
        """Read the board; an answer that says less than the engine promised is none."""
        board = self._guarded.board
        self._careful[job.query, job.A, job.B] = board.still_careful()
        self.effort = int(board.asked[0]), float(board.spent[0]) * 1e-9
        status, table, texts = board.results()
        for i, text in faults(job.query, board.promised(), table).items():
            if status[i] == Status.ANSWERED:
                status[i], table[i], texts[i] = Status.ERROR, np.nan, text
        for i, text in texts.items():
            if status[i] in (Status.ANSWERED, Status.SKIPPED):
                self.incidents[f"{text}: {in_words(job)}"] += 1
        return Answers.from_table(status, table, texts)

    def _restart(self, job: Job, how: str, lost_at: Counter[int]) -> None:
        """Start a new guard for the rest of a batch; where the last two were lost at one scene, without that."""
        if self._guarded.leaving:
            raise EngineUnavailable(f"the worker of {self.engine_spec} was interrupted: {how}")
        board = self._guarded.board
        at = int(board.at[0])
        lost_at[at] += 1
        self.incidents[f"{how}, and was started again: {in_words(job)}"] += 1
        if lost_at[at] > 1 and 0 <= at < job.size and board.status[at] == PENDING:
            board.pin(at, Status.CRASHED, f"{how}, twice at this scene")
        if lost_at.total() > MOST_RESTARTS:
            for i in board.pending().tolist():
                board.pin(i, Status.SKIPPED + REMARKED, f"not asked: {how}, for the {lost_at.total()}th time")
        board.at[0] = NOWHERE_YET
        self._guarded.start()
        self._guarded.ask(job)

    def renew(self) -> None:
        """Have the next batch answered by a fresh process, in which the engine was asked nothing before."""
        self._renewed = True

    def take_incidents(self) -> Counter[str]:
        """Return `incidents`, and begin a new list."""
        taken, self.incidents = self.incidents, Counter()
        return taken

    @property
    def process_id(self) -> int:
        """The guard's process, above those that hold the engine."""
        assert self._guarded.process is not None
        return self._guarded.process.pid

    def interrupt(self) -> None:
        """End the worker's processes at once; from any thread. What waits for a result raises."""
        self._guarded.interrupt()

    def close(self) -> None:
        """End the worker's processes and wait for that; closing twice does no harm."""
        self._end()

    def __enter__(self) -> Self:
        """Return the worker."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()


def in_words(job: Job) -> str:
    """Name a job's cell."""
    return f"{job.query} {job.A.__name__}–{job.B.__name__}"


def _rows(kind: Kind, rows: ArrayLike, name: str, behind: int = 0) -> Array:
    array = np.ascontiguousarray(rows, dtype=np.float64)
    if array.ndim == 2 and kind.header:  # rows that say their own size
        return array
    if array.ndim != 2 or array.shape[1] != kind.width() + behind:
        raise ValueError(f"{name}: a {kind.__name__} is a row of {kind.width() + behind} numbers, got {array.shape}")
    return array
