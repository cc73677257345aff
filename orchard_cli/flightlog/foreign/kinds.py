"""Whose log a file is, by its first bytes and records."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

from mcap.records import Channel, Metadata

from orchard_cli.errors import InputError
from orchard_cli.flightlog.scan import Raw, Scan

_ULOG = b"ULog\x01\x12\x35"
_LOOKED_AT = 2000  # records before it is given up to find a channel


class Kind(Enum):
    """Who wrote a log."""

    OURS = "orchard"
    ROS2 = "ROS 2"
    ULOG = "PX4"


def kind_of(path: Path) -> Kind:
    """OURS too when it cannot be told: the reader of our logs says best what is wrong."""
    try:
        if not path.is_file():
            return Kind.OURS
        with path.open("rb") as stream:
            if stream.read(len(_ULOG)) == _ULOG:
                return Kind.ULOG
        return _of_mcap(path)
    except (OSError, InputError):
        return Kind.OURS


def _of_mcap(path: Path) -> Kind:
    found = Kind.OURS
    for number, record in enumerate(Scan(path)):
        if isinstance(record, Metadata) and record.name == "orchard":
            return Kind.OURS
        if isinstance(record, Channel) and record.message_encoding == "cdr":
            found = Kind.ROS2
        if number > _LOOKED_AT or isinstance(record, Raw):
            break
    return found
