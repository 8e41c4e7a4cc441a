"""The reference solution: heyoka.py in extended precision, extremes found as events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools import heyoka_batch
from remanent._typing import BoolArray, FloatArray

#: Tolerance of a step in extended precision, whose unit roundoff is 5e-20.
_EXTENDED_TOLERANCE = 1e-18
#: Tolerance of a step in double precision at its best.
_DOUBLE_TOLERANCE = 1e-16
#: Error of double precision at its best above which a motion is left out.
UNRESOLVED = 1e-9


@dataclass(frozen=True)
class Reference:
    """Results for ``job.omegas[job.subset]``.

    Attributes
    ----------
    values : mapping of what is given to array (trajectory, value)
        "extremes", the largest and smallest thickness stretch, and "end", the last one.
    resolved : array (trajectory,) of bool
        Motions that do not magnify the rounding of double precision beyond use.
    """

    values: dict[str, FloatArray]
    resolved: BoolArray

    def error(self, gives: str, values: FloatArray, sample: slice = slice(None)) -> FloatArray:
        """Largest error of each resolved trajectory; NaN where there is no value."""
        difference = np.abs(values - self.values[gives][sample]).max(axis=1)
        return np.asarray(difference[self.resolved[sample]])


def reference(job: Job) -> Reference:
    """Integrate the checked frequencies of a job once more, as well as can be."""
    extended = _extended_precision(job)
    in_double = heyoka_batch.build_end(job)(job.omegas[job.subset], _DOUBLE_TOLERANCE).values
    resolved = np.abs(in_double - extended["end"]).max(axis=1) <= UNRESOLVED
    return Reference(extended, resolved)


def _extended_precision(job: Job) -> dict[str, FloatArray]:
    """Extremes and end of the thickness stretch, arrays (trajectory, value)."""
    import heyoka as hy

    real = np.longdouble
    turning_points: list[Any] = []

    def record(ta: Any, time: Any, _direction: int) -> None:
        ta.update_d_output(time)
        turning_points.append(ta.d_output[0])

    # As the equation has it: with b squared in double, the load would lose digits.
    wave = job.b * hy.sin(hy.par[0] * hy.time)
    v, system = heyoka_batch.equations(job, wave * wave)
    start = np.array([1.0, 0.0], dtype=real)
    events = [hy.nt_event(v, record, fp_type=real)]
    ta = hy.taylor_adaptive(
        system, start, pars=np.ones(1, dtype=real), tol=real(_EXTENDED_TOLERANCE), fp_type=real,
        nt_events=events,
    )  # fmt: skip
    extremes, end = [], []
    for omega in job.omegas[job.subset]:
        turning_points[:] = [real(1.0)]
        ta.time, ta.state[:], ta.pars[0] = real(0.0), start, real(omega)
        ta.propagate_until(real(job.window))
        stretches = thickness_stretch(np.array([*turning_points, ta.state[0]]))
        extremes.append([stretches.max(), stretches.min()])
        end.append([stretches[-1]])
    return {"extremes": np.array(extremes, dtype=float), "end": np.array(end, dtype=float)}
