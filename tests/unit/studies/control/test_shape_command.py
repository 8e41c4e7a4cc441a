"""Commands of steps land where they should, at rest, and say what they leave."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import remanent as rm


@pytest.mark.parametrize("target", [0.6, 1.05, 1.5, 2.5])
@pytest.mark.parametrize(("c", "temperature"), [(1.0, 293.0), (0.01, 350.0)])
def test_closed_form(target: float, c: float, temperature: float) -> None:
    """S = 0, no damping: m1 = theta (x - 1)(x + 2)/(2x) for half its period, by quadrature,
    then m2 = theta (x^3 - 1)/x^2."""
    command = rm.shape_command(rm.Actuator(c=c, temperature=temperature), target)
    theta, x = temperature / 293.0, target
    first = theta * (x - 1.0) * (x + 2.0) / (2.0 * x)
    np.testing.assert_allclose(command.loads, [first, theta * (x**3 - 1.0) / x**2], rtol=1e-10)

    def potential(stretch: float) -> float:
        return 3.0 * (theta * (stretch**2 / 2.0 + stretch**-4 / 4.0) - first * stretch**-2 / 2.0)

    middle, half = 0.5 * (1.0 + x**-0.5), 0.5 * (x**-0.5 - 1.0)

    def slowness(angle: float) -> float:
        stretch = middle - half * np.cos(angle)
        left = 2.0 * (potential(1.0) - potential(stretch)) / (1.0 + 2.0 * c * stretch**-6)
        return float(abs(half * np.sin(angle)) / np.sqrt(left))

    expected = quad(slowness, 1e-6, np.pi - 1e-6, epsabs=1e-9)[0]
    assert command.times[1] == pytest.approx(expected, abs=1e-5)


SLOW = pytest.mark.slow  # a new material is derived and compiled
CASES = {
    "plain": (rm.Actuator(), 1.3),
    "film": (rm.Actuator(c=0.01, temperature=350.0), 1.2),
    "prestressed": (rm.Actuator(prestress=1.0), 0.8),
    "damped": (rm.Actuator(dissipation=rm.Rayleigh(0.3)), 1.4),
    "both": (rm.Actuator(prestress=-0.5, dissipation=rm.Rayleigh(0.1)), 1.3),
    "creeping": (rm.Actuator(dissipation=(rm.Zener(0.5, 0.7), rm.Rayleigh(0.05))), 1.2),
}


@pytest.mark.parametrize(
    "case", [*(c for c in CASES if c != "creeping"), pytest.param("creeping", marks=SLOW)]
)
def test_a_shaped_move_leaves_a_millionth(case: str) -> None:
    """Residual vibration below 1e-6 of that of the single step, and the block stays there."""
    actuator, target = CASES[case]
    command = rm.shape_command(actuator, target)
    shaped = rm.step_response(actuator, command)
    plain = rm.step_response(actuator, rm.Constant(command.loads[-1]))
    assert float(shaped.final) == pytest.approx(target, abs=1e-12)
    assert float(shaped.residual_amplitude) < 1e-6 * float(plain.residual_amplitude)
    after = command.times[-1] + np.linspace(0.0, 10.0, 50)
    history = rm.simulate(actuator, command, times=after)
    np.testing.assert_allclose(history.thickness_stretch, target, atol=1e-8)


@pytest.mark.parametrize("initial", [(1.05, 0.3), (0.95, -0.4)])
def test_a_moving_block_is_caught(initial: tuple[float, float]) -> None:
    """From any state, also one with speed."""
    command = rm.shape_command(rm.Actuator(prestress=0.2), 1.2, initial=initial)
    history = rm.simulate(
        rm.Actuator(prestress=0.2), command, initial=initial, times=command.times[-1] + np.arange(5)
    )
    np.testing.assert_allclose(history.thickness_stretch, 1.2, atol=1e-8)


@pytest.mark.slow
def test_a_robust_command_loses_to_second_order() -> None:
    """Twice the error in the modulus: twice the vibration of two steps, four times of three."""
    actuator = rm.Actuator()
    over = {"shear_modulus": [1.005, 1.01]}
    growth, left = [], []
    for robust in ((), ("shear_modulus",)):
        command = rm.shape_command(actuator, 1.2, robust_to=robust)
        found = rm.step_response(actuator, command, over=over).residual_amplitude.values
        growth.append(found[1] / found[0])
        left.append(found[1])
    np.testing.assert_allclose(growth, [2.0, 4.0], rtol=0.03)
    assert left[1] < 0.02 * left[0]


def test_commands_over_a_field_are_the_single_ones() -> None:
    """`shape_commands` over a grid, and NaN where the target cannot be held."""
    ds = rm.shape_commands(rm.Actuator(), 1.3, over={"prestress": [0.0, 0.4]})
    for s in (0.0, 0.4):
        single = rm.shape_command(rm.Actuator(prestress=s), 1.3)
        np.testing.assert_array_equal(ds.sel(prestress=s).step_load, single.loads)
        np.testing.assert_array_equal(ds.sel(prestress=s).step_time, single.times)
    assert (ds.switch_time_error < 1e-8).all()
    unstable = 1.1 - 1.1**-5 + 2.15 * 1.1**-3
    mixed = rm.shape_commands(rm.Actuator(), 1.1**-2, over={"prestress": [0.0, unstable]})
    np.testing.assert_array_equal(np.isfinite(mixed.switch_time), [True, False])
    assert mixed.status.values.tolist() == [rm.Status.OK, rm.Status.DIVERGED]


def test_what_cannot_be_held_is_refused() -> None:
    """Between the folds of the wedge of three equilibria the middle one is unstable."""
    stretch, m = 1.1, 2.15  # where the force falls with stretch: 1 + 5 l^-6 < 3 m l^-4
    bent = rm.Actuator(prestress=stretch - stretch**-5 + m * stretch**-3)
    with pytest.raises(rm.InputError, match="unstable"):
        rm.shape_command(bent, stretch**-2)
    with pytest.raises(rm.InputError, match="target"):
        rm.shape_command(rm.Actuator(), -1.0)
    with pytest.raises(rm.InputError, match="field"):
        rm.shape_command(rm.Actuator(), 1.2, robust_to="stiffness")
    with pytest.raises(rm.InputError, match=r"rm\.Steps"):
        rm.step_response(rm.Actuator(), rm.Sine(0.1, 1.0))


def test_a_body_that_is_at_rest_at_the_target_stays() -> None:
    """Law: the command to stay is the load that holds the body, from the start."""
    assert rm.shape_command(rm.Actuator(), 1.0) == rm.Steps([0.0], [0.0])
    pulled = rm.Actuator(prestress=0.3)
    held = float(rm.equilibria(pulled, 0.2).equilibrium_stretch[0])
    start = (held**-0.5, 0.0)
    command = rm.shape_command(pulled, held, initial=start)
    assert command.loads == pytest.approx((0.2,), abs=1e-12)
    ds = rm.step_response(pulled, command, initial=start)
    assert float(ds.residual_amplitude) < 1e-9
    assert np.isnan(float(ds.rise_time))
    assert "no change" in str(ds.reason.values)


def half_period(target: float) -> float:
    """Duration of the first step to a target, without damping and at the reference temperature.

    With x the thickness stretch, t = x^(-1/2) and an in-plane stretch s between 1 and t, energy
    gives ds/dtime, and s = 1 + (t - 1)(1 - cos a)/2 leaves a smooth periodic function of a.
    """
    angle = np.pi * (np.arange(200) + 0.5) / 200.0
    t = target**-0.5
    s = 1.0 + 0.5 * (t - 1.0) * (1.0 - np.cos(angle))
    slowness = s**2 * np.sqrt((1.0 + 2.0 * s**-6) / (3.0 * (1.0 + s) * (s + t)))
    return float(np.pi * np.mean(slowness / np.sqrt(s**2 + 0.5 * target)))


@pytest.mark.parametrize("target", [1.5, 2.5])
def test_the_error_of_a_switch_time_is_above_the_true_one_but_not_far(target: float) -> None:
    """Law: the stated error is between once and a hundred times what the time is off by."""
    found = rm.shape_commands(rm.Actuator(), target, tolerance=1e-5)
    off = abs(float(found.switch_time) - half_period(target))
    assert 1e-10 < off <= float(found.switch_time_error) < 100.0 * off
