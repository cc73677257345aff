"""Which systems a real vehicle may fly."""

from __future__ import annotations

import pytest

from orchard_cli.commands.real_sensors import refuse_unknown
from orchard_cli.commands.systems import BENCH_ONLY, SYSTEMS, demand_airworthy, yaw_rule
from orchard_cli.commands.wiring import Choices
from orchard_cli.errors import InputError, LinkError
from orchard_cli.motion.yaw import PUBLISHED, STEADY


@pytest.mark.parametrize("system", SYSTEMS)
def test_what_has_touched_something_or_passes_too_near_flies_no_real_vehicle(system: str) -> None:
    if system in BENCH_ONLY:
        with pytest.raises(InputError, match="does not fly a real vehicle"):
            demand_airworthy(system)
    else:
        demand_airworthy(system)


def test_the_default_is_airworthy_and_every_refusal_names_a_system() -> None:
    demand_airworthy("guided")
    assert set(BENCH_ONLY) <= set(SYSTEMS)


def test_the_published_yaw_is_the_published_systems_own_a_choice_and_for_the_bench() -> None:
    assert yaw_rule(Choices(system="ego-published")) is PUBLISHED
    assert yaw_rule(Choices(system="ego")) is STEADY
    assert yaw_rule(Choices(system="ego", yaw="published")) is PUBLISHED
    with pytest.raises(InputError, match="steady, published"):
        yaw_rule(Choices(yaw="sideways"))
    with pytest.raises(InputError, match="--yaw"):
        demand_airworthy("ego", "published")
    demand_airworthy("ego", "steady")


def test_colour_is_refused_of_a_real_camera_with_what_to_leave_out() -> None:
    with pytest.raises(LinkError, match="leave out --detector"):
        refuse_unknown("zones", frozenset({"colour"}))
