"""Files that a person names for output: written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from orchard_cli.errors import Fault, InputError


def write_whole(path: Path, content: str | bytes, suffixes: tuple[str, ...] = ()) -> None:
    """Write a file; a killed process leaves the old one or the new one. A link is followed.

    `suffixes`: what the name may end in, lest a wrong option costs somebody a log. Raises
    InputError where the name is of another kind or the file cannot be written.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        wanted = " or ".join(suffixes)
        raise InputError(Fault(str(path), "is named for another kind of file", f"name a {wanted}"))
    try:
        target = path.resolve()
        if os.path.lexists(target) and not target.is_file():
            raise InputError(Fault(str(path), "is no regular file", "name another file"))
        replace(target, content)
    except (OSError, RuntimeError) as error:  # RuntimeError: a link that leads to itself
        reason = getattr(error, "strerror", None) or str(error)
        fault = Fault(str(path), f"cannot be written: {reason}", "name another file")
        raise InputError(fault) from error


def replace(target: Path, content: str | bytes) -> None:
    """Write beside the target, then put it in its place. Raises OSError."""
    data = content.encode() if isinstance(content, str) else content
    with tempfile.NamedTemporaryFile(
        "wb", dir=target.parent, prefix=f".{target.name}.", delete=False
    ) as file:
        try:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
            os.chmod(file.name, 0o644)
            os.replace(file.name, target)
        except BaseException:
            os.unlink(file.name)
            raise
