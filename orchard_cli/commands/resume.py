"""What `orchard plan --resume-at` and `--resume-from` leave to spray."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.mission.resume import Missed
    from orchard_cli.mission.route import Pass
    from orchard_cli.model.arrays import Points
    from orchard_cli.model.mission import Mission
    from orchard_cli.survey import Survey

_OTHERWISE = "give the options of the flight that was logged"
_NEAR = 0.05  # m: a line of the logged mission that is one of this plan's


def resumed(
    surveyed: Survey, at: str | None, logs: Sequence[Path], with_missed: bool
) -> tuple[list[Pass], list[str]]:
    """The passes that are left, and remarks on what was found. Raises InputError."""
    from orchard_cli.mission import resume, route

    flown = route.passes(surveyed.orchard, surveyed.wishes)
    if at is not None and logs:
        raise InputError(Fault("--resume-at", "stands beside --resume-from", "give one of them"))
    if at is not None:
        return _any(resume.rest(flown, resume.place(at, flown))), []
    lines: list[Points] = []
    behind: list[Pass] = []
    for path in logs:
        mission, sprayed = _logged(path)
        _demand_same(mission, surveyed.sha256, flown, path)
        planned = [route.Pass(segment.row or 0, p) for segment, p in mission.spray_lines]
        behind += resume.passed(planned, sprayed)
        lines += sprayed
    done = lines if with_missed else [one.points_site for one in behind]
    left = _any(resume.remaining(flown, done))
    x, y = left[0].points_site[0, :2]
    remarks = [f"resumes in row {left[0].row + 1} at ({x:.2f}, {y:.2f})"]
    return left, remarks + [_told(m, with_missed) for m in resume.missed(flown, behind, lines)]


def _any(left: list[Pass]) -> list[Pass]:
    if not left:
        raise InputError(Fault("--resume-at, --resume-from", "nothing is left to spray"))
    return left


def _told(missed: Missed, planned: bool) -> str:
    (x0, y0), (x1, y1) = missed.begin_site, missed.end_site
    where = f"row {missed.row + 1} from ({x0:.1f}, {y0:.1f}) to ({x1:.1f}, {y1:.1f})"
    done = "is planned again" if planned else "was not sprayed; --missed plans it again"
    return f"{where}, {missed.length:.1f} m, {done}"


def _logged(path: Path) -> tuple[Mission, list[Points]]:
    """The mission of a log, and the lines that were flown with the pump on."""
    from orchard_cli import flightlog
    from orchard_cli import mission as missions
    from orchard_cli.analysis.coverage import flown_lines

    log = flightlog.read(path, ("/odometry", "/spray"))
    data = log.attachments.get("mission.json")
    if data is None:
        raise InputError(Fault(str(path), "holds no mission", "give the log of an orchard flight"))
    return missions.loads(data, f"{path}: mission.json"), flown_lines(log)


def _demand_same(mission: Mission, sha256: str, flown: Sequence[Pass], path: Path) -> None:
    """The log is of this survey, flown along these lines. Raises InputError."""
    import shapely

    if mission.provenance.survey_sha256 != sha256:
        what = f"is of another survey, {mission.provenance.survey}"
        raise InputError(Fault(str(path), what, "give the survey as it was when it was flown"))
    lines = [shapely.LineString(one.points_site[:, :2]) for one in flown]
    for segment, points in mission.spray_lines:
        sprayed = shapely.LineString(points[:, :2])
        if not any(sprayed.within(line.buffer(_NEAR)) for line in lines):
            row = (segment.row or 0) + 1
            what = f"was flown along other lines, the first of them at row {row}"
            raise InputError(Fault(str(path), what, _OTHERWISE))
