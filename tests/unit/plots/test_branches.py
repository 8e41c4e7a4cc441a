"""Branches look as stable as they are, and what is marked on them is there."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import remanent as rm
from remanent import plots
from remanent._typing import FloatArray
from remanent.plots.retraced import new_stretches, turning_points
from tests.unit.plots import synthetic


@cache
def doubled_branch() -> xr.Dataset:
    """The doubled branch of the guide on orbits: all but its first point are saddles."""
    damped = rm.Actuator(dissipation=rm.Rayleigh(0.01))
    drive = rm.SineSquared(b=0.8, omega=2.4)
    return rm.switch_branch(rm.continue_orbit(damped, drive, "omega", (2.25, 2.45)), 0)


def legend_texts(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def drawn_length(lines: list[Line2D], size: FloatArray) -> float:
    """Length of all lines, over the size of what is drawn."""
    steps = [np.diff(np.asarray(line.get_xydata()), axis=0) / size for line in lines]
    return float(sum(np.hypot(*step.T).sum() for step in steps))


def test_a_branch_that_is_run_twice_is_drawn_once() -> None:
    """What goes there and back over one curve keeps its dashes."""
    once = doubled_branch()
    back = once.isel(point=slice(None, None, -1))
    dataset = xr.concat(
        [once, back], "point", data_vars="minimal", coords="minimal", compat="override",
        join="override",
    )  # fmt: skip
    points = np.stack([dataset.omega.values, dataset.amplitude.values], axis=1)
    size = np.ptp(points, axis=0)
    whole = np.hypot(*(np.diff(points, axis=0) / size).T).sum()
    lines = plots.branch(dataset, ax=Figure().add_subplot())
    assert drawn_length(lines, size) == pytest.approx(0.5 * whole, rel=0.02)


def test_the_start_of_a_doubled_branch_is_one_mark() -> None:
    """There it turns, and no fold is marked over the point where it starts."""
    dataset = doubled_branch()
    at = [k for k, kind in enumerate(dataset.special_kind.values) if kind == "fold"]
    for k in at:
        others = np.delete(np.arange(dataset.sizes["special"]), k)
        if (
            np.abs(dataset.special_omega.values[others] - float(dataset.special_omega[k])).min()
            > 1e-6
        ):
            pytest.fail("the fold is a fold of its own")
    axes = Figure().add_subplot()
    plots.branch(dataset, ax=axes)
    marks = [line for line in axes.lines if line.get_marker() in {"o", "^", "s", "D"}]
    places = [tuple(point) for line in marks for point in np.asarray(line.get_xydata())]
    assert len(places) == 1
    assert "fold" not in legend_texts(axes)


def test_a_branch_of_saddles_is_named_so_alone() -> None:
    """One point at the start that is called otherwise is no line that the legend names."""
    axes = Figure().add_subplot()
    plots.branch(doubled_branch(), ax=axes)
    assert "saddle" in legend_texts(axes)
    assert "stable" not in legend_texts(axes)


def ends_by_stability(lines: list[Line2D]) -> dict[str, list[tuple[float, float]]]:
    """The first and the last point of each stability's line; of one line each."""
    found: dict[str, list[tuple[float, float]]] = {}
    for line in lines:
        points = np.asarray(line.get_xydata())
        found.setdefault(str(line.get_gid()), []).extend([tuple(points[0]), tuple(points[-1])])
    return found


def without_the_fold() -> xr.Dataset:
    """A branch with computed points on both sides of its fold, and none at it."""
    whole = synthetic.fold()
    return whole.isel(point=whole["amplitude"].values != 1.0)


@pytest.mark.parametrize("points", [slice(None), slice(None, None, -1), slice(None, None, 3)])
def test_the_line_changes_its_style_at_the_special_point(points: slice) -> None:
    """Solid ends and dashed begins at the fold itself, not at the last point before it."""
    dataset = without_the_fold().isel(point=points)
    ends = ends_by_stability(plots.branch(dataset, ax=Figure().add_subplot()))
    for stability in ("stable", "saddle"):
        assert (1.0, 1.0) in ends[stability]


def test_the_multiplier_that_reaches_the_circle_does_so_at_the_special_point() -> None:
    """It is 1 there, and another one keeps the value that it has on both sides."""
    lines = plots.multipliers(without_the_fold(), ax=Figure().add_subplot())
    ends = ends_by_stability(lines)
    for stability in ("stable", "saddle"):
        assert {(1.0, 1.0), (1.0, 0.5)} <= set(ends[stability])


def test_what_special_points_do_not_hold_is_cut_on_the_line() -> None:
    """The value at the fold lies between those of its neighbours, at the frequency of the fold."""
    dataset = without_the_fold()
    dataset = dataset.assign(maximum=2.0 * dataset["amplitude"])
    ends = ends_by_stability(plots.branch(dataset, "maximum", ax=Figure().add_subplot()))
    (cut,) = set(ends["stable"]) & set(ends["saddle"])
    assert cut == pytest.approx((1.0, 2.0), abs=1e-12)


def test_a_change_that_no_special_point_explains_stays_where_it_is_known() -> None:
    """A special point elsewhere on the branch draws no line to itself."""
    dataset = without_the_fold()
    dataset = dataset.assign(
        special_omega=("special", [0.9]), special_amplitude=("special", [0.71])
    )
    lines = plots.branch(dataset, ax=Figure().add_subplot())
    drawn = np.concatenate([np.asarray(line.get_ydata()) for line in lines])
    assert np.isin(drawn, dataset["amplitude"].values).all()


def test_marks_stand_off_the_frame() -> None:
    """A fold at the end of what was followed is seen whole."""
    axes = plots.branch(synthetic.fold())[0].axes
    assert axes is not None
    left, right = axes.get_xlim()
    assert right - 0.02 * (right - left) > 1.0


def test_what_lies_apart_is_drawn_whole() -> None:
    """Both arms of a fold, and two branches side by side, lose nothing."""
    s = np.linspace(-1.0, 1.0, 201)
    arms = np.stack([1.0 - s**2, s], axis=1)
    size = np.ptp(arms, axis=0)
    (turn,) = turning_points(arms[:, 0])
    assert turn == 100
    first, second = arms[: turn + 1], arms[turn:]
    assert new_stretches(second, [first], size) == [slice(0, 101)]
    assert new_stretches(first + np.array([0.05, 0.0]), [first], size) == [slice(0, 101)]
    assert new_stretches(first[::-1], [first], size) == []


@pytest.mark.parametrize(("reason", "words"), [
    ("max_points", "end: max_points"), ("lost", "end: branch lost"), ("bounds", ""), ("closed", ""),
])  # fmt: skip
def test_ends_before_the_end_are_marked(reason: str, words: str) -> None:
    """Where a branch was cut short the mark says why; where it left the range nothing is said."""
    ends = ("end", np.array(["closed", reason]))
    dataset = synthetic.fold().assign(end_reason=ends).assign_coords(end=["first", "last"])
    axes = Figure().add_subplot()
    plots.branch(dataset, ax=axes)
    crosses = [line for line in axes.lines if line.get_marker() == "x"]
    assert len(crosses) == bool(words)
    if words:
        assert words in legend_texts(axes)
        last = (float(dataset.omega[-1]), float(dataset.amplitude[-1]))
        assert tuple(np.ravel(crosses[0].get_xydata())) == last


def test_a_branch_that_left_the_box_ends_with_a_mark() -> None:
    """An end inside the range of the parameter is the edge of the box, and is called so."""
    dataset: Any = synthetic.fold()
    dataset = dataset.assign(end_reason=("end", np.array(["bounds", "bounds"])))
    low = float(dataset.omega[0])
    dataset = dataset.assign_attrs(parameter="omega", parameter_range=(low, 1.3))
    axes = Figure().add_subplot()
    plots.branch(dataset.isel(point=slice(0, 30)), ax=axes)
    assert "edge of the state box" in legend_texts(axes)
    (cross,) = [line for line in axes.lines if line.get_marker() == "x"]
    assert float(np.ravel(cross.get_xdata())[0]) == float(dataset.omega[29])


def response(heights: FloatArray, resonance: float, bracket: float = 1e-3) -> xr.Dataset:
    """A response over frequencies from 0.5 to 1.5 with a resonance that is said."""
    grid = np.linspace(0.5, 1.5, heights.size)
    return xr.Dataset(
        {"amplitude": ("omega", heights), "resonance": resonance, "resonance_error": bracket},
        coords={"omega": grid},
    )


def test_an_end_of_the_range_is_no_resonance() -> None:
    """Largest at the last frequency, or at the first: an arrow, and the word is another one."""
    rising = np.linspace(0.1, 1.0, 11)
    for heights, end, marker in ((rising, 1.5, ">"), (rising[::-1], 0.5, "<")):
        for resonance in (end, np.nan, end - 1e-6):
            axes = Figure().add_subplot()
            plots.response(response(heights, resonance), ax=axes)
            assert legend_texts(axes) == ["largest in range"]
            marks = [line for line in axes.lines if line.get_marker() not in {"None", ""}]
            assert [str(line.get_marker()) for line in marks] == [marker]
            assert tuple(np.ravel(marks[0].get_xydata())) == (end, 1.0)


def test_a_resonance_inside_is_ringed() -> None:
    """Where the amplitude falls on both sides the mark is a circle, and no arrow is there."""
    heights = 1.0 - np.abs(np.linspace(-1.0, 1.0, 11))
    axes = Figure().add_subplot()
    plots.response(response(heights, 1.0), ax=axes)
    assert legend_texts(axes) == ["resonance"]


def test_a_response_without_a_peak_has_no_mark() -> None:
    """No resonance, and the largest amplitude inside: nothing is claimed."""
    heights = 1.0 - np.abs(np.linspace(-1.0, 1.0, 11))
    axes = Figure().add_subplot()
    plots.response(response(heights, np.nan), ax=axes)
    assert not legend_texts(axes)
