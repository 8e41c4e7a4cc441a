"""The period map of [Thermal, eq. 16] by heyoka.py in extended precision, with its Jacobian.

The equation is written out once more, from [Thermal]; of the package only the values of
its own fields are used.  Damping is Rayleigh's, the load a constant plus a wave or the
square of a sine.  The variational equations give the Jacobian, so that Newton's method
finds periodic orbits to 1e-16 without anything of the package.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import SineSquared

#: Extended precision, 64 bits of mantissa on x86.
LONG = np.longdouble
#: Relative error of a step.
PRECISION = 1e-19
#: Steps of Newton's method before it gives up.
MAX_NEWTON_STEPS = 30
#: Size of a Newton step at which it has converged.
CONVERGED = 1e-15
#: Rounding of an image.
IMAGE_ROUNDING = 1e-17
#: Largest Newton step, as a share of the distance of the stretch from zero.
LARGEST_STEP = 0.3


@dataclass(frozen=True)
class Orbit:
    """A fixed point of an iterate of the period map.

    Attributes
    ----------
    state : array (2,)
        Stretch and its rate at phase 0.
    jacobian : array (2, 2)
        Of the iterate there; its eigenvalues are the multipliers.
    """

    state: FloatArray
    jacobian: FloatArray

    @property
    def multipliers(self) -> FloatArray:
        """Eigenvalues of the Jacobian, complex array (2,)."""
        (a, b), (c, d) = self.jacobian
        middle, half = (a + d) / 2, (a - d) / 2
        square = half * half + b * c  # of the distance from the middle, in extended precision
        root = np.sqrt(np.clongdouble(square))
        return np.array([middle + root, middle - root], dtype=np.clongdouble)


@dataclass(frozen=True)
class PeriodMap:
    """States after whole periods of the drive.

    Attributes
    ----------
    drive : SineSquared or Sine
        The kind of load; its numbers are those of `values`.
    values : mapping of name to float
        Fields of actuator and drive as the package takes them, ``dissipation.0.eta`` too.
    """

    drive: Drive
    values: Mapping[str, float]

    @property
    def period(self) -> Any:
        """Of the load, in extended precision."""
        waves = 1 if isinstance(self.drive, SineSquared) else 2
        return waves * np.arctan(LONG(1)) * 4 / LONG(self.values["omega"])

    def image(self, state: Any, periods: int) -> tuple[Any, Any]:
        """A state `periods` later, array (2,), and its derivatives, (2, 2), extended precision."""
        engine = _engine(isinstance(self.drive, SineSquared))
        if not self._advance(engine, [*state, 1, 0, 0, 1], periods):
            return np.full(2, np.nan, dtype=LONG), np.full((2, 2), np.nan, dtype=LONG)
        return engine.state[:2].copy(), engine.state[2:].reshape(2, 2).copy()

    def extremes(self, state: Any, periods: int) -> tuple[float, float]:
        """Smallest and largest thickness stretch over `periods` from a state at phase 0."""
        stretches, engine = _engine_at_rest(isinstance(self.drive, SineSquared))
        stretches[:] = [float(state[0])]
        if not self._advance(engine, list(state), periods):
            return np.nan, np.nan
        stretches.append(float(engine.state[0]))
        return max(stretches) ** -2.0, min(stretches) ** -2.0

    def _advance(self, engine: Any, state: list[Any], periods: int) -> bool:
        """Follow a state from phase 0; whether it arrives."""
        engine.time = LONG(0)
        engine.state[:] = state
        v = self.values
        theta = LONG(v["temperature"]) / LONG(v.get("reference_temperature", 293.0))
        body = [v["c"], theta, v.get("prestress", 0.0), v.get("dissipation.0.eta", 0.0)]
        size = v["b"] if isinstance(self.drive, SineSquared) else v["m"]
        load = [v.get("phase", 0.0), v["omega"], size, v.get("mean", 0.0)]
        engine.pars[:] = [*body, *load][: len(engine.pars)]
        outcome = engine.propagate_until(periods * self.period, max_steps=1_000_000)
        return "time_limit" in str(outcome[0]) and bool(engine.state[0] > 0)

    def orbit(self, start: Any, periods: int) -> Orbit | None:
        """The fixed point that Newton's method finds from `start`; None if it finds none."""
        state = np.asarray(start, dtype=LONG)
        for _ in range(MAX_NEWTON_STEPS):
            image, jacobian = self.image(state, periods)
            if not np.isfinite(image.astype(float)).all():
                return None
            matrix = np.eye(2, dtype=LONG) - jacobian
            step = _solve(matrix, image - state)
            size = float(np.abs(step).max())
            state = state + step * min(1.0, LARGEST_STEP * abs(float(state[0])) / max(size, 1e-300))
            if not state[0] > 0:
                return None
            # Near a bifurcation the rounding of the image moves the point by more.
            columns = [_solve(matrix, unit) for unit in np.eye(2, dtype=LONG)]
            if size < max(CONVERGED, IMAGE_ROUNDING * float(np.abs(columns).max())):
                return Orbit(state, self.image(state, periods)[1])
        return None


def _solve(matrix: Any, vector: Any) -> Any:
    """Cramer's rule: NumPy's solver knows no extended precision."""
    (a, b), (c, d) = matrix
    determinant = a * d - b * c
    if determinant == 0:
        return np.full(2, np.nan, dtype=LONG)
    return np.array([d * vector[0] - b * vector[1], a * vector[1] - c * vector[0]]) / determinant


@cache
def _engine(squared: bool) -> Any:
    """The equation of motion with its variational equations."""
    import heyoka as hy

    _, equations = _equations(squared)
    system = hy.var_ode_sys(equations, hy.var_args.vars, order=1)
    start = np.array([1, 0, 1, 0, 0, 1], dtype=LONG)
    return hy.taylor_adaptive(system, start[:2], fp_type=LONG, tol=LONG(PRECISION))


@cache
def _engine_at_rest(squared: bool) -> tuple[list[float], Any]:
    """A list, and the equation of motion, which adds to it the stretch where its rate is 0."""
    import heyoka as hy

    stretches: list[float] = []

    def add(engine: Any, time: Any, _direction: int) -> None:
        engine.update_d_output(time)
        stretches.append(float(engine.d_output[0]))

    (_, rate), equations = _equations(squared)
    event = hy.nt_event(rate, callback=add, fp_type=LONG)
    start = np.array([1, 0], dtype=LONG)
    engine = hy.taylor_adaptive(
        equations, start, fp_type=LONG, tol=LONG(PRECISION), nt_events=[event]
    )
    return stretches, engine


def _equations(squared: bool) -> tuple[Any, Any]:
    """The variables, stretch and rate, and their equations of motion."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    c, theta, prestress, eta, phase, omega, size, mean = (hy.par[k] for k in range(8))
    sine = size * hy.sin(phase + omega * hy.time)
    m = sine * sine if squared else mean + sine
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + m * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    return (x, v), [(x, v), (v, rate)]
