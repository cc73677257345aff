"""What became of a flight, by where the vehicle really was. Its own estimate is not asked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from orchard_cli.geometry.clearance import clearance
from orchard_cli.geometry.shapes import ground_plane, walker_at
from orchard_cli.model.arrays import Array
from orchard_cli.model.mission import WAYPOINT_PASSED, Mission
from orchard_cli.model.site import Orchard
from orchard_cli.model.world import World

from .witness import Witness

AIRBORNE = 0.5  # m above the ground: lower it is taking off or landing
AT_REST = 0.3  # m/s, and
DOWN = 0.4  # m above the ground: the airframe's centre when it stands
MOVING = 0.3  # m/s: slower it stands, and whoever comes near comes by himself
DETOUR = 3.5  # m beside a waypoint: farther off, a part of the route was not flown
SAME_TREE = 0.05  # m between a surveyed trunk and the world's


class Outcome(Enum):
    """How a flight ended, from best to worst."""

    COMPLETED = "completed"  # the route to its end, and landed there
    SAFE = "safe end"  # landed whole elsewhere, or earlier
    UNSAFE = "unsafe end"  # not on the ground, armed, or for ever
    CONTACT = "contact"  # it touched something in the air


@dataclass(frozen=True, slots=True)
class Judgement:
    """One flight, judged. Distances are from the airframe's centre to a surface, while airborne."""

    outcome: Outcome
    why: str
    contact: str  # what was touched; empty: nothing
    nearest: Mapping[str, float]  # m to each kind of thing that the survey does not know
    trees: float  # m to the surveyed trees; inf: there are none
    person: float  # m, level, to a person while moving; inf: there was nobody
    error: float  # m, greatest level error of the estimate
    over_ideal: float | None  # s longer than the planned trajectory; None: not completed
    flight: float  # s from taking off to the end
    left_out: int  # waypoints passed at more than WAYPOINT_PASSED and the estimate's error
    holds: int
    replans: int

    @property
    def clearance(self) -> float:
        """m to the nearest thing that the survey does not know; inf: there is none."""
        return min(self.nearest.values(), default=math.inf)


def judge(mission: Mission, world: World, seen: Witness, as_planned: bool, why: str) -> Judgement:
    """`as_planned` and `why` are how the flight says that it ended."""
    truth = seen.truth[seen.truth[:, 0] <= seen.touched_at]
    up = truth[_heights(world, truth) > AIRBORNE]
    error = _error(seen)
    outcome = _outcome(mission, world, seen, as_planned, error)
    known = tuple(tree for tree in world.trees if _surveyed(mission.orchard, tree.x, tree.y))
    begun = [record.time for record in seen.phases if record.phase == "route"]
    ended = [record.time for record in seen.phases if record.phase == "landing"]
    completed = outcome is Outcome.COMPLETED and begun and ended
    span = mission.trajectory.end - mission.trajectory.start
    return Judgement(
        outcome=outcome,
        why=why,
        contact=_told(seen.contact, mission.orchard, world),
        nearest={kind: _least(part, up) for kind, part in unexpected(mission.orchard, world)},
        trees=_least(World("known", trees=known), up),
        person=_person(world, up),
        error=error,
        over_ideal=ended[-1] - begun[0] - span if completed else None,
        flight=float(np.ptp(up[:, 0])) if len(up) else 0.0,
        left_out=int((_missed(mission, truth) > WAYPOINT_PASSED + error).sum()),
        holds=sum(record.phase == "hold" for record in seen.phases),
        replans=seen.decisions.get("avoid", 0),
    )


def unexpected(orchard: Orchard, world: World) -> list[tuple[str, World]]:
    """A world with nothing but the things of one kind that the survey does not know, by kind."""
    tall = tuple(tree for tree in world.trees if not _surveyed(orchard, tree.x, tree.y))
    bare = replace(world, trees=(), poles=(), wires=(), boxes=(), people=())
    kinds = {
        "pole": replace(bare, poles=world.poles),
        "wire": replace(bare, wires=world.wires),
        "box": replace(bare, boxes=world.boxes),
        "tall tree": replace(bare, trees=tall),
        "person": replace(bare, people=world.people),
    }
    things = {"pole": world.poles, "wire": world.wires, "box": world.boxes, "tall tree": tall,
              "person": world.people}  # fmt: skip
    return [(kind, part) for kind, part in kinds.items() if things[kind]]


def _surveyed(orchard: Orchard, x: float, y: float) -> bool:
    trunks = np.concatenate([row.trunks_site for row in orchard.rows])
    return bool(np.hypot(*(trunks - (x, y)).T).min() < SAME_TREE)


def _told(contact: str, orchard: Orchard, world: World) -> str:
    """What was touched; of a tree, whether the survey knows it as it is."""
    kind, _, number = contact.partition(" ")
    if kind != "tree":
        return contact
    tree = world.trees[int(number) - 1]
    return contact if _surveyed(orchard, tree.x, tree.y) else f"tall {contact}"


def _least(world: World, up: Array) -> float:
    """m from the true path to the nearest of a world's things; inf for none."""
    if not len(up):
        return math.inf
    return float(clearance(world, up[:, 1:4], up[:, 0]).nearest.min())


def _person(world: World, up: Array) -> float:
    """m, level: how near it flew to somebody, at whatever height; standing does not count."""
    moving = up[np.hypot(up[:, 4], up[:, 5]) > MOVING]
    apart = [
        float(np.hypot(*(walker_at(one, moving[:, 0]) - moving[:, 1:3]).T).min()) - one.radius
        for one in world.people
        if len(moving)
    ]
    return min(apart, default=math.inf)


def _heights(world: World, truth: Array) -> Array:
    """(n,) m above the ground under a path."""
    a, b, c = ground_plane(world)
    return np.asarray(truth[:, 3] - (a * truth[:, 1] + b * truth[:, 2] + c))


def _error(seen: Witness) -> float:
    """m, greatest level distance between estimated and true place."""
    truth, believed = seen.truth, seen.believed
    if not len(truth) or not len(believed):
        return math.nan
    at = np.column_stack([np.interp(believed[:, 0], truth[:, 0], truth[:, k]) for k in (1, 2)])
    return float(np.hypot(*(believed[:, 1:3] - at).T).max())


def _missed(mission: Mission, truth: Array) -> Array:
    """(n,) m, level: how far beside each waypoint it passed."""
    apart = truth[:, None, 1:3] - mission.waypoints_site[:, :2]
    return np.asarray(np.linalg.norm(apart, axis=2).min(axis=0))


def _outcome(
    mission: Mission, world: World, seen: Witness, as_planned: bool, error: float
) -> Outcome:
    if seen.contact:
        return Outcome.CONTACT
    truth = seen.truth
    ended = bool(seen.phases) and seen.phases[-1].phase == "ended"
    if not len(truth) or not ended or seen.state is None or seen.state.armed:
        return Outcome.UNSAFE
    last = truth[-1:]
    if _heights(world, last)[0] > DOWN or np.linalg.norm(last[0, 4:7]) > AT_REST:
        return Outcome.UNSAFE
    passed = (_missed(mission, truth) < DETOUR + error).all()
    home = np.hypot(*(last[0, 1:3] - mission.landing_site)) < WAYPOINT_PASSED + error
    return Outcome.COMPLETED if as_planned and passed and home else Outcome.SAFE
