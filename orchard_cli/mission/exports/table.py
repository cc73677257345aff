"""The course as a table (CSV): one line a place; leg, row and pump are those of the way onwards."""

from __future__ import annotations

import csv
import io

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.mission import Leg

from .course import Course, Loaded, Way

_COLUMNS = (
    "point", "leg", "row", "spray", "x_m", "y_m", "z_m", "latitude_deg", "longitude_deg",
    "height_m", "height_reference", "height_above_takeoff_m", "height_above_ground_m",
)  # fmt: skip


def write(course: Course) -> bytes:
    """The text of the table; `row` counts from 1."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(_COLUMNS)
    ways = [*course.ways, Way(Leg.TRANSIT, None)]
    for k, way in enumerate(ways):
        latitude, longitude, height = course.places_wgs84[k]
        table.writerow(
            [
                k + 1,
                way.leg.value if k < len(course.ways) else "end",
                "" if way.row is None else way.row + 1,
                int(way.sprays),
                *(f"{value:.4f}" for value in course.points_site[k]),
                f"{latitude:.9f}",
                f"{longitude:.9f}",
                f"{height:.4f}",
                course.reference.value,
                f"{course.heights[k]:.4f}",
                f"{course.clear[k]:.4f}",
            ]
        )
    return text.getvalue().encode()


def read(data: bytes) -> Loaded:
    """Read the table. Raises InputError for anything else."""
    reader = csv.DictReader(io.StringIO(data.decode("utf-8", "replace")))
    try:
        if tuple(reader.fieldnames or ()) != _COLUMNS:
            raise InputError(Fault("csv", "does not begin with the table's columns"))
        lines = list(reader)
        table = np.array(
            [
                [
                    float(line[c])
                    for c in ("latitude_deg", "longitude_deg", "height_above_takeoff_m")
                ]
                for line in lines
            ]
        ).reshape(-1, 3)
        sprays = tuple(line["spray"] == "1" for line in lines[:-1])
    except (csv.Error, KeyError, TypeError, ValueError) as error:
        raise InputError(Fault("csv", f"is no exported table: {error}")) from error
    return Loaded(table[:, :2], table[:, 2], sprays)
