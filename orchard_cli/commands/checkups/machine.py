"""The computer: cores, disk, clock, ports."""

from __future__ import annotations

import ctypes
import os
import shutil
import socket
import tempfile
import time
from pathlib import Path

from .finding import Finding, Verdict, judged

LEAST_DISK = 2e9  # bytes: an hour of flight with depth images at 2 Hz
SLOWEST_SYNC = 0.2  # s for 1 MB to reach the disk
PORTS = ((14540, "the autopilot's usual port"), (8765, "the live view"))
_UNSYNCHRONISED = 0x0040  # STA_UNSYNC of adjtimex(2)


def machine(folder: Path) -> list[Finding]:
    """Everything of the computer; logs would be written to `folder`."""
    return [cores(), *disk(folder), clock(), *(port(number, use) for number, use in PORTS)]


def cores() -> Finding:
    """Control loop, mapping and log each want their time."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    load = os.getloadavg()[0]
    found = f"{count}, load {load:.1f}"
    if (count or 1) < 2:
        return Finding("machine", "cores", found, Verdict.BAD, "fly on two cores or more")
    return judged(
        "machine", "cores", found, load < (count or 1),
        "other programs are busy: end them before flying", Verdict.NOTE,
    )  # fmt: skip


def disk(folder: Path) -> list[Finding]:
    """Room for logs, and how long a write takes to reach the disk."""
    free = shutil.disk_usage(folder).free
    room = judged(
        "machine", "disk", f"{free / 1e9:.1f} GB free in {folder}", free > LEAST_DISK,
        "make room: a flight of 10 minutes writes about 0.3 GB",
    )  # fmt: skip
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(os.urandom(2**20))
            began = time.monotonic()
            os.fsync(file.fileno())
            took = time.monotonic() - began
    except OSError as error:
        why = f"cannot be written: {error.strerror}"
        return [room, Finding("machine", "disk writes", why, Verdict.BAD, "fly from elsewhere")]
    slow = judged(
        "machine", "disk writes", f"1 MB in {took * 1e3:.0f} ms", took < SLOWEST_SYNC,
        "a slow disk drops images from the log; the flight itself does not wait", Verdict.NOTE,
    )  # fmt: skip
    return [room, slow]


def clock() -> Finding:
    """Whether the system keeps UTC; flights do not need it, their logs' times do."""
    now = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime())
    state = _clock_status()
    if state is None:
        return Finding("machine", "clock", f"{now}; whether it is set is not known", Verdict.NOTE)
    return judged(
        "machine", "clock", now, not state & _UNSYNCHRONISED,
        "not synchronised: the log's times may be wrong; set it by NTP or GPS", Verdict.NOTE,
    )  # fmt: skip


def _clock_status() -> int | None:
    """The kernel's status word of its clock (adjtimex, read only); None where there is none."""
    buffer = (ctypes.c_long * 64)()  # struct timex is shorter; modes = 0 reads
    try:
        if ctypes.CDLL(None).adjtimex(ctypes.byref(buffer)) < 0:
            return None
    except (OSError, AttributeError):
        return None
    # modes (int, padded), offset, freq, maxerror, esterror, status (int)
    return int(ctypes.c_int.from_address(ctypes.addressof(buffer) + 5 * 8).value)


def port(number: int, use: str) -> Finding:
    """Whether a port can be bound; another program there would steal or miss packets."""
    kind = socket.SOCK_DGRAM if number == PORTS[0][0] else socket.SOCK_STREAM
    with socket.socket(socket.AF_INET, kind) as probe:
        try:
            probe.bind(("127.0.0.1", number))
        except OSError as error:
            return Finding(
                "machine", f"port {number}", f"{use}: {error.strerror}", Verdict.NOTE,
                "another program has it: end that one, or use another port",
            )  # fmt: skip
    return Finding("machine", f"port {number}", f"{use}: free")
