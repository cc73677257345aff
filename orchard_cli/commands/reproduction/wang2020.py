"""Wang et al. 2020: what RGB-D fusion measures of a tree (Fig. 9), and flights past one (Fig. 10).

The tree is the paper's: 3.20 m wide, 2.85 m high. Chosen here, as the paper gives no numbers: the
camera's height, the canopy's shape, and where the tree stands beside the path.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orchard_cli.analysis import Flight
from orchard_cli.commands.wiring import Choices
from orchard_cli.geometry.clearance import clearance
from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.mission import plan
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.mission import Mission, Provenance
from orchard_cli.model.obstacles import Category, Detection
from orchard_cli.model.vehicle import Pose
from orchard_cli.model.world import Tree, World
from orchard_cli.perception import DepthDetector
from orchard_cli.perception.distance import distance
from orchard_cli.perception.fusion import flat_extent, fuse, round_extent
from orchard_cli.perception.rays import Rays
from orchard_cli.simulator.scene import Scene
from orchard_cli.survey import parse

from .desk import Desk
from .rows import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE = "Wang et al. 2020: RGB-D and deep learning"
WIDTH, HEIGHT = 3.20, 2.85  # m
CANOPY = 2.3  # m from the canopy's bottom to its top
DISTANCES = np.arange(2.5, 9.01, 0.5)  # m from the camera to the trunk's centre
TRUSTED = (4.5, 8.0)  # m, "trustful" (§4.2)
EYE = 1.4  # m, the camera's height
LOOKS = 12  # at each distance
MEASURES = ("depth", "width", "height")
PAPER = {"4.5 to 8 m": (-0.53, -0.26, -0.24), "2.5 to 9 m": (-0.77, -0.67, -0.65)}

SURVEY = """
name = "wang2020"
[site]
latitude_deg = 40.0
longitude_deg = 116.35
height_m = 50.0
height_reference = "amsl"
heading_deg = 0.0
[flight]
height_m = {height}
height_above = "ground"
speed_m_s = 1.0
swath_m = 3.0
start_row = "first"
start_side = "near"
corner_cut_m = 0.5
[vehicle]
clearance_m = 0.85
airframe_radius_m = 0.35
[[row]]
gaps_m = [7.0, 7.0, 7.0, 7.0]
tree_height_m = 0.3
"""
AT = 14.0  # m along the row


@dataclass(frozen=True, slots=True)
class Case:
    """One of Fig. 10's flights."""

    name: str
    height: float  # m above the ground
    aside: float  # m of the tree to the left of the path

    @property
    def world(self) -> str:
        """As a world file."""
        return (
            f'name = "{self.name}"\n[[tree]]\nx_m = {AT}\ny_m = {self.aside}\n'
            f"height_m = {HEIGHT}\ncanopy_radius_m = {WIDTH / 2}\ncanopy_height_m = {CANOPY}\n"
        )


CASES = (Case("left", 1.4, -0.6), Case("right", 1.4, 0.6), Case("over", 3.2, 0.3))


def table_1(desk: Desk) -> list[Row]:
    """The network's accuracy: not to be had."""
    del desk
    why = "neither the paper's 3,700 pictures nor its weights are public; see docs/zones.md"
    return [Row("Table 1", "mean of five classes", "AP", 91.9, None, "%", why)]


def fig_9(desk: Desk) -> list[Row]:
    """Errors of depth, width and height against the distance."""
    desk.say(f"Fig. 9: {LOOKS} looks at each of {len(DISTANCES)} distances")
    errors = np.array([_looks(float(far), desk.seed) for far in DISTANCES])  # (n, looks, 6)
    means = errors.mean(axis=1)
    rows = []
    for far, found in zip(DISTANCES, means, strict=True):
        for column, ours in zip(MEASURES, found[:3], strict=True):
            rows.append(Row("Fig. 9", f"{far:.1f} m", f"{column} error", None, ours, "m"))
    inside = np.abs(DISTANCES - sum(TRUSTED) / 2) <= (TRUSTED[1] - TRUSTED[0]) / 2
    for name, which in (("4.5 to 8 m", inside), ("2.5 to 9 m", np.ones_like(inside))):
        for k, column in enumerate(MEASURES):
            worst = float(np.abs(errors[which][:, :, k]).max())
            note = f"worst look {worst:.2f}; eqs. 1-2 alone {means[which][:, 3 + k].mean():.2f}"
            ours = float(means[which][:, k].mean())
            rows.append(
                Row("Fig. 9", name, f"{column} error, mean", PAPER[name][k], ours, "m", note)
            )
    _draw_errors(desk.folder / "fig9.png", means)
    return rows


def fig_10(desk: Desk) -> list[Row]:
    """Left, right and leap, flown."""
    rows, flights = [], []
    for case in CASES:
        choices = Choices(system="zones", seed=desk.seed, camera=(424, 240))
        flight = desk.fly(f"fig10-{case.name}", _mission(case.height), case.world, choices)
        flights.append(flight)
        rows += _flown(case, flight)
    _draw_flights(desk.folder / "fig10.png", flights)
    return rows


TABLES = {"1": table_1, "fig9": fig_9, "fig10": fig_10}


def _looks(far: float, seed: int) -> Array:
    """Errors (LOOKS, 6) m: depth, width and height of a round tree, then as published."""
    tree = Tree(0.0, 0.0, height=HEIGHT, canopy_radius=WIDTH / 2, canopy_height=CANOPY)
    scene, camera, detector = (
        Scene(World("tree", trees=(tree,), seed=seed)),
        d455(),
        DepthDetector(),
    )
    turn, found = from_yaw_pitch_roll(0.0), []
    position = np.array([-far, 0.0, EYE]) - camera.position_body
    pose = Pose(0.0, position, turn)
    for number in range(LOOKS):
        frame = DepthFrame(0.0, scene.render(camera, position, turn, 0.0, number), camera)
        seen = detector.detect(frame, pose, None)
        trees = [one for one in seen if one.category in (Category.TREE, Category.BUILDING)]
        largest = max(trees or seen, key=_area)
        found.append(_errors(largest, frame, Rays.of(camera, pose), far))
    return np.array(found)


def _area(one: Detection) -> float:
    return (one.right - one.left) * (one.bottom - one.top)


def _errors(seen: Detection, frame: DepthFrame, rays: Rays, far: float) -> tuple[float, ...]:
    camera = frame.camera
    read = distance(seen, frame.depth_mm, camera.range_min, np.inf)
    if read is None:
        return (np.nan,) * 6
    tree, flat = fuse(seen, read, rays), flat_extent(seen, read.depth, camera)
    axis = round_extent(seen, read.depth, camera).depth
    return (
        axis - far, tree.width - WIDTH, tree.height - HEIGHT,
        read.depth - far, flat.width - WIDTH, flat.height - HEIGHT,
    )  # fmt: skip


def _mission(height: float) -> Mission:
    text = SURVEY.format(height=height)
    surveyed = parse(text.encode(), "wang2020.survey.toml")
    made = Provenance(surveyed.file, surveyed.sha256, "reproduce", "2020-06-01T00:00:00+00:00")
    return plan(surveyed.orchard, surveyed.wishes, made)


def _flown(case: Case, flight: Flight) -> list[Row]:
    path = _path(flight)
    beside = path[np.abs(path[:, 0] - AT) < WIDTH]
    aside = float(beside[np.abs(beside[:, 1]).argmax(), 1])
    up = float(beside[:, 2].max()) - case.height
    behind = path[(path[:, 0] > AT + 8.0) & (path[:, 0] < 2 * AT)]
    back = float(np.abs(behind[:, 1]).max()) if len(behind) else None
    nearest = None
    if flight.world is not None and len(beside):
        nearest = float(clearance(flight.world, beside).nearest.min())
    decided = {r.why.rsplit(": ", 1)[-1] for r in flight.log.planner if r.decision == "avoid"}
    way = f"decided: {', '.join(sorted(decided & {'left', 'right', 'over'})) or 'nothing'}"
    contacts = None if flight.log.contacts is None else float(len(flight.log.contacts))
    row = {"left": "left turn", "right": "right turn", "over": "leap"}[case.name]
    return [
        Row("Fig. 10", row, "offset to the left", None, aside, "m", way),
        Row("Fig. 10", row, "offset upwards", None, up, "m", way),
        Row("Fig. 10", row, "least clearance", None, nearest, "m", "0.85 m are kept"),
        Row("Fig. 10", row, "contacts", 0.0, contacts, ""),
        Row("Fig. 10", row, "offset 8 m behind", 0.0, back, "m", "estimator's error included"),
    ]


def _path(flight: Flight) -> Points:
    """Where it really was, (n, 3) m."""
    track = flight.log.truth or flight.log.odometry
    return track.positions_site


def _draw_errors(file: Path, means: Array) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.add_subplot()
    for k, name in enumerate(MEASURES):
        line = axes.plot(DISTANCES, means[:, k], marker="o", label=name)[0]
        published = PAPER["4.5 to 8 m"][k]
        axes.plot(TRUSTED, [published] * 2, "--", color=line.get_color(),
                  label=f"{name}, paper's mean")  # fmt: skip
    axes.axhline(0.0, color="grey", linewidth=0.8)
    axes.set(xlabel="distance to the trunk, m", ylabel="error, m", title="Wang 2020, Fig. 9")
    axes.legend(ncols=3, fontsize=8)
    figure.savefig(file, dpi=120)


def _draw_flights(file: Path, flights: list[Flight]) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 7), layout="constrained")
    for k, (case, flight) in enumerate(zip(CASES, flights, strict=True)):
        axes = figure.add_subplot(3, 1, k + 1)
        path = _path(flight)
        path = path[np.abs(path[:, 0] - AT) < 9.0]
        up = case.name == "over"
        axes.plot(path[:, 0], path[:, 2] if up else path[:, 1], label="flown")
        _draw_tree(axes, case, up)
        axes.set_aspect("equal")
        axes.set(title=case.name, ylabel="z, m" if up else "y (left), m")
    axes.set_xlabel("x along the path, m")
    figure.savefig(file, dpi=120)


def _draw_tree(axes: Axes, case: Case, up: bool) -> None:
    from matplotlib.patches import Ellipse

    middle = HEIGHT - CANOPY / 2 if up else case.aside
    canopy = Ellipse((AT, middle), WIDTH, CANOPY if up else WIDTH, color="tab:green", alpha=0.5)
    axes.add_patch(canopy)
    axes.axhline(case.height if up else 0.0, color="grey", linewidth=0.8, linestyle="--")
