"""Watches a flight by what it records: the truth, and what it believed and did."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.records import (
    PlannerRecord,
    Record,
    SafetyRecord,
    TruthRecord,
)
from orchard_cli.model.vehicle import VehicleState


class Witness:
    """Fits the socket `Recorder` of flight/ports.py; keeps what a judgement needs."""

    def __init__(self) -> None:
        self.phases: list[SafetyRecord] = []  # one for each change of phase
        self.decisions: dict[str, int] = {}  # of the avoidance system, by their kind
        self.state: VehicleState | None = None  # newest telemetry
        self.contact = ""  # what was touched
        self.touched_at = math.inf  # s
        self.losses: dict[str, int] = {}  # it loses nothing
        self._truth: list[Array] = []
        self._believed: list[Array] = []

    def write(self, record: Record) -> None:
        """See one record."""
        match record:
            case TruthRecord():
                row = (record.time, *record.position_site, *record.velocity_site)
                self._truth.append(np.array(row))
                if record.contact and not self.contact:
                    self.contact, self.touched_at = record.contact, record.time
            case VehicleState():
                self.state = record
                self._believed.append(np.array([record.time, *record.position_site]))
            case SafetyRecord():
                if not self.phases or self.phases[-1].phase != record.phase:
                    self.phases.append(record)
            case PlannerRecord():
                self.decisions[record.decision] = self.decisions.get(record.decision, 0) + 1

    @property
    def truth(self) -> Array:
        """(n, 7): time s, true position m, true velocity m/s; n > 0 once it has flown."""
        return np.array(self._truth).reshape(-1, 7)

    @property
    def believed(self) -> Array:
        """(n, 4): time s, estimated position m."""
        return np.array(self._believed).reshape(-1, 4)

    def close(self) -> None:
        """Nothing to finish."""
