"""The running flight over WebSocket, for Foxglove and Lichtblick. It can lose, never hold up."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Protocol

import foxglove

from orchard_cli.errors import LinkError
from orchard_cli.flightlog.pace import Pace, Rates
from orchard_cli.flightlog.scribe import Scribe
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.records import NewTrajectory, OccupiedCells, Record, RunHeader

PORT = 8765  # where Foxglove and Lichtblick look first
BACKLOG = 256  # records that wait at most; then the newest are dropped
REPEAT = 2.0  # s of flight time: who connects later sees plan and trajectory within that
CLOSING = 2.0  # s


class LiveView:
    """Fits the socket `Recorder` of flight/ports.py: the log's topics, served instead of written.

    Anybody who reaches the address may watch; nobody can steer. A watcher that is too slow loses
    messages, as does a flight whose server is too slow.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = PORT) -> None:
        """Listen. Raises LinkError when the address cannot be had."""
        self._context = foxglove.Context()
        rates = Rates(depth=5.0)
        self._paces = {DepthFrame: Pace(rates.depth), OccupiedCells: Pace(rates.cells)}
        self._rates = rates
        try:
            self._server = foxglove.start_server(
                name="orchard", host=host, port=port, context=self._context
            )
        except RuntimeError as error:
            raise LinkError(
                f"--live: cannot listen on {host}:{port} ({error}); name another port"
            ) from None
        self.address = f"ws://{host}:{self._server.port}"
        self._scribe: Scribe | None = None
        self._plan = Pace(1.0 / REPEAT)
        self._trajectory: NewTrajectory | None = None
        self._queue: queue.Queue[Record | None] = queue.Queue(BACKLOG)
        self._thread = threading.Thread(target=self._serve, name="live-view", daemon=True)
        self._thread.start()

    @property
    def losses(self) -> Mapping[str, int]:
        """None: what nobody saw is in the log all the same."""
        return {}

    def write(self, record: Record) -> None:
        """Queue one record; never waits, never raises."""
        pace = self._paces.get(type(record))
        if pace is None or (not isinstance(record, RunHeader) and pace.due(record.time)):
            with contextlib.suppress(queue.Full):
                self._queue.put_nowait(record)

    def close(self) -> None:
        """Stop serving; what still waits is not sent."""
        with contextlib.suppress(queue.Full):
            self._queue.put(None, timeout=CLOSING)
        self._thread.join(CLOSING)
        self._server.stop()

    def _serve(self) -> None:
        while (record := self._queue.get()) is not None:
            with contextlib.suppress(Exception):  # a picture is not worth a flight
                self._show(record)

    def _show(self, record: Record) -> None:
        if isinstance(record, RunHeader):
            self._scribe = Scribe(self._context, record, self._rates)
            return
        if self._scribe is None:
            return
        if isinstance(record, NewTrajectory):
            self._trajectory = record
        if self._plan.due(record.time):
            self._scribe.draw_plan(record.time)
            if self._trajectory is not None:
                self._scribe.write(self._trajectory)
        self._scribe.write(record)


class _Recorder(Protocol):
    @property
    def losses(self) -> Mapping[str, int]: ...

    def write(self, record: Record) -> None: ...

    def close(self) -> None: ...


class Tee:
    """Fits the socket `Recorder`: hands every record to several."""

    def __init__(self, *recorders: _Recorder) -> None:
        self._recorders = recorders

    @property
    def losses(self) -> Mapping[str, int]:
        """Of all of them together."""
        return {why: n for one in self._recorders for why, n in one.losses.items()}

    def write(self, record: Record) -> None:
        """Queue one record everywhere."""
        for recorder in self._recorders:
            recorder.write(record)

    def close(self) -> None:
        """Close them all."""
        for recorder in self._recorders:
            recorder.close()


def layout() -> Path:
    """The layout file for Foxglove and Lichtblick that comes with this package."""
    return Path(str(files(__package__) / "foxglove-layout.json"))
