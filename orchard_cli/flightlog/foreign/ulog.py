"""PX4 ULog -> FlownLog, in the mission's site frame."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.frames import ned_from_site
from orchard_cli.geometry.geodesy import site_from_wgs84
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.flown import Commands, FlownLog, Track
from orchard_cli.model.mission import Mission

PATIENCE = 60.0  # s of real time on a machine that is busy; the child's limits come first
_FLU_FROM_FRD = np.diag([1.0, -1.0, -1.0])


def read_ulog(path: Path, mission: Mission) -> FlownLog:
    """The estimated path, setpoints and battery of a PX4 flight.

    Its local frame is placed by the latitude and longitude that it tells itself; heights count
    from where the vehicle stood when the log began, on the mission's take-off ground. Raises
    InputError when there is no flight in it, or reading it takes too long or too much.
    """
    found = _arrays(path)
    local = _in_order(found.get("vehicle_local_position"), 10)
    attitude = _in_order(found.get("vehicle_attitude"), 5)
    if len(local) < 2 or len(attitude) < 2:
        raise InputError(Fault(str(path), "holds no position and attitude of a flight"))
    origin = _origin(path, local, mission)
    notes = ["from a PX4 log: clearance, spray and the planner are not in it"]
    if bool(found["corrupt"]):
        notes.append("it is damaged: what could be read is measured")
    if int(found["dropouts"]):
        notes.append(f"the logger dropped messages {int(found['dropouts'])} times")
    site_from_ned = ned_from_site(mission.orchard.origin.heading)
    setpoints = _in_order(found.get("trajectory_setpoint"), 11)
    battery = _in_order(found.get("battery_status"), 2)
    return FlownLog(
        file=path.name,
        metadata={"system": "PX4", "vehicle": "PX4", "site": mission.orchard.name,
                  "simulated": "unknown"},
        attachments={},
        odometry=_track(local, attitude, found, site_from_ned, origin),
        truth=None,
        commands=_commands(setpoints, site_from_ned, origin, mission.orchard.origin.heading),
        battery_times=battery[:, 0],
        battery_shares=battery[:, 1],
        notes=tuple(notes),
    )  # fmt: skip


def _arrays(path: Path) -> dict[str, Array]:
    """What the child process found. Raises InputError when it failed or took too long."""
    if find_spec("pyulog") is None:
        mend = "install it: pip install 'orchard-cli[logs]'"
        raise InputError(Fault(str(path), "needs pyulog to be read", mend))
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    child = [sys.executable, str(Path(__file__).with_name("ulog_child.py")), str(path.resolve())]
    try:
        done = subprocess.run(
            child, capture_output=True, timeout=PATIENCE, check=True, env=environment
        )
        with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays}
    except subprocess.TimeoutExpired:
        what = "takes too long to be read"
    except (subprocess.CalledProcessError, ValueError, OSError):
        what = "is damaged: it cannot be read"
    raise InputError(Fault(str(path), what, "copy it again from the vehicle"))


def _in_order(table: Array | None, width: int) -> Array:
    """Rows whose time goes on, all of them finite; none when the topic is not there."""
    if table is None or table.ndim != 2 or table.shape[1] != width:
        return np.empty((0, width))
    _, first = np.unique(table[:, 0], return_index=True)
    return np.asarray(table[first])


def _origin(path: Path, local: Array, mission: Mission) -> Points:
    """(3,) m, the local frame's origin in the site frame, its height by the ground under it."""
    place = local[np.isfinite(local[:, 7:10]).all(axis=1), 7:10]
    if not len(place):
        raise InputError(Fault(str(path), "does not tell where on earth it was flown"))
    x, y, _ = site_from_wgs84(mission.orchard.origin, place[-1:])[0]
    ground = mission.takeoff_ground + float(np.median(local[:50, 3]))  # z is down
    return np.array([x, y, ground])


def _track(
    local: Array, attitude: Array, found: dict[str, Array], site_from_ned: Array, origin: Points
) -> Track:
    from scipy.spatial.transform import Rotation, Slerp

    local = local[np.isfinite(local[:, :7]).all(axis=1)]
    good = np.isfinite(attitude).all(axis=1) & (np.linalg.norm(attitude[:, 1:], axis=1) > 0.5)
    attitude = attitude[good]
    local = local[(local[:, 0] >= attitude[0, 0]) & (local[:, 0] <= attitude[-1, 0])]
    times = local[:, 0]
    ned_from_frd = Slerp(attitude[:, 0], Rotation.from_quat(attitude[:, 1:], scalar_first=True))
    turned = site_from_ned @ ned_from_frd(times).as_matrix() @ _FLU_FROM_FRD
    rates = np.full((len(times), 3), np.nan)
    measured = _in_order(found.get("vehicle_angular_velocity"), 4)
    if len(measured):
        columns = [np.interp(times, measured[:, 0], measured[:, i]) for i in (1, 2, 3)]
        rates = np.column_stack(columns) @ _FLU_FROM_FRD
    return Track(
        times,
        local[:, 1:4] @ site_from_ned.T + origin,
        local[:, 4:7] @ site_from_ned.T,
        Rotation.from_matrix(turned).as_quat(scalar_first=True),
        rates,
    )


def _commands(table: Array, site_from_ned: Array, origin: Points, heading: float) -> Commands:
    """Setpoints with a position: a mode that commands velocities tells nothing of the route."""
    table = table[np.isfinite(table[:, :4]).all(axis=1)]
    return Commands(
        table[:, 0],
        table[:, 1:4] @ site_from_ned.T + origin,
        table[:, 4:7] @ site_from_ned.T,
        table[:, 7:10] @ site_from_ned.T,
        heading - table[:, 10],
    )
