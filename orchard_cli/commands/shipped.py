"""The orchards in missions/, which come with the repository and with no wheel."""

from __future__ import annotations

from pathlib import Path

from orchard_cli.errors import Fault, InputError

MISSIONS = Path(__file__).resolve().parents[2] / "missions"


def shipped(name: str) -> Path:
    """A file of the folder. Raises InputError when it is not there."""
    file = MISSIONS / name
    if not file.exists():
        raise missing(file)
    return file


def missing(path: Path) -> InputError:
    """What to say of a file, or a folder, that is not there."""
    what = "the missions/ folder of the repository is needed"
    return InputError(Fault(str(path), what, "run it from a clone installed with pip -e"))
