"""Writing survey TOML, as a crew would: one row of trees a table, its lists on one line.

Numbers are written so that they are read again to the last bit.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from orchard_cli.errors import Fault, InputError
from orchard_cli.model import output_file

_WIDTH = 100


def text_of(tables: Mapping[str, Any], remarks: tuple[str, ...] = ()) -> str:
    """The TOML of a survey's tables; remarks become its first lines."""
    lines = [f"# {remark}" for remark in remarks]
    plain = {k: v for k, v in tables.items() if not _is_table(v) and not _are_tables(v)}
    lines += [""] * bool(lines) + [_line(key, value) for key, value in plain.items()]
    for key, value in tables.items():
        if _is_table(value):
            lines += ["", f"[{key}]", *(_line(k, v) for k, v in value.items())]
        elif _are_tables(value):
            for table in value:
                lines += ["", f"[[{key}]]", *(_line(k, v) for k, v in table.items())]
    return "\n".join(lines) + "\n"


def save(text: str, path: Path, replace: bool = False) -> None:
    """Write a survey, all or nothing. Raises InputError where it cannot be, or where a file is."""
    try:
        if os.path.lexists(path) and not (replace and path.is_file()):
            raise InputError(Fault(str(path), "is there already", "choose another name"))
        output_file.replace(path, text)
    except OSError as error:
        raise InputError(
            Fault(str(path), f"cannot be written: {error.strerror}", "choose another place")
        ) from error


def _is_table(value: Any) -> bool:
    return isinstance(value, dict)


def _are_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(v, dict) for v in value)


def _line(key: str, value: Any) -> str:
    line = f"{key} = {_value(value)}"
    if len(line) <= _WIDTH or not isinstance(value, list):
        return line
    return f"{key} = [\n" + _wrapped([_value(v) for v in value]) + "\n]"


def _wrapped(items: list[str]) -> str:
    lines = ["   "]
    for item in items:
        if len(lines[-1]) + len(item) + 2 > _WIDTH and lines[-1].strip():
            lines.append("   ")
        lines[-1] += f" {item},"
    return "\n".join(lines)


def _value(value: Any) -> str:
    """A TOML value; JSON's strings and truth values are TOML's, too."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)
