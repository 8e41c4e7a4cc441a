"""What of the machine this process may use.

Law: Stopping.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from remanent import _machine

#: Prints what a fresh process may use.
TELL = """
from remanent import _machine
print(_machine.available_processor_count(), _machine.available_memory_bytes())
"""
#: Prints how many megabytes a fresh process holds when seven of eight arrays have been freed.
TELL_HELD = """
import numpy as np
from pathlib import Path
from remanent._machine import keep_large_arrays_apart

def held():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6

if {keep}:
    keep_large_arrays_apart()
np.ones(2**21)  # freed: from now on arrays of less than 16 MB count as small
before = held()
arrays = [np.ones(2**18) for _ in range(64)]
stay = arrays[::8]
del arrays
print(held() - before)
"""
GIB = 2.0**30


def told(prepare: str = "") -> tuple[int, float]:
    """Processors and bytes of a process that `prepare` was run in first."""
    code = f"import os, resource\n{prepare}\n{TELL}"
    answer = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    return int(answer[0]), float(answer[1])


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="Linux has affinities")
def test_processors_are_those_of_the_affinity() -> None:
    """Bound to one processor, a process counts one."""
    assert told("os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})")[0] == 1
    assert told()[0] == len(os.sched_getaffinity(0))


@pytest.mark.skipif(os.name != "posix", reason="limits of processes are POSIX")
@pytest.mark.parametrize("limit", ["RLIMIT_AS", "RLIMIT_DATA"])
def test_memory_is_what_the_limit_of_the_process_leaves(limit: str) -> None:
    """Less than the limit, by what the process has mapped; and more than nothing."""
    soft = 2 * GIB
    hard = f"resource.getrlimit(resource.{limit})[1]"
    available = told(f"resource.setrlimit(resource.{limit}, ({int(soft)}, {hard}))")[1]
    assert 0.0 < available < soft


def tree(root: Path, files: dict[str, str], own: str) -> list[float]:
    """Limits that are found in such files, for a process in the groups `own`."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    (root / "own").write_text(own)
    return list(_machine._control_group_limits_bytes(root, root / "own"))


def test_limits_of_control_groups_and_of_those_above(tmp_path: Path) -> None:
    """Version 2: the group's own limit and its parent's; "max" is none."""
    files = {"a/memory.max": "3000\n", "a/b/memory.max": "max\n", "a/b/c/memory.max": "5000\n"}
    assert min(tree(tmp_path, files, "0::/a/b/c\n")) == 3000.0


def test_limits_of_control_groups_of_the_first_version(tmp_path: Path) -> None:
    """Version 1: in a hierarchy of its own, among others; in a container at its root."""
    files = {"memory/memory.limit_in_bytes": "7000\n", "cpu/memory.limit_in_bytes": "1\n"}
    own = "5:cpu,cpuacct:/outside/name\n4:memory:/outside/name\n0::/\n"
    assert tree(tmp_path, files, own) == [7000.0]


def test_without_control_groups_there_is_no_limit(tmp_path: Path) -> None:
    """No file, nothing found, no error."""
    assert list(_machine._control_group_limits_bytes(tmp_path, tmp_path / "none")) == []
    assert tree(tmp_path, {}, "0::/x\n") == []


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only GNU's library keeps gaps")
def test_large_arrays_that_are_freed_leave_no_gaps() -> None:
    """Of 134 MB, an eighth stays here and there: a process holds that eighth."""

    def megabytes_held(keep: bool) -> float:
        code = TELL_HELD.format(keep=keep)
        usual = {name: v for name, v in os.environ.items() if not name.startswith("MALLOC_")}
        return float(subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True, env=usual
        ).stdout)  # fmt: skip

    assert megabytes_held(keep=True) < 25.0
    assert megabytes_held(keep=False) > 100.0
