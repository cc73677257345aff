"""The recorder: takes records without ever holding up the flight, and writes them as MCAP."""

from __future__ import annotations

import contextlib
import math
import queue
import threading
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

import foxglove
from foxglove.mcap import MCAPWriteOptions, MCAPWriter

from orchard_cli.flightlog.pace import Pace, Rates
from orchard_cli.flightlog.scribe import Scribe, TimedRecord, metadata
from orchard_cli.flightlog.sink import Sink
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.records import LogLine, OccupiedCells, Record, RunHeader, Severity
from orchard_cli.model.sensors import ColourFrame

CHUNK_SECONDS = 0.5
"""A chunk is closed and handed to the disk at least this often, in flight time."""

QUEUE_LENGTH = 4096
BULKY_LENGTH = 512
"""Depth images and maps are dropped first: when this many records wait already."""

CLOSING_LIMIT = 20.0
"""s that `close` waits for a disk that hangs; the file is then cut, and readable up to the cut."""

_BULKY = (DepthFrame, ColourFrame, OccupiedCells)
_MEDIA = {".json": "application/json", ".toml": "application/toml"}


class McapRecorder:
    """Fits the socket `Recorder` of flight/ports.py.

    `write` puts the record on a bounded queue; a thread encodes, compresses and writes. A full
    queue or a failing disk costs records, counted in `losses` and said in /log, never time.
    With `patient` (lockstep, where flight time waits for the log) nothing is dropped: there is no
    thread, and `write` does the work itself.
    """

    def __init__(
        self,
        path: Path | str,
        *,
        rates: Rates | None = None,
        overwrite: bool = False,
        patient: bool = False,
    ) -> None:
        """Create the file. Raises InputError when it exists or cannot be written."""
        rates = rates or Rates()
        sink = Sink(Path(path), overwrite, sync=not patient)
        self._writing = _Writing(sink, rates)  # touched by the log's thread only
        self._paces = {
            DepthFrame: Pace(rates.depth),
            ColourFrame: Pace(rates.depth),
            OccupiedCells: Pace(rates.cells),
        }
        self._patient = patient
        self._queue: queue.Queue[Record | None] = queue.Queue(QUEUE_LENGTH)
        self._dropped: Counter[str] = Counter()  # by the flight's thread
        self._failed: Counter[str] = Counter()  # by the log's thread
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="flightlog", daemon=True)
        if not patient:
            self._thread.start()

    @property
    def losses(self) -> Mapping[str, int]:
        """How many records were lost so far, by reason; empty when none."""
        return {**self._dropped, **self._failed}

    def write(self, record: Record) -> None:
        """Queue one record; never raises, and never waits unless patient."""
        if self._closed:
            self._dropped["after the end"] += 1
        elif not isinstance(record, _BULKY):
            self._put(record)
        elif self._paces[type(record)].due(record.time):
            if self._patient or self._queue.qsize() < BULKY_LENGTH:
                self._put(record)
            else:
                self._dropped["image or map: the writer is behind"] += 1

    def _put(self, record: Record) -> None:
        if self._patient:
            self._log(record)
            return
        try:
            self._queue.put_nowait(record)
        except queue.Full:
            self._dropped["the queue is full"] += 1

    def close(self) -> None:
        """Write out everything that is queued and finish the file."""
        if self._closed:
            return
        self._closed = True
        if self._patient:
            self._finish()
        else:
            with contextlib.suppress(queue.Full):
                self._queue.put(None, timeout=CLOSING_LIMIT)
            self._thread.join(CLOSING_LIMIT)
            if self._thread.is_alive():
                self._dropped["the disk hangs: the end"] += 1

    def _run(self) -> None:
        while self._step():
            pass
        self._finish()

    def _finish(self) -> None:
        self._attempt("the end", lambda: self._writing.finish(self.losses))

    def _step(self) -> bool:
        """Log one record; False at the end. A pause in the flight ends the chunk."""
        try:
            record = self._queue.get(timeout=CHUNK_SECONDS)
        except queue.Empty:
            self._attempt("a chunk", self._writing.commit)
            return True
        if record is not None:
            self._log(record)
        return record is not None

    def _log(self, record: Record) -> None:
        self._attempt(type(record).__name__, lambda: self._writing.take(record))
        if self._dropped or self._failed:
            self._attempt("this sentence", lambda: self._writing.tell(self.losses))

    def _attempt(self, what: str, act: Callable[[], None]) -> None:
        try:
            act()
        except Exception as error:  # a log must not end a flight: count, go on
            self._failed[f"{what}: {error}"] += 1


class _Writing:
    """The log's thread: everything that touches the file."""

    def __init__(self, sink: Sink, rates: Rates) -> None:
        self._sink = sink
        self._rates = rates
        self._context = foxglove.Context()
        options = MCAPWriteOptions(compression_level=1, compression_threads=0, disable_seeking=True)
        self._mcap: MCAPWriter = foxglove.open_mcap(
            sink, context=self._context, writer_options=options
        )
        self._scribe: Scribe | None = None
        self._held: list[TimedRecord] = []  # images and maps: for chunks of their own
        self._now = float("-inf")  # s, flight clock, of the newest record
        self._committed = float("-inf")
        self._told = 0

    def take(self, record: Record) -> None:
        """Log one record; raises when it cannot be."""
        if isinstance(record, RunHeader):
            self._begin(record)
            return
        if self._scribe is None:
            raise ValueError("came before the run's header")
        if self._sink.ended:
            raise OSError("the disk stayed full")
        if self._sink.failure and isinstance(record, _BULKY):
            raise OSError(self._sink.failure)
        if isinstance(record, _BULKY):
            self._held.append(record)
        else:
            self._scribe.write(record)
        self._now = record.time
        if abs(self._now - self._committed) >= CHUNK_SECONDS:
            self.commit()

    def tell(self, losses: Mapping[str, int]) -> None:
        """Say in the log what it has lost, when that has grown since the last chunk."""
        total = sum(losses.values())
        at_chunk_end = math.isfinite(self._now) and self._now == self._committed
        if self._scribe and total > self._told and at_chunk_end:
            self._told = total
            lost = ", ".join(f"{count} ({why})" for why, count in losses.items())
            text = f"the log has lost {total} records: {lost}"
            self._scribe.write(LogLine(self._now, Severity.WARNING, text, "flightlog"))

    def commit(self) -> None:
        """End the chunk, write what was held in chunks of its own, and hand all to the disk."""
        self._committed = self._now
        try:
            self._write_held()
        finally:
            self._sink.commit()

    def _write_held(self) -> None:
        """Readers that need no images skip these chunks: most of the file."""
        self._mcap.flush()
        held, self._held = self._held, []
        if self._scribe is not None:
            for record in held:
                self._scribe.write(record)
        self._mcap.flush()

    def finish(self, losses: Mapping[str, int]) -> None:
        """Say what was lost, write the index and close the file."""
        self.commit()
        self.tell(losses)
        self._mcap.close()
        self._sink.close()

    def _begin(self, header: RunHeader) -> None:
        if self._scribe is not None:
            raise ValueError("a run has one header")
        self._mcap.write_metadata("orchard", metadata(header))
        self._scribe = Scribe(self._context, header, self._rates)
        utc = round(header.utc_offset * 1e9)
        try:
            for name, data in header.attachments.items():
                media = _MEDIA.get(Path(name).suffix, "application/octet-stream")
                self._mcap.attach(
                    log_time=utc, create_time=0, name=name, media_type=media, data=data
                )
        finally:
            self.commit()
