"""The block with two stretches, viscosity and heat, written out once more from its Lagrangian.

Nothing of the package is used: Lagrange's equations are a linear system that NumPy solves,
and SciPy's DOP853 integrates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from remanent._typing import FloatArray


@dataclass(frozen=True)
class Block:
    """Numbers of one block; state (l1, l1', l2, l2', xi1, xi2 of each branch, theta)."""

    c: float = 1.0
    theta: float = 1.0
    loads: tuple[float, float] = (0.0, 0.0)
    weights: tuple[float, float] = (1.0, 1.0)
    dashpot: float = 0.0
    fluid: float = 0.0
    branches: tuple[tuple[float, float], ...] = ()
    coupling: float = 0.0
    exchange: float = 0.0
    #: Relative change of the remanence per unit of theta.
    alpha: float = 0.0
    m: Callable[[float], float] = field(default=lambda _t: 0.0)
    m_rate: Callable[[float], float] = field(default=lambda _t: 0.0)

    def rates(self, t: float, y: FloatArray) -> FloatArray:
        """Rates of the state."""
        (a, u, b, v), theta = y[:4], y[-1]
        x = 1.0 / (a * b)
        load = self.m(t) * (1.0 + self.alpha * (theta - 1.0))
        slope = np.array([-x / a, -x / b])
        hessian = x * np.array([[2.0 / a**2, 1.0 / (a * b)], [1.0 / (a * b), 2.0 / b**2]])
        rate = np.array([u, v])
        x_rate = slope @ rate
        force = -theta * (np.array([a, b]) + x * slope) + self.loads + load * slope
        e = rate / [a, b]
        force -= self.dashpot * rate + 2.0 * self.fluid * (e + e.sum()) / [a, b]
        lost = self.dashpot * (rate @ rate) + 2.0 * self.fluid * (e @ e + e.sum() ** 2)
        inner, warmed = [], a * u + b * v + x * x_rate  # the latter: of the springs' energy
        for k, (mu, tr) in enumerate(self.branches):
            p, q = y[4 + 2 * k : 6 + 2 * k]
            q1, q2, q3 = (a / p) ** 2, (b / q) ** 2, (x * p * q) ** 2
            force -= theta * mu * (np.array([q1 / a, q2 / b]) + q3 / x * slope)
            flow = theta / (2.0 * tr) * (np.array([q1, q2]) - (q1 + q2 + q3) / 3.0)
            lost += 2.0 * mu * tr * (flow @ flow + flow.sum() ** 2)
            warmed += mu * (
                q1 * (u / a - flow[0]) + q2 * (v / b - flow[1]) + q3 * (x_rate / x + flow.sum())
            )
            inner += [p * flow[0], q * flow[1]]
        mass = np.diag(self.weights) + self.c * np.outer(slope, slope)
        right = 3.0 * force - self.c * slope * (rate @ hessian @ rate)
        acceleration = np.linalg.solve(mass, right)
        in_field = self.alpha * (self.m_rate(t) * x + self.m(t) * x_rate)
        warming = self.coupling * (theta * warmed - theta * in_field + lost)
        warming -= self.exchange * (theta - self.theta)
        if self.coupling == 0.0:
            warming = 0.0
        return np.array([u, acceleration[0], v, acceleration[1], *inner, warming])

    def start(self) -> FloatArray:
        """Rest."""
        return np.array([1.0, 0.0, 1.0, 0.0, *[1.0] * (2 * len(self.branches)), self.theta])

    def run(self, times: FloatArray, start: Any = None, rtol: float = 1e-13) -> FloatArray:
        """States (time, state)."""
        y = self.start() if start is None else np.asarray(start, dtype=float)
        found = solve_ivp(
            self.rates, (0.0, times[-1]), y, method="DOP853", rtol=rtol, atol=1e-15, t_eval=times
        )
        assert found.success, found.message
        return np.asarray(found.y.T)
