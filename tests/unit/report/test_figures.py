"""Laws of the report's figures: they draw from Datasets, and change nothing."""

from __future__ import annotations

from collections.abc import Callable

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from remanent.report import dynamics_figures, evidence_figures, figures
from remanent.report.settings import MAX_RESONANCE_MISFIT
from tests.unit.plots import synthetic

Make = Callable[[], list[xr.Dataset]]
KINDS: dict[str, tuple[Callable[..., Figure], Make, int]] = {
    "figure 2": (figures.draw_figure_2, lambda: [synthetic.constant(6.0, 61)], 2),
    "figure 3": (figures.draw_figure_3, lambda: [synthetic.constant(6.0, 61)], 2),
    "figure 4": (figures.draw_figure_4, lambda: [synthetic.frequency_response(7, 10.0)], 2),
    "figure 5": (
        figures.draw_figure_5_or_6,
        lambda: [synthetic.forced(0.0, 1.25, 10.0), synthetic.sections(0.0, 1.25, 12)],
        9,
    ),
    "landscapes": (evidence_figures.draw_landscapes, lambda: [synthetic.potential()], 2),
    "tolerance": (
        evidence_figures.draw_solver_comparison,
        lambda: [synthetic.two_tolerances(12), synthetic.drift(10.0)],
        14,
    ),
    "orbits": (
        dynamics_figures.draw_response_branches,
        lambda: [
            synthetic.diagram(),
            synthetic.frequency_response(7, 10.0),
            synthetic.resonance_orbits(),
        ],
        6,
    ),
    "jump": (
        dynamics_figures.draw_jump_at_resonance,
        lambda: [
            synthetic.diagram().isel(prestress=0, temperature=1),
            synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=1),
            synthetic.beside_a_saddle(),
            synthetic.crossing(),
        ],
        2,
    ),
    "chaos": (dynamics_figures.draw_chaos_map, lambda: [synthetic.regimes(), synthetic.cases()], 3),
    "valley": (evidence_figures.draw_misfit_maps, lambda: [synthetic.valley()], 7),
}
every_figure = pytest.mark.parametrize("kind", KINDS)


@every_figure
def test_figures_render_and_change_nothing(kind: str) -> None:
    """Each renders without a warning, leaves its Datasets and the global style alone."""
    draw, make, panels = KINDS[kind]
    datasets = make()
    before, rc = [dataset.copy(deep=True) for dataset in datasets], dict(mpl.rcParams)
    figure = draw(*datasets)
    figure.set_dpi(50)
    figure.canvas.draw()
    assert len(figure.axes) == panels
    assert dict(mpl.rcParams) == rc
    for dataset, copy in zip(datasets, before, strict=True):
        xr.testing.assert_identical(dataset, copy)


@every_figure
def test_figures_say_what_made_them(kind: str) -> None:
    """A footer names the actuator's constants."""
    draw, make, _ = KINDS[kind]
    assert "$c = 1$" in draw(*make()).get_supxlabel()


@every_figure
def test_nothing_sticks_out(kind: str) -> None:
    """No label or legend is cut at the edge of the page."""
    draw, make, _ = KINDS[kind]
    figure = draw(*make())
    figure.draw_without_rendering()
    box = figure.get_tightbbox()
    width, height = figure.get_size_inches()
    assert box.x0 >= -0.02
    assert box.y0 >= -0.02
    assert box.x1 <= width + 0.02
    assert box.y1 <= height + 0.02


def test_panels_of_figure_5_are_lettered_as_published() -> None:
    """Rows are temperatures; (a, c, e) are histories, (b, d, f) phase planes, ours come after."""
    figure = figures.draw_figure_5_or_6(
        synthetic.forced(0.0, 1.25, 10.0), synthetic.sections(0.0, 1.25, 12)
    )
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert [title[:3] for title in titles] == [f"({k})" for k in "abgcdhefi"]
    assert "250" in titles[0]
    assert "400" in titles[6]


def test_each_column_of_figure_5_has_one_scale() -> None:
    """What is three times as large is drawn three times as large, and the axes say what it is."""
    axes = figures.draw_figure_5_or_6(
        synthetic.forced(0.0, 1.25, 10.0), synthetic.sections(0.0, 1.25, 12)
    ).axes
    for column in range(3):
        assert len({(one.get_xlim(), one.get_ylim()) for one in axes[column::3]}) == 1
    assert all("rate" in one.get_ylabel() for one in axes[1::3])


def test_choices_that_agree_are_marked_in_their_cells() -> None:
    """Each dot is a choice whose misfit is small enough; no line leads between cells."""
    dataset = synthetic.valley()
    axes = evidence_figures.draw_misfit_maps(dataset).axes[0]
    dots, least = axes.lines
    misfit = dataset["misfit"].isel(law=0, window=0)
    assert not axes.collections[1:]
    assert len(np.asarray(dots.get_xdata())) == int((misfit <= MAX_RESONANCE_MISFIT).sum()) > 1
    for x, y in np.asarray(dots.get_xydata()):
        assert float(misfit.sel(reference_temperature=x, b=y)) <= MAX_RESONANCE_MISFIT
    (place,) = np.asarray(least.get_xydata())
    assert float(misfit.sel(reference_temperature=place[0], b=place[1])) == float(misfit.min())


def test_the_legend_of_the_jump_names_what_is_in_view() -> None:
    """A special point beyond the frame has no entry."""
    branches = synthetic.diagram().isel(prestress=0, temperature=1)
    response = synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=1)
    response = response.assign(amplitude=response["amplitude"] + 1.0)  # the frame is as high
    drawn = {
        name: dynamics_figures.draw_jump_at_resonance(
            branches, one, synthetic.beside_a_saddle(), synthetic.crossing()
        )
        for name, one in {"all": response, "part": response.sel(omega=slice(0.5, 1.1))}.items()
    }
    words = {
        name: [text.get_text() for text in figure.legends[0].get_texts()]
        for name, figure in drawn.items()
    }
    assert "fold" in words["all"]
    assert "fold" not in words["part"]
    assert "saddle" in words["part"]


def test_the_bars_of_the_landscapes_are_named() -> None:
    """What a bar across a well stands for is in the legend."""
    figure = evidence_figures.draw_landscapes(synthetic.potential())
    assert any("energy" in text.get_text() for text in figure.legends[0].get_texts())


def test_no_peak_is_cut_off() -> None:
    """Panels on one scale show the largest amplitude of all, from zero."""
    dataset = synthetic.frequency_response(7, 10.0).copy(deep=True)
    dataset["amplitude"].values[1, 2, 3] = 5.0  # the last panel has the highest peak
    dataset["resonance"].values[1, 2] = float(dataset["omega"][3])
    panels = figures.draw_figure_4(dataset).axes
    assert len(panels) == 2
    for axes in panels:
        bottom, top = axes.get_ylim()
        assert bottom == 0.0
        assert top > 5.0


def test_every_second_period_is_drawn_in_the_phase_plane() -> None:
    """Panel (b) holds the even drive periods, its neighbour all of them."""
    figure = figures.draw_figure_5_or_6(
        synthetic.forced(0.0, 1.25, 10.0), synthetic.sections(0.0, 1.25, 12)
    )
    counts = [sum(len(np.asarray(c.get_offsets())) for c in axes.collections)
              for axes in figure.axes[1:3]]  # fmt: skip
    assert counts == [7, 13]


def test_every_panel_of_the_comparison_has_a_letter() -> None:
    """From (a) to (n), in rows."""
    axes = evidence_figures.draw_solver_comparison(
        synthetic.two_tolerances(12), synthetic.drift(10.0)
    ).axes
    assert [one.texts[0].get_text() for one in axes] == [f"({k})" for k in "abcdefghijklmn"]


def test_pairs_of_sections_share_their_scale() -> None:
    """Converged and default sections are compared on the same axes."""
    axes = evidence_figures.draw_solver_comparison(
        synthetic.two_tolerances(12), synthetic.drift(10.0)
    ).axes
    assert len(axes) == 14
    for first, second in zip(axes[0:12:2], axes[1:12:2], strict=True):
        assert first.get_xlim() == second.get_xlim()
        assert first.get_ylim() == second.get_ylim()


def test_both_motions_beside_the_jump_and_the_saddle_are_drawn() -> None:
    """Panel (b) holds each motion in its colour, and the saddle where it is."""
    axes = dynamics_figures.draw_jump_at_resonance(
        synthetic.diagram().isel(prestress=0, temperature=1),
        synthetic.frequency_response(7, 10.0).isel(prestress=0, temperature=1),
        synthetic.beside_a_saddle(),
        synthetic.crossing(),
    ).axes[1]
    points = [line for line in axes.lines if len(np.asarray(line.get_xdata())) == 30]
    assert len({str(line.get_color()) for line in points}) == 2
    (saddle,) = [line for line in axes.lines if line.get_marker() == "X"]
    assert float(np.ravel(saddle.get_xdata())[0]) == 1.4


def test_the_published_motions_lie_in_the_chart() -> None:
    """Their places are those of their own Dataset, within the axes."""
    cases = synthetic.cases()
    axes = dynamics_figures.draw_chaos_map(synthetic.regimes(), cases).axes[0]
    drawn = [(float(np.ravel(line.get_xdata())[0]), float(np.ravel(line.get_ydata())[0]))
             for line in axes.lines]  # fmt: skip
    assert drawn == list(zip(cases["omega"].values, cases["b"].values, strict=True))
    for x, y in drawn:
        assert axes.get_xlim()[0] < x < axes.get_xlim()[1]
        assert axes.get_ylim()[0] < y < axes.get_ylim()[1]
