"""The command line: ``proxyproof run``, what looks at a run again (``show``, ``replay``, ``check`` ...), and more.

Exit status: 0 as it should be, 1 not so (each command says what that is), 2 bad input (one line on standard error),
3 the reference was proven wrong, 130 interrupted. Commands import what they need when they run, so that help and the
table need no engine.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from reports import (
    accuracy_command,
    checking,
    comparing,
    fit_command,
    options,
    replaying,
    running,
    showing,
    text,
)
from reports.options import BadInput
from reports.running import BAD_INPUT, FINISHED, INTERRUPTED

USAGE_ERRORS: tuple[type[Exception], ...] = typer.BadParameter.__mro__[1:3]
"""What typer raises for a wrong command line: its UsageError and ClickException, which it does not export."""

app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Fuzz collision code, and prove who is wrong.",
)


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


OWN = (
    running.run,
    showing.show,
    replaying.replay,
    checking.check,
    comparing.diff,
    accuracy_command.accuracy,
    fit_command.fit,
)
"""Commands that stand in files of their own."""
for own in OWN:
    app.command()(own)


@app.command()
def table(
    markdown: Annotated[bool, typer.Option("--markdown", help="Print it as Markdown.")] = False,
) -> int:
    """Print the pair table: which algorithm answers which two types."""
    from reports import vs  # noqa: PLC0415

    print(vs.as_markdown() if markdown else vs.as_text(), end="")
    return FINISHED


@app.command()
def schema() -> int:
    """Print the JSON Schema of `report.json`."""
    from reports.summary import schema as text_of  # noqa: PLC0415

    print(text_of(), end="")
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
def touching(
    bodies: Annotated[int, typer.Option(min=2, max=5000, metavar="NUMBER", help="How many bodies to throw.")] = 400,
    seed: Annotated[
        int,
        typer.Option(
            parser=options.whole("--seed", 0, options.LARGEST_SEED),
            metavar="NUMBER",
            help="Another seed throws others.",
        ),
    ] = 0,
) -> int:
    """Throw bodies of many types into a room, and hold the pipeline of refimpl and PyBullet to proofs of who touches.

    Exit status: 0 both name the pairs that they must, up to PyBullet's margins; 1 one of them does not.
    """
    from oracles.crowds.making import thrown  # noqa: PLC0415
    from oracles.crowds.touching import compared  # noqa: PLC0415
    from oracles.engine import EngineUnavailable  # noqa: PLC0415
    from reports.crowds import as_markdown  # noqa: PLC0415

    try:
        found = compared(thrown(bodies, seed))
    except EngineUnavailable as error:
        raise BadInput(str(error)) from None
    print(as_markdown(found), end="")
    return running.INCOMPLETE if found.wrong or found.far_named else FINISHED


@app.command()
def models(
    folder: Annotated[
        Path | None,
        typer.Argument(
            parser=options.place("DIR"),
            metavar="[DIR]",
            help="Folder of meshes and URDFs. Default: PyBullet's, which takes minutes.",
        ),
    ] = None,
) -> int:
    """List the models that scenes can be made of: what each is usable as, and what keeps it from the rest."""
    from reports import models as listed  # noqa: PLC0415

    for line in listed.lines(options.library_of(folder)):
        print(line)
    return FINISHED


@app.command("hunt-mutants")
def hunt_mutants(
    name: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Wrong engines to hunt for. Default: all.")
    ] = None,
    budget: Annotated[
        float, typer.Option(parser=options.seconds("--budget"), metavar="SECONDS", help="Time to find one of them.")
    ] = 60.0,
    settle: Annotated[
        float,
        typer.Option(
            parser=options.seconds("--settle"), metavar="SECONDS", help="Time to look on after the first finding."
        ),
    ] = 5.0,
    jobs: Annotated[int, typer.Option(min=1, max=256, metavar="NUMBER", help="How many to hunt for at a time.")] = 1,
    seed: Annotated[
        int,
        typer.Option(
            parser=options.whole("--seed", 0, options.LARGEST_SEED),
            metavar="NUMBER",
            help="Another seed tries other scenes.",
        ),
    ] = 0,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the table as Markdown.")] = False,
    correct: Annotated[
        int | None,
        typer.Option(min=1, metavar="SCENES", help="Question the engine that is right instead, on so many scenes."),
    ] = None,
) -> int:
    """Test the hunter: put engines that are wrong on purpose before it, and print what it finds.

    Exit status: 0 all found, each named rightly and in at most two buckets; 1 else.
    """
    from reports import mutants  # noqa: PLC0415

    if correct is not None:
        return mutants.show_right(correct, seed)
    try:
        wanted = mutants.chosen(name or ())
    except KeyError as unknown:
        raise BadInput(f"there is no wrong engine {unknown}; there are {', '.join(mutants.names())}") from None
    return mutants.show(wanted, budget=budget, settle=settle, seed=seed, jobs=jobs, markdown=markdown)


def command() -> NoReturn:
    """Be the program: run the command line, and end with its exit status, which a second Ctrl-C does not change."""
    status = main()
    if status == INTERRUPTED:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(status)


if __name__ == "__main__":
    command()
