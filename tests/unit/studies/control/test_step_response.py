"""What a step leaves: its metrics, its energy, and how they scale."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import remanent as rm
from remanent._typing import FloatArray


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


#: Steps after which a root finder that knows no physics leaves for negative stretches or for
#: another equilibrium, with the thickness stretch at which the motion comes to rest.
FAR_STEPS = [
    ({"c": 0.05, "prestress": 0.2}, 0.3, 2.25, 2.3728853743),
    ({"c": 0.05, "prestress": 0.1}, 0.3, 2.0, 2.1794468528),
    ({"prestress": 2.2}, 0.4, 2.3, 1.6076142682),
    ({"c": 0.01, "prestress": 0.1}, 0.3, 2.25, 2.3970883839),
    ({"c": 0.01, "prestress": 0.1}, 0.3, 2.5, 2.6219122927),
    ({"c": 0.01, "prestress": 0.1}, 0.3, 3.0, 3.0865272482),
]


@pytest.mark.parametrize(("fields", "eta", "load", "rest"), FAR_STEPS)
def test_the_final_rest_is_where_the_motion_ends(
    fields: dict[str, float], eta: float, load: float, rest: float
) -> None:
    """Law: the final thickness stretch is that at the end of a long damped motion."""
    body = rm.Actuator(**fields, dissipation=rm.Rayleigh(eta))  # type: ignore[arg-type]
    ds = rm.step_response(body, rm.Constant(load), duration=80.0)
    assert int(ds.status) == rm.Status.OK
    assert float(ds.final) == pytest.approx(rest, abs=1e-9)
    end = rm.simulate(body, rm.Constant(load), times=[0.0, 500.0]).thickness_stretch[-1]
    assert float(ds.final) == pytest.approx(float(end), abs=1e-6)


def positive_rests(prestress: float, load: float) -> FloatArray:
    """Thickness stretches at rest: x^6 - S x^5 + m x^2 - 1 = 0 of the in-plane stretch x."""
    roots = np.roots([1.0, -prestress, 0.0, 0.0, load, 0.0, -1.0])
    return np.sort(roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)].real ** -2)


@pytest.mark.parametrize("count", [12, pytest.param(400, marks=pytest.mark.slow)])
def test_final_rests_of_a_random_grid_are_roots_of_the_polynomial(count: int) -> None:
    """Law: where one equilibrium is there, every damped motion ends in it."""
    rng = np.random.default_rng(count)
    columns = {
        "c": 10.0 ** rng.uniform(-2.0, 0.0, count),
        "prestress": rng.uniform(0.1, 0.8, count),
        "m": rng.uniform(1.0, 4.75, count),
    }
    over = {name: xr.DataArray(column, dims="case") for name, column in columns.items()}
    body = rm.Actuator(dissipation=rm.Rayleigh(0.3))
    ds = rm.step_response(body, rm.Constant(0.0), duration=60.0, over=over)
    rows = zip(columns["prestress"], columns["m"], strict=True)
    expected = np.concatenate([positive_rests(s, m) for s, m in rows])
    np.testing.assert_allclose(ds.final, expected, rtol=1e-11)
    assert set(ds.status.values.tolist()) <= {rm.Status.OK, rm.Status.INCOMPLETE}
    assert ((ds.reason == "") == (ds.status == rm.Status.OK)).all()


@pytest.mark.parametrize("count", [6, pytest.param(60, marks=pytest.mark.slow)])
def test_among_three_equilibria_the_final_rest_is_the_one_that_scipy_reaches(count: int) -> None:
    """Law: the final rest is the end of the motion that DOP853 follows to a standstill."""
    rng = np.random.default_rng(count)
    columns = {
        "prestress": rng.uniform(1.9, 2.6, count),
        "m": rng.uniform(1.5, 3.0, count),
        "initial.stretch": rng.uniform(0.6, 2.5, count),
    }
    over = {name: xr.DataArray(column, dims="case") for name, column in columns.items()}
    ds = rm.step_response(rm.Actuator(dissipation=rm.Rayleigh(0.3)), rm.Constant(0.0), over=over)
    for k, (s, m, x) in enumerate(zip(*columns.values(), strict=True)):

        def rates(_: float, y: FloatArray, s: float = s, m: float = m) -> list[float]:
            x, v = y
            force = x**8 - x**2 - s * x**7 + m * x**4 + 0.3 * v * x**7
            return [v, (6.0 * v * v - 3.0 * force) / (x**7 + 2.0 * x)]

        way = solve_ivp(rates, (0.0, 150.0), [x, 0.0], method="DOP853", rtol=1e-8, atol=1e-8)
        rests = positive_rests(s, m)
        nearest = rests[np.argmin(np.abs(rests - way.y[0, -1] ** -2))]
        assert float(ds.final[k]) == pytest.approx(nearest, rel=1e-9)


def test_a_motion_over_a_barrier_that_nothing_stops_has_no_final_rest() -> None:
    """Law: without dissipation a motion with more energy than the barrier visits both wells."""
    body = rm.Actuator(prestress=2.2)
    ds = rm.step_response(body, rm.Constant(2.5), initial=(4.0, 0.0), duration=30.0)
    assert np.isnan(float(ds.final))
    assert int(ds.status) == rm.Status.INCOMPLETE
    assert "barrier" in str(ds.reason.values)


def test_settling_is_decided_at_turning_points() -> None:
    """Law: the last peak beyond the band counts, also where it lies between any samples.

    The value is the last passage of the band by DOP853 at 1e-13.
    """
    body = rm.Actuator(dissipation=rm.Rayleigh(0.69))
    ds = rm.step_response(body, rm.Constant(0.5), duration=100.0)
    assert abs(float(ds.settling_time) - 16.924030) < 1e-6
    assert float(ds.settling_time_error) < 1e-5


def test_a_run_that_is_too_short_says_what_is_missing() -> None:
    """Law: a number that is missing has a status and a reason."""
    damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    ds = rm.step_response(damped, rm.Constant(0.1), duration=1e-300)
    assert np.isnan(float(ds.rise_time))
    assert (int(ds.status), "90 %" in str(ds.reason.values)) == (rm.Status.INCOMPLETE, True)
    short = rm.step_response(damped, rm.Constant(0.1), duration=5.0)
    assert (int(short.status), "settled" in str(short.reason.values)) == (9, True)
    with pytest.raises(rm.InputError, match="longer than the command"):
        rm.step_response(damped, rm.Steps([0.0, 2.0], [0.1, 0.2]), duration=2.0)
    shaped = rm.Actuator(c=0.05, prestress=0.2)
    landed = rm.step_response(shaped, rm.shape_command(shaped, 2.2))
    assert float(landed.final) == pytest.approx(2.2, abs=1e-12)
    assert float(landed.residual_amplitude) < 1e-8


def test_invalid_points_have_a_status() -> None:
    """Law: a value that breaks a rule leaves NaN and the status invalid, also everywhere."""
    ds = rm.step_response(rm.Actuator(), rm.Constant(0.2), over={"c": [-1.0]})
    assert ds.status.values.tolist() == [rm.Status.INVALID]
    assert all(np.isnan(ds[name]).all() for name in ("final", "rise_time", "overshoot"))


def test_an_adiabatic_body_rests_at_the_temperature_that_it_has_come_to() -> None:
    """Law: what is dissipated warms the body, and the warmer body rests where its motion ends."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.3), heat=rm.Heat(coupling=2e-3))
    ds = rm.step_response(body, rm.Constant(0.3), duration=60.0)
    end = rm.simulate(body, rm.Constant(0.3), times=[0.0, 300.0]).thickness_stretch[-1]
    assert abs(float(ds.final) - float(end)) <= float(ds.final_error) + 1e-9
    isothermal = rm.step_response(body.replace(heat=None), rm.Constant(0.3), duration=60.0)
    assert abs(float(ds.final) - float(isothermal.final)) > 1e-6


def test_turns_below_the_tolerance_are_not_lost() -> None:
    """Law: settling is judged by the change, however small that is beside the tolerance.

    A change of 0.0017 swings about its end with rates that soon fall below a tolerance of 4e-4.
    """
    body = rm.Actuator(
        c=0.4214616, temperature=267.206951, prestress=-0.26, dissipation=rm.Rayleigh(1.3038)
    )
    loose, fine = (
        rm.step_response(body, rm.Constant(-0.265), duration=60.0, tolerance=t)
        for t in (3.7e-4, 1e-10)
    )
    for name in ("rise_time", "settling_time", "overshoot"):
        assert abs(float(loose[name] - fine[name])) <= float(loose[f"{name}_error"]), name


@pytest.mark.parametrize("duration", np.linspace(5.0, 9.0, 17))
def test_a_motion_without_damping_never_settles(duration: float) -> None:
    """Wherever in its band, or outside, the run of an undamped motion ends."""
    ds = rm.step_response(rm.Actuator(), rm.Constant(0.3), duration=float(duration), band=0.4)
    assert np.isnan(ds.settling_time)
    assert np.isnan(ds.settling_time_error)


def test_a_band_that_holds_the_start_is_settled_in_from_there() -> None:
    """An overdamped motion never leaves a band of one and a half times its way: exactly 0."""
    ds = rm.step_response(rm.Actuator(dissipation=rm.Rayleigh(5.0)), rm.Constant(0.3), band=1.5)
    assert (float(ds.settling_time), float(ds.settling_time_error)) == (0.0, 0.0)


@pytest.mark.parametrize("temperature", [293.0, 500.0])
def test_a_run_lasts_ten_natural_periods(temperature: float) -> None:
    """2 pi over the natural frequency at the last rest, which slight damping hardly changes."""
    body = rm.Actuator(temperature=temperature, dissipation=rm.Rayleigh(0.05))
    ds = rm.step_response(body, rm.Steps([0.0, 1.5], [0.2, 0.3]))
    frequency = float(rm.equilibria(body, 0.3).natural_frequency.item())
    assert ds.attrs["duration"] == pytest.approx(1.5 + 20.0 * np.pi / frequency, rel=1e-3)
