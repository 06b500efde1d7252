"""Witnesses: scenes on which an engine failed, kept as JSON beside the ledger.

A witness ``witnesses/ENGINE/ID.json`` is one object: ``format``, ``engine``, ``version`` (the engine's), ``key`` (of
the bucket), ``symptom``, ``amount``, ``lower``, ``upper``, ``claim``, ``answer`` (what the engine said, by name),
``text`` (its last words, where it gave no answer), ``scene``, ``proof_scene`` (null, or the proxies that the
certificate is about) and ``certificate``. Numbers are doubles that read back to the bit; those that are not finite
are the strings "nan", "inf" and "-inf". The id is that of the scene, a hash of its content.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from oracles.ledger.reading import ENGINE, WITNESS, LedgerError, read_file
from oracles.outcome import Finding
from oracles.scene import Scene
from refimpl.proof import from_json
from refimpl.proof.wire import certificate_to_json, impact_from_json

FORMAT = "proxyproof-witness-1"
FOLDER = "witnesses"
LARGEST = 300_000
LONGEST_TEXT = 1_000


@dataclass(frozen=True)
class Witness:
    """One recorded failure; its certificate stays data until someone checks it."""

    engine: str
    version: str
    key: str
    symptom: str
    amount: float
    lower: float
    upper: float
    claim: str
    text: str
    scene: Scene
    proof_scene: Scene | None = None
    answer: dict[str, Any] = field(default_factory=dict)
    certificate: Any = None

    @property
    def id(self) -> str:
        """Hash of the scene's content."""
        return self.scene.id

    @property
    def proof(self) -> Any:
        """The certificate; raises `InvalidCertificate` when it is none."""
        return impact_from_json(self.certificate) if self.scene.motion is not None else from_json(self.certificate)

    @classmethod
    def of(cls, finding: Finding, key: str, version: str) -> Witness:
        """Record a finding."""
        verdict = finding.verdict
        return cls(
            finding.engine,
            version,
            key,
            verdict.symptom,
            verdict.amount,
            verdict.lower,
            verdict.upper,
            verdict.claim[:LONGEST_TEXT],
            finding.text[:LONGEST_TEXT],
            finding.scene,
            verdict.proof_scene,
            finding.answer,
            None if verdict.certificate is None else certificate_to_json(verdict.certificate),
        )

    def to_text(self) -> str:
        """Return the file's text."""
        data = {
            "format": FORMAT,
            **{name: getattr(self, name) for name in ("engine", "version", "key", "symptom")},
            **{name: getattr(self, name) for name in ("amount", "lower", "upper", "claim", "answer", "text")},
            "scene": self.scene.to_json(),
            "proof_scene": None if self.proof_scene is None else self.proof_scene.to_json(),
            "certificate": self.certificate,
        }
        lines = [f"{json.dumps(name)}: {_dump(value)}" for name, value in data.items()]
        return "{\n" + ",\n".join(lines) + "\n}\n"


def path_of(folder: Path, engine: str, name: str) -> Path:
    """Where a witness is kept; raises `LedgerError` for names that would lead elsewhere."""
    if not ENGINE.fullmatch(engine) or not WITNESS.fullmatch(name):
        raise LedgerError(f"no witness can be kept under {engine[:80]!r} and {name[:80]!r}")
    return folder / FOLDER / engine / f"{name}.json"


def load_witness(folder: Path, engine: str, name: str) -> Witness:
    """Read one witness of a ledger in `folder`; raises `LedgerError` when it is none, or that of another scene."""
    path = path_of(folder, engine, name)
    data = read_file(path, LARGEST)
    try:
        found = _parsed(json.loads(data))
    except RecursionError:
        raise LedgerError(f"{path} is nested too deeply") from None
    except (ValueError, TypeError, LookupError, OverflowError) as error:
        raise LedgerError(f"{path} is no witness: {type(error).__name__}: {str(error)[:300]}") from None
    if found.id != name or found.engine != engine:
        raise LedgerError(f"{path} is the witness {found.id} of {found.engine[:80]!r}")
    return found


def _parsed(data: Any) -> Witness:
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT}")
    found: dict[str, Any] = {
        name: _text(data[name], name) for name in ("engine", "version", "key", "symptom", "claim", "text")
    }
    found |= {name: _number(data[name], name) for name in ("amount", "lower", "upper")}
    if not isinstance(data["answer"], dict):
        raise TypeError("answer must be an object")
    found["scene"] = Scene.from_json(data["scene"])
    found["proof_scene"] = None if data["proof_scene"] is None else Scene.from_json(data["proof_scene"])
    return Witness(**found, answer=data["answer"], certificate=data["certificate"])


def _text(value: Any, name: str) -> str:
    if not isinstance(value, str) or len(value) > 2 * LONGEST_TEXT:
        raise ValueError(f"{name} must be a text of at most {2 * LONGEST_TEXT} characters")
    return value


def _number(value: Any, name: str) -> float:
    if isinstance(value, str) and value in ("nan", "inf", "-inf"):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{name} must be a number")
    return float(value)


def _dump(value: Any) -> str:
    return json.dumps(_finite(value), ensure_ascii=False, allow_nan=False)


def _finite(value: Any) -> Any:
    """Data in which numbers that are not finite are texts."""
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
