"""One motion of [Thermal, eq. 16] by heyoka.py in extended precision, with its energies.

The work of the load, the dissipated energy and the integral of the thickness stretch are
integrated with the motion, and so is a difference of the two in-plane stretches, whose equation
is that of :func:`remanent.symmetry_check`, written out once more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from benchmarks.errors.period_map import LONG, PRECISION, PeriodMap

#: Steps of Newton's method for a time.
_TIME_STEPS = 4


@dataclass(frozen=True)
class Motion:
    """The motion from rest, or another state, of a case.

    Attributes
    ----------
    reference : PeriodMap
        With the values of the fields.
    start : tuple of float
        Stretch and rate at tau = 0.
    """

    reference: PeriodMap
    start: tuple[float, float] = (1.0, 0.0)

    def engine(self) -> Any:
        """The integrator at tau = 0."""
        engine, v = _engine(), self.reference.values
        engine.time = LONG(0)
        engine.state[:] = [LONG(self.start[0]), LONG(self.start[1]), 0, 0, 0, 1, 0, 0, 1]
        theta = LONG(v["temperature"]) / LONG(293.0)
        engine.pars[:] = [
            LONG(value) for value in (
                v["c"], theta, v.get("prestress", 0.0), v.get("dissipation.0.eta", 0.0),
                v["omega"], v["b"],
            )
        ]  # fmt: skip
        return engine

    def states(self, times: Any) -> Any:
        """Stretch, rate, work, dissipated energy, integral of the thickness stretch, (time, 5)."""
        engine, rows = self.engine(), []
        for time in times:
            engine.propagate_until(LONG(time))
            rows.append(engine.state[:5].copy())
        return np.array(rows)

    def stored_energy(self, states: Any) -> Any:
        """Kinetic and elastic energy and that of the dead loads, array (time,)."""
        v, (x, rate) = self.reference.values, states[:, :2].T
        theta, thickness_rate = LONG(v["temperature"]) / LONG(293.0), -2 * rate / x**3
        kinetic = (2 * rate**2 + LONG(v["c"]) * thickness_rate**2) / 6
        elastic = theta * (2 * x**2 + x**-4 - 3) / 2
        return kinetic + elastic - 2 * LONG(v.get("prestress", 0.0)) * (x - 1)

    def passages(self, times: Any, value: float) -> tuple[Any, Any]:
        """Times near the given, ascending ones at which the stretch is `value`, and the states."""
        engine, found, states = self.engine(), [], []
        for time in times:
            engine.propagate_until(LONG(time))
            for _ in range(_TIME_STEPS):
                x, rate = engine.state[:2]
                engine.propagate_until(engine.time - (x - LONG(value)) / rate)
            found.append(engine.time)
            states.append(engine.state[:2].copy())
        return np.array(found), np.array(states)

    def transverse_jacobian(self, periods: int) -> Any:
        """Derivatives of a difference of stretches by itself over some drive periods, (2, 2)."""
        engine = self.engine()
        engine.propagate_until(periods * self.reference.period)
        return engine.state[5:].reshape(2, 2).T.copy()


@cache
def _engine() -> Any:
    import heyoka as hy

    x, v, work, lost, mean, a, da, b, db = hy.make_vars(
        "x", "v", "work", "lost", "mean", "a", "da", "b", "db"
    )
    c, theta, prestress, eta, omega, size = (hy.par[k] for k in range(6))
    sine = size * hy.sin(omega * hy.time)
    m = sine * sine
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + m * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    # (x^-2)'' = 6 v^2/x^4 - 2 x''/x^3
    thickness_acceleration = 6.0 * v * v / x4 - 2.0 * rate / (x2 * x)
    stiffness = 3.0 * (theta * (1.0 + 1.0 / (x4 * x2)) - m / x4) + c / x4 * thickness_acceleration

    def part(q: Any, dq: Any) -> Any:
        return -stiffness * q - 3.0 * eta * dq

    system = [
        (x, v), (v, rate), (work, -2.0 * m * v / (x2 * x)), (lost, 2.0 * eta * v * v),
        (mean, 1.0 / x2), (a, da), (da, part(a, da)), (b, db), (db, part(b, db)),
    ]  # fmt: skip
    start = np.array([1, 0, 0, 0, 0, 1, 0, 0, 1], dtype=LONG)
    return hy.taylor_adaptive(system, start, fp_type=LONG, tol=LONG(PRECISION))
