"""Pictures of systems that users write: their names, symbols, units and numbers."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.plots.footer import footer_text

WELLS = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="-k*x**2/2 + x**4/4 - load*x",
    dissipation="delta*x_rate**2/2",
    parameters={"delta": 0.25, "k": 1.0},
    units={"x": "mm", "time": "ms", "load": "mN", "delta": "ms-1"},
    symbols={"x": "u", "load": "F", "delta": r"\delta"},
)
BALLOON = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/2",
    potential="stretch**2 + stretch**-4/2 - pressure*stretch**3/3 - voltage*stretch**4/2",
    rest={"stretch": 1.0},
    loads=("pressure", "voltage"),
    units={"pressure": "kPa"},
    symbols={"pressure": "P"},
)


@pytest.fixture(scope="module")
def wells_at_rest() -> xr.Dataset:
    over = {"m": np.linspace(-1.0, 1.0, 11)}
    return rm.equilibria(WELLS, over=over, state_box={"x": (-2.0, 2.0)})


def words_above(axes: Any) -> list[str]:
    legends = [*axes.figure.legends, axes.get_legend()]
    return [text.get_text() for one in legends if one for text in one.get_texts()]


def test_equilibria_are_drawn_between_their_folds(wells_at_rest: xr.Dataset) -> None:
    """Three branches of x^3 - x = F, which meet at F = +-2/3^(3/2), x = -+3^(-1/2)."""
    artists = rm.plot.equilibria(wells_at_rest)
    axes = artists[0].axes
    assert axes is not None
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("load, $F$ (mN)", "x, $u$ (mm)")
    assert sorted(str(line.get_gid()) for line in artists) == ["stable", "stable", "unstable"]
    for line in artists:
        load, x = np.asarray(line.get_xydata()).T
        np.testing.assert_allclose(x**3 - x, load, atol=1e-12)
    (middle,) = (line for line in artists if line.get_gid() == "unstable")
    ends = np.sort(np.asarray(middle.get_xydata())[[0, -1], 1])
    np.testing.assert_allclose(ends, [-(3**-0.5), 3**-0.5], atol=1e-12)
    plt.close("all")


def test_a_frequency_falls_to_zero_at_a_fold(wells_at_rest: xr.Dataset) -> None:
    """Its unit is one over the user's unit of time."""
    artists = rm.plot.equilibria(wells_at_rest, "natural_frequency")
    axes = artists[0].axes
    assert axes is not None
    assert axes.get_ylabel() == "natural frequency, $\\omega_n$ (rad ms$^{-1}$)"
    assert min(np.nanmin(np.asarray(line.get_ydata(), dtype=float)) for line in artists) == 0.0
    plt.close("all")


def test_where_nothing_holds_there_is_no_equilibrium() -> None:
    """A balloon above its largest pressure has a mark, which says that nothing is missing."""
    at_rest = rm.equilibria(
        BALLOON, over={"pressure.m": [0.0, 0.5, 1.0, 1.5]}, state_box={"stretch": (0.5, 4.0)}
    )
    axes = rm.plot.equilibria(at_rest)[0].axes
    assert axes is not None
    assert "no equilibrium" in words_above(axes)
    assert "pressure" in axes.get_xlabel()
    assert "(kPa)" in axes.get_xlabel()
    plt.close("all")


def test_a_fit_is_drawn_in_the_units_of_the_user() -> None:
    """Data and curve against time, and what is left between them."""
    loads, start = rm.Constant(0.1), (0.5, 0.0)
    run = rm.simulate(WELLS, loads, times=np.linspace(0.0, 10.0, 30), initial=start)
    found = rm.fit(WELLS, loads, run[["x"]], {"delta": 0.2}, initial=start)
    points, curve = rm.plot.fit(found)
    axes = points.axes
    assert axes is not None
    assert axes.get_ylabel() == "x, $u$ (mm)"
    assert axes.get_xlabel().endswith("(ms)")
    np.testing.assert_array_equal(np.asarray(points.get_ydata()), run.x.values)
    np.testing.assert_allclose(np.asarray(curve.get_ydata()), run.x.values, atol=1e-6)
    left = rm.plot.fit(found, residuals=True)[0].axes
    assert left is not None
    assert left.get_ylabel() == "residual of $u$ (mm)"
    plt.close("all")


def test_the_footer_says_the_numbers_of_the_system_and_of_each_load() -> None:
    """By the user's symbols and units; fields that are shown are left out."""
    run = rm.simulate(WELLS, rm.Sine(0.3, 1.2), duration=2.0)
    text = footer_text(run)
    for piece in (r"$\delta = 0.25$ ms$^{-1}$", "$k = 1$", "$F = 0.3$ mN"):
        assert piece in text
    loads = {"pressure": rm.Constant(0.2), "voltage": rm.Sine(0.05, 2.0)}
    both = footer_text(rm.simulate(BALLOON, loads, duration=2.0))
    assert "pressure: Constant ($m = 0.2$)" in both
    assert "voltage: Sine ($m = 0.05$" in both
    varied = rm.simulate(BALLOON, loads, duration=2.0, over={"pressure.m": [0.1, 0.2]})
    assert "pressure: Constant " in footer_text(varied) + " "
    assert "0.2" not in footer_text(varied)


def test_the_footer_says_bounds_as_numbers() -> None:
    """No brackets of an array of code."""
    over = {"pressure.m": [0.0, 0.5]}
    at_rest = rm.equilibria(BALLOON, over=over, state_box={"stretch": (0.5, 4.0)})
    assert "state box $0.5$, $4$" in footer_text(at_rest)


def test_bars_name_parameters_by_the_symbols_of_the_user() -> None:
    """Each field has its meaning and symbol."""
    measure = rm.Measure(rm.simulate, WELLS, rm.Constant(0.1), times=[4.0], of="x")
    rm.plot.bars(rm.sensitivity(measure, parameters=["delta", "k"]))
    labels = [label.get_text().replace("\n", " ") for label in plt.gca().get_yticklabels()]
    assert set(labels) == {r"delta, $\delta$", "k, $k$"}
    plt.close("all")
