"""All measurements, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from orchard_cli import mission as missions
from orchard_cli.errors import Fault, InputError
from orchard_cli.model.mission import Mission
from orchard_cli.model.world import World

from .. import wiring
from ..systems import SYSTEMS, needs_of
from . import cycle, frames, lockstep, machine, mapping, octomap, replanning, stream
from .document import SCHEMA, plain
from .pole_fields import FIELDS
from .samples import Samples, Spread, spreads

NO_PLANNER = "none"


@dataclass(frozen=True, slots=True)
class Plan:
    """What to measure, and how much of it."""

    mission: Path
    world: Path
    systems: tuple[str, ...]
    frames_log: Path | None
    octomap: bool
    seed: int
    frames: int = 240
    rounds: int = 3  # over the frames, for the map
    replans: int = 500  # in each kind of field
    simulated: float = 60.0  # s of lockstep
    streamed: float = 20.0  # s of setpoints
    paced: bool = True  # whether the cycle waits for the camera's rate

    def quick(self) -> Plan:
        """A few of everything: shows that the bench works, not how fast anything is."""
        return replace(
            self, frames=8, rounds=1, replans=10, simulated=4.0, streamed=1.0, paced=False
        )


def run(plan: Plan) -> dict[str, Any]:
    """Measure everything; the JSON document. Raises InputError for files and systems."""
    check(plan.systems)
    if plan.octomap:
        octomap.binding()
    mission = missions.load(plan.mission)
    world, _ = wiring.load_world(mission, plan.world)
    about, samples = machine.describe(), Samples()
    stretches = _frames(plan, mission, world, samples)
    make = SYSTEMS[plan.systems[0]]
    _maps(plan, stretches, _low(plan, mission, world), samples)
    replans = _replans(plan, mission, samples)
    cycle.measure(stretches, mission, make, plan.paced, samples)
    jitter = stream.jitter(stretches, mission, make, plan.streamed)
    pace = lockstep.measure(mission, world, plan.simulated, samples)
    about["load_1min_after"] = machine.describe()["load_1min"]
    document = {
        "schema": SCHEMA,
        "machine": about,
        "stages": spreads(samples.cpu_ms),
        "wall": spreads(samples.wall_ms),
        "replanning": replans,
        "setpoint_jitter": Spread.of(jitter),
        "lockstep": {"factor": pace.factor, "simulated_s": pace.simulated_s,
                     "cpu_s": pace.cpu_s, "wall_s": pace.wall_s},
        "settings": {"frames": sum(len(s.seen) for s in stretches), "replans": plan.replans,
                     "seed": plan.seed, "paced": plan.paced, "stages_of": plan.systems[0]},
    }  # fmt: skip
    found: dict[str, Any] = plain(document)
    return found


def planners() -> tuple[str, ...]:
    """The systems that plan on depth alone: the bench's fields have no other sensors."""
    return tuple(name for name in SYSTEMS if name != NO_PLANNER and not needs_of(name))


def check(systems: Sequence[str]) -> None:
    """Raises InputError for systems that do not exist or plan nothing."""
    mend = f"choose of {', '.join(planners())}"
    faults = [
        Fault("--system", f"no planning system {name!r}", mend)
        for name in systems
        if name not in planners()
    ]
    if faults:
        raise InputError(faults)


def _frames(
    plan: Plan, mission: Mission, world: World, samples: Samples
) -> tuple[frames.Stretch, ...]:
    recorded = None if plan.frames_log is None else frames.recorded(plan.frames_log)
    drawn = frames.drawn(mission, world, plan.frames, samples)  # in any case: it times `render`
    return drawn if recorded is None else recorded


def _low(plan: Plan, mission: Mission, world: World) -> tuple[frames.Stretch, ...]:
    """Fuller frames, between the rows; none beside a log's."""
    if plan.frames_log is not None:
        return ()
    return frames.drawn(mission, world, plan.frames // 2, Samples(), low=True)


def _maps(
    plan: Plan,
    stretches: tuple[frames.Stretch, ...],
    low: tuple[frames.Stretch, ...],
    samples: Samples,
) -> None:
    """The map as flown; and with the fullest frames there are, beside those of others."""
    fullest = low or stretches
    mapping.measure(stretches, "map_update", plan.rounds, samples)
    if low:
        mapping.measure(low, "map_update_low", plan.rounds, samples)
    mapping.measure(frames.thinned(fullest), "map_update_ego", plan.rounds, samples)
    mapping.measure_projection(fullest, samples)
    if plan.octomap:
        octomap.measure(fullest, plan.frames // 4, samples)


def _replans(plan: Plan, mission: Mission, samples: Samples) -> dict[str, Any]:
    """By system and field; the stages are the first system's."""
    limits, found = mission.limits, {}
    for number, name in enumerate(plan.systems):
        own = samples if number == 0 else Samples()
        tallies = replanning.measure(SYSTEMS[name], FIELDS, plan.replans, plan.seed, own)
        found[name] = {
            field: replanning.summary(tally, limits.clearance, limits.airframe_radius)
            for field, tally in tallies.items()
        }
    return found
