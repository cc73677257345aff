"""The whole onboard cycle: raw frame in, verdict out, with the log being written beside it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from orchard_cli.flight.lookout import COMMIT
from orchard_cli.flight.onboard import Onboard, OnboardJob
from orchard_cli.flight.ports import Avoidance, Recorder
from orchard_cli.flight.warmup import warm_up
from orchard_cli.flightlog import McapRecorder
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import NewTrajectory, RunHeader
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose
from orchard_cli.motion.situation import Avoid, Keep

from .frames import RATE, Seen, Stretch
from .samples import Samples

LATE = 0.01  # s from the exposure to the cycle's begin


def measure(
    stretches: Sequence[Stretch],
    mission: Mission,
    make: Callable[[], Avoidance],
    paced: bool,
    samples: Samples,
) -> None:
    """Time `cycle` over all frames: decoding, mapping, planning, and handing over to the log.

    `paced`: at the camera's rate, so that the log's thread works as in flight; else as fast as it
    goes. Compressing and writing are done by that thread; its share of a frame is `log_thread`.
    """
    with TemporaryDirectory() as folder:
        recorder = McapRecorder(Path(folder) / "bench.mcap")
        recorder.write(header(mission))
        try:
            for stretch in stretches:
                _replay(stretch, mission, make, paced, recorder, samples)
        finally:
            recorder.close()


def _replay(
    stretch: Stretch,
    mission: Mission,
    make: Callable[[], Avoidance],
    paced: bool,
    recorder: Recorder,
    samples: Samples,
) -> None:
    camera = stretch.seen[0].frame.camera
    warm_up(Onboard(OccupancyGrid(), make(), mission.limits), camera)
    onboard, active = Onboard(OccupancyGrid(), make(), mission.limits), stretch.route
    due = time.perf_counter()
    for seen in stretch.seen:
        due += 1 / RATE
        if paced:
            time.sleep(max(due - time.perf_counter(), 0.0))
        raw = seen.frame.depth_mm.tobytes()
        everything = time.process_time()
        with samples.timed("cycle"):
            active = _cycle(raw, seen, onboard, active, stretch.route, recorder)
        others = (time.process_time() - everything) * 1e3 - samples.cpu_ms["cycle"][-1]
        samples.add_cpu({"log_thread": max(others, 0.0)})


def _cycle(
    raw: bytes,
    seen: Seen,
    onboard: Onboard,
    active: Trajectory | None,
    reference: Trajectory | None,
    recorder: Recorder,
) -> Trajectory | None:
    """One frame: what the flight's loop and its worker do with it. The trajectory flown next."""
    camera, now = seen.frame.camera, seen.frame.time + LATE
    depth = np.frombuffer(raw, dtype="<u2").reshape(camera.height, camera.width)
    frame = DepthFrame(seen.frame.time, depth, camera)
    recorder.write(frame)
    pose = seen.vehicle.pose
    ahead = np.asarray(pose.position_site) + LATE * np.asarray(seen.vehicle.velocity_site)
    poses = (pose, Pose(now, ahead, pose.site_from_body))
    job = OnboardJob(now, now + COMMIT, frame, poses, seen.vehicle, active, reference)
    result = onboard.cycle(job)
    recorder.write(result.record)
    if result.occupied is not None:
        recorder.write(result.occupied)
    if isinstance(result.verdict, Keep):
        return active
    guide = result.verdict.guide_site if isinstance(result.verdict, Avoid) else np.empty((0, 3))
    recorder.write(NewTrajectory(now, result.verdict.trajectory, guide, result.verdict.why))
    return result.verdict.trajectory


def header(mission: Mission) -> RunHeader:
    """What the bench's logs begin with."""
    return RunHeader(
        run_id="bench",
        system="bench",
        tool_version="bench",
        vehicle="none",
        site=mission.orchard.name,
        simulated=True,
        seed=None,
        utc_offset=0.0,
        mission=mission,
    )
