"""Mission files: JSON with a schema name and version, checked by the schema shipped beside this.

What is written (saving.py) is read again to the last bit.
"""

from __future__ import annotations

import json
from importlib import resources
from itertools import islice
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.input_text import read_bounded
from orchard_cli.model.mission import Mission

from .checks import check
from .documents import SCHEMA, VERSION, document_of, mission_of
from .upgrade import upgraded

LARGEST = 10_000_000  # bytes
_MOST_FAULTS = 20  # listed; a file that is not a mission at all has thousands


def schema() -> dict[str, Any]:
    """The JSON Schema of mission files."""
    text = resources.files(__package__).joinpath("mission.schema.json").read_text("utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def load(path: Path) -> Mission:
    """Read and check a mission file. Raises InputError with every fault."""
    return loads(read_bounded(path, LARGEST), str(path))


def load_unchecked(path: Path) -> Mission:
    """Read a mission file that may be unfit to fly, to tell what is wrong with it.

    Raises InputError with every fault of its form alone.
    """
    return _formed(read_bounded(path, LARGEST), str(path))


def loads(data: bytes | str, where: str = "mission") -> Mission:
    """A mission from the text of its file; `where` names it in faults.

    Raises InputError with every fault of the schema, else with every fault of the physics.
    """
    mission = _formed(data, where)
    faults = [Fault(f"{where}: {f.where}", f.what, f.mend) for f in check(mission)]
    if faults:
        raise InputError(faults)
    return mission


def _formed(data: bytes | str, where: str) -> Mission:
    document = _parsed(data, where)
    found = Draft202012Validator(schema()).iter_errors(document)
    errors = list(islice(found, _MOST_FAULTS + 1))
    if errors:
        faults = [
            Fault(f"{where}: {'/'.join(map(str, e.absolute_path)) or 'file'}", _short(e.message))
            for e in errors[:_MOST_FAULTS]
        ]
        if len(errors) > _MOST_FAULTS:
            faults.append(Fault(where, "has more faults than these"))
        raise InputError(faults)
    try:
        return mission_of(document)
    except ValueError as error:
        raise InputError(Fault(where, str(error), "plan the mission again")) from error


def dumps(mission: Mission) -> str:
    """The text of a mission's file."""
    return _laid_out(document_of(mission)) + "\n"


def _parsed(data: bytes | str, where: str) -> dict[str, Any]:
    try:
        document = json.loads(data, parse_constant=_no_constant, object_pairs_hook=_no_twins)
    except UnicodeDecodeError as error:
        raise InputError(Fault(where, "is not UTF-8 text")) from error
    except (ValueError, RecursionError) as error:
        raise InputError(Fault(where, f"is not JSON: {error}")) from error
    name = document.get("schema") if isinstance(document, dict) else None
    if name != SCHEMA:
        raise InputError(
            Fault(where, f"is no mission file (schema {name!r})", "make one with `orchard plan`")
        )
    if document.get("version") == 1:
        document = upgraded(document)
    elif document.get("version") != VERSION:
        raise InputError(
            Fault(
                f"{where}: version",
                f"is {document.get('version')!r}, this program reads 1 to {VERSION}",
                "plan the mission again",
            )
        )
    return dict(document)


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is not a number")


def _no_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    unique = dict(pairs)
    if len(unique) < len(pairs):
        raise ValueError("a key stands twice in one object")
    return unique


def _short(message: str) -> str:
    return message if len(message) <= 160 else f"{message[:60]} ... {message[-90:]}"


def _laid_out(value: Any, indent: int = 0) -> str:
    """JSON with one point, row or entry a line: short, and fit for a diff."""
    flat = json.dumps(value, allow_nan=False, ensure_ascii=False)
    if len(flat) + indent <= 100:
        return flat
    pad = " " * (indent + 1)
    if isinstance(value, dict):
        lines = [f"{json.dumps(k)}: {_laid_out(v, indent + 1)}" for k, v in value.items()]
        return "{\n" + ",\n".join(pad + line for line in lines) + "\n" + " " * indent + "}"
    if isinstance(value, list):
        lines = [_laid_out(v, indent + 1) for v in value]
        return "[\n" + ",\n".join(pad + line for line in lines) + "\n" + " " * indent + "]"
    return flat
