"""What can be made to go wrong in a running simulation, to see what the flight does."""

from __future__ import annotations

from dataclasses import dataclass

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class EstimateJump:
    """The autopilot's estimator is reset: it believes to be elsewhere, from now on."""

    moved_site: Triple = (0.0, 0.0, 0.0)  # m
    turned: float = 0.0  # rad, of its heading


@dataclass(frozen=True, slots=True)
class OriginMove:
    """The autopilot's local origin is put elsewhere; what it believes on earth stays."""

    moved_site: Triple  # m


SimulatedFault = EstimateJump | OriginMove
