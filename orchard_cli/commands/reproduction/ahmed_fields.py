"""The fields of Ahmed 2022: where the obstacles stand and which way is flown.

The paper's x runs along the rows and its y to the right; the site's y runs to the left. Its minus
signs are lost in our text: "[ 20 4 3 ]" beside "[ 20   0   3 ]" shows them as missing blanks, so
that rows and obstacles stand at y = 0 to -12, to the left: at 0 to +12 here. The first x of a
place cannot be told so; obstacles 2 and 4 are taken at -10 and -15, for on the 3 m rows obstacles
3 and 4 would otherwise stand 5 m apart, nearer than the method's own distances allow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.mission import Limits, Mission, Provenance
from orchard_cli.model.site import HeightReference, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.tank import SPRAYER, Load
from orchard_cli.model.wishes import FlightWishes

from .posts import posts

HALF = 20.0  # m, rows run from -HALF to HALF
HEIGHT = 3.0  # m
ACCELERATION = 3.0  # m/s²: as hard as the paper's Fig. 10 brakes, where the load allows it
ALONG = 2.0  # m/s², of it along the route
_ORIGIN = SiteOrigin(32.2, 119.5, 10.0, HeightReference.AMSL, math.pi / 2)  # Zhenjiang

POLE = "[[pole]]\nx_m = 0.0\ny_m = 0.0\nradius_m = 0.2\nheight_m = 6.0\n"


@dataclass(frozen=True, slots=True)
class Course:
    """A set of Table 6."""

    gap: float  # m between rows
    speed: float  # m/s
    length: float  # m, as the paper says
    area: float  # m², as the paper says


COURSES = (Course(4.0, 5.0, 175.0, 704.0), Course(3.0, 3.5, 215.0, 645.0),
           Course(2.0, 2.5, 295.0, 588.0))  # fmt: skip


def limits(speed: float, level: float) -> Limits:
    """What the sprayer flies with; the battery lasts the less, the more it carries."""
    heavier = SPRAYER.mass_at(level) / SPRAYER.mass
    asked = Limits(
        speed=speed,
        acceleration=ACCELERATION,
        acceleration_along=ALONG,
        clearance=2 * SPRAYER.arm,
        endurance=2400.0 / heavier**1.5,
        climb_speed=1.0,
    )
    return Load(SPRAYER, level).limits(asked)


def mission(
    ys: list[float], speed: float, level: float, swath: float, inset: float = 0.0
) -> Mission:
    """Rows along x at each y, flown to and fro; `inset` m shorter at both ends."""
    from orchard_cli.mission import plan

    rows = tuple(
        TreeRow(np.array([[inset - HALF, y], [HALF - inset, y]]), np.zeros(2), np.full(2, 0.5))
        for y in ys
    )
    wishes = FlightWishes(HEIGHT, swath=swath, corner_cut=0.5, limits=limits(speed, level))
    made = Provenance("Ahmed 2022", "0" * 64, "0", "2022-04-02T00:00:00Z")
    return plan(Orchard("Ahmed 2022", _ORIGIN, rows), wishes, made)


def world(obstacles: str, flown: Mission, seed: int) -> str:
    """A world file: still air, and an estimate without errors, as in the paper's simulation.

    Two low posts before the take-off are what the depth camera sees before the vehicle may arm.
    """
    return f"""name = "Ahmed 2022"
seed = {seed}
{obstacles}
{posts(flown, 0.6)}
[noise]
position_m = 0.0
height_m = 0.0
velocity_m_s = 0.0
attitude_deg = 0.0
"""


def tilted(y: float) -> str:
    """The box of Fig. 13, its middle `y` m left of the row."""
    return f"[[box]]\ncentre_m = [0.0, {y}, 3.0]\nsize_m = [1.0, 0.4, 6.0]\nyaw_deg = 45.0\n"


def field_obstacles() -> str:
    """The four obstacles of Table 5."""
    boxes = ((-10.0, 3.0, 2.0, 2.0, 0.0), (-15.0, 9.0, 1.0, 0.4, 45.0))
    poles = ((0.0, 3.0, 0.1), (10.0, 9.0, 0.375))
    told = [
        f"[[pole]]\nx_m = {x}\ny_m = {y}\nradius_m = {r}\nheight_m = 6.0\n" for x, y, r in poles
    ]
    told += [
        f"[[box]]\ncentre_m = [{x}, {y}, 3.0]\nsize_m = [{a}, {b}, 6.0]\nyaw_deg = {yaw}\n"
        for x, y, a, b, yaw in boxes
    ]
    return "\n".join(told)
