"""What the numbers were taken on, without names of hosts or paths."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path


def processor() -> str:
    """The model of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def environment() -> dict[str, str]:
    """Versions and hardware that every result is kept with."""
    return {
        "processor": processor(),
        "vectors": _vectors(),
        "system": platform.system(),
        "Python": platform.python_version(),
        **{name: version(name) for name in ("remanent", "numpy", "llvmlite")},
    }


def busy() -> float:
    """Processes that wanted to run in the last minute, per processor; 0 where unknown."""
    try:
        return os.getloadavg()[0] / (os.cpu_count() or 1)
    except (AttributeError, OSError):
        return 0.0


@contextmanager
def one_core() -> Iterator[None]:
    """Everything inside, threads too, runs on one processor, where the system can do that."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def _vectors() -> str:
    from remanent.integrate.kernel.compile import host_processor

    return f"{32 * host_processor().lane_count} bits"
