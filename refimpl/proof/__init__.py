"""Proofs of signed distances and ray times: `certify` makes a certificate, `check` believes only what it verifies."""

from refimpl.proof.certify import certify
from refimpl.proof.checker import check
from refimpl.proof.claims import (
    Certificate,
    Claim,
    Common,
    Core,
    Cover,
    Escape,
    Inscribed,
    Near,
    Part,
    Piece,
    Separated,
    Split,
)
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.sweep_search import certify_sweep
from refimpl.proof.sweeps import Clear, Meets, SweepCertificate, check_sweep
from refimpl.proof.wire import from_json, to_json

__all__ = [
    "Certificate",
    "Claim",
    "Clear",
    "Common",
    "Core",
    "Cover",
    "Escape",
    "Inscribed",
    "InvalidCertificate",
    "Meets",
    "Near",
    "Part",
    "Piece",
    "Separated",
    "Split",
    "SweepCertificate",
    "certify",
    "certify_sweep",
    "check",
    "check_sweep",
    "from_json",
    "to_json",
]
