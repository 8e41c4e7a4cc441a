"""How long a user waits for the first import and the first figure, in fresh processes.

Measured is the time of the wall clock of whole processes, in seconds, the median of repeats in
which the commands take turns.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from typing import Any

from benchmarks.rows.plan import Plan
from benchmarks.tools.tool import Package

#: A frequency response of 301 points, computed and drawn.
_FIGURE = """
import io
import numpy as np
import remanent as rm
hot = rm.Actuator(temperature=350)
ds = rm.frequency_response(hot, rm.SineSquared(0.4, 1.0), np.linspace(0.5, 2.0, 301))
rm.plot.response(ds)[0].get_figure().savefig(io.BytesIO())
"""
#: The imports that the first figure is measured against; of these, Numba is not ours.
_BARE_IMPORTS = "bare imports"
#: The first figure with an empty cache of kernels.
_COLD = "first figure, cold"
#: Processes of each kind.
_REPEATS = 9
#: The same in a quick run.
_QUICK_REPEATS = 3
#: Code of a process by name.
_COMMANDS = {
    "nothing": "pass",
    "import numpy": "import numpy",
    "import remanent": "import remanent",
    _BARE_IMPORTS: "import numba, xarray, matplotlib.pyplot",
    "first figure": _FIGURE,
}


def measure(plan: Plan) -> dict[str, Any]:
    """Median seconds of whole processes that take turns."""
    repeats = _QUICK_REPEATS if plan.quick else _REPEATS
    commands = dict(_COMMANDS)
    if reason := Package("numba").missing():
        plan.say(f"start: {_BARE_IMPORTS} left out, {reason}")
        del commands[_BARE_IMPORTS]
    times: dict[str, list[float]] = {name: [] for name in (*commands, _COLD)}
    for name, code in commands.items():  # the first of each warms the system's caches
        _seconds(code, os.environ)
        plan.say(f"start: {name}: ready")
    for repeat in range(repeats):
        plan.say(f"start: round {repeat + 1} of {repeats}")
        for name, code in commands.items():
            times[name].append(_seconds(code, os.environ))
        with tempfile.TemporaryDirectory() as empty:
            cold = {**os.environ, "REMANENT_CACHE_DIR": empty}
            times[_COLD].append(_seconds(_FIGURE, cold))
    return {"repeats": repeats, "seconds": {k: statistics.median(v) for k, v in times.items()}}


def _seconds(code: str, environment: Mapping[str, str]) -> float:
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", code], check=True, env={**environment, "MPLBACKEND": "Agg"}
    )
    return time.perf_counter() - begin
