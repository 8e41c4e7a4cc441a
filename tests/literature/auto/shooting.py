"""Periodic orbits and their special points by shooting, in long double.

Independent of AUTO and of the package: heyoka integrates the equation together with its
first and second variations (in the state and in one parameter) at a tolerance of
1e-18, and Newton's method solves for the orbit, and for the condition that makes it
special, to the last digits of long double arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from remanent._typing import FloatArray

TOLERANCE = 1e-18
#: Newton's method may ask for an orbit that never ends; no drive period needs so many.
MOST_STEPS = 300
#: Beyond this an iterate is lost.
LARGEST = 50.0
Real = np.longdouble
#: rates(x, v, phase, parameters) -> (x', v'), derivatives with respect to the phase
#: s in [0, 1] of the drive; parameters are heyoka expressions in the order given.
Rates = Callable[[Any, Any, Any, Sequence[Any]], tuple[Any, Any]]


@dataclass(frozen=True)
class Flow:
    """A forced oscillator of one degree of freedom, with its second-order variations."""

    integrator: Any
    names: tuple[str, ...]
    free: str

    @classmethod
    def build(
        cls, rates: Rates, names: Sequence[str], free: str, *, tolerance: float = TOLERANCE
    ) -> Flow:
        """Compile the equation; `free` is the parameter that varies."""
        x, v = hy.make_vars("x", "v")
        par = [hy.par[i] for i in range(len(names))]
        dx, dv = rates(x, v, hy.time, par)
        system = hy.var_ode_sys([(x, dx), (v, dv)], [x, v, par[list(names).index(free)]], order=2)
        start = np.zeros(2, dtype=Real)
        integrator = hy.taylor_adaptive(
            system, start, tol=Real(tolerance), fp_type=Real, compact_mode=True,
            pars=np.zeros(len(names), dtype=Real),
        )  # fmt: skip
        return cls(integrator, tuple(names), free)

    def jet(self, state: Any, par: Any, end: float = 1.0) -> tuple[Any, Any, Any]:
        """State at phase `end` from phase 0, first (2, 3) and second (2, 3, 3) derivatives.

        The three variables are x, v and the free parameter.
        """
        ta = self.integrator
        ta.time = Real(0)
        fresh = np.zeros(ta.state.shape, dtype=Real)
        fresh[:2] = state
        for i in range(2):
            fresh[ta.get_vslice(order=1, component=i)] = [Real(j == i) for j in range(3)]
        ta.state[:] = fresh
        ta.pars[:] = np.asarray(par, dtype=Real)
        outcome = ta.propagate_until(Real(end), max_steps=MOST_STEPS)[0]
        if outcome != hy.taylor_outcome.time_limit:
            raise ArithmeticError(f"the integration ended with {outcome}")
        value = ta.state[:2].copy()
        first = np.array([ta.state[ta.get_vslice(order=1, component=i)] for i in range(2)])
        second = np.zeros((2, 3, 3), dtype=Real)
        for i in range(2):
            where = ta.get_vslice(order=2, component=i)
            for k in range(where.start, where.stop):
                powers = list(ta.get_mindex(k))[1:]
                a, b = (j for j, power in enumerate(powers) for _ in range(power))
                second[i, a, b] = second[i, b, a] = ta.state[k]
        return value, first, second

    def path(self, state: Any, par: Any, nodes: FloatArray) -> FloatArray:
        """States (node, 2) at the phases `nodes`, the first of which is 0."""
        self.jet(state, par, 0.0)
        states = self.integrator.propagate_grid(nodes.astype(Real))[-1]
        return np.asarray(states[:, :2], dtype=float)


def multipliers(matrix: Any) -> Any:
    """Eigenvalues of a 2 x 2 matrix."""
    trace = matrix[0, 0] + matrix[1, 1]
    det = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
    root = np.sqrt(np.clongdouble(trace * trace / 4 - det))
    return np.array([trace / 2 + root, trace / 2 - root])


def solve(matrix: Any, right: Any) -> Any:
    """Gaussian elimination with row exchanges, which LAPACK has not in long double."""
    a = np.column_stack([matrix, right]).astype(Real)
    n = len(a)
    for k in range(n):
        pivot = k + int(np.argmax(np.abs(a[k:, k])))
        a[[k, pivot]] = a[[pivot, k]]
        a[k] /= a[k, k]
        for i in range(n):
            if i != k:
                a[i] -= a[i, k] * a[k]
    return a[:, -1]


def newton(
    equations: Callable[[Any], tuple[Any, Any]], start: Any, *, iterations: int = 25
) -> tuple[Any, float]:
    """A zero and the size of the last step; equations give residual and Jacobian.

    Raises
    ------
    ArithmeticError
        If steps do not shrink to 1e-13 of the unknowns.
    """
    x = np.array(start, dtype=Real)
    smallest = np.inf
    for _ in range(iterations):
        residual, jacobian = equations(x)
        step = solve(jacobian, residual)
        x = x - step
        size = float(np.max(np.abs(step) / np.maximum(1, np.abs(x))))
        if not np.isfinite(size) or np.max(np.abs(x)) > LARGEST:
            break
        if size < 1e-15 and size >= smallest / 4:
            return x, size
        smallest = min(size, smallest)
    if smallest < 1e-13:
        return x, smallest
    raise ArithmeticError(f"Newton's method stalled at a step of {smallest:.1e}")


def orbit(
    flow: Flow, par: Any, start: Any, *, period: int = 1, iterations: int = 25
) -> tuple[Any, Any, float]:
    """Initial state, Jacobian of the map and last step of Newton's method."""

    def equations(x: Any) -> tuple[Any, Any]:
        value, first, _ = flow.jet(x, par, period)
        return value - x, first[:, :2] - np.eye(2)

    state, step = newton(equations, start, iterations=iterations)
    return state, flow.jet(state, par, period)[1][:, :2], step


def special(
    flow: Flow, par: Any, start: Any, kind: str, *, period: float = 1.0, image: int = 1
) -> tuple[Any, Any, Any, float]:
    """Locate a fold ("LP"), a period doubling ("PD") or a torus point ("TR").

    With period 1/2 and image -1, of the map -P_half whose square is the period map, where
    the equation has the symmetry (x, s) -> (-x, s + 1/2): what doubles there loses the
    symmetry.

    Returns
    -------
    free parameter, initial state, multipliers, last step of Newton's method
    """
    index = _free(flow)

    def equations(z: Any) -> tuple[Any, Any]:
        jet = flow.jet(z[:2], _with(par, index, z[2]), period)
        value, first, second = (image * part for part in jet)
        d, change = first[:, :2], second[:, :2, :]
        trace, dtrace = d[0, 0] + d[1, 1], change[0, 0] + change[1, 1]
        det = d[0, 0] * d[1, 1] - d[0, 1] * d[1, 0]
        ddet = (change[0, 0] * d[1, 1] + d[0, 0] * change[1, 1]) - (
            change[0, 1] * d[1, 0] + d[0, 1] * change[1, 0]
        )
        tests = {
            "LP": (1 - trace + det, ddet - dtrace),
            "PD": (1 + trace + det, ddet + dtrace),
            "TR": (det - 1, ddet),
        }
        extra, row = tests[kind]
        jacobian = np.vstack([first - np.eye(2, 3), row])
        return np.array([*(value - z[:2]), extra]), jacobian

    z, step = newton(equations, [*start, par[index]])
    matrix = flow.jet(z[:2], _with(par, index, z[2]), max(1.0, period))[1]
    return z[2], z[:2], multipliers(matrix), step


#: What vanishes in the Jacobian of the map over half a period, for orbits symmetric in time.
HALF = {"LP": (1, 0), "BP": (0, 1), "PD": (0, 0), "PD*": (1, 1)}


def symmetric_special(flow: Flow, par: Any, stretch: Any, kind: str) -> tuple[Any, Any, Any, float]:
    """The same for an orbit at rest at phases 0 and 1/2 of a drive even in time, undamped.

    The map over a period is R A^-1 R A with A the Jacobian over half of it and R the
    reversal of the rate, so its trace is 2 + 4 A01 A10 / det A = -2 + 4 A00 A11 / det A: a
    fold has A10 = 0, a loss of symmetry ("BP") A01 = 0, a period doubling A00 = 0 or
    A11 = 0. Unlike the general conditions these are regular.
    """
    index = _free(flow)
    i, j = HALF[kind]

    def equations(z: Any) -> tuple[Any, Any]:
        value, first, second = flow.jet([z[0], 0], _with(par, index, z[1]), 0.5)
        rows = np.vstack([first[1, [0, 2]], second[i, j][[0, 2]]])
        return np.array([value[1], first[i, j]]), rows

    z, step = newton(equations, [stretch, par[index]])
    matrix = flow.jet([z[0], 0], _with(par, index, z[1]))[1]
    return z[1], np.array([z[0], Real(0)]), multipliers(matrix), step


def _with(par: Any, index: int, value: Any) -> Any:
    changed = np.array(par, dtype=Real)
    changed[index] = value
    return changed


def _free(flow: Flow) -> int:
    return flow.names.index(flow.free)
