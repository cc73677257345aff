"""No machine code outlives its source, and the cache stays small."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import orchard_cli
from orchard_cli import kernel_cache

PACKAGE = Path(orchard_cli.__file__).parent
KERNELS = sorted(PACKAGE.glob("**/_kernels.py"))


def settled(environment, version="1"):
    """The folder that a new process chooses."""
    code = (
        "import sys, os; sys.path.insert(0, sys.argv[1]); import kernel_cache as k;"
        "k.settle(sys.argv[2]); print(os.environ[k.VARIABLE])"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code, str(PACKAGE), version],
        env={"PATH": os.environ["PATH"], **environment}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return Path(ran.stdout.strip())


@pytest.mark.parametrize("change", ["edit", "add", "rename"])
def test_any_change_of_any_kernel_file_begins_a_new_cache(tmp_path, change):
    for room in ("one", "two/three"):
        (tmp_path / room).mkdir(parents=True)
        (tmp_path / room / "_kernels.py").write_text(f"# {room}")
    before = kernel_cache.key(tmp_path, "1")
    assert kernel_cache.key(tmp_path, "1") == before != kernel_cache.key(tmp_path, "2")
    if change == "edit":
        (tmp_path / "two/three/_kernels.py").write_text("# another")
    elif change == "add":
        (tmp_path / "_kernels.py").write_text("")
    else:
        (tmp_path / "one").rename(tmp_path / "four")
    assert kernel_cache.key(tmp_path, "1") != before


@pytest.mark.parametrize("path", KERNELS, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_kernels_import_nothing_of_the_package_but_kernels(path):
    """Else the key would not see a changed constant."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.level or "orchard_cli" in str(node.module)):
            assert str(node.module).endswith("_kernels")
        elif isinstance(node, ast.Import):
            assert not any(name.name.startswith("orchard_cli") for name in node.names)


def test_this_process_keeps_its_kernels_in_the_folder_of_their_sources():
    from numba.core import config

    name = kernel_cache.key(PACKAGE, orchard_cli.__version__)
    assert kernel_cache.folder().name.endswith(name)
    assert Path(config.CACHE_DIR) == kernel_cache.folder()


def test_a_child_takes_its_parents_folder_and_a_users_choice_is_kept(tmp_path):
    folder = settled({"XDG_CACHE_HOME": str(tmp_path)})
    assert folder.parent == tmp_path / "orchard"
    assert settled({"NUMBA_CACHE_DIR": str(folder)}) == folder
    assert settled({"NUMBA_CACHE_DIR": str(tmp_path / "mine")}).parent == tmp_path / "mine"


def test_only_the_folders_used_last_are_kept(tmp_path):
    made = [settled({"XDG_CACHE_HOME": str(tmp_path)}, str(n)) for n in range(8)]
    for n, each in enumerate(made):
        if each.exists():
            os.utime(each, (n, n))
    newest = settled({"XDG_CACHE_HOME": str(tmp_path)}, "0")
    kept = set((tmp_path / "orchard").iterdir())
    assert len(kept) == kernel_cache.KEPT
    assert {newest, made[-1]} <= kept


def test_where_nothing_can_be_written_a_private_folder_serves_and_goes(tmp_path):
    (tmp_path / "file").write_text("")
    folder = settled({"XDG_CACHE_HOME": str(tmp_path / "file")})
    assert folder.parent.parent == Path("/tmp")
    assert not folder.exists()
