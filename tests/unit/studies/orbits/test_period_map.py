"""The public period map and the right-hand side, against an independent engine."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import remanent as rm
from benchmarks.errors.period_map import PeriodMap  # needs heyoka
from remanent.models.drives.base import Drive

DRIVE = rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(temperature=350, prestress=0.2, dissipation=rm.Rayleigh(0.1))
VALUES = {
    "c": 1.0, "temperature": 350.0, "prestress": 0.2, "dissipation.0.eta": 0.1,
    "b": 0.4, "omega": 1.25,
}  # fmt: skip


@pytest.mark.parametrize("period", [1, 3])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-9, 1e-12])
def test_images_and_jacobians_are_within_their_errors(period: int, tolerance: float) -> None:
    """Law: Coverage.  Random states against Taylor series in extended precision."""
    rng = np.random.default_rng(period)
    states = np.column_stack([rng.uniform(0.7, 1.6, 20), rng.uniform(-1.0, 1.0, 20)])
    period_map = rm.period_map(DAMPED, DRIVE, orbit_period=period, tolerance=tolerance)
    found = period_map(states.reshape(4, 5, 2))
    assert found.images.shape == (4, 5, 2) == found.images_error.shape
    assert found.jacobians.shape == (4, 5, 2, 2) == found.jacobians_error.shape
    assert (found.images_error <= tolerance).all()
    reference = PeriodMap(DRIVE, VALUES)
    exact = [reference.image(state, period) for state in states]
    images = np.array([image for image, _ in exact]).reshape(4, 5, 2)
    jacobians = np.array([jacobian for _, jacobian in exact]).reshape(4, 5, 2, 2)
    assert (np.abs(found.images - images) <= found.images_error).all()
    assert (np.abs(found.jacobians - jacobians) <= found.jacobians_error).all()


def test_an_image_depends_on_its_state_alone() -> None:
    """Law: Determinism.  Alone, in a batch, in another order: the same bits."""
    rng = np.random.default_rng(5)
    states = np.column_stack([rng.uniform(0.7, 1.6, 40), rng.uniform(-1.0, 1.0, 40)])
    together = rm.period_map(DAMPED, DRIVE)(states)
    backwards = rm.period_map(DAMPED, DRIVE)(states[::-1])
    alone = rm.period_map(DAMPED, DRIVE)(states[7])
    for name, values in vars(together).items():
        np.testing.assert_array_equal(getattr(backwards, name)[::-1], values)
        np.testing.assert_array_equal(getattr(alone, name), values[7])


def test_the_map_keeps_area_and_returns_its_orbits() -> None:
    """Exact facts: det J = 1 without dissipation; an orbit is its own image."""
    actuator = rm.Actuator(temperature=350)
    orbits = rm.periodic_orbits(actuator, DRIVE)
    found = rm.period_map(actuator, DRIVE)(orbits.initial.values)
    off = np.abs(found.images - orbits.initial.values)
    assert (off <= found.images_error + 1e-9).all()
    np.testing.assert_allclose(np.linalg.det(found.jacobians), 1.0, atol=1e-8)


def test_a_motion_that_does_not_last_has_no_image() -> None:
    """NaN in place of an image and of its error; the others are not touched."""
    period_map = rm.period_map(rm.Actuator(), rm.Sine(3.0, 2.0, mean=3.0))
    found = period_map([[1.0, 0.0], [1e-3, -1e3]])
    lasted = np.isfinite(found.images).all(axis=1)
    assert lasted.tolist() == [True, False]
    assert (np.isfinite(found.images_error).all(axis=1) == lasted).all()


@pytest.mark.parametrize(
    ("states", "words"),
    [
        ([1.0, 0.0, 0.0], "2 numbers along their last axis"),
        (1.0, "2 numbers along their last axis"),
        ([np.nan, 0.0], "finite"),
        ([-0.5, 0.0], "stretch above 0"),
        (["a", "b"], "finite numbers"),
    ],
)
def test_states_that_are_none_are_refused(states: object, words: str) -> None:
    """Law: Bad input.  The message says what is asked for."""
    with pytest.raises(rm.InputError, match=words):
        rm.period_map(DAMPED, DRIVE)(states)  # type: ignore[arg-type]


DRIVES: list[Drive] = [
    rm.Constant(0.3), DRIVE, rm.Sine(0.4, 1.1, mean=0.2, phase=0.5),
    rm.Sines([0.1, 0.2], [1.0, 2.0], 0.9), rm.Steps([0.0, 1.0, 2.5], [0.1, 0.4, 0.2]),
    rm.Ramp([0.0, 1.0, 2.5], [0.0, 0.4, 0.1]), rm.Chirp(0.2, 0.5, 2.0, 3.0),
    rm.Sampled(np.linspace(0.0, 6.0, 13), 0.2 * np.sin(np.linspace(0.0, 6.0, 13))),
]  # fmt: skip


@pytest.mark.parametrize("drive", DRIVES, ids=lambda d: type(d).__name__)
def test_rates_are_those_of_the_equation_of_motion(drive: Drive) -> None:
    """[Thermal, eq. 16] written out once more, at random times and states, and the load there."""
    rng = np.random.default_rng(11)
    t = rng.uniform(0.0, 5.0, (3, 8))
    x, v = rng.uniform(0.6, 2.0, t.shape), rng.uniform(-2.0, 2.0, t.shape)
    found = rm.rates(DAMPED, drive)(t, np.stack([x, v], axis=-1))
    theta, prestress, eta, c, m = 350.0 / 293.0, 0.2, 0.1, 1.0, drive(t)
    force = theta * (x - x**-5) - prestress + m * x**-3 + eta * v
    rate = (6.0 * c * x**-7 * v**2 - 3.0 * force) / (1.0 + 2.0 * c * x**-6)
    np.testing.assert_array_equal(found[..., 0], v)
    np.testing.assert_allclose(found[..., 1], rate, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("body", [
    DAMPED, rm.Actuator(prestress=(0.1, 0.2), dissipation=rm.Zener(0.5, 1.0)),
    rm.Actuator(heat=rm.Heat(exchange=0.1), dissipation=rm.Rayleigh(0.1)),
], ids=["one coordinate", "two with internal variables", "warming"])  # fmt: skip
def test_rates_in_an_integrator_of_scipy_give_the_motion(body: rm.Actuator) -> None:
    """Law: Independent engines.  DOP853 on the rates, and the motion of `simulate`."""
    rates = rm.rates(body, DRIVE)
    motion = rm.simulate(body, DRIVE, duration=4.0)
    start = [float(motion[name][0]) for name in rates.state_names]
    solution = solve_ivp(rates, (0.0, 4.0), start, method="DOP853", rtol=1e-11, atol=1e-12)
    end = [float(motion[name][-1]) for name in rates.state_names]
    np.testing.assert_allclose(solution.y[:, -1], end, rtol=1e-8, atol=1e-8)


def test_times_and_states_of_rates_that_are_none_are_refused() -> None:
    """Law: Bad input.  Times before 0, of another shape, states of another length."""
    rates = rm.rates(DAMPED, DRIVE)
    assert rates(np.zeros(0), np.zeros((0, 2))).shape == (0, 2)
    for t, y, words in (
        (-1.0, [1.0, 0.0], "not be below 0"),
        ([0.0, 1.0, 2.0], [[1.0, 0.0], [1.0, 0.1]], "one time or have the shape"),
        (0.0, [1.0], "2 numbers along the last axis"),
    ):
        with pytest.raises(rm.InputError, match=words):
            rates(t, y)


def test_errors_that_grow_from_period_to_period_are_kept_below_the_tolerance() -> None:
    """x'' = x + f sin(w t), away from a saddle: errors grow e^pi times in each of three periods."""
    force, omega, period, tolerance = 0.1, 2.0, 3, 1e-9
    saddle = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="-x**2/2 - load*x"
    )
    states = np.array([[1.0, 0.0], [1.0, -1.0], [0.3, 0.1], [0.01, 0.0]])
    period_map = rm.period_map(
        saddle, rm.Sine(force, omega), orbit_period=period, tolerance=tolerance
    )
    found = period_map(states)
    end = period * 2.0 * np.pi / omega
    # Beside the forced motion -f sin(w t)/(1 + w^2), which is at 0 where a period begins.
    forced_rate = np.array([0.0, -force * omega / (1.0 + omega**2)])
    turn = np.array([[np.cosh(end), np.sinh(end)], [np.sinh(end), np.cosh(end)]])
    exact = (states - forced_rate) @ turn.T + forced_rate
    assert (found.images_error <= tolerance).all()
    assert (np.abs(found.images - exact) <= found.images_error).all()
    assert (np.abs(found.jacobians - turn) <= found.jacobians_error).all()
