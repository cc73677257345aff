"""Where compiled kernels are kept: a folder of their own for every state of their sources.

numba looks whether the file of a kernel has changed, but not the files of the kernels that it
calls: after an edit there, or an upgrade, the old machine code would fly on. So the folder is
named for the version and a hash of every `_kernels.py` of the package, and an edit anywhere
begins an empty one. Kernels import nothing of the package but other kernels (a test sees to it).
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

VARIABLE = "NUMBA_CACHE_DIR"
"""What numba reads when it is imported, and what child processes inherit."""

KEPT = 6  # folders; about 3 MB each
_PREFIX = "orchard-"


class Counts(NamedTuple):
    """Specialisations of kernels in this process, so far."""

    loaded: int  # from the cache: it was warm for them
    compiled: int  # just now; they are kept for the next time


def settle(version: str) -> None:
    """Choose the folder, before numba is imported; keep KEPT folders, those used last.

    It lies in $NUMBA_CACHE_DIR if the user has set that, else in the user's cache folder; where
    neither can be written, in a private one that goes with the process.
    """
    name = _PREFIX + key(Path(__file__).parent, version)
    given = os.environ.get(VARIABLE)
    if given and Path(given).name == name:  # by the process that started this one
        return
    home = Path(given) if given else _user_cache()
    folder = home / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        writable = os.access(folder, os.W_OK | os.X_OK)
    except OSError:
        writable = False
    if writable:
        _tidy(home)
    else:
        folder = _private() / name
    os.environ[VARIABLE] = str(folder)


def folder() -> Path:
    """Where the kernels of this process are kept."""
    return Path(os.environ[VARIABLE])


def key(package: Path, version: str) -> str:
    """The version and a hash of the sources of all kernels under `package`."""
    digest = hashlib.sha256(version.encode())
    for source in sorted(_sources(str(package))):
        digest.update(os.path.relpath(source, package).encode())
        digest.update(Path(source).read_bytes())
    return f"{version}-{digest.hexdigest()[:12]}"


def _sources(folder: str) -> Iterator[str]:
    """By hand: a recursive glob takes four times as long, at every start of the program."""
    for entry in os.scandir(folder):
        if entry.name == "_kernels.py":
            yield entry.path
        elif entry.is_dir() and entry.name != "__pycache__":
            yield from _sources(entry.path)


def counts(package: str = "orchard_cli") -> Counts:
    """What was loaded and what was compiled so far of the kernels of a package.

    The cache is warm for what was done between two calls when `compiled` did not grow.
    """
    loaded = compiled = 0
    for name, module in list(sys.modules.items()):
        if name.startswith(package) and name.endswith("_kernels"):
            for thing in list(vars(module).values()):
                if hasattr(thing, "stats") and thing.py_func.__module__ == name:
                    loaded += sum(thing.stats.cache_hits.values())
                    compiled += sum(thing.stats.cache_misses.values())
    return Counts(loaded, compiled)


def _user_cache() -> Path:
    home = os.environ.get("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME")
    return (Path(home) if home else Path(os.path.expanduser("~")) / ".cache") / "orchard"


def _private() -> Path:
    """A folder that only this process and its children use."""
    import atexit
    import shutil
    import tempfile

    folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _tidy(home: Path) -> None:
    """Remove all but the folders used last."""
    try:
        ours = [each for each in home.iterdir() if each.name.startswith(_PREFIX)]
        ours.sort(key=lambda each: each.stat().st_mtime, reverse=True)
    except OSError:  # another process tidies at the same time
        return
    for each in ours[KEPT:]:
        import shutil

        shutil.rmtree(each, ignore_errors=True)
