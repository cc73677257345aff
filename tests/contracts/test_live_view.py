"""What somebody who watches a running flight sees, through a WebSocket of another library."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Iterator

import made_flights as made
import pytest
from websockets.sync.client import ClientConnection, connect

from orchard_cli.commands.live_option import live_view
from orchard_cli.errors import InputError, LinkError
from orchard_cli.flightlog import LiveView, Tee, layout
from orchard_cli.flightlog.messages import JSON_TOPICS
from orchard_cli.flightlog.scribe import FOXGLOVE_TOPICS

MESSAGE = 1  # opcode of a message's binary frame in the protocol


@pytest.fixture
def view() -> Iterator[LiveView]:
    view = LiveView(port=0)
    yield view
    view.close()


def watch(view: LiveView) -> ClientConnection:
    return connect(view.address, subprotocols=["foxglove.sdk.v1"])


def advertised(client: ClientConnection) -> dict[str, int]:
    """Topic to channel number, of everything that is offered within half a second."""
    found: dict[str, int] = {}
    end = time.monotonic() + 0.5
    while (left := end - time.monotonic()) > 0:
        try:
            text = client.recv(timeout=left)
        except TimeoutError:
            break
        if isinstance(text, str) and (told := json.loads(text))["op"] == "advertise":
            found |= {channel["topic"]: channel["id"] for channel in told["channels"]}
    return found


def next_message(client: ClientConnection) -> bytes:
    while True:
        frame = client.recv(timeout=5.0)
        if isinstance(frame, bytes) and frame[0] == MESSAGE:
            return frame


def test_a_watcher_gets_the_logs_topics_and_their_messages(view: LiveView) -> None:
    flight = list(made.flight(made.mission()))
    view.write(flight[0])
    with watch(view) as client:
        topics = advertised(client)
        assert set(JSON_TOPICS) <= set(topics)
        client.send(json.dumps({"op": "subscribe", "subscriptions": [
            {"id": 7, "channelId": topics["/odometry"]}]}))  # fmt: skip
        time.sleep(0.2)
        for record in flight[1:50]:
            view.write(record)
        frame = next_message(client)
        number = struct.unpack_from("<I", frame, 1)[0]
        assert number in (7, topics["/odometry"])
        assert "position_m" in json.loads(frame[13:])


def test_who_connects_late_sees_the_plan_too(view: LiveView) -> None:
    flight = list(made.flight(made.mission()))
    for record in flight[:200]:
        view.write(record)
    time.sleep(0.3)
    with watch(view) as client:
        topics = advertised(client)
        client.send(json.dumps({"op": "subscribe", "subscriptions": [
            {"id": 1, "channelId": topics["/plan/spline"]}]}))  # fmt: skip
        time.sleep(0.2)
        for record in flight[200:1200]:
            view.write(record)
        assert len(next_message(client)) > 100


def test_writing_never_waits_and_never_raises(view: LiveView) -> None:
    flight = list(made.flight(made.mission()))
    for record in flight * 3:
        view.write(record)  # before its header's channels exist, and faster than it can serve


def test_a_port_that_is_taken_is_told(view: LiveView) -> None:
    port = int(view.address.rsplit(":", 1)[1])
    with pytest.raises(LinkError, match="name another port"):
        LiveView(port=port)


def test_it_listens_on_this_computer_only_unless_told_otherwise(view: LiveView) -> None:
    assert view.address.startswith("ws://127.0.0.1:")


@pytest.mark.parametrize("address", ["8765", "host:", ":1", "host:x", "host:99999"])
def test_an_address_that_is_none_is_refused(address: str) -> None:
    with pytest.raises(InputError, match="HOST:PORT"):
        live_view(address)


def test_the_layout_shows_topics_that_exist() -> None:
    text = layout().read_text()
    document = json.loads(text)
    shown = set(document["configById"]["3D!orchard"]["topics"])
    assert shown <= set(FOXGLOVE_TOPICS)
    placed = json.dumps(document["layout"])
    assert all(panel in placed for panel in document["configById"])


def test_a_tee_hands_on_to_all() -> None:
    class Kept:
        def __init__(self) -> None:
            self.records: list[object] = []
            self.losses = {"the disk is full": 3}

        def write(self, record: object) -> None:
            self.records.append(record)

        def close(self) -> None:
            self.records.append("closed")

    one, two = Kept(), Kept()
    tee = Tee(one, two)
    assert tee.losses == {"the disk is full": 3}
    tee.write(made.header(made.mission()))
    tee.close()
    assert len(one.records) == 2
    assert one.records == two.records
