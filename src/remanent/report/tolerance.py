"""The story of the tolerance: the same motions, converged and at ode45's defaults."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

from remanent._typing import FloatArray
from remanent.models.drives.waves import Constant
from remanent.report.evidence import CASE_VALUES, ClaimEvidence
from remanent.report.settings import MOTION_FREQUENCIES, PRESTRESSES, TEMPERATURES, Setting
from remanent.results import build, provenance
from remanent.studies.motion.simulate import simulate

#: MATLAB's default relative tolerance of ode45.
ODE45_RELATIVE_TOLERANCE = 1e-3
#: MATLAB's default absolute tolerance of ode45.
ODE45_ABSOLUTE_TOLERANCE = 1e-6
#: How the two solvers are called in figures.
SOLVER_NAMES = ("converged", "ode45 defaults")
#: Length of the runs whose energy is followed, tau.
_ENERGY_DURATION = 500.0
#: Times at which their energy is taken.
_ENERGY_TIME_COUNT = 1001
#: Tolerance of the converged one of these runs.
_CONVERGED_TOLERANCE = 1e-11
#: Drive periods of sections by both solvers, of which one is slow.
_SECTION_DRIVE_PERIODS = 500


def ode45_states(
    setting: Setting,
    temperature: float,
    prestress: float,
    load: Callable[[float], float],
    times: FloatArray,
) -> FloatArray:
    """States (time, 2) from rest, as a script at default tolerances gives them.

    SciPy's RK45 is the same Dormand-Prince 5(4) pair as ode45, with a step controller
    of its own: alike in kind, not dot for dot.

    Parameters
    ----------
    setting : Setting
        A choice of what [Thermal] leaves unstated.
    temperature, prestress : float
        Of the case, in kelvin, and dimensionless.
    load : callable
        The magnetic load m at a time.
    times : array (time,)
        When states are taken; the run ends at the last.
    """
    theta = temperature / setting.reference_temperature

    def equation_16(tau: float, y: FloatArray) -> tuple[float, float]:
        x, v = y.tolist()
        force = theta * (x - x**-5) - prestress + load(tau) * x**-3
        return v, (6.0 * v * v / x**7 - 3.0 * force) / (1.0 + 2.0 / x**6)

    solved = solve_ivp(
        equation_16, (0.0, float(times[-1])), [1.0, 0.0], method="RK45", t_eval=times,
        rtol=ODE45_RELATIVE_TOLERANCE, atol=ODE45_ABSOLUTE_TOLERANCE,
    )  # fmt: skip
    return np.asarray(solved.y.T)


def _sine_squared_load(b: float, omega: float, tau: float) -> float:
    """m = (b sin ωτ)², the reference law."""
    return (b * math.sin(omega * tau)) ** 2


def sections_by_solver(evidence: ClaimEvidence) -> xr.Dataset:
    """Sections of the six motions by both solvers, at every second drive period.

    Returns
    -------
    xarray.Dataset
        ``thickness_stretch``, ``thickness_stretch_rate`` (solver, prestress,
        temperature, period), ``omega`` (prestress).
    """
    converged = evidence.section.sel(period=slice(0, _SECTION_DRIVE_PERIODS, 2))
    shape = (len(PRESTRESSES), len(TEMPERATURES), converged.sizes["period"], 2)
    script = np.empty(shape)
    for (i, s), (j, t) in product(enumerate(PRESTRESSES), enumerate(TEMPERATURES)):
        times = converged["period"].values * (math.pi / MOTION_FREQUENCIES[i])
        load = partial(_sine_squared_load, evidence.setting.b, MOTION_FREQUENCIES[i])
        script[i, j] = ode45_states(evidence.setting, t, s, load, times)
    both = _stack_solvers(converged, script)
    omega = build.dataset({}, {"omega": (("prestress",), np.array(MOTION_FREQUENCIES))}, {})
    return both.assign_coords(omega=omega["omega"])


def energy_drift_by_solver(setting: Setting) -> xr.Dataset:
    """Energy minus its first value over a long run under constant load, both solvers.

    Returns
    -------
    xarray.Dataset
        ``energy_drift`` (solver, prestress, temperature, time).
    """
    drive = Constant(setting.b**2)
    times = np.linspace(0.0, _ENERGY_DURATION, _ENERGY_TIME_COUNT)
    converged = simulate(
        setting.actuator, drive, times=times, over=CASE_VALUES, tolerance=_CONVERGED_TOLERANCE
    )
    energy = np.empty((2, len(PRESTRESSES), len(TEMPERATURES), _ENERGY_TIME_COUNT))
    energy[0] = converged["energy"].values
    for (i, s), (j, t) in product(enumerate(PRESTRESSES), enumerate(TEMPERATURES)):
        x, v = ode45_states(setting, t, s, lambda _: drive.m, times).T
        theta = t / setting.reference_temperature
        energy[1, i, j] = (
            (1.0 + 2.0 / x**6) * v**2 / 3.0
            + theta * (2.0 * x**2 + x**-4 - 3.0) / 2.0
            - 2.0 * s * (x - 1.0)
            - drive.m / x**2
        )
    dims = ("solver", "prestress", "temperature", "time")
    return build.dataset(
        {"energy_drift": (dims, energy - energy[..., :1])},
        {
            "solver": (("solver",), np.array(SOLVER_NAMES)),
            "prestress": (("prestress",), np.array(PRESTRESSES)),
            "temperature": (("temperature",), np.array(TEMPERATURES)),
            "time": (("time",), times),
        },
        provenance.attributes(
            setting.actuator,
            drive,
            _CONVERGED_TOLERANCE,
            over=CASE_VALUES,
            duration=_ENERGY_DURATION,
        ),
    )


def _stack_solvers(converged: xr.Dataset, script: FloatArray) -> xr.Dataset:
    """Both solvers' sections in one Dataset."""
    dims = ("solver", "prestress", "temperature", "period")
    x, v = script[..., 0], script[..., 1]
    ours = [converged[n].transpose(*dims[1:]).values for n in
            ("thickness_stretch", "thickness_stretch_rate")]  # fmt: skip
    return build.dataset(
        {
            "thickness_stretch": (dims, np.stack([ours[0], x**-2])),
            "thickness_stretch_rate": (dims, np.stack([ours[1], -2.0 * v * x**-3])),
        },
        {
            "solver": (("solver",), np.array(SOLVER_NAMES)),
            **{n: ((n,), converged[n].values) for n in dims[1:]},
        },
        converged.attrs,
    )
