"""The stand-in map that EGO-Planner's flights are measured again with."""

from __future__ import annotations

import numpy as np

from orchard_cli.avoidance import Ego, EgoSettings
from orchard_cli.commands.reproduction import ideal
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.world import Pole

POLE = Pole(12.0, 0.1, 0.15, 8.0)


def test_a_pole_is_in_the_map_once_it_is_near_and_in_view_and_only_its_front():
    grid = ideal.SeenPoles([POLE])

    def seen():
        return grid.window(np.array([10.0, -2.0, 3.0]), np.array([14.0, 2.0, 4.0])).occupied

    grid.see(np.array([7.5, 0.0, 3.5]), 0.0)  # too far
    grid.see(np.array([9.0, 0.0, 3.5]), np.pi / 2)  # out of view
    assert not seen().any()
    grid.see(np.array([9.0, 0.0, 3.5]), 0.0)
    columns = np.argwhere(seen().any(axis=2))
    assert len(columns)
    assert (10.0 + 0.1 * columns[:, 0]).max() < 12.0
    assert seen()[tuple(columns[0])].all()  # from below to above


def test_a_flight_goes_to_the_end_of_its_route_and_keeps_off_the_pole():
    along = np.concatenate([np.zeros(2), np.arange(0.0, 25.0, 0.5), np.full(3, 25.0)])
    points = np.column_stack([along, 0 * along, 0 * along + 3.5])
    flown = ideal.fly(
        Ego(EgoSettings.published()), Trajectory(0.0, 0.5, points), [POLE], Limits(acceleration=1.0)
    )
    assert flown.clearance([POLE]) > 0.05
    np.testing.assert_allclose(flown.places[-1], [25.0, 0.0, 3.5], atol=0.01)
    assert 10 < flown.curves < 25
