"""The command line: ``proxyproof run``, ``table``, ``bounces`` and ``models``.

Exit status: 0 finished and as the ledger expects, 1 incomplete or not as expected, 2 bad input (one line on standard
error), 3 the reference was proven wrong, 130 interrupted. Commands import what they need when they run, so that help
and the table need no engine.
"""

from __future__ import annotations

import math
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports import text

if TYPE_CHECKING:
    from rich.console import Console

    from oracles.ledger import Ledger
    from oracles.library import Library
    from oracles.outcome import Run

FINISHED, INCOMPLETE, BAD_INPUT, REFERENCE_WRONG, INTERRUPTED = 0, 1, 2, 3, 130
LARGEST_SEED = 2**63 - 1

USAGE_ERRORS: tuple[type[Exception], ...] = typer.BadParameter.__mro__[1:3]
"""What typer raises for a wrong command line: its UsageError and ClickException, which it does not export."""

app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Fuzz collision code, and prove who is wrong.",
)


class BadInput(Exception):
    """The command line asks for what cannot be done; the text names it, and the way out."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status; bad input ends in one line, not in a traceback."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        status = app(
            args=list(sys.argv[1:] if arguments is None else arguments), prog_name="proxyproof", standalone_mode=False
        )
        sys.stdout.flush()
    except BadInput as error:
        return _refuse(str(error))
    except USAGE_ERRORS as error:
        said = error.format_message() if hasattr(error, "format_message") else str(error)
        return _refuse(f"{said.rstrip('.')}; see proxyproof --help")
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        # the reader of a pipe has seen enough; nothing may be written at exit either
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FINISHED
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _refuse(f"standard output cannot be written: {error.strerror or error}")
    return status if isinstance(status, int) else FINISHED


def _refuse(line: str) -> int:
    print(f"proxyproof: {text.visible(line, limit=1000)}", file=sys.stderr)
    return BAD_INPUT


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415

        try:
            print(f"proxyproof {version('proxyproof')}")
        except PackageNotFoundError:
            print("proxyproof (not installed)")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def start(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Fuzz collision code, and prove who is wrong."""
    del version
    if context.invoked_subcommand is None:
        print(context.get_help())


def _seconds(option: str) -> Callable[[str], float]:
    """Make the parser of an option that takes a time."""

    def parse(said: str) -> float:
        try:
            value = float(said)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0):
            raise BadInput(f"{option} must be a positive number of seconds, got {said!s}")
        return value

    return parse


def _seed(said: str) -> int:
    try:
        value = int(said)
    except ValueError:
        value = -1
    if not 0 <= value <= LARGEST_SEED:
        raise BadInput(f"--seed must be a whole number from 0 to {LARGEST_SEED}, got {said!s}")
    return value


def _folder(said: str) -> Path:
    if not str(said).strip() or "\0" in str(said):
        raise BadInput(f"--out must name a folder, got {str(said)!r}")
    return Path(said)


def _file(option: str) -> Callable[[str], Path]:
    """Make the parser of an option that names a file."""

    def parse(said: str) -> Path:
        if not str(said).strip() or "\0" in str(said):
            raise BadInput(f"{option} must name a file, got {str(said)!r}")
        return Path(said)

    return parse


def _library(folder: str | None) -> Library:
    """Models of a user's folder, all of them read, or those that are there without one."""
    from oracles import library  # noqa: PLC0415
    from oracles.meshfiles import ModelError  # noqa: PLC0415

    if folder is None:
        return library.shipped()
    if not folder.strip() or "\0" in folder:
        raise BadInput(f"models come from a folder, got {folder!r}")
    try:
        return library.of_user(Path(folder))
    except ModelError as error:
        raise BadInput(str(error)) from None


@app.command()
def run(
    engine: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Engine to question: fcl, bullet, pybullet-defaults, or your own as module:class or file.py:class; "
            "may be repeated. Default: all installed.",
        ),
    ] = None,
    pair: Annotated[
        list[str] | None, typer.Option(metavar="A-B", help="Pair to try, as Sphere-Box; may be repeated. Default: all.")
    ] = None,
    budget: Annotated[
        float, typer.Option(parser=_seconds("--budget"), metavar="SECONDS", help="Time to spend.")
    ] = 60.0,
    seed: Annotated[int, typer.Option(parser=_seed, metavar="NUMBER", help="Another seed tries other scenes.")] = 0,
    call_limit: Annotated[
        float,
        typer.Option(
            parser=_seconds("--call-limit"),
            metavar="SECONDS",
            help="Processor time an engine has for one answer (waiting: five times that).",
        ),
    ] = 0.5,
    models: Annotated[
        str | None,
        typer.Option(metavar="DIR", help="Folder of meshes (OBJ, STL) and URDFs for scenes. Default: PyBullet's."),
    ] = None,
    ledger: Annotated[
        list[Path] | None,
        typer.Option(
            parser=_file("--ledger"),
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
    out: Annotated[Path, typer.Option(parser=_folder, metavar="DIR", help="Folder for the report.")] = Path(
        "discrepancy-report"
    ),
) -> int:
    """Question engines, prove what they get wrong, and write a report.

    Exit status: 0 finished and as the ledger expects; 1 incomplete, or with a bucket that is NEW or an entry that is
    STALE or CHANGED; 2 bad input; 3 the reference itself was proven wrong; 130 interrupted.
    """
    pairs = _pairs(pair) if pair else None
    engines = _engines(engine)
    library = _library(models)
    known = _ledger(ledger or [], update=update_ledger)

    from oracles.campaign import run_campaign  # noqa: PLC0415
    from oracles.engine import EngineUnavailable  # noqa: PLC0415
    from reports import folder, terminal  # noqa: PLC0415

    shown, progress = _consoles()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends as Ctrl-C does: with a report
    try:
        folder.prepare(out)
        with terminal.progress(progress, budget) as listener:
            found = run_campaign(
                engines,
                budget=budget,
                seed=seed,
                listener=listener,
                pairs=pairs,
                call_limit=call_limit,
                models=library,
                ledger=known,
            )
        with _undisturbed():
            folder.write(found, out)
    except (folder.FolderError, EngineUnavailable) as error:
        raise BadInput(str(error)) from None
    terminal.print_summary(found, shown)
    print(f"report: {text.visible(out / 'index.html')}, report.md, run.json and repro/")
    settled = _settle(found, known, update=update_ledger)
    return exit_status(found, settled=settled)


def _ledger(own: Sequence[Path], *, update: bool) -> Ledger:
    """Ledger of the run: the user's files, of which the last is made when it is to be written, and the shipped ones."""
    from oracles.ledger import Ledger, LedgerError  # noqa: PLC0415
    from oracles.ledger.update import require_writable  # noqa: PLC0415

    try:
        found = Ledger.load(own, create=update)
        if update:
            require_writable(found)
    except LedgerError as error:
        raise BadInput(str(error)) from None
    return found


def _settle(found: Run, ledger: Ledger, *, update: bool) -> bool:
    """Print what would have to change in the ledger, and write it if asked to; whether all is as expected then."""
    from oracles.ledger import LedgerError  # noqa: PLC0415
    from oracles.ledger.update import changes, described, write  # noqa: PLC0415

    wanted = changes(found, ledger, fill=update)
    if not wanted.files:
        return True
    try:
        print(f"\nThe ledger is not what this run found.\n\n{described(wanted)}", end="")
        if update:
            with _undisturbed():
                write(wanted)
            print(f"\nwritten: {', '.join(text.visible(path) for path in wanted.files)}, and witnesses beside")
    except LedgerError as error:
        raise BadInput(str(error)) from None
    return update


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Let a second Ctrl-C wait: what was found is being written, which takes a second."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@app.command()
def table(
    markdown: Annotated[bool, typer.Option("--markdown", help="Print it as Markdown.")] = False,
) -> int:
    """Print the pair table: which algorithm answers which two types."""
    from reports import vs  # noqa: PLC0415

    print(vs.as_markdown() if markdown else vs.as_text(), end="")
    return FINISHED


@app.command()
def bounces() -> int:
    """Measure how a ball bounces in PyBullet by default, by restitution and speed, and print it as Markdown."""
    from oracles.bounces import measured  # noqa: PLC0415
    from oracles.engine import EngineUnavailable  # noqa: PLC0415
    from reports.bounces import as_markdown  # noqa: PLC0415

    try:
        print(as_markdown(measured()), end="")
    except EngineUnavailable as error:
        raise BadInput(str(error)) from None
    return FINISHED


@app.command()
def models(
    folder: Annotated[
        str | None,
        typer.Argument(metavar="[DIR]", help="Folder of meshes and URDFs. Default: PyBullet's, which takes minutes."),
    ] = None,
) -> int:
    """List the models that scenes can be made of: what each is usable as, and what keeps it from the rest."""
    from reports import models as listed  # noqa: PLC0415

    for line in listed.lines(_library(folder)):
        print(line)
    return FINISHED


def exit_status(found: Run, *, settled: bool = True) -> int:
    """Exit status that tells what became of a run, and whether the ledger fits it; the gravest word wins."""
    if found.reference_wrong:
        return REFERENCE_WRONG
    if found.interrupted:
        return INTERRUPTED
    return INCOMPLETE if found.problems or not settled else FINISHED


def _engines(chosen: Sequence[str] | None) -> list[str]:
    """Engines to question: those asked for, which must load, or all that are installed."""
    from oracles.engine import EngineUnavailable  # noqa: PLC0415
    from oracles.engines import available_engines, load_engine  # noqa: PLC0415

    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())  # an engine of the user's own stands in the folder that he is in
    if not chosen:
        installed = [name for name, missing in available_engines().items() if missing is None]
        if not installed:
            raise BadInput("no engine is installed: pip install python-fcl pybullet (the extra 'engines')")
        return installed
    for name in dict.fromkeys(chosen):
        try:
            load_engine(name)
        except EngineUnavailable as error:
            raise BadInput(str(error)) from None
        except Exception as error:
            # a module of the user's own may raise anything while it is imported
            raise BadInput(f"--engine {name!r} cannot be loaded: {type(error).__name__}: {error}") from error
    return list(dict.fromkeys(chosen))


def _pairs(chosen: Sequence[str]) -> list[str]:
    """Names of pairs as the table has them, from any dash, any case and either order."""
    from oracles.scene import TYPES, cells  # noqa: PLC0415

    known = {tuple(cell.pair.casefold().split("–")): cell.pair for cell in cells()}
    found = []
    for name in chosen:
        parts = tuple(part.strip().casefold() for part in re.split("[-–—]", name))
        match = known.get(parts) or known.get(parts[::-1])
        if match is None:
            types = ", ".join(TYPES)
            raise BadInput(
                f"--pair {name!r} is not in the pair table: write A-B with two of {types}; see proxyproof table"
            )
        found.append(match)
    return list(dict.fromkeys(found))


def _consoles() -> tuple[Console, Console]:
    """Console for the summary, on standard output, and for the progress, on standard error."""
    from rich.console import Console  # noqa: PLC0415

    from reports.terminal import PLAIN_WIDTH  # noqa: PLC0415

    def console(stream: Any) -> Console:
        return Console(file=stream, width=None if stream.isatty() else PLAIN_WIDTH, highlight=False)

    return console(sys.stdout), console(sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
