"""What of this machine the process may use: processors and memory.

A machine may have more of both than the process is allowed: by its affinity, by limits on
the process (``ulimit``) and by limits on its control group (a container, a batch job).
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

#: Bytes that are assumed where the machine does not tell how many it has.
_ASSUMED_MEMORY_BYTES: Final = 8.0 * 2**30
#: Where control groups are found, by convention.
_CONTROL_GROUP_ROOT: Final = Path("/sys/fs/cgroup")
#: The control groups of this process, a line for each hierarchy.
_OWN_CONTROL_GROUPS: Final = Path("/proc/self/cgroup")
#: Pages that this process has mapped and holds, the first two numbers.
_OWN_MEMORY: Final = Path("/proc/self/statm")
#: The parameter of ``mallopt`` for the size from which on memory is mapped, and that size.
_MMAP_THRESHOLD: Final = -3
_LARGE_ARRAY_BYTES: Final = 2**20
#: Environment variable with the threads that this process may have beside others.
THREADS_VARIABLE: Final = "REMANENT_THREADS"


def available_processor_count() -> int:
    """Processors that this process may use, by its affinity and by ``REMANENT_THREADS``."""
    wanted = os.environ.get(THREADS_VARIABLE, "")
    limit = int(wanted) if wanted.isdecimal() and int(wanted) > 0 else None
    count = _processor_count()
    return count if limit is None else min(count, limit)


def _processor_count() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) or 1
    return os.cpu_count() or 1


def keep_large_arrays_apart() -> None:
    """Let the C library give every large array pages of its own, which go back when it is freed.

    The library of GNU stops doing so for arrays of a size that was freed once, and is left with
    gaps, so that memory creeps up over thousands of tasks.  Those of macOS, Windows and musl do
    so anyway.
    """
    with suppress(OSError, TypeError, AttributeError):
        ctypes.CDLL(None).mallopt(_MMAP_THRESHOLD, _LARGE_ARRAY_BYTES)


def available_memory_bytes() -> float:
    """Bytes that this process may hold at most, by the machine and by every limit on it."""
    return min([_physical_memory_bytes(), *_control_group_limits_bytes(), *_process_limits_bytes()])


def _physical_memory_bytes() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return _windows_memory_bytes() or _ASSUMED_MEMORY_BYTES


class _MemoryStatus(ctypes.Structure):
    """What ``GlobalMemoryStatusEx`` of Windows fills in."""

    _fields_ = (
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        ("physical", ctypes.c_uint64),
        *((f"other_{k}", ctypes.c_uint64) for k in range(6)),
    )


def _windows_memory_bytes() -> float | None:
    """Bytes that a machine with Windows has; None on another system."""
    library = getattr(ctypes, "windll", None)
    if library is None:
        return None
    status = _MemoryStatus(length=ctypes.sizeof(_MemoryStatus))
    told = library.kernel32.GlobalMemoryStatusEx(ctypes.byref(status))
    return float(status.physical) if told else None


def _process_limits_bytes() -> Iterator[float]:
    """What is left of the limits on address space and on data."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for name in ("RLIMIT_AS", "RLIMIT_DATA"):
        if not hasattr(resource, name):  # not every system limits both
            continue
        soft, _ = resource.getrlimit(getattr(resource, name))
        if soft != resource.RLIM_INFINITY:
            yield max(float(soft) - _mapped_bytes(), 0.0)


def _mapped_bytes() -> float:
    """Bytes of address space that this process has taken already; 0 where it is not told."""
    try:
        pages = _OWN_MEMORY.read_text(encoding="utf-8").split()[0]
        return float(pages) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError, IndexError):
        return 0.0


def _control_group_limits_bytes(
    root: Path = _CONTROL_GROUP_ROOT, own: Path = _OWN_CONTROL_GROUPS
) -> Iterator[float]:
    """Limits on the control groups of this process and on those above them.

    In a container the group's name may be that outside of it, so that the files are looked
    for at the root of the hierarchy too.
    """
    with suppress(OSError):
        for line in own.read_text(encoding="utf-8").splitlines():
            _, controllers, name = line.split(":", 2)
            if controllers and "memory" not in controllers.split(","):
                continue
            base, file = (
                (root / "memory", "memory.limit_in_bytes") if controllers else (root, "memory.max")
            )
            group = Path(name.lstrip("/"))
            for folder in (base / group, *(base / part for part in group.parents)):
                with suppress(OSError, ValueError):  # "max" is no number: there is no limit
                    yield float(int((folder / file).read_text(encoding="utf-8")))
