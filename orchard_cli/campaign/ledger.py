"""What has been flown so far: one JSON document a line, appended as a whole, never rewritten.

A campaign that is stopped, or killed, goes on from here. The first line says what was flown and
by which code, so that results of different campaigns are never mixed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from orchard_cli.code_hash import code_hash
from orchard_cli.errors import Fault, InputError

FILE = "cases.ndjson"


class Ledger:
    """The results in a folder."""

    def __init__(self, folder: Path, inputs: Mapping[str, Any], key: tuple[str, ...]) -> None:
        """Begin or go on with `folder`; `key` names what tells two results apart.

        Raises InputError when other inputs, or other code, made what lies there.
        """
        self._path = folder / FILE
        self._key = key
        folder.mkdir(parents=True, exist_ok=True)
        head = {"inputs": dict(inputs), "code": code_hash()}
        lines = self._whole_lines()
        if not lines:
            self._append(head)
        elif lines[0] != head:
            what = "holds results of other inputs, or of another version of this program"
            raise InputError(Fault(str(self._path), what, "name another folder with --out"))
        self.records = {self._name(line): line for line in lines[1:]}

    def add(self, record: Mapping[str, Any]) -> None:
        """Keep one result, at once and for good."""
        self._append(record)
        self.records[self._name(record)] = dict(record)

    def _name(self, record: Mapping[str, Any]) -> tuple[Any, ...]:
        return tuple(record[part] for part in self._key)

    def _whole_lines(self) -> list[dict[str, Any]]:
        """Every line that was written to its end; what a killed process left is cut off."""
        if not self._path.exists():
            return []
        data = self._path.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]
        if len(whole) < len(data):
            os.truncate(self._path, len(whole))
        try:
            return [dict(json.loads(line)) for line in whole.splitlines()]
        except (ValueError, TypeError) as error:
            fault = Fault(str(self._path), f"is no list of results: {error}", "name another folder")
            raise InputError(fault) from None

    def _append(self, record: Mapping[str, Any]) -> None:
        line = json.dumps(record, allow_nan=False).encode() + b"\n"
        with open(self._path, "ab") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
