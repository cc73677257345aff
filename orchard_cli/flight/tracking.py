"""How well the autopilot follows, and what its plans have to leave room for.

A plan keeps `Limits.clearance` to the airframe's centre; what that leaves beyond the airframe is
for the autopilot (ASSUMED) and for the eyes. An autopilot that strays further beside what it is
told to fly gets the excess on top: the clearance grows by it, up to MOST. Strays beyond that hold
the flight (safety.py, `Tolerances.tracking`): the widest clearance less the error would be less
than the airframe.

A real PX4 in its own noisy simulation strays by 0.5 to 1.0 m; the simulator here by less than 0.3.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.mission import Limits
from orchard_cli.model.vehicle import Setpoint

ASSUMED = 0.3  # m beside its setpoint that every plan allows for
MOST = 0.5  # m by which the clearance grows at most
STEP = 0.1  # m: it grows in steps, so that not every cycle asks for another plan
FADING = 60.0  # s in which an error is forgotten to a third; for the hold
LASTING = 300.0  # s, likewise, for the clearance: an autopilot that strayed will stray again
MOVING = 0.3  # m/s of the setpoint from which only the error across its way counts
KEPT = 64  # setpoints: more than a second of them


@dataclass(frozen=True, slots=True)
class Tracking:
    """The greatest error lately: a peak that holds, and fades."""

    error: float = 0.0  # m, horizontal, beside what it was told to fly
    lasting: float = 0.0  # m, the same, forgotten more slowly; never less
    time: float = -math.inf  # s, of the pose that it was last judged by

    def after(self, error: float, time: float) -> Tracking:
        """With one more error, at a later time."""
        dt = max(time - self.time, 0.0)
        error_now = max(error, self.error * math.exp(-dt / FADING))
        lasting = max(error, self.lasting * math.exp(-dt / LASTING))
        return Tracking(error_now, lasting, max(time, self.time))

    @property
    def widening(self) -> float:
        """m to add to the clearance: what the lasting error exceeds ASSUMED by, in whole steps."""
        excess = self.lasting - ASSUMED
        return min(math.ceil(max(excess, 0.0) / STEP - 1e-9) * STEP, MOST)


STEADY = Tracking()


def beside(setpoint: Setpoint, position_site: Vector, time: float) -> float:
    """m from where a setpoint leads at `time` to the vehicle, horizontally.

    On the way only what is across it counts: lag does not lead off a path that is free. The slower
    the setpoint, the more of what is along its way counts too.
    """
    ahead = time - setpoint.time
    off = (position_site - setpoint.position_site - setpoint.velocity_site * ahead)[:2]
    velocity = setpoint.velocity_site[:2]
    speed = math.hypot(*velocity)
    if speed > 0.0:
        along = velocity / speed
        off = off - along * float(off @ along) * min(speed / MOVING, 1.0)
    return math.hypot(*off)


def widened(limits: Limits, widening: float) -> Limits:
    """The limits with more clearance; the same object when there is nothing to add."""
    return replace(limits, clearance=limits.clearance + widening) if widening else limits


class Follower:
    """Judges each new pose by the setpoint that was meant for its time."""

    def __init__(self) -> None:
        self.tracking = STEADY
        self._sent: deque[Setpoint] = deque(maxlen=KEPT)

    def sent(self, setpoint: Setpoint) -> None:
        """This was streamed."""
        self._sent.append(setpoint)

    def stopped(self) -> None:
        """Nothing is streamed any more; what comes next is another way."""
        self._sent.clear()

    def judge(self, position_site: Vector, time: float) -> None:
        """The vehicle was there at `time`. Poses before the first setpoint say nothing."""
        meant = next((one for one in reversed(self._sent) if one.time <= time), None)
        if meant is not None and time > self.tracking.time:
            error = beside(meant, np.asarray(position_site), time)
            self.tracking = self.tracking.after(error, time)
