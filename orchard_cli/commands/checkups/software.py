"""Python and the libraries that this package asks for."""

from __future__ import annotations

import platform
import re
import sys
from importlib.metadata import PackageNotFoundError, requires, version

from .finding import Finding, Verdict, judged

PACKAGE = "orchard-cli"
LEAST = (3, 11)
_REQUIREMENT = re.compile(r"^([A-Za-z0-9_.-]+)(?:\[[^]]*\])?\s*([^;]*)(?:;\s*(.*))?$")


def software() -> list[Finding]:
    """The interpreter, then each library with the version asked for."""
    python = judged(
        "software", "Python", platform.python_version(), sys.version_info >= LEAST,
        f"install Python {LEAST[0]}.{LEAST[1]} or newer, and a new virtual environment",
    )  # fmt: skip
    return [python, *map(_library, _asked_for(requires(PACKAGE) or []))]


def _asked_for(lines: list[str]) -> list[tuple[str, str]]:
    """Name and version rule of each library that every installation has; extras are left out."""
    found = []
    for line in lines:
        match = _REQUIREMENT.match(line)
        if match and "extra ==" not in (match[3] or ""):
            found.append((match[1], match[2].strip()))
    return found


def _library(asked: tuple[str, str]) -> Finding:
    name, rule = asked
    mend = f"pip install '{name}{rule}'"
    try:
        have = version(name)
    except PackageNotFoundError:
        return Finding("software", name, "missing", Verdict.BAD, mend)
    return judged("software", name, f"{have} ({rule})", satisfies(have, rule), mend)


def satisfies(have: str, rule: str) -> bool:
    """Whether a version keeps a rule of comma-separated `>=`, `<` and `==` parts."""
    for part in filter(None, (p.strip() for p in rule.split(","))):
        sign, wanted = re.match(r"([<>=!~]+)\s*(.*)", part).groups()  # type: ignore[union-attr]
        have_numbers, wanted_numbers = _numbers(have), _numbers(wanted)
        width = max(len(have_numbers), len(wanted_numbers))
        a, b = (n + (0,) * (width - len(n)) for n in (have_numbers, wanted_numbers))
        if not {">=": a >= b, "<": a < b, "==": a == b}.get(sign, True):
            return False
    return True


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(n) for n in re.findall(r"\d+", text.split("+", maxsplit=1)[0])[:4])
