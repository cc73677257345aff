"""Where the onboard cycle runs: beside the control loop, never in it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")
JobTaken_contra = TypeVar("JobTaken_contra", contravariant=True)
ResultMade_co = TypeVar("ResultMade_co", covariant=True)


class Worker(Protocol[JobTaken_contra, ResultMade_co]):
    """Does one job at a time and hands out each result once."""

    def idle(self) -> bool:
        """Whether a job can be given now."""
        ...

    def give(self, job: JobTaken_contra, now: float) -> None:
        """Start a job; only when idle."""
        ...

    def take(self, now: float) -> ResultMade_co | Exception | None:
        """The finished result, or what went wrong, or None."""
        ...

    def close(self) -> None:
        """Stop."""
        ...


class ThreadWorker(Generic[Job, Result]):
    """Runs jobs in a thread; the kernels in them let go of the GIL."""

    def __init__(self, work: Callable[[Job], Result]) -> None:
        self._work = work
        self._job: Job | None = None
        self._result: Result | Exception | None = None
        self._wake = threading.Semaphore(0)
        self._busy = False
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="onboard", daemon=True)
        self._thread.start()

    def idle(self) -> bool:
        """True once the last result has been taken."""
        return not self._busy

    def give(self, job: Job, now: float) -> None:
        """Hand over a job."""
        del now
        self._busy, self._job = True, job
        self._wake.release()

    def take(self, now: float) -> Result | Exception | None:
        """The result of the job given, once."""
        del now
        result, self._result = self._result, None
        if result is not None:
            self._busy = False
        return result

    def close(self) -> None:
        """Let the running job finish, then stop."""
        self._stopping = True
        self._wake.release()
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while True:
            self._wake.acquire()
            job, self._job = self._job, None
            if self._stopping or job is None:
                return
            try:
                self._result = self._work(job)
            except Exception as error:  # a throwing planner must not end the flight
                self._result = error


class InlineWorker(Generic[Job, Result]):
    """Runs jobs at once, and hands the result out a fixed latency later: bit-repeatable."""

    def __init__(self, work: Callable[[Job], Result], latency: float = 0.04) -> None:
        self._work = work
        self._latency = latency
        self._due = 0.0
        self._result: Result | Exception | None = None

    def idle(self) -> bool:
        """True once the last result has been taken."""
        return self._result is None

    def give(self, job: Job, now: float) -> None:
        """Do the job now."""
        self._due = now + self._latency
        try:
            self._result = self._work(job)
        except Exception as error:
            self._result = error

    def take(self, now: float) -> Result | Exception | None:
        """The result, when its latency has passed."""
        if self._result is None or now < self._due:
            return None
        result, self._result = self._result, None
        return result

    def close(self) -> None:
        """Nothing to stop."""
