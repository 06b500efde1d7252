"""Repro scripts: one file that asks an engine, carries the proof, checks it, and says whether the engine is right."""

from oracles.repro.writing import script_of

__all__ = ["script_of"]
