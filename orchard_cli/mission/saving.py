"""Writing mission files. It is atomic: a killed process leaves the old file or the new one."""

from __future__ import annotations

import json
import os
from pathlib import Path

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.input_text import read_bounded
from orchard_cli.model.mission import Mission
from orchard_cli.model.output_file import replace

from .documents import SCHEMA
from .files import LARGEST, dumps

_ANOTHER = "choose another with -o"


def save(mission: Mission, path: Path) -> None:
    """Write a mission file, all or nothing. A link is followed: the file that it names is written.

    Raises InputError where it cannot be written, and where something stands that is no mission.
    """
    try:
        target = path.resolve()
        if os.path.lexists(target):
            _refuse_what_is_no_mission(target, str(path))
        replace(target, dumps(mission))
    except (OSError, RuntimeError) as error:  # RuntimeError: a link that leads to itself
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(Fault(str(path), f"cannot be written: {reason}", _ANOTHER)) from error


def _refuse_what_is_no_mission(target: Path, where: str) -> None:
    """A wrong -o must not cost the crew a survey, a log or a device."""
    if not target.is_file():
        raise InputError(Fault(where, "is no regular file", _ANOTHER))
    try:
        document = json.loads(read_bounded(target, LARGEST))
    except (InputError, ValueError, RecursionError):
        document = None
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise InputError(
            Fault(where, "is there already and is no mission", f"move it away, or {_ANOTHER}")
        )
