"""Sweeps of a parameter, up and down."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm

DRIVE = rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.2))


def test_a_sweep_shows_hysteresis() -> None:
    """Up and down differ where two motions coexist, and each continues the one before."""
    omega = np.linspace(1.0, 1.25, 11)
    body = rm.Actuator(dissipation=rm.Rayleigh(0.02))
    ds = rm.bifurcation_diagram(
        body, rm.SineSquared(0.5, 1.0), "omega", omega, direction="both", discard=300, keep=3
    )
    assert ds.stretch.dims == ("sweep", "omega", "period")
    apart = np.abs(ds.stretch.sel(sweep="up") - ds.stretch.sel(sweep="down")).max("period")
    assert float(apart.max()) > 0.05
    assert float(apart.min()) < 1e-3
    np.testing.assert_allclose(ds.thickness_stretch, ds.stretch**-2.0, rtol=1e-14)
    up = rm.bifurcation_diagram(body, rm.SineSquared(0.5, 1.0), "omega", omega, discard=300, keep=3)
    assert up.stretch.dims == ("omega", "period")
    np.testing.assert_array_equal(up.stretch, ds.stretch.sel(sweep="up"))


def test_sweeps_over_a_field_are_the_single_ones() -> None:
    """Determinism: each set of parameters is swept as it is alone, both ways."""
    values, temperatures = [0.2, 0.3, 0.4], [280.0, 320.0]
    options: dict[str, Any] = {"direction": "both", "discard": 30, "keep": 3}
    ds = rm.bifurcation_diagram(
        DAMPED, DRIVE, "b", values, over={"temperature": temperatures}, **options
    )
    assert ds.stretch.dims == ("temperature", "sweep", "b", "period")
    for temperature in temperatures:
        body = DAMPED.replace(temperature=temperature)
        alone = rm.bifurcation_diagram(body, DRIVE, "b", values, **options)
        assert {"stretch", "thickness_stretch"} <= set(alone.data_vars)
        for name in alone.data_vars:
            here = ds[name].sel(temperature=temperature)
            np.testing.assert_array_equal(here, alone[name], err_msg=str(name))


def test_bad_arguments_say_what_to_do() -> None:
    """Bad input: the message names the argument that was passed."""
    with pytest.raises(rm.InputError, match="omgea"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omgea", [1.0, 2.0])
    with pytest.raises(rm.InputError, match=r"^`values` must be sorted"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omega", [2.0, 1.0])
    with pytest.raises(rm.InputError, match="`over` must not vary omega"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omega", [1.0, 2.0], over={"omega": [1.0]})
    with pytest.raises(rm.InputError, match="direction"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omega", [1.0, 2.0], direction="left")
