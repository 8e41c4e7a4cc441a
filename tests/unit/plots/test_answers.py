"""What the pictures of resonances, steps, balances and backbones show."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

import remanent as rm
from remanent import plots
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.plots import colours
from remanent.plots.text_fit import broken_text, text_width, wrapped_text
from remanent.results import build, provenance
from tests.unit.plots import pictures, synthetic


def new_axes() -> Axes:
    return Figure(layout="constrained").add_subplot()


def legend_texts(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def test_resonances_are_marked_with_their_order() -> None:
    """2:1 and 1:1 stand at their peaks, in the frame, the marker by kind; saddles are open."""
    axes = new_axes()
    peaks = pictures.RESULTS["peaks"]().isel(temperature=0)
    plots.response(synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=0), ax=axes,
                   resonances=False)  # fmt: skip
    low, high = plots.resonances(peaks, ax=axes)
    assert (low.get_marker(), high.get_marker()) == ("^", "o")
    assert (low.get_markerfacecolor() == "none", high.get_markerfacecolor() == "none") == (
        False, True,
    )  # fmt: skip
    written = {text.get_text(): text.xy for text in axes.texts}  # type: ignore[attr-defined]
    places = zip(peaks.omega.values.tolist(), peaks.amplitude.values.tolist(), strict=True)
    assert written == dict(zip(["2:1", "1:1"], places, strict=True))
    assert axes.get_ylim()[1] > 1.1 * float(peaks.amplitude.max())
    assert {"primary", "superharmonic", "open: not stable"} <= set(legend_texts(axes))


def test_a_resonance_of_unknown_order_has_none() -> None:
    """0:0 is no order."""
    peaks = pictures.RESULTS["peaks"]().isel(temperature=0).copy(deep=True)
    peaks["order_p"][:] = 0
    axes = new_axes()
    plots.resonances(peaks, ax=axes)
    assert not axes.texts


def step() -> tuple[xr.Dataset, xr.Dataset]:
    """x = 2 − exp(−t), which rises from 10 to 90 % in log 9 and settles to 2 % at log 50."""
    time = np.linspace(0.0, 8.0, 4001)
    motion = build.dataset(
        {"thickness_stretch": (("time",), 2.0 - np.exp(-time))}, {"time": (("time",), time)},
        provenance.attributes(synthetic.ACTUATOR, rm.Constant(0.1), 1e-9),
    )  # fmt: skip
    found = {"final": 2.0, "rise_time": np.log(9.0), "settling_time": np.log(50.0)}
    values = {name: ((), np.array(value)) for name, value in found.items()}
    return motion, build.dataset(values, {}, {"band": 0.02})


def test_a_step_shows_its_rise_its_band_and_when_it_has_settled() -> None:
    """The bracket ends where 90 % are reached, the mark lies on the edge of the band."""
    axes = new_axes()
    plots.step_response(*step(), ax=axes)
    (rise,) = [line for line in axes.lines if line.get_gid() == "rise"]
    np.testing.assert_allclose(
        np.asarray(rise.get_xdata()), [np.log(10.0 / 9.0), np.log(10.0)], atol=1e-5
    )
    (settled,) = [line for line in axes.lines if line.get_gid() == "settled"]
    np.testing.assert_allclose(np.asarray(settled.get_xydata()), [[np.log(50.0), 1.98]], atol=1e-5)
    (band,) = axes.patches
    box = band.get_extents().transformed(axes.transData.inverted())
    np.testing.assert_allclose([box.y0, box.y1], [1.98, 2.02])
    assert legend_texts(axes) == ["final ± 2 %", "rise", "settled"]


def test_a_step_that_has_not_settled_says_so() -> None:
    """No mark, and words for it, with the reason of the measures above the axes."""
    motion, measures = step()
    measures["settling_time"] = np.nan
    measures["status"] = int(rm.Status.INCOMPLETE)
    measures["reason"] = "the run is too short"
    axes = new_axes()
    plots.step_response(motion, measures, ax=axes)
    assert not [line for line in axes.lines if line.get_gid() == "settled"]
    assert "settled: no result" in legend_texts(axes)
    assert [text.get_text() for text in axes.texts] == ["incomplete: the run is too short"]
    with pytest.raises(InputError, match="measures"):
        plots.step_response(motion, motion)
    with pytest.raises(InputError, match="measures"):
        plots.step_response(motion, measures.expand_dims(temperature=[250.0, 350.0]))


def test_the_areas_of_a_balance_end_in_the_work() -> None:
    """What is dissipated and what is stored add up to it but for the defect, which is said."""
    balance = pictures.RESULTS["balance"]()
    axes = new_axes()
    (work,) = plots.energy_balance(balance, ax=axes)
    np.testing.assert_array_equal(work.get_ydata(), balance.drive_work)
    _, stored = axes.collections
    top = np.asarray(stored.get_paths()[0].vertices)[:, 1].max()
    defect = float(abs(balance.balance).max())
    assert top == pytest.approx(float(balance.drive_work.max()), abs=2.0 * defect)
    (said,) = [text for text in legend_texts(axes) if text.startswith("defect at most")]
    assert "10^{" in said
    with pytest.raises(InputError, match="isel"):
        plots.energy_balance(balance.expand_dims(c=[0.5, 1.0]))


def backbone() -> xr.Dataset:
    values: dict[str, Any] = {"frequency": [2.4, 2.2, 2.0], "amplitude": [0.0, 0.5, 9.0]}
    return xr.Dataset(
        {name: ("initial.stretch", value) for name, value in values.items()},
        coords={"initial.stretch": [1.0, 1.5, 3.0]},
    )


RATIOS = [(rm.SineSquared(0.4, 1.0), 2.0), (rm.Sine(0.4, 1.0), 1.0)]


@pytest.mark.parametrize(("drive", "ratio"), RATIOS)
def test_a_backbone_lies_on_the_axis_of_the_drive(drive: Drive, ratio: float) -> None:
    """(b sin ωτ)² has twice the frequency ω, sin ωτ once; no limit of the response changes."""
    forced = synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=0)
    forced = forced.assign_attrs(provenance.attributes(synthetic.ACTUATOR, drive, 1e-9))
    bare, axes = new_axes(), new_axes()
    plots.response(forced, ax=bare)
    plots.response(forced, ax=axes, backbone=backbone())
    (line,) = [artist for artist in axes.get_children() if artist.get_gid() == "backbone"]
    np.testing.assert_allclose(line.get_xdata(), backbone().frequency / ratio)  # type: ignore[attr-defined]
    assert (bare.get_xlim(), bare.get_ylim()) == (axes.get_xlim(), axes.get_ylim())
    assert "backbone" in legend_texts(axes)


def test_a_backbone_that_does_not_fit_is_refused() -> None:
    """One in other units, something else, a response without a drive, an axis of a load."""
    forced = synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=0)
    for wrong in (backbone().assign_attrs(scales_applied="{}"), backbone()[["frequency"]]):
        with pytest.raises(InputError, match="backbone"):
            plots.response(forced, backbone=wrong)
    with pytest.raises(InputError, match="drive"):
        plots.response(forced.drop_attrs(), backbone=backbone())
    branch = synthetic.fold().rename(omega="b", special_omega="special_b")
    with pytest.raises(InputError, match="frequency"):
        plots.branch(branch, parameter="b", backbone=backbone())


def test_one_actuator_has_the_colour_of_its_temperature() -> None:
    """Without a coordinate its field says it; of a temperature that was varied nothing does."""
    dataset = synthetic.fold()
    for kelvin in (250.0, 400.0):
        made = provenance.attributes(rm.Actuator(temperature=kelvin), None, 1e-9)
        (expected,) = colours.temperature_colours([kelvin])
        for line in plots.branch(dataset.assign_attrs(made), ax=new_axes()):
            assert to_rgba(line.get_color()) == expected
    varied = provenance.attributes(rm.Actuator(), None, 1e-9, over=["temperature"])
    line = plots.branch(dataset.assign_attrs(varied), ax=new_axes())[0]
    assert line.get_color() == colours.OKABE_ITO_COLOURS["blue"]


def test_numbers_within_their_error_have_one_tone_and_a_name() -> None:
    """The sign of such an exponent is not known; the scale is that of the others."""
    at, values = ("b", "omega"), np.array([[-0.1, 0.02], [0.3, -0.01]])
    dataset = xr.Dataset(
        {"exponent": (at, values), "exponent_error": (at, np.full((2, 2), 0.05))},
        coords={"b": [0.1, 0.2], "omega": [1.0, 2.0]},
    )  # fmt: skip
    mesh = plots.map(dataset, "exponent", ax=new_axes())
    shown: FloatArray = np.ma.getdata(np.ma.asarray(mesh.get_array()))
    np.testing.assert_array_equal(shown, [[-0.1, 0.0], [0.3, 0.0]])
    assert isinstance(mesh.axes, Axes)
    assert legend_texts(mesh.axes) == [r"$\Lambda$ is 0 within error"]


def test_bars_of_several_variables_say_what_they_share() -> None:
    """First-order and total Sobol indices are Sobol indices; a lone part needs no number."""
    damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    dataset = xr.Dataset(
        {name: ("field", [0.2, 0.5]) for name in ("first_index", "total_index")},
        coords={"field": ["c", "dissipation.0.eta"]},
        attrs=provenance.attributes(damped, None, None),
    )
    bars = plots.bars(dataset, ["first_index", "total_index"], ax=new_axes())
    axes = bars[0].patches[0].axes
    assert isinstance(axes, Axes)
    assert axes.get_xlabel() == "Sobol index"
    first = axes.get_yticklabels()[0]
    assert first.get_text() == r"viscosity, $\eta$"
    assert bars[0].patches[0].get_hatch() != bars[1].patches[0].get_hatch()


def two_swings(duration: float) -> xr.Dataset:
    """A small and a large oscillation of the period 2 pi, whose amplitudes beat slowly."""
    time = np.arange(0.0, duration, 1.0 / 12.0)
    swing = np.sin(time) * (1.0 + 0.5 * np.cos(0.02 * time))
    return xr.Dataset(
        {"thickness_stretch": (("temperature", "time"), np.outer([0.1, 0.5], swing))},
        coords={"time": time, "temperature": [250.0, 350.0]},
    )


def test_many_turns_are_drawn_thin_and_the_small_motion_over_the_large_one() -> None:
    """None hides another; what the user says of lines stays."""
    dataset = two_swings(2000.0)
    for envelope in (True, False):
        small, large = plots.history(dataset, ax=new_axes(), envelope=envelope)
        assert small.get_zorder() > large.get_zorder()
        assert small.get_linewidth() < 0.7
        (given, _) = plots.history(dataset, ax=new_axes(), envelope=envelope, linewidth=2.0)
        assert given.get_linewidth() == 2.0
    few = plots.history(dataset.isel(time=slice(0, 400)), ax=new_axes())
    assert few[0].get_zorder() == few[1].get_zorder()


def test_a_long_history_is_the_band_between_its_extremes() -> None:
    """The outline follows the known envelope, and its vertices are numbers of the result."""
    dataset = two_swings(3000.0)
    line = plots.history(dataset.isel(temperature=1), ax=new_axes())[0]
    time, value = np.asarray(line.get_xydata())[np.isfinite(line.get_ydata())].T
    assert np.isin(value, dataset["thickness_stretch"].values).all()
    count = len(time) // 2
    envelope = 0.5 * (1.0 + 0.5 * np.cos(0.02 * time))
    in_one_turn = 0.5 * 0.5 * 0.02 * 2.0 * np.pi  # the envelope changes by no more
    for inner, sign in ((slice(5, count - 5), 1.0), (slice(count + 5, -5), -1.0)):
        np.testing.assert_allclose(value[inner], sign * envelope[inner], atol=in_one_turn)
    assert line.axes is not None
    assert len(line.axes.patches) == 1
    for options in ({"envelope": False}, {"marker": "."}):
        curve = plots.history(dataset.isel(temperature=1), ax=new_axes(), **options)[0]
        assert len(np.asarray(curve.get_xdata())) == dataset.sizes["time"]


def test_a_band_has_a_gap_where_nothing_is_known() -> None:
    """No polygon leads over values that are missing."""
    dataset = two_swings(3000.0).isel(temperature=0)
    dataset["thickness_stretch"][12_000:18_000] = np.nan
    axes = plots.history(dataset, ax=new_axes())[0].axes
    assert axes is not None
    assert len(axes.patches) == 2


def test_a_new_figure_of_a_long_history_has_its_last_oscillations_beside_it() -> None:
    """Ten of them, on the same vertical scale; a short history has no second axes."""
    dataset = two_swings(4000.0)
    axes = plots.history(dataset)[0].axes
    assert axes is not None
    _, beside = axes.figure.axes
    assert beside.get_ylim() == axes.get_ylim()
    assert beside.get_xlim() == pytest.approx((4000.0 - 20.0 * np.pi, 4000.0), abs=0.5)
    assert len(beside.lines) == 2
    short = plots.history(dataset.isel(time=slice(0, 400)))[0].axes
    assert short is not None
    assert len(short.figure.axes) == 1
    plt.close("all")


def test_labels_break_between_words_and_keep_their_mathematics() -> None:
    """Never longer than they have to be; words of a note are cut with an ellipsis."""
    text = r"thickness stretch at equilibrium, $\lambda_3 + x$"
    whole = text_width(text, 8.0)
    assert broken_text(text, whole + 1.0, 8.0) == text
    lines = broken_text(text, 0.6 * whole, 8.0).split("\n")
    assert len(lines) == 2
    assert " ".join(lines) == text
    assert max(text_width(line, 8.0) for line in lines) <= 0.6 * whole
    assert all(line.count("$") % 2 == 0 for line in broken_text(text, 1.0, 8.0).split("\n"))
    room = text_width("one two", 8.0) + 1.0
    note = wrapped_text("one two three four five six seven", room, 8.0, 2)
    assert note.startswith("one two\n")
    assert note.endswith("…")


def test_a_fit_is_drawn_on_the_grid_of_the_model() -> None:
    """A peak between two measurements has its top; another variable is refused."""
    found = pictures.RESULTS["fit"]()
    time = np.linspace(0.0, 6.0, 301)
    model = xr.Dataset({"thickness_stretch": ("time", np.sin(time))}, coords={"time": time})
    _, curve = plots.fit(found, model=model, ax=new_axes())
    np.testing.assert_array_equal(curve.get_xydata(), np.stack([time, np.sin(time)], axis=1))
    _, level = plots.fit(found, model=model, residuals=True, ax=new_axes())
    assert not np.asarray(level.get_ydata()).any()
    with pytest.raises(InputError, match="model"):
        plots.fit(found, model=model.rename(thickness_stretch="other"), ax=new_axes())
