"""A chart of regimes over the plane of frequency and load, 512 motions by 512.

Measured are seconds of the wall clock and of all processors together.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from typing import Any

import numpy as np

import remanent as rm
from benchmarks import figures
from benchmarks.page import DOCS
from benchmarks.rows.plan import Plan

#: Motions along each side of the chart.
_SIDE = 512
#: The same in a quick run.
_QUICK_SIDE = 48
#: Drive periods after which motions are judged.
_PERIODS = 500
#: Tolerance of a motion.
_TOLERANCE = 1e-7
#: Drive frequencies of the chart.
_OMEGA = (0.4, 2.2)
#: Roots of the peak load of the chart.
_B = (0.1, 1.6)
#: Drive frequencies between which the fold of the primary resonance lies.
_FOLD_OMEGA = (1.1, 1.4)


def measure(plan: Plan) -> dict[str, Any]:
    """Time on all cores; the picture is drawn here, since its data are too large to keep."""
    side = _QUICK_SIDE if plan.quick else _SIDE
    hot, drive = rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.0)
    rm.classify(hot, drive, periods=100)  # kernels are compiled here
    over = {"b": np.linspace(*_B, side), "omega": np.linspace(*_OMEGA, side)}
    begin, spent = time.perf_counter(), time.process_time()
    ds = rm.regime_chart(hot, drive, over, periods=_PERIODS, tolerance=_TOLERANCE)
    seconds, spent = time.perf_counter() - begin, time.process_time() - spent
    plan.say(f"chart: {side} x {side} in {seconds:.0f} s")
    if not plan.quick:
        figures.chart(ds, _folds(hot, drive), DOCS / "results" / "chart.png")
    return {
        "side": side,
        "periods": _PERIODS,
        "tolerance": _TOLERANCE,
        "seconds": seconds,
        "processor_seconds": spent,
        "cores": os.cpu_count(),
        "regimes": dict(Counter(ds.regime.values.ravel().tolist()).most_common()),
    }


def _folds(hot: rm.Actuator, drive: rm.SineSquared) -> Any:
    """Where the orbits of the primary resonance are born, in the plane of the chart."""
    orbits = rm.response_diagram(hot, drive, _FOLD_OMEGA)
    (fold,) = np.flatnonzero(orbits.special_kind.values == "fold")
    at = orbits.isel(special=fold)
    return rm.continue_bifurcation(
        hot, rm.SineSquared(0.4, float(at.special_omega)), "fold", ("omega", "b"), [_OMEGA, _B],
        initial=(float(at.special_stretch), float(at.special_stretch_rate)),
    )  # fmt: skip
