"""Records <-> MCAP."""

from orchard_cli.flightlog.pace import Rates
from orchard_cli.flightlog.reader import NEEDED, read
from orchard_cli.flightlog.writer import McapRecorder

__all__ = ["NEEDED", "McapRecorder", "Rates", "read"]
