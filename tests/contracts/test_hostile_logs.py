"""A damaged or hostile log is measured as far as it goes, or refused in one line: exit code 2.

`ORCHARD_FUZZ=10000 pytest tests/contracts/test_hostile_logs.py --timeout 3000` tries that many.
"""

from __future__ import annotations

import os
import zlib

import pytest
from mutated_logs import mutated

from orchard_cli.commands.analyze_logs import measured
from orchard_cli.errors import InputError
from orchard_cli.flightlog import read
from orchard_cli.flightlog.scan import MAGIC

from .test_analyze import write_log

CASES = int(os.environ.get("ORCHARD_FUZZ", "24"))


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("hostile") / "whole.mcap")


def outcome(act, path):
    try:
        act(path)
    except InputError as error:
        return str(error)
    return "measured"


def test_mutated_logs_are_read_or_refused(log, tmp_path):
    for seed in range(CASES):
        path = tmp_path / "mutated.mcap"
        path.write_bytes(mutated(log, seed))
        assert "\n" not in outcome(read, path), seed


@pytest.mark.parametrize("seed", [3, 7, 11, 39, 43])
def test_whole_logs_that_tell_nonsense_are_measured_or_refused(log, tmp_path, seed):
    path = tmp_path / "nonsense.mcap"
    path.write_bytes(mutated(log, seed))
    outcome(measured, path)


def record(opcode, content):
    return bytes([opcode]) + len(content).to_bytes(8, "little") + content


def chunk(packed, size, compression=b"zstd"):
    head = (0).to_bytes(16, "little") + size.to_bytes(8, "little") + (0).to_bytes(4, "little")
    return record(6, head + len(compression).to_bytes(4, "little") + compression
                  + len(packed).to_bytes(8, "little") + packed)  # fmt: skip


@pytest.mark.parametrize("compression", [b"zstd", b"lz4"])
def test_a_log_that_unpacks_to_gigabytes_is_not_unpacked(tmp_path, compression):
    """mcap #1220, #1474: a MemoryError of a damaged log."""
    import lz4.frame
    import zstandard

    size = 60 * 2**20
    pack = zstandard.compress if compression == b"zstd" else lz4.frame.compress
    bomb = chunk(pack(bytes(size)), size, compression)
    path = tmp_path / "bomb.mcap"
    path.write_bytes(MAGIC + record(1, bytes(8)) + bomb * 100)
    said = outcome(read, path)
    assert "far more" in said or "damaged" in said


def test_a_log_of_millions_of_empty_records_is_given_up(tmp_path):
    import zstandard

    empty = bytes([5]) + (22).to_bytes(8, "little") + bytes(22)
    crowd = empty * 500_000
    path = tmp_path / "crowd.mcap"
    path.write_bytes(
        MAGIC + record(1, bytes(8)) + chunk(zstandard.compress(crowd), len(crowd)) * 40
    )
    assert "far more records" in outcome(read, path)


def test_a_file_of_zeros_is_no_millions_of_records(tmp_path):
    path = tmp_path / "zeros.mcap"
    path.write_bytes(MAGIC + bytes(20_000_000))
    assert "zeros" in outcome(read, path)


def test_a_chunk_that_tells_a_wrong_checksum_is_not_believed(tmp_path):
    told = record(5, bytes(22))
    head = (0).to_bytes(16, "little") + len(told).to_bytes(8, "little")
    head += (zlib.crc32(told) ^ 1).to_bytes(4, "little") + (0).to_bytes(4, "little")
    path = tmp_path / "wrong.mcap"
    path.write_bytes(MAGIC + record(6, head + len(told).to_bytes(8, "little") + told))
    assert "checksum is wrong" in outcome(read, path)
