"""Viscosity: limits, losses, and what temperature does to it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import remanent as rm

DRIVE = rm.SineSquared(0.4, 1.25)
TIMES = np.linspace(0.0, 10.0, 41)


def stretch(dissipation: Any, **fields: Any) -> np.ndarray:
    actuator = rm.Actuator(dissipation=dissipation, **fields)
    ds = rm.simulate(actuator, DRIVE, times=TIMES, tolerance=1e-10)
    assert int(ds.status) == 1
    return np.asarray(ds.stretch.values)


def test_a_branch_that_never_relaxes_is_a_spring_in_parallel() -> None:
    """t_r to infinity: elastic with mu + mu_v, that is theta (1 + mu_v) for m and S as given."""
    spring = rm.simulate(
        rm.Actuator(temperature=293.0 * 1.5), DRIVE, times=TIMES, tolerance=1e-10
    ).stretch.values
    errors = [np.abs(stretch(rm.Zener(0.5, t)) - spring).max() for t in (1e4, 1e5, 1e6)]
    assert errors[-1] < 1e-6
    assert np.diff(np.log10(errors)) == pytest.approx([-1.0, -1.0], abs=0.1)


def test_a_branch_that_relaxes_at_once_vanishes_to_first_order() -> None:
    """t_r to 0: elastic with mu, and the difference is proportional to t_r."""
    soft = stretch(())
    times = np.array([0.01, 0.005, 0.0025])
    errors = [np.abs(stretch(rm.Zener(0.5, t)) - soft).max() for t in times]
    slope = np.polyfit(np.log(times), np.log(errors), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.05)


def test_fast_branches_are_fluids() -> None:
    """To first order in t_r a branch is a Newtonian fluid of viscosity mu_v t_r."""
    errors = []
    for t in (0.02, 0.01):
        branch, fluid = stretch(rm.Zener(0.5, t)), stretch(rm.KelvinVoigt(0.5 * t))
        errors.append(np.abs(branch - fluid).max())
    assert errors[1] < 0.35 * errors[0]


def test_two_halves_of_a_branch_are_one() -> None:
    """A Prony series of two equal branches is a single one of twice the modulus."""
    one = stretch(rm.Zener(0.5, 0.7))
    two = stretch((rm.Zener(0.25, 0.7), rm.Zener(0.25, 0.7)))
    assert np.abs(one - two).max() < 1e-9


@pytest.mark.parametrize(
    ("element", "scaled"),
    [
        (rm.Rayleigh(0.2), lambda root: rm.Rayleigh(0.2 / root)),
        (rm.KelvinVoigt(0.1), lambda root: rm.KelvinVoigt(0.1 / root)),
        (rm.Zener(0.5, 0.7), lambda root: rm.Zener(0.5, 0.7 / root)),
    ],
)
def test_temperature_scales_out(element: Any, scaled: Any) -> None:
    """(theta; m, w, eta, tau) and (1; m/theta, w/r, eta/r, tau r), r = sqrt(theta).

    Law: Reversal and scaling.
    """
    theta = 1.37
    root = math.sqrt(theta)
    warm = rm.Actuator(temperature=293.0 * theta, dissipation=element, prestress=(0.4, 0.1))
    cold = rm.Actuator(dissipation=scaled(root), prestress=(0.4 / theta, 0.1 / theta))
    a = rm.simulate(warm, DRIVE, times=TIMES)
    b = rm.simulate(cold, rm.SineSquared(0.4 / root, 1.25 / root), times=TIMES * root)
    assert float(np.abs(a.stretch_1.values - b.stretch_1.values).max()) <= float(a.error + b.error)


def test_a_shift_is_a_change_of_the_relaxation_time() -> None:
    """log10 a_T = -c1 (T - T0)/(c2 + T - T0); ln a_T = A (1/T - 1/T0)."""
    factor = 10.0 ** (-8.0 * 20.0 / 220.0)
    assert stretch(rm.Zener(0.5, 2.0, rm.WLF(8.0, 200.0)), temperature=313.0) == pytest.approx(
        stretch(rm.Zener(0.5, 2.0 * factor), temperature=313.0), abs=1e-9
    )
    factor = math.exp(3000.0 * (1.0 / 313.0 - 1.0 / 293.0))
    assert stretch(rm.KelvinVoigt(0.2, rm.Arrhenius(3000.0)), temperature=313.0) == pytest.approx(
        stretch(rm.KelvinVoigt(0.2 * factor), temperature=313.0), abs=1e-9
    )


def test_a_frozen_element_is_refused() -> None:
    """Below the pole of the shift an element has no relaxation time."""
    frozen = rm.Zener(0.5, 2.0, rm.WLF(8.0, 30.0))
    with pytest.raises(rm.InputError, match="be above T0 - c2"):
        rm.Actuator(temperature=250.0, dissipation=frozen)
    ds = rm.simulate(
        rm.Actuator(dissipation=frozen),
        DRIVE,
        times=[0.0, 1.0],
        over={"temperature": [250.0, 293.0]},
    )
    assert ds.status.values.tolist() == [4, 1]


def test_small_oscillations_lose_what_linear_theory_says() -> None:
    """Loss of a Zener branch: pi Y'' a^2, Y'' = 12 mu_v w t/(1 + w^2 t^2)/..., per period.

    For small equal stretches the branch's energy is 6 mu_v e^2 with the spring's strain e =
    ln(l/xi) and e' = strain rate - e/t_r, a linear Maxwell element of modulus 12 mu_v.
    """
    modulus, t, w, amplitude = 0.4, 0.8, 1.7, 1e-3
    body = rm.Actuator(dissipation=rm.Zener(modulus, t))
    ds = rm.cycle_losses(body, rm.Sine(amplitude, w), periods=60, discard=59, tolerance=1e-12)
    path = rm.simulate(body, rm.Sine(amplitude, w), periods=60, tolerance=1e-11)
    late = path.stretch.values[path.time.values > 59 * 2.0 * math.pi / w]
    a = 0.5 * (late.max() - late.min())
    viscous = 12.0 * modulus * w * t / (1.0 + (w * t) ** 2)
    assert float(ds.dissipated_energy[0]) == pytest.approx(math.pi * viscous * a**2, rel=1e-3)
    assert float(ds.drive_work[0]) == pytest.approx(float(ds.dissipated_energy[0]), rel=1e-2)


@pytest.mark.slow
def test_damped_motion_is_labelled_and_has_basins() -> None:
    """A branch with internal variables ends on one periodic attractor, the orbit found."""
    body = rm.Actuator(dissipation=rm.Zener(0.5, 1.0))
    ds = rm.basins(body, DRIVE, {"stretch": [0.8, 1.3], "stretch_rate": [0.0, 0.4]}, periods=150)
    assert ds.basin.values.tolist() == [[0, 0], [0, 0]]
    orbit = rm.periodic_orbits(body, DRIVE)
    assert orbit.stability.values.tolist() == ["stable"]
    assert ds.attractor_state.values[0] == pytest.approx(orbit.initial.values[0], abs=1e-6)


@pytest.mark.slow
def test_damped_response_is_a_single_stable_branch() -> None:
    """Strong damping leaves one response at each frequency, and it is stable."""
    ds = rm.response_diagram(rm.Actuator(dissipation=rm.Zener(1.0, 1.0)), DRIVE, (1.1, 1.4))
    assert ds.sizes["branch"] == 1
    assert set(ds.stability.values.ravel().tolist()) - {""} == {"stable"}
