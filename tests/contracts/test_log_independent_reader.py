"""Our log in the hands of others: mcap's own reader, and Foxglove's schemas."""

from __future__ import annotations

import json
import re

import foxglove.schemas
import made_flights as made
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from jsonschema import Draft202012Validator
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from orchard_cli.flightlog import McapRecorder
from orchard_cli.flightlog.messages import JSON_TOPICS
from orchard_cli.flightlog.scribe import FOXGLOVE_TOPICS


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "flight.mcap"
    recorder = McapRecorder(path, patient=True)
    for one in made.flight(made.planned_mission(), depth=True, attachments={"world.toml": b"#"}):
        recorder.write(one)
    recorder.close()
    return path


@pytest.fixture(scope="module")
def summary(log):
    with log.open("rb") as stream:
        return make_reader(stream, validate_crcs=True).get_summary()


def test_mcaps_own_reader_finds_a_whole_file_with_an_honest_index(log, summary):
    """What `mcap doctor` checks: counts, times, places and checksums agree with the messages."""
    with log.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        counts, times = {}, []
        for _, channel, message in reader.iter_messages():
            counts[channel.id] = counts.get(channel.id, 0) + 1
            times.append(message.log_time)
        names = [one.name for one in reader.iter_attachments()]
    told = summary.statistics
    assert counts == dict(told.channel_message_counts)
    assert len(times) == told.message_count
    assert times == sorted(times)
    assert (times[0], times[-1]) == (told.message_start_time, told.message_end_time)
    assert told.chunk_count == len(summary.chunk_indexes)
    assert set(names) == {one.name for one in summary.attachment_indexes}
    assert {one.name for one in summary.metadata_indexes} == {"orchard"}
    for index in summary.chunk_indexes:
        assert set(index.message_index_offsets) <= set(summary.channels)


def test_every_foxglove_topic_decodes_by_its_own_schema_and_is_foxgloves(log, summary):
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        if channel.topic in FOXGLOVE_TOPICS:
            assert channel.message_encoding == schema.encoding == "protobuf"
            kind = schema.name.removeprefix("foxglove.")
            ours = FileDescriptorSet.FromString(schema.data)
            theirs = FileDescriptorSet.FromString(getattr(foxglove.schemas, kind).get_schema().data)
            assert {f.name: f for f in ours.file} == {f.name: f for f in theirs.file}
    with log.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        decoded = reader.iter_decoded_messages(topics=list(FOXGLOVE_TOPICS))
        seen = {channel.topic for _, channel, _, message in decoded if message is not None}
    assert {"/tf", "/pose", "/gps", "/camera/depth", "/map/occupied", "/scene", "/log"} <= seen


def test_every_json_message_fits_the_schema_in_the_file(log, summary):
    checks = {
        channel.id: Draft202012Validator(json.loads(summary.schemas[channel.schema_id].data))
        for channel in summary.channels.values()
        if channel.topic in JSON_TOPICS
    }
    assert checks
    with log.open("rb") as stream:
        for number, (_, channel, message) in enumerate(make_reader(stream).iter_messages()):
            if channel.id in checks and number % 7 == 0:
                checks[channel.id].validate(json.loads(message.data))


def test_images_and_maps_share_no_chunk_with_what_metrics_are_made_of(summary):
    bulky = {"/camera/depth", "/camera/calibration", "/camera/colour", "/map/occupied"}
    topics = {key: channel.topic for key, channel in summary.channels.items()}
    kinds = [
        {topics[key] for key in index.message_index_offsets} for index in summary.chunk_indexes
    ]
    assert any(kind & bulky for kind in kinds)
    for kind in kinds:
        assert not kind & bulky or kind <= bulky | {"/tf"}


def test_topics_are_named_as_the_documentation_names_them(summary):
    from pathlib import Path

    page = (Path(__file__).parents[2] / "docs" / "log.md").read_text()
    told = set(re.findall(r"`(/[a-z_/]+)`", page))
    assert {channel.topic for channel in summary.channels.values()} <= told
