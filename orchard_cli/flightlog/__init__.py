"""Records <-> MCAP."""

from orchard_cli.flightlog.scribe import Rates
from orchard_cli.flightlog.writer import McapRecorder

__all__ = ["McapRecorder", "Rates"]
