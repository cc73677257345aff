"""Damaged and hostile logs: bytes changed, cut, doubled; or whole files that tell nonsense."""

from __future__ import annotations

import io
import random
import re
from functools import lru_cache
from pathlib import Path

from mcap.records import Attachment, Channel, Metadata, Schema
from mcap.writer import Writer

from orchard_cli.flightlog.scan import Raw, Scan

NUMBERS = (
    b"1e300",
    b"-1e300",
    b"0",
    b"-0.0",
    b"1e-300",
    b"9007199254740993",
    b"null",
    b'""',
    b"[]",
)
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


@lru_cache
def _records(path: Path) -> tuple:
    return tuple(Scan(path))


def mutated(path: Path, seed: int) -> bytes:
    """The log at `path`, changed in a way that follows from the seed."""
    chance = random.Random(seed)
    kind = (_flipped, _spliced, _lying, _nonsense)[seed % 4]
    return kind(path, chance)


def _flipped(path: Path, chance: random.Random) -> bytes:
    data = bytearray(path.read_bytes())
    for _ in range(chance.choice((1, 3, 30, 300))):
        data[chance.randrange(len(data))] = chance.randrange(256)
    return bytes(data[: chance.choice((len(data), chance.randrange(len(data))))])


def _spliced(path: Path, chance: random.Random) -> bytes:
    data = path.read_bytes()
    a, b, c = (chance.randrange(len(data)) for _ in range(3))
    return data[:a] + data[min(b, c) : max(b, c)] * chance.choice((1, 2, 5)) + data[a:]


def _lying(path: Path, chance: random.Random) -> bytes:
    """Lengths and counts are where it hurts: eight bytes of a large number somewhere."""
    data = bytearray(path.read_bytes())
    for _ in range(chance.choice((1, 2, 8))):
        at = chance.randrange(8, len(data) - 8)
        data[at : at + 8] = chance.choice((2**63, 2**40, 2**31, 0, 1)).to_bytes(8, "little")
    return bytes(data)


def _nonsense(path: Path, chance: random.Random) -> bytes:
    """A whole file with right checksums, whose messages, metadata or mission tell nonsense."""
    out = io.BytesIO()
    writer = Writer(out, chunk_size=chance.choice((1000, 100_000)))
    writer.start()
    schemas, channels = {}, {}
    rate = chance.choice((0.0, 0.001, 0.05, 1.0))
    for record in _records(path):
        match record:
            case Schema():
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, _bent(record.data, chance, rate / 20)
                )
            case Channel():
                channels[record.id] = writer.register_channel(
                    record.topic, record.message_encoding, schemas[record.schema_id]
                )
            case Raw() if chance.random() > rate / 10:
                data = _bent(record.data, chance, rate)
                time = chance.choice((0, 2**63)) if chance.random() < rate else record.log_time
                writer.add_message(channels[record.channel_id], time, data, time)
            case Attachment():
                data = _bent(record.data, chance, rate)
                writer.add_attachment(0, 0, record.name, record.media_type, data)
            case Metadata():
                told = dict(record.metadata)
                if chance.random() < rate:
                    told[chance.choice(list(told))] = chance.choice(("", "x" * 9999, "\x1b[31m"))
                writer.add_metadata(record.name, told)
    writer.finish()
    return out.getvalue()


def _bent(data: bytes, chance: random.Random, rate: float) -> bytes:
    if chance.random() >= rate:
        return data
    if data[:1] == b"{" and chance.random() < 0.8:
        spots = list(NUMBER.finditer(data))
        if spots:
            spot = chance.choice(spots)
            return data[: spot.start()] + chance.choice(NUMBERS) + data[spot.end() :]
    changed = bytearray(data)
    for _ in range(min(len(changed), 4)):
        changed[chance.randrange(len(changed))] = chance.randrange(256)
    return bytes(changed)
