"""Reads a PX4 ULog in a process of its own, within limits, and writes arrays to stdout.

pyulog trusts the sizes that a file tells: a damaged or hostile one could cost any amount of
memory and time. Here it can cost this process's. Run by `ulog.py` as a script: it imports nothing
of the package, so that it starts in a moment.
"""

from __future__ import annotations

import io
import resource
import sys
from pathlib import Path
from typing import Any

import numpy as np

MEMORY = 420 * 2**20, 6  # bytes, and per byte of the file
TIME = 3, 10e6  # s of processor time, and bytes read in one more
TOPICS = {
    "vehicle_local_position": "x y z vx vy vz ref_lat ref_lon ref_alt",
    "vehicle_attitude": "q[0] q[1] q[2] q[3]",
    "vehicle_angular_velocity": "xyz[0] xyz[1] xyz[2]",
    "trajectory_setpoint": "position[0] position[1] position[2] velocity[0] velocity[1] velocity[2]"
    " acceleration[0] acceleration[1] acceleration[2] yaw",
    "battery_status": "remaining",
}


def main() -> None:
    """Limit this process, read the file, write an .npz."""
    path = Path(sys.argv[1])
    size = path.stat().st_size
    memory = MEMORY[0] + MEMORY[1] * size
    seconds = int(TIME[0] + size / TIME[1])
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    out = io.BytesIO()
    np.savez(out, **_arrays(path))
    sys.stdout.buffer.write(out.getvalue())


def _arrays(path: Path) -> dict[str, Any]:
    from pyulog import ULog

    log = ULog(str(path), list(TOPICS), disable_str_exceptions=True)
    found: dict[str, Any] = {"corrupt": bool(log.file_corruption), "dropouts": len(log.dropouts)}
    for one in log.data_list:
        wanted = TOPICS[one.name].split()
        if one.name in found or not all(name in one.data for name in wanted):
            continue
        columns = [one.data["timestamp"] * 1e-6, *(one.data[name] for name in wanted)]
        found[one.name] = np.column_stack([np.asarray(c, dtype=np.float64) for c in columns])
    return found


if __name__ == "__main__":
    main()
