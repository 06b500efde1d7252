"""Copies out of `oracles.repro.pieces` what one script needs: functions, methods, rows of tables, as they stand there.

What a script names is followed through the pieces: a function brings those that it names, a class its bases and the
methods whose names occur anywhere in what is chosen. So scripts of simple shapes stay short, and no line of a checker
is written twice.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

ORDER = (
    "exact",
    "inscribed",
    "solids",
    "rounds",
    "boxes",
    "curved",
    "polytopes",
    "claims",
    "unions",
    "rays",
    "flat",
    "checking",
    "impacts",
    "judging",
    "asking",
    "running",
)
"""The modules, each after those that it needs."""
RUN = ("judging", "asking", "running")
"""Those that ask and judge, and prove nothing."""
KEY = re.compile(r'\s*"([^"]+)":')

Tables = Mapping[str, frozenset[str]]
"""Names of tables, and the keys whose rows are wanted."""


@dataclass(frozen=True)
class Piece:
    """One top-level definition.

    Attributes
    ----------
    node
        Its syntax.
    lines
        Its text, with the comments in front of it and the docstring behind it.
    """

    module: str
    name: str
    node: ast.stmt
    lines: tuple[str, ...]


@cache
def pieces() -> dict[str, Piece]:
    """Every definition by its name, in the order in which scripts hold them."""
    found: dict[str, Piece] = {}
    for module in ORDER:
        text = files("oracles.repro.pieces").joinpath(f"{module}.py").read_text("utf-8")
        for piece in _pieces_of(module, text):
            assert piece.name not in found, f"{piece.name} is there twice"
            found[piece.name] = piece
    return found


def _pieces_of(module: str, text: str) -> Iterator[Piece]:
    lines, body = text.splitlines(), ast.parse(text).body
    for i, node in enumerate(body):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            name = node.name
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            name = node.target.id
        else:
            continue
        after = body[i + 1] if i + 1 < len(body) else None
        end = after.end_lineno if isinstance(after, ast.Expr) else node.end_lineno
        yield Piece(module, name, node, tuple(lines[node.lineno - 1 : end]))


@cache
def _imports() -> dict[str, str]:
    """Names that the pieces import from the standard library, each with its statement."""
    found: dict[str, str] = {}
    for module in ORDER:
        text = files("oracles.repro.pieces").joinpath(f"{module}.py").read_text("utf-8")
        for node in ast.parse(text).body:
            if isinstance(node, ast.Import):
                found |= {alias.name: f"import {alias.name}" for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not str(node.module).startswith(("oracles", "__future__")):
                found |= {alias.name: f"from {node.module} import" for alias in node.names}
    return found


def select(roots: str, tables: Tables) -> tuple[str, str, str]:
    """Imports, checker and the rest of all that a piece of Python needs.

    Parameters
    ----------
    roots
        The text that names the first of them.
    tables
        Rows that are wanted of tables; of others, none are left out.
    """
    first = ast.parse(roots)
    names, attributes = _used([first])
    chosen: dict[str, list[ast.AST]] = {}
    while True:
        wanted = [name for name in pieces() if name in names]
        chosen = {name: _nodes(pieces()[name], attributes, tables) for name in wanted}
        found = _used([first, *(node for nodes in chosen.values() for node in nodes)])
        if found == (names, attributes):
            break
        names, attributes = found
    checker, rest = (
        "\n\n".join(
            _text(pieces()[name], attributes, tables) for name in chosen if (pieces()[name].module in RUN) == run
        )
        for run in (False, True)
    )
    return _import_lines(names), checker, rest


def _nodes(piece: Piece, attributes: set[str], tables: Tables) -> list[ast.AST]:
    """Parts of a definition that are chosen."""
    node = piece.node
    if isinstance(node, ast.ClassDef):
        return [*node.bases, *(item for item in node.body if _is_wanted(item, attributes))]
    value = getattr(node, "value", None)
    if isinstance(value, ast.Dict) and piece.name in tables:
        rows = zip(value.keys, value.values, strict=True)
        return [row for key, row in rows if isinstance(key, ast.Constant) and key.value in tables[piece.name]]
    return [node]


def _is_wanted(item: ast.stmt, attributes: set[str]) -> bool:
    if not isinstance(item, ast.FunctionDef):
        return True
    abstract = isinstance(item.body[-1], ast.Raise) and ast.unparse(item.body[-1]) == "raise NotImplementedError"
    return item.name.startswith("__") or (item.name in attributes and not abstract)


def _used(nodes: Iterable[ast.AST]) -> tuple[set[str], set[str]]:
    """Names that are not bound where they occur, and names of attributes."""
    names, attributes = set[str](), set[str]()
    for root in nodes:
        free, inside = _free(root)
        names |= free
        attributes |= inside
    return names, attributes


@cache
def _free(root: ast.AST) -> tuple[set[str], set[str]]:
    """Names in one function or statement, without its own variables; and names of attributes."""
    read, bound, attributes = set[str](), set[str](), set[str]()
    for node in ast.walk(root):
        if isinstance(node, ast.Name):
            (read if isinstance(node.ctx, ast.Load) else bound).add(node.id)
        elif isinstance(node, ast.arg):
            bound.add(node.arg)
        elif isinstance(node, ast.Attribute):
            attributes.add(node.attr)
    return (read - bound if isinstance(root, ast.FunctionDef) else read), attributes


def _text(piece: Piece, attributes: set[str], tables: Tables) -> str:
    """Lines of a definition that are chosen."""
    node, lines = piece.node, list(piece.lines)
    if isinstance(node, ast.ClassDef):
        start = node.lineno
        for item in reversed(node.body):
            if not _is_wanted(item, attributes):
                decorators = getattr(item, "decorator_list", [])
                first = min([item.lineno, *(d.lineno for d in decorators)]) - start
                assert item.end_lineno is not None
                del lines[first - 1 : item.end_lineno - start + 1]
    elif piece.name in tables:
        wanted = set(tables[piece.name])
        lines = [line for line in lines if not (match := KEY.match(line)) or match[1] in wanted]
    return "\n".join(lines)


def _import_lines(names: set[str]) -> str:
    """Import statements of the names that occur."""
    plain, parts = set[str](), dict[str, list[str]]()
    for name, statement in _imports().items():
        if name in names:
            if statement.startswith("import"):
                plain.add(statement)
            else:
                parts.setdefault(statement, []).append(name)
    combined = [f"{statement} {', '.join(sorted(found))}" for statement, found in parts.items()]
    return "\n".join([*sorted(plain), *sorted(combined)])
