"""How evenly setpoints leave while mapping and planning run beside the loop, in real time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

from orchard_cli.flight.guidance import Guidance
from orchard_cli.flight.lookout import COMMIT
from orchard_cli.flight.onboard import Onboard, OnboardJob, OnboardResult
from orchard_cli.flight.ports import Avoidance
from orchard_cli.flight.runner import RATE as LOOP_RATE
from orchard_cli.flight.warmup import warm_up
from orchard_cli.flight.worker import ThreadWorker
from orchard_cli.flightlog import McapRecorder
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.mission import Mission

from .cycle import header
from .frames import RATE, Seen, Stretch

PERIOD = 1.0 / LOOP_RATE


def jitter(
    stretches: Sequence[Stretch],
    mission: Mission,
    make: Callable[[], Avoidance],
    seconds: float,
) -> list[float]:
    """Milliseconds by which each interval between two setpoints differs from 20 ms.

    The control loop's pace, its setpoint and its log, with full frames at the camera's rate in the
    onboard worker. Wall time: what else the machine does counts.
    """
    seen = [one for stretch in stretches for one in stretch.seen]
    onboard = Onboard(OccupancyGrid(), make(), mission.limits)
    warm_up(Onboard(OccupancyGrid(), make(), mission.limits), seen[0].frame.camera)
    worker: ThreadWorker[OnboardJob, OnboardResult] = ThreadWorker(onboard.cycle)
    try:
        with TemporaryDirectory() as folder:
            recorder = McapRecorder(Path(folder) / "bench.mcap")
            recorder.write(header(mission))
            try:
                left = list(_stream(seen, mission, worker, recorder, seconds))
            finally:
                recorder.close()
    finally:
        worker.close()
    return [abs(b - a - PERIOD) * 1e3 for a, b in pairwise(left)]


def _stream(
    seen: Sequence[Seen],
    mission: Mission,
    worker: ThreadWorker[OnboardJob, OnboardResult],
    recorder: McapRecorder,
    seconds: float,
) -> Iterator[float]:
    """The moments at which a setpoint was ready to be sent."""
    guidance = Guidance(mission.limits)
    guidance.join(mission.trajectory, 0.0)
    while guidance.pending:
        route = guidance.begin(0.0)
    began, given = time.perf_counter(), 0
    for tick in range(int(seconds * LOOP_RATE)):
        time.sleep(max(began + tick * PERIOD - time.perf_counter(), 0.0))
        worker.take(0.0)
        if worker.idle() and tick * PERIOD * RATE >= given:
            one = seen[given % len(seen)]
            now = one.frame.time
            poses = (one.vehicle.pose,)
            job = OnboardJob(now, now + COMMIT, one.frame, poses, one.vehicle, route, route)
            recorder.write(one.frame)
            worker.give(job, now)
            given += 1
        setpoint = guidance.setpoint(tick * PERIOD)
        yield time.perf_counter()
        recorder.write(setpoint)
