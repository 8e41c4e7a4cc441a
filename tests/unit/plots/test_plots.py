"""Laws that every plot obeys, and what each of them shows."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import remanent as rm
from remanent import plots
from remanent._errors import InputError
from remanent.plots import footer, style
from remanent.results.si import to_si
from tests.contracts.sound_calls import SOUND
from tests.unit.plots import synthetic

Plot = Callable[..., Sequence[Artist]]
#: Every plot with a Dataset of six members, (prestress, temperature).
KINDS: dict[str, tuple[Plot, Callable[[], xr.Dataset]]] = {
    "history": (plots.history, lambda: synthetic.constant(6.0, 61)),
    "curve": (
        partial(plots.curve, variable="thickness_stretch", x="time"),
        lambda: synthetic.constant(6.0, 61),
    ),
    "phase": (plots.phase, lambda: synthetic.constant(6.0, 61)),
    "section": (
        plots.section,
        lambda: xr.concat(
            [synthetic.sections(0.0, 1.25, 12), synthetic.sections(1.0, 1.25, 12)],
            dim="prestress",
        ),
    ),
    "response": (plots.response, lambda: synthetic.frequency_response(7, 10.0)),
    "landscape": (plots.landscape, synthetic.potential),
}
every_plot = pytest.mark.parametrize("kind", KINDS)


def case(kind: str) -> tuple[Plot, xr.Dataset]:
    draw, make = KINDS[kind]
    return draw, make()


def figure_of(artists: Sequence[Artist]) -> Figure:
    found = artists[0].get_figure(root=True)
    assert found is not None
    return found


def png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=40)
    return buffer.getvalue()


@every_plot
def test_the_dataset_is_untouched(kind: str) -> None:
    """Drawing changes neither values nor attributes."""
    draw, dataset = case(kind)
    before = dataset.copy(deep=True)
    png(figure_of(draw(dataset)))
    xr.testing.assert_identical(dataset, before)


@every_plot
def test_one_artist_per_member_with_its_colour(kind: str) -> None:
    """Six members give six artists; two of each temperature have its colour."""
    draw, dataset = case(kind)
    artists = draw(dataset)
    assert len(artists) == 6
    expected = style.temperature_colours(synthetic.TEMPERATURES)
    for rank, artist in enumerate(artists):
        colour = (
            artist.get_color() if isinstance(artist, Line2D) else artist.get_facecolor()[0]  # type: ignore[attr-defined]
        )
        np.testing.assert_allclose(mpl.colors.to_rgba(colour), expected[rank // 2])


@every_plot
def test_attributes_may_be_missing(kind: str) -> None:
    """What arithmetic drops is looked up by name, or left out; no picture needs it."""
    draw, dataset = case(kind)
    bare, full = (figure_of(draw(ds)).axes[0] for ds in (dataset.drop_attrs(), dataset))
    assert bare.get_xlabel() == full.get_xlabel()
    assert bare.get_ylabel() == full.get_ylabel()


@every_plot
def test_global_style_is_untouched(kind: str) -> None:
    """The house style applies inside a plot only."""
    before = dict(mpl.rcParams)
    draw, dataset = case(kind)
    png(figure_of(draw(dataset)))
    assert dict(mpl.rcParams) == before


@every_plot
def test_given_axes_are_used(kind: str) -> None:
    """With ``ax`` everything is drawn there, and no figure is made."""
    draw, dataset = case(kind)
    axes = Figure().add_subplot()
    assert all(artist.axes is axes for artist in draw(dataset, ax=axes))
    assert not plt.get_fignums()


@every_plot
def test_a_new_figure_is_known_to_pyplot_and_has_a_footer(kind: str) -> None:
    """Without ``ax`` a notebook shows the figure, with what made it written below."""
    draw, dataset = case(kind)
    figure = figure_of(draw(dataset))
    assert plt.get_fignums() == [figure.number]
    assert "tolerance" in figure.get_supxlabel()


@every_plot
def test_legend_lies_outside_the_data(kind: str) -> None:
    """The legend is above the axes, within the figure, and hides nothing."""
    draw, dataset = case(kind)
    artists = draw(dataset)
    figure = figure_of(artists)
    figure.draw_without_rendering()
    axes = artists[0].axes
    assert axes is not None
    legend = axes.get_legend()
    assert legend is not None
    box, frame = legend.get_window_extent(), axes.get_window_extent()
    assert box.y0 >= frame.y1 - 1
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1


@every_plot
def test_the_same_dataset_gives_the_same_picture(kind: str) -> None:
    """Nothing random, dated or left over from the last plot."""
    draw, dataset = case(kind)
    assert png(figure_of(draw(dataset))) == png(figure_of(draw(dataset)))


@every_plot
def test_a_single_member_needs_no_legend(kind: str) -> None:
    """One line is one line."""
    draw, dataset = case(kind)
    artists = draw(dataset.isel(temperature=0, prestress=0, drop=True)[_plain(dataset)])
    assert len(artists) == 1
    assert artists[0].axes is not None
    assert artists[0].axes.get_legend() is None


def _plain(dataset: xr.Dataset) -> list[str]:
    """Variables that are drawn, without the marks that have legend entries of their own."""
    marks = {
        "resonance", "resonance_error", "published", "stability", "equilibrium_stretch", "level",
    }  # fmt: skip
    return [str(name) for name in dataset.data_vars if name not in marks]


@every_plot
def test_a_missing_variable_is_named(kind: str) -> None:
    """A Dataset of another kind is refused."""
    draw, dataset = case(kind)
    with pytest.raises(InputError, match=r"rm\.plot\.overview draws"):
        draw(dataset[["prestress"]])


#: Pictures that ask for the result of a function when they are given another one.
ASKING = [
    "energy_balance", "history", "landscape", "multipliers", "phase", "resonances", "response",
    "section",
]  # fmt: skip


@pytest.mark.filterwarnings("ignore::remanent.InputWarning")
@pytest.mark.parametrize("picture", ASKING)
def test_results_of_the_function_that_is_asked_for_are_drawn(picture: str) -> None:
    """The message names the functions; the picture draws what they return."""
    draw = getattr(rm.plot, picture)
    other = xr.Dataset({"omega": [1.0, 2.0], "special_omega": ("special", [1.0])})
    with pytest.raises(InputError) as raised:
        draw(other)
    functions = re.findall(r"rm\.(\w+)", raised.value.fix.split(";")[0])
    assert functions
    for name in functions:
        assert draw(getattr(rm, name)(**SOUND[name]()))
        plt.close("all")


@every_plot
def test_a_third_dimension_is_refused(kind: str) -> None:
    """Colour and line style are two; the message says how to select."""
    draw, dataset = case(kind)
    with pytest.raises(InputError, match=r"\.isel\("):
        draw(dataset.expand_dims(c=[0.5, 1.0]))


def test_history_draws_the_numbers() -> None:
    """The line is the data, on axes that name it."""
    dataset = synthetic.constant(6.0, 61).isel(prestress=0)
    artists = plots.history(dataset)
    for k, artist in enumerate(artists):
        np.testing.assert_array_equal(artist.get_xdata(), dataset["time"].values)
        np.testing.assert_array_equal(
            artist.get_ydata(), dataset["thickness_stretch"].isel(temperature=k).values
        )
    assert artists[0].axes is not None
    assert artists[0].axes.get_xlabel() == r"time, $\tau$"
    assert artists[0].axes.get_ylabel() == r"thickness stretch, $\lambda_3$"


def test_history_takes_times_of_each_trajectory() -> None:
    """Where lengths differ, time is a two-dimensional coordinate along ``cycle``."""
    dataset = synthetic.constant(6.0, 61).isel(prestress=0).rename_dims(time="cycle")
    times = np.outer([1.0, 2.0, 3.0], dataset["time"].values)
    attrs = dataset["time"].attrs
    dataset = dataset.drop_vars("time").assign_coords(time=(("temperature", "cycle"), times, attrs))
    lines = plots.history(dataset)
    assert len(lines) == len(times)
    for k, artist in enumerate(lines):
        np.testing.assert_array_equal(artist.get_xdata(), times[k])


def test_members_that_go_together_are_named_together() -> None:
    """Coordinates that share a dimension make one name and one colour per case."""
    dataset = synthetic.constant(6.0, 61).stack(case=("prestress", "temperature"))
    dataset = dataset.reset_index("case").transpose("case", "time")
    artists = plots.history(dataset)
    labels = [str(artist.get_label()) for artist in artists]
    assert labels[0] == "$S = 0$, $T = 250$ K"
    assert len(set(labels)) == 6


def test_lines_without_temperature_have_house_colours() -> None:
    """Another dimension takes Okabe and Ito's colours."""
    dataset = synthetic.constant(6.0, 61).isel(temperature=0, drop=True)
    colours = [artist.get_color() for artist in plots.phase(dataset)]
    assert colours == list(style.OKABE_ITO_COLOURS.values())[:2]


def test_a_few_points_are_vectors_and_large_clouds_are_pixels() -> None:
    """Points are shapes up to some thousands; more are one image, below vector axes."""
    small = synthetic.sections(0.0, 1.25, 12)
    large = small.isel(temperature=[0], period=np.arange(6000) % 13)
    for dataset, images in ((small, 0), (large, 1)):
        artists = plots.section(dataset)
        assert all(artist.get_rasterized() == bool(images) for artist in artists)
        assert not figure_of(artists).axes[0].get_rasterized()
        buffer = io.StringIO()
        figure_of(artists).savefig(buffer, format="svg", metadata={"Date": None})
        assert buffer.getvalue().count("<image") == images
        assert buffer.getvalue().count("<path") > 20


def test_resonances_are_marked_where_they_are() -> None:
    """A computed resonance is a circle on its curve, a published one a triangle above."""
    dataset = synthetic.frequency_response(7, 10.0).isel(prestress=0)
    axes = plots.response(dataset)[0].axes
    assert axes is not None
    drawn = {
        (line.get_marker(), round(float(np.asarray(line.get_xdata())[0]), 9))
        for line in axes.get_lines()
        if line.get_marker() in {"o", "v"}
    }
    for name, marker in (("resonance", "o"), ("published", "v")):
        for value in dataset[name].values:
            assert (marker, round(float(value), 9)) in drawn


def test_curves_pass_through_their_resonance() -> None:
    """A maximum found between grid points belongs to the curve."""
    dataset = synthetic.frequency_response(7, 10.0).isel(prestress=0)
    shape = dataset["resonance"]
    dataset["resonance_amplitude"] = shape.copy(data=np.full(shape.shape, 9.0))
    curves = plots.response(dataset)
    assert len(curves) == shape.size
    for artist in curves:
        assert np.max(np.asarray(artist.get_ydata())) == 9.0
        assert (np.diff(np.asarray(artist.get_xdata())) >= 0).all()


def test_other_curves_carry_no_marks() -> None:
    """A resonance is a maximum of the amplitude, and is marked there only."""
    dataset = synthetic.frequency_response(7, 10.0).isel(prestress=0)
    axes = plots.response(dataset, "maximum")[0].axes
    assert axes is not None
    assert len(axes.get_lines()) == 3


def test_stable_equilibria_are_full_and_unstable_ones_empty() -> None:
    """Two wells have two full circles and between them an empty one."""
    dataset = synthetic.two_wells()
    assert dataset["stability"].values.tolist() == ["stable", "unstable", "stable"]
    axes = plots.landscape(dataset)[0].axes
    assert axes is not None
    marks = [line for line in axes.get_lines() if line.get_marker() == "o"]
    fills = [mpl.colors.to_hex(mark.get_markerfacecolor()) for mark in marks]
    assert [fill == "#ffffff" for fill in fills] == [False, True, False]


def test_si_results_have_si_axes() -> None:
    """Labels follow the Dataset's own units and symbols."""
    dataset = to_si(synthetic.with_scales(synthetic.constant(6.0, 61))).isel(prestress=1)
    axes = plots.history(dataset)[0].axes
    assert axes is not None
    assert axes.get_xlabel() == "time, $t$ (ms)"
    assert r"\sigma = 100$ kPa" in footer.footer_text(dataset)


def test_gaps_and_empty_members_draw() -> None:
    """States beyond the horizon are NaN: a gap, not a warning."""
    dataset = synthetic.constant(6.0, 61).copy(deep=True)
    for name in ("thickness_stretch", "thickness_stretch_rate"):
        dataset[name].values[0, 0] = np.nan
        dataset[name].values[1, 1, 30:] = np.nan
    for draw in (plots.history, plots.phase):
        lines = draw(dataset)
        png(figure_of(lines))
        drawn = [int(np.isfinite(np.asarray(line.get_ydata())).sum()) for line in lines]
        assert drawn == [0, 61, 61, 30, 61, 61]
    response: Any = synthetic.frequency_response(7, 10.0).copy(deep=True)
    response["amplitude"].values[0, 0] = np.nan
    response["resonance"].values[0, 0] = np.nan
    curves = plots.response(response)
    png(figure_of(curves))
    empty = [bool(np.isnan(np.asarray(curve.get_ydata())).all()) for curve in curves]
    assert empty == [True, False, False, False, False, False]


def test_a_curve_has_the_band_of_its_quantiles() -> None:
    """The middle quantile is the line; the outermost bound the shade."""
    values = np.array([[0.0, 1.0], [2.0, 3.0], [5.0, 7.0]])
    attrs = {"units": "1", "long_name": "thickness stretch", "symbol": r"\lambda_3"}
    times = ("time", [0.0, 1.0], {"units": "1", "long_name": "time", "symbol": r"\tau"})
    dataset = xr.Dataset(
        {"thickness_stretch": (("quantile", "time"), values, attrs)},
        coords={"quantile": [0.05, 0.5, 0.95], "time": times},
    )
    (line,) = plots.curve(dataset, "thickness_stretch", "time")
    np.testing.assert_array_equal(line.get_ydata(), values[1])
    assert line.axes is not None
    (shade,) = line.axes.collections
    ends = shade.get_paths()[0].get_extents()
    assert (ends.y0, ends.y1) == (0.0, 7.0)
    legend = line.axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["median", "5–95 %"]


def test_a_fit_shows_what_it_compared() -> None:
    """Points are the observed values, the curve the predicted; residuals their difference."""
    attrs = {"units": "1", "long_name": "time", "symbol": r"\tau"}
    dataset = xr.Dataset(
        {
            "observed": ("observation", [1.0, 1.2, 9.0]),
            "predicted": ("observation", [1.1, 1.1, 8.0]),
        },
        coords={
            "time": ("observation", [0.0, 1.0, 0.0], attrs),
            "quantity": ("observation", ["thickness_stretch", "thickness_stretch", "stretch"]),
        },
    )
    points, curve = plots.fit(dataset)
    np.testing.assert_array_equal(points.get_ydata(), [1.0, 1.2])
    np.testing.assert_array_equal(curve.get_ydata(), [1.1, 1.1])
    left, level = plots.fit(dataset, "stretch", residuals=True)
    np.testing.assert_array_equal(left.get_ydata(), [1.0])
    np.testing.assert_array_equal(level.get_ydata(), [0.0])
    with pytest.raises(InputError, match="fit"):
        plots.fit(dataset.drop_vars("predicted"))


def test_bars_are_as_long_as_their_values() -> None:
    """One set for each measure, with error lines, the field with the longest bar on top."""
    values = np.array([[1.0, -2.0, 0.5], [0.1, 0.2, 0.3]])
    dataset = xr.Dataset(
        {
            "elasticity": (("measure", "field"), values),
            "elasticity_error": (("measure", "field"), 0.1 * np.abs(values)),
        },
        coords={"measure": ["fold", "peak"], "field": ["temperature", "c", "b"]},
    )
    found = plots.bars(dataset)
    unsorted = plots.bars(dataset, sort=False)
    for drawn, order in ((found, [1, 0, 2]), (unsorted, [0, 1, 2])):
        for container, row in zip(drawn, values[:, order], strict=True):
            np.testing.assert_allclose([bar.get_width() for bar in container.patches], row)
            assert container.errorbar is not None
    axes = found[0].patches[0].axes
    assert isinstance(axes, Axes)
    assert axes.get_yticklabels()[0].get_text().startswith("slenderness")
    low, high = axes.get_ylim()
    assert low > high  # the first field is on top
    with pytest.raises(InputError, match="field"):
        plots.bars(dataset, "derivative")


def test_a_sweep_is_drawn_against_its_parameter() -> None:
    """Every kept point stands above its own value; up and down are told apart."""
    sweep = rm.bifurcation_diagram(
        rm.Actuator(dissipation=rm.Rayleigh(0.3)), rm.SineSquared(0.4, 1.25), "b", [0.2, 0.3, 0.4],
        direction="both", discard=5, keep=4,
    )  # fmt: skip
    up, down = plots.section(sweep, "b", "thickness_stretch")
    for points, one in ((up, "up"), (down, "down")):
        drawn = np.asarray(points.get_offsets())
        kept = sweep.thickness_stretch.sel(sweep=one)
        for value, row in zip(sweep.b.values, kept.values, strict=True):
            np.testing.assert_array_equal(np.sort(drawn[drawn[:, 0] == value, 1]), np.sort(row))
