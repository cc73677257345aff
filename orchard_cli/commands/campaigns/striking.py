"""How each fault is made to happen, and what shows from outside that it did."""

from __future__ import annotations

import math
import os
import resource
import signal
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from orchard_cli.model.records import TruthRecord
from orchard_cli.model.world import Pole
from orchard_cli.simulator import SimulatorProcess
from orchard_cli.simulator.faults import (
    Appearance,
    BatteryDrop,
    CameraFault,
    ClockStep,
    EstimateJump,
    Failure,
    GpsLoss,
    WindChange,
)
from orchard_cli.simulator.mavlink.relay import Relay

from .fault_world import EMPTY_AFTER
from .troubles import Trouble, Troubles

LASTS = 4.0  # s, of what passes
STORM = 13.0  # m/s
LOW, CRITICAL = 0.19, 0.09  # shares of the battery
JUMP, STEP = 1.5, 5.0  # m, s
PERSON_AHEAD, EMERGENCY = 3.5, 1.3  # m ahead of the airframe's centre
STATION_MODE = "hold"


@dataclass(slots=True)
class Scene:
    """Everything that a fault can take hold of."""

    simulator: SimulatorProcess
    relay: Relay
    troubles: Troubles
    pid: int  # of the flight
    log: Path
    truth: TruthRecord | None = None  # newest
    since: float = math.inf  # s, when the fault was injected
    later: list[tuple[float, Callable[[], None]]] = field(default_factory=list)
    appeared: list[Pole] = field(default_factory=list)
    frames: list[tuple[float, int, bool, float]] = field(default_factory=list)
    before: dict[str, float] = field(default_factory=dict)

    def at(self, seconds: float, act: Callable[[], None]) -> None:
        """Do something so long after the fault."""
        self.later.append((self.since + seconds, act))

    def run_due(self, now: float) -> None:
        """Do what has fallen due."""
        due = [act for time, act in self.later if time <= now]
        self.later = [(time, act) for time, act in self.later if time > now]
        for act in due:
            act()


def _camera(failure: Failure) -> Callable[[Scene], None]:
    return lambda s: s.simulator.inject(CameraFault(failure, LASTS))


def _trouble(kind: Trouble) -> Callable[[Scene], None]:
    return lambda s: s.troubles.begin(kind, s.since + LASTS)


def _cut(seconds: float) -> Callable[[Scene], None]:
    def act(s: Scene) -> None:
        s.relay.whole.clear()
        s.at(seconds, s.relay.whole.set)

    return act


def _reboot(s: Scene) -> None:
    s.relay.kill_motors()
    _cut(3.0)(s)


def _jumps(s: Scene) -> None:
    for k in range(6):
        step = (0.0, JUMP if k % 2 else -1.2 * JUMP, 0.0)
        s.at(3.0 * k, partial(s.simulator.inject, EstimateJump(step)))


def _pilot(s: Scene) -> None:
    s.relay.take_over("pilot")
    for k in range(1, 100):
        s.at(0.1 * k, s.relay.sticks)


def _station(s: Scene) -> None:
    s.relay.take_over(STATION_MODE)


def _garbage(s: Scene) -> None:
    rng = np.random.default_rng(0)
    for k in range(100):
        s.at(0.04 * k, lambda: s.relay.babble(b"\xfd" + rng.bytes(int(rng.integers(1, 300)))))


def _appear(ahead: float, radius: float, height: float) -> Callable[[Scene], None]:
    def act(s: Scene) -> None:
        assert s.truth is not None
        velocity = s.truth.velocity_site[:2]
        way = velocity / max(float(np.hypot(*velocity)), 1e-6)
        x, y = s.truth.position_site[:2] + way * (ahead + radius)
        pole = Pole(float(x), float(y), radius, height)
        s.appeared.append(pole)
        s.simulator.inject(Appearance(pole))

    return act


def _disk_full(s: Scene) -> None:
    room = s.log.stat().st_size if s.log.exists() else 0
    s.before["size"] = room
    resource.prlimit(s.pid, resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))


def _signal(number: int) -> Callable[[Scene], None]:
    return lambda s: os.kill(s.pid, number)


def _stop_and_go_on(s: Scene) -> None:
    os.kill(s.pid, signal.SIGSTOP)
    s.at(3.0, lambda: os.kill(s.pid, signal.SIGCONT))


STRIKES: Mapping[str, Callable[[Scene], None]] = {
    "frames late": _camera(Failure.SILENT),
    "frames frozen": _camera(Failure.FROZEN),
    "frames blank": _camera(Failure.BLANK),
    "frames garbage": _camera(Failure.GARBAGE),
    "poses late": _trouble(Trouble.POSES_LATE),
    "GPS lost": lambda s: s.simulator.inject(GpsLoss(LASTS + 2.0)),
    "estimator reset": lambda s: s.simulator.inject(EstimateJump((0.4, JUMP, 0.3))),
    "GPS jumping": _jumps,
    "wind": lambda s: s.simulator.inject(WindChange((0.0, STORM, 0.0))),
    "planner late": _trouble(Trouble.PLANNER_LATE),
    "planner throwing": _trouble(Trouble.PLANNER_THROWS),
    "planner hanging": _trouble(Trouble.PLANNER_HANGS),
    "link cut 3 s": _cut(3.0),
    "link cut 15 s": _cut(15.0),
    "autopilot rebooted": _reboot,
    "pilot takes over": _pilot,
    "second ground station": _station,
    "MAVLink garbage": _garbage,
    "battery low": lambda s: s.simulator.inject(BatteryDrop(LOW)),
    "battery critical": lambda s: s.simulator.inject(BatteryDrop(CRITICAL)),
    "tank empty": lambda _: None,  # it took off with too little
    "fence near": lambda _: None,  # it has been there all the time
    "person ahead": _appear(PERSON_AHEAD, 0.3, 3.4),
    "emergency distance": _appear(EMERGENCY, 0.15, 6.0),
    "disk full": _disk_full,
    "clock step": lambda s: s.simulator.inject(ClockStep(STEP)),
    "SIGTERM": _signal(signal.SIGTERM),
    "SIGKILL": _signal(signal.SIGKILL),
    "SIGSTOP": _stop_and_go_on,
}


def _tilt(s: Scene) -> str:
    if s.truth is None:
        return ""
    _, x, y, _ = s.truth.site_from_body
    tilt = math.degrees(2 * math.asin(min(1.0, math.hypot(x, y))))
    return f"tilted by {tilt:.0f}° in level flight" if tilt > 8.0 else ""


def _frames(wanted: str) -> Callable[[Scene], str]:
    """By the images that the simulator shows: none, the same again, empty, or without sense."""
    return lambda s: told if (told := _images(s)).startswith(wanted) else ""


def _images(s: Scene) -> str:
    after = [frame for frame in s.frames if frame[0] > s.since + 0.2]
    now = s.simulator.clock.now()
    newest = s.frames[-1][0] if s.frames else 0.0
    if now - max(newest, s.since) > 0.6:
        return f"no frame for {now - max(newest, s.since):.1f} s"
    if len(after) < 4:
        return ""
    if not any(frame[2] for frame in after[-3:]):
        return "empty frames"
    if len({frame[1] for frame in after[-4:]}) == 1:
        return "the same frame again and again"
    return "frames at random" if min(frame[3] for frame in after[-3:]) > 15000 else ""


def _hits(s: Scene) -> str:
    return f"struck {s.troubles.hits} times" if s.troubles.hits else ""


def _process(s: Scene) -> str:
    try:
        state = Path(f"/proc/{s.pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (OSError, IndexError):
        return "the process is gone"
    return {"T": "the process is stopped", "Z": "the process is gone"}.get(state, "")


def _believed(s: Scene) -> str:
    if s.truth is None:
        return ""
    north, east, _ = s.relay.heard.position_ned
    shift = math.hypot(north - s.before["north"], east - s.before["east"])
    moved = float(np.hypot(*(s.truth.position_site[:2] - [s.before["x"], s.before["y"]])))
    return f"the estimate jumped by {abs(shift - moved):.1f} m" if abs(shift - moved) > 0.8 else ""


def _boot(s: Scene) -> str:
    stepped = s.relay.heard.boot_s - s.before["boot"] - (s.simulator.clock.now() - s.since)
    return f"its clock stepped by {stepped:.1f} s" if stepped > 0.8 * STEP else ""


def _silent(s: Scene) -> str:
    quiet = s.simulator.clock.now() - s.relay.heard.carried_at
    return f"nothing carried for {quiet:.1f} s" if quiet > 1.5 else ""


def _full(s: Scene) -> str:
    grown = s.log.stat().st_size - s.before["size"] if s.log.exists() else 0
    later = s.simulator.clock.now() - s.since > 3.0
    return "the log's file grows no more" if later and grown <= 0 else ""


def _battery(s: Scene) -> str:
    share = s.relay.heard.battery
    return f"battery told at {share:.0%}" if share <= LOW + 0.01 else ""


def _mode(wanted: str) -> Callable[[Scene], str]:
    return lambda s: f"mode {wanted}" if s.relay.heard.mode == wanted else ""


def _pumped(s: Scene) -> str:
    pumped = [time for time, what in s.relay.heard.asked if what == "pump"]
    spent = pumped and s.simulator.clock.now() - pumped[0] > 2 * EMPTY_AFTER
    return f"pump asked for {len(pumped)} times, on at {pumped[0]:.1f} s" if spent else ""


EVIDENCE: Mapping[str, Callable[[Scene], str]] = {
    "frames late": _frames("no frame"), "frames frozen": _frames("the same"),
    "frames blank": _frames("empty"), "frames garbage": _frames("frames at random"),
    "poses late": _hits, "planner late": _hits, "planner throwing": _hits,
    "planner hanging": _hits,
    "GPS lost": lambda s: "no fix told" if s.relay.heard.fix < 3 else "",
    "estimator reset": _believed, "GPS jumping": _believed,
    "wind": _tilt,
    "link cut 3 s": _silent, "link cut 15 s": _silent,
    "autopilot rebooted": lambda s: "" if s.relay.heard.armed else "disarmed",
    "pilot takes over": _mode("pilot"), "second ground station": _mode(STATION_MODE),
    "MAVLink garbage": lambda s: "100 pieces sent" if not s.later else "",
    "battery low": _battery, "battery critical": _battery,
    "tank empty": _pumped,
    "fence near": lambda _: "the pole leaves no room inside the fence",
    "person ahead": lambda s: "somebody appeared" if s.appeared else "",
    "emergency distance": lambda s: "a pole appeared" if s.appeared else "",
    "disk full": _full, "clock step": _boot,
    "SIGTERM": lambda _: "sent", "SIGKILL": _process, "SIGSTOP": _process,
}  # fmt: skip
