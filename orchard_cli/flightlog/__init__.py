"""Records <-> MCAP."""

from orchard_cli.flightlog.live import LiveView, Tee, layout
from orchard_cli.flightlog.pace import Rates
from orchard_cli.flightlog.reader import NEEDED, read
from orchard_cli.flightlog.writer import McapRecorder

__all__ = ["NEEDED", "LiveView", "McapRecorder", "Rates", "Tee", "layout", "read"]
