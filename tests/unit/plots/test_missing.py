"""What is missing is named: lost members, gaps, horizons, cells without a result."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import TICKUP
from matplotlib.patches import PathPatch

import remanent as rm
from remanent import plots
from tests.unit.plots import synthetic


def texts(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def axes_of(artists: Sequence[Any]) -> Axes:
    found = artists[0].axes
    assert isinstance(found, Axes)
    return found


def histories(codes: Sequence[int]) -> xr.Dataset:
    """Three temperatures; a code other than ok loses all, that of a horizon the second half."""
    dataset = synthetic.constant(6.0, 61).isel(prestress=0).copy(deep=True)
    for k, code in enumerate(codes):
        start = {rm.Status.OK: 61, rm.Status.HORIZON: 30}.get(rm.Status(code), 0)
        for name in ("thickness_stretch", "thickness_stretch_rate"):
            dataset[name].values[k, start:] = np.nan
    return dataset.assign(status=("temperature", np.asarray(codes, dtype=np.int8)))


def test_a_lost_run_is_named_with_its_status() -> None:
    """The legend says which member has no line, and why."""
    axes = axes_of(plots.history(histories([1, 3, 1])))
    assert texts(axes) == ["$T = 250$ K", "$T = 350$ K (no result: escaped)", "$T = 400$ K"]
    assert (
        "(no result)" in texts(axes_of(plots.history(histories([1, 3, 1]).drop_vars("status"))))[1]
    )


def test_a_lost_member_whose_colour_and_style_others_show_is_named() -> None:
    """One of six: its temperature and its prestress are both seen elsewhere."""
    dataset = synthetic.constant(6.0, 61).copy(deep=True)
    dataset["thickness_stretch"].values[1, 2] = np.nan
    assert "$T = 400$ K, $S = 1$ (no result)" in texts(axes_of(plots.history(dataset)))


@pytest.mark.parametrize("draw", [plots.history, plots.phase])
def test_the_horizon_is_marked_once(draw: Any) -> None:
    """A line that stops early ends in a cross, named by its status; others do not."""
    axes = axes_of(draw(histories([1, 2, 2])))
    assert texts(axes).count("horizon") == 1
    crosses = [line for line in axes.lines if line.get_marker() == "x"]
    assert len(crosses) == 2
    assert "horizon" not in texts(axes_of(draw(histories([1, 1, 1]))))


def test_an_empty_frame_says_what_happened() -> None:
    """No ticks of a scale of nothing; the words of the status."""
    axes = axes_of(plots.history(histories([4, 4, 4]).isel(temperature=[0])))
    assert [text.get_text() for text in axes.texts] == ["no result: invalid"]
    assert len(axes.get_yticks()) == 0
    assert axes.get_xlim() == (0.0, 6.0)


def test_frequencies_without_a_result_are_marked() -> None:
    """A gap of a response is seen on the axis, with the words of its status."""
    dataset = (
        synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=[0, 1]).copy(deep=True)
    )
    dataset["amplitude"].values[0, [2, 3]] = np.nan
    status = np.ones((2, 7), dtype=np.int8)
    status[0, [2, 3]] = int(rm.Status.MAX_STEPS)
    axes = axes_of(plots.response(dataset.assign(status=(("temperature", "omega"), status))))
    assert "no result: max-steps" in texts(axes)
    (ticks,) = [line for line in axes.lines if str(line.get_marker()) == str(TICKUP)]
    np.testing.assert_array_equal(ticks.get_xdata(), dataset["omega"].values[[2, 3]])


def test_marks_on_the_edge_stand_inside_the_axes() -> None:
    """Where nothing rests a mark rises from the lower edge, and none hangs below it."""
    balloon = rm.LagrangianSystem(
        coordinates="stretch", kinetic="stretch_rate**2/2",
        potential="stretch**2 + stretch**-4/2 - pressure*stretch**3/3",
        parameters={"pressure": 0.5}, rest={"stretch": 1.0},
    )  # fmt: skip
    over = {"pressure": [0.0, 0.6, 1.2, 1.8]}
    found = rm.equilibria(balloon, over=over, state_box={"stretch": (0.9, 4.0)})
    axes = axes_of(plots.equilibria(found))
    (ticks,) = [line for line in axes.lines if str(line.get_marker()) == str(TICKUP)]
    axes.figure.draw_without_rendering()  # type: ignore[union-attr]
    style = ticks._marker  # type: ignore[attr-defined]
    heights = style.get_transform().transform(style.get_path().vertices)[:, 1]
    assert heights.min() >= 0.0
    assert heights.max() > 0.0


def test_a_cloud_that_stops_says_how_many_points_it_has() -> None:
    """Beyond the horizon a section has no points, and the legend counts those it has."""
    dataset = synthetic.sections(0.0, 1.25, 12).copy(deep=True)
    for name in ("thickness_stretch", "thickness_stretch_rate"):
        dataset[name].values[1, 5:] = np.nan
    dataset = dataset.assign(status=("temperature", np.array([1, 2, 1], dtype=np.int8)))
    assert "$T = 350$ K, 5 of 13 points: horizon" in texts(axes_of(plots.section(dataset)))


def cell_patches(axes: Axes) -> list[PathPatch]:
    return [patch for patch in axes.get_children() if isinstance(patch, PathPatch)]


def test_cells_without_a_result_are_hatched_and_named() -> None:
    """Alone in the legend too; a number, a regime and a status of their own."""
    dataset = synthetic.regimes()
    numbers = dataset[["exponent"]].copy(deep=True)
    numbers["exponent"].values[0, 1] = np.nan
    mesh = plots.map(numbers, "exponent", ax=Figure().add_subplot())
    assert isinstance(mesh.axes, Axes)
    assert texts(mesh.axes) == ["no result"]
    (patch,) = cell_patches(mesh.axes)
    assert patch.get_hatch()
    box = patch.get_path().get_extents()
    assert (box.x0, box.x1, box.y0, box.y1) == (1.5, 2.5, -0.75, 1.75)
    status = np.ones((2, 4), dtype=np.int8)
    status[0, 1] = int(rm.Status.INVALID)
    numbers = numbers.assign(status=(("b", "omega"), status))
    mesh = plots.map(numbers, "exponent", ax=Figure().add_subplot())
    assert isinstance(mesh.axes, Axes)
    assert texts(mesh.axes) == ["no result: invalid"]


def test_undecided_cells_are_named_also_where_they_are_the_only_entry() -> None:
    """Tori and chaos have colour bars; what is left in the legend is a single patch."""
    mesh = plots.map(synthetic.regimes(), ax=Figure().add_subplot())
    assert isinstance(mesh.axes, Axes)
    assert texts(mesh.axes) == ["undecided"]
    assert len(cell_patches(mesh.axes)) == 1


def test_a_lone_exponent_is_named_instead_of_scaled() -> None:
    """A colour bar that serves one cell would say no more than its number."""
    dataset = synthetic.regimes()
    dataset["regime"].values[1, 1] = "undecided"
    mesh = plots.map(dataset, ax=Figure().add_subplot())
    assert isinstance(mesh.axes, Axes)
    assert texts(mesh.axes) == [r"chaotic, $\Lambda = 0.1$", "undecided"]
    figure = mesh.axes.figure
    assert [axes.get_ylabel().split(":")[0] for axes in figure.axes[1:]] == ["quasi-periodic"]


def test_a_bar_that_is_not_defined_says_so() -> None:
    """No length would read as zero; it stands below those that are."""
    values = np.array([1.0, np.nan, -0.5])
    dataset = xr.Dataset(
        {"elasticity": ("field", values)}, coords={"field": ["temperature", "c", "b"]}
    )
    axes = plots.bars(dataset)[0].patches[0].axes
    assert isinstance(axes, Axes)
    (word,) = [text for text in axes.texts if text.get_text() == "not defined"]
    assert word.xy == (0.0, 2.0)  # type: ignore[attr-defined]
    low, high = sorted(axes.get_ylim())
    assert low < -0.35
    assert high > 2.35  # the room of its bar lies inside the frame


@pytest.mark.parametrize("as_variable", [True, False])
@pytest.mark.parametrize("draw", [plots.branch, plots.multipliers, plots.equilibria, plots.map])
def test_a_search_that_stopped_early_shows_its_reason(draw: Any, as_variable: bool) -> None:
    """Status incomplete is in the figure, with what stopped it."""
    made = {
        plots.equilibria: lambda: rm.equilibria(rm.Actuator(), over={"m": [0.1, 0.2, 0.3]}),
        plots.map: synthetic.regimes,
    }
    dataset = made.get(draw, synthetic.fold)()
    size = {name: dataset.sizes[name] for name in ("b", "omega") if draw is plots.map}
    code = np.full(tuple(size.values()), int(rm.Status.INCOMPLETE), dtype=np.int8)
    dataset = dataset.assign(status=(tuple(size), code))
    reason = "the box of states was too small"
    if as_variable:
        dataset = dataset.assign(reason=(tuple(size), np.full(tuple(size.values()), reason)))
    else:
        dataset = dataset.assign_attrs(reason=reason)
    axes = Figure(layout="constrained").add_subplot()
    draw(dataset, ax=axes)
    said = " ".join(text.get_text() for text in axes.texts).replace("\n", " ")
    assert "incomplete" in said
    assert reason in said


def test_measurements_that_are_missing_are_counted() -> None:
    """A fit says how many of its points have no value or no prediction."""
    nan = np.nan
    dataset = xr.Dataset(
        {"observed": ("observation", [1.0, nan, 3.0]),
         "predicted": ("observation", [1.0, 2.0, nan])},
        coords={"time": ("observation", [0.0, 1.0, 2.0]),
                "quantity": ("observation", ["thickness_stretch"] * 3)},
    )  # fmt: skip
    found = texts(axes_of(plots.fit(dataset)))
    assert {"1 of 3 not measured", "1 of 3 without a prediction"} < set(found)
