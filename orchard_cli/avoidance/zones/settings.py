"""The zones' distances and the manoeuvres' sizes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ZonesSettings:
    """Distances are along the path to an obstacle's surface. The paper gives the 2 m of `approach`
    and the 2 m square of `half`; the rest is chosen so that a vehicle at 1 m/s has room."""

    warning: float = 8.0  # m: nearer than this, slow down
    action: float = 5.0  # m: nearer than this, turn or leap
    emergency: float = 1.2  # m: nearer than this, stop and wait for the pilot
    half: float = 1.0  # m, half of the side of the safely-passing-area (Wang 2020, Fig. 4)
    people: float = 2.0  # m beside the path within which a person or a drone stops the flight
    slow: float = 0.6  # share of the cruise speed in the warning zone
    approach: float = 2.0  # m before the obstacle at which the manoeuvre begins (§3.6, iii)
    spare: float = 0.1  # m that a manoeuvre keeps besides
    highest_leap: float = 2.0  # m above the route
    furthest: float = 5.0  # m beside the route
    lead: float = 2.0  # m of route behind the manoeuvre in which speed is taken up again
    cruises: tuple[float, ...] = (1.0, 0.8, 0.6, 0.45)  # shares of the speed to try, in order
    vertical: float = 0.6  # m above and below what Limits.clearance is beside
    accept: float = 0.1  # m that a new trajectory keeps over the clearance in the map
    look_ahead: float = 7.0  # m of path that is checked in the map
    gentle: float = 0.6  # share of the acceleration limit for early braking
    stop_short: float = 0.2  # m before what blocks
    confirmed: int = 3  # looks that must agree
    forget: float = 1.0  # s after which what is not seen again is forgotten
