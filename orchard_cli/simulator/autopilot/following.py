"""Flying an uploaded mission."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.simulator.control import Demand

from .parameters import Parameters
from .plan import Does, Item
from .returning import Return
from .seen import Seen
from .tasks import Land, Task


class Follow(Task):
    """An uploaded mission; at its end it holds. `index` is the item being done."""

    def __init__(
        self, seen: Seen, values: Parameters, items: tuple[Item, ...], index: int, home_site: Vector
    ) -> None:
        super().__init__(seen, values)
        self.items = items
        self.index = index
        self.reached: list[int] = []
        self._home = home_site
        self._waits_until = math.nan
        self._after: Land | Return | None = None
        # From the ground the first leg goes straight up (PX4 does so without a take-off item).
        self._rising = seen.height < 0.5
        self._begin(seen, values)

    @property
    def climbs(self) -> bool:
        """Whether it wants to be in the air: not once its landing or its end has come."""
        return self._after is None and not self.complete

    @property
    def rising(self) -> bool:
        """Whether it still climbs straight up from the ground."""
        return self._rising

    def take_reached(self) -> list[int]:
        """Indices of the items reached since the last call."""
        reached, self.reached = self.reached, []
        return reached

    @property
    def complete(self) -> bool:
        """Whether every item is done."""
        return self.index >= len(self.items)

    @property
    def sinks(self) -> bool:
        """As the landing says, once it has begun."""
        return self._after.sinks if self._after else super().sinks

    def step(self, seen: Seen, values: Parameters, dt: float) -> Demand:
        """The demand of the landing or return that an item asked for, else of the route."""
        if self._after is not None:
            self.lands = self._after.lands
            return self._after.step(seen, values, dt)
        return super().step(seen, values, dt)

    def steer(self, seen: Seen, values: Parameters, dt: float) -> None:
        """Take up the next item when this one is done."""
        if not self.complete and self._item_done(seen, values):
            if self._rising:
                self._rising = False
            else:
                self.reached.append(self.index)
                self.index += 1
            self._begin(seen, values)
        super().steer(seen, values, dt)

    def _begin(self, seen: Seen, values: Parameters) -> None:
        """Set up the current item, passing at once what has no place and takes no time."""
        while not self.complete:
            item = self.items[self.index]
            if item.moves:
                self._aim(item, seen, values)
                return
            if item.command == Does.CHANGE_SPEED and item.params[1] > 0:
                self.speed = item.params[1]
            elif item.command == Does.RETURN:
                self._end_with(Return(seen, values, self._home))
                return
            elif item.command == Does.DELAY:
                self._waits_until = seen.time + max(0.0, item.params[0])
                return
            self.reached.append(self.index)
            self.index += 1

    def _end_with(self, after: Land | Return) -> None:
        """The last item that matters: what comes behind it is not flown."""
        self._after = after
        self.reached.append(self.index)
        self.index = len(self.items)

    def _aim(self, item: Item, seen: Seen, values: Parameters) -> None:
        assert item.target_site is not None
        place = item.target_site
        self._waits_until = math.nan
        if self._rising:
            self.target = np.array([*seen.position_site[:2], place[2]])
            self.climb = values["MPC_TKO_SPEED"]
            return
        self.climb = values["MPC_Z_V_AUTO_UP"]
        self.target = np.array(place)
        course = place[:2] - seen.position_site[:2]
        if math.isfinite(item.params[3]):
            self.yaw_wanted = item.params[3]
        elif math.hypot(*course) > values["NAV_ACC_RAD"]:
            self.yaw_wanted = math.atan2(course[1], course[0])
        if item.command == Does.LAND:
            self.target[2] = max(float(seen.position_site[2]), float(place[2]))

    def _item_done(self, seen: Seen, values: Parameters) -> bool:
        item = self.items[self.index]
        if item.moves:
            miss = self.target - seen.position_site
            radius = item.params[1] if item.params[1] > 0 else values["NAV_ACC_RAD"]
            near = math.hypot(miss[0], miss[1]) < radius or self._rising
            if not near or abs(miss[2]) > values["NAV_MC_ALT_RAD"]:
                return False
            if item.command == Does.LAND and not self._rising:
                landing = Land(seen, values)
                landing.target[:2] = self.target[:2]
                self._end_with(landing)
                return False
            if math.isnan(self._waits_until):
                stay = item.params[0] if item.command == Does.WAYPOINT and not self._rising else 0.0
                self._waits_until = seen.time + max(0.0, stay)
        return bool(seen.time >= self._waits_until)
