"""World files (TOML) and their faults. Every fault of a file is told at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.input_text import decoded, parse_toml, read_bounded
from orchard_cli.model.site import Orchard
from orchard_cli.model.world import Box, Person, Pole, SensorNoise, Tree, Wind, Wire, World

from .toml_table import Table

LARGEST_FILE = 4_000_000  # bytes
MOST_THINGS = 20_000  # of one kind
FARTHEST = 10_000.0  # m from the origin

T = TypeVar("T")


def load(path: Path, orchard: Orchard | None = None) -> World:
    """Read a world file. `orchard` is the survey's, for `trees = "survey"`.

    Raises InputError with every fault: no regular file, too large, not UTF-8, not TOML, unknown or
    missing keys, wrong types, values out of their bounds.
    """
    return load_with_bytes(path, orchard)[0]


def load_with_bytes(path: Path, orchard: Orchard | None = None) -> tuple[World, bytes]:
    """As `load`, and the file's bytes, to keep beside the flight."""
    data = read_bounded(path, LARGEST_FILE)
    return parse(decoded(data, str(path)), str(path), orchard), data


def parse(text: str, source_name: str, orchard: Orchard | None = None) -> World:
    """The world that a file's text describes; raises InputError as `load` does."""
    document = parse_toml(text, source_name)
    faults: list[Fault] = []
    top = Table(document, source_name, "", faults)
    defaults = _tree(top.table("tree_defaults"), placed=False)
    world = World(
        name=top.text("name", Path(source_name).stem),
        trees=_trees(top, defaults, orchard),
        poles=_list_of(top, "pole", _pole),
        wires=_list_of(top, "wire", _wire),
        boxes=_list_of(top, "box", _box),
        people=_list_of(top, "person", _person),
        wind=_wind(top.table("wind")),
        noise=_noise(top.table("noise")),
        seed=top.whole("seed", 0, 0, 2**31 - 1),
    )
    top.refuse_unknown()
    if faults:
        raise InputError(faults)
    return world


def from_orchard(orchard: Orchard) -> World:
    """The world that a survey tells of, for flying without a world file.

    Its trees and its known obstacles (as poles), no wind.
    """
    poles = tuple(
        Pole(float(known.position_site[0]), float(known.position_site[1]), known.radius, known.top)
        for known in orchard.obstacles
    )
    return World(name=orchard.name, trees=_survey_trees(orchard, Tree(0.0, 0.0)), poles=poles)


def _trees(top: Table, defaults: Tree, orchard: Orchard | None) -> tuple[Tree, ...]:
    own = _list_of(top, "tree", lambda table: _tree(table, defaults=defaults))
    source = top.text("trees", "")
    if source == "":
        return own
    if source != "survey":
        top.fault("trees", f'"{source}"', 'write "survey", or list [[tree]]')
    elif orchard is None:
        top.fault("trees", '"survey", but there is no survey here', "list [[tree]]")
    else:
        return _survey_trees(orchard, defaults) + own
    return own


def _survey_trees(orchard: Orchard, like: Tree) -> tuple[Tree, ...]:
    """The surveyed trees; a tree lower than the default canopy is canopy from the ground up."""
    return tuple(
        replace(
            like, x=float(x), y=float(y), ground=float(ground), height=float(height),
            canopy_height=min(like.canopy_height, float(height)),
        )
        for row in orchard.rows
        for (x, y), ground, height in zip(row.trunks_site, row.ground, row.heights, strict=True)
    )  # fmt: skip


def _list_of(top: Table, key: str, make: Callable[[Table], T]) -> tuple[T, ...]:
    return tuple(make(table) for table in top.tables(key, MOST_THINGS))


def _place(table: Table, key: str) -> float:
    return table.number(key, None, -FARTHEST, FARTHEST)


def _tree(table: Table, placed: bool = True, defaults: Tree | None = None) -> Tree:
    like = defaults or Tree(0.0, 0.0)
    tree = Tree(
        x=_place(table, "x_m") if placed else 0.0,
        y=_place(table, "y_m") if placed else 0.0,
        ground=table.number("ground_m", 0.0, -1000.0, 1000.0) if placed else 0.0,
        height=table.number("height_m", like.height, 0.2, 60.0),
        canopy_radius=table.number("canopy_radius_m", like.canopy_radius, 0.05, 20.0),
        canopy_height=table.number("canopy_height_m", like.canopy_height, 0.05, 60.0),
        trunk_radius=table.number("trunk_radius_m", like.trunk_radius, 0.005, 3.0),
    )
    if placed and not table.faulty and tree.canopy_height > tree.height:
        table.fault("canopy_height_m", f"{tree.canopy_height} m is more than the tree's height")
    table.refuse_unknown()
    return tree


def _pole(table: Table) -> Pole:
    pole = Pole(
        _place(table, "x_m"),
        _place(table, "y_m"),
        table.number("radius_m", None, 0.002, 20.0),
        table.number("height_m", None, 0.05, 200.0),
        table.number("ground_m", 0.0, -1000.0, 1000.0),
    )
    table.refuse_unknown()
    return pole


def _wire(table: Table) -> Wire:
    wire = Wire(
        table.vector("a_m", 3, FARTHEST),
        table.vector("b_m", 3, FARTHEST),
        table.number("sag_m", 0.0, 0.0, 50.0),
        table.number("radius_m", None, 0.0005, 1.0),
    )
    if not table.faulty and (wire.a_site == wire.b_site).all():
        table.fault("b_m", "the same place as a_m", "a wire needs two ends")
    table.refuse_unknown()
    return wire


def _box(table: Table) -> Box:
    box = Box(
        table.vector("centre_m", 3, FARTHEST),
        table.vector("size_m", 3, 500.0),
        math.radians(table.number("yaw_deg", 0.0, -360.0, 360.0)),
    )
    if not table.faulty and (box.size <= 0).any():
        table.fault("size_m", "a side that is not positive", "give the three full lengths")
    table.refuse_unknown()
    return box


def _person(table: Table) -> Person:
    start = table.vector("a_m", 2, FARTHEST)
    like = Person(start, start, 0.0)
    person = Person(
        start,
        table.vector("b_m", 2, FARTHEST),
        table.number("speed_m_s", 1.0, 0.0, 12.0),
        table.number("radius_m", like.radius, 0.05, 2.0),
        table.number("height_m", like.height, 0.3, 3.0),
        table.number("start_s", 0.0, 0.0, 86400.0),
    )
    table.refuse_unknown()
    return person


def _wind(table: Table) -> Wind:
    calm = Wind()
    speed = table.number("speed_m_s", 0.0, 0.0, 60.0)
    towards = math.radians(table.number("towards_deg", 0.0, -360.0, 360.0))
    wind = Wind(
        np.array([speed * math.cos(towards), speed * math.sin(towards), 0.0]),
        table.number("gust_m_s", calm.gust, 0.0, 30.0),
        table.number("gust_time_s", calm.gust_time, 0.05, 600.0),
    )
    table.refuse_unknown()
    return wind


def _noise(table: Table) -> SensorNoise:
    usual = SensorNoise()
    noise = SensorNoise(
        disparity_px=table.number("disparity_px", usual.disparity_px, 0.0, 5.0),
        dropout=table.number("dropout", usual.dropout, 0.0, 1.0),
        position=table.number("position_m", usual.position, 0.0, 20.0),
        height=table.number("height_m", usual.height, 0.0, 20.0),
        velocity=table.number("velocity_m_s", usual.velocity, 0.0, 5.0),
        attitude=math.radians(
            table.number("attitude_deg", math.degrees(usual.attitude), 0.0, 45.0)
        ),
        radar_range=table.number("radar_range_m", usual.radar_range, 0.0, 5.0),
        radar_angle=math.radians(
            table.number("radar_angle_deg", math.degrees(usual.radar_angle), 0.0, 20.0)
        ),
        radar_speed=table.number("radar_speed_m_s", usual.radar_speed, 0.0, 5.0),
        radar_miss=table.number("radar_miss", usual.radar_miss, 0.0, 1.0),
        radar_clutter=table.number("radar_clutter", usual.radar_clutter, 0.0, 50.0),
        laser_range=table.number("laser_range_m", usual.laser_range, 0.0, 5.0),
    )
    table.refuse_unknown()
    return noise
