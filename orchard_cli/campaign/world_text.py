"""A world as the text of a world file, so that a case can be kept, read and flown again."""

from __future__ import annotations

import math
from collections.abc import Mapping

from orchard_cli.model.arrays import Vector
from orchard_cli.model.world import Box, Person, Pole, Tree, Wind, Wire, World

Value = float | str | Vector


def world_text(world: World) -> str:
    """TOML that the simulator's world files are written in; every key is told."""
    tables = [_table("[tree]", _tree(tree)) for tree in world.trees]
    tables += [_table("[pole]", _pole(pole)) for pole in world.poles]
    tables += [_table("[wire]", _wire(wire)) for wire in world.wires]
    tables += [_table("[box]", _box(box)) for box in world.boxes]
    tables += [_table("[person]", _person(person)) for person in world.people]
    tables += [_table("wind", _wind(world.wind)), _table("noise", _noise(world))]
    return _keys({"name": world.name, "seed": world.seed}) + "".join(tables)


def _table(name: str, keys: Mapping[str, Value]) -> str:
    return f"\n[{name}]\n{_keys(keys)}"


def _keys(keys: Mapping[str, Value]) -> str:
    return "".join(f"{key} = {_value(value)}\n" for key, value in keys.items())


def _value(value: Value) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, (int, float)):
        return repr(value)
    return f"[{', '.join(repr(float(x)) for x in value)}]"


def _tree(tree: Tree) -> dict[str, Value]:
    return {
        "x_m": tree.x, "y_m": tree.y, "ground_m": tree.ground, "height_m": tree.height,
        "canopy_radius_m": tree.canopy_radius, "canopy_height_m": tree.canopy_height,
        "trunk_radius_m": tree.trunk_radius,
    }  # fmt: skip


def _pole(pole: Pole) -> dict[str, Value]:
    return {
        "x_m": pole.x, "y_m": pole.y, "radius_m": pole.radius, "height_m": pole.height,
        "ground_m": pole.ground,
    }  # fmt: skip


def _wire(wire: Wire) -> dict[str, Value]:
    return {"a_m": wire.a_site, "b_m": wire.b_site, "sag_m": wire.sag, "radius_m": wire.radius}


def _box(box: Box) -> dict[str, Value]:
    return {"centre_m": box.centre_site, "size_m": box.size, "yaw_deg": math.degrees(box.yaw)}


def _person(person: Person) -> dict[str, Value]:
    return {
        "a_m": person.a_site, "b_m": person.b_site, "speed_m_s": person.speed,
        "radius_m": person.radius, "height_m": person.height, "start_s": person.start,
    }  # fmt: skip


def _wind(wind: Wind) -> dict[str, Value]:
    x, y = (float(v) for v in wind.velocity_site[:2])
    return {
        "speed_m_s": math.hypot(x, y), "towards_deg": math.degrees(math.atan2(y, x)),
        "gust_m_s": wind.gust, "gust_time_s": wind.gust_time,
    }  # fmt: skip


def _noise(world: World) -> dict[str, Value]:
    noise = world.noise
    return {
        "disparity_px": noise.disparity_px, "dropout": noise.dropout,
        "position_m": noise.position, "height_m": noise.height,
        "velocity_m_s": noise.velocity, "attitude_deg": math.degrees(noise.attitude),
        "radar_range_m": noise.radar_range, "radar_angle_deg": math.degrees(noise.radar_angle),
        "radar_speed_m_s": noise.radar_speed, "radar_miss": noise.radar_miss,
        "radar_clutter": noise.radar_clutter, "laser_range_m": noise.laser_range,
    }  # fmt: skip
