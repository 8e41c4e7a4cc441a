"""The double well x'' + delta x' - x + x^3 = m cos(omega tau) for every tool, in its best form.

Each tool gives the states of many motions at a time, and the largest Lyapunov exponents of many
motions from the mean growth of a tangent vector, which is scaled back after every drive period.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from benchmarks.tools import diffrax_vmap, heyoka_batch, pynamicalsys_rk45
from benchmarks.tools.tool import Source
from remanent._typing import FloatArray

#: Damping of the double well.
DELTA = 0.15
#: In the right one of the two wells, at rest.
REST = (1.0, 0.0)
#: Motions that diffrax steps together.
_GROUP = 256
#: Steps after which diffrax gives up: never here.
_MAX_STEPS = 1_000_000

#: ``ends(omega, m, starts, times, tolerance)``: states (trajectory, 2).
Ends = Callable[[FloatArray, FloatArray, FloatArray, FloatArray, float], FloatArray]
#: ``exponents(omega, m, periods, tolerance)``: array (trajectory,).
Exponents = Callable[[FloatArray, FloatArray, int, float], FloatArray]


@dataclass(frozen=True)
class Peer:
    """A tool on the double well.

    Attributes
    ----------
    name
        In results.
    source
        Where it comes from.
    build_ends, build_exponents
        Write the work for it.
    sample
        How many motions it is timed on at most; 0 for all.
    """

    name: str
    source: Source
    build_ends: Callable[[], Ends]
    build_exponents: Callable[[], Exponents]
    sample: int = 0


# heyoka.py ------------------------------------------------------------------------------


def _heyoka_system(*, with_tangent: bool) -> list[Any]:
    import heyoka as hy

    x, v, p, q = hy.make_vars("x", "v", "p", "q")
    load = hy.par[1] * hy.cos(hy.par[0] * hy.time)
    square = x * x
    system = [(x, v), (v, load - DELTA * v + x * (1.0 - square))]
    if with_tangent:
        system += [(p, q), (q, (1.0 - 3.0 * square) * p - DELTA * q)]
    return system


@cache
def _heyoka_integrator(tolerance: float, form: heyoka_batch.Form, with_tangent: bool) -> Any:
    system = _heyoka_system(with_tangent=with_tangent)
    start = [*REST, 1.0, 0.0][: len(system)]
    return heyoka_batch.batch_integrator(system, start, tolerance, form, parameter_count=2)


def heyoka_ends(form: heyoka_batch.Form) -> Ends:
    """States by Taylor series, several motions in the lanes of a vector."""

    def ends(
        omega: FloatArray, m: FloatArray, starts: FloatArray, times: FloatArray, tolerance: float
    ) -> FloatArray:
        ta = _heyoka_integrator(tolerance, form, False)
        result = np.empty((omega.size, 2))
        for rows in _groups(omega.size, form.lanes):
            ta.set_time(0.0)
            ta.state[:], ta.pars[0], ta.pars[1] = starts[rows].T, omega[rows], m[rows]
            ta.propagate_until(times[rows].tolist())
            result[rows] = ta.state.T
        return result

    return ends


def heyoka_exponents(form: heyoka_batch.Form) -> Exponents:
    """Exponents with the tangent vector as two further states."""

    def exponents(omega: FloatArray, m: FloatArray, periods: int, tolerance: float) -> FloatArray:
        ta = _heyoka_integrator(tolerance, form, True)
        result = np.empty(omega.size)
        for rows in _groups(omega.size, form.lanes):
            period, growth = 2.0 * np.pi / omega[rows], np.zeros(form.lanes)
            ta.set_time(0.0)
            ta.state[:] = np.array([*REST, 1.0, 0.0])[:, None]
            ta.pars[0], ta.pars[1] = omega[rows], m[rows]
            for n in range(1, periods + 1):
                ta.propagate_until((n * period).tolist())
                length = np.hypot(ta.state[2], ta.state[3])
                growth += np.log(length)
                ta.state[2:] /= length
            result[rows] = growth / (periods * period)
        return result

    return exponents


def _groups(count: int, size: int) -> list[Any]:
    """Rows of each group; the last group repeats its last row."""
    padded = np.minimum(np.arange(-(-count // size) * size), count - 1)
    return list(padded.reshape(-1, size))


# diffrax --------------------------------------------------------------------------------


def _diffrax_solver() -> Any:
    """``solve(state, begin, end, omega, m, tolerance)`` for one motion, with or without tangent."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def rates(tau: Any, y: Any, p: Any) -> Any:
        x, v = y[0], y[1]
        square = x * x
        motion = (v, p[1] * jnp.cos(p[0] * tau) - DELTA * v + x * (1.0 - square))
        if len(y) == 2:
            return motion
        return (*motion, y[3], (1.0 - 3.0 * square) * y[2] - DELTA * y[3])

    def solve(state: Any, begin: Any, end: Any, p: Any, tolerance: Any) -> Any:
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), diffrax.Dopri8(), begin, end, None, state, p,
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            saveat=diffrax.SaveAt(t1=True), max_steps=_MAX_STEPS, throw=False,
        )  # fmt: skip
        return tuple(one[-1] for one in solution.ys)

    return solve


def diffrax_ends() -> Ends:
    """States by Dopri8 through jit and vmap, in groups of neighbours."""
    import jax
    import jax.numpy as jnp

    solve = _diffrax_solver()

    def end(omega: Any, m: Any, start: Any, time: Any, tolerance: Any) -> Any:
        return jnp.stack(solve((start[0], start[1]), 0.0, time, (omega, m), tolerance))

    batch = jax.jit(jax.vmap(end, in_axes=(0, 0, 0, 0, None)))

    def ends(
        omega: FloatArray, m: FloatArray, starts: FloatArray, times: FloatArray, tolerance: float
    ) -> FloatArray:
        result = np.empty((omega.size, 2))
        for rows in _groups(omega.size, min(_GROUP, omega.size)):
            result[rows] = batch(omega[rows], m[rows], starts[rows], times[rows], tolerance)
        return result

    return ends


def diffrax_exponents() -> Exponents:
    """Exponents with the tangent vector as two further states, all periods in one loop of JAX."""
    import jax
    import jax.numpy as jnp

    solve = _diffrax_solver()

    def exponent(omega: Any, m: Any, tolerance: Any, periods: int) -> Any:
        period = 2.0 * jnp.pi / omega

        def advance(carry: Any, n: Any) -> Any:
            state, growth = carry
            x, v, p, q = solve(state, n * period, (n + 1.0) * period, (omega, m), tolerance)
            length = jnp.hypot(p, q)
            return ((x, v, p / length, q / length), growth + jnp.log(length)), None

        begin = (*map(jnp.asarray, (*REST, 1.0, 0.0)),)
        (_, growth), _ = jax.lax.scan(advance, (begin, 0.0), jnp.arange(float(periods)))
        return growth / (periods * period)

    batch = jax.jit(jax.vmap(exponent, in_axes=(0, 0, None, None)), static_argnums=3)

    def exponents(omega: FloatArray, m: FloatArray, periods: int, tolerance: float) -> FloatArray:
        result = np.empty(omega.size)
        for rows in _groups(omega.size, min(_GROUP, omega.size)):
            result[rows] = batch(omega[rows], m[rows], tolerance, periods)
        return result

    return exponents


# pynamicalsys ---------------------------------------------------------------------------


@cache
def _pynamicalsys_system() -> Any:
    import numba
    from pynamicalsys import ContinuousDynamicalSystem

    @numba.njit(fastmath={"contract"})  # type: ignore[untyped-decorator,unused-ignore]
    def rates(tau: float, u: Any, p: Any) -> Any:
        x, v = u[0], u[1]
        return np.array([v, p[1] * np.cos(p[0] * tau) - DELTA * v + x * (1.0 - x * x)])

    @numba.njit(fastmath={"contract"})  # type: ignore[untyped-decorator,unused-ignore]
    def jacobian(_tau: float, u: Any, _p: Any) -> Any:
        out = np.zeros((2, 2))
        out[0, 1], out[1, 0], out[1, 1] = 1.0, 1.0 - 3.0 * u[0] * u[0], -DELTA
        return out

    return ContinuousDynamicalSystem(
        equations_of_motion=rates, jacobian=jacobian, system_dimension=2, number_of_parameters=2
    )


def pynamicalsys_ends() -> Ends:
    """States by an adaptive Runge-Kutta pair, one motion after another."""
    system = _pynamicalsys_system()

    def ends(
        omega: FloatArray, m: FloatArray, starts: FloatArray, times: FloatArray, tolerance: float
    ) -> FloatArray:
        system.integrator("rk45", atol=tolerance, rtol=tolerance)
        rows = zip(omega, m, starts, times, strict=True)
        return np.array([
            system.trajectory(start, float(time), parameters=[w, strength])[-1, 1:]
            for w, strength, start, time in rows
        ])  # fmt: skip

    return ends


def pynamicalsys_exponents() -> Exponents:
    """Exponents by its own function."""
    system = _pynamicalsys_system()

    def exponents(omega: FloatArray, m: FloatArray, periods: int, tolerance: float) -> FloatArray:
        system.integrator("rk45", atol=tolerance, rtol=tolerance)
        return np.array([
            np.ravel(system.lyapunov(
                list(REST), periods * 2.0 * np.pi / w, parameters=[w, strength], num_exponents=1
            ))[0]
            for w, strength in zip(omega, m, strict=True)
        ])  # fmt: skip

    return exponents


def peers() -> list[Peer]:
    """Every tool, heyoka.py in each of its forms."""
    forms = [
        Peer(
            f"heyoka.py, {form.lanes} lanes{', compact' if form.compact_mode else ''}",
            heyoka_batch.PACKAGE,
            lambda form=form: heyoka_ends(form),  # type: ignore[misc]
            lambda form=form: heyoka_exponents(form),  # type: ignore[misc]
            sample=1024,
        )
        for form in heyoka_batch.FORMS
    ]
    diffrax = Peer(
        "diffrax Dopri8, vmap", diffrax_vmap.TOOL.source, diffrax_ends, diffrax_exponents, _GROUP
    )
    pynamicalsys = Peer(
        "pynamicalsys rk45",
        pynamicalsys_rk45.TOOL.source,
        pynamicalsys_ends,
        pynamicalsys_exponents,
        sample=8,
    )
    return [*forms, diffrax, pynamicalsys]
