"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

from orchard_cli import __version__


def describe() -> dict[str, Any]:
    """Processor, versions, and how busy the machine is: without these a figure says little."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load_1min": _load(),
        "system": platform.platform(terse=True),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
        "orchard": __version__,
    }


def _load() -> float | None:
    """Runnable processes, averaged over a minute; None where the system does not tell."""
    try:
        return round(os.getloadavg()[0], 2)
    except OSError:
        return None


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())
