"""Figures of other programs for the same work, to stand beside ours. docs/bench.md says how they
were measured: on one 2-core x86-64 machine, quiet, on rendered orchard frames and pole fields.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Peer:
    """What another program takes, ms; a range where several scenes were measured."""

    median: str
    p99: str
    who: str


EGO = "EGO-Planner (C++)"

STAGES: dict[str, tuple[Peer, ...]] = {
    "map_update_low": (
        Peer("5.6-6.3", "6.8-7.4", "wavemap 2.2 (C++), 848x480, 4.5 m, wall"),
        Peer("13-18.5", "", f"{EGO}, every pixel, 6 m"),
        Peer("42", "57", "OctoMap 1.9.7 (C++), every pixel, thinned per cell"),
    ),
    "map_update_ego": (Peer("5.0-6.3", "5.2-6.8", f"{EGO}, every second pixel, 4.5 m"),),
    "search": (Peer("0.17-0.18", "0.46-1.04", f"{EGO}, A* alone over 3-6 m"),),
    "optimise": (Peer("0.08", "0.18-0.37", f"{EGO}, L-BFGS"),),
    "cycle": (Peer("11.1", "11.1", "time between two D455 frames at 90 Hz"),),
    "octomap": (Peer("42", "57", "OctoMap 1.9.7 where the peers were measured"),),
}


@dataclass(frozen=True, slots=True)
class PeerReplan:
    """EGO-Planner's own replans in one kind of field: calls, shares, and CPU ms."""

    which: str
    first_call_share: float
    spread: tuple[float, float, float, float]  # median, p95, p99, max


EGO_REPLANS: dict[str, tuple[PeerReplan, ...]] = {
    "density_0.02": (PeerReplan("every call", 0.992, (0.167, 0.347, 0.443, 0.754)),),
    "density_0.05": (
        PeerReplan("every call", 0.992, (0.203, 0.411, 0.520, 0.907)),
        PeerReplan("with A*", 0.985, (0.307, 0.530, 0.674, 0.907)),
    ),
    "forced": (PeerReplan("every call", 0.926, (0.287, 0.411, 0.462, 0.547)),),
    "forced_0.02": (PeerReplan("every call", 0.915, (0.307, 0.469, 0.585, 0.859)),),
    "forced_0.05": (PeerReplan("every call", 0.898, (0.317, 0.495, 0.633, 1.225)),),
}
"""Known map, its published settings, target 7.5 m ahead, 1000 calls each. It plans in every call,
ours only where the way is blocked.
"""
