"""Flying home: PX4's return to launch."""

from __future__ import annotations

import math

from orchard_cli.model.arrays import Vector
from orchard_cli.simulator.control import Demand

from .parameters import Parameters
from .seen import Seen
from .tasks import Land, Task


def return_height(distance: float, height: float, values: Parameters) -> float:
    """Height above home at which PX4 flies home from `distance` m at `height` (RTL_TYPE 0)."""
    wanted, acceptance = values["RTL_RETURN_ALT"], values["NAV_ACC_RAD"]
    if distance <= acceptance:
        wanted = 2.0 * distance
    else:
        if values["RTL_CONE_ANG"] > 0 and distance <= values["RTL_MIN_DIST"]:
            half_angle = math.radians(min(max(values["RTL_CONE_ANG"], 1.0), 89.0))
            wanted = min(distance / math.tan(half_angle), wanted)
        wanted = max(wanted, 2.0 * acceptance)
    return max(wanted, height)


class Return(Task):
    """Climb to the return height, fly home, descend, land."""

    def __init__(self, seen: Seen, values: Parameters, home_site: Vector) -> None:
        super().__init__(seen, values)
        self._home = home_site
        self._landing: Land | None = None
        there = home_site - seen.position_site
        distance = math.hypot(there[0], there[1])
        height = return_height(distance, float(-there[2]), values)
        self._stage = 0
        self.target[2] = home_site[2] + height

    @property
    def sinks(self) -> bool:
        """As the landing says, once it has begun."""
        return self._landing.sinks if self._landing else super().sinks

    def step(self, seen: Seen, values: Parameters, dt: float) -> Demand:
        """The landing's demand once it has begun."""
        if self._landing is not None:
            return self._landing.step(seen, values, dt)
        return super().step(seen, values, dt)

    def steer(self, seen: Seen, values: Parameters, dt: float) -> None:
        """Next stage when the present target is reached."""
        if self._reached(seen, values):
            self._stage += 1
            if self._stage == 1:
                self.target[:2] = self._home[:2]
                course = self._home[:2] - seen.position_site[:2]
                if math.hypot(*course) > values["NAV_ACC_RAD"]:
                    self.yaw_wanted = math.atan2(course[1], course[0])
            elif self._stage == 2:
                low = float(self._home[2]) + values["RTL_DESCEND_ALT"]
                self.target[2] = min(float(self.target[2]), low)
            else:
                self.lands = True
                self._landing = Land(seen, values)
                self._landing.target[:2] = self._home[:2]
        super().steer(seen, values, dt)

    def _reached(self, seen: Seen, values: Parameters) -> bool:
        miss = self.target - seen.position_site
        if abs(miss[2]) > values["NAV_MC_ALT_RAD"]:
            return False
        return self._stage == 0 or math.hypot(miss[0], miss[1]) < 0.5 * values["NAV_ACC_RAD"]
