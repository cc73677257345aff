"""The drawings of the page: one avoidance, and what was sprayed."""

from __future__ import annotations

import numpy as np

from orchard_cli.geometry.shapes import walker_at
from orchard_cli.model.arrays import Points
from orchard_cli.model.world import World

from ..coverage import areas, flown_lines, planned_lines
from ..figures import Unknown
from ..flight import Flight
from ..turns import Turn
from .svg import CELL, GREY, INK, LEAF, Ground

FLOWN, OLD, NEW = "#0072B2", "#D55E00", "#7B3FA0"
APPLIED, MISSED, DOUBLED, BESIDE = "#8CC5A0", "#D55E00", "#56309B", "#E8C766"
TREE_RADIUS = 1.0  # m: surveys measure no canopy width, so their trees are discs of this size
MARGIN = 1.5  # m
LEAST = 12.0  # m: a map shows at least this much


def turn_map(flight: Flight, turn: Turn, title: str) -> str:
    """What was known when it was decided, the path given up, the new one, and the one flown."""
    points = [p[:, :2] for p in (turn.flown_site, turn.new_site) if len(p)]
    low, high = _frame(np.vstack(points))
    ground = Ground(low, high, title)
    orchard(ground, flight)
    ground.line(flight.mission.waypoints_site, GREY, 2.0, "7 6")
    ground.line(turn.old_site, OLD, 3.0, "2 7")
    ground.line(turn.flown_site, FLOWN, 4.0)
    ground.line(turn.new_site, NEW, 2.0, "9 5")
    if flight.world is not None:
        obstacles(ground, flight.world, turn.decided)
    near = np.all((turn.cells_site > low) & (turn.cells_site < high), axis=1)
    ground.squares(turn.cells_site[near], turn.cell, CELL)
    ground.craft(turn.vehicle_site, turn.heading, FLOWN)
    ground.label(turn.vehicle_site, "decided here", -20, 30)
    ground.scale_bar()
    return ground.text()


def _frame(points: Points) -> tuple[Points, Points]:
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    lack = np.maximum(0.0, np.array([LEAST, max(LEAST, (high - low)[0]) * 0.45]) - (high - low)) / 2
    return low - lack, high + lack


def orchard(ground: Ground, flight: Flight) -> None:
    """Trees as discs: the world's canopies, else the survey's trees at one size."""
    if flight.world is not None:
        for tree in flight.world.trees:
            ground.disc((tree.x, tree.y), tree.canopy_radius, LEAF)
        return
    for row in flight.mission.orchard.rows:
        for trunk in row.trunks_site:
            ground.disc(trunk, TREE_RADIUS, LEAF)


def obstacles(ground: Ground, world: World, time: float) -> None:
    """Everything that the simulated world has besides trees, where it was at a time."""
    for pole in world.poles:
        ground.disc((pole.x, pole.y), pole.radius, INK, least=4.0)
    for wire in world.wires:
        ground.line([wire.a_site, wire.b_site], INK, 2.0)
    for box in world.boxes:
        x, y = box.size[0] / 2, box.size[1] / 2
        corners = np.array([(x, y), (-x, y), (-x, -y), (x, -y), (x, y)])
        turn = np.array([[np.cos(box.yaw), -np.sin(box.yaw)], [np.sin(box.yaw), np.cos(box.yaw)]])
        ground.line(corners @ turn.T + box.centre_site[:2], INK, 3.0)
    for person in world.people:
        ground.disc(walker_at(person, np.array([time]))[0], person.radius, "#CC79A7", least=5.0)


def coverage_map(flight: Flight, title: str) -> str | None:
    """Applied, missed, doubled and beside the plan; None when nothing is planned or logged."""
    mission = flight.mission
    lines = planned_lines(mission)
    if not lines or isinstance(flight.metrics.figures["coverage_percent"], Unknown):
        return None
    found = areas(lines, flown_lines(flight.log), mission.swath)
    points = np.vstack([mission.waypoints_site[:, :2], *lines])
    low, high = points.min(axis=0) - mission.swath, points.max(axis=0) + mission.swath
    ground = Ground(low, high, title)
    ground.area(found.planned.intersection(found.treated), APPLIED)
    ground.area(found.treated.difference(found.planned), BESIDE)
    ground.area(found.missed, MISSED)
    ground.area(found.doubled, DOUBLED)
    ground.line(flight.log.odometry.positions_site[::5], INK, 1.2)
    for row in mission.orchard.rows:
        for trunk in row.trunks_site:
            ground.disc(trunk, 0.25, "white", least=2.0)
    if flight.world is not None:
        obstacles(ground, flight.world, flight.begin)
    ground.scale_bar()
    return ground.text()
