"""The parameter protocol. Integers travel bytewise in the float field, as PX4 does it."""

from __future__ import annotations

import struct
from typing import Any

from pymavlink.dialects.v20 import development as mav

from orchard_cli.simulator.autopilot.parameters import Parameters

INT32, FLOAT = 6, 9  # MAV_PARAM_TYPE
DOES_NOT_EXIST, TYPE_MISMATCH = 1, 5  # MAV_PARAM_ERROR


class ParamProtocol:
    """Answers PARAM_REQUEST_READ, PARAM_REQUEST_LIST and PARAM_SET."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def handle(self, message: Any) -> list[Any]:
        """Answers to one message of the protocol; none for any other."""
        kind = message.get_type()
        if kind == "PARAM_REQUEST_LIST":
            return [self._value(name) for name in self._parameters]
        if kind == "PARAM_REQUEST_READ":
            return [self._read(message)]
        if kind == "PARAM_SET":
            return [self._set(message)]
        return []

    def _read(self, message: Any) -> Any:
        name = message.param_id
        if 0 <= message.param_index < len(self._parameters):
            name = self._parameters.order[message.param_index]
        if name not in self._parameters:
            return self._error(message, DOES_NOT_EXIST)
        return self._value(name)

    def _set(self, message: Any) -> Any:
        name = message.param_id
        if name not in self._parameters:
            return self._error(message, DOES_NOT_EXIST)
        integer = self._parameters.entries[name].integer
        if message.param_type != (INT32 if integer else FLOAT):
            return self._error(message, TYPE_MISMATCH)
        value = message.param_value
        if integer:
            (value,) = struct.unpack("<i", struct.pack("<f", value))
        self._parameters.set(name, value)
        return self._value(name)

    def _value(self, name: str) -> Any:
        integer = self._parameters.entries[name].integer
        value = self._parameters[name]
        if integer:
            (value,) = struct.unpack("<f", struct.pack("<i", int(value)))
        return mav.MAVLink_param_value_message(
            name.encode(), value, INT32 if integer else FLOAT, len(self._parameters),
            self._parameters.order.index(name),
        )  # fmt: skip

    @staticmethod
    def _error(message: Any, error: int) -> Any:
        return mav.MAVLink_param_error_message(
            message.get_srcSystem(),
            message.get_srcComponent(),
            message.param_id.encode(),
            -1,
            error,
        )
