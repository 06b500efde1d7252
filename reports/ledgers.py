"""The ledger on the command line: loading it before a run, and saying or writing what the run would change in it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from reports import text
from reports.options import BadInput

if TYPE_CHECKING:
    from oracles.ledger import Ledger
    from oracles.ledger.writing import Changes
    from oracles.outcome import Run


def load(own: Sequence[Path], engines: Sequence[str], *, update: bool) -> Ledger:
    """Ledger of the run: the user's files, of which the last is made when it is to be written, and the shipped ones."""
    from oracles.ledger import Ledger, LedgerError  # noqa: PLC0415
    from oracles.ledger.writing import require_writable  # noqa: PLC0415

    foreign = [name for name in engines if ":" in name]
    if update and foreign and not own:
        raise BadInput(
            f"--update-ledger needs --ledger FILE: {foreign[0]} is none of the engines of the shipped ledger"
        )
    try:
        found = Ledger.load(own, create=update)
        if update:
            require_writable(found)
    except LedgerError as error:
        raise BadInput(str(error)) from None
    return found


def settle(found: Run, ledger: Ledger, *, update: bool) -> bool:
    """Print what would have to change in the ledger, and write it if asked to; whether all is as expected then."""
    from oracles.interrupts import ignored  # noqa: PLC0415
    from oracles.ledger import LedgerError  # noqa: PLC0415
    from oracles.ledger.update import changes  # noqa: PLC0415
    from oracles.ledger.writing import described, write  # noqa: PLC0415

    wanted = changes(found, ledger, fill=update)
    if not wanted.files:
        return True
    try:
        print(
            f"\nThe ledger is not what this run found{'' if update else _way_out(wanted)}.\n\n{described(wanted)}",
            end="",
        )
        if update:
            with ignored():
                write(wanted)
            print(f"\nwritten: {', '.join(text.visible(path) for path in wanted.files)}, and witnesses beside")
    except LedgerError as error:
        raise BadInput(str(error)) from None
    return update


def _way_out(wanted: Changes) -> str:
    """Options with which the same run would write what it prints."""
    from oracles.ledger.files import SHIPPED  # noqa: PLC0415

    *_, last = wanted.files
    named = "" if last.parent == SHIPPED else f"--ledger {text.visible(last)} "
    return f"; {named}--update-ledger writes this, and the witnesses"
