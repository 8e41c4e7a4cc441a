"""How long a user waits for the first import and the first figure, in fresh processes."""

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

_FIGURE = """
import io
import numpy as np
import remanent as rm
hot = rm.Actuator(temperature=350)
ds = rm.frequency_response(hot, rm.SineSquared(0.4, 1.0), np.linspace(0.5, 2.0, 301))
rm.plot.response(ds)[0].get_figure().savefig(io.BytesIO())
"""
_COMMANDS = {
    "nothing": "pass",
    "import numpy": "import numpy",
    "import remanent": "import remanent",
    "bare imports": "import numba, xarray, matplotlib.pyplot",
    "first figure": _FIGURE,
}


def measure(plan: Plan) -> dict[str, Any]:
    """Median seconds of whole processes that take turns."""
    repeats = 3 if plan.quick else 9
    times: dict[str, list[float]] = {name: [] for name in (*_COMMANDS, "first figure, cold")}
    for name, code in _COMMANDS.items():  # the first of each warms the system's caches
        _seconds(code, os.environ)
        plan.say(f"start: {name}: ready")
    for repeat in range(repeats):
        plan.say(f"start: round {repeat + 1} of {repeats}")
        for name, code in _COMMANDS.items():
            times[name].append(_seconds(code, os.environ))
        with tempfile.TemporaryDirectory() as empty:
            cold = {**os.environ, "REMANENT_CACHE_DIR": empty}
            times["first figure, cold"].append(_seconds(_FIGURE, cold))
    return {"repeats": repeats, "seconds": {k: statistics.median(v) for k, v in times.items()}}


def _seconds(code: str, environment: Mapping[str, str]) -> float:
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", code], check=True, env={**environment, "MPLBACKEND": "Agg"}
    )
    return time.perf_counter() - begin
