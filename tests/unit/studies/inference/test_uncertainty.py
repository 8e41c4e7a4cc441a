"""Uncertain fields: a monotone measure has the quantiles of its argument."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

import remanent as rm


def natural(found: xr.Dataset) -> Any:
    return found.frequency.isel({"initial.stretch": 0})


NATURAL = rm.Measure(rm.backbone, rm.Actuator(), [1.00001], of=natural)


def test_quantiles_and_shares_of_a_closed_form() -> None:
    """omega_n^2 = 18 T/(293 (1 + 2c)); ln omega_n is a sum, so that shares are known nearly."""
    ds = rm.uncertainty(NATURAL, parameter_ranges={"temperature": norm(293.0, 5.0)}, samples=512)
    exact = np.sqrt(6.0 * norm(293.0, 5.0).ppf(ds["quantile"]) / 293.0)
    assert (abs(ds.value - exact) < 5.0 * ds.value_error).all()
    assert (ds.value_error < 1e-3).all()
    both = {"temperature": (288.0, 298.0), "c": (0.99, 1.01)}
    ds = rm.uncertainty(NATURAL, parameter_ranges=both, samples=256, sobol=True)
    warm, slender = (5.0 / 293.0 / 2.0) ** 2, (0.01 / 3.0) ** 2
    shares = np.array([warm, slender]) / (warm + slender)
    for index in (ds.first_index, ds.total_index):
        np.testing.assert_allclose(index, shares, atol=0.02)
    assert (ds.total_index_error < 0.05).all()


def test_a_history_has_a_band_and_repeats_itself() -> None:
    """Every instant has its quantiles; at rest there is no band; the same seed, the same."""

    def band(rng: int | None) -> xr.Dataset:
        return rm.uncertainty(
            rm.simulate, rm.Actuator(), rm.Constant(0.2), times=[0.0, 1.0, 5.0],
            of="thickness_stretch", parameter_ranges={"c": (0.9, 1.1)}, samples=256, rng=rng,
        )  # fmt: skip

    ds = band(3)
    assert ds.thickness_stretch.dims == ("quantile", "time")
    np.testing.assert_array_equal(ds.thickness_stretch[:, 0], 1.0)
    assert (ds.thickness_stretch.diff("quantile")[:, 1:] > 0.0).all()
    xr.testing.assert_identical(ds, band(3))
    assert not ds.equals(band(4))
    xr.testing.assert_identical(band(None), band(0))
    ends = rm.simulate(rm.Actuator(), rm.Constant(0.2), times=[1.0], over={"c": [0.91, 1.09]})
    expected = np.sort(ends.thickness_stretch.values[:, 0])
    np.testing.assert_allclose(ds.thickness_stretch[[0, 2], 1], expected, atol=5e-4)


def test_physical_sizes_may_be_uncertain() -> None:
    """Of a command of steps: the modulus matters ten times more than the remanence."""
    command = rm.shape_command(rm.Actuator(), 1.2)
    left = [
        rm.uncertainty(
            rm.step_response, rm.Actuator(), command, of="residual_amplitude", duration=10.0,
            parameter_ranges={name: (0.95, 1.05)}, samples=32, quantiles=(0.25, 0.5, 0.75),
        )
        for name in ("shear_modulus", "remanence")
    ]  # fmt: skip
    assert all(float(ds.known_share) == 1.0 for ds in left)
    assert (left[0].residual_amplitude > 5.0 * left[1].residual_amplitude).all()


def test_bad_ranges_are_refused() -> None:
    """The message says which, and what to pass."""
    with pytest.raises(rm.InputError, match="larger upper"):
        rm.uncertainty(NATURAL, parameter_ranges={"c": (1.0, 0.5)})
    with pytest.raises(rm.InputError, match="power of two"):
        rm.uncertainty(NATURAL, parameter_ranges={"c": (0.5, 1.0)}, samples=1000)
    with pytest.raises(rm.InputError, match="at least one"):
        rm.uncertainty(NATURAL, parameter_ranges={})
    with pytest.raises(rm.InputError, match="numeric fields"):
        rm.uncertainty(NATURAL, parameter_ranges={"omega": (0.5, 1.0)})
    with pytest.raises(rm.InputError, match="increase"):
        rm.uncertainty(NATURAL, parameter_ranges={"c": (0.5, 1.0)}, quantiles=(0.9, 0.1))
    with pytest.raises(rm.InputError, match="alone"):
        rm.uncertainty(NATURAL, rm.Actuator(), parameter_ranges={"c": (0.5, 1.0)})


def test_the_deviation_is_that_of_the_distribution() -> None:
    """omega_n = sqrt(6 T/293), T between 250 and 350: no degree of freedom is taken off."""
    warm, exact = {"temperature": (250.0, 350.0)}, 0.11952923
    far = []
    for seed in range(4):
        ds = rm.uncertainty(NATURAL, parameter_ranges=warm, samples=256, rng=seed)
        far.append((float(ds.deviation) - exact) / float(ds.deviation_error))
    assert abs(np.mean(far)) < 1.5
    assert np.max(np.abs(far)) < 6.0
