"""Which mode PX4 flies when the one that was asked for cannot be trusted."""

from __future__ import annotations

from dataclasses import dataclass

from .modes import Mode
from .parameters import Parameters

_SEVERITY = (Mode.POSCTL, Mode.HOLD, Mode.RETURN, Mode.LAND)
"""From the mildest to the most severe; the most severe action wins."""

_OFFBOARD_LOSS = {3: Mode.RETURN, 4: Mode.LAND, 5: Mode.HOLD}
_PILOT_LOSS = {1: Mode.HOLD, 2: Mode.RETURN, 3: Mode.LAND}


@dataclass(frozen=True, slots=True)
class Threats:
    """What is wrong now."""

    setpoints_lost: bool  # the mode is offboard and its stream is too old
    pilot_lost: bool  # the mode needs sticks and there are none
    pilot_there: bool
    battery: float  # share left


def failsafe(intended: Mode, threats: Threats, values: Parameters) -> Mode:
    """The mode to fly: the intended one, or the most severe action that a threat asks for.

    PX4 1.17 as measured (px4/README §4): the loss of setpoints acts at once, without the hold of
    COM_FAIL_ACT_T. COM_OBL_RC_ACT 0 to 2 hand over to a pilot, and without one NAV_RCL_ACT rules.
    Terminating and disarming in flight are not simulated: such values act as the defaults.
    """
    if intended is Mode.LAND:
        return intended
    actions = []
    if threats.setpoints_lost:
        asked = _OFFBOARD_LOSS.get(int(values["COM_OBL_RC_ACT"]), Mode.POSCTL)
        if asked is Mode.POSCTL and not threats.pilot_there:
            asked = _PILOT_LOSS.get(int(values["NAV_RCL_ACT"]), Mode.RETURN)
        actions.append(asked)
    if threats.pilot_lost:
        actions.append(_PILOT_LOSS.get(int(values["NAV_RCL_ACT"]), Mode.RETURN))
    if values["COM_LOW_BAT_ACT"] == 3 and threats.battery <= values["BAT_EMERGEN_THR"]:
        actions.append(Mode.LAND)
    elif values["COM_LOW_BAT_ACT"] >= 2 and threats.battery <= values["BAT_CRIT_THR"]:
        actions.append(Mode.LAND if values["COM_LOW_BAT_ACT"] == 2 else Mode.RETURN)
    if not actions:
        return intended
    return max(actions, key=_SEVERITY.index)
