"""The example sheet in missions/: it plans, and its rows stand where docs/survey.md says."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from orchard_cli import mission as missions
from orchard_cli import survey
from orchard_cli.model.mission import Provenance

SHEET = Path(__file__).parents[2] / "missions" / "example.survey.csv"


@cache
def planned():
    read = survey.load(SHEET)
    source = Provenance(read.file, read.sha256, "test", "2026-01-01T00:00:00+00:00")
    return missions.plan(read.orchard, read.wishes, source)


def test_rows_run_along_x_and_the_others_lie_to_the_left():
    ends = [row.trunks_site[[0, -1]].tolist() for row in planned().orchard.rows]
    assert ends == [
        [pytest.approx([0.0, 0.0]), pytest.approx([8.9, 0.0])],
        [pytest.approx([0.5, 6.0]), pytest.approx([9.6, 6.0])],
        [pytest.approx([-0.2, 12.2]), pytest.approx([9.1, 12.2])],
    ]


def test_the_flight_runs_from_row_to_row_at_the_height_asked_for():
    waypoints = planned().waypoints_site
    assert waypoints[:, 0] == pytest.approx([0.0, 8.9, 9.6, 0.5, -0.2, 9.1])
    assert waypoints[:, 1] == pytest.approx([0.0, 0.0, 6.0, 6.0, 12.2, 12.2])
    assert waypoints[:, 2] == pytest.approx(3.5)


def test_the_second_row_lies_north_of_the_first_when_rows_head_east():
    first, _, _, second, *_ = planned().waypoints_wgs84
    assert second[0] > first[0]
