"""MCAP records in file order, as far as the file is whole: for logs that were cut or damaged.

The container is read here and not by mcap's readers for three reasons: they give nothing of a cut
file or stop at its first damage, they decode every record of a chunk, and a length that lies can
cost them any amount of memory. What a record holds is decoded by mcap.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterator
from io import BytesIO
from pathlib import Path
from typing import IO, Any, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata, Schema

from orchard_cli.errors import Fault, InputError

MAGIC = b"\x89MCAP0\r\n"
RECORD_LIMIT = 64 * 2**20
"""bytes: no record and no chunk of a flight comes near this size; a damaged length may."""
SMALL = 64 * 2**20
"""bytes: a file up to this size is read whole, so that its checksum over everything is verified."""
SWELLING = 256 * 2**20, 100
"""bytes, and times the file's size: a file that unpacks to more than both is no flight."""
CROWD = 300_000, 32
"""records, and per byte of the file: a file with more records than both is no flight."""

_HEAD = struct.Struct("<BQ")  # opcode, length of what follows
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_FOOTER = struct.Struct("<QQI")  # start of the summary, of its offsets; checksum
_CHUNK_INDEX = struct.Struct("<QQQQI")  # first and last time, place, length, bytes of pairs
_PAIR = struct.Struct("<HQ")  # channel, place of its message index
_PLAIN = {Opcode.SCHEMA: Schema, Opcode.CHANNEL: Channel, Opcode.METADATA: Metadata}


class Raw(NamedTuple):
    """One message, not decoded."""

    channel_id: int
    log_time: int  # ns
    data: bytes


class Broken(Exception):
    """The file is damaged here; the text says how."""


class Cut(Exception):
    """The file ends here."""


class Scan:
    """Iterates over schemas, channels, messages (`Raw`), attachments and metadata in file order.

    The first damage ends it, and `end` then says so; the messages that came before have passed
    their checksum. With `topics`, chunks that hold none of them are not even read, where the
    file's index is whole and the file is not small. Memory is bounded by the largest chunk.
    """

    def __init__(self, path: Path, topics: Collection[str] | None = None) -> None:
        self._path = path
        self._topics = topics
        self.end = ""  # why reading stopped early; empty: the file is whole

    def __iter__(self) -> Iterator[Any]:
        """Raises InputError when the file cannot be opened or is no MCAP."""
        try:
            if self._path.exists() and not self._path.is_file():  # a pipe would block for ever
                raise InputError(Fault(str(self._path), "is no regular file", "name a log file"))
            with self._path.open("rb") as stream:
                yield from self._records(stream)
        except OSError as error:
            what = f"cannot be read: {error.strerror}"
            raise InputError(Fault(str(self._path), what, "name a log file")) from None

    def _records(self, stream: IO[bytes]) -> Iterator[Any]:
        size = self._path.stat().st_size
        if stream.read(len(MAGIC)) != MAGIC:
            fault = Fault(str(self._path), "is no MCAP log", "name a log of `orchard fly`")
            raise InputError(fault)
        skipped = _needless(stream, size, self._topics) if size > SMALL else {}
        data = _Data(stream, size, skipped, self._topics)
        try:
            yield from data
        except Cut:
            self.end = "its index is cut off" if data.ended else "it is cut off, or still written"
        except Broken as broken:
            self.end = str(broken)
        except OSError:
            raise
        except Exception as error:  # a damaged file makes the library raise anything at all
            self.end = f"it is damaged near byte {data.place} ({type(error).__name__})"


class _Data:
    """The file's records up to its end; chunks opened."""

    def __init__(
        self,
        stream: IO[bytes],
        size: int,
        skipped: dict[int, int],
        topics: Collection[str] | None,
    ) -> None:
        self._stream, self._size, self._skipped = stream, size, skipped
        self._topics = topics
        self._wanted: set[int] = set()  # channels of topics that were asked for
        self._checksum = zlib.crc32(MAGIC)
        self._swelling = max(SWELLING[0], SWELLING[1] * size)
        self._crowd = max(CROWD[0], size // CROWD[1])
        self.place = len(MAGIC)  # of the record being read
        self.ended = False  # everything but the summary has been read

    def __iter__(self) -> Iterator[Any]:
        while True:
            self.place = self._stream.tell()
            length = self._skipped.get(self.place)
            if length is not None:
                self._stream.seek(self.place + length)
                continue
            head = self._read(_HEAD.size)
            opcode, length = _HEAD.unpack(head)
            self._count(opcode)
            if opcode == Opcode.FOOTER:
                self._read(length + len(MAGIC))
                return
            content = self._read(length)
            if opcode == Opcode.DATA_END:
                self._end(content)
            if self.ended:  # the summary only repeats
                continue
            self._checksum = zlib.crc32(content, zlib.crc32(head, self._checksum))
            yield from self._opened(opcode, content)

    def _read(self, count: int) -> bytes:
        if count > self._size - self._stream.tell():
            raise Cut
        if count > RECORD_LIMIT:
            raise Broken(f"it is damaged near byte {self.place} (a record of {count} bytes)")
        return self._stream.read(count)

    def _end(self, content: bytes) -> None:
        self.ended = True
        (told,) = struct.unpack_from("<I", content)
        if told and not self._skipped and told != self._checksum:
            raise Broken("its checksum is wrong: a part may be missing, an attachment damaged")

    def _opened(self, opcode: int, content: bytes) -> Iterator[Any]:
        if opcode == Opcode.CHUNK:
            yield from self._inside(_unpacked(content, self._spend))
        elif opcode == Opcode.MESSAGE:
            channel, _, log_time, _ = _MESSAGE.unpack_from(content)
            if channel in self._wanted:
                yield Raw(channel, log_time, content[_MESSAGE.size :])
        elif opcode == Opcode.ATTACHMENT:
            (told,) = struct.unpack_from("<I", content, len(content) - 4)
            if told and told != zlib.crc32(content[:-4]):
                raise Broken("an attachment's checksum is wrong")
            yield Attachment.read(_stream(content))
        elif opcode in _PLAIN:
            yield self._plain(opcode, content)

    def _plain(self, opcode: int, content: bytes) -> Any:
        record = _PLAIN[Opcode(opcode)].read(_stream(content))
        if isinstance(record, Channel) and (self._topics is None or record.topic in self._topics):
            self._wanted.add(record.id)
        return record

    def _spend(self, count: int) -> None:
        self._swelling -= count
        if self._swelling < 0:
            raise Broken("it unpacks to far more than a flight")

    def _inside(self, records: bytes) -> list[Any]:
        """All of a chunk or nothing: what is yielded has been read to its end."""
        found: list[Any] = []
        place, end, head, message = 0, len(records), _HEAD, _MESSAGE
        wanted = self._wanted
        while place < end:
            opcode, length = head.unpack_from(records, place)
            start = place + head.size
            place = start + length
            if place > end:
                raise Broken(f"it is damaged near byte {self.place} (a record beyond its chunk)")
            if opcode == Opcode.MESSAGE:
                channel, _, log_time, _ = message.unpack_from(records, start)
                if channel in wanted:
                    found.append(Raw(channel, log_time, records[start + message.size : place]))
            elif opcode in _PLAIN:
                found.append(self._plain(opcode, records[start:place]))
            self._count(opcode)
        return found

    def _count(self, opcode: int) -> None:
        """0 is no opcode: a hole of zeros would be read as millions of empty records."""
        if opcode == 0:
            raise Broken(f"it is damaged near byte {self.place} (zeros)")
        self._crowd -= 1
        if self._crowd < 0:
            raise Broken("it holds far more records than a flight")


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(content))


def _unpacked(content: bytes, spend: Any) -> bytes:
    """A chunk's records; Broken when its sizes or its checksum are not to be believed."""
    _, _, size, checksum, named = struct.unpack_from("<QQQII", content)
    compression = content[32 : 32 + named]
    (length,) = struct.unpack_from("<Q", content, 32 + named)
    packed = content[40 + named : 40 + named + length]
    if max(size, len(packed)) > RECORD_LIMIT:
        raise Broken("a chunk is too large")
    spend(size)
    if compression == b"zstd":
        if zstandard.frame_content_size(packed) > RECORD_LIMIT:  # -1: unknown
            raise Broken("a chunk is too large")
        records = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    elif compression == b"lz4":
        from lz4.frame import LZ4FrameDecompressor

        records = LZ4FrameDecompressor().decompress(packed, max_length=size)
    elif compression == b"":
        records = packed
    else:
        raise Broken(f"a chunk is packed in an unknown way, {compression[:20]!r}")
    if len(records) != size or (checksum and zlib.crc32(records) != checksum):
        raise Broken("a chunk's checksum is wrong")
    return records


def _needless(stream: IO[bytes], size: int, topics: Collection[str] | None) -> dict[int, int]:
    """Place -> length of each chunk without any of the topics, with its message indexes.

    By the file's own summary, if its checksum is right; empty otherwise.
    """
    if topics is None:
        return {}
    try:
        channels, chunks = _summary(stream, size)
    except Exception:  # cut or damaged: then every chunk is looked into
        return {}
    finally:
        stream.seek(len(MAGIC))
    wanted = {channel.id for channel in channels if channel.topic in topics}
    return {place: length for place, length, held in chunks if held and not wanted & held}


def _summary(stream: IO[bytes], size: int) -> tuple[list[Channel], list[tuple[int, int, set[int]]]]:
    """The channels that the file's end tells of, and of each chunk its place, its length with its
    message indexes, and its channels. Raises anything when it is damaged."""
    tail = _HEAD.size + _FOOTER.size + len(MAGIC)
    stream.seek(size - tail)
    footer = stream.read(tail)
    start, _, checksum = _FOOTER.unpack_from(footer, _HEAD.size)
    if not footer.endswith(MAGIC) or not checksum or not 0 < size - tail - start <= RECORD_LIMIT:
        raise Broken("no summary")
    stream.seek(start)
    summary = stream.read(size - tail - start)
    if zlib.crc32(footer[: _HEAD.size + 16], zlib.crc32(summary)) != checksum:
        raise Broken("the summary's checksum is wrong")
    channels, chunks, place = [], [], 0
    while place < len(summary):
        opcode, length = _HEAD.unpack_from(summary, place)
        content = summary[place + _HEAD.size : place + _HEAD.size + length]
        place += _HEAD.size + length
        if opcode == Opcode.CHANNEL:
            channels.append(Channel.read(_stream(content)))
        elif opcode == Opcode.CHUNK_INDEX:
            chunks.append(_chunk_index(content))
    return channels, chunks


def _chunk_index(content: bytes) -> tuple[int, int, set[int]]:
    """Place, length with message indexes, channels: the parts of a ChunkIndex that matter here."""
    _, _, start, length, listed = _CHUNK_INDEX.unpack_from(content)
    place = _CHUNK_INDEX.size
    channels = {channel for channel, _ in _PAIR.iter_unpack(content[place : place + listed])}
    (indexes,) = struct.unpack_from("<Q", content, place + listed)
    return start, length + indexes, channels
