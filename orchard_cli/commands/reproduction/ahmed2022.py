"""Ahmed 2022: drift, one obstacle, a tilted box, spraying missions, a larger safe distance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from orchard_cli.commands.wiring import Choices

from . import ahmed_fields as fields
from .ahmed_published import APPROACHES, DRIFT, MISSIONS, POLE, WIDER
from .desk import Desk
from .flights import Task
from .rows import Row

if TYPE_CHECKING:
    from orchard_cli.analysis import Flight
    from orchard_cli.model.arrays import Array
    from orchard_cli.model.mission import Mission

TITLE = "Ahmed 2022, Agronomy 12:873"
STILL = 0.1  # m/s under which the vehicle has not set out, or has arrived
LEAD = 5.0  # s from take-off to setting out, which the paper's times include


@dataclass(frozen=True, slots=True, eq=False)
class _Flown:
    """The part of a flight that the paper counts: from setting out to being at rest at the end."""

    times: Array  # (n,) s
    places: Array  # (n, 3) m, true
    rolls: Array  # (n,) rad
    contact: str
    done: bool

    @property
    def length(self) -> float:
        """m along the true path."""
        return float(np.linalg.norm(np.diff(self.places, axis=0), axis=1).sum())


def table3(desk: Desk) -> list[Row]:
    """The drift after a stop."""
    from orchard_cli.commands.identification import LEVELS, SPEEDS, fly_test

    note = "with the 0.3 s to which a flight here is committed, and PX4's cascade instead of a PID"
    rows = []
    for speed in SPEEDS:
        desk.say(f"drift at {speed} m/s")
        for level, paper in zip(LEVELS, DRIFT[speed], strict=True):
            ours = fly_test(level, speed, fields.ACCELERATION).drift
            rows.append(Row("Table 3", f"{speed} m/s", f"level {level}", paper, ours, "m", note))
    return rows


@dataclass(frozen=True, slots=True)
class _Plan:
    """One flight."""

    name: str
    mission: Mission
    obstacles: str
    level: float
    system: str = "dfa"


def table4(desk: Desk) -> list[Row]:
    """One pole straight ahead, six levels."""
    plans = [_Plan(f"pole-{level:.2f}", _row(level), fields.POLE, level) for level in POLE]
    return [row for plan, flight in _flights(desk, plans) for row in _pole(plan, flight)]


def _pole(plan: _Plan, flight: Flight) -> list[Row]:
    flown = _flown(flight, plan.mission)
    ours = (
        flown.times[-1] - flown.times[0] + LEAD,
        100 * np.abs(flown.places[:, 1]).max(),
        100 * (fields.HEIGHT - flown.places[:, 2].min()),
        math.degrees(flown.rolls.max()),
        math.degrees(-flown.rolls.min()),
        _clearance(flight),
    )
    columns = (
        ("travel time", "s"), ("y-max", "cm"), ("z-max fall", "cm"),
        ("roll max +", "deg"), ("roll max -", "deg"), ("least distance", "m"),
    )  # fmt: skip
    row, paper = f"level {plan.level}", (*POLE[plan.level], None)
    return _cells("Table 4", row, columns, paper, ours, _said(flown))


def figure13(desk: Desk) -> list[Row]:
    """A box turned by 45 degrees, met left of the middle, in the middle, and right of it."""
    plans = [
        _Plan(f"tilted-{name}", _row(0.1), fields.tilted(y), 0.1)
        for name, (y, _) in APPROACHES.items()
    ]
    sides = [side for _, side in APPROACHES.values()]
    rows = []
    for (plan, flight), paper in zip(_flights(desk, plans), sides, strict=True):
        flown = _flown(flight, plan.mission)
        aside = flown.places[:, 1]
        ours = float(np.sign(aside[int(np.argmax(np.abs(aside)))]))
        said = f"most {np.abs(aside).max():.2f} m aside; {_said(flown)}"
        rows += [
            Row("Fig. 13", plan.name, "side passed", paper, ours, "+ left", said),
            Row("Fig. 13", plan.name, "least distance", None, _clearance(flight), "m"),
        ]
    return rows


def table6(desk: Desk) -> list[Row]:
    """Three gaps, five levels, four obstacles (Table 5)."""
    cases = [(course, level) for course in fields.COURSES for level in MISSIONS[course.gap]]
    plans = [_field(f"field-{c.gap:.0f}m-{level:.2f}", c, level, "dfa") for c, level in cases]
    rows = []
    for (plan, flight), (course, level) in zip(_flights(desk, plans), cases, strict=True):
        paper = MISSIONS[course.gap][level]
        rows += _covered("Table 6", course, plan, flight, paper)
    return rows


def figure16(desk: Desk) -> list[Row]:
    """A safe distance of 2 m on the 3 m rows."""
    course = fields.COURSES[1]
    plans = [_field(f"wide-{level:.2f}", course, level, "dfa-wide") for level in WIDER]
    rows = []
    for plan, flight in _flights(desk, plans):
        paper = (None, None, None, None, WIDER[plan.level])
        rows += _covered("Fig. 16", course, plan, flight, paper)
    return rows


TABLES = {"3": table3, "4": table4, "fig13": figure13, "6": table6, "fig16": figure16}


def _flights(desk: Desk, plans: Sequence[_Plan]) -> Iterator[tuple[_Plan, Flight]]:
    """Each plan's flight, flown where that was not done."""
    made = [(plan, _choices(desk, plan), _world(desk, plan)) for plan in plans]
    desk.fly_all(
        [
            Task.of(desk.folder, plan.name, plan.mission, world, choices, desk.reuse)
            for plan, choices, world in made
        ]
    )
    for plan, choices, world in made:
        yield plan, desk.fly(plan.name, plan.mission, world, choices)


def _choices(desk: Desk, plan: _Plan) -> Choices:
    return Choices(
        system=plan.system, seed=desk.seed, camera=(212, 120), vehicle="sprayer", level=plan.level
    )


def _world(desk: Desk, plan: _Plan) -> str:
    return fields.world(plan.obstacles, plan.mission, desk.seed)


def _row(level: float) -> Mission:
    """One row of Tables 4 and Fig. 13."""
    return fields.mission([0.0], 3.5, level, 3.0, inset=_inset(3.5, level))


def _field(name: str, course: fields.Course, level: float, system: str) -> _Plan:
    ys = [float(y) for y in np.arange(0.0, 12.0 + 1e-9, course.gap)]
    mission = fields.mission(ys, course.speed, level, course.gap)
    return _Plan(name, mission, fields.field_obstacles(), level, system)


def _covered(
    table: str, course: fields.Course, plan: _Plan, flight: Flight,
    paper: tuple[float | None, ...],
) -> list[Row]:  # fmt: skip
    mission = plan.mission
    flown = _flown(flight, mission)
    columns = (
        ("time", "s"), ("average z fall", "cm"), ("length", "m"), ("increase", "m"),
        ("coverage", "%"), ("least distance", "m"),
    )  # fmt: skip
    falls = 100 * np.maximum(fields.HEIGHT - flown.places[:, 2], 0.0)
    free = mission.route_length + _outside(mission)
    ours = (
        flown.times[-1] - flown.times[0] + LEAD,
        float(falls.mean()),
        flown.length - _outside(mission) + fields.HEIGHT,
        flown.length - free,
        _coverage(flown.places, course.gap),
        _clearance(flight),
    )
    pumped = flight.metrics.figures["coverage_percent"]
    said = f"{_said(flown)}; pump off in avoidances: {pumped}"
    if isinstance(pumped, float):
        said = f"{_said(flown)}; pump off in avoidances: {pumped:.1f} %"
    row = f"gap {course.gap:.0f} m, level {plan.level}"
    return _cells(table, row, columns, (*paper, None), ours, said)


def _clearance(flight: Flight) -> float:
    """m between the vehicle's centre and the nearest obstacle, all the way."""
    found = flight.metrics.figures["clearance_min_m"]
    return float(found) if isinstance(found, int | float) else math.nan


def _cells(
    table: str, row: str, columns: tuple[tuple[str, str], ...],
    paper: tuple[float | None, ...], ours: tuple[float, ...], note: str,
) -> list[Row]:  # fmt: skip
    return [
        Row(table, row, column, theirs, float(mine), unit, note if k == 0 else "")
        for k, ((column, unit), theirs, mine) in enumerate(zip(columns, paper, ours, strict=True))
    ]


def _flown(flight: Flight, mission: Mission) -> _Flown:
    """Cut the true track to what the paper counts."""
    truth = flight.log.truth
    assert truth is not None
    up = truth.positions_site[:, 2] > fields.HEIGHT - 0.5
    moving = np.linalg.norm(truth.velocities_site[:, :2], axis=1) > STILL
    inside = np.flatnonzero(up & moving)
    first, last = (int(inside[0]), int(inside[-1])) if len(inside) else (0, len(up) - 1)
    w, x, y, z = truth.site_from_body[first : last + 1].T
    rolls = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    places = truth.positions_site[first : last + 1]
    done = float(np.linalg.norm(places[-1, :2] - mission.landing_site)) < 1.0
    touched = flight.log.contacts or ()
    contact = str(touched[0]) if touched else ""
    return _Flown(truth.times[first : last + 1], places, rolls, contact, done)


def _said(flown: _Flown) -> str:
    if flown.contact:
        return f"touched {flown.contact}"
    return "flown to its end" if flown.done else "did not reach its end"


def _inset(speed: float, level: float) -> float:
    """m by which the rows are shortened, so that the flight is at rest at -HALF and at HALF."""
    from orchard_cli.mission.route import run_up

    return run_up(fields.limits(speed, level))


def _outside(mission: Mission) -> float:
    """m of run-up and run-out beyond the first and last waypoint."""
    ends = mission.waypoints_site[[0, -1], :2]
    spots = np.array([mission.takeoff_site, mission.landing_site])
    return float(np.linalg.norm(ends - spots, axis=1).sum())


def _coverage(places: Any, gap: float) -> float:
    """A_CP of the flown path, the pump never off (eqs. 30-31)."""
    import shapely

    half = gap / 2
    ideal = shapely.box(-fields.HALF - half, -half, fields.HALF + half, 12.0 + half)
    strip = shapely.LineString(places[:, :2]).simplify(0.02).buffer(half, cap_style="square")
    return float(100 * strip.intersection(ideal).area / ideal.area)
