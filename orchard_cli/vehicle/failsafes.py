"""The autopilot's own failsafe parameters, judged before arming.

They rule when this program is gone. PX4's stock values return home by first climbing to 30 m:
fatal under nets, wires and branches.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Rule:
    """What one parameter should be."""

    name: str
    is_float: bool
    wanted: float
    safe: Callable[[float], bool]
    why: str


@dataclass(frozen=True, slots=True)
class Finding:
    """One parameter that is not safe here. `value` is None when the autopilot has no such one."""

    name: str
    value: float | None
    wanted: float
    is_float: bool
    why: str

    def __str__(self) -> str:
        have = "missing" if self.value is None else f"{self.value:g}"
        return f"{self.name} is {have}, should be {self.wanted:g}: {self.why}"


def rules(flight_height: float) -> tuple[Rule, ...]:
    """Rules for a mission flown at `flight_height` m above its ground."""
    return (
        Rule("COM_OF_LOSS_T", True, 1.0, lambda v: 0 < v <= 1.0,
             "a lost setpoint stream must be noticed within 1 s"),
        Rule("COM_OBL_RC_ACT", False, 5, lambda v: v in (4, 5),
             "when the stream is lost the vehicle must hold (5) or land (4), not fly home"),
        Rule("RTL_RETURN_ALT", True, round(flight_height, 1), lambda v: v <= flight_height + 0.5,
             "a return first climbs to this height, through branches, nets and wires"),
        Rule("NAV_DLL_ACT", False, 0, lambda v: v in (0, 1, 3),
             "a lost data link must not start a return"),
    )  # fmt: skip


def judge(values: Mapping[str, float | None], flight_height: float) -> tuple[Finding, ...]:
    """Every parameter that is missing or unsafe for a mission at `flight_height` m."""
    return tuple(
        Finding(rule.name, value, rule.wanted, rule.is_float, rule.why)
        for rule in rules(flight_height)
        for value in (values.get(rule.name),)
        if value is None or not rule.safe(value)
    )
