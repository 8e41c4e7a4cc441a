"""What is drawn of equilibria exists: no line joins two of them, and stability is the style."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import remanent as rm
from remanent import plots
from remanent._errors import InputError
from remanent._typing import FloatArray

#: Loads across both folds of a block under S = 2.2.
LOADS = np.linspace(1.5, 3.5, 41)
SNAPPING = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": LOADS})


def drawn(artists: list[Line2D]) -> list[tuple[str, FloatArray]]:
    """Line style and points of each branch."""
    return [(str(line.get_linestyle()), np.asarray(line.get_xydata())) for line in artists]


def load_at(thickness: FloatArray, prestress: float) -> FloatArray:
    """The load that holds a neo-Hookean block at a stretch, m = S l^3 - (l^4 - l^-2)."""
    stretch = thickness**-0.5
    return np.asarray(prestress * stretch**3 - (stretch**4 - stretch**-2))


def test_every_point_of_a_branch_is_an_equilibrium() -> None:
    """m = S l^3 - (l^4 - l^-2) holds at each, folds included."""
    artists = plots.equilibria(SNAPPING)
    assert len(artists) == 3
    for _, points in drawn(artists):
        np.testing.assert_allclose(load_at(points[:, 1], 2.2), points[:, 0], rtol=1e-8)


def test_no_line_leads_where_nothing_rests() -> None:
    """Half way between neighbours of a branch the curve of equilibria is near."""
    for _, points in drawn(plots.equilibria(SNAPPING)):
        order = np.argsort(points[:, 1])
        steps = np.abs(np.diff(points[order], axis=0))
        middle = 0.5 * (points[order][1:, 1] + points[order][:-1, 1])
        apart = load_at(middle, 2.2) - 0.5 * (points[order][1:, 0] + points[order][:-1, 0])
        assert np.abs(apart).max() <= 2.0 * steps[:, 0].max()


def test_stable_branches_are_solid_and_unstable_ones_dashed() -> None:
    """The middle branch is unstable and ends in both folds, which are circles."""
    artists = plots.equilibria(SNAPPING)
    (unstable,) = [points for look, points in drawn(artists) if look != "-"]
    folds = np.stack([SNAPPING.fold_m, SNAPPING.fold_thickness_stretch], axis=1)
    ends = unstable[[0, -1]]
    np.testing.assert_array_equal(ends[ends[:, 0].argsort()], folds[folds[:, 0].argsort()])
    axes = artists[0].axes
    assert axes is not None
    (circles,) = [line for line in axes.lines if line.get_marker() == "o"]
    marked = np.asarray(circles.get_xydata())
    assert {tuple(point) for point in marked} == {tuple(point) for point in folds}
    legend = axes.get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()] == ["stable", "unstable", "fold"]


def test_curves_of_equilibria_are_their_branches() -> None:
    """``curve`` of a variable of equilibria joins none of one number."""
    by_curve = plots.curve(SNAPPING, "equilibrium_stretch", "m", ax=Figure().add_subplot())
    for (_, one), (_, other) in zip(
        drawn(by_curve), drawn(plots.equilibria(SNAPPING)), strict=True
    ):
        np.testing.assert_array_equal(one, other)


def test_without_located_folds_branches_end_where_two_meet() -> None:
    """Nothing is drawn across: no step is longer than the largest of a branch that is known."""
    bare = SNAPPING.drop_vars([name for name in SNAPPING.data_vars if str(name).startswith("fold")])
    known = max(np.abs(np.diff(p[:, 1])).max() for _, p in drawn(plots.equilibria(SNAPPING)))
    for _, points in drawn(plots.equilibria(bare)):
        assert np.abs(np.diff(points[:, 1])).max() <= known


@settings(max_examples=10, deadline=None)
@given(
    prestress=st.floats(1.9, 3.0), count=st.integers(2, 60), low=st.floats(0.5, 2.5),
    width=st.floats(0.05, 5.0),
)  # fmt: skip
def test_on_any_grid_neighbours_lie_on_one_piece_of_the_curve(
    prestress: float, count: int, low: float, width: float
) -> None:
    """As m(l) is monotonic between folds, two points that are joined have no fold between."""
    over = {"m": np.linspace(low, low + width, count)}
    dataset = rm.equilibria(rm.Actuator(prestress=prestress), over=over)
    thickness = np.linspace(0.05, 8.0, 4001)
    slope = np.sign(np.diff(load_at(thickness, prestress)))
    turns = thickness[1:-1][slope[1:] != slope[:-1]]
    for _, points in drawn(plots.equilibria(dataset, ax=Figure().add_subplot())):
        for one, other in zip(points[:-1, 1], points[1:, 1], strict=True):
            inside = (turns > min(one, other) + 0.02) & (turns < max(one, other) - 0.02)
            assert not inside.any(), (one, other, turns)


@pytest.mark.parametrize(
    "variable", ["equilibrium_stretch", "natural_frequency", "equilibrium_potential"]
)
def test_other_variables_and_members_draw(variable: str) -> None:
    """A branch for each piece of each temperature, in its colour."""
    over = {"m": LOADS[::4], "temperature": np.array([280.0, 310.0])}
    dataset = rm.equilibria(rm.Actuator(prestress=2.2), over=over)
    artists = plots.equilibria(dataset, variable)
    assert len({str(line.get_color()) for line in artists}) == 2
    for line in artists:
        assert np.isfinite(line.get_xydata()).any()
    axes = artists[0].axes
    assert axes is not None
    legend = axes.get_legend()
    assert legend is not None
    # Where nothing is stable there is no natural frequency, and no line of that name.
    words = {text.get_text() for text in legend.get_texts()}
    assert ("unstable" in words) == (variable != "natural_frequency")


def test_a_result_without_a_parameter_is_refused() -> None:
    """Equilibria of one load have nothing to be drawn against."""
    with pytest.raises(InputError, match="over a parameter"):
        plots.equilibria(rm.equilibria(rm.Actuator(), 0.16))


def test_every_equilibrium_is_in_the_frame_of_a_landscape() -> None:
    """Two stable ones and the one between, each with room beside it; never below stretch 0."""
    loaded = rm.equilibria(rm.Actuator(), 2.2, over={"prestress": [1.9, 2.1, 2.3]})
    for dataset in (*(loaded.isel(prestress=k) for k in range(3)), loaded):
        axes = plots.landscape(dataset)[0].axes
        assert isinstance(axes, Axes)
        left, right = axes.get_xlim()
        bottom, top = axes.get_ylim()
        stretch, height = (
            dataset[n].values.ravel() for n in ("equilibrium_stretch", "equilibrium_potential")
        )
        known = np.isfinite(stretch)
        assert left >= 0.0
        assert (stretch[known] > left + 0.02 * (right - left)).all()
        assert (stretch[known] < right - 0.02 * (right - left)).all()
        assert ((height[known] > bottom) & (height[known] < top)).all()
