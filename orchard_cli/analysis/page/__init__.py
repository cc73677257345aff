"""The page of `orchard analyze --html`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from orchard_cli.model.output_file import write_whole

from ..flight import Flight
from ..paper import Published
from .document import page

__all__ = ["page", "save"]


def save(path: Path, flights: Sequence[Flight], published: Sequence[Published] = ()) -> None:
    """Write the page, whole or not at all. Raises InputError when it cannot be written."""
    write_whole(path, page(flights, published), (".html", ".htm"))
