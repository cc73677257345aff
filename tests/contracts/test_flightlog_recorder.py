"""What the flight loop and outside tools may rely on of the recorder."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import made_flights as made
import numpy as np
import pytest
from mcap.reader import make_reader

from orchard_cli.errors import InputError
from orchard_cli.flightlog import McapRecorder, Rates
from orchard_cli.flightlog.sink import PENDING_LIMIT, Sink
from orchard_cli.model.records import LogLine, Severity

WELL_KNOWN = {
    "/tf": "foxglove.FrameTransforms",
    "/pose": "foxglove.PoseInFrame",
    "/gps": "foxglove.LocationFix",
    "/plan/waypoints": "foxglove.PosesInFrame",
    "/plan/spline": "foxglove.PosesInFrame",
    "/trajectory": "foxglove.PosesInFrame",
    "/guide_path": "foxglove.PosesInFrame",
    "/map/occupied": "foxglove.PointCloud",
    "/camera/depth": "foxglove.RawImage",
    "/camera/calibration": "foxglove.CameraCalibration",
    "/scene": "foxglove.SceneUpdate",
    "/log": "foxglove.Log",
}


def record(path: Path, records, **options) -> McapRecorder:
    recorder = McapRecorder(path, patient=True, **options)
    for one in records:
        recorder.write(one)
    recorder.close()
    return recorder


def summary_of(path: Path):
    with path.open("rb") as stream:
        return make_reader(stream).get_summary()


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("log") / "flight.mcap"
    attachments = {"mission.json": b"{}", "world.toml": b"name = 'w'\n"}
    recorder = record(path, made.flight(made.mission(), depth=True, attachments=attachments))
    assert recorder.losses == {}
    return path


def test_topics_carry_foxgloves_well_known_schemas(log):
    summary = summary_of(log)
    names = {c.topic: summary.schemas[c.schema_id] for c in summary.channels.values()}
    assert {topic: names[topic].name for topic in WELL_KNOWN} == WELL_KNOWN
    assert {names[topic].encoding for topic in WELL_KNOWN} == {"protobuf"}
    others = {topic for topic, kind in names.items() if kind.encoding == "jsonschema"}
    assert others == set(names) - set(WELL_KNOWN)


def test_log_is_indexed_compressed_and_chunked_every_half_second(log):
    summary = summary_of(log)
    spans = [c.message_end_time - c.message_start_time for c in summary.chunk_indexes]
    assert {c.compression for c in summary.chunk_indexes} == {"zstd"}
    assert len(spans) > 80
    assert max(spans) <= 1e9
    assert [a.name for a in summary.attachment_indexes] == ["mission.json", "world.toml"]


def test_log_time_is_flight_time_plus_the_utc_offset(log):
    with log.open("rb") as stream:
        _, _, first = next(make_reader(stream).iter_messages(topics=["/odometry"]))
    assert first.log_time == pytest.approx((100.0 + made.UTC_OFFSET) * 1e9, abs=1e3)
    assert b'"time":100.0' in first.data


def test_json_schemas_hold_only_what_foxglove_reads(log):
    """Foxglove wants an object at the root, no references, no null, no unions."""
    import json

    def check(node):
        assert not {"$ref", "anyOf", "oneOf"} & set(node)
        assert node["type"] in {"object", "array", "number", "integer", "string", "boolean"}
        for child in node["properties"].values() if node["type"] == "object" else ():
            check(child)
        if node["type"] == "array":
            check(node["items"])

    schemas = [s for s in summary_of(log).schemas.values() if s.encoding == "jsonschema"]
    assert schemas
    for schema in schemas:
        root = json.loads(schema.data)
        assert root["type"] == "object"
        check(root)


def test_depth_is_thinned_to_its_rate(tmp_path):
    path = tmp_path / "thin.mcap"
    record(path, made.flight(made.mission(), depth=True), rates=Rates(depth=1.0))
    summary = summary_of(path)
    ids = {c.topic: c.id for c in summary.channels.values()}
    seconds = made.mission().route_length / made.SPEED
    count = summary.statistics.channel_message_counts[ids["/camera/depth"]]
    assert count == pytest.approx(seconds, abs=2)


def test_same_records_give_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        record(tmp_path / name, made.flight(made.mission(1)))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_an_existing_log_is_not_overwritten_unasked(tmp_path):
    path = tmp_path / "flight.mcap"
    path.write_bytes(b"precious")
    with pytest.raises(InputError, match="exists already"):
        McapRecorder(path)
    assert path.read_bytes() == b"precious"


def test_a_place_that_cannot_be_written_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        McapRecorder(tmp_path / "no" / "such" / "folder.mcap")


def test_write_never_raises_and_counts_what_it_cannot_write(tmp_path):
    recorder = McapRecorder(tmp_path / "odd.mcap", patient=True)
    recorder.write(LogLine(0.0, Severity.INFO, "too early"))
    recorder.write(made.header(made.mission(1)))
    recorder.write(made.state(1.0, np.full(3, np.nan), np.zeros(3)))
    recorder.write(made.state(float("nan"), np.zeros(3), np.zeros(3)))
    recorder.write("not a record")
    recorder.write(made.state(2.0, np.zeros(3), np.zeros(3)))
    recorder.close()
    recorder.write(LogLine(3.0, Severity.INFO, "too late"))
    assert sum(recorder.losses.values()) == 5
    assert recorder.losses["after the end"] == 1


def test_a_bad_attachment_costs_itself_not_the_flight(tmp_path):
    path = tmp_path / "odd.mcap"
    attachments = {"mission.json": b"{}", "world.toml": object()}
    recorder = record(path, made.flight(made.mission(1), attachments=attachments))
    assert [why.split(":")[0] for why in recorder.losses] == ["RunHeader"]
    assert summary_of(path).statistics.message_count > 1000


def test_a_stalled_disk_costs_records_never_time(tmp_path, monkeypatch):
    """The disk hangs; the flight writes on and images go first, then the rest, all counted."""
    go_on = threading.Event()
    monkeypatch.setattr(Sink, "commit", lambda self: go_on.wait(60))
    recorder = McapRecorder(tmp_path / "stalled.mcap", rates=Rates(depth=30.0, cells=30.0))
    records = list(made.flight(made.mission(3), depth=True))
    for one in records:
        recorder.write(one)
    losses = dict(recorder.losses)
    go_on.set()
    recorder.close()
    assert losses["image or map: the writer is behind"] > 100
    assert losses["the queue is full"] > 100


def test_a_full_disk_keeps_a_true_beginning_and_recovers(tmp_path, monkeypatch):
    path = tmp_path / "full.mcap"
    sink = Sink(path, overwrite=False, sync=False)
    sink.write(b"a" * 10)
    sink.commit()
    real = os.write
    monkeypatch.setattr(os, "write", lambda file, data: real(file, bytes(data[:3])))
    sink.write(b"b" * 10)
    sink.commit()

    def full(file, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    sink.write(b"c" * 10)
    sink.commit()
    assert sink.failure == "No space left on device"
    monkeypatch.setattr(os, "write", real)
    sink.write(b"d")
    sink.close()
    assert sink.failure == ""
    assert path.read_bytes() == b"a" * 10 + b"b" * 10 + b"c" * 10 + b"d"


def test_a_disk_that_stays_full_ends_the_log_in_bounded_memory(tmp_path, monkeypatch):
    def full(file, data):
        raise OSError(28, "No space left on device")

    sink = Sink(tmp_path / "full.mcap", overwrite=False, sync=False)
    monkeypatch.setattr(os, "write", full)
    for _ in range(PENDING_LIMIT // 2**20 + 10):
        sink.write(b"x" * 2**20)
        sink.commit()
    assert sink.ended
    assert len(sink._pending) <= PENDING_LIMIT + 2**20


def test_what_comes_after_the_log_has_ended_is_counted(tmp_path, monkeypatch):
    monkeypatch.setattr("orchard_cli.flightlog.sink.PENDING_LIMIT", 1000)

    def full(file, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    recorder = record(tmp_path / "ended.mcap", made.flight(made.mission(1)))
    assert recorder.losses["VehicleState: the disk stayed full"] > 400


def test_images_are_given_up_first_and_the_log_says_so(tmp_path, monkeypatch):
    path = tmp_path / "failing.mcap"
    refuse = iter([False, True, True, True] + [False] * 1000)
    commit = Sink.commit

    def sometimes(self):
        if next(refuse):
            self.failure = "No space left on device"
        else:
            commit(self)

    monkeypatch.setattr(Sink, "commit", sometimes)
    recorder = record(path, made.flight(made.mission(1), depth=True))
    reasons = list(recorder.losses)
    assert reasons
    assert all("No space left" in why for why in reasons)
    assert {why.split(":")[0] for why in reasons} == {"DepthFrame", "OccupiedCells"}
    with path.open("rb") as stream:
        lines = [m.data for _, _, m in make_reader(stream).iter_messages(topics=["/log"])]
    assert any(b"the log has lost" in line for line in lines)


KILLED = """
import sys, time
sys.path.insert(0, {tests!r})
import made_flights as made
from orchard_cli.flightlog import McapRecorder
recorder = McapRecorder({path!r})
for one in made.flight(made.mission()):
    if getattr(one, "time", 0.0) > 130.0:
        break
    recorder.write(one)
while recorder._queue.qsize():
    time.sleep(0.05)
time.sleep(0.7)
print("ready", flush=True)
time.sleep(60)
"""


def test_a_killed_process_loses_at_most_the_last_second(tmp_path):
    from mcap.stream_reader import StreamReader

    path = tmp_path / "killed.mcap"
    code = KILLED.format(tests=str(Path(__file__).parents[1]), path=str(path))
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as child:
        assert child.stdout.readline().strip() == b"ready"
        child.send_signal(signal.SIGKILL)
    newest = 0
    with path.open("rb") as stream:
        try:
            for one in StreamReader(stream).records:
                newest = max(newest, getattr(one, "publish_time", 0))
        except Exception:  # the cut
            pass
    assert newest / 1e9 - made.UTC_OFFSET == pytest.approx(130.0, abs=1.0)
