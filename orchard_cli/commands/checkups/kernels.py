"""Whether the compiled kernels are at hand, so that nothing has to be compiled before a flight."""

from __future__ import annotations

import time

from orchard_cli.flight.onboard import Onboard
from orchard_cli.flight.warmup import warm_up
from orchard_cli.kernel_cache import counts, folder
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.depth import d455
from orchard_cli.model.mission import Limits

from .finding import Finding, Verdict


def kernels(system: str) -> list[Finding]:
    """Run the onboard cycle of a system once: what is not in the cache is compiled, and kept."""
    from orchard_cli.commands.systems import SYSTEMS

    before = counts()
    began = time.monotonic()
    warm_up(Onboard(OccupancyGrid(), SYSTEMS[system](), Limits()), d455())
    took = time.monotonic() - began
    after = counts()
    loaded, compiled = after.loaded - before.loaded, after.compiled - before.compiled
    if compiled == 0:
        found = f"warm: {loaded} loaded in {took:.1f} s from {folder()}"
        return [Finding("kernels", system, found)]
    found = f"{compiled} compiled just now in {took:.1f} s into {folder()}, {loaded} were at hand"
    mend = "nothing to do: look again to see that they are kept"
    return [Finding("kernels", system, found, Verdict.NOTE, mend)]
