"""The real MAVSDK library flies the simulated autopilot over UDP, faster than real time."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import mavsdk
import pytest
from mavsdk.plugins.action import Action
from mavsdk.plugins.mission_raw import MissionItem, MissionRaw
from mavsdk.plugins.offboard import AccelerationNed, Offboard, PositionNedYaw, VelocityNedYaw
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry

from orchard_cli.errors import LinkError
from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.world import World
from orchard_cli.simulator import SimulatorProcess, SimulatorSettings

pytestmark = pytest.mark.flight

ORIGIN = SiteOrigin(46.2276, 11.1297, 250.0, HeightReference.AMSL, 0.0)
FACTOR = 8.0


def sleep(clock, seconds: float) -> None:
    """Simulated seconds; the clock itself looks up every 0.1 s of real time."""
    end = clock.now() + seconds
    while clock.now() < end:
        clock.sleep_until(end)


class Client:
    """MAVSDK's synchronous plugins on one system, and the simulator's clock."""

    def __init__(self, simulator: SimulatorProcess) -> None:
        mavsdk.log_subscribe(lambda *_: True)
        self.simulator, self.clock = simulator, simulator.clock
        kind = mavsdk.ComponentType.COMPANION_COMPUTER
        self.hub = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind))
        self.hub.add_any_connection(simulator.url)
        self.system = self.hub.first_autopilot(10.0)
        assert self.system is not None
        self.action, self.telemetry = Action(self.system), Telemetry(self.system)
        self.param, self.offboard = Param(self.system), Offboard(self.system)
        self.telemetry.set_rate_landed_state(10.0)
        self.telemetry.set_rate_position_velocity_ned(50.0)

    def until(self, true: Callable[[], bool], limit: float) -> float:
        """Simulated seconds until it is true; fails after `limit` of them."""
        start = self.clock.now()
        while not true():
            assert self.clock.now() - start < limit, "waited too long"
            sleep(self.clock, 0.02)
        return self.clock.now() - start

    def mode(self) -> FlightMode:
        return FlightMode(self.telemetry.flight_mode())

    def place(self) -> tuple[float, float, float]:
        p = self.telemetry.position_velocity_ned().position
        return p.north_m, p.east_m, p.down_m

    def aim(
        self, north: float, east: float, down: float, v: tuple[float, float], yaw: float
    ) -> None:
        self.offboard.set_position_velocity_acceleration_ned(
            PositionNedYaw(north, east, down, yaw), VelocityNedYaw(*v, 0.0, yaw),
            AccelerationNed(0.0, 0.0, 0.0),
        )  # fmt: skip

    def ready(self) -> bool:
        """MAVSDK's health_all_ok leaves out whether it can be armed."""
        return self.telemetry.health_all_ok() and self.telemetry.health().is_armable

    def lift(self, height: float = 3.5) -> None:
        self.until(self.ready, 15)
        self.action.set_takeoff_altitude(height)
        self.action.arm()
        self.action.takeoff()
        self.until(lambda: self.telemetry.armed() and self.mode() is FlightMode.HOLD, 20)
        self.until(lambda: self.place()[2] < -height + 0.2, 10)

    def go_offboard(self) -> None:
        north, east, down = self.place()
        self.aim(north, east, down, (0.0, 0.0), 0.0)
        self.offboard.start()
        self.until(lambda: self.mode() is FlightMode.OFFBOARD, 3)


def started(**options: Any) -> SimulatorProcess:
    settings = {"speed_factor": FACTOR, "port": 0, "autopilot_port": 0, "camera": None, **options}
    return SimulatorProcess.start(
        World("field", seed=2), ORIGIN, (0.0, 0.0), 0.0, SimulatorSettings(**settings)
    )


@pytest.fixture
def client() -> Iterator[Client]:
    with contextlib.ExitStack() as stack:
        simulator = started()
        stack.callback(simulator.close)
        one = Client(simulator)
        stack.callback(one.hub.destroy)
        yield one


def refused(call: Callable[[], Any]) -> str:
    with pytest.raises(mavsdk.MavsdkError) as raised:
        call()
    return str(raised.value.result.name)


def test_a_whole_flight_around_a_pi(client: Client) -> None:
    """Connect, parameters, arm, take off, 20 x 6 m at 1 m/s, hold, land, disarm."""
    client.until(client.ready, 15)
    assert client.telemetry.get_gps_global_origin().latitude_deg == pytest.approx(46.2276, abs=1e-6)
    client.param.set_param_int("COM_OBL_RC_ACT", 5)
    assert client.param.get_param_int("COM_OBL_RC_ACT") == 5
    assert len(client.param.get_all_params().float_params) > 50
    client.lift()
    client.go_offboard()
    n0, e0, d0 = client.place()
    legs = [(20.0, 0.0), (20.0, 6.0), (0.0, 6.0)]
    n, e, misses = 0.0, 0.0, []
    for to_n, to_e in legs:
        length = math.hypot(to_n - n, to_e - e)
        vn, ve = (to_n - n) / length, (to_e - e) / length
        begin = client.clock.now()
        while (done := client.clock.now() - begin) < length:
            at = (n0 + n + vn * done, e0 + e + ve * done)
            client.aim(*at, d0, (vn, ve), math.degrees(math.atan2(ve, vn)))
            sleep(client.clock, 0.05)
            here = client.place()
            misses.append(math.hypot(here[0] - at[0], here[1] - at[1]))
        n, e = to_n, to_e
    rms = math.sqrt(sum(m * m for m in misses) / len(misses))
    # PX4 in SIH with stepped velocities: 0.35 rms, 0.77 max (px4/README §3).
    assert rms < 0.5
    assert max(misses) < 1.2
    client.action.hold()
    client.until(lambda: client.mode() is FlightMode.HOLD, 3)
    client.action.land()
    client.until(lambda: LandedState(client.telemetry.landed_state()) is LandedState.ON_GROUND, 20)
    assert 0.5 < client.until(lambda: not client.telemetry.armed(), 5) < 3.5
    truth = client.simulator.truth.take()
    assert truth[-1].position_site[2] == pytest.approx(0.0, abs=0.02)
    assert truth[-1].position_site[:2] == pytest.approx((0.0, -6.0), abs=1.0)  # y is to the left


def test_refusals_are_px4s(client: Client) -> None:
    client.until(client.ready, 15)
    assert refused(lambda: client.param.get_param_int("NO_SUCH_PARAM")) == "DOES_NOT_EXIST"
    assert refused(lambda: client.param.get_param_int("COM_OF_LOSS_T")) == "WRONG_TYPE"
    assert refused(lambda: client.telemetry.set_rate_raw_imu(10.0)) == "UNKNOWN"
    assert refused(client.offboard.start) == "NO_SETPOINT_SET"
    client.lift()
    assert refused(client.action.disarm) == "COMMAND_DENIED"
    client.action.land()
    client.until(lambda: not client.telemetry.armed(), 25)


def test_a_stream_that_ends_makes_it_return_after_one_second(client: Client) -> None:
    client.lift()
    client.go_offboard()
    sleep(client.clock, 2)
    client.offboard.destroy()
    passed = client.until(lambda: client.mode() is FlightMode.RETURN_TO_LAUNCH, 4)
    assert 0.9 < passed < 2.2  # COM_OF_LOSS_T and the heartbeat's lag


class Cut:
    """Stands between client and simulator and can be cut, as a radio link can."""

    def __init__(self, client_port: int) -> None:
        self._to = ("127.0.0.1", client_port)
        self._air, self._ground = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in "ab")
        for end in (self._air, self._ground):
            end.bind(("127.0.0.1", 0))
            end.setblocking(False)
        self.port = int(self._air.getsockname()[1])
        self.whole, self._ended = threading.Event(), threading.Event()
        self.whole.set()
        self._vehicle: Any = None
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def _carry(self) -> None:
        while not self._ended.is_set():
            for come in (self._air, self._ground):
                while True:
                    try:
                        data, sender = come.recvfrom(65535)
                    except BlockingIOError:
                        break
                    if come is self._air:
                        self._vehicle = sender
                    if self.whole.is_set():
                        go = self._ground if come is self._air else self._air
                        go.sendto(data, self._to if go is self._ground else self._vehicle)
            time.sleep(0.001)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._air.close()
        self._ground.close()


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_a_link_cut_of_three_seconds_ends_in_offboard_again_as_in_px4() -> None:
    """offboard_link_cut_3s.tlog: back in OFFBOARD by itself, obeying the old setpoint."""
    client_port = free_port()
    with contextlib.ExitStack() as stack:
        cut = Cut(client_port)
        stack.callback(cut.close)
        simulator = started(port=cut.port, speed_factor=4.0)
        stack.callback(simulator.close)
        simulator.url = f"udpin://127.0.0.1:{client_port}"
        client = Client(simulator)
        stack.callback(client.hub.destroy)
        client.lift()
        client.go_offboard()
        north, east, down = client.place()
        client.aim(north + 6.0, east, down, (0.0, 0.0), 0.0)
        sleep(client.clock, 8)
        simulator.truth.take()
        cut.whole.clear()
        sleep(client.clock, 2.9)
        cut.whole.set()
        sleep(client.clock, 8)
        assert client.mode() is FlightMode.OFFBOARD
        track = [record.position_site[2] for record in simulator.truth.take()]
        assert max(track) > -down + 0.5  # it had begun its return, with the climb
        assert track[-1] == pytest.approx(-down, abs=0.3)  # and came back by itself


def test_a_mission_goes_up_comes_down_and_is_flown(client: Client) -> None:
    client.until(client.ready, 15)
    mission = MissionRaw(client.system)
    nan = math.nan
    items = [
        MissionItem(0, 6, 22, 1, 1, 0.0, 0.0, 0.0, nan, 462276000, 111297000, 3.0, 0),
        MissionItem(1, 6, 16, 0, 1, 0.0, 0.5, 0.0, nan, 462276500, 111297000, 3.0, 0),
        MissionItem(2, 6, 16, 0, 1, 0.0, 0.5, 0.0, nan, 462276500, 111297600, 3.0, 0),
    ]
    mission.upload_mission(items)
    down = mission.download_mission()
    assert [(i.seq, i.command, i.x, i.y, i.z) for i in down] == [
        (i.seq, i.command, i.x, i.y, i.z) for i in items
    ]
    client.action.arm()
    mission.start_mission()
    client.until(lambda: mission.mission_progress().current >= 2, 40)
    sleep(client.clock, 8)
    north, east, _ = client.place()
    assert (north, east) == pytest.approx((5.56, 4.63), abs=0.7)
    mission.pause_mission()
    client.until(lambda: client.mode() is FlightMode.HOLD, 3)
    mission.clear_mission()
    assert mission.download_mission() == []


def test_it_keeps_its_factor_and_shows_frames_while_it_renders() -> None:
    simulator = started(camera=(424, 240), frame_rate=15.0, speed_factor=3.0)
    try:
        assert simulator.camera is not None
        stamps, start = [], simulator.clock.now()
        while simulator.clock.now() < start + 9.0:
            sleep(simulator.clock, 0.03)
            frame = simulator.camera.latest()
            if frame is not None:
                assert frame.depth_mm.shape == (240, 424)
                assert frame.time <= simulator.clock.now()
                stamps.append(frame.time)
        assert len(stamps) > 60
        assert all(later > earlier for earlier, later in pairwise(stamps))
        times = [record.time for record in simulator.truth.take()]
        assert all(0.0199 < b - a < 0.0201 for a, b in pairwise(times))
        assert 0.5 < simulator.achieved_factor <= 3.05
    finally:
        simulator.close()


def test_closing_ends_the_process_and_the_clock_says_so() -> None:
    simulator = started()
    pid = simulator.pid
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)  # even one that does not listen
    began = time.monotonic()
    simulator.close()
    assert time.monotonic() - began < 5
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    with pytest.raises(LinkError):
        sleep(simulator.clock, 5.0)
    simulator.close()


def test_it_ends_when_its_starter_is_killed() -> None:
    script = (
        "import sys, time\n"
        "sys.path.insert(0, 'tests/flights')\n"
        "from test_sim_over_mavsdk import started\n"
        "if __name__ == '__main__':\n"
        "    print(started().pid, flush=True)\n"
        "    time.sleep(60)\n"
    )
    starter = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert starter.stdout is not None
    pid = int(starter.stdout.readline())
    starter.kill()
    starter.wait()
    for _ in range(100):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    os.kill(pid, signal.SIGKILL)
    pytest.fail("the simulator outlived the program that started it")


def test_a_port_in_use_is_said_and_nothing_is_left_running() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        with pytest.raises(LinkError, match="in use"):
            started(autopilot_port=other.getsockname()[1])
