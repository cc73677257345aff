"""Many tasks at once: in processes of this machine or on a Dask cluster, with a bar meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from orchard_cli.errors import Fault, InputError, LinkError

DASK_PATIENCE = 10  # s

Task = TypeVar("Task")
Result = TypeVar("Result")


def spread(
    work: Callable[[Task], Result],
    tasks: Sequence[Task],
    workers: int,
    dask: str | None = None,
    doing: str = "working",
    quiet: bool = False,
) -> Iterator[Result]:
    """Each task's result as it comes, in any order; on stderr a bar with the time that is left.

    `work` and the tasks travel to other processes: a function of a module, and plain data. It
    must not raise. Raises InputError without Dask, LinkError without its scheduler.
    """
    from rich.console import Console
    from rich.progress import track

    if dask is not None:
        done = _on_dask(work, tasks, dask)
    elif workers > 1:
        done = _in_processes(work, tasks, workers)
    else:
        done = map(work, tasks)
    console = Console(stderr=True, quiet=quiet)
    yield from track(done, doing, len(tasks), console=console, transient=True)


def _in_processes(
    work: Callable[[Task], Result], tasks: Sequence[Task], workers: int
) -> Iterator[Result]:
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from multiprocessing import get_context

    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
    try:
        for future in as_completed([pool.submit(work, task) for task in tasks]):
            yield future.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _on_dask(
    work: Callable[[Task], Result], tasks: Sequence[Task], address: str
) -> Iterator[Result]:
    """The cluster's workers need this package and the same files under the same paths."""
    try:
        from distributed import Client, as_completed
    except ImportError:
        mend = "install it: pip install 'orchard-cli[dask]'"
        raise InputError(Fault("--dask", "needs distributed", mend)) from None
    try:
        client = Client(address, timeout=DASK_PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise LinkError(f"--dask: no scheduler answers at {address} ({error})") from None
    with client:
        futures = client.map(work, tasks, pure=False)
        for future in as_completed(futures):
            yield future.result()
