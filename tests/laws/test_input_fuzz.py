"""No bytes make a reader of worlds, missions, tasks, settings or terrains fail in another
way than by faults of one line each, within bounded time and memory.

`ORCHARD_FUZZ=10000 pytest tests/laws/test_input_fuzz.py --timeout 3000` runs that many a reader;
logs have theirs in tests/contracts/test_hostile_logs.py.
"""

from __future__ import annotations

import io
import os
import random
import resource
import subprocess
import sys
import zipfile
from contextlib import suppress
from pathlib import Path

import made_terrain
import pytest
from made_flights import planned_mission
from made_surveys import collection, point

from orchard_cli import mission as missions
from orchard_cli import survey
from orchard_cli.errors import InputError
from orchard_cli.model.input_text import decoded, parse_toml
from orchard_cli.simulator import world_file
from orchard_cli.survey import Form, Given, geotiff, load_tasks

CASES = int(os.environ.get("ORCHARD_FUZZ", "40"))
MISSIONS = Path(__file__).parents[2] / "missions"
PIECES = (
    b"", b"-", b"nan", b"inf", b"1e999", b"-1e308", b"[", b"]", b"[[", b"{", b"}", b'"', b"'''",
    b"\n", b"=", b".", b",", b"#", b"9" * 400, b"null", b"true", b"\x00", b"\xff", b"\xef\xbb\xbf",
    b"[pole]", b"[[tree]]", b"a.b.c = 1", b"1979-05-27", b"0x1", b"\\u0000",
)  # fmt: skip
TASKS = b"""
[[task]]
do = "takeoff"
at_m = [0.0, 0.0]
height_m = 3.0
[[task]]
do = "fly"
to_m = [10.0, 0.0]
[[task]]
do = "hover"
for_s = 5
[[task]]
do = "land"
"""


def spoilt(data, seed):
    """A text with pieces put in, cut out and doubled, by a seed."""
    chance = random.Random(seed)
    for _ in range(chance.choice((1, 1, 2, 4))):
        at = chance.randrange(len(data) + 1)
        cut = at + chance.choice((0, 1, 8, 60))
        again = data[at:cut] * chance.choice((0, 1, 3))
        data = data[:at] + chance.choice(PIECES) + again + data[cut:]
    return data


def only_faults(act, *what):
    """Whatever `act` makes of it, it is a value or faults of one printable line each."""
    faults = ()
    try:
        act(*what)
    except InputError as error:
        faults = error.faults
    for fault in faults:
        assert str(fault).isprintable(), str(fault)


ORCHARD = survey.load(MISSIONS / "lemon-gazebo.survey.toml").orchard
TREES = collection(
    [point([113.1 + 3e-5 * (k % 4), 23.4 + 6e-5 * (k // 4)], row=k // 4) for k in range(12)]
)


def world(data):
    world_file.parse(decoded(data, "w"), "w", ORCHARD)


def settings_table(data):
    tables = parse_toml(decoded(data, "s"), "s")
    survey.parse(TREES, "t", Form.GEOJSON, Given(tree_height_m=2.0, settings=tables))


READERS = {
    "mission": (missions.loads, missions.dumps(planned_mission()).encode()),
    "world": (world, (MISSIONS / "lemon-gazebo.world.toml").read_bytes()),
    "settings": (settings_table, (MISSIONS / "lemon-field.settings.toml").read_bytes()),
    "survey": (
        lambda data: survey.parse(data, "f", Form.TOML),
        (MISSIONS / "lemon-gazebo.survey.toml").read_bytes(),
    ),
    "sheet": (
        lambda data: survey.parse(data, "f", Form.SHEET),
        (MISSIONS / "example.survey.csv").read_bytes(),
    ),
}


@pytest.mark.parametrize("name", list(READERS))
def test_no_spoilt_text_makes_a_reader_fail_in_another_way(name):
    read, data = READERS[name]
    read(data)
    for seed in range(CASES):
        only_faults(read, spoilt(data, seed))


def test_no_spoilt_tasks_make_their_reader_fail_in_another_way(tmp_path):
    file = tmp_path / "t.toml"
    file.write_bytes(TASKS)
    load_tasks(file)
    for seed in range(CASES):
        file.write_bytes(spoilt(TASKS, seed))
        only_faults(load_tasks, file)


def test_no_changed_geotiff_makes_its_reader_fail_in_another_way(tmp_path):
    made_terrain.write(tmp_path / "whole.tif", made_terrain.plane(0.1, 0), reach=20)
    whole, file = (tmp_path / "whole.tif").read_bytes(), tmp_path / "t.tif"
    for seed in range(CASES):
        chance = random.Random(seed)
        data = bytearray(whole[: chance.choice((len(whole), chance.randrange(1, len(whole))))])
        for _ in range(chance.choice((1, 3, 20))):
            data[chance.randrange(min(len(data), 600))] = chance.randrange(256)
        file.write_bytes(data)
        only_faults(geotiff.read, file)


def bomb(inner=200_000_000, name="doc.kml"):
    """A KMZ of a few hundred kilobytes that unpacks to 200 MB."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, b"<kml>" + b" " * inner)
    return packed.getvalue()


def within(seconds, megabytes, command, *what):
    """Exit code and what a command said, of a process that may take no more."""

    def bound():
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        resource.setrlimit(resource.RLIMIT_DATA, (megabytes * 2**20, megabytes * 2**20))

    done = subprocess.run(
        [Path(sys.executable).with_name("orchard"), command, *map(str, what)],
        capture_output=True, text=True, check=False, preexec_fn=bound,
    )  # fmt: skip
    return done.returncode, done.stderr


HOSTILE = {
    "deep.geojson": lambda: b"[" * 7_900_000,
    "deep.kml": lambda: b"<a>" * 2_600_000,
    "bomb.kmz": bomb,
    "laughs.kml": lambda: (
        b'<!DOCTYPE l [<!ENTITY a "ha">'
        + b"".join(
            b'<!ENTITY %c "%s">' % (98 + k, b"&%c;" % (97 + k) * 10) for k in range(9)
        )
        + b"]><kml>&j;</kml>"
    ),
    "wide.csv": lambda: b"lat;lon\n" + b";" * 7_900_000,
    "long.survey.toml": lambda: b"a = " + b"[" * 990_000,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", list(HOSTILE))
def test_hostile_surveys_end_in_one_line_soon(tmp_path, name):
    file = tmp_path / name
    file.write_bytes(HOSTILE[name]())
    code, said = within(20, 1500, "plan", file, "-o", tmp_path / "m.json")
    assert code == 2, said[-500:]
    assert said.count("\n") == 1


@pytest.mark.slow
def test_a_mission_of_ten_million_brackets_ends_in_one_line_soon(tmp_path):
    file = tmp_path / "deep.mission.json"
    file.write_bytes(b"[" * 10_000_000)
    code, said = within(20, 1500, "check", file)
    assert code == 2, said[-500:]
    assert said.count("\n") == 1
    with suppress(InputError):
        missions.loads(b'{"schema": ' + b"[" * 9_000_000)
