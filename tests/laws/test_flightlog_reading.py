"""Laws of the log: what was recorded is read back; a broken file is read up to its damage."""

from __future__ import annotations

import os

import made_flights as made
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.errors import InputError
from orchard_cli.flightlog import NEEDED, McapRecorder, read
from orchard_cli.flightlog import records as decoding
from orchard_cli.flightlog.messages import Truth
from orchard_cli.model.flown import Contact
from orchard_cli.model.records import NewTrajectory, PlannerRecord, SprayRecord, TruthRecord
from orchard_cli.model.vehicle import Setpoint, VehicleState


@pytest.fixture(scope="module")
def records():
    attachments = {"mission.json": b"{}", "world.toml": b"name = 'w'\n"}
    return list(made.flight(made.mission(1), made.Bump(), 10.0, True, attachments))


@pytest.fixture(scope="module")
def log(records, tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "flight.mcap"
    recorder = McapRecorder(path, patient=True)
    for one in records:
        recorder.write(one)
    recorder.close()
    return path


@pytest.fixture(scope="module")
def whole(log):
    return read(log)


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("scratch") / "broken.mcap"


def test_what_was_recorded_is_read_back(records, whole):
    def of(kind):
        return [one for one in records if isinstance(one, kind)]

    states, truths, setpoints = of(VehicleState), of(TruthRecord), of(Setpoint)
    odometry, truth, commands = whole.odometry, whole.truth, whole.commands
    np.testing.assert_array_equal(odometry.times, [s.time for s in states])
    np.testing.assert_array_equal(odometry.positions_site, [s.position_site for s in states])
    np.testing.assert_array_equal(odometry.site_from_body, [s.site_from_body for s in states])
    np.testing.assert_array_equal(
        odometry.angular_velocities_body, [s.angular_velocity_body for s in states]
    )
    np.testing.assert_array_equal(truth.velocities_site, [t.velocity_site for t in truths])
    np.testing.assert_array_equal(
        commands.accelerations_site, [s.acceleration_site for s in setpoints]
    )
    assert list(whole.planner) == of(PlannerRecord)
    assert list(whole.spray) == of(SprayRecord)
    (new,) = of(NewTrajectory)
    (back,) = whole.trajectories
    np.testing.assert_array_equal(
        back.trajectory.control_points_site, new.trajectory.control_points_site
    )
    assert whole.attachments == {"mission.json": b"{}", "world.toml": b"name = 'w'\n"}
    assert whole.system == "guided"
    assert whole.lines[0].text == "made-up flight"
    assert whole.lines[0].time == pytest.approx(100.0, abs=1e-6)
    assert whole.notes == ()


def test_only_the_topics_asked_for_are_decoded(log, whole):
    some = read(log, topics=["/odometry"])
    assert len(some.odometry.times) == len(whole.odometry.times)
    assert (some.truth, some.planner, some.maps) == (None, (), ())
    assert whole.maps == ()
    (first, *_) = read(log, topics=[*NEEDED, "/map/occupied"]).maps
    np.testing.assert_allclose(first.centres_site, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    assert first.cell == pytest.approx(0.1)


def read_or_refused(path):
    """What is read, or None when it is refused: then in one line."""
    try:
        return read(path)
    except InputError as error:
        complaint = error
    assert len(complaint.faults) == 1
    assert "\n" not in str(complaint)
    return None


@settings(max_examples=80, deadline=None, derandomize=True)
@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_a_log_cut_at_any_byte_is_read_up_to_the_cut_and_says_so(share, log, whole, scratch):
    data = log.read_bytes()
    kept = int(share * len(data))
    scratch.write_bytes(data[:kept])
    cut = read_or_refused(scratch)
    if cut is not None:
        n = len(cut.odometry.times)
        assert "cut off" in cut.notes[0]
        np.testing.assert_array_equal(cut.odometry.times, whole.odometry.times[:n])
        positions = whole.odometry.positions_site[:n]
        np.testing.assert_array_equal(cut.odometry.positions_site, positions)
        assert cut.planner == whole.planner[: len(cut.planner)]
        flown = whole.odometry.times[-1] - whole.odometry.times[0]
        assert len(cut.odometry.times) / len(whole.odometry.times) > share - 1.5 / flown - 0.12


@settings(max_examples=80, deadline=None, derandomize=True)
@given(share=st.floats(0.0, 1.0, exclude_max=True), bits=st.integers(1, 255))
def test_a_flipped_byte_never_gives_a_wrong_flight_unsaid(share, bits, log, whole, scratch):
    data = bytearray(log.read_bytes())
    data[int(share * len(data))] ^= bits
    scratch.write_bytes(data)
    found = read_or_refused(scratch)
    if found is not None:
        kept = np.isin(whole.odometry.times, found.odometry.times)
        np.testing.assert_array_equal(found.odometry.times, whole.odometry.times[kept])
        positions = whole.odometry.positions_site[kept]
        np.testing.assert_array_equal(found.odometry.positions_site, positions)
        assert found.notes or (kept.all() and found.attachments == whole.attachments)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(junk=st.binary(max_size=300), honest=st.booleans())
def test_junk_is_refused_in_one_line(junk, honest, scratch):
    magic = b"\x89MCAP0\r\n" if honest else b""
    scratch.write_bytes(magic + junk)
    assert read_or_refused(scratch) is None


def test_a_length_that_lies_costs_no_memory(log, scratch):
    """A record that claims 500 MB in a file of 100 kB is a cut, not a MemoryError."""
    data = log.read_bytes()[:40000]
    scratch.write_bytes(data + b"\x06" + (500 * 2**20).to_bytes(8, "little") + b"x" * 100)
    assert any("cut off" in note or "damaged" in note for note in read(scratch).notes)


@pytest.mark.parametrize(
    ("name", "what"),
    [("missing.mcap", "cannot be read"), (".", "no regular file"), ("pipe", "no regular file")],
)
def test_a_log_that_is_no_file_is_refused_in_one_line(tmp_path, name, what):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match=what):
        read(tmp_path / name)


def test_samples_are_read_once_and_in_time_order(tmp_path):
    """The flight logs its newest telemetry each cycle, so samples repeat."""
    recorder = McapRecorder(tmp_path / "odd.mcap", patient=True)
    recorder.write(made.header(made.mission(1)))
    for time in (1.0, 1.0, 2.0, 1.5, 3.0):
        recorder.write(made.state(time, np.array([time, 0.0, 0.0]), np.zeros(3)))
    recorder.close()
    log = read(tmp_path / "odd.mcap")
    np.testing.assert_array_equal(log.odometry.times, [1.0, 2.0, 3.0])
    assert any("out of time order" in note for note in log.notes)


def test_what_was_touched_is_read_back_with_its_first_moment(tmp_path):
    recorder = McapRecorder(tmp_path / "crash.mcap", patient=True)
    recorder.write(made.header(made.mission(1)))
    level = np.array([1.0, 0.0, 0.0, 0.0])
    for time, contact in ((1.0, ""), (1.02, "pole 2"), (1.04, "pole 2")):
        recorder.write(TruthRecord(time, np.zeros(3), np.zeros(3), level, contact))
    recorder.close()
    assert read(tmp_path / "crash.mcap").contacts == (Contact(1.02, "pole 2"),)


def test_no_contact_and_nobody_who_looked_are_told_apart(whole):
    assert whole.contacts == ()
    nowhere = [0.0, 0.0, 0.0]
    old = Truth(time=1.0, position_m=nowhere, velocity_m_s=nowhere, site_from_body=[1.0, *nowhere])
    assert decoding.contacts([old]) is None
    assert decoding.contacts([]) is None


def test_an_mcap_of_somebody_else_is_refused(tmp_path):
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()
    with pytest.raises(InputError, match="holds no flight of orchard"):
        read(path)
