"""Input files that people write: read within bounds, decoded, and parsed with faults for errors."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from orchard_cli.errors import Fault, InputError

MOST_PARTS = 20  # of a dotted key
"""tomllib takes memory with the square of a key's parts: 50,000 of them take 10 GB."""

_QUOTED_OR_COMMENT = re.compile(
    r'''"""(?:[^"\\]++|\\[\s\S]?|"(?!""))*+(?:"{3,5}|\Z)'''
    r"""|'{3}(?:[^']++|'(?!''))*+(?:'{3,5}|\Z)"""
    r"""|"(?:[^"\\\n]++|\\.)*+"?"""
    r"""|'[^'\n]*+'?"""
    r"""|\#[^\n]*+"""
)


def read_bounded(path: Path, largest: int, mend: str = "") -> bytes:
    """The bytes of a regular file of at most `largest` bytes.

    Raises InputError for anything else: a pipe or a device would never end. `mend` tells what to
    do about a file that is too large.
    """
    try:
        if not path.is_file():
            what = "is no regular file" if path.exists() else "is no file"
            raise InputError(Fault(str(path), what, "give the path of a file"))
        with path.open("rb") as file:
            data = file.read(largest + 1)
    except OSError as error:
        raise InputError(Fault(str(path), f"cannot be read: {error.strerror}")) from error
    except ValueError as error:  # a NUL in the path
        raise InputError(Fault(repr(str(path)), f"is no path: {error}")) from error
    if len(data) > largest:
        raise InputError(Fault(str(path), f"too large, {largest / 1e6:.0f} MB is the most", mend))
    return data


def decoded(data: bytes, where: str) -> str:
    """UTF-8 text, with or without a byte order mark. Raises InputError with the line."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(
            Fault(f"{where}, line {line}", "is not UTF-8 text", "save the file as UTF-8")
        ) from error


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises InputError for whatever is none."""
    if line := _long_key(text):
        raise InputError(
            Fault(f"{where}, line {line}", f"a key of more than {MOST_PARTS} parts", "shorten it")
        )
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise InputError(Fault(where, "is nested too deeply")) from error
    except ValueError as error:  # not only TOMLDecodeError: an integer of 5000 digits, too
        raise InputError(Fault(where, f"is not TOML: {error}", "mend that line")) from error


def _long_key(text: str) -> int:
    """The number of the first line with a dotted key of too many parts, 0 when there is none."""
    bare = _QUOTED_OR_COMMENT.sub(lambda found: "\n" * found.group().count("\n"), text)
    for number, line in enumerate(bare.split("\n"), 1):
        if line.count(".") >= MOST_PARTS and any(
            part.count(".") >= MOST_PARTS for part in re.split(r"[=,\[\]{}]", line)
        ):
            return number
    return 0
