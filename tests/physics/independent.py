"""Equation 16 by somebody else's integrators: SciPy's DOP853, heyoka's Taylor series.

The equation is written out here once more, from [Thermal], so that nothing of the
package but the drive's own load m(tau) is used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.drives.chirp import Chirp
from remanent.models.drives.piecewise import PiecewiseDrive, Ramp, Sampled, Steps
from remanent.models.drives.waves import Constant, Sine, SineSquared


@dataclass(frozen=True)
class Case:
    """Numbers of some actuators, arrays (case,), under one drive."""

    c: FloatArray
    theta: FloatArray
    prestress: FloatArray
    drive: Drive

    def acceleration(self, m: Any, x: Any, v: Any) -> Any:
        """Equation 16 solved for the acceleration."""
        r = 1.0 / x
        r3 = r * r * r
        force = self.theta * (x - r3 * r * r) - self.prestress + m * r3
        inertia = 1.0 + 2.0 * self.c * r3 * r3
        return (6.0 * self.c * r3 * r3 * r * v * v - 3.0 * force) / inertia


def random_drive(kind: type[Drive], rng: np.random.Generator, duration: float) -> Drive:
    """A drive of some kind with loads of up to 3."""
    inner = np.sort(rng.uniform(0.05, 0.95, 5)) * duration
    times, even = np.concatenate([[0.0], inner]), np.linspace(0.0, duration, 13)
    u = rng.uniform
    makers: dict[type[Drive], Callable[[], Drive]] = {
        Constant: lambda: Constant(u(-3, 3)),
        SineSquared: lambda: SineSquared(u(0.2, 1.7), u(0.4, 4), u(0, 6)),
        Sine: lambda: Sine(u(-2, 2), u(0.4, 5), u(-1, 1), u(0, 6)),
        Steps: lambda: Steps(times, u(-3, 3, 6)),
        Ramp: lambda: Ramp(times, u(-3, 3, 6)),
        Sampled: lambda: Sampled(even, u(-1.5, 1.5, 13)),
        Chirp: lambda: Chirp(u(-2, 2), u(0.2, 2), u(2, 5), duration * u(0.5, 1.2), u(-1, 1)),
    }
    return makers[kind]()


DRIVES: tuple[type[Drive], ...] = (Constant, SineSquared, Sine, Steps, Ramp, Sampled, Chirp)


def random_case(kind: type[Drive], decade: int, count: int, duration: float, seed: int) -> Case:
    """Actuators with c in [10**decade, 10**(decade + 1)], theta 0.5 to 2, S -1 to 3."""
    rng = np.random.default_rng([seed, decade + 10, DRIVES.index(kind)])
    return Case(
        c=10.0 ** rng.uniform(decade, decade + 1, count),
        theta=rng.uniform(0.5, 2.0, count),
        prestress=rng.uniform(-1.0, 3.0, count),
        drive=random_drive(kind, rng, duration),
    )


def corners(drive: Drive, duration: float) -> list[float]:
    """Instants between which the load is smooth, ends included."""
    inner = list(drive.times) if isinstance(drive, PiecewiseDrive) else []
    if isinstance(drive, Chirp):
        inner = [drive.duration]
    return [0.0, *(t for t in inner if 0.0 < t < duration), duration]


def smooth_load(drive: Drive, begin: float) -> Callable[[float], float]:
    """The load from `begin` to the next corner, as one smooth function of time."""
    if not isinstance(drive, PiecewiseDrive):
        return lambda t: float(drive(t))
    piece = int(np.searchsorted(drive.times, begin, side="right")) - 1
    a0, a1, a2, a3 = drive.piece_coefficients()[:, piece].tolist()
    start = drive.times[piece]
    return lambda t: a0 + (t - start) * (a1 + (t - start) * (a2 + (t - start) * a3))


def dop853(case: Case, times: FloatArray, rtol: float) -> FloatArray:
    """States (case, time, 2) from rest, all cases in one system of equations."""
    count = case.c.size
    y = np.concatenate([np.ones(count), np.zeros(count)])
    states = np.full((count, times.size, 2), np.nan)
    marks = corners(case.drive, float(times[-1]))
    for begin, end in pairwise(marks):
        inside = (times >= begin) & (times <= end)
        asked = np.unique(np.concatenate([[begin], times[inside], [end]]))
        load = smooth_load(case.drive, begin)

        def rates(t: float, z: FloatArray, load: Callable[[float], float] = load) -> FloatArray:
            return np.concatenate([z[count:], case.acceleration(load(t), z[:count], z[count:])])

        found = solve_ivp(
            rates, (begin, end), y, method="DOP853", rtol=rtol, atol=1e-16, t_eval=asked
        )
        assert found.success, found.message
        rows = np.isin(asked, times[inside])
        states[:, inside, 0] = found.y[:count, rows]
        states[:, inside, 1] = found.y[count:, rows]
        y = found.y[:, -1]
    return states
