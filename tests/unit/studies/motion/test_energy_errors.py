"""Errors of energies, works and losses, and what a manifold that is not crossed says."""

from __future__ import annotations

import numpy as np
import xarray as xr

import remanent as rm
from remanent.studies.regimes._attractors import error_of_fraction


def test_errors_of_a_balance_cover_a_finer_one() -> None:
    """Random damped bodies: each column at 1e-5 is within its error of that at 1e-12."""
    rng = np.random.default_rng(11)
    columns = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0, 12), "dissipation.0.eta": rng.uniform(0.02, 0.5, 12),
        "b": rng.uniform(0.2, 0.9, 12), "omega": rng.uniform(0.6, 2.0, 12),
    }  # fmt: skip
    over = {name: xr.DataArray(values, dims="case") for name, values in columns.items()}
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25)
    coarse, fine = (
        rm.energy_balance(body, drive, times=np.linspace(0, 20, 9), over=over, tolerance=t)
        for t in (1e-5, 1e-12)
    )
    for name in ("drive_work", "dissipated_energy", "stored_energy", "mean_thickness_stretch"):
        off = abs(coarse[name] - fine[name]).max("time")
        assert (off <= coarse[f"{name}_error"]).all(), name
    assert (abs(coarse.balance).max("time") <= coarse.balance_error).all()
    coarse, fine = (
        rm.cycle_losses(body, drive, periods=8, over=over, tolerance=t) for t in (1e-5, 1e-12)
    )
    for name in ("drive_work", "dissipated_energy"):
        assert (abs(coarse[name] - fine[name]).max("period") <= coarse[f"{name}_error"]).all()


def test_a_manifold_without_a_saddle_says_so() -> None:
    """Where motion crosses it, a number; elsewhere incomplete, with the reason."""
    ds = rm.manifold_crossing(
        rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25), "omega", (1.25, 1.26),
        width=1e-3, over={"temperature": [293.0, 350.0]},
    )  # fmt: skip
    assert ds.status.values.tolist() == [rm.Status.INCOMPLETE, rm.Status.OK]
    assert "saddle" in str(ds.reason.values[0])
    assert str(ds.reason.values[1]) == ""
    assert np.isnan(ds.omega[0])


def test_a_fraction_of_few_states_is_uncertain() -> None:
    """Wilson's interval for all of two: from 2/3, so that the error is 1/3; 68 % for many."""
    assert abs(float(error_of_fraction(np.array(1.0), 2)) - 1.0 / 3.0) < 1e-15
    rng = np.random.default_rng(2)
    for count in (2, 10, 100):
        share = rng.uniform(size=20000)
        seen = rng.binomial(count, share) / count
        covered = np.abs(seen - share) <= error_of_fraction(seen, count)
        assert covered.mean() > 0.68, count
