"""Verbs of motion and of regimes where every point of `over` is invalid."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import xarray as xr

import remanent as rm

BODY = rm.Actuator(dissipation=rm.Rayleigh(0.1))
DRIVE = rm.SineSquared(0.4, 1.25)
Verb = Callable[[dict[str, list[float]]], xr.Dataset]
CALLS: dict[str, Verb] = {
    "lyapunov": lambda over: rm.lyapunov(BODY, DRIVE, periods=10, over=over),
    "classify": lambda over: rm.classify(BODY, DRIVE, periods=100, over=over),
    "regime_chart": lambda over: rm.regime_chart(
        BODY, DRIVE, {**over, "temperature": [293.0]}, periods=100
    ),
    "bifurcation_diagram": lambda over: rm.bifurcation_diagram(
        BODY, DRIVE, "temperature", [293.0], discard=2, keep=2, over=over
    ),
    "basins": lambda over: rm.basins(BODY, DRIVE, {"stretch": [1.0]}, periods=100, over=over),
    "symmetry_check": lambda over: rm.symmetry_check(BODY, DRIVE, over=over),
    "poincare_section": lambda over: rm.poincare_section(BODY, DRIVE, periods=3, over=over),
    "poincare_section at a phase": lambda over: rm.poincare_section(
        BODY, DRIVE, periods=3, section_phase=0.3, over=over
    ),
    "crossings": lambda over: rm.crossings(BODY, DRIVE, "energy", 0.0, periods=3, over=over),
    "energy_balance": lambda over: rm.energy_balance(BODY, DRIVE, periods=3, over=over),
    "cycle_losses": lambda over: rm.cycle_losses(BODY, DRIVE, periods=3, discard=1, over=over),
    "manifold_crossing": lambda over: rm.manifold_crossing(
        BODY, DRIVE, "temperature", (290.0, 300.0), over=over
    ),
}


@pytest.mark.parametrize("over", [{"c": [-1.0]}, {"omega": [-1.0]}], ids=["system", "drive"])
@pytest.mark.parametrize("verb", list(CALLS))
def test_a_result_without_a_valid_point_says_so(verb: str, over: dict[str, list[float]]) -> None:
    """Invariant: a failure is a status and NaN, where nothing is valid too."""
    ds = CALLS[verb](over)
    assert (ds.status == rm.Status.INVALID).all()
    for name in ("exponent", "stretch", "dissipated_energy", "crossing_time", "transverse_growth"):
        assert name not in ds.data_vars or ds[name].isnull().all()
