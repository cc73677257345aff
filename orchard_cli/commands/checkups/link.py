"""The autopilot at the other end of --connect."""

from __future__ import annotations

from orchard_cli.errors import LinkError
from orchard_cli.vehicle import LinkReport, inspect_link

from .finding import Finding, Verdict, judged

LEAST_RATE = 15.0  # Hz of odometry: poses are interpolated between these


def link(url: str, flight_height: float) -> list[Finding]:
    """Firmware, health, streams, and the parameters that rule when this program is gone."""
    try:
        return findings(inspect_link(url, flight_height))
    except LinkError as error:
        return [Finding("link", url, "no answer", Verdict.BAD, str(error))]


def findings(report: LinkReport) -> list[Finding]:
    """The report, judged."""
    battery = report.battery_share
    found = [
        Finding("link", "firmware", report.firmware),
        judged("link", "armed", "yes" if report.armed else "no", not report.armed,
               "somebody flies it: disarm before looking further"),
        judged("link", "GPS", report.fix, report.fix.startswith(("fix 3d", "fix dgps", "rtk")),
               "wait for a fix under the open sky"),
        judged("link", "battery", "not told" if battery is None else f"{battery:.0%}",
               battery is not None, "set up battery monitoring: the flight turns back by it"),
        judged("link", "health", "; ".join(report.problems) or "may arm", not report.problems,
               "mend what the autopilot complains of"),
    ]  # fmt: skip
    for name, rate in report.rates.items():
        found.append(judged(
            "link", f"stream: {name}", f"{rate:.0f} Hz", rate >= LEAST_RATE,
            f"{LEAST_RATE:.0f} Hz at least; a flight asks for 50: is the link fast enough?",
        ))  # fmt: skip
    for one in report.parameters:
        have = "missing" if one.value is None else f"{one.value:g}"
        found.append(judged(
            "failsafe", one.name, have, one.safe,
            f"should be {one.wanted:g}: {one.why}; `orchard fly --mend-failsafes` sets it",
        ))  # fmt: skip
    return found
