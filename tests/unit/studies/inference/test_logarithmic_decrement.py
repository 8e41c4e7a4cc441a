"""Damping and frequency of a ringdown are those of the linear oscillator."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm

TRUE = rm.Actuator(dissipation=rm.Rayleigh(0.2), prestress=0.2)


def test_decrement_of_small_oscillations() -> None:
    """(1 + 2c) u'' + 3 eta u' + 18 theta u = 0, over a grid, from the verb's own histories."""
    over = {"dissipation.0.eta": [0.05, 0.1], "temperature": [293.0, 350.0]}
    run = rm.simulate(TRUE.replace(prestress=0.0), rm.Constant(0.0), duration=20.0,
                      initial=(1.00001, 0.0), over=over)  # fmt: skip
    found = rm.logarithmic_decrement(run)
    theta, eta = run.temperature / 293.0, run["dissipation.0.eta"]
    zeta = eta / np.sqrt(8.0 * theta * 3.0)
    omega = np.sqrt(6.0 * theta * (1.0 - zeta**2))
    np.testing.assert_allclose(found.damping_ratio, zeta, rtol=1e-4)
    np.testing.assert_allclose(found.frequency, omega.transpose(*found.dims), rtol=1e-4)


def test_a_record_without_swings_says_why_it_has_no_decrement() -> None:
    """Every number that is missing has its reason, and those beside it have none."""
    time = np.linspace(0.0, 20.0, 400)
    over = {"dissipation.0.eta": [0.1, 9.0]}
    run = rm.simulate(TRUE, rm.Constant(0.0), times=time, initial=(1.001, 0.0), over=over)
    found = rm.logarithmic_decrement(run)
    assert np.isnan(found.decrement).values.tolist() == [False, True]
    assert [bool(reason) for reason in found.reason.values] == [False, True]


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 0.03])
def test_noise_of_dense_records_is_smoothed(noise: float) -> None:
    """Law: the decrement of u'' + eta u'/2 + 6 u = 0 is found within three standard errors."""
    time = np.linspace(0.0, 20.0, 2000)
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    run = rm.simulate(body, rm.Constant(0.0), times=time, initial=(1.001, 0.0))
    size = 0.5 * np.ptp(run.thickness_stretch.values)
    errors = size * noise * np.random.default_rng(1).standard_normal(time.size)
    found = rm.logarithmic_decrement(run.assign(thickness_stretch=run.thickness_stretch + errors))
    zeta = 0.1 / np.sqrt(24.0)
    exact = 2.0 * np.pi * zeta / np.sqrt(1.0 - zeta**2)
    # The motion is that of no small oscillation: it differs by the amplitude, 2e-3, squared.
    assert abs(float(found.decrement) - exact) < 3.0 * float(found.decrement_error) + 1e-4
    assert float(found.decrement_error) < noise


def test_errors_are_the_scatter_of_repetitions() -> None:
    """Law: over records with noise anew, estimates scatter as much as each says of itself."""
    time = np.linspace(0.0, 20.0, 1000)
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    run = rm.simulate(body, rm.Constant(0.0), times=time, initial=(1.001, 0.0))
    rng, size = np.random.default_rng(2), 1e-3 * 0.5 * np.ptp(run.thickness_stretch.values)
    found = [
        rm.logarithmic_decrement(
            run.assign(
                thickness_stretch=run.thickness_stretch + size * rng.standard_normal(time.size)
            )
        )
        for _ in range(24)
    ]
    for name in ("decrement", "frequency"):
        estimates = np.array([float(one[name]) for one in found])
        stated = np.array([float(one[f"{name}_error"]) for one in found])
        assert 0.6 < estimates.std() / stated.mean() < 1.6, name


def test_a_record_needs_its_times() -> None:
    """A decay without `time` is refused in words, whatever the dimension is called."""
    run = rm.simulate(TRUE, rm.Constant(0.0), times=np.linspace(0.0, 20.0, 400), initial=(1.1, 0.0))
    unlabelled = run.drop_vars("time").rename_dims(time="sample")
    with pytest.raises(rm.InputError, match="have thickness_stretch along `time`"):
        rm.logarithmic_decrement(unlabelled)
