"""Data as Python text: as it is where that can be read, packed where it is long; all reads back to the bit."""

from __future__ import annotations

import ast
import base64
import json
import math
import zlib
from typing import Any

WIDTH = 116
MANY = 150
"""Numbers from which on a list is packed."""
LINE = 100


class Name(str):
    """Text that stands for itself: the name of something that the script defines."""

    __slots__ = ()


class Numbers:
    """Lists that are too long to be read: they stand packed at the end of a script."""

    def __init__(self) -> None:
        self._packed: list[str] = []

    def __bool__(self) -> bool:
        """Whether there is any."""
        return bool(self._packed)

    def text(self, value: Any, indent: int = 0, *, before: int = 0) -> str:
        """Python text of plain data, on one line where that fits."""
        line = self._line(value)
        if len(line) + indent + before <= WIDTH or not isinstance(value, list | dict) or not value:
            return line
        if isinstance(value, list) and count(value) > MANY and not _names(value):
            return self.packed(value)
        inner, pad = indent + 4, " " * (indent + 4)
        if isinstance(value, dict):
            rows = [f"{name!r}: " + self.text(item, inner, before=len(repr(name)) + 3) for name, item in value.items()]
            body = "".join(f"{pad}{_quoted(row)},\n" for row in rows)
            return "{\n" + body + " " * indent + "}"
        body = "".join(f"{pad}{self.text(item, inner, before=1)},\n" for item in value)
        return "[\n" + body + " " * indent + "]"

    def packed(self, value: Any) -> str:
        """Name under which a list stands at the end."""
        data = json.dumps(value).encode("ascii")
        self._packed.append(base64.b85encode(zlib.compress(data, 9)).decode("ascii"))
        return f"NUMBERS[{len(self._packed) - 1}]"

    def definition(self) -> str:
        """Python text of all that is packed."""
        text = "NUMBERS = [  # JSON, compressed\n"
        for packed in self._packed:
            lines = [packed[i : i + LINE] for i in range(0, len(packed), LINE)]
            text += "    unpacked(\n" + "".join(f"        {line!r}\n" for line in lines) + "    ),\n"
        return text + "]\n"

    def _line(self, value: Any) -> str:
        if isinstance(value, Name):
            return value
        if isinstance(value, dict):
            return "{" + ", ".join(f'"{name}": {self._line(item)}' for name, item in value.items()) + "}"
        if isinstance(value, list):
            return "[" + ", ".join(map(self._line, value)) + "]"
        if isinstance(value, float) and not math.isfinite(value):
            return "math.nan" if math.isnan(value) else "math.inf" if value > 0 else "-math.inf"
        return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


UNPACKED = '''def unpacked(text):
    """Plain data that is too long to be read."""
    return json.loads(zlib.decompress(base64.b85decode(text)))
'''


def _quoted(row: str) -> str:
    """A row of a dictionary with its key in double quotes."""
    end = row.index("'", 1)
    return f'"{row[1:end]}"{row[end + 1 :]}'


def count(value: Any) -> int:
    """Return how many numbers plain data holds."""
    if isinstance(value, dict):
        return sum(map(count, value.values()))
    return sum(map(count, value)) if isinstance(value, list) else 1


def _names(value: Any) -> bool:
    """Whether something in plain data stands for itself."""
    if isinstance(value, dict):
        return any(map(_names, value.values()))
    return any(map(_names, value)) if isinstance(value, list) else isinstance(value, Name)


def shortened(script: str, numbers: Numbers) -> str:
    """Python text whose long lists of numbers stand packed at the end."""
    lines = script.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode("utf-8")))
    data, end, found = script.encode("utf-8"), len(script.encode("utf-8")), b""
    for node in reversed(_long_lists(ast.parse(script))):
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        first, last = starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset
        found = numbers.packed(ast.literal_eval(node)).encode("ascii") + data[last:end] + found
        end = first
    return (data[:end] + found).decode("utf-8")


def _long_lists(tree: ast.AST) -> list[ast.List]:
    """Literal lists of many numbers, in the order of the text, none within another."""
    found: list[ast.List] = []
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.List) and sum(isinstance(n, ast.Constant) for n in ast.walk(node)) > MANY:
            try:
                ast.literal_eval(node)
                found.append(node)
                continue
            except ValueError:
                pass
        waiting += ast.iter_child_nodes(node)
    return sorted(found, key=lambda node: (node.lineno, node.col_offset))
