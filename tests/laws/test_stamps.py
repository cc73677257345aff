"""Autopilot stamps -> flight clock."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchard_cli.vehicle.stamps import StampClock


@given(st.floats(-1e6, 1e6), st.integers(0, 2**32 - 1))
def test_delays_on_the_way_do_not_shift_the_stamps(offset, seed):
    delays = np.random.default_rng(seed).exponential(0.01, 500)
    delays[::50] = 0.0
    clock = StampClock()
    for i, delay in enumerate(delays):
        stamp = i * 0.02
        got = clock.flight_time(stamp, stamp + offset + delay)
        assert got <= stamp + offset + delay + 1e-6
    assert got == pytest.approx(stamp + offset, abs=1e-6)


def test_a_reboot_of_the_autopilot_starts_the_learning_anew():
    clock = StampClock()
    assert clock.flight_time(100.0, 5.0) == pytest.approx(5.0)
    assert clock.flight_time(2.0, 30.0) == pytest.approx(30.0)


def test_a_drifting_clock_is_followed_within_the_window():
    clock = StampClock(window=10.0)
    for i in range(5000):
        arrived = i * 0.02
        got = clock.flight_time(arrived * 0.9999, arrived)
    assert got == pytest.approx(arrived, abs=2e-3)


@pytest.mark.parametrize("step", [-30.0, -5.0, -1.5, -0.8, -0.2, 0.2, 3.0, 60.0])
def test_a_step_of_the_autopilots_clock_is_never_taken_for_the_future_and_is_over_in_10_s(step):
    clock = StampClock()
    for i in range(1500):
        arrived = i * 0.02
        got = clock.flight_time(arrived + (step if i >= 500 else 0.0), arrived)
        assert got <= arrived + 1e-6
        if step > 0 or step < -1.0 or not 500 <= i <= 1000:
            assert got == pytest.approx(arrived, abs=1e-6)
