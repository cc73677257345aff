"""The client's side of a flight that a real PX4 flew, played to ours: the answers must agree.

What is compared was recorded from PX4 main of March 2026 (tests/data/extract_px4.py).
"""

from __future__ import annotations

import json
import lzma
import math
import struct
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mav

from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.world import World
from orchard_cli.simulator.autopilot import TICK, Autopilot
from orchard_cli.simulator.mavlink import Endpoint

DATA = Path(__file__).parent.parent / "data"
BOOT = 5.0  # s that ours has been running when the recording begins
NOT_OURS = {  # pymavlink does not know the numbers; OpenDroneID concerns nobody here
    "UNKNOWN_8", "UNKNOWN_380", "UNKNOWN_411", "OPEN_DRONE_ID_LOCATION", "OPEN_DRONE_ID_SYSTEM",
}  # fmt: skip
ONCE = {"PARAM_VALUE", "PING"}  # bursts, and questions


@dataclass
class Heard:
    """What ours said, in the recording's own form."""

    acks: list[list[float]] = field(default_factory=list)
    modes: list[list[float]] = field(default_factory=list)
    landed: list[list[float]] = field(default_factory=list)
    params: dict[str, list[float]] = field(default_factory=dict)
    errors: list[list[Any]] = field(default_factory=list)
    counts: dict[str, Counter[str]] = field(default_factory=dict)
    misses: list[float] = field(default_factory=list)  # m, position against setpoint


@pytest.fixture(scope="module")
def recorded() -> dict[str, Any]:
    told: dict[str, Any] = json.loads((DATA / "px4_pi_20x6.autopilot.json").read_text())
    return told


def client_frames() -> list[tuple[float, bytes]]:
    raw = lzma.decompress((DATA / "px4_pi_20x6.client.xz").read_bytes())
    frames, at = [], 0
    while at < len(raw):
        time, size = struct.unpack_from("<dH", raw, at)
        frames.append((time, raw[at + 10 : at + 10 + size]))
        at += 10 + size
    return frames


@pytest.fixture(scope="module")
def heard(recorded: dict[str, Any]) -> Heard:
    autopilot = Autopilot(World("field", seed=1), (0.0, 0.0), 0.02)
    autopilot.parameters.set("COM_OBL_RC_ACT", 5)  # as the recorded vehicle had it
    origin = SiteOrigin(46.2276, 11.1297, 250.0, HeightReference.AMSL, 0.0)
    endpoint = Endpoint(autopilot, origin, 1.7e9)
    reader, wire = mav.MAVLink(None), mav.MAVLink(None)
    frames = client_frames()
    result = Heard(counts={name: Counter() for name in recorded["phases"]})
    setpoint = None
    while autopilot.time < BOOT + frames[-1][0] + 1:
        now = autopilot.time - BOOT
        said = endpoint.tick() if now > 0 else []
        while frames and frames[0][0] <= now:
            for message in reader.parse_buffer(frames.pop(0)[1]) or ():
                said += endpoint.handle(message)
                if message.get_type() == "SET_POSITION_TARGET_LOCAL_NED":
                    setpoint = (message.x, message.y, message.z)
        for message in said:
            (again,) = reader.parse_buffer(message.pack(wire))  # through the bytes and back
            note(result, recorded, now, again)
        if setpoint is not None and 24.0 < now < 83.0:
            told = endpoint.earth.local(autopilot.seen.position_site)
            result.misses.append(math.dist(told, setpoint))
        autopilot.step()
        if not frames:
            break
    for _ in range(round(4.0 / TICK)):
        for message in endpoint.tick():
            note(result, recorded, autopilot.time - BOOT, message)
        autopilot.step()
    return result


def note(result: Heard, recorded: dict[str, Any], now: float, m: Any) -> None:
    kind = m.get_type()
    for name, (first, last) in recorded["phases"].items():
        result.counts[name][kind] += first <= now < last
    if kind == "COMMAND_ACK":
        result.acks.append([now, m.command, m.result])
    elif kind == "PARAM_VALUE" and 6.6 < now < 10.6:
        result.params[m.param_id] = [m.param_value, m.param_type]
    elif kind == "PARAM_ERROR":
        result.errors.append([m.param_id, m.error])
    elif kind == "HEARTBEAT":
        changed(result.modes, now, [m.base_mode, m.custom_mode])
    elif kind == "EXTENDED_SYS_STATE":
        changed(result.landed, now, [m.landed_state])


def changed(rows: list[list[float]], now: float, value: list[float]) -> None:
    if not rows or rows[-1][1:] != value:
        rows.append([now, *value])


def test_every_command_gets_px4s_answer(heard: Heard, recorded: dict[str, Any]) -> None:
    assert [row[1:] for row in heard.acks] == [row[1:] for row in recorded["acks"]]
    for ours, theirs in zip(heard.acks, recorded["acks"], strict=True):
        assert abs(ours[0] - theirs[0]) < 0.05


def test_modes_follow_each_other_as_in_px4(heard: Heard, recorded: dict[str, Any]) -> None:
    assert [row[1:] for row in heard.modes] == [row[1:] for row in recorded["modes"]]
    for ours, theirs in zip(heard.modes[1:], recorded["modes"][1:], strict=True):
        assert ours[0] == pytest.approx(theirs[0], abs=2.5)  # of which the heartbeat's lag is 1 s


def test_landed_states_follow_each_other_as_in_px4(heard: Heard, recorded: dict[str, Any]) -> None:
    assert [row[1] for row in heard.landed] == [row[1] for row in recorded["landed"]]
    for ours, theirs in zip(heard.landed[1:], recorded["landed"][1:], strict=True):
        # In its simulator's noise PX4 stood for 3 s before it believed in the ground; ours for 1 s.
        assert ours[0] == pytest.approx(theirs[0], abs=3.0)


def test_parameters_have_px4s_values_and_types(heard: Heard, recorded: dict[str, Any]) -> None:
    assert heard.params == recorded["params"]
    assert heard.errors == recorded["errors"]


@pytest.mark.parametrize("phase", ["before", "offboard"])
def test_streams_have_px4s_rates(heard: Heard, recorded: dict[str, Any], phase: str) -> None:
    first, last = recorded["phases"][phase]
    for kind, rate in recorded["rates"][phase].items():
        if kind in NOT_OURS | ONCE:
            continue
        ours = heard.counts[phase][kind] / (last - first)
        # Slow ones are counted in whole messages.
        assert ours == pytest.approx(rate, rel=0.1, abs=1.5 / (last - first)), kind
    unknown = set(heard.counts[phase]) - set(recorded["rates"][phase]) - ONCE
    assert not {kind for kind in unknown if heard.counts[phase][kind]}


def test_it_tracks_the_recorded_setpoints_at_least_as_well_as_px4(heard: Heard) -> None:
    rms = math.sqrt(sum(miss * miss for miss in heard.misses) / len(heard.misses))
    assert rms < 0.376  # PX4 in SIH on the same setpoints (px4/flight_pi_20x6.log)
    assert max(heard.misses) < 1.102
