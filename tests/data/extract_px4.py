"""How px4_pi_20x6.* were made: python tests/data/extract_px4.py flight_pi_20x6.tlog

The tlog is a recording of a real PX4 (main of March 2026, SIH) flown by MAVSDK 4.1.0. Kept of it:
every frame that the client sent, with its time, and of the autopilot's side what the replay test
compares: answers, modes, landed states, rates, parameters, tracking.
"""

from __future__ import annotations

import json
import lzma
import os
import struct
import sys
from collections import Counter
from pathlib import Path
from typing import Any

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil

CLIENT = 195  # component id
PHASES = {"before": (1.6, 6.2), "offboard": (30.0, 80.0)}  # s


def main(tlog: str) -> None:
    log = mavutil.mavlink_connection(tlog, dialect="development")
    frames = bytearray()
    told: dict[str, Any] = {"acks": [], "modes": [], "landed": [], "params": {}, "errors": []}
    counts: dict[str, Counter[str]] = {name: Counter() for name in PHASES}
    start = None
    while (m := log.recv_msg()) is not None:
        start = m._timestamp if start is None else start
        t, kind = m._timestamp - start, m.get_type()
        if m.get_srcComponent() == CLIENT:
            raw = bytes(m.get_msgbuf())
            frames += struct.pack("<dH", t, len(raw)) + raw
            continue
        for name, (first, last) in PHASES.items():
            counts[name][kind] += first <= t < last
        if kind == "COMMAND_ACK":
            told["acks"].append([round(t, 3), m.command, m.result])
        elif kind == "PARAM_VALUE" and 6.6 < t < 10.6:
            told["params"][m.param_id] = [m.param_value, m.param_type]
        elif kind == "PARAM_ERROR":
            told["errors"].append([m.param_id, m.error])
        elif kind == "HEARTBEAT":
            changed(told["modes"], t, [m.base_mode, m.custom_mode])
        elif kind == "EXTENDED_SYS_STATE":
            changed(told["landed"], t, [m.landed_state])
    told["rates"] = {
        name: {kind: n / (PHASES[name][1] - PHASES[name][0]) for kind, n in counted.items() if n}
        for name, counted in counts.items()
    }
    told["phases"] = PHASES
    here = Path(__file__).parent
    (here / "px4_pi_20x6.client.xz").write_bytes(lzma.compress(bytes(frames), preset=9))
    text = json.dumps(told, indent=1, sort_keys=True)
    (here / "px4_pi_20x6.autopilot.json").write_text(text + "\n", encoding="utf-8")


def changed(rows: list[list[Any]], t: float, value: list[Any]) -> None:
    """Add a row when the value differs from the last one's."""
    if not rows or rows[-1][1:] != value:
        rows.append([round(t, 3), *value])


if __name__ == "__main__":
    main(sys.argv[1])
