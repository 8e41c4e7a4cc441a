"""Long runs of flows: exponents that are known, steps that follow each trajectory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from remanent._field import Field, Role, StateVariable
from remanent._typing import FloatArray
from remanent.analysis.regimes.long_runs import LongRun, propagate_tangents
from remanent.analysis.regimes.lyapunov import LyapunovExponents, lyapunov_exponents
from remanent.codegen.lower import DependenceLevel, lower_to_program
from remanent.integrate.kernel.compile import Kernel
from remanent.integrate.maps.advance import BlockAdvancer
from remanent.integrate.maps.period_map import ErrorControl, PeriodMap, PeriodMapImage
from tests.unit.integrate.handmade import COSINE, Oscillator, Q, V, turning

X, Y, Z = sp.symbols("x y z", real=True)


def autonomous(rates: list[sp.Expr]) -> Field:
    """A field of x, y, z without parameters; the phase is there but plays no part."""
    names = ("x", "y", "z")[: len(rates)]
    inputs = ("drive_phase", *names, "sine", "cosine")
    waveforms = sp.symbols("sine cosine", real=True)
    levels = dict.fromkeys((X, Y, Z), DependenceLevel.STATE) | dict.fromkeys(
        waveforms, DependenceLevel.DRIVE
    )

    def program(*outputs: sp.Expr) -> object:
        return lower_to_program(outputs, inputs=inputs, levels=levels, definitions={})

    return Field(
        variables=tuple(StateVariable(name, Role.COORDINATE) for name in names),
        load_names=(),
        parameter_names=(),
        waveform_names=("sine", "cosine"),
        rates=program(*rates),  # type: ignore[arg-type]
        observable_name="x",
        observable_and_rates=program(X, rates[0], rates[0], rates[0]),  # type: ignore[arg-type]
        observables={},
    )


def spectrum(
    field: Field, start: list[float], length: float, periods: int, *, directions: int | None = None
) -> tuple[LyapunovExponents, LongRun]:
    """Exponents per unit of time of an autonomous flow, strobed every `length`."""
    count = len(start) if directions is None else directions
    flow = PeriodMap(field, turning, directions=count)
    advance = BlockAdvancer(flow, np.zeros((1, 0)), np.array([length]), 1e-9)
    path = propagate_tangents(advance, np.array([start]), periods, directions=count)
    found = lyapunov_exponents(path.log_growth, path.block_lengths_in_periods)
    per_time = {
        name: getattr(found, name) / length
        for name in ("mean", "error", "batch_error", "running_mean")
    }
    return replace(found, **per_time), path


def test_decay_has_exponent_minus_one() -> None:
    """Exponents: x' = -x."""
    found, _ = spectrum(autonomous([-X]), [1.0], 0.7, 200)
    assert found.mean[0, 0] == pytest.approx(-1.0, abs=1e-8)


def test_lorenz_exponents() -> None:
    """Their sum is the trace, -(10 + 1 + 8/3); the largest is 0.9056 (Viswanath 1998).

    Law: Exponents.
    """
    rates = [10 * (Y - X), 28 * X - Y - X * Z, X * Y - sp.Rational(8, 3) * Z]
    found, path = spectrum(autonomous(rates), [1.0, 1.0, 20.0], 0.2, 4000)
    assert path.error_bound_met.all()
    assert found.mean[0].sum() == pytest.approx(-(11.0 + 8.0 / 3.0), abs=1e-5)
    assert found.mean[0, 0] == pytest.approx(0.9056, abs=3 * found.error[0, 0] + 1e-3)
    assert abs(found.mean[0, 1]) < 3 * found.error[0, 1] + 5e-3
    assert found.error[0, 0] < 0.03


@pytest.mark.slow
def test_roessler_exponents() -> None:
    """a = 0.15, b = 0.2, c = 10: largest 0.09 (Wolf 1985: 0.13 bits), the next 0."""
    rates = [-Y - Z, X + 0.15 * Y, sp.Rational(1, 5) + Z * (X - 10)]
    found, _ = spectrum(autonomous(rates), [1.0, 1.0, 1.0], 1.0, 8000, directions=2)
    assert found.batch_error[0, 0] < 0.003
    assert found.mean[0, 0] == pytest.approx(0.13 * np.log(2.0), abs=0.005)
    assert abs(found.mean[0, 1]) < 3 * found.error[0, 1] + 2e-3


def test_exponent_of_the_map_is_period_times_that_of_the_flow() -> None:
    """Exponents: strobing half as often doubles growth per period."""
    rates = [10 * (Y - X), 28 * X - Y - X * Z, X * Y - sp.Rational(8, 3) * Z]
    often, _ = spectrum(autonomous(rates), [1.0, 1.0, 20.0], 0.2, 2000, directions=1)
    seldom, _ = spectrum(autonomous(rates), [1.0, 1.0, 20.0], 0.4, 1000, directions=1)
    slack = 3 * float(np.hypot(often.error[0, 0], seldom.error[0, 0]))
    assert often.mean[0, 0] == pytest.approx(seldom.mean[0, 0], abs=slack)


def duffing(par: FloatArray, tolerance: float, directions: int = 2) -> BlockAdvancer:
    """Parameters omega, damping, force; two wells."""
    d, f = sp.symbols("d F", real=True)
    field = Oscillator(f * COSINE - d * V + Q - Q**3, {"d": 0.0, "F": 0.0}).field()
    flow = PeriodMap(field, turning, directions=directions)
    return BlockAdvancer(flow, np.ascontiguousarray(par[:, 1:]), 2 * np.pi / par[:, 0], tolerance)


def test_forced_duffing_is_chaotic_and_contracts_as_its_damping_says() -> None:
    """omega = 1, F = 0.3, d = 0.15: the sum of the exponents is -d, the largest positive."""
    par = np.array([[1.0, 0.15, 0.3]])
    path = propagate_tangents(duffing(par, 1e-9), np.array([[0.5, 0.0]]), 1500, directions=2)
    found = lyapunov_exponents(path.log_growth, path.block_lengths_in_periods)
    assert found.mean[0].sum() == pytest.approx(-0.15 * 2 * np.pi, abs=1e-6)
    assert found.mean[0, 0] > 5 * found.error[0, 0]


def test_company_and_blocks_do_not_change_a_run() -> None:
    """Determinism: a trajectory alone, among others, and after others with other steps."""
    forces = np.linspace(0.05, 0.5, 37)
    par = np.column_stack([np.linspace(0.5, 1.5, 37), np.full(37, 0.1), forces])
    start = np.tile([0.5, 0.0], (37, 1))
    whole = propagate_tangents(duffing(par, 1e-8), start, 60, directions=2, every=True)
    alone = propagate_tangents(duffing(par[9:10], 1e-8), start[9:10], 60, directions=2, every=True)
    assert whole.visited_states is not None
    assert alone.visited_states is not None
    np.testing.assert_array_equal(whole.visited_states[9], alone.visited_states[0])
    np.testing.assert_array_equal(whole.triangular_factors[9], alone.triangular_factors[0])


@pytest.mark.parametrize("half", [False, True], ids=["whole", "half"])
@pytest.mark.parametrize("error_control", ["all", "state", "none"])
def test_steps_of_the_company_do_not_change_an_image(
    half: bool, error_control: ErrorControl
) -> None:
    """Determinism: points whose steps differ two hundredfold share groups, and each is as alone."""
    field = Oscillator(0.3 * COSINE - 0.15 * V + Q - Q**3, {}).field()
    flow = PeriodMap(field, turning, directions=2, error_control=error_control)
    rng = np.random.default_rng(3)
    count = 37
    start, length = rng.uniform(-1.0, 1.0, (count, 2)), rng.uniform(4.0, 8.0, count)
    resolution = rng.choice([6, 8, 14, 24, 40, 112, 512, 1280], count)

    def image(points: slice) -> PeriodMapImage:
        states, lengths = start[points], length[points]
        return flow(
            states, np.zeros((len(states), 0)), lengths, tolerance=1e-5, cycles=3, half=half,
            visited=True, resolution=resolution[points],
        )  # fmt: skip

    whole = image(slice(None))
    for k in range(count):
        alone = image(slice(k, k + 1))
        for name, values in vars(alone).items():
            np.testing.assert_array_equal(getattr(whole, name)[k], values[0], err_msg=name)


@pytest.mark.parametrize("error_control", ["all", "state", "none"])
def test_kernels_for_few_points_change_no_bit(error_control: ErrorControl) -> None:
    """Determinism: smaller groups, for a plain field and for one with a division and functions."""
    rng = np.random.default_rng(5)
    start, length = rng.uniform(-0.9, 0.9, (9, 2)), rng.uniform(4.0, 8.0, 9)
    for acceleration in (0.3 * COSINE - Q**3, COSINE / (2 + Q) - sp.exp(Q) * V - sp.log(2 + Q**2)):
        images = [
            PeriodMap(
                Oscillator(acceleration, {}).field(), turning,
                directions=2, error_control=error_control, expected_points=expected,
            )(start, np.zeros((9, 0)), length, tolerance=1e-9, cycles=2, visited=True)
            for expected in (None, 1)
        ]  # fmt: skip
        for name, values in vars(images[0]).items():
            np.testing.assert_array_equal(values, getattr(images[1], name), err_msg=name)


def test_points_wait_for_their_company_at_the_end_of_a_period() -> None:
    """x'' = -x: after a period of 2 pi every point is back, whatever steps its company takes."""
    flow = PeriodMap(Oscillator(-Q, {}).field(), turning, error_control="none")
    start = np.random.default_rng(4).uniform(-1.0, 1.0, (40, 2))
    image = flow(
        start, np.zeros((40, 0)), np.full(40, 2.0 * np.pi), tolerance=np.inf, cycles=2,
        resolution=np.arange(16, 56),
    )  # fmt: skip
    np.testing.assert_allclose(image.state, start, atol=1e-9)


def test_round_off_is_not_refined() -> None:
    """Shorter steps do not lower an error that rounding makes, so none are tried."""
    flow = PeriodMap(Oscillator(-Q, {}).field(), turning)
    image = flow(np.array([[1.0, 0.0]]), np.zeros((1, 0)), np.full(1, 2.0 * np.pi), tolerance=1e-18)
    assert 1e-18 < image.largest_period_error[0] < 1e-13
    assert image.resolution[0] < 1024


def test_errors_of_periods_meet_the_tolerance() -> None:
    """Each period against the same map at 1e-13."""
    par = np.array([[0.7, 0.0, 0.4], [1.3, 0.0, 0.3]])
    start = np.array([[0.5, 0.0], [1.2, 0.4]])
    path = propagate_tangents(duffing(par, 1e-8, 1), start, 40, directions=1, every=True)
    assert path.visited_states is not None
    exact = duffing(par, 1e-13, 0)
    for n in range(39):
        now = path.visited_states[:, n]
        image = exact(np.arange(2), now, np.empty((2, 0, 2)), 1, every=False)
        assert np.abs(image.visited_states[:, 0] - path.visited_states[:, n + 1]).max() <= 1e-8
    assert (path.largest_period_error <= 1e-8).all()


def test_what_escapes_is_told_from_what_cannot_be_resolved() -> None:
    """x'' = 6 x^2 from (1, 2) is infinite at 1; 16 rad per period need more than 8 steps."""
    start = np.array([[1.0, 2.0]])

    def run(acceleration: sp.Expr, max_resolution: int) -> LongRun:
        flow = PeriodMap(Oscillator(acceleration, {}).field(), turning, directions=1)
        advance = BlockAdvancer(
            flow, np.zeros((1, 0)), np.full(1, 0.9), 1e-11, max_resolution=max_resolution
        )
        return propagate_tangents(advance, start, 20, directions=1)

    lost = run(6 * Q**2, 2**12)
    assert lost.escaped.all()
    assert lost.error_bound_met.all()
    assert lost.completed_periods[0] < 20
    stuck = run(-256 * Q, 8)
    assert not stuck.error_bound_met.any()
    assert not stuck.escaped.any()
    assert run(-256 * Q, 2**12).error_bound_met.all()


@pytest.mark.parametrize("directions", [1, 2])
def test_error_control_changes_nothing_but_the_error(directions: int) -> None:
    """The finer solution stays the same, and the error of the state is that without tangents."""
    field = Oscillator(COSINE - 0.1 * V - Q**3, {}).field()
    start, length = np.array([[0.3, 0.0], [1.5, 0.4]]), np.array([5.0, 6.0])

    def image(columns: int, error_control: ErrorControl) -> PeriodMapImage:
        flow = PeriodMap(field, turning, directions=columns, error_control=error_control)
        empty = np.zeros((2, 0))
        return flow(start, empty, length, tolerance=np.inf, cycles=3, resolution=16)

    everything = image(directions, "all")
    for other in (image(directions, "state"), image(directions, "none")):
        np.testing.assert_array_equal(other.state, everything.state)
        np.testing.assert_array_equal(other.tangents, everything.tangents)
    alone = image(0, "all").largest_period_error
    np.testing.assert_allclose(image(directions, "state").largest_period_error, alone, rtol=1e-3)
    assert (everything.largest_period_error >= alone).all()


def test_errors_of_tangents_are_absolute_up_to_one_and_relative_beyond() -> None:
    """q'' = -q at rest, whose only error is that of its tangent: as large as that, up to 1."""
    flow = PeriodMap(Oscillator(-Q, {}).field(), turning, directions=1)
    sizes = np.array([1e-6, 1e-3, 1.0, 1e3, 1e6])
    image = flow(
        np.zeros((5, 2)), np.zeros((5, 0)), np.full(5, 3.0), tolerance=np.inf, resolution=4,
        tangent=sizes[:, None, None] * np.array([[[1.0, 0.0]]]),
    )  # fmt: skip
    error = image.largest_period_error
    assert error[2] > 0.0
    np.testing.assert_allclose(error[:2] / error[2], sizes[:2], rtol=1e-3)
    # Beyond, over the larger of cos and sin, at least 0.7.
    assert ((error[3:] / error[2] >= 0.999) & (error[3:] / error[2] <= 1.42)).all()


def test_calls_of_the_machine_code_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Determinism: ten periods in one call of the kernel, and in calls of three, then one."""
    flow = PeriodMap(Oscillator(COSINE - 0.1 * V - Q**3, {}).field(), turning, directions=1)

    def image() -> PeriodMapImage:
        return flow(
            np.array([[0.3, 0.1]]), np.zeros((1, 0)), np.array([5.0]), tolerance=np.inf, cycles=10,
            resolution=16, visited=True,
        )  # fmt: skip

    whole = image()
    monkeypatch.setattr(Kernel, "_cycles_per_call", lambda *_: 3)
    parts = image()
    np.testing.assert_array_equal(parts.state, whole.state)
    np.testing.assert_array_equal(parts.tangents, whole.tangents)
    np.testing.assert_array_equal(parts.visited_states, whole.visited_states)


def test_a_map_carries_derivatives_only_along_what_it_is_given() -> None:
    """q'' = -q over a time t: none, d/dq(0) = (cos t, -sin t), and d/dv(0) = (sin t, cos t)."""
    field, length = Oscillator(-Q, {}).field(), np.array([0.7])
    exact = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    flows = [PeriodMap(field, turning)]
    flows += [PeriodMap(field, turning, directions=count) for count in (1, 2)]
    for count, flow in enumerate(flows):
        image = flow(np.array([[0.3, 0.1]]), np.zeros((1, 0)), length, tolerance=1e-12)
        assert image.tangents.shape == (1, count, 2)
        np.testing.assert_allclose(image.tangents[0], exact[:count], rtol=0.0, atol=1e-11)


def test_the_coarse_solution_is_rounded_to_as_many_digits_less_as_its_method_says() -> None:
    """At rest in [1, 1.9] the two solutions differ by up to half of 2^b units of the last digit."""
    flow = PeriodMap(Oscillator(0.0 * Q, {}).field(), turning)
    rest = np.random.default_rng(8).uniform(1.0, 1.9, 400)
    image = flow(
        np.column_stack([rest, np.zeros(400)]), np.zeros((400, 0)), np.ones(400),
        tolerance=np.inf, resolution=8,
    )  # fmt: skip
    method = flow.kernel.method
    assert image.last_state_error is not None
    np.testing.assert_array_equal(image.state[:, 0], rest)
    difference = np.abs(image.last_state_error[:, 0]) / method.error_per_solution_difference
    half_unit = 0.5 * 2.0**method.coarse_solution_lost_bits * np.finfo(float).eps
    assert 0.9 * half_unit < difference.max() <= half_unit * (1.0 + 1e-9)
