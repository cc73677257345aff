"""`orchard plan`, `fly` over MAVSDK and `analyze`, as a user runs them."""

import contextlib
import json
import os
import pty
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import numpy as np
import pytest

from orchard_cli.errors import InputError
from orchard_cli.flightlog import read

pytestmark = pytest.mark.flight
ORCHARD = Path(sys.executable).parent / "orchard"
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
[[row]]
distance_m = 6.0
gaps_m = [3.0, 3.0, 3.0, 3.0, 3.0]
tree_height_m = 2.2
"""
WORLD = """
name = "two rows"
trees = "survey"
[[pole]]
x_m = 10.5
y_m = 0.0
radius_m = 0.15
height_m = 8.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("two-rows")
    (folder / "two.survey.toml").write_text(SURVEY)
    (folder / "two.world.toml").write_text(WORLD)
    run(folder, "plan", "two.survey.toml", "-q")
    return folder


def run(folder, *words, code=0, timeout=180):
    done = subprocess.run(
        [ORCHARD, *words], cwd=folder, capture_output=True, text=True, timeout=timeout, check=False
    )
    assert done.returncode == code, done.stderr + done.stdout
    assert "Traceback" not in done.stderr
    return done


FLY = ("fly", "two.mission.json", "--world", "two.world.toml", "--camera", "424x240")


def test_over_mavsdk_a_pole_is_passed_at_the_clearance_and_the_log_tells_it(folder):
    flown = json.loads(run(folder, *FLY, "--speed-factor", "3", "--log", "a.mcap", "--json").stdout)
    assert flown["as_planned"]
    assert flown["log_losses"] == {}
    report = json.loads(run(folder, "analyze", "a.mcap", "--json").stdout)
    metrics = report["logs"][0]["metrics"]
    assert metrics["avoidances"] == 1
    assert metrics["clearance_min_m"] >= 0.85
    assert metrics["avoidance_peak_mean_m"] <= 1.6
    assert metrics["height_error_max_m"] < 0.3
    assert metrics["battery_left_percent"] > 50


def test_lockstep_flies_the_same_bits_for_a_seed_and_others_for_another(folder):
    for log, seed in (("b.mcap", "5"), ("c.mcap", "5"), ("d.mcap", "6")):
        run(folder, *FLY, "--lockstep", "--seed", seed, "--log", log, "-q")
    b, c, d = (read(folder / name).truth.positions_site for name in ("b.mcap", "c.mcap", "d.mcap"))
    assert np.array_equal(b, c)
    assert b.shape != d.shape or not np.array_equal(b, d)


def test_a_signal_without_a_terminal_brings_it_home_and_ends_with_3(folder):
    with subprocess.Popen(
        [ORCHARD, *FLY, "--speed-factor", "4", "--log", "e.mcap", "-q"],
        cwd=folder, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    ) as flight:  # fmt: skip
        wait_for_route(folder / "e.mcap")
        flight.send_signal(signal.SIGTERM)
        _, said = flight.communicate(timeout=120)
    assert flight.returncode == 3, said
    assert "Traceback" not in said
    log = read(folder / "e.mcap")
    assert log.odometry.positions_site[-1, 2] < 0.5
    assert any(record.phase == "return" for record in log.safety)


def children(pid):
    return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def simulator_of(pid):
    return next(
        child for child in children(pid)
        if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()
    )  # fmt: skip


def wait_for_route(log, patience=120.0):
    end = time.monotonic() + patience
    while time.monotonic() < end:
        time.sleep(1.0)
        if log.exists() and log.stat().st_size > 100_000:
            with contextlib.suppress(InputError):
                if any(record.phase == "route" for record in read(log).safety):
                    return
    raise AssertionError("the route was not reached")


def test_a_killed_flight_leaves_a_log_that_reads_up_to_its_last_second(folder):
    with subprocess.Popen(
        [ORCHARD, *FLY, "--log", "f.mcap", "--json"],
        cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True,
    ) as flight:  # fmt: skip
        wait_for_route(folder / "f.mcap")
        os.kill(children(flight.pid)[0], signal.SIGKILL)
        document, said = flight.communicate(timeout=30)
    assert flight.returncode == 4
    assert json.loads(document)["log"] == "f.mcap"
    assert "killed" in said
    assert "take over" in said
    log = read(folder / "f.mcap")
    assert log.notes
    span = log.odometry.times[-1] - log.odometry.times[0]
    assert span > 3.0


def test_a_stalled_simulator_ends_no_flight_and_a_hung_flight_gives_the_terminal_back(folder):
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    with subprocess.Popen(
        [ORCHARD, *FLY, "--log", "g.mcap", "--json"],
        cwd=folder, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as flight:  # fmt: skip
        wait_for_route(folder / "g.mcap")
        (flying,) = children(flight.pid)
        assert termios.tcgetattr(theirs) != before  # keys are read one by one
        simulator = simulator_of(flying)
        os.kill(simulator, signal.SIGSTOP)
        time.sleep(1.5)
        os.kill(simulator, signal.SIGCONT)
        time.sleep(1.0)
        assert children(flight.pid) == [flying]
        os.kill(flying, signal.SIGSTOP)
        time.sleep(1.0)
        os.kill(flying, signal.SIGCONT)
        document, said = flight.communicate(timeout=30)
    assert flight.returncode == 4
    assert json.loads(document)["ended"] == "the flight program hung and was ended"
    assert "take over" in said
    assert termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)
