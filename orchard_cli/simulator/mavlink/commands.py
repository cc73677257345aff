"""MAV_CMD by MAV_CMD: what is done, and PX4's answer."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from orchard_cli.simulator.autopilot import Autopilot, Mode, Result

from .earth import Earth

FORCE = 21196.0  # param 2 of arm and disarm: PX4's magic for "whatever the checks say"
GLOBAL_FRAMES = (3, 5, 6, 11)  # relative or absolute, also as integers; PX4 answers 9 to frame 0

_MODES = {mode.value: mode for mode in Mode}

Params = tuple[float, float, float, float, float, float, float]


class Commands:
    """Carries out the commands about the vehicle; those about messages are the endpoint's."""

    def __init__(self, autopilot: Autopilot, earth: Earth) -> None:
        self._autopilot = autopilot
        self._earth = earth
        self._table: dict[int, Callable[[Params], Result]] = {
            20: lambda _: autopilot.set_mode(Mode.RETURN),
            21: lambda _: autopilot.set_mode(Mode.LAND),
            22: self._take_off,
            176: self._set_mode,
            179: lambda _: Result.ACCEPTED,  # home is set at arming again
            187: self._set_actuators,
            224: self._set_item,
            246: self._reboot,
            300: lambda _: autopilot.set_mode(Mode.MISSION),
            400: self._arm,
            401: lambda _: Result.ACCEPTED,  # run the arming checks: they always run
        }

    def run(self, command: int, params: Params) -> Result:
        """Do it and say how PX4 would answer."""
        act = self._table.get(command)
        return Result.UNSUPPORTED if act is None else act(params)

    def run_int(self, message: Any) -> Result:
        """A COMMAND_INT: PX4 checks the frame first, then only repositioning needs the place."""
        if message.command == 192 and message.frame not in GLOBAL_FRAMES:
            return Result.UNSUPPORTED_FRAME
        place = (message.x * 1e-7, message.y * 1e-7, message.z)
        return self.run(
            message.command,
            (message.param1, message.param2, message.param3, message.param4, *place),
        )

    def _arm(self, params: Params) -> Result:
        force = params[1] == FORCE
        if params[0] == 1:
            return self._autopilot.arm(force)
        if params[0] == 0:
            return self._autopilot.disarm(force)
        return Result.DENIED

    def _take_off(self, params: Params) -> Result:
        height = params[6]
        if math.isfinite(height):
            down = self._earth.height - height
            height = float(self._earth.site(0.0, 0.0, down)[2])
        return self._autopilot.take_off(height)

    def _set_mode(self, params: Params) -> Result:
        base, main, sub = params[0], params[1], params[2]
        if not int(base) & 1:  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
            return Result.DENIED
        wanted = (int(main), int(sub) if np.isfinite(sub) else 0)
        mode = _MODES.get(wanted)
        return Result.DENIED if mode is None else self._autopilot.set_mode(mode)

    def _set_item(self, params: Params) -> Result:
        index = int(params[0])
        if not 0 <= index < max(len(self._autopilot.mission), 1):
            return Result.DENIED
        self._autopilot.jump(index)
        return Result.ACCEPTED

    def _set_actuators(self, params: Params) -> Result:
        """The first one is the pump's; NaN leaves it as it is."""
        if math.isfinite(params[0]):
            self._autopilot.craft.pumping = params[0] > 0
        return Result.ACCEPTED

    def _reboot(self, _: Params) -> Result:
        return Result.TEMPORARILY_REJECTED if self._autopilot.armed else Result.UNSUPPORTED
