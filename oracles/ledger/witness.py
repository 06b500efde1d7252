"""Witnesses: findings that are kept as JSON beside the ledger, to be asked again in each run.

A witness ``witnesses/ENGINE/ID.json`` is one object: ``format``, ``version`` (of the engine), ``key`` (of the bucket)
and ``finding``, as `oracles.records` writes it, with the certificate that convicts the engine. Numbers are doubles
that read back to the bit; those that are not finite are the strings "nan", "inf" and "-inf". The id is that of the
scene, a hash of its content. In place of the finding there may be a ``case`` of a survey, whose answer is judged anew
when it is read, or a ``crowd`` with the certificate of the pair that a broad phase has missed.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from oracles.engine import NAME as ENGINE_NAME
from oracles.ledger.reading import LONGEST_PATTERN, WITNESS, LedgerError, read_file
from oracles.ledger.studies import CaseWitness, CrowdWitness, study_from_json
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

    def parts(self) -> dict[str, Any]:
        """What its file holds of it."""
        return {"finding": finding_to_json(self.finding)}


AnyWitness = Witness | CaseWitness | CrowdWitness


def text_of(witness: AnyWitness) -> str:
    """Return the file's text: a line for each part of what was found."""
    head = {"format": FORMAT, "version": witness.version, "key": witness.key}
    lines = []
    for name, value in (head | witness.parts()).items():
        if isinstance(value, dict):
            inner = ",\n".join(f" {_dump(part)}: {_dump(of)}" for part, of in value.items())
            lines.append(f"{_dump(name)}: {{\n{inner}\n}}")
        else:
            lines.append(f"{_dump(name)}: {_dump(value)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def path_of(folder: Path, engine: str, name: str) -> Path:
    """Where a witness is kept; raises `LedgerError` for names that would lead elsewhere."""
    if not ENGINE_NAME.fullmatch(engine) or not WITNESS.fullmatch(name):
        raise LedgerError(f"no witness can be kept under {engine[:80]!r} and {name[:80]!r}")
    return folder / FOLDER / engine / f"{name}.json"


def load_witness(folder: Path, engine: str, name: str) -> AnyWitness:
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


def _parsed(data: Any) -> AnyWitness:
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT}")
    texts = [data[name] for name in ("key", "version")]
    if not all(isinstance(text, str) and len(text) <= LONGEST_PATTERN for text in texts):
        raise ValueError(f"key and version must be texts of at most {LONGEST_PATTERN} characters")
    if "finding" not in data:
        return study_from_json(data, texts[1])
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
