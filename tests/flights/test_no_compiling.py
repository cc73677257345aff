"""No pause in flight: what flies is compiled or loaded before the vehicle is armed."""

import subprocess
import sys
from pathlib import Path

import pytest

from orchard_cli.commands.systems import SYSTEMS

FLY = """
import sys
from pathlib import Path

from orchard_cli import mission as missions
from orchard_cli.commands.fly import fly_mission
from orchard_cli.commands.wiring import Choices
from orchard_cli.flight.runner import Flight
from orchard_cli.kernel_cache import counts

def flying():  # the simulator's kernels are not in flight
    every, simulated = counts(), counts("orchard_cli.simulator")
    return every.loaded - simulated.loaded, every.compiled - simulated.compiled

def run(self, fly=Flight.run):
    before = flying()
    ending = fly(self)
    print(before, flying())
    return ending

Flight.run = run
folder, system = Path(sys.argv[1]), sys.argv[2]
mission = missions.load(folder / "two.mission.json")
choices = Choices(system=system, camera=(212, 120))
fly_mission(mission, choices, folder / "a.mcap", folder / "two.world.toml",
            lockstep=True, quiet=True)
"""
SURVEY = """
name = "two rows"
[site]
latitude_deg = 23.158
longitude_deg = 113.352
height_m = 30.0
height_reference = "amsl"
heading_deg = 70.0
[flight]
height_m = 3.5
[[row]]
gaps_m = [3.0, 3.0, 3.0, 3.0, 3.0]
tree_height_m = 2.2
"""
WORLD = """
name = "two rows"
trees = "survey"
[[pole]]
x_m = 7.5
y_m = 0.0
radius_m = 0.15
height_m = 8.0
"""


@pytest.mark.parametrize("system", SYSTEMS)
def test_nothing_is_compiled_or_loaded_once_the_flight_has_begun(system, tmp_path):
    (tmp_path / "two.survey.toml").write_text(SURVEY)
    (tmp_path / "two.world.toml").write_text(WORLD)
    for words in (
        [
            str(Path(sys.executable).parent / "orchard"),
            "plan",
            str(tmp_path / "two.survey.toml"),
            "-q",
        ],
        ["-c", FLY, str(tmp_path), system],
    ):
        ran = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr
    before, after = ran.stdout.strip().split(") (")
    assert before.strip("()") == after.strip("()")
    assert not before.startswith("(0, 0")
