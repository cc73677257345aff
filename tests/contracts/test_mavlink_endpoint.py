"""The autopilot's end of the link, message by message: frames, masks, refusals, transfers."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import development as mav
from scipy.spatial.transform import Rotation

from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.world import SensorNoise, World
from orchard_cli.simulator.autopilot import Autopilot, Mode
from orchard_cli.simulator.mavlink import Endpoint
from orchard_cli.simulator.mavlink.earth import Earth
from orchard_cli.simulator.mavlink.streams import BUILDERS

QUIET = World("quiet", noise=SensorNoise(position=0, height=0, velocity=0, attitude=0))
HEADING = 0.7
NAN = math.nan


def origin(heading: float = HEADING) -> SiteOrigin:
    return SiteOrigin(46.2276, 11.1297, 250.0, HeightReference.AMSL, heading)


class Link:
    """A client's hand: packs what it says, so that only what survives the wire arrives."""

    def __init__(
        self, heading: float = HEADING, yaw_site: float = 0.3, seconds: float = 3.0
    ) -> None:
        self.autopilot = Autopilot(QUIET, (5.0, -3.0), yaw_site)
        self.endpoint = Endpoint(self.autopilot, origin(heading), 1.7e9)
        self._out = mav.MAVLink(None, srcSystem=1, srcComponent=195)
        self._back = mav.MAVLink(None, srcSystem=1, srcComponent=1)
        self._reader = mav.MAVLink(None)
        for _ in range(round(seconds * 100)):
            self.autopilot.step()

    def say(self, message: Any) -> list[Any]:
        (heard,) = self._reader.parse_buffer(message.pack(self._out))
        return [
            self._reader.parse_buffer(answer.pack(self._back))[0]
            for answer in self.endpoint.handle(heard)
        ]

    def command(self, number: int, *params: float) -> list[Any]:
        filled = (*params, *[NAN] * (7 - len(params)))
        return self.say(mav.MAVLink_command_long_message(1, 1, number, 0, *filled))

    def results(self, number: int, *params: float) -> list[int]:
        answers = self.command(number, *params)
        return [m.result for m in answers if m.get_type() == "COMMAND_ACK"]

    def message(self, number: int) -> Any:
        """One message, asked for."""
        return self.command(512, number)[0]

    def setpoint(self, mask: int, frame: int = 1, **fields: float) -> Any:
        names = ("x", "y", "z", "vx", "vy", "vz", "afx", "afy", "afz", "yaw", "yaw_rate")
        values = [fields.get(name, 0.0) for name in names]
        self.say(mav.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *values))
        return self.autopilot.inputs.wanted


# -- frames


@given(
    heading=st.floats(-7, 7),
    euler=st.tuples(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1)),
)
def test_attitude_is_turned_from_site_and_flu_to_ned_and_frd(
    heading: float, euler: tuple[float, float, float]
) -> None:
    body = Rotation.from_euler("ZYX", euler)
    ned_from_site = np.array(
        [
            [math.cos(heading), math.sin(heading), 0],
            [math.sin(heading), -math.cos(heading), 0],
            [0, 0, -1],
        ]
    )
    want = ned_from_site @ body.as_matrix() @ np.diag([1.0, -1.0, -1.0])
    got = Earth(origin(heading), np.zeros(3)).attitude(body.as_quat(scalar_first=True))
    assert Rotation.from_quat(got, scalar_first=True).as_matrix() == pytest.approx(want, abs=1e-9)


@given(
    heading=st.floats(-7, 7),
    place=st.tuples(st.floats(-300, 300), st.floats(-300, 300), st.floats(-5, 50)),
)
@settings(max_examples=40)
def test_places_agree_with_geodesy_within_centimetres(
    heading: float, place: tuple[float, float, float]
) -> None:
    start = np.array([12.0, -7.0, 0.5])
    earth = Earth(origin(heading), start)
    north, east, down = earth.local(np.array(place))
    latitude, longitude = earth.degrees(north, east)
    want = wgs84_from_site(origin(heading), np.array([place]))[0]
    assert (latitude - want[0]) * 111e3 == pytest.approx(0, abs=0.03)
    assert (longitude - want[1]) * 77e3 == pytest.approx(0, abs=0.03)
    assert earth.height - down == pytest.approx(want[2], abs=0.03)
    assert earth.site(north, east, down) == pytest.approx(place, abs=1e-9)
    assert earth.metres(latitude, longitude) == pytest.approx((north, east), abs=1e-6)


def test_a_nose_along_the_rows_has_the_rows_compass_heading() -> None:
    link = Link(yaw_site=0.0)
    assert link.message(30).yaw == pytest.approx(HEADING, abs=1e-3)
    assert link.message(33).hdg == pytest.approx(math.degrees(HEADING) * 100, abs=10)


def test_a_nose_turned_left_has_a_smaller_compass_heading() -> None:
    assert Link(yaw_site=0.3).message(30).yaw == pytest.approx(HEADING - 0.3, abs=1e-3)


# -- setpoints


@pytest.mark.parametrize(
    ("mask", "kept"),
    [
        (2552, "position"), (2503, "velocity"), (2496, "position velocity"),
        (2048, "position velocity acceleration"), (3135, "acceleration"),
    ],
)  # fmt: skip
def test_the_type_mask_leaves_what_it_ignores_uncontrolled(mask: int, kept: str) -> None:
    wanted = Link().setpoint(mask, x=1, y=2, z=-3, vx=1, vy=0, vz=0, afx=0, afy=1, afz=0)
    for name in ("position", "velocity", "acceleration"):
        assert np.isfinite(getattr(wanted, f"{name}_site")).all() == (name in kept)


def test_a_local_setpoint_arrives_in_the_site_frame() -> None:
    wanted = Link(heading=math.pi / 2).setpoint(
        2048, x=1.0, y=2.0, z=-3.0, vx=0.5, vy=0.25, vz=-0.1, afz=-1.0, yaw=math.pi / 2
    )
    # +x looks east, +y north; the local origin is the start.
    assert wanted.position_site == pytest.approx((5.0 + 2.0, -3.0 + 1.0, 3.0), abs=0.01)
    assert wanted.velocity_site == pytest.approx((0.25, 0.5, 0.1))
    assert wanted.acceleration_site == pytest.approx((0.0, 0.0, 1.0))
    assert wanted.yaw_site == pytest.approx(0.0, abs=1e-6)


def test_ignored_yaw_is_not_controlled_and_yaw_rate_turns_its_sign() -> None:
    wanted = Link().setpoint(2503 - 2048 + 1024, vx=1.0, yaw=1.0, yaw_rate=0.4)
    assert math.isnan(wanted.yaw_site)
    assert wanted.yaw_rate == pytest.approx(-0.4)


def test_a_body_velocity_goes_where_the_nose_points() -> None:
    wanted = Link(yaw_site=0.3).setpoint(2503, frame=8, vx=1.0, vy=0.5)
    ahead = np.array([math.cos(0.3), math.sin(0.3)])
    right = np.array([math.sin(0.3), -math.cos(0.3)])
    assert wanted.velocity_site[:2] == pytest.approx(ahead + 0.5 * right, abs=1e-3)
    assert np.isnan(wanted.position_site).all()


def test_a_height_alone_is_controlled_without_the_rest() -> None:
    wanted = Link().setpoint(2552 | 3, z=-3.0)
    assert np.isnan(wanted.position_site[:2]).all()
    assert wanted.position_site[2] == pytest.approx(3.0, abs=0.01)


@pytest.mark.parametrize(("mask", "frame"), [(0xFFF, 1), (2552, 7), (2552, 21)])
def test_a_setpoint_of_nothing_or_in_another_frame_is_no_setpoint(mask: int, frame: int) -> None:
    assert Link().setpoint(mask, frame=frame, x=1.0) is None


def test_what_is_meant_for_another_vehicle_is_not_heard() -> None:
    link = Link()
    for target in ((7, 1), (1, 42)):
        assert link.say(mav.MAVLink_command_long_message(*target, 400, 0, 1, *[NAN] * 6)) == []
    assert not link.autopilot.armed


# -- commands


def test_arming_is_refused_in_px4s_way_with_the_reason_in_words() -> None:
    link = Link(seconds=0.5)
    ack, text = link.command(400, 1.0)
    assert (ack.command, ack.result, ack.target_component) == (400, 1, 195)
    assert text.text == "Arming denied: system starting"


def test_a_mode_change_is_answered_twice_the_first_time_always_with_yes() -> None:
    link = Link()
    assert link.results(176, 129, 4, 3) == [0, 0]
    link.results(400, 1.0)
    assert link.results(176, 129, 6, 0) == [0, 1]  # armed, offboard without a stream
    assert link.results(176, 129, 9, 9) == [0, 2]
    assert link.autopilot.mode is Mode.HOLD


def test_no_answer_but_the_recorded_one_is_beyond_what_mavsdk_knows() -> None:
    link = Link()
    for command in range(600):
        if command not in (22, 400):
            assert all(result <= 6 for result in link.results(command, 0.0)), command
    reposition = mav.MAVLink_command_int_message(1, 1, 0, 192, 0, 0, NAN, 1, NAN, 0, 0, 0, 0.0)
    assert [m.result for m in link.say(reposition)] == [9]  # goto_location_unknown_ack.tlog


def test_home_is_denied_without_gps_and_told_with_it() -> None:
    link = Link()
    link.autopilot.set_gps_fix(False)
    assert link.results(512, 242) == [2]
    link.autopilot.set_gps_fix(True)
    for _ in range(300):
        link.autopilot.step()
    home, ack = link.command(512, 242)
    assert ack.result == 0
    assert (home.latitude / 1e7, home.longitude / 1e7) == pytest.approx(
        tuple(wgs84_from_site(origin(), np.array([[5.0, -3.0, 0.0]]))[0, :2]), abs=2e-7
    )


def test_every_known_message_can_be_asked_for_and_survives_the_wire() -> None:
    link = Link()
    for number in BUILDERS:
        answers = link.command(512, number)
        told = [m for m in answers if m.get_type() != "COMMAND_ACK"]
        assert answers[-1].result == (0 if told else 2)
        assert all(m.get_msgId() == number for m in told)


def test_intervals_are_kept_and_unknown_messages_refused() -> None:
    link = Link()
    assert link.results(511, 32, 20000.0) == [0]
    assert link.results(511, 140, 1e5) == [4]
    assert link.results(511, 30, -1.0) == [0]
    assert link.command(510, 32)[1].interval_us == 20000
    assert link.command(510, 30)[1].interval_us == -1
    counts = {30: 0, 32: 0, 0: 0}
    assert link.results(511, 0, 1e4) == [0]  # PX4 does not hurry its heartbeat
    for _ in range(500):
        link.autopilot.step()
        for m in link.endpoint.tick():
            counts[m.get_msgId()] = counts.get(m.get_msgId(), 0) + 1
    assert counts[30] == 0
    assert counts[32] == pytest.approx(250, abs=3)
    assert counts[0] == pytest.approx(5, abs=1)
    assert link.results(511, 30, 0.0) == [0]
    assert link.command(510, 30)[1].interval_us == 10000


# -- parameters


def read(link: Link, name: str, index: int = -1) -> Any:
    (answer,) = link.say(mav.MAVLink_param_request_read_message(1, 1, name.encode(), index))
    return answer


def write(link: Link, name: str, value: float, kind: int) -> Any:
    (answer,) = link.say(mav.MAVLink_param_set_message(1, 1, name.encode(), value, kind))
    return answer


def test_integers_travel_bytewise_and_floats_as_they_are() -> None:
    link = Link()
    as_float = struct.unpack("<f", struct.pack("<i", 5))[0]
    assert write(link, "COM_OBL_RC_ACT", as_float, 6).param_value == as_float
    assert link.autopilot.parameters["COM_OBL_RC_ACT"] == 5
    assert write(link, "MIS_TAKEOFF_ALT", 3.5, 9).param_value == 3.5
    assert read(link, "MIS_TAKEOFF_ALT").param_type == 9


def test_absent_and_mistyped_parameters_are_errors_and_change_nothing() -> None:
    link = Link()
    assert read(link, "NO_SUCH_PARAM").get_type() == "PARAM_ERROR"
    assert write(link, "NO_SUCH_PARAM", 1.0, 9).error == 1
    assert write(link, "MIS_TAKEOFF_ALT", 9.0, 6).get_type() == "PARAM_ERROR"
    assert link.autopilot.parameters["MIS_TAKEOFF_ALT"] == 2.5


def test_the_list_has_every_parameter_once_and_each_can_be_read_by_its_index() -> None:
    link = Link()
    rows = link.say(mav.MAVLink_param_request_list_message(1, 1))
    assert [row.param_index for row in rows] == list(range(rows[0].param_count))
    assert len({row.param_id for row in rows}) == len(rows) == len(link.autopilot.parameters)
    assert read(link, "", 7).param_id == rows[7].param_id


def test_a_changed_gain_is_flown_with() -> None:
    link = Link()
    before = link.autopilot.craft._cascade._gains.copy()
    write(link, "MPC_XY_P", 0.5, 9)
    link.autopilot.step()
    assert (link.autopilot.craft._cascade._gains != before).sum() == 2


# -- missions


def item(seq: int, x: int, y: int, z: float, frame: int = 3, command: int = 16) -> Any:
    return mav.MAVLink_mission_item_int_message(
        1, 1, seq, frame, command, int(seq == 0), 1, 0.0, 0.5, 0.0, NAN, x, y, z, 0
    )


def upload(link: Link, items: list[Any]) -> list[Any]:
    said = link.say(mav.MAVLink_mission_count_message(1, 1, len(items), 0))
    for wanted in items:
        assert said[0].get_type() == "MISSION_REQUEST_INT"
        assert said[0].seq == wanted.seq
        said = link.say(wanted)
    return said


def test_a_mission_goes_up_and_comes_down_the_same() -> None:
    link = Link()
    items = [item(k, 462276000 + 100 * k, 111297000 - 50 * k, 3.5 + k) for k in range(5)]
    (ack,) = upload(link, items)
    assert (ack.get_type(), ack.type) == ("MISSION_ACK", 0)
    (count,) = link.say(mav.MAVLink_mission_request_list_message(1, 1, 0))
    assert count.count == 5
    for sent in items:
        (got,) = link.say(mav.MAVLink_mission_request_int_message(1, 1, sent.seq, 0))
        assert (got.x, got.y, got.z, got.command) == (sent.x, sent.y, sent.z, sent.command)
        assert got.frame == 6  # PX4 hands out the integer frame
    first = link.autopilot.mission[0].target_site
    want = wgs84_from_site(origin(), first[None])[0]
    assert want[:2] == pytest.approx([46.2276, 11.1297], abs=2e-7)
    assert first[2] == pytest.approx(3.5, abs=0.01)


def test_an_item_that_does_not_come_is_asked_for_again_and_then_given_up() -> None:
    link = Link()
    link.say(mav.MAVLink_mission_count_message(1, 1, 2, 0))
    asked = 0
    for _ in range(400):
        link.autopilot.step()
        asked += sum(m.get_type() == "MISSION_REQUEST_INT" for m in link.endpoint.tick())
    assert asked == 9  # and the first, at once: ten in all
    assert link.autopilot.mission == ()


def test_items_out_of_order_or_of_another_kind_leave_the_old_mission() -> None:
    link = Link()
    upload(link, [item(0, 462276000, 111297000, 3.5)])
    link.say(mav.MAVLink_mission_count_message(1, 1, 2, 0))
    (again,) = link.say(item(1, 462276000, 111297000, 3.5))
    assert (again.get_type(), again.seq) == ("MISSION_REQUEST_INT", 0)
    (refused,) = link.say(item(0, 0, 0, 1.0, frame=8))
    assert refused.type == 2
    (fence,) = link.say(mav.MAVLink_mission_count_message(1, 1, 2, 1))
    assert fence.type == 3
    assert len(link.autopilot.mission) == 1


def test_clearing_leaves_no_mission() -> None:
    link = Link()
    upload(link, [item(0, 462276000, 111297000, 3.5)])
    (ack,) = link.say(mav.MAVLink_mission_clear_all_message(1, 1, 0))
    assert ack.type == 0
    assert link.autopilot.mission == ()
    assert link.message(42).total == 65535
