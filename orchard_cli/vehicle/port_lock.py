"""One program a port.

Two MAVSDK programs can bind the same UDP port without an error, and the newer one then steals every
packet from the older in mid-flight. An advisory lock on a file named after the port prevents that.
"""

from __future__ import annotations

import fcntl
import re
import tempfile
from pathlib import Path
from typing import IO

from orchard_cli.errors import LinkError


class PortLock:
    """Held from construction to `release`, or until the process ends."""

    def __init__(self, url: str) -> None:
        """Raises LinkError when another orchard holds the port of `url`."""
        name = re.sub(r"[^A-Za-z0-9]+", "-", url.rsplit("/", 1)[-1])
        path = Path(tempfile.gettempdir()) / f"orchard-link-{name}.lock"
        self._file: IO[str] = path.open("w")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise LinkError(
                f"{url} is in use by another orchard; end that flight first, "
                "or give this one another port"
            ) from None

    def release(self) -> None:
        """Let others have the port."""
        self._file.close()
