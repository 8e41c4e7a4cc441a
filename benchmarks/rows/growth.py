"""Time and memory from a thousand trajectories to a million, each in its own process.

Measured are seconds of the wall clock on one core, and bytes: those of the result, and the
growth of the peak of resident memory beyond it.
"""

from __future__ import annotations

import json
import re
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.jobs import RESPONSE
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from benchmarks.tools import ours
from remanent._typing import FloatArray

#: Numbers of trajectories; a quick run leaves out the last.
_COUNTS = (1_000, 10_000, 100_000, 1_000_000)
#: Tolerance of the frequency responses.
_TOLERANCE = 1e-8


def measure(plan: Plan) -> dict[str, Any]:
    """Run every size in a process of its own, since a peak of memory is never forgotten."""
    rows = []
    with one_core():
        for count in _COUNTS[:-1] if plan.quick else _COUNTS:
            command = [sys.executable, "-m", __spec__.name, str(count)]
            done = subprocess.run(command, check=True, capture_output=True, text=True)
            rows.append({"trajectories": count, **json.loads(done.stdout)})
            plan.say(f"growth: {count} trajectories in {rows[-1]['seconds']:.2f} s")
    return {"tolerance": _TOLERANCE, "rows": rows}


def _frequencies(count: int) -> FloatArray:
    return np.linspace(RESPONSE.low, RESPONSE.high, count)


def _respond(omegas: FloatArray) -> int:
    """Bytes of the result of a frequency response."""
    ds = rm.frequency_response(
        ours.actuator(RESPONSE), rm.SineSquared(RESPONSE.b, 1.0), omegas, tolerance=_TOLERANCE
    )
    return int(ds.nbytes)


def peak() -> int:
    """Largest resident memory of this process so far, bytes.

    On Linux not from ``getrusage``, which remembers the process that started this one.
    """
    status = Path("/proc/self/status")
    if status.exists():
        return int(re.findall(r"^VmHWM:\s+(\d+) kB$", status.read_text(), re.M)[0]) * 1024
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def main(count: int) -> None:
    """One size; what the first call brings with it, imports and kernels, does not count."""
    _respond(_frequencies(_COUNTS[0]))
    omegas = _frequencies(count)
    before, begin = peak(), time.perf_counter()
    size = _respond(omegas)
    seconds = time.perf_counter() - begin
    print(json.dumps({"seconds": seconds, "result": size, "beyond": peak() - before - size}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
