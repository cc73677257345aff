"""Python and the libraries that this package asks for."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import PackageNotFoundError, requires, version

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from .finding import Finding, Verdict, judged

PACKAGE = "orchard-cli"
LEAST = (3, 11)


def software() -> list[Finding]:
    """The interpreter, then each library with the version asked for."""
    python = judged(
        "software", "Python", platform.python_version(), sys.version_info >= LEAST,
        f"install Python {LEAST[0]}.{LEAST[1]} or newer, and a new virtual environment",
    )  # fmt: skip
    return [python, *map(_library, _asked_for(requires(PACKAGE) or []))]


def _asked_for(lines: list[str]) -> list[Requirement]:
    """Each library that every installation has; extras are left out."""
    asked = map(Requirement, lines)
    return [one for one in asked if one.marker is None or one.marker.evaluate({"extra": ""})]


def _library(asked: Requirement) -> Finding:
    mend = f"pip install '{asked.name}{asked.specifier}'"
    try:
        have = version(asked.name)
    except PackageNotFoundError:
        return Finding("software", asked.name, "missing", Verdict.BAD, mend)
    rule = str(asked.specifier)
    return judged("software", asked.name, f"{have} ({rule})", satisfies(have, rule), mend)


def satisfies(have: str, rule: str) -> bool:
    """Whether a version keeps a rule such as `>=4.1,<5`."""
    return SpecifierSet(rule).contains(have, prereleases=True)
