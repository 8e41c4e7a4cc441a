"""What a point of a branch of periodic orbits costs AUTO-07p; None where it is missing.

The branch is the undamped actuator's (theta = 350/293, S = 0, b = 0.4, c = 1), 500 points
over omega down from 1.6, on 60 intervals with 4 collocation points, tolerance 1e-8,
multipliers at every point, folds, branch points and doublings watched, nothing stored.

The form is AUTO's fastest of those tried: the phase of the load as a third state of a
boundary-value problem with multipliers (IPS = 7), in half the time of four states with an
oscillator that makes the load (IPS = 2); derivatives by hand; the mesh adapted every tenth
step; one Newton iteration a point with a new Jacobian, then chords (NWTN = 1). The
multipliers, made from that Jacobian, are then good to 1e-4; `NWTN=3` makes them as good as
the orbit in 1.6 times the time.
"""

from __future__ import annotations

import resource
import statistics
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.jobs import REFERENCE_TEMPERATURE
from remanent._typing import FloatArray
from tests.literature.auto import runner

#: Points of the branch.
POINTS = 500
#: Temperature, kelvin.
TEMPERATURE = 350.0
#: Temperature over that of the reference configuration.
THETA = TEMPERATURE / REFERENCE_TEMPERATURE
#: Root of the peak load.
B = 0.4
#: Drive frequency at which the branch starts.
OMEGA = 1.6
#: Stretch at phase 0 of the orbit it starts from, whose rate is 0 there.
STRETCH = 0.9649531659050434
#: One orbit of so many is stored to see how well it closes.
_STORED = 5
#: AUTO's constants, under its own names.
CONSTANTS: dict[str, Any] = {
    "ICP": [1], "NTST": 60, "NCOL": 4, "EPSL": 1e-8, "EPSU": 1e-8, "EPSS": 1e-6,
    "NMX": POINTS, "NPR": POINTS, "DS": -0.002, "DSMAX": 0.004, "ITNW": 7, "NWTN": 1,
    "IAD": 10, "IID": 0, "SP": ["TR0"], "UZSTOP": {}, "dat": "start",
}  # fmt: skip


class Auto:
    """AUTO-07p's object files with a Fortran compiler, as a source of a tool."""

    def missing(self) -> str:
        if runner.installed():
            return ""
        return (
            "AUTO-07p or gfortran is not installed; "
            "install both with `apt install auto-07p gfortran` on Debian or Ubuntu"
        )

    def version(self) -> str:
        return f"AUTO-07p {runner.AUTO_VERSION} (Debian), gfortran -O3"


SOURCE = Auto()


def seconds_per_point(repeats: int = 3, **changes: Any) -> float | None:
    """Processor time of one point, the median of runs, with AUTO's start and its files.

    Parameters
    ----------
    repeats
        Number of runs.
    **changes
        Constants of AUTO that differ from :data:`CONSTANTS`.
    """
    if not runner.installed():
        return None
    with tempfile.TemporaryDirectory() as scratch:
        executable = runner.compile_equations("actuator", Path(scratch))
        _start(Path(scratch))
        return statistics.median(_timed(executable, **changes) for _ in range(repeats))


def orbits() -> tuple[FloatArray, FloatArray] | None:
    """Every fifth of its orbits: states at phase 0, array (point, 2), and frequencies."""
    if not runner.installed():
        return None
    with tempfile.TemporaryDirectory() as scratch:
        executable = runner.compile_equations("actuator", Path(scratch))
        _start(Path(scratch))
        stored = runner.run(executable, "actuator", **{**CONSTANTS, "NPR": _STORED}).solutions
    return np.array([orbit.u[0, :2] for orbit in stored]), np.array([o.par[0] for o in stored])


def _timed(executable: Path, **changes: Any) -> float:
    """Processor time of a point in one run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = runner.run(executable, "actuator", **{**CONSTANTS, **changes})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.points != POINTS:
        raise RuntimeError(f"AUTO stopped after {run.points} of {POINTS} points")
    spent = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return spent / POINTS


def _start(directory: Path) -> None:
    """The orbit that AUTO starts from."""

    def rates(s: float, y: Any) -> list[float]:
        x, v = y.tolist()
        m = (B * np.sin(np.pi * s)) ** 2
        rate = (6 * v * v - 3 * (THETA * (x**8 - x * x) + m * x**4)) / (x**7 + 2 * x)
        return [np.pi / OMEGA * v, np.pi / OMEGA * rate]

    s = np.linspace(0.0, 1.0, 401)
    path = solve_ivp(rates, (0.0, 1.0), [STRETCH, 0.0], method="DOP853", t_eval=s,
                     rtol=1e-12, atol=1e-12).y  # fmt: skip
    runner.write_start(directory, (OMEGA, THETA, 0.0, B, 1.0, 0.0), np.column_stack([s, *path, s]))


if __name__ == "__main__":
    cost = seconds_per_point()
    print(SOURCE.missing() if cost is None else f"{SOURCE.version()}: {1e3 * cost:.3f} ms a point")
