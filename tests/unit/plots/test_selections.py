"""Every plot draws every ordinary selection of a result, in any figure, and never two alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import remanent as rm
from remanent import plots
from remanent._errors import InputError
from remanent.plots import footer, style
from tests.unit.plots import synthetic

DRIVE = rm.SineSquared(0.4, 1.25)
OVER = {"prestress": [0.0, 0.5, 1.0], "temperature": [250.0, 300.0, 350.0, 400.0]}


@cache
def results() -> Mapping[str, tuple[Callable[..., Any], xr.Dataset]]:
    """A plot and a result of a verb for each, over prestress and temperature."""
    actuator = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    block = rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length="5 mm",
        half_thickness="0.5 mm", remanence="140 mT", dissipation=rm.Rayleigh(0.1),
    )  # fmt: skip
    run = rm.simulate(actuator, DRIVE, duration=3.0, over=OVER)
    grid = [0.8, 1.0, 1.2, 1.4]
    response = rm.frequency_response(actuator, DRIVE, grid, duration=8.0, over=OVER)
    diagram = synthetic.diagram()
    pulled = {"m": [1.8, 2.2, 2.6], "temperature": [280.0, 310.0], "prestress": [2.1, 2.2]}
    return {
        "history": (plots.history, run),
        "phase": (plots.phase, run),
        "curve": (partial(plots.curve, variable="thickness_stretch", x="time"), run),
        "against temperature": (
            partial(plots.curve, variable="resonance", x="temperature"), response),
        "section": (plots.section, rm.poincare_section(actuator, DRIVE, periods=6, over=OVER)),
        "response": (plots.response, response),
        "response in SI": (plots.response, rm.to_si(
            rm.frequency_response(block, DRIVE, grid, duration=8.0, over=OVER))),
        "branch": (plots.branch, diagram),
        "landscape": (plots.landscape, synthetic.potential()),
        "equilibria": (plots.equilibria, rm.equilibria(rm.Actuator(), over=pulled)),
        "map": (partial(plots.map, variable="resonance"), response),
    }  # fmt: skip


def looks(handle: Any) -> tuple[str, ...]:
    """What a legend entry looks like."""
    if hasattr(handle, "get_linestyle") and hasattr(handle, "get_marker"):
        return (mpl.colors.to_hex(handle.get_color()), str(handle.get_linestyle()),
                str(getattr(handle, "_dash_pattern", "")), str(handle.get_marker()),
                str(handle.get_markerfacecolor()), str(handle.get_linewidth()),
                str(bool(handle.get_path_effects())))  # fmt: skip
    return (str(handle.get_facecolor()), str(handle.get_hatch()))


def require_unlike_entries(axes: Any) -> None:
    """No two entries of a legend read or look the same; words without a sample may."""
    legend = axes.get_legend()
    if legend is None:
        return
    names = [text.get_text() for text in legend.get_texts()]
    assert len(set(names)) == len(names)
    samples = [looks(h) for h in legend.legend_handles]
    shown = [s for s in samples if len(s) == 2 or s[1] != "None" or s[3] not in {"None", ""}]
    assert len(set(shown)) == len(shown), list(zip(names, samples, strict=True))


def some_of(draw: st.DrawFn, dataset: xr.Dataset) -> xr.Dataset:
    """An ordinary selection: a number, a list, a slice or all along each of its dimensions."""
    for dim in ("prestress", "temperature", "m", "omega"):
        if dim not in dataset.sizes:
            continue
        size = dataset.sizes[dim]
        kind = draw(st.sampled_from(["all", "number", "list", "slice"]))
        if kind == "number":
            dataset = dataset.isel({dim: draw(st.integers(0, size - 1))})
        elif kind == "list":
            dataset = dataset.isel({dim: [draw(st.integers(0, size - 1))]})
        elif kind == "slice":
            dataset = dataset.isel({dim: slice(0, draw(st.integers(1, size)))})
    return dataset


@st.composite
def selections(draw: st.DrawFn) -> tuple[Callable[..., Any], xr.Dataset, bool]:
    """A plot, a selection of its result with some values lost, and whether axes are given."""
    name = draw(st.sampled_from(sorted(results())))
    plot, whole = results()[name]
    dataset = some_of(draw, whole).copy(deep=True)
    if draw(st.booleans()):
        dataset = dataset.drop_attrs()
        if name in {"equilibria"}:
            plot = partial(plot, parameter="m")
    for variable in dataset.data_vars.values():
        if variable.dtype.kind == "f" and variable.size and draw(st.booleans()):
            cut = draw(st.integers(0, variable.size))
            flat = variable.values.reshape(-1)
            flat[cut:] = np.nan
            variable.values[...] = flat.reshape(variable.shape)
    return plot, dataset, draw(st.booleans())


@settings(max_examples=20, deadline=None)
@given(selections())
def test_every_ordinary_selection_is_drawn(
    case: tuple[Callable[..., Any], xr.Dataset, bool],
) -> None:
    """Selecting, losing values and losing attributes never break a plot; names differ.

    Only a plot of what has no dimension left to run along is refused, with a message.
    """
    plot, dataset, given_axes = case
    axes = Figure(layout="constrained").add_subplot() if given_axes else None
    before = dataset.copy(deep=True)
    try:
        artists = plot(dataset, ax=axes) if given_axes else plot(dataset)
    except InputError:
        # Said before anything is drawn, in the words of the package.
        return
    finally:
        xr.testing.assert_identical(dataset, before)
        plt.close("all")
    first = artists if not isinstance(artists, list) else artists[0] if artists else None
    if first is not None:
        assert isinstance(first.axes, Axes)
        require_unlike_entries(first.axes)
        figure = first.axes.get_figure(root=True)
        assert figure is not None
        figure.draw_without_rendering()


@pytest.mark.parametrize("name", ["history", "phase", "curve", "section", "response", "landscape"])
def test_one_temperature_of_several_is_drawn(name: str) -> None:
    """``.isel(temperature=0)`` leaves one line for each prestress, each told from the others."""
    plot, dataset = results()[name]
    artists = plot(dataset.isel(temperature=0))
    count = dataset.sizes["prestress"]
    assert len(artists) == count
    colours = {tuple(np.ravel(a.get_color() if hasattr(a, "get_color") else a.get_facecolor()))
               for a in artists}  # fmt: skip
    assert len(colours) == count
    require_unlike_entries(artists[0].axes)


def test_as_many_styles_as_there_are_and_no_more() -> None:
    """Six prestresses at two temperatures: colours for the six; six by six are refused."""
    whole = synthetic.frequency_response(7, 10.0)
    many = whole.isel(prestress=[0, 1, 0, 1, 0, 1]).assign_coords(prestress=np.arange(6.0))
    artists = plots.response(many.isel(temperature=[0, 2]))
    axes = artists[0].axes
    assert axes is not None
    require_unlike_entries(axes)
    told = {(str(a.get_color()), str(a.get_linestyle())) for a in artists}
    assert len(told) == len(artists)
    more = many.isel(temperature=[0, 1, 2, 0, 1]).assign_coords(temperature=np.arange(250.0, 255.0))
    with pytest.raises(InputError, match=r"isel\("):
        plots.response(more)


def test_many_numbers_get_a_colour_bar() -> None:
    """Twelve temperatures have a bar with ticks instead of seven rows of names."""
    values = np.linspace(250.0, 400.0, 12)
    whole = synthetic.frequency_response(7, 10.0).isel(prestress=0)
    many = whole.isel(temperature=np.arange(12) % 3).assign_coords(temperature=values)
    axes = plots.response(many)[0].axes
    assert axes is not None
    figure = axes.get_figure(root=True)
    assert figure is not None
    (bar,) = [one for one in figure.axes if one is not axes]
    assert bar.get_ylabel() == "temperature, $T$ (K)"
    assert bar.get_ylim() == (250.0, 400.0)


def test_joined_results_are_drawn_without_axes() -> None:
    """What concatenation drops from the attributes is left out of the footer."""
    parts = [rm.simulate(rm.Actuator(), DRIVE.replace(b=b), duration=2.0 + b) for b in (0.2, 0.4)]
    joined = xr.concat(parts, pd.Index(["weak", "strong"], name="case"), join="inner",
                       combine_attrs="drop_conflicts")  # fmt: skip
    assert len(plots.history(joined)) == 2
    measure = rm.Measure(rm.frequency_response, rm.Actuator(), DRIVE, [0.8, 1.0, 1.2],
                         of="resonance_amplitude", duration=5.0)  # fmt: skip
    found = [rm.sensitivity(measure, parameters=["c", "b"], step=step) for step in (0.01, 0.02)]
    together = xr.concat(found, pd.Index(["fine", "coarse"], name="measure"),
                         combine_attrs="drop_conflicts")  # fmt: skip
    figure = plots.bars(together)[0].patches[0].get_figure(root=True)
    assert isinstance(figure, Figure)
    assert "remanent" in figure.get_supxlabel()


def test_the_footer_has_the_units_of_the_axes() -> None:
    """In SI it says Hz, mT, ms, Pa s and what the block was built with."""
    dataset = results()["response in SI"][1].isel(prestress=0, temperature=0)
    text = footer.footer_text(dataset)
    for piece in (r"$\mu = 100$ kPa", r"$B_r = 140$ mT", "mT", " ms", "Pa s", "kPa"):
        assert piece in text
    for piece in (r"\omega =", r"\tau_w", r"$b ="):
        assert piece not in text


def test_axes_of_the_user_keep_their_style() -> None:
    """Labels that are there stay, a second plot adds to the legend, fonts are the user's."""
    with plt.style.context("default"):
        axes = Figure(layout="constrained").add_subplot()
        axes.set_xlabel("my frequency")
        plots.branch(synthetic.fold(), ax=axes)
        plots.response(
            synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=0), ax=axes
        )
        assert axes.get_xlabel() == "my frequency"
        assert axes.get_ylabel() == r"thickness stretch amplitude, $\lambda_3^a$"
        legend = axes.get_legend()
        assert legend is not None
        names = [text.get_text() for text in legend.get_texts()]
        assert {"stable", "saddle", "fold", "resonance", "published"} <= set(names)
        assert {text.get_fontname() for text in legend.get_texts()} == {"DejaVu Sans"}


@pytest.mark.parametrize(
    "width", [style.SINGLE_COLUMN_WIDTH_INCHES, style.DOUBLE_COLUMN_WIDTH_INCHES]
)
@pytest.mark.parametrize("name", ["response", "section", "branch", "equilibria", "map"])
def test_nothing_sticks_out_of_a_column(name: str, width: float) -> None:
    """All text of a figure of a journal's width lies inside it."""
    plot, dataset = results()[name]
    figure, axes = style.subplots(figsize=(width, 2.6))
    plot(dataset.isel(prestress=0), ax=axes) if name != "map" else plot(dataset, ax=axes)
    figure.draw_without_rendering()
    box, (wide, high) = figure.get_tightbbox(), figure.get_size_inches()
    assert box.x0 >= -0.02
    assert box.x1 <= wide + 0.02
    assert box.y0 >= -0.02
    assert box.y1 <= high + 0.02


def test_settings_in_si_are_said_once_converted() -> None:
    """A duration of 60 ms is 60 ms below a figure, and so are what is discarded and ranges."""
    block = rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length="5 mm",
        half_thickness="0.5 mm", remanence="140 mT", dissipation=rm.Rayleigh(0.5),
    )  # fmt: skip
    untyped: Any = rm
    run = untyped.frequency_response(block, DRIVE, ["200 Hz"], duration="60 ms", discard="30 ms")
    text = footer.footer_text(rm.to_si(run))
    assert "$t_w = 60$ ms" in text
    assert "discard $30$ ms" in text
    peaks = run.assign_attrs(
        settings="duration parameter_range", parameter_range=(1.0, 1.4), parameter="omega",
        duration=int(block.time("1 s")),
    )  # fmt: skip
    assert r"$\omega$ from $1$ to $1.4$" in footer.footer_text(peaks)
    converted = rm.to_si(peaks)
    low, high = converted.attrs["parameter_range"]
    assert f"$f$ from ${low:.6g}$ to ${high:.6g}$ Hz" in footer.footer_text(converted)
    # A whole number of units of tau is a length of time too.
    assert 0.99e3 < converted.attrs["duration"] <= 1e3
