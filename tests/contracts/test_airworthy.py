"""Which systems a real vehicle may fly."""

from __future__ import annotations

import pytest

from orchard_cli.commands.systems import BENCH_ONLY, SYSTEMS, demand_airworthy
from orchard_cli.errors import InputError


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
