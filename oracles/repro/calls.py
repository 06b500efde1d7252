"""The part of a script that asks the engine: what its adapter writes, put into a function."""

from __future__ import annotations

import ast
import sys
import textwrap
from collections.abc import Iterator

from oracles.engine import Engine
from oracles.scene import Scene

PACKAGES = {"fcl": "pip install python-fcl", "pybullet": "pip install pybullet", "numpy": "pip install numpy"}
PACKAGES |= {"pymunk": "pip install pymunk"}
PACKAGES |= dict.fromkeys(("oracles", "refimpl"), "pip install proxyproof")
LONGEST = 500
OWN = "the module of this engine: call this in its folder"
"""How to get a module that no index knows."""


def call_of(engine: Engine, scene: Scene) -> str:
    """Return the script that asks an engine alone for one scene, or a comment on why there is none."""
    rows = [row.tolist() for row in scene.rows]
    try:
        script = engine.repro(scene.query, scene.cell.type_a, scene.cell.type_b, *rows)
        if not isinstance(script, str):
            return f"# {engine.name} wrote a {type(script).__name__} for this scene\n"
        ast.parse(script)
    except Exception as error:  # an adapter's mistake must not cost the report
        said = f"{type(error).__name__}: {str(error)[:LONGEST]!r}"
        return f"# {engine.name} wrote no script for this scene: {said}\n"
    return script


def function_of(name: str, script: str) -> str:
    """Put a script into a function, as it is; as text to be executed, where indenting would change it."""
    if not ast.parse(script).body:
        why = script.strip().lstrip("# ") or "there is no script"
        return f"def {name}():\n    raise RuntimeError({why!r})\n"
    indented = textwrap.indent(script.strip("\n") + "\n", "    ", lambda line: bool(line.strip()))
    function = f"def {name}():\n{indented}"
    if _same(function, script):
        return function
    return f"def {name}():\n    exec(compile({script!r}, {name!r}, 'exec'), {{'__name__': '__main__'}})\n"


def _same(function: str, script: str) -> bool:
    """Whether a function does what a script does."""
    try:
        compile(function, "function", "exec")
        (made,) = ast.parse(function).body
    except (SyntaxError, ValueError):
        return False
    assert isinstance(made, ast.FunctionDef)
    alone = ast.parse(script).body
    return [ast.dump(node) for node in made.body] == [ast.dump(node) for node in alone]


def needed_by(script: str) -> list[list[str]]:
    """Modules that a script imports beyond the standard library, each with how to get it."""
    return [[name, PACKAGES.get(name, OWN)] for name in sorted(set(_imported(script)))]


def _imported(script: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(script)):
        modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        modules += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        for module in modules:
            name = module.partition(".")[0]
            if name not in sys.stdlib_module_names:
                yield name
