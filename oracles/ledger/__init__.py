"""The ledger: what is known of the engines' faults, with a cause each, and witnesses that show it anew in each run.

An entry says which findings have its cause, in which versions of the engine; what no entry covers is NEW. Its witnesses
are scenes on which the engine failed, kept with what it said and what proves it wrong. They are replayed first in each
run, so that it does not hang on luck whether a fault shows, nor whether one that is gone is noticed.

`entry` is what an entry says, `files` reads ledgers of strangers, `witness` keeps witnesses, `replay` asks them
again, `states` is what a run makes of an entry, and `update` writes what has changed.
"""

from oracles.ledger.entry import Entry, FirstSeen
from oracles.ledger.files import Ledger, LedgerError
from oracles.ledger.states import settle
from oracles.ledger.witness import Witness

__all__ = ["Entry", "FirstSeen", "Ledger", "LedgerError", "Witness", "settle"]
