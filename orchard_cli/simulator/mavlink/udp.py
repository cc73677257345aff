"""The link's socket: MAVLink 2 over UDP, as PX4's onboard instance does it."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Iterable
from typing import Any

from pymavlink.dialects.v20 import development as mav

DATAGRAM = 1200  # bytes: several messages travel together, as with PX4


class UdpLink:
    """Sends to `to` until somebody writes, then to whoever wrote last."""

    def __init__(self, bind: tuple[str, int], to: tuple[str, int], ids: tuple[int, int]) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(bind)
        self._socket.setblocking(False)
        self._to = to
        self._mav = mav.MAVLink(None, srcSystem=ids[0], srcComponent=ids[1])
        self._parser = mav.MAVLink(None)
        self._parser.robust_parsing = True

    @property
    def port(self) -> int:
        """The port that it is bound to."""
        return int(self._socket.getsockname()[1])

    def receive(self) -> list[Any]:
        """Messages that came since the last call."""
        messages: list[Any] = []
        while True:
            try:
                data, sender = self._socket.recvfrom(65535)
            except BlockingIOError:
                return messages
            except ConnectionError:  # a client that went away; UDP tells it to the next reader
                continue
            self._to = sender
            messages += [
                message
                for message in self._parser.parse_buffer(data) or ()
                if message.get_type() != "BAD_DATA"
            ]

    def send(self, messages: Iterable[Any]) -> None:
        """Pack and send; what the network does not take is lost, as on a real link."""
        datagram = bytearray()
        for message in messages:
            packed = message.pack(self._mav)
            if len(datagram) + len(packed) > DATAGRAM:
                self._put(datagram)
                datagram = bytearray()
            datagram += packed
        self._put(datagram)

    def _put(self, datagram: bytearray) -> None:
        if datagram:
            with contextlib.suppress(BlockingIOError, ConnectionError):
                self._socket.sendto(datagram, self._to)

    def close(self) -> None:
        """Let go of the port."""
        self._socket.close()
