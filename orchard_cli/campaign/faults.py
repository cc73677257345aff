"""Faults, the phases that they strike in, and what the vehicle must then do.

Judged by what an observer saw of the vehicle, never by what the flight says of itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from orchard_cli.model.arrays import Array, Vector

PHASES = ("route", "avoidance", "take-off", "landing", "return")
STILL = 0.35  # m/s, level: it stands, in gusts too
STANDS = 0.6  # s for which it must
STOP_WITHIN = 4.0  # s: half a second to see it, and braking from 1 m/s by 0.5 m/s²
MODE_TOLD = 2.0  # s: modes are told once a second, and heard a little later
NEAR_PLACE = 3.0  # m from a place: at it
LAND_WITHIN = 45.0  # s: half a minute of looking for a free place, and coming down
LOG_LOSS = 1.0  # s of log that may be lost at the end
DOWN = 0.4  # m above the ground


class Reaction(Enum):
    """What must be seen of the vehicle after a fault. A contact is never allowed."""

    GO_ON = "goes on and lands at the end of the route"
    STOP = "stands within 4 s (GPS: 6 s), then ends safe"
    HOME = "comes back to the take-off place"
    LAND = "lands within 45 s, near by"
    QUIET = "nothing is sent or asked any more, and the mode stays"
    SAFE = "ends on the ground, or standing in the autopilot's own hold"
    DEAD = "nothing is sent or asked any more"


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that goes wrong, and what must follow."""

    name: str
    moving: Reaction  # on the route, in an avoidance, on the way back
    otherwise: Reaction = Reaction.SAFE  # taking off and landing, which the autopilot flies
    phases: tuple[str, ...] = PHASES
    within: float = STOP_WITHIN  # s until it must stand, where that must follow
    unheard: float = 0.0  # s for which it cannot be known, the link being down
    real_time: bool = False  # its limits are in real time
    ends_flight: bool = False  # the flight program ends with it: nothing lands the vehicle

    def reaction(self, phase: str) -> Reaction:
        """What must follow in a phase."""
        return self.otherwise if phase in ("take-off", "landing") else self.moving


_R = Reaction
_EYES = ("take-off", "route", "avoidance", "return")
_FLYING = ("route", "avoidance", "return")
FAULTS: Mapping[str, Fault] = {
    fault.name: fault
    for fault in (
        Fault("frames late", _R.STOP, phases=_EYES),
        Fault("frames frozen", _R.STOP, phases=_EYES),
        Fault("frames blank", _R.STOP, phases=_EYES),
        Fault("frames garbage", _R.STOP, phases=_EYES),
        Fault("poses late", _R.STOP, phases=_EYES),
        Fault("GPS lost", _R.STOP, within=6.0),  # told for 2 s before it counts
        Fault("estimator reset", _R.STOP),
        Fault("GPS jumping", _R.SAFE, phases=_FLYING),
        Fault("wind", _R.SAFE),
        Fault("planner late", _R.STOP, phases=_EYES),
        Fault("planner throwing", _R.STOP, phases=_EYES),
        Fault("planner hanging", _R.STOP, phases=_EYES),
        Fault("link cut 3 s", _R.STOP, real_time=True),
        Fault("link cut 15 s", _R.STOP, real_time=True),
        Fault("autopilot rebooted", _R.DEAD, _R.DEAD, phases=("route",), unheard=3.0),
        Fault("pilot takes over", _R.QUIET, _R.QUIET),
        Fault("second ground station", _R.QUIET, _R.QUIET),
        Fault("MAVLink garbage", _R.GO_ON, phases=("take-off", "route", "avoidance", "landing")),
        Fault("battery low", _R.SAFE),
        Fault("battery critical", _R.LAND),
        Fault("tank empty", _R.GO_ON, phases=("route",)),
        Fault("fence near", _R.SAFE, phases=("avoidance",)),
        Fault("person ahead", _R.SAFE, phases=_FLYING),
        Fault("emergency distance", _R.STOP, phases=_FLYING),
        Fault("disk full", _R.GO_ON, phases=("take-off", "route", "avoidance", "landing")),
        Fault("clock step", _R.SAFE),
        Fault("SIGTERM", _R.HOME),
        Fault("SIGKILL", _R.STOP, real_time=True, ends_flight=True),
        Fault("SIGSTOP", _R.STOP, real_time=True, ends_flight=True),
    )
}


@dataclass(frozen=True, slots=True, eq=False)
class Observed:
    """What was seen of one flight from outside."""

    times: Array  # (n,) s, simulated
    positions_site: Array  # (n, 3) m, true
    velocities_site: Array  # (n, 3) m/s, true
    distances: Array  # (n,) m from the airframe's centre to the nearest thing
    modes: tuple[str, ...]  # (n,), as the autopilot tells
    armed: tuple[bool, ...]  # (n,)
    setpoints_at: Array  # (n,) s: when the newest setpoint went by
    injected: float | None  # s; None: the phase was never reached
    evidence: str  # what shows that the fault happened; empty: nothing
    contact: str
    asked: tuple[tuple[float, str], ...]  # what the flight asked the autopilot for, and when
    ended: float | None  # s, when the flight program ended; None: it did not
    crashed: str  # how the flight program ended, when it did not end by itself; else empty
    log_until: float | None  # s, the newest record that the log gives back
    log_fault: str
    takeoff_site: Vector  # (2,) m
    landing_site: Vector  # (2,) m


def judge_fault(fault: Fault, phase: str, seen: Observed) -> tuple[str, bool]:
    """What the vehicle did, in words, and whether that is what must follow."""
    if seen.injected is None:
        return "the phase was not reached", False
    if seen.contact and fault.moving is not Reaction.DEAD:
        return f"touched {seen.contact}", False
    told, ok = _RULES[fault.reaction(phase)](fault, seen, seen.injected)
    log = _log_lost(fault, seen)
    if seen.crashed and not fault.ends_flight:
        log, ok = [f"the flight program {seen.crashed}", *log], False
    nearest = seen.distances[seen.times >= seen.injected].min(initial=np.inf)
    words = [told, *([f"nearest {nearest:.2f} m"] if np.isfinite(nearest) else []), *log]
    return "; ".join(words), ok and bool(seen.evidence) and not log


def _log_lost(fault: Fault, seen: Observed) -> list[str]:
    """It must go on to when the flight last spoke; to a full disk, until that was full."""
    if seen.log_fault:
        return [f"log: {seen.log_fault}"]
    if seen.log_until is None:
        return ["the log holds nothing"]
    spoke = max([seen.setpoints_at[-1], *(time for time, _ in seen.asked)])
    end = seen.injected if fault.name == "disk full" else spoke
    if end is not None and seen.log_until < end - LOG_LOSS:
        return [f"the log's last {end - seen.log_until:.1f} s are lost"]
    return []


def stopped_at(seen: Observed, since: float) -> float | None:
    """When it first stood, level, for STANDS seconds after `since`; None: it never did."""
    level = np.hypot(seen.velocities_site[:, 0], seen.velocities_site[:, 1])
    begun: float | None = None
    for time, speed in zip(seen.times, level, strict=True):
        if time < since or speed > STILL:
            begun = None
        elif begun is None:
            begun = float(time)
        elif time - begun >= STANDS:
            return begun
    return None


def _down(seen: Observed) -> bool:
    return not seen.armed[-1] and bool(seen.positions_site[-1, 2] < DOWN)


def _safe(fault: Fault, seen: Observed, since: float) -> tuple[str, bool]:
    del fault
    if _down(seen):
        home = _near(seen, seen.takeoff_site)
        where = "at take-off" if home else "at the end" if _near(seen, seen.landing_site) else "out"
        return f"landed {where} after {seen.times[-1] - since:.1f} s", True
    level = float(np.hypot(*seen.velocities_site[-1, :2]))
    if seen.modes[-1] == "hold" and level < STILL:
        return "stands in the autopilot's hold", True
    return f"in the air in {seen.modes[-1]} at {level:.2f} m/s", False


def _near(seen: Observed, place: Vector) -> bool:
    return bool(np.hypot(*(seen.positions_site[-1, :2] - place)) < NEAR_PLACE)


def _stop(fault: Fault, seen: Observed, since: float) -> tuple[str, bool]:
    at, (told, safe) = stopped_at(seen, since), _safe(fault, seen, since)
    if at is None:
        return f"never stood; {told}", False
    here = np.searchsorted(seen.times, [since, at])
    way = float(np.hypot(*np.ptp(seen.positions_site[here, :2], axis=0)))
    return f"stood after {at - since:.1f} s and {way:.1f} m; {told}", (
        safe and at - since <= fault.within
    )


def _go_on(fault: Fault, seen: Observed, since: float) -> tuple[str, bool]:
    told, _ = _safe(fault, seen, since)
    return told, _down(seen) and _near(seen, seen.landing_site)


def _home(fault: Fault, seen: Observed, since: float) -> tuple[str, bool]:
    told, _ = _safe(fault, seen, since)
    return told, _down(seen) and _near(seen, seen.takeoff_site)


def _land(fault: Fault, seen: Observed, since: float) -> tuple[str, bool]:
    told, _ = _safe(fault, seen, since)
    return told, _down(seen) and seen.times[-1] - since <= LAND_WITHIN


def _dead(fault: Fault, seen: Observed, since: float) -> tuple[str, bool]:
    known = since + fault.unheard + MODE_TOLD
    late = seen.setpoints_at[-1] - since
    asked = [what for time, what in seen.asked if time > known]
    told = f"last setpoint {max(late, 0.0):.1f} s after, asked for {', '.join(asked) or 'nothing'}"
    return told, seen.setpoints_at[-1] <= known and not asked


def _quiet(fault: Fault, seen: Observed, since: float) -> tuple[str, bool]:
    told, quiet = _dead(fault, seen, since)
    modes = {
        mode for time, mode in zip(seen.times, seen.modes, strict=True) if time > since + MODE_TOLD
    }
    return f"{told}; mode {' then '.join(sorted(modes))}", quiet and len(modes) == 1


_RULES = {
    Reaction.GO_ON: _go_on,
    Reaction.STOP: _stop,
    Reaction.HOME: _home,
    Reaction.LAND: _land,
    Reaction.QUIET: _quiet,
    Reaction.SAFE: _safe,
    Reaction.DEAD: _dead,
}
