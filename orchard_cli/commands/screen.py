"""The live screen of a flight, on stderr."""

from __future__ import annotations

import math
from types import TracebackType

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from orchard_cli.flight.safety import Phase
from orchard_cli.flight.status import Status

_COLOURS = {
    Phase.HOLD: "yellow",
    Phase.RETURN: "yellow",
    Phase.PILOT: "magenta",
    Phase.AVOIDANCE: "cyan",
    Phase.LANDING: "blue",
}


class LiveScreen:
    """Fits flight/ports.py `Display`; draws four times a second from a thread of its own."""

    def __init__(self, title: str, keys: bool) -> None:
        self._title = Text(title)  # a name may hold what looks like markup
        self._keys = keys
        self._status: Status | None = None
        console = Console(stderr=True)
        self._live = Live(
            console=console, get_renderable=self._draw, refresh_per_second=4, transient=False
        )

    def __enter__(self) -> LiveScreen:
        self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._live.stop()

    def show(self, status: Status) -> None:
        """Keep the newest status."""
        self._status = status

    def _draw(self) -> Panel:
        status = self._status
        if status is None:
            return Panel("connecting ...", title=self._title)
        table = Table.grid(padding=(0, 2))
        for width in (12, 34, 14, 28):
            table.add_column(width=width, no_wrap=True, overflow="ellipsis")
        for row in _rows(status):
            table.add_row(*row)
        bar = Table.grid()
        bar.add_row(ProgressBar(total=1.0, completed=status.progress, width=60))
        lines: list[RenderableType] = [
            table,
            bar,
            Text("; ".join(status.hazards), style="bold red"),
        ]
        if self._keys:
            keys = "Ctrl-C or h: hold   c: continue   r: back the way it came   l: land here, now"
            lines.append(Text(keys, style="dim"))
        style = _COLOURS.get(status.phase, "green")
        return Panel(Group(*lines), title=self._title, border_style=style)


class QuietScreen:
    """Shows nothing; for scripts."""

    def __enter__(self) -> QuietScreen:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        pass

    def show(self, status: Status) -> None:
        """Look away."""


def _number(value: float, form: str, unit: str = "") -> str:
    return f"{value:{form}}{unit}" if math.isfinite(value) else "--"


def _rows(s: Status) -> list[tuple[str, ...]]:
    left = f"{int(s.remaining // 60)}:{int(s.remaining % 60):02d} left"
    return [
        ("phase", f"{s.phase.value} ({s.mode})", "time", f"{s.time:6.1f} s, {left}"),
        ("why", s.why, "battery", _number(s.battery * 100, ".0f", " %")),
        ("height", _number(s.height, "5.2f", " m"), "speed", _number(s.speed, "5.2f", " m/s")),
        (
            "cross-track",
            _number(s.cross_track, "5.2f", " m"),
            "spray",
            "ON" if s.spraying else "off",
        ),
        (
            "frame age",
            _number(s.frame_age * 1e3, "4.0f", " ms"),
            "onboard cycle",
            _number(s.cycle_ms, "5.1f", " ms"),
        ),
        ("decision", s.decision, "avoidances", str(s.avoidances)),
    ]
