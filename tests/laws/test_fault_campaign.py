"""What the fault campaign calls right and wrong, and that its instruments do what they say."""

import multiprocessing
import socket
import time
from dataclasses import replace

import numpy as np
import pytest
from pymavlink.dialects.v20 import development as mav

from orchard_cli.campaign.faults import FAULTS, PHASES, Observed, judge_fault
from orchard_cli.commands.campaigns.faults import chosen, document, record, timeline
from orchard_cli.commands.campaigns.striking import EVIDENCE, STRIKES
from orchard_cli.commands.campaigns.troubles import LatePoses, Trouble, TroubledWorker, Troubles
from orchard_cli.errors import InputError
from orchard_cli.flight.worker import InlineWorker
from orchard_cli.model.vehicle import Pose
from orchard_cli.simulator.mavlink.relay import HOST, Relay

INJECTED = 10.0


def seen(stops=1.0, lands=True, end=(9.0, 0.0), mode="offboard", **changes):
    """1 m/s along x, a fault at 10 s, standing `stops` s later, down at 30 s."""
    times = np.arange(0.0, 40.0, 0.05)
    speed = np.where((times >= INJECTED + stops) & (times < INJECTED + stops + 4.0), 0.0, 1.0)
    down = lands & (times > 30.0)
    places = np.column_stack([np.cumsum(speed) * 0.05, 0 * times, np.where(down, 0.1, 3.0)])
    places[down] = (*end, 0.1)
    speed[down] = 0.0
    told = Observed(
        times=times,
        positions_site=places,
        velocities_site=np.column_stack([speed, 0 * times, 0 * times]),
        distances=np.full(len(times), 2.0),
        modes=(mode,) * len(times),
        armed=tuple((~down).tolist()),
        setpoints_at=times - 0.02,
        injected=INJECTED,
        evidence="seen",
        contact="",
        asked=(),
        ended=39.0,
        crashed="",
        log_until=39.5,
        log_fault="",
        takeoff_site=np.array([-4.0, 0.0]),
        landing_site=np.array([9.0, 0.0]),
    )
    return replace(told, **changes)


def right(fault, observed, phase="route"):
    return judge_fault(FAULTS[fault], phase, observed)[1]


def test_every_fault_can_be_made_to_happen_and_be_seen():
    assert set(FAULTS) == set(STRIKES) == set(EVIDENCE)
    assert all(set(fault.phases) <= set(PHASES) for fault in FAULTS.values())


def test_standing_in_time_is_right_and_flying_on_is_wrong():
    assert right("frames blank", seen(stops=2.0))
    assert not right("frames blank", seen(stops=6.0))
    assert not right("frames blank", seen(stops=100.0))


def test_nothing_is_right_that_did_not_happen_or_touched_something_or_lost_its_log():
    assert not right("frames blank", seen(evidence=""))
    assert not right("frames blank", seen(injected=None))
    assert not right("frames blank", seen(contact="pole 1"))
    assert not right("frames blank", seen(log_until=37.0))
    assert not right("frames blank", seen(log_until=None, log_fault="is no log"))
    assert not right("frames blank", seen(crashed="failed"))


def test_a_full_disk_may_lose_what_comes_after_it():
    assert right("disk full", seen(log_until=9.5))
    assert not right("disk full", seen(log_until=8.0))


def test_home_is_the_take_off_place_and_the_end_is_not():
    assert right("SIGTERM", seen(end=(-4.0, 0.5)))
    assert not right("SIGTERM", seen())
    assert right("disk full", seen())
    assert not right("disk full", seen(end=(-4.0, 0.5)))


def test_what_stays_in_the_air_is_safe_only_in_the_autopilots_hold():
    hovering = {"lands": False, "velocities_site": np.zeros((800, 3))}
    assert right("SIGKILL", seen(mode="hold", **hovering))
    assert not right("SIGKILL", seen(mode="offboard", **hovering))


def test_after_the_pilot_took_over_nothing_is_sent_or_asked():
    observed = seen()
    quiet = np.minimum(observed.times, INJECTED + 1.0)
    assert right("pilot takes over", replace(observed, setpoints_at=quiet))
    assert not right("pilot takes over", observed)
    asked = replace(observed, setpoints_at=quiet, asked=((INJECTED + 3.0, "mode"),))
    assert not right("pilot takes over", asked)


def test_cells_are_chosen_by_name_and_unknown_names_are_told():
    assert len(chosen("SIGKILL", None)) == len(FAULTS["SIGKILL"].phases)
    assert [fault.name for fault, _ in chosen("SIGKILL", "route")] == ["SIGKILL"]
    for fault, phase in (("nonsense", None), (None, "nonsense"), ("tank empty", "landing")):
        with pytest.raises(InputError):
            chosen(fault, phase)


def test_the_document_has_what_scripts_ask_for_and_the_timeline_what_people_do():
    one = record(FAULTS["frames blank"], "route", seen())
    assert {"fault", "phase", "happened", "outcome", "ok"} <= set(one)
    assert document([one])["ok"]
    rows = timeline(seen())
    assert rows[0][0] == "-1.00"
    assert float(rows[8][2]) == 0.0


@pytest.fixture
def troubles():
    return Troubles(multiprocessing.get_context("spawn"))


def test_a_troubled_planner_is_late_throws_or_hangs_and_then_is_well_again(troubles):
    worker = TroubledWorker(InlineWorker(lambda job: job, latency=0.0), troubles)
    worker.give("a", 0.0)
    assert worker.take(0.1) == "a"
    troubles.begin(Trouble.PLANNER_LATE, 5.0)
    worker.give("b", 1.0)
    assert worker.take(1.1) is None
    assert not worker.idle()
    assert worker.take(2.7) == "b"
    troubles.begin(Trouble.PLANNER_THROWS, 5.0)
    worker.give("c", 3.0)
    assert isinstance(worker.take(3.1), RuntimeError)
    troubles.begin(Trouble.PLANNER_HANGS, 5.0)
    worker.give("d", 4.0)
    assert worker.take(4.1) is None
    assert worker.take(4.9) is None
    assert worker.take(5.1) == "d"
    assert worker.idle()
    assert troubles.hits == 3


def test_late_poses_come_later_and_only_while_there_is_trouble(troubles):
    class Vehicle:
        def poses(self, since):
            return tuple(Pose(t, np.zeros(3), np.array([1.0, 0, 0, 0])) for t in (1.0, 3.0))

    now = [3.1]
    vehicle = LatePoses(Vehicle(), troubles, lambda: now[0])
    assert len(vehicle.poses(0.0)) == 2
    troubles.begin(Trouble.POSES_LATE, 4.0)
    assert [pose.time for pose in vehicle.poses(0.0)] == [1.0]
    now[0] = 4.1
    assert len(vehicle.poses(0.0)) == 2


def test_a_relay_carries_listens_and_can_be_cut():
    client, vehicle = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    client.bind((HOST, 0))
    client.settimeout(2.0)
    vehicle.settimeout(2.0)
    relay = Relay(lambda: 7.0, client.getsockname()[1])
    speak = mav.MAVLink(None, srcSystem=1, srcComponent=1)
    try:
        beat = mav.MAVLink_heartbeat_message(2, 12, 128, 6 << 16, 4, 3).pack(speak)
        vehicle.sendto(beat, (HOST, relay.port))
        data, ground = client.recvfrom(2000)
        assert data == beat
        assert (relay.heard.mode, relay.heard.armed) == ("offboard", True)
        setpoint = mav.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, 1, 0, *([0.0] * 9), 0.0, 0.0
        ).pack(speak)
        client.sendto(setpoint, ground)
        assert vehicle.recv(2000) == setpoint
        assert relay.heard.setpoint_at == 7.0
        relay.whole.clear()
        vehicle.sendto(beat, (HOST, relay.port))
        client.sendto(setpoint, ground)
        time.sleep(0.2)
        for end in (client, vehicle):
            end.setblocking(False)
            with pytest.raises(BlockingIOError):
                end.recv(2000)
        relay.kill_motors()
        vehicle.settimeout(2.0)
        (order,) = mav.MAVLink(None).parse_buffer(vehicle.recv(2000))
        assert (order.command, order.param1, order.param2) == (400, 0.0, 21196.0)
    finally:
        relay.close()
        client.close()
        vehicle.close()
