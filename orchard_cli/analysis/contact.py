"""What a simulated flight touched. The vehicle breaks on it: what follows is a fall, no flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchard_cli.model.flown import FlownLog

from .figures import Clearances, Figure, Unknown


def contacts_figure(log: FlownLog) -> Figure:
    """0 or 1; Unknown where nobody can tell."""
    if log.contacts is not None:
        return len(log.contacts)
    if log.truth is None:
        return Unknown("a contact is known to a simulator only")
    return Unknown("flown by a simulator that did not look for contacts")


def until_contact(
    log: FlownLog, clearances: Clearances | Unknown
) -> tuple[FlownLog, Clearances | Unknown]:
    """The estimated path and the clearances without the fall, which may lead through anything."""
    if not log.contacts:
        return log, clearances
    end = log.contacts[0].time
    if not isinstance(clearances, Unknown):
        up = clearances.times <= end
        clearances = Clearances(
            clearances.times[up], clearances.obstacles[up], clearances.trees[up]
        )
    return replace(log, odometry=log.odometry.between(-np.inf, end)), clearances
