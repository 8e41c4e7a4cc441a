"""A system of one's own, the double well, beside heyoka.py, diffrax and pynamicalsys.

Measured is processor time per trajectory and unit of time, in microseconds, medians of runs in
which tools take turns.  Responses: every tool has the loosest tolerance with which its own
results are within 1e-8; ours gives the extremes of the motion, with their error and, at one
resolution, without, the others its last state.  Exponents: every tool has the loosest tolerance
with which one drive period from 64 states on such motions ends within 1e-7; the verb runs
everything once more with steps twice as long, to give the error, and is timed without that too.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

import remanent as rm
from benchmarks.accuracy import LIMIT
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from benchmarks.tools import ours as ours_on_actuators
from benchmarks.tools.double_well import DELTA, REST, Peer, peers
from benchmarks.tools.tool import TOLERANCES
from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.lyapunov import lyapunov_exponents
from remanent.integrate.ensemble.ensemble import integrate_without_error_bound
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.maps.period_map import PeriodMap
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.regimes._follower import EnsembleFollower

_WELL = rm.LagrangianSystem.example().replace(parameters={"delta": DELTA}, rest={"x": REST[0]})
#: The load m cos(omega tau).
_DRIVE = rm.Sine(0.05, 1.0, phase=np.pi / 2.0)
#: Length of the motions of a response.
_WINDOW = 100.0
#: Frequencies of a response.
_RESPONSE_OMEGA = (0.5, 2.0)
#: How many, and in a quick run.
_COUNT, _QUICK_COUNT = 8192, 1024
#: Frequencies on which errors are measured.
_CHECKED = 64
#: Frequencies and loads of the map of exponents.
_OMEGA, _M = (0.8, 1.6), (0.05, 0.45)
#: Points along each side of the map, and in a quick run.
_SIDE, _QUICK_SIDE = 128, 24
#: Drive periods over which exponents are averaged.
_PERIODS = 500
#: Largest error of the state after one period that a tolerance may give.
_PERIOD_LIMIT = 1e-7
#: States from which that period starts, and drive periods from rest after which they are taken.
_STARTS, _PERIODS_TO_STARTS = 64, 5
#: Tolerances of SciPy as the reference.
_REFERENCE_RTOL, _REFERENCE_ATOL = 1e-13, 1e-15
#: Ours, in results: the verb, and the motion at one resolution for all without a bound.
_OURS, _OURS_FIXED = "remanent", "remanent, one resolution, no bound"
#: Ours without the second run, by which exponents have their error.
_OURS_ONCE = "remanent, once"


@dataclass(frozen=True)
class _Prepared:
    """A tool at its setting: how to run it, and over how many trajectories and units of time."""

    run: Callable[[], object]
    amount: float
    setting: float
    worst: float
    limit: float
    setting_name: str = "tolerance"


def measure_response(plan: Plan) -> dict[str, Any]:
    """Frequency responses in the right well."""
    omega = np.linspace(*_RESPONSE_OMEGA, _QUICK_COUNT if plan.quick else _COUNT)
    sample = omega[:: omega.size // _CHECKED]
    exact = _reference_motions(sample)
    ends, extremes = exact[:, :2], exact[:, 2:]

    def ours(omega: FloatArray, tolerance: float) -> FloatArray:
        found = rm.frequency_response(
            _WELL, _DRIVE, omega, duration=_WINDOW, tolerance=tolerance, resonance_width=10.0
        )
        return np.column_stack([found.maximum.values, found.minimum.values])

    def theirs(peer: Peer) -> Callable[[FloatArray, float], FloatArray]:
        compute = peer.build_ends()

        def run(omega: FloatArray, tolerance: float) -> FloatArray:
            count = omega.size
            return compute(
                omega, np.full(count, _DRIVE.m), np.tile(REST, (count, 1)),
                np.full(count, _WINDOW), tolerance,
            )  # fmt: skip

        return run

    def prepared(
        run: Callable[[FloatArray, float], FloatArray],
        exact: FloatArray,
        most: int = 0,
        settings: Sequence[float] = TOLERANCES,
        setting_name: str = "tolerance",
    ) -> _Prepared:
        setting, worst = _loosest(lambda s: np.abs(run(sample, s) - exact).max(), LIMIT, settings)
        timed = omega[:: max(1, omega.size // most)] if most else omega
        amount = timed.size * _WINDOW
        return _Prepared(lambda: run(timed, setting), amount, setting, worst, LIMIT, setting_name)

    with one_core():
        tools = {
            _OURS: prepared(ours, extremes),
            _OURS_FIXED: prepared(
                _without_bound,
                extremes,
                settings=ours_on_actuators.FIXED.settings,
                setting_name=ours_on_actuators.FIXED.setting_name,
            ),
        }
        for peer in _present(plan):
            tools[peer.name] = prepared(theirs(peer), ends, peer.sample)
        return {"tools": _measured(plan, "response", tools), "trajectories": omega.size}


def _without_bound(omega: FloatArray, resolution: float) -> FloatArray:
    """Extremes at one resolution for all, without the coarse solution that the bound needs."""
    ens = lay_out_ensemble(_WELL, _DRIVE, {"omega": omega})
    problem = initial_value_problem(ens, np.full(omega.size, _WINDOW))
    outcome = integrate_without_error_bound(
        problem, Request(wants_extremes=True), resolution=int(resolution), workers=1
    )
    return np.column_stack([outcome.maximum, outcome.minimum])


def measure_exponents(plan: Plan) -> dict[str, Any]:
    """A map of the largest exponent over frequency and load."""
    side = _QUICK_SIDE if plan.quick else _SIDE
    omega, m = np.linspace(*_OMEGA, side), np.linspace(*_M, side)
    starts = _starts()
    length = 2.0 * np.pi / starts["omega"]
    exact = _reference_ends(starts, length)

    def period_error(states: FloatArray) -> float:
        return float(np.abs(states - exact).max())

    def ours(tolerance: float) -> object:
        return rm.lyapunov(
            _WELL, _DRIVE, periods=_PERIODS, over={"omega": omega, "m": m}, tolerance=tolerance
        )

    def ours_once(tolerance: float) -> object:
        return _exponents_of_one_run({"omega": omega, "m": m}, tolerance)

    def theirs(peer: Peer) -> _Prepared:
        ends, exponents = peer.build_ends(), peer.build_exponents()
        states = np.column_stack([starts["x"], starts["v"]])
        tolerance, worst = _loosest(
            lambda t: period_error(ends(starts["omega"], starts["m"], states, length, t)),
            _PERIOD_LIMIT,
        )
        rng = np.random.default_rng(1)
        count = min(peer.sample, 256)
        w, strength = rng.choice(omega, count), rng.choice(m, count)
        exponents(w[:8], strength[:8], 2, tolerance)  # compiles
        amount = float((_PERIODS * 2.0 * np.pi / w).sum())
        return _Prepared(
            lambda: exponents(w, strength, _PERIODS, tolerance), amount, tolerance, worst,
            _PERIOD_LIMIT,
        )  # fmt: skip

    with one_core():
        tolerance, worst = _loosest(
            lambda t: period_error(_our_ends(starts, length, t)), _PERIOD_LIMIT
        )
        amount = float((_PERIODS * 2.0 * np.pi / omega).sum() * side)
        tools = {
            name: _Prepared(partial(run, tolerance), amount, tolerance, worst, _PERIOD_LIMIT)
            for name, run in ((_OURS, ours), (_OURS_ONCE, ours_once))
        }
        tools |= {peer.name: theirs(peer) for peer in _present(plan)}
        return {"tools": _measured(plan, "exponents", tools), "trajectories": side**2}


def _exponents_of_one_run(over: dict[str, FloatArray], tolerance: float) -> FloatArray:
    """Exponents of motions that are followed once, as the verb follows them first."""
    follower = EnsembleFollower(lay_out_ensemble(_WELL, _DRIVE, over), _PERIODS, 1)

    def work(indices: IntArray) -> dict[str, np.ndarray[Any, Any]]:
        path = follower.follow(indices, tolerance)
        growth = lyapunov_exponents(path.log_growth, path.block_lengths_in_periods)
        return {"exponent": growth.mean[:, 0] / follower.period_lengths[indices]}

    return follower.compute_in_chunks(work, {"exponent": np.empty(0)}, None)["exponent"]


def _measured(plan: Plan, work: str, tools: dict[str, _Prepared]) -> dict[str, Any]:
    """Medians of processor time; tools take turns, so that all see the same machine."""
    seconds: dict[str, list[float]] = {name: [] for name in tools}
    for turn in range(plan.repeats + 1):
        for name, tool in tools.items():
            begin = time.process_time()
            tool.run()
            if turn:  # the first compiles
                seconds[name].append(time.process_time() - begin)
    rows = {}
    for name, tool in tools.items():
        microseconds = 1e6 * statistics.median(seconds[name]) / tool.amount
        plan.say(f"double well, {work}: {name}: {microseconds:.3g} µs, worst {tool.worst:.1e}")
        rows[name] = {
            "microseconds": microseconds,
            "setting": tool.setting,
            "setting_name": tool.setting_name,
            "worst": tool.worst,
            "met": tool.worst <= tool.limit,
        }
    return rows


def _present(plan: Plan) -> Iterator[Peer]:
    """Peers that are installed; the others are told of."""
    for peer in peers():
        reason = peer.source.missing()
        if reason:
            plan.say(f"double well: {peer.name} left out, {reason}")
        else:
            yield peer


def _loosest(
    error: Callable[[float], float], limit: float, settings: Sequence[float] = TOLERANCES
) -> tuple[float, float]:
    """The cheapest setting within the limit, and its error; the dearest if none is."""
    for setting in settings:
        worst = float(error(setting))
        if worst <= limit:
            break
    return setting, worst


def _reference_motions(omega: FloatArray) -> FloatArray:
    """Last state, largest and smallest x by SciPy at its best, array (trajectory, 4)."""
    rows = []
    for w in omega:
        run = _scipy_run(float(w), _DRIVE.m, REST, _WINDOW, events=lambda _, y: y[1])
        turns = np.concatenate([run.y_events[0][:, 0], [REST[0], run.y[0, -1]]])
        rows.append([*run.y[:, -1], turns.max(), turns.min()])
    return np.array(rows)


def _reference_ends(starts: dict[str, FloatArray], times: FloatArray) -> FloatArray:
    """States at given times by SciPy at its best."""
    rows = zip(*starts.values(), times, strict=True)
    return np.array([_scipy_run(w, m, (x, v), end).y[:, -1] for w, m, x, v, end in rows])


def _scipy_run(w: float, m: float, start: Any, end: float, *, events: Any = None) -> Any:
    def rates(tau: float, y: Any) -> list[float]:
        x, v = y
        return [v, m * np.cos(w * tau) - DELTA * v + x - x**3]

    return solve_ivp(
        rates, (0.0, end), start, method="DOP853", rtol=_REFERENCE_RTOL, atol=_REFERENCE_ATOL,
        events=events,
    )  # fmt: skip


def _starts() -> dict[str, FloatArray]:
    """States on motions from rest, with their frequencies and loads."""
    rng = np.random.default_rng(2)
    omega, m = rng.uniform(*_OMEGA, _STARTS), rng.uniform(*_M, _STARTS)
    over = {"omega": xr.DataArray(omega, dims="case"), "m": xr.DataArray(m, dims="case")}
    section = rm.poincare_section(_WELL, _DRIVE, periods=_PERIODS_TO_STARTS, over=over)
    section = section.isel(period=-1)
    return {"omega": omega, "m": m, "x": section.x.values, "v": section.x_rate.values}


def _our_ends(starts: dict[str, FloatArray], length: FloatArray, tolerance: float) -> FloatArray:
    """States after a period, by the map that `lyapunov` iterates."""
    over = {name: xr.DataArray(starts[name], dims="case") for name in ("omega", "m")}
    problem = initial_value_problem(lay_out_ensemble(_WELL, _DRIVE, over), np.ones(_STARTS))
    flow = PeriodMap(
        problem.field, problem.load_schedule.waveforms_at_phase, directions=1, error_control="state"
    )
    states = np.column_stack([starts["x"], starts["v"]])
    return flow(states, problem.parameters, length, tolerance=tolerance).state
