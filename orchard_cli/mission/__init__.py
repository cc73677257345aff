"""Orchard + wishes -> Mission: the Π, its spline, its time law, its checks, its file."""

from .checks import check
from .files import dumps, load, load_unchecked, loads, schema
from .notes import notes
from .planner import measured_corner_cut, plan
from .saving import save
from .sorties import plan_from_home, plan_sorties
from .stops import with_stops
from .tasks import plan_tasks

__all__ = [
    "check",
    "dumps",
    "load",
    "load_unchecked",
    "loads",
    "measured_corner_cut",
    "notes",
    "plan",
    "plan_from_home",
    "plan_sorties",
    "plan_tasks",
    "save",
    "schema",
    "with_stops",
]
