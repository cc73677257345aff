"""`--live`: the running flight for Foxglove or Lichtblick."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.flightlog import LiveView


def live_view(address: str) -> tuple[LiveView, ...]:
    """The server on HOST:PORT, and word of it on stderr; nothing for an empty address.

    Raises InputError when that is no address, LinkError when it cannot be had.
    """
    if not address:
        return ()
    from orchard_cli.flightlog import LiveView, layout

    host, colon, port = address.rpartition(":")
    if not (colon and host and port.isdigit() and int(port) < 2**16):
        mend = "write HOST:PORT, as 192.168.1.20:8765 or [::1]:8765"
        raise InputError(Fault("--live-address", f"no address {address!r}", mend))
    view = LiveView(host.strip("[]"), int(port))
    typer.echo(f"live at {view.address} (Foxglove, Lichtblick); layout: {layout()}", err=True)
    return (view,)
