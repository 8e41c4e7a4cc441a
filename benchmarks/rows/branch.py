"""Branches of periodic orbits beside AUTO-07p: one, and a family of 64 together.

Measured is the processor time of a point of a branch with its Floquet multipliers, in
microseconds, the median of repeats.  Ours has the loosest tolerance with which its orbits
close after a period as well as AUTO's do.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import remanent as rm
from benchmarks import auto07p
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from remanent._typing import FloatArray
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import Curve
from remanent.analysis.orbits.orbit_equations import build_orbit_equations
from remanent.analysis.orbits.stability import floquet_multipliers
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._period_map import StroboscopicMap

#: Step along the branch, with which as many points as AUTO's cover the same part of it.
_STEP = 0.00126
#: Tolerances that are tried, loosest first.
_TOLERANCES = (1e-8, 3e-9, 1e-9, 3e-10, 1e-10, 3e-11)
#: Temperatures of the family, kelvin.
_TEMPERATURES = np.linspace(250.0, 400.0, 8)
#: Prestresses of the family.
_PRESTRESSES = np.linspace(0.0, 1.0, 8)
#: Lowest drive frequency that a branch may reach.
_LOW = 0.6
#: Drive frequency at which branches start.
_HIGH = auto07p.OMEGA
#: Points of the one branch that are predicted and corrected together.
_SINGLE_BLOCK = 32
#: Points of each branch of the family that are predicted and corrected together.
_FAMILY_BLOCK = 16
#: Tolerance of the period map by which orbits are judged.
_JUDGING_TOLERANCE = 1e-13


def measure(plan: Plan) -> dict[str, Any]:
    """Processor time of a point, with its multipliers."""
    single = np.array([[auto07p.TEMPERATURE, 0.0]])
    family = np.stack(np.meshgrid(_TEMPERATURES, _PRESTRESSES), axis=-1).reshape(-1, 2)
    if reason := auto07p.SOURCE.missing():
        plan.say(f"branch: left out, {reason}")
    rows: dict[str, Any] = {}
    with one_core():
        orbits = auto07p.orbits()
        theirs = None if orbits is None else _defect(*orbits)
        tolerance, worst = _loosest(single, theirs)
        for name, cases, block, repeats in (
            ("one", single, _SINGLE_BLOCK, 3 * plan.repeats),
            ("family", family, _FAMILY_BLOCK, plan.repeats),
        ):
            rows[name] = _timed(partial(_traced, cases, block, tolerance), repeats)
            plan.say(f"branch: {name}: {rows[name]['microseconds']:.0f} µs a point")
        seconds = auto07p.seconds_per_point(3 * plan.repeats)
    return {
        **rows,
        "tolerance": tolerance,
        "defect": worst,
        "auto_defect": theirs,
        "auto": None if seconds is None else 1e6 * seconds,
        "auto_version": auto07p.SOURCE.version(),
    }


def _defect(states: FloatArray, omega: FloatArray) -> float:
    """Largest distance between the ends of an orbit of the single branch after a period."""
    ens = lay_out_ensemble(
        rm.Actuator(temperature=auto07p.TEMPERATURE), rm.SineSquared(auto07p.B, _HIGH)
    )
    image = StroboscopicMap(ens, ("omega",), _JUDGING_TOLERANCE).run(states, omega[:, None], 1)
    return float(np.abs(image.state - states).max())


def _loosest(case: FloatArray, theirs: float | None) -> tuple[float, float]:
    """The loosest tolerance with which our orbits close as well as AUTO's, and how well."""
    for tolerance in _TOLERANCES:
        (curve,) = _traced(case, _SINGLE_BLOCK, tolerance)
        worst = _defect(curve.points.unknown[:, :2], curve.points.unknown[:, -1])
        if theirs is None or worst <= theirs:
            return tolerance, worst
    raise RuntimeError("no tolerance is good enough")


def _timed(work: Callable[[], list[Curve]], repeats: int) -> dict[str, Any]:
    """Microseconds of processor time a point, and the largest error of an orbit."""
    work()  # kernels are compiled here
    times, points, worst = [], 0, 0.0
    for _ in range(repeats):
        begin = time.process_time()
        curves = work()
        for curve in curves:
            floquet_multipliers(curve.points.extra_arrays["jacobian"], curve.points.residual_error)
        times.append(time.process_time() - begin)
        points = sum(len(curve.points) for curve in curves)
        worst = max(float((c.points.residual + c.points.residual_error).max()) for c in curves)
    microseconds = 1e6 * statistics.median(times) / points
    return {"microseconds": microseconds, "points": points, "worst": worst, "branches": len(curves)}


def _traced(cases: FloatArray, block: int, tolerance: float) -> list[Curve]:
    """The branch of the smallest orbit of every actuator, down from the highest frequency."""
    ens = lay_out_ensemble(rm.Actuator(), rm.SineSquared(0.4, _HIGH))
    held = ("temperature", "prestress")
    map_ = StroboscopicMap(
        ens, (*held, "omega"), 0.5 * tolerance, undifferentiated_parameter_names=held
    )
    equations = build_orbit_equations(map_, 1)
    scale = np.array([1.0, 1.0, 100.0, 1.0, _HIGH - _LOW])
    rest = np.array([_equilibrium(t / 293.0, s) for t, s in cases])
    guess = np.column_stack([rest, np.zeros(len(cases)), cases, np.full(len(cases), _HIGH)])
    down = np.zeros(guess.shape)
    down[:, -1] = -1.0
    starts, reached = correct_points(equations, guess, down, scale=scale, tolerance=tolerance)
    settings = ContinuationSettings(
        np.array([0.3, -8.0, 0.0, -9.0, _LOW]), np.array([4.0, 8.0, 999.0, 9.0, _HIGH + 1e-9]),
        scale, first_step_length=_STEP, max_step_length=_STEP, tolerance=tolerance,
        points_per_block=block, max_points=auto07p.POINTS, held_unknown_indices=(2, 3),
    )  # fmt: skip
    return continue_curves(equations, starts.subset(reached), settings)


def _equilibrium(theta: float, prestress: float) -> float:
    """Where theta (x - x^-5) = S, by Newton's method from above."""
    roots = np.roots([theta, -prestress, 0.0, 0.0, 0.0, 0.0, -theta])
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(real[real > 0.0][0])
