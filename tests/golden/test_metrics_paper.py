"""Liu 2024's figures are copied right: they give the savings that the paper itself states."""

from __future__ import annotations

import pytest

from orchard_cli.analysis.comparison import comparison
from orchard_cli.analysis.figures import Metrics, Unknown
from orchard_cli.analysis.paper import PUBLISHED


@pytest.mark.parametrize(
    ("table", "time", "deviation", "yaw"),
    [("liu2024-table1", 28.7, 10.1, 70.1), ("liu2024-table2", 27.8, 8.8, 56.1)],
)
def test_published_figures_give_the_published_savings(table, time, deviation, yaw):
    """In % of the ego-planner's figure (Liu 2024, §5.2 and §6.2)."""
    own, ego = (flight.figures for flight in PUBLISHED[table])

    def saved(name):
        return 100 * (1 - own[name] / ego[name])

    assert saved("duration_s") == pytest.approx(time, abs=0.06)
    assert saved("avoidance_peak_mean_m") == pytest.approx(deviation, abs=0.06)
    assert saved("yaw_rate_max_rad_s") == pytest.approx(yaw, abs=0.06)


def test_deltas_are_shares_of_the_papers_own_system():
    ours = Metrics({"duration_s": 2 * 333.54, "distance_m": Unknown("cut")}, (), None, None, ())
    duration, distance = comparison([ours], PUBLISHED["liu2024-table1"])
    assert duration.cells[0].delta == pytest.approx(1.0)
    assert (duration.cells[1].figure, duration.cells[2].figure) == (333.54, 467.67)
    assert distance.cells[0].delta is None
