"""The four tasks that a flight can be put together from (Wang 2020, §3.7)."""

from __future__ import annotations

from dataclasses import dataclass

from .arrays import Vector, frozen


@dataclass(frozen=True, slots=True, eq=False)
class TakeOff:
    """Go straight up."""

    place_site: Vector  # (2,) m
    height: float  # m above the ground there

    def __post_init__(self) -> None:
        object.__setattr__(self, "place_site", frozen(self.place_site, (2,), "take-off"))


@dataclass(frozen=True, slots=True, eq=False)
class FlyTo:
    """Go straight there, and stop."""

    place_site: Vector  # (2,) m
    height: float | None = None  # m above the ground at the take-off; None: as it is

    def __post_init__(self) -> None:
        object.__setattr__(self, "place_site", frozen(self.place_site, (2,), "place"))


@dataclass(frozen=True, slots=True)
class Hover:
    """Stay."""

    seconds: float  # s


@dataclass(frozen=True, slots=True)
class Land:
    """Go straight down."""


Task = TakeOff | FlyTo | Hover | Land
