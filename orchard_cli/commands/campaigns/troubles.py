"""What goes wrong inside the flight's process, put between its loop and its sockets from outside.

The observer's process switches them on and off in shared memory; the flight knows nothing of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import IntEnum
from multiprocessing.context import SpawnContext
from typing import Any

from orchard_cli.flight.onboard import OnboardJob, OnboardResult
from orchard_cli.flight.worker import Worker
from orchard_cli.model.vehicle import Pose

LATE = 1.5  # s by which a late planner's answers, and late poses, come later


class Trouble(IntEnum):
    """Kinds."""

    NONE = 0
    PLANNER_LATE = 1
    PLANNER_THROWS = 2
    PLANNER_HANGS = 3
    POSES_LATE = 4


class Troubles:
    """Shared by two processes: hand it over as an argument of the second one."""

    def __init__(self, context: SpawnContext) -> None:
        self._kind = context.RawValue("i", 0)
        self._until = context.RawValue("d", 0.0)
        self._hits = context.RawValue("i", 0)

    def begin(self, kind: Trouble, until: float) -> None:
        """From now to `until`, s of the flight clock."""
        self._until.value = until
        self._kind.value = kind

    def now(self, now: float) -> Trouble:
        """What is wrong at this time."""
        return Trouble(self._kind.value) if now < self._until.value else Trouble.NONE

    def hit(self) -> None:
        """It has struck."""
        self._hits.value += 1

    @property
    def hits(self) -> int:
        """How often it has struck: the evidence that it happened."""
        return int(self._hits.value)


class TroubledWorker:
    """Fits flight/worker.py `Worker`: an onboard cycle that is late, throws or hangs."""

    def __init__(self, inner: Worker[OnboardJob, OnboardResult], troubles: Troubles) -> None:
        self._inner = inner
        self._troubles = troubles
        self._held: tuple[float, OnboardResult | Exception] | None = None

    def idle(self) -> bool:
        """False as well while an answer is held back."""
        return self._held is None and self._inner.idle()

    def give(self, job: OnboardJob, now: float) -> None:
        """Hand on."""
        self._inner.give(job, now)

    def take(self, now: float) -> OnboardResult | Exception | None:
        """The answer, spoilt while there is trouble."""
        trouble = self._troubles.now(now)
        if self._held is not None:
            return self._release(trouble, now)
        result = self._inner.take(now)
        if result is None or trouble in (Trouble.NONE, Trouble.POSES_LATE):
            return result
        self._troubles.hit()
        if trouble is Trouble.PLANNER_THROWS:
            return RuntimeError("thrown by the fault campaign")
        self._held = (now if trouble is Trouble.PLANNER_LATE else math.inf, result)
        return None

    def _release(self, trouble: Trouble, now: float) -> OnboardResult | Exception | None:
        assert self._held is not None
        since, result = self._held
        if now - since < LATE and not (trouble is Trouble.NONE and math.isinf(since)):
            return None
        self._held = None
        return result

    def close(self) -> None:
        """Stop."""
        self._inner.close()


class LatePoses:
    """Fits flight/ports.py `Vehicle`: poses come late while there is that trouble."""

    def __init__(self, inner: Any, troubles: Troubles, now: Callable[[], float]) -> None:
        self._inner = inner
        self._troubles = troubles
        self._now = now

    def poses(self, since: float) -> tuple[Pose, ...]:
        """Those that have come by now."""
        now, found = self._now(), self._inner.poses(since)
        if self._troubles.now(now) is not Trouble.POSES_LATE:
            return tuple(found)
        self._troubles.hit()
        return tuple(pose for pose in found if pose.time < now - LATE)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)
