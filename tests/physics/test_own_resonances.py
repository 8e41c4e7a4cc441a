"""Resonances of systems that users write, against the linear oscillator and weak nonlinearity."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm

BOX = {"x": (-3.0, 3.0), "x_rate": (-3.0, 3.0)}


def oscillator(potential: str, damping: float, **others: Any) -> rm.LagrangianSystem:
    return rm.LagrangianSystem(
        coordinates="x",
        kinetic="x_rate**2/2",
        potential=f"{potential} - load*x",
        dissipation="damping*x_rate**2/2",
        parameters={"damping": damping},
        **others,
    )


def within(ds: xr.Dataset, name: str, exact: float, **where: int) -> bool:
    one = ds[name].isel(where)
    return bool(abs(one - exact) <= ds[f"{name}_error"].isel(where))


@pytest.mark.parametrize("damping", [0.2, 0.4])
@pytest.mark.parametrize("observable", ["x", "50*x - 3"])
def test_the_peak_of_a_linear_oscillator(damping: float, observable: str) -> None:
    """w^2 = 1 - 2 z^2 with z = damping/2; amplitude and lag of the first harmonic there.

    An observable in other units has the same peak, fifty times as high.
    """
    zeta, force = 0.5 * damping, 0.2
    system = oscillator("x**2/2", damping, observable=observable)
    ds = rm.resonances(system, rm.Sine(force, 1.0), (0.6, 1.4), state_box=BOX, slices=1)
    omega = (1.0 - 2.0 * zeta**2) ** 0.5
    size = force / (2.0 * zeta * (1.0 - zeta**2) ** 0.5)
    assert ds.resonance_kind.values.tolist() == ["primary"]
    assert within(ds, "omega", omega, peak=0)
    assert within(ds, "amplitude", size * (50.0 if "50" in observable else 1.0), peak=0)
    assert within(ds, "phase_lag", float(np.arctan2(omega, zeta)), peak=0)
    assert within(ds, "share", 1.0, peak=0)
    assert within(ds, "free_frequency", 1.0, peak=0)
    assert within(ds, "detuning", omega - 1.0, peak=0)
    assert float(ds.omega_error.max()) < 1e-6


@pytest.mark.slow
def test_a_hard_spring_has_superharmonic_resonance_by_thirds() -> None:
    """A cubic force answers at three times the frequency of the load, and at a third."""
    hard = oscillator("x**2/2 + x**4/4", 0.05, units={"x": "mm", "time": "s"})
    low = rm.resonances(hard, rm.Sine(0.5, 1.0), (0.3, 0.5), state_box=BOX, slices=1)
    strongest = low.isel(peak=int(np.argmax(low.amplitude.values)))
    assert str(strongest.resonance_kind.values) == "superharmonic"
    assert (int(strongest.order_p), int(strongest.order_q)) == (3, 1)
    assert low.amplitude.attrs["units"] == "mm"
    assert low.free_frequency.attrs["units"] == "rad s-1"


@pytest.mark.slow
def test_a_spring_that_the_load_changes_has_parametric_resonance() -> None:
    """x'' + c x' + (1 + load) x + x^3 = 0 leaves rest at twice its frequency."""
    pumped = rm.LagrangianSystem(
        coordinates="x",
        kinetic="x_rate**2/2",
        potential="(1 + load)*x**2/2 + x**4/4",
        dissipation="0.05*x_rate**2",
    )
    ds = rm.resonances(
        pumped, rm.Sine(0.3, 2.0), (2.0, 3.2), orbit_periods=(2,), state_box=BOX, slices=2
    )
    kinds = set(zip(ds.resonance_kind.values, ds.order_p.values, ds.order_q.values, strict=True))
    assert ("parametric", 1, 2) in kinds


@pytest.mark.slow
def test_resonances_in_one_of_two_wells() -> None:
    """About the rest that is nearest to the state at rest, at the frequency of its well."""
    wells = oscillator("-x**2/2 + x**4/4", 0.3, rest={"x": 0.9})
    ds = rm.resonances(wells, rm.Sine(0.02, 1.0), (1.2, 1.6), slices=1,
                       state_box={"x": (-2.0, 2.0), "x_rate": (-2.0, 2.0)})  # fmt: skip
    assert "primary" in ds.resonance_kind.values.tolist()
    assert float(abs(ds.free_frequency - 2.0**0.5).min()) < 0.01


REFUSED: dict[str, tuple[Any, dict[str, Any], str]] = {
    "two wells alike": (
        oscillator("-x**2/2 + x**4/4", 0.3), BOX, "`state_box` must hold a stable equilibrium",
    ),
    "no well": (
        oscillator("-x**2/2", 0.3), BOX, "`state_box` must hold a stable equilibrium",
    ),
    "two coordinates": (
        rm.LagrangianSystem(
            coordinates=("x", "y"), kinetic="(x_rate**2 + y_rate**2)/2",
            potential="x**2 + y**2 - load*x",
        ),
        {**BOX, "y": (-1.0, 1.0), "y_rate": (-1.0, 1.0)}, "`system` must have one coordinate",
    ),
    "rates": (
        rm.FirstOrderSystem(rates={"x": "v", "v": "-x - 0.1*v + load"}),
        {"x": (-1.0, 1.0), "v": (-1.0, 1.0)}, "`system` must have an energy",
    ),
    "an internal variable": (
        rm.LagrangianSystem(
            coordinates=("x", "xi"), kinetic="x_rate**2/2",
            potential="x**2/2 + (x - xi)**2/2 - load*x", dissipation="xi_rate**2/2",
        ),
        {**BOX, "xi": (-1.0, 1.0)}, "`system` must have no internal variables",
    ),
    "no box": (oscillator("x**2/2", 0.1), {}, "`state_box` must give bounds of x, x_rate"),
}  # fmt: skip


@pytest.mark.parametrize(("system", "box", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_what_has_no_backbone_is_refused(system: Any, box: dict[str, Any], message: str) -> None:
    """By name, with the reason and a way out."""
    with pytest.raises(rm.InputError, match=message):
        rm.resonances(system, rm.Sine(0.1, 1.0), (0.8, 1.2), state_box=box or None)
