"""What the plots of basins and of multipliers show."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from remanent import plots
from remanent._errors import InputError
from remanent.plots import style
from tests.unit.plots import synthetic


def test_every_basin_has_the_colour_of_its_attractor() -> None:
    """Pale cells, a full mark inside; the first state variable runs to the right."""
    dataset = synthetic.basins_of_two()
    axes = Figure().add_subplot()
    cells = np.asarray(plots.basins(dataset, ax=axes).get_array())
    assert cells.shape == (5, 9, 3)
    wheel = [to_rgb(tone) for tone in style.OKABE_ITO_COLOURS.values()][:2]
    for k, tone in enumerate(wheel):
        own = cells[dataset["basin"].T.values == k]
        assert (own == own[0]).all()
        assert np.abs(1.0 - own[0]).max() < np.abs(1.0 - np.array(tone)).max()
        (mark,) = [one for one in axes.lines if np.allclose(to_rgb(one.get_color()), tone)]
        place = (float(np.ravel(mark.get_xdata())[0]), float(np.ravel(mark.get_ydata())[0]))
        assert place == tuple(dataset["attractor_state"].values[k])
    assert axes.get_xlabel().startswith("initial in-plane stretch, ")


def test_the_legend_of_basins_gives_shares_with_their_errors() -> None:
    """Each attractor has a letter, its share and the error of it in the legend."""
    axes = Figure().add_subplot()
    plots.basins(synthetic.basins_of_two(), ax=axes)
    legend = axes.get_legend()
    assert legend is not None
    assert {text.get_text() for text in legend.get_texts()} == {
        "A, period 3: 40.0 ± 1.0 %", "B, chaotic: 58.0 ± 2.0 %", "undecided",
    }  # fmt: skip


def test_without_dissipation_islands_are_drawn_as_a_map() -> None:
    """Where there are no attractors, colours follow the rotation number."""
    whole = synthetic.basins_of_two()
    regime = whole["regime"].copy(data=np.full((9, 5), "quasi-periodic"))
    turns = whole["basin"].copy(data=np.linspace(0.0, 1.0, 45).reshape(9, 5))
    islands = xr.Dataset({"regime": regime, "rotation_number": turns}, attrs=whole.attrs)
    cells = np.asarray(plots.basins(islands, ax=Figure().add_subplot()).get_array())
    assert cells.shape == (5, 9, 3)
    assert np.unique(cells.reshape(-1, 3), axis=0).shape[0] > 10


def test_basins_of_one_variable_are_refused() -> None:
    """A map of basins needs two state variables."""
    with pytest.raises(InputError, match="two state variables"):
        plots.basins(synthetic.basins_of_two().isel(stretch=0))


def test_multipliers_are_drawn_by_their_modulus() -> None:
    """Both of a pair, stable solid and saddles dashed, with the fold where they are 1."""
    dataset = synthetic.fold()
    axes = Figure().add_subplot()
    lines = plots.multipliers(dataset, ax=axes)
    assert len(lines) == 4
    drawn = np.concatenate([np.asarray(line.get_ydata()) for line in lines])
    assert drawn.max() == pytest.approx(1.5)
    assert drawn.min() == pytest.approx(0.5)
    assert len({str(line.get_linestyle()) for line in lines}) == 2
    (mark,) = [line for line in axes.lines if line.get_marker() == "o"]
    assert (float(np.ravel(mark.get_xdata())[0]), float(np.ravel(mark.get_ydata())[0])) == (
        1.0,
        1.0,
    )


def test_a_branch_without_attributes_is_drawn_against_a_parameter_that_is_named() -> None:
    """What was followed is an attribute, omega without it; another one has to be passed."""
    branch = synthetic.fold().drop_attrs()
    other = branch.rename(omega="b", special_omega="special_b")
    named = other.assign_attrs(parameter="b")
    labels = []
    for dataset, parameter in ((branch, None), (other, "b"), (named, None)):
        axes = Figure().add_subplot()
        plots.branch(dataset, parameter=parameter, ax=axes)
        labels.append(axes.get_xlabel().rpartition(", ")[2])
    assert labels == ["$\\omega$", "$b$", "$b$"]
    with pytest.raises(InputError, match="Pass parameter="):
        plots.branch(other)
    axes = Figure().add_subplot()
    plots.multipliers(branch, ax=axes)
    assert axes.get_ylabel().startswith("modulus")
