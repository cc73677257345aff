"""The mission protocol: upload, download, clear, and telling the progress."""

from __future__ import annotations

import math
from typing import Any

from pymavlink.dialects.v20 import development as mav

from orchard_cli.simulator.autopilot import Autopilot, Item

from .earth import Earth

ACCEPTED, UNSUPPORTED_FRAME, UNSUPPORTED, BAD_SEQUENCE = 0, 2, 3, 13  # MAV_MISSION_RESULT
RETRY, RETRIES = 0.25, 10  # s and times: PX4 asks again for an item that does not come
_ABSOLUTE, _RELATIVE, _NO_PLACE = (0, 5), (3, 6), (2,)
_STORED_FRAME = {3: 6, 0: 5}  # PX4 hands out the integer frames


class MissionProtocol:
    """One transfer at a time, for missions only (fence and rally points are refused)."""

    def __init__(self, autopilot: Autopilot, earth: Earth) -> None:
        self._autopilot = autopilot
        self._earth = earth
        self._stored: list[Any] = []  # MISSION_ITEM_INT as they came
        self._coming: list[Any] | None = None
        self._expected = 0
        self._partner = (0, 0)
        self._asked_at = 0.0
        self._asked = 0

    def handle(self, message: Any, now: float) -> list[Any]:
        """Answers to one message of the protocol; none for any other."""
        answer = {
            "MISSION_COUNT": self._begin,
            "MISSION_ITEM_INT": self._take,
            "MISSION_REQUEST_LIST": self._count,
            "MISSION_REQUEST_INT": self._give,
            "MISSION_REQUEST": self._give,
            "MISSION_CLEAR_ALL": self._clear,
            "MISSION_SET_CURRENT": self._set_current,
        }.get(message.get_type())
        if answer is None:
            return []
        to = (message.get_srcSystem(), message.get_srcComponent())
        if getattr(message, "mission_type", 0) != 0:
            return [self._ack(to, UNSUPPORTED, message.mission_type)]
        return answer(message, to, now)

    def tick(self, now: float) -> list[Any]:
        """Ask again for an item that did not come, and tell which items were reached."""
        told = [mav.MAVLink_mission_item_reached_message(i) for i in self._autopilot.reached]
        self._autopilot.reached.clear()
        if self._coming is not None and now - self._asked_at > RETRY:
            if self._asked >= RETRIES:
                self._coming = None
            else:
                told.append(self._request(now))
        return told

    def _begin(self, message: Any, to: tuple[int, int], now: float) -> list[Any]:
        if message.count == 0:
            return self._clear(message, to, now)
        self._coming, self._expected, self._partner, self._asked = [], message.count, to, 0
        return [self._request(now)]

    def _request(self, now: float) -> Any:
        self._asked_at = now
        self._asked += 1
        return mav.MAVLink_mission_request_int_message(*self._partner, len(self._coming or ()), 0)

    def _take(self, message: Any, to: tuple[int, int], now: float) -> list[Any]:
        if self._coming is None:
            # The last item again: the client missed the answer. PX4 repeats it.
            repeated = self._stored and message.seq == len(self._stored) - 1
            return [self._ack(to, ACCEPTED if repeated else BAD_SEQUENCE)]
        if message.seq != len(self._coming):
            return [self._request(now)]
        if message.frame not in (*_ABSOLUTE, *_RELATIVE, *_NO_PLACE):
            self._coming = None
            return [self._ack(to, UNSUPPORTED_FRAME)]
        self._coming.append(message)
        self._asked = 0
        if len(self._coming) < self._expected:
            return [self._request(now)]
        self._stored, self._coming = self._coming, None
        self._autopilot.upload(tuple(self._item(stored) for stored in self._stored))
        return [self._ack(to, ACCEPTED)]

    def _item(self, message: Any) -> Item:
        target = None
        if message.frame not in _NO_PLACE:
            north, east = self._earth.metres(message.x * 1e-7, message.y * 1e-7)
            target = self._earth.site(north, east, 0.0)
            home = float(self._autopilot.home_site[2])
            absolute = float(self._earth.site(0.0, 0.0, self._earth.height - message.z)[2])
            target[2] = home + message.z if message.frame in _RELATIVE else absolute
        yaw = message.param4
        if math.isfinite(yaw):
            yaw = self._earth.yaw_site(math.radians(yaw))
        params = (message.param1, message.param2, message.param3, yaw)
        return Item(message.command, params, target)

    def _count(self, _: Any, to: tuple[int, int], __: float) -> list[Any]:
        return [mav.MAVLink_mission_count_message(*to, len(self._stored), 0)]

    def _give(self, message: Any, to: tuple[int, int], _: float) -> list[Any]:
        if message.seq >= len(self._stored):
            return [self._ack(to, BAD_SEQUENCE)]
        m = self._stored[message.seq]
        return [
            mav.MAVLink_mission_item_int_message(
                *to, m.seq, _STORED_FRAME.get(m.frame, m.frame), m.command, m.current,
                m.autocontinue, m.param1, m.param2, m.param3, m.param4, m.x, m.y, m.z, 0,
            )
        ]  # fmt: skip

    def _clear(self, _: Any, to: tuple[int, int], __: float) -> list[Any]:
        self._stored, self._coming = [], None
        self._autopilot.upload(())
        return [self._ack(to, ACCEPTED)]

    def _set_current(self, message: Any, _: tuple[int, int], __: float) -> list[Any]:
        if message.seq < len(self._stored):
            self._autopilot.jump(message.seq)
        return []

    @staticmethod
    def _ack(to: tuple[int, int], result: int, mission_type: int = 0) -> Any:
        return mav.MAVLink_mission_ack_message(*to, result, mission_type)
