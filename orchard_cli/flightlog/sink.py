"""The file under the log: append only, committed at chunk ends, and never in the flight's way."""

from __future__ import annotations

import os
from pathlib import Path

from orchard_cli.errors import Fault, InputError

PENDING_LIMIT = 32 * 2**20
"""Bytes kept for a disk that refuses to take them; beyond this the log ends."""


class Sink:
    """A file-like object for the MCAP writer. It keeps what the disk refuses and tries again.

    Bytes reach the file in order or not at all, so the file is at any time a true beginning of
    the log. No method raises after construction.
    """

    def __init__(self, path: Path, overwrite: bool, sync: bool) -> None:
        """Create the file; InputError when that cannot be done."""
        flags = os.O_WRONLY | os.O_CREAT | (os.O_TRUNC if overwrite else os.O_EXCL)
        try:
            self._file = os.open(path, flags, 0o644)
        except FileExistsError:
            fault = Fault(str(path), "this log exists already", "name another or remove it")
            raise InputError(fault) from None
        except OSError as error:
            fault = Fault(str(path), f"cannot be written: {error.strerror}", "name another file")
            raise InputError(fault) from None
        self._sync = sync
        self._pending = bytearray()
        self._length = 0
        self.failure = ""  # why the disk refused the last time; empty: it did not
        self.ended = False  # too much was refused: nothing more is kept

    def write(self, data: bytes) -> int:
        """Take bytes; they reach the disk with the next commit."""
        if not self.ended:
            self._pending += data
        self._length += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:  # noqa: ARG002
        """The present length; the MCAP writer only asks where it is."""
        return self._length

    def flush(self) -> None:
        """Nothing: `commit` decides when bytes go to the disk."""

    def commit(self) -> None:
        """Write what is pending; what the disk refuses stays pending, up to a limit."""
        try:
            while self._pending:
                del self._pending[: os.write(self._file, self._pending)]
            if self._sync:
                os.fsync(self._file)
            self.failure = ""
        except OSError as error:
            self.failure = error.strerror or type(error).__name__
            self.ended = self.ended or len(self._pending) > PENDING_LIMIT

    def close(self) -> None:
        """Commit and let go of the file."""
        self.commit()
        try:
            os.close(self._file)
        except OSError as error:
            self.failure = error.strerror or type(error).__name__
