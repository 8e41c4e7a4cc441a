"""Commands of steps land where they should, at rest, and say what they leave."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

import remanent as rm
from remanent.analysis.control.shaping import controllable_poles
from remanent.codegen.build import build
from remanent.studies.statics._static_state import StaticState


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


def test_physical_sizes_scale_what_they_should() -> None:
    """A larger modulus is a warmer block; remanence is load; density is slowness."""
    actuator = rm.Actuator(prestress=0.3, dissipation=rm.Rayleigh(0.2))
    command = rm.Steps([0.0, 1.3], [0.2, 0.4])

    def left(body: rm.Actuator, drive: rm.Steps, **over: float) -> list[float]:
        names = {k: [v] for k, v in over.items()}
        ds = rm.step_response(body, drive, duration=20.0, over=names)
        names = ("residual_amplitude", "rise_time", "settling_time", "farthest")  # type: ignore[assignment]
        return [ds[name].item() for name in names]

    hot = left(actuator, command, temperature=1.1 * 293.0)
    np.testing.assert_allclose(left(actuator, command, shear_modulus=1.1), hot, rtol=1e-7)
    strong = left(actuator, rm.Steps([0.0, 1.3], [0.22, 0.44]))
    np.testing.assert_allclose(left(actuator, command, remanence=1.1), strong, rtol=1e-7)
    slow = np.sqrt(1.1)
    heavy = rm.step_response(
        actuator.replace(dissipation=rm.Rayleigh(0.2 / slow)),
        rm.Steps([0.0, 1.3 / slow], [0.2, 0.4]),
        duration=20.0 / slow,
    )
    expected = [
        heavy.residual_amplitude, heavy.rise_time * slow, heavy.settling_time * slow,
        heavy.farthest,
    ]  # fmt: skip
    np.testing.assert_allclose(left(actuator, command, density=1.1), expected, rtol=1e-7)


def test_a_magnet_in_itself_changes_with_remanence_and_modulus() -> None:
    """B_r^2/(mu mu0), beside m ~ B_r/mu and times in the unit of the modulus."""
    remanence, modulus = 1.2, 1.1
    over = {"remanence": xr.DataArray([remanence], dims="case"),
            "shear_modulus": xr.DataArray([modulus], dims="case")}  # fmt: skip
    body = rm.Actuator(magnet=rm.Magnet(demagnetisation=0.2))
    ds = rm.step_response(body, rm.Constant(0.3), duration=6.0, over=over)
    changed = body.with_parameter("magnet.demagnetisation", 0.2 * remanence**2 / modulus)
    load = rm.Constant(0.3 * remanence / modulus)
    alone = rm.step_response(changed, load, duration=6.0 * np.sqrt(modulus))
    assert float(ds.farthest[0]) == pytest.approx(float(alone.farthest), abs=1e-8)


def test_metrics_of_a_small_step() -> None:
    """Overshoot exp(-pi zeta/sqrt(1 - zeta^2)); settling as a dense history has it."""
    actuator = rm.Actuator(dissipation=rm.Rayleigh(0.6))
    ds = rm.step_response(actuator, rm.Constant(1e-4), duration=20.0)
    zeta = 0.6 * 3.0 / (2.0 * 3.0) / np.sqrt(6.0)  # 3 l'' + 3 eta l' + 18 l = 0
    expected = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))
    assert float(ds.overshoot) == pytest.approx(expected, rel=1e-3)
    dense = rm.simulate(actuator, rm.Constant(1e-4), times=np.linspace(0.0, 20.0, 40_001))
    share = (dense.thickness_stretch - 1.0) / (ds.final - 1.0)
    outside = dense.time[np.flatnonzero(np.abs(share - 1.0) > 0.02)[-1]]
    assert float(ds.settling_time) == pytest.approx(float(outside), abs=1e-3)
    rise = [float(dense.time[np.flatnonzero(share > s)[0]]) for s in (0.1, 0.9)]
    assert float(ds.rise_time) == pytest.approx(rise[1] - rise[0], abs=1e-3)


def test_residual_energy_is_the_kinetic_and_potential_energy_above_rest() -> None:
    """E - min U of the history, at the last step and after it (no damping)."""
    actuator, command = rm.Actuator(prestress=0.5), rm.Steps([0.0, 0.7], [0.1, 0.5])
    ds = rm.step_response(actuator, command)
    lowest = rm.equilibria(actuator, 0.5).equilibrium_potential
    energy = rm.simulate(actuator, command, times=[0.7, 5.0]).energy
    np.testing.assert_allclose(energy - float(lowest.min()), float(ds.residual_energy), atol=1e-9)


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


def test_rest_and_poles_of_two_coordinates() -> None:
    """Equal dead loads leave one mode to move, that of one coordinate; unequal ones both."""
    pair = rm.Actuator(prestress=(0.2, 0.2))
    field = build(pair, rm.Constant(0.1))
    own = {**pair.parameters(), "m": 0.0}
    row = np.array([own[name] for name in field.parameters])
    body = StaticState(field, row, np.array([1.0, 0.0, 1.0, 0.0])).at_thickness(1.2)
    assert body is not None
    one = rm.equilibria(rm.Actuator(prestress=0.2), body.load)
    assert float(one.equilibrium_stretch[0]) == pytest.approx(1.2, abs=1e-12)
    modes = controllable_poles(*body.linearised())
    np.testing.assert_allclose(
        sorted(modes.imag), np.array([-1, 1]) * float(one.natural_frequency[0])
    )
    row[field.parameters.index("prestress_2")] = 0.3
    bent = StaticState(field, row, body.state).at_thickness(1.2)
    assert bent is not None
    assert controllable_poles(*bent.linearised()).size == 4
    assert bent.thickness() == pytest.approx(1.2, abs=1e-12)
