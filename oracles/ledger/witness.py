"""Witnesses: findings that are kept as JSON beside the ledger, to be asked again in each run.

A witness ``witnesses/ENGINE/ID.json`` is one object: ``format``, ``version`` (of the engine), ``key`` (of the bucket)
and ``finding``, as `oracles.records` writes it, with the certificate that convicts the engine. Numbers are doubles
that read back to the bit; those that are not finite are the strings "nan", "inf" and "-inf". The id is that of the
scene, a hash of its content.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from oracles.engine import NAME as ENGINE_NAME
from oracles.ledger.reading import LONGEST_PATTERN, WITNESS, LedgerError, read_file
from oracles.outcome import Finding
from oracles.records import finding_from_json, finding_to_json
from oracles.scene import Scene

FORMAT = "proxyproof-witness-1"
FOLDER = "witnesses"
LARGEST = 300_000


@dataclass(frozen=True)
class Witness:
    """One recorded failure, with the version of the engine that failed and the name of the bucket."""

    finding: Finding
    key: str
    version: str

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.finding.engine

    @property
    def scene(self) -> Scene:
        """What the engine failed on."""
        return self.finding.scene

    @property
    def id(self) -> str:
        """Hash of the scene's content."""
        return self.scene.id

    def to_text(self) -> str:
        """Return the file's text: a line for each part of the finding."""
        finding = ",\n".join(f" {_dump(name)}: {_dump(value)}" for name, value in finding_to_json(self.finding).items())
        head = {"format": FORMAT, "version": self.version, "key": self.key}
        lines = [f"{_dump(name)}: {_dump(value)}" for name, value in head.items()]
        return "{\n" + ",\n".join([*lines, '"finding": {\n' + finding + "\n}"]) + "\n}\n"


def path_of(folder: Path, engine: str, name: str) -> Path:
    """Where a witness is kept; raises `LedgerError` for names that would lead elsewhere."""
    if not ENGINE_NAME.fullmatch(engine) or not WITNESS.fullmatch(name):
        raise LedgerError(f"no witness can be kept under {engine[:80]!r} and {name[:80]!r}")
    return folder / FOLDER / engine / f"{name}.json"


def load_witness(folder: Path, engine: str, name: str) -> Witness:
    """Read one witness of a ledger in `folder`, and check its certificate.

    Raises
    ------
    LedgerError
        When it is none, that of another scene, or its certificate does not prove what it says.
    """
    path = path_of(folder, engine, name)
    data = read_file(path, LARGEST)
    try:
        found = _parsed(json.loads(data))
    except RecursionError:
        raise LedgerError(f"{path} is nested too deeply") from None
    except (ValueError, TypeError, LookupError, OverflowError, AttributeError) as error:
        raise LedgerError(f"{path} is no witness: {type(error).__name__}: {str(error)[:300]}") from None
    if found.id != name or found.engine != engine:
        raise LedgerError(f"{path} is the witness {found.id} of {found.engine[:80]!r}")
    return found


def _parsed(data: Any) -> Witness:
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT}")
    texts = [data[name] for name in ("key", "version")]
    if not all(isinstance(text, str) and len(text) <= LONGEST_PATTERN for text in texts):
        raise ValueError(f"key and version must be texts of at most {LONGEST_PATTERN} characters")
    return Witness(finding_from_json(data["finding"]), *texts)


def _dump(value: Any) -> str:
    return json.dumps(_finite(value), ensure_ascii=False, allow_nan=False)


def _finite(value: Any) -> Any:
    """Data in which numbers that are not finite are texts."""
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
