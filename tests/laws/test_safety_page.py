"""docs/safety.md says what the code does, and names tests that exist."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from orchard_cli.flight.safety import Phase
from orchard_cli.flight.safety_page import renewed
from orchard_cli.flight.spray import spray
from tests.laws.test_safety import vehicle

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "safety.md").read_text()
NAMED = re.findall(r"`(tests/\S+\.py)::(test_\w+)`", PAGE)


def test_the_table_in_the_docs_is_the_one_that_flies():
    assert renewed(PAGE) == PAGE


def test_every_requirement_names_a_test_that_exists():
    section = PAGE.split("## Requirements")[1].split("\n## ")[0]
    assert section.count("\n- ") == len(NAMED) > 10
    for file, name in NAMED:
        assert f"def {name}(" in (ROOT / file).read_text(), (file, name)


@pytest.mark.parametrize("phase", [phase for phase in Phase if phase is not Phase.ROUTE])
def test_spray_is_off_in_every_phase_but_the_route(phase):
    assert not spray(SimpleNamespace(), phase, vehicle()).on
