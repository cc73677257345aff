"""MAVLink mission items: what QGroundControl's plans and WPL files are lists of.

Positions are in MAV_FRAME_GLOBAL_RELATIVE_ALT: heights above the home position, which the
autopilot sets on the ground at take-off. A command that follows a waypoint is carried out when
that waypoint is reached.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

import numpy as np

from orchard_cli.errors import Fault, InputError

from .course import Course, Loaded


class Command(IntEnum):
    """The MAV_CMD numbers that an exported mission is made of."""

    WAYPOINT = 16
    LAND = 21
    TAKEOFF = 22
    CHANGE_SPEED = 178
    SET_SERVO = 183
    SET_ACTUATOR = 187
    SPRAYER = 216


class Frame(IntEnum):
    """MAV_FRAME."""

    GLOBAL = 0  # height above mean sea level
    MISSION = 2  # the item has no place
    RELATIVE = 3  # height above home


class PumpBy(Enum):
    """How the autopilot is told to run the pump."""

    SPRAYER = "sprayer"  # MAV_CMD_DO_SPRAYER: ArduPilot with its sprayer enabled
    SERVO = "servo"  # MAV_CMD_DO_SET_SERVO: ArduPilot, a pump on an output
    ACTUATOR = "actuator"  # MAV_CMD_DO_SET_ACTUATOR: PX4, a pump on an actuator set


@dataclass(frozen=True, slots=True)
class Pump:
    """How to run the pump; servo and its pulses matter to SERVO, the number to ACTUATOR, too."""

    by: PumpBy = PumpBy.SPRAYER
    number: int = 9  # of the servo output, or of the actuator (1 to 4)
    on_us: int = 1900
    off_us: int = 1100

    def item(self, on: bool) -> Item:
        """The item that turns the pump on or off."""
        if self.by is PumpBy.SPRAYER:
            return Item(Command.SPRAYER, Frame.MISSION, (float(on), 0, 0, 0, 0, 0, 0))
        if self.by is PumpBy.SERVO:
            pulse = self.on_us if on else self.off_us
            return Item(Command.SET_SERVO, Frame.MISSION, (self.number, pulse, 0, 0, 0, 0, 0))
        values: list[float | None] = [None] * 6
        values[self.number - 1] = 1.0 if on else -1.0
        return Item(Command.SET_ACTUATOR, Frame.MISSION, (*values, 0))

    @property
    def firmware(self) -> int:
        """MAV_AUTOPILOT: PX4 for actuators, else ArduPilot."""
        return 12 if self.by is PumpBy.ACTUATOR else 3


@dataclass(frozen=True, slots=True)
class Item:
    """One mission item. None is NaN: leave as it is."""

    command: int
    frame: int
    params: tuple[float | None, ...]  # 7; of a place: latitude, longitude, height from the fifth


def items(course: Course, pump: Pump) -> list[Item]:
    """Take off, pump off, fly the places with the pump on along rows only, land."""
    speed = Item(Command.CHANGE_SPEED, Frame.MISSION, (1, course.speed, -1, 0, 0, 0, 0))
    listed = [_at(Command.TAKEOFF, course, 0), pump.item(False), speed]
    on = False
    for k in range(1, len(course.places_wgs84)):
        if course.ways[k - 1].sprays is not on:
            on = not on
            listed.append(pump.item(on))
        listed.append(_at(Command.WAYPOINT, course, k))
    latitude, longitude, height = (float(v) for v in course.landing_wgs84)
    ground = round(height - float(course.home_wgs84[2]), 4)
    place = (round(latitude, 9), round(longitude, 9), ground)
    landing = Item(Command.LAND, Frame.RELATIVE, (0, 0, 0, None, *place))
    return [*listed, pump.item(False), landing]


def _at(command: Command, course: Course, k: int) -> Item:
    latitude, longitude = (round(float(v), 9) for v in course.places_wgs84[k, :2])
    height = round(float(course.heights[k]), 4)
    return Item(command, Frame.RELATIVE, (0, 0, 0, None, latitude, longitude, height))


def loaded(listed: list[Item]) -> Loaded:
    """The places and the pump of a list of items. Raises InputError for items of another kind."""
    places: list[tuple[float, float, float]] = []
    sprays: list[bool] = []
    on = False
    for item in listed:
        if item.command in (Command.TAKEOFF, Command.WAYPOINT):
            if item.frame != Frame.RELATIVE:
                raise InputError(Fault("item", f"in frame {item.frame}, not in relative heights"))
            if places:
                sprays.append(on)
            latitude, longitude, height = (float(v or 0.0) for v in item.params[4:7])
            places.append((latitude, longitude, height))
        else:
            on = _pump_after(item, on)
    table = np.array(places).reshape(-1, 3)
    return Loaded(table[:, :2], table[:, 2], tuple(sprays))


def _pump_after(item: Item, on: bool) -> bool:
    """Whether the pump runs after an item that is no place."""
    if item.command == Command.SPRAYER:
        return bool(item.params[0])
    if item.command == Command.SET_SERVO:
        return (item.params[1] or 0.0) > 1500
    if item.command == Command.SET_ACTUATOR:
        return any((value or 0.0) > 0 for value in item.params[:6])
    return on
