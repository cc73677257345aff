"""Random orchards, flown in lockstep by many workers, and what became of them in figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchard_cli.campaign.ledger import Ledger
from orchard_cli.campaign.summary import summary

from ..pool import spread
from .flying import Task, fly_one

SCHEMA = "orchard.campaign.orchards/1"


@dataclass(frozen=True, slots=True)
class Campaign:
    """What is to be flown, and where the results go."""

    flights: int
    seed: int
    system: str
    camera: tuple[int, int]
    folder: Path

    @property
    def inputs(self) -> dict[str, Any]:
        """What every result depends on; how many are flown is none of it."""
        return {"seed": self.seed, "system": self.system, "camera": list(self.camera)}

    def task(self, number: int, keep: bool = False) -> Task:
        """One of its cases."""
        return Task(self.seed, number, self.system, self.camera, self.folder / "kept", keep)


def run(campaign: Campaign, workers: int, dask: str | None, quiet: bool) -> dict[str, Any]:
    """Fly what has not been flown yet; the document of all."""
    ledger = Ledger(campaign.folder, campaign.inputs, ("case",))
    rest = [campaign.task(k) for k in range(campaign.flights) if (k,) not in ledger.records]
    for record in spread(fly_one, rest, workers, dask, "flying", quiet):
        ledger.add(record)
    return document(campaign, [ledger.records[(k,)] for k in range(campaign.flights)])


def document(campaign: Campaign, records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The same for any number of workers: by case, and without anybody's clock."""
    return {"schema": SCHEMA, **campaign.inputs, **summary(records)}
