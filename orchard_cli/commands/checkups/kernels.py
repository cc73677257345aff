"""Whether the compiled kernels are at hand, so that nothing has to be compiled before a flight."""

from __future__ import annotations

import sys
import time

import numpy as np

from orchard_cli.flight.onboard import Onboard
from orchard_cli.flight.warmup import warm_up
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.depth import d455
from orchard_cli.model.mission import Limits

from .finding import Finding, Verdict


def kernels(system: str) -> list[Finding]:
    """Run the onboard cycle of a system once: what is not in the cache is compiled, and kept."""
    from orchard_cli.commands.wiring import SYSTEMS

    before = _counts()
    began = time.monotonic()
    warm_up(Onboard(OccupancyGrid(), SYSTEMS[system](), Limits()), d455())
    took = time.monotonic() - began
    loaded, compiled = np.subtract(_counts(), before)
    if compiled == 0:
        return [Finding("kernels", system, f"warm: {loaded} loaded in {took:.1f} s")]
    found = f"{compiled} compiled just now in {took:.1f} s, {loaded} were at hand"
    mend = "nothing to do: look again to see that they are kept"
    return [Finding("kernels", system, found, Verdict.NOTE, mend)]


def _counts() -> tuple[int, int]:
    """Specialisations that numba loaded from its cache, and those that it compiled, so far."""
    from numba.core.dispatcher import Dispatcher

    loaded = compiled = 0
    for name, module in list(sys.modules.items()):
        if name.startswith("orchard_cli") and name.endswith("_kernels"):
            for thing in list(vars(module).values()):
                if isinstance(thing, Dispatcher) and thing.py_func.__module__ == name:
                    loaded += sum(thing.stats.cache_hits.values())
                    compiled += sum(thing.stats.cache_misses.values())
    return loaded, compiled
