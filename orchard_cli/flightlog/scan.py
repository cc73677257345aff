"""MCAP records in file order, as far as the file is whole: for logs that were cut or damaged."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import zstandard
from mcap.exceptions import EndOfFile, InvalidMagic
from mcap.records import Channel, Chunk, DataEnd, Message, Schema
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk

from orchard_cli.errors import Fault, InputError

RECORD_LIMIT = 512 * 2**20
"""No record and no chunk of ours comes near this size in bytes; a damaged length may."""


class Scan:
    """Iterates over schemas, channels, messages, attachments and metadata in file order.

    The first damage ends it, and `end` then says so; the messages that came before have passed
    their checksum. Memory is bounded by the largest chunk, time by the file's length.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.end = ""  # why reading stopped early; empty: the file is whole

    def __iter__(self) -> Iterator[Any]:
        """Raises InputError when the file cannot be opened or is no MCAP."""
        try:
            if self._path.exists() and not self._path.is_file():  # a pipe would block for ever
                raise InputError(Fault(str(self._path), "is no regular file", "name a log file"))
            with self._path.open("rb") as stream:
                yield from self._records(_Exact(stream, self._path.stat().st_size))
        except OSError as error:
            what = f"cannot be read: {error.strerror}"
            raise InputError(Fault(str(self._path), what, "name a log file")) from None

    def _records(self, stream: _Exact) -> Iterator[Any]:
        reader = StreamReader(
            stream, emit_chunks=True, validate_crcs=True, record_size_limit=RECORD_LIMIT
        )
        records = reader.records
        finished = False
        while True:
            place = stream.tell()
            try:
                record = next(records)
                parts = _opened(record) if isinstance(record, Chunk) else [record]
            except StopIteration:
                return
            except Exception as error:  # a damaged file makes the library raise anything at all
                self._explain(error, place, finished)
                return
            finished = finished or isinstance(record, DataEnd)
            if not finished:  # the summary only repeats
                yield from parts

    def _explain(self, error: Exception, place: int, finished: bool) -> None:
        if isinstance(error, InvalidMagic) and place == 0:
            raise InputError(
                Fault(str(self._path), "is no MCAP log", "name a log of `orchard fly`")
            ) from None
        if isinstance(error, OSError):
            raise error
        if isinstance(error, EndOfFile):
            self.end = "its index is cut off" if finished else "it is cut off, or still written"
        elif isinstance(error, CRCValidationError) and isinstance(error.record, DataEnd):
            self.end = "its checksum is wrong: a part may be missing, an attachment damaged"
        else:
            self.end = f"it is damaged near byte {place} ({type(error).__name__})"


class _Exact:
    """A stream whose `read` gives all that is asked for, or tells that the file ends here."""

    def __init__(self, stream: IO[bytes], size: int) -> None:
        self._stream = stream
        self._size = size

    def tell(self) -> int:
        return self._stream.tell()

    def read(self, count: int) -> bytes:
        if count > self._size - self._stream.tell():
            raise EndOfFile
        return self._stream.read(count)


def _opened(chunk: Chunk) -> list[Channel | Message | Schema]:
    """The chunk's records; ValueError when a size in it is not to be believed."""
    sizes = [chunk.uncompressed_size]
    if chunk.compression == "zstd":
        sizes.append(zstandard.frame_content_size(chunk.data))  # -1: unknown
    if max(sizes) > RECORD_LIMIT:
        raise ValueError("chunk too large")
    return breakup_chunk(chunk, validate_crc=True)  # type: ignore[no-any-return]
