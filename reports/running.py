"""``proxyproof run``: a campaign from its options to its report."""

from __future__ import annotations

import os
import sys
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports import ledgers, options, text
from reports.options import MOST_EXAMPLES, MOST_PASSES, MOST_WORKERS, BadInput

if TYPE_CHECKING:
    from oracles.outcome import Run

FINISHED, INCOMPLETE, BAD_INPUT, REFERENCE_WRONG, INTERRUPTED = 0, 1, 2, 3, 130
BUDGET, SEED, CALL_LIMIT, EXAMPLES = 60.0, 0, 0.5, 150
OUT = Path("discrepancy-report")
BESIDE = ("report.md", "report.json", "junit.xml", "report.sarif", "accuracy.csv", "repro/", "issues/", "pictures/")


def run(
    engine: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Engine to question: fcl, bullet, pybullet-defaults, bullet-stepping, bullet-ccd, pymunk, or your own "
            "as module:class or file.py:class; may be repeated. Default: all installed.",
        ),
    ] = None,
    pair: Annotated[
        list[str] | None, typer.Option(metavar="A-B", help="Pair to try, as Sphere-Box; may be repeated. Default: all.")
    ] = None,
    budget: Annotated[
        float | None,
        typer.Option(
            parser=options.seconds("--budget"), metavar="SECONDS", help=f"Time to spend. Default: {BUDGET:g}."
        ),
    ] = None,
    passes: Annotated[
        int | None,
        typer.Option(
            parser=options.whole("--passes", 1, MOST_PASSES),
            metavar="NUMBER",
            help="Passes over all pairs, instead of a time: the same seed then finds the same.",
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            parser=options.whole("--seed", 0, options.LARGEST_SEED),
            metavar="NUMBER",
            help=f"Another seed tries other scenes. Default: {SEED}.",
        ),
    ] = None,
    call_limit: Annotated[
        float | None,
        typer.Option(
            parser=options.seconds("--call-limit"),
            metavar="SECONDS",
            help=f"Processor time an engine has for one answer (waiting: five times that). Default: {CALL_LIMIT:g}.",
        ),
    ] = None,
    models: Annotated[
        Path | None,
        typer.Option(
            parser=options.place("--models"),
            metavar="DIR",
            help="Folder of meshes (OBJ, STL) and URDFs for scenes. Default: PyBullet's.",
        ),
    ] = None,
    examples: Annotated[
        int | None,
        typer.Option(
            parser=options.whole("--examples", 1, MOST_EXAMPLES),
            metavar="NUMBER",
            help=f"Scenes that each attack of Hypothesis generates. Default: {EXAMPLES}.",
        ),
    ] = None,
    database: Annotated[
        Path | None,
        typer.Option(
            parser=options.place("--database"),
            metavar="DIR",
            help="Folder in which Hypothesis keeps what fails, to try it first the next time. Default: none; the seed "
            "says it all.",
        ),
    ] = None,
    ledger: Annotated[
        list[Path] | None,
        typer.Option(
            parser=options.place("--ledger", "file"),
            metavar="FILE",
            help="Ledger of known faults of your own, beside the shipped one; may be repeated.",
        ),
    ] = None,
    update_ledger: Annotated[
        bool,
        typer.Option(
            "--update-ledger",
            help="Write what is NEW, STALE or CHANGED, and witnesses of entries without any, to the last FILE, "
            "or to the shipped ledger.",
        ),
    ] = False,
    workers: Annotated[
        int | None,
        typer.Option(
            parser=options.whole("--workers", 0, MOST_WORKERS),
            metavar="NUMBER",
            help="Processes that share the work; 0 does it all in this one. Default: one for each processor.",
        ),
    ] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster that does the work instead.")
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(
            parser=options.place("--resume"),
            metavar="DIR",
            help="Go on where the run in this folder ended, with its options; --budget counts anew.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            parser=options.place("--out"), metavar="DIR", help=f"Folder for report and record. Default: {OUT}."
        ),
    ] = None,
) -> int:
    """Question engines, prove what they get wrong, and write a report.

    Exit status: 0 finished and as the ledger expects; 1 incomplete, or with a bucket that is NEW, an entry that is
    STALE or CHANGED; 2 bad input; 3 the reference itself was proven wrong; 130
    interrupted.
    """
    asked = _Asked(engine, pair, budget, passes, seed, call_limit, models, examples, database)
    if resume is not None:
        asked.fill_in(resume)
        if out not in (None, resume):
            raise BadInput(f"--resume goes on in its own folder: leave out --out {str(out)!r}")
    question = asked.question()
    question["ledger"] = ledgers.load(ledger or [], question["engines"], update=update_ledger)
    found = _campaign(question, lambda: _executor(workers, dask), resume or out or OUT, resume=resume is not None)
    return exit_status(found, settled=ledgers.settle(found, question["ledger"], update=update_ledger))


@dataclass
class _Asked:
    """What the command line says; None where it leaves the choice to the default, or to the run that is resumed."""

    engine: list[str] | None
    pair: list[str] | None
    budget: float | None
    passes: int | None
    seed: int | None
    call_limit: float | None
    models: Path | None
    examples: int | None
    database: Path | None

    def fill_in(self, folder: Path) -> None:
        """Take what is left open from the record of a run, of which nothing is executed."""
        from oracles.engines import SHIPPED  # noqa: PLC0415
        from oracles.store import RecordError, read_manifest  # noqa: PLC0415

        try:
            old = read_manifest(folder)
            if not self.engine:
                foreign = [name for name in old["engines"] if name not in SHIPPED]
                if foreign:
                    raise BadInput(f"the run is of an engine of one's own: name it again with --engine {foreign[0]}")
                self.engine = [str(name) for name in old["engines"]]
            self.pair = self.pair or [str(name) for name in old["pairs"]]
            self.seed = int(old["seed"]) if self.seed is None else self.seed
            self.call_limit = float(old["call limit"]) if self.call_limit is None else self.call_limit
            self.examples = int(old["examples"]) if self.examples is None else self.examples
            self.models = Path(old["models"]) if self.models is None and old["models"] is not None else self.models
            if self.database is None and old.get("database") is not None:
                self.database = Path(old["database"])
            if self.budget is None and self.passes is None:
                self.budget, self.passes = old["work"]["budget"], old["work"]["passes"]
        except RecordError as error:
            raise BadInput(str(error)) from None
        except (LookupError, TypeError, ValueError) as error:
            raise BadInput(f"{folder / 'manifest.json'} is damaged: {error!r}") from None

    def question(self) -> dict[str, Any]:
        """Return what the campaign is asked."""
        return {
            "engines": options.engines(self.engine),
            "pairs": options.pairs(self.pair) if self.pair else None,
            "budget": BUDGET if self.budget is None else self.budget,
            "passes": self.passes,
            "seed": SEED if self.seed is None else self.seed,
            "call_limit": CALL_LIMIT if self.call_limit is None else self.call_limit,
            "models": None if self.models is None else str(self.models),
            "examples": EXAMPLES if self.examples is None else self.examples,
            "database": None if self.database is None else _made(self.database),
        }


def _made(folder: Path) -> str:
    """Path of a folder that is there from now on."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"--database {text.visible(folder)}: {error.strerror}") from None
    return str(folder.resolve())


def _executor(workers: int | None, dask: str | None) -> Executor:
    """What does the tasks."""
    from oracles.cluster import Cluster  # noqa: PLC0415
    from oracles.executors import Crew, Here  # noqa: PLC0415

    if dask is not None:
        return Cluster(dask)
    number = len(os.sched_getaffinity(0)) if workers is None else workers
    return Crew(number) if number else Here()


def _campaign(question: dict[str, Any], executor: Any, out: Path, *, resume: bool) -> Run:
    """Run it, write its report, and say what came of it."""
    from oracles.campaign import run_campaign  # noqa: PLC0415
    from oracles.cluster import ClusterUnavailable  # noqa: PLC0415
    from oracles.engine import EngineUnavailable  # noqa: PLC0415
    from oracles.interrupts import ignored, one_stop  # noqa: PLC0415
    from oracles.meshfiles import ModelError  # noqa: PLC0415
    from oracles.store import RecordError  # noqa: PLC0415
    from reports import folder, step_summary, terminal  # noqa: PLC0415
    from reports.console import console  # noqa: PLC0415

    shown, progress = console(), console(sys.stderr)
    budget = None if question["passes"] else question["budget"]
    try:
        folder.prepare(out)
        with one_stop(), terminal.progress(progress, budget) as listener:
            found = run_campaign(**question, listener=listener, executor=executor(), folder=out, resume=resume)
    except (folder.FolderError, EngineUnavailable, ModelError, RecordError, ClusterUnavailable) as error:
        raise BadInput(str(error)) from None
    written = f"report: {text.visible(out / 'index.html')}, and beside it {', '.join(BESIDE)}"
    with ignored():
        try:
            folder.write(found, out)
        except folder.FolderError as error:  # a full disk: what was found is shown all the same
            found.problems.append(f"the report is not written: {error}")
            written = ""
        if failed := step_summary.append(found):
            print(f"proxyproof: {text.visible(failed)}", file=sys.stderr)
    terminal.print_summary(found, shown)
    if written:
        print(written)
    return found


def exit_status(found: Run, *, settled: bool = True) -> int:
    """Exit status that tells what became of a run, and whether the ledger fits it; the gravest word wins."""
    if found.reference_wrong:
        return REFERENCE_WRONG
    if found.interrupted:
        return INTERRUPTED
    return INCOMPLETE if found.problems or broken(found) or not settled else FINISHED


def broken(found: Run) -> bool:
    """Whether a survey or a crowd shows what no ledger can list: of the reference, or without a witness."""
    from oracles.fault import BROAD_PHASE, survey_query  # noqa: PLC0415
    from oracles.ledger.studies import failed_in  # noqa: PLC0415

    shown = {(one.engine, one.query, one.pair) for one in failed_in(found) if not one.entry}
    failed = {(c.engine, survey_query(c.survey), c.question) for c in found.surveys if c.failed}
    crowds = {c.engine for c in found.crowds if c.wrong} - {
        engine for engine, query, _ in shown if query == BROAD_PHASE
    }
    return bool(failed - shown or crowds)
