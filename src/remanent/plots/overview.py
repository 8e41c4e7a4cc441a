"""The figure that suits a result on a grid, whatever verb it is of."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from remanent._errors import InputError
from remanent.plots.balances import energy_balance
from remanent.plots.basins import basins
from remanent.plots.branches import branch
from remanent.plots.curves import curve
from remanent.plots.equilibria import equilibria
from remanent.plots.forced import response
from remanent.plots.labels import axis_label
from remanent.plots.maps import map as chart
from remanent.plots.motion import history, section
from remanent.plots.peaks import resonances

#: Endings of the files of pictures.
_PICTURES = (".png", ".svg", ".pdf")
#: Lines that one figure shows of a grid, at most.
_MAX_LINES = 5
#: What is drawn of results that have one number for each point, the first that there is.
_MAIN_VARIABLES = (
    "exponent", "amplitude", "dissipated_energy", "orbits", "crossings", "settling_time",
    "transverse_exponent", "natural_frequency", "frequency", "fold_m", "omega",
)  # fmt: skip
#: What is drawn only where there is nothing else.
_LAST_VARIABLES = frozenset({"status", "drive_period", "residual", "horizon", "local_error"})
#: What tells of the kind of a result: a dimension or a variable of its own, and how it is drawn.
_DRAWN_BY_MARK: tuple[tuple[str, Callable[..., Any]], ...] = (
    ("point", branch),
    ("resonance_kind", resonances),
    ("balance", energy_balance),
    ("equilibrium", equilibria),
    ("cycle", history),
    ("time", history),
    ("section_phase", section),
    ("resonance", response),
)
#: Dimensions that verbs give to the grid, along which lines or marks are drawn.
_LINE_DIMENSIONS: Mapping[Callable[..., Any], tuple[str, ...]] = MappingProxyType(
    {response: ("omega",), resonances: ("peak",)}
)


def overview(dataset: xr.Dataset, *, ax: Axes | None = None, footer: bool = True) -> Any:
    """Draw the figure that suits a result, of as much of its grid as one figure can show.

    Charts show two parameters, lines at most five values of the first one; of further ones the
    value in the middle is shown, and named in the footer.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of a verb that takes `over`, complete or not.
    ax : matplotlib.axes.Axes, optional
        A new figure by default.
    footer : bool
        Whether a new figure says how its data were made.

    Returns
    -------
    list of artists, or one
        What the function that draws returns.

    Raises
    ------
    InputError
        A result in which there is nothing to draw.

    See Also
    --------
    history : A variable against time.
    response : A frequency response.
    map : A chart over two parameters.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> ds = rm.simulate(rm.Actuator(), rm.Constant(0.16), duration=20)
    >>> artists = rm.plot.overview(ds)
    >>> len(artists)
    1
    >>> plt.close()
    """
    varied = _grid_dimensions(dataset)
    dataset = _numbered(dataset, varied)
    is_branch = "point" in dataset.dims and "point" not in varied
    if is_branch and "amplitude" not in dataset:
        return _curves_of_bifurcations(dataset, varied, ax)
    if "attractor" in dataset.dims:
        return basins(_middle_of(dataset, varied), ax=ax, footer=footer)
    for mark, draw in _DRAWN_BY_MARK:
        if mark in varied:
            continue
        if mark in dataset.variables or mark in dataset.dims or mark in dataset.attrs:
            across = [d for d in varied if d not in _LINE_DIMENSIONS.get(draw, ())]
            shown = _middle_of if draw is energy_balance else _few_lines
            return draw(shown(dataset, across), ax=ax, footer=footer)
    if "regime" in dataset and len(varied) > 1:
        return chart(_middle_of(dataset, varied[:-2]), "regime", ax=ax, footer=footer)
    lists = {dim: 0 for dim, size in dataset.sizes.items() if dim not in varied and size}
    dataset = dataset.isel(lists)
    name = _main_variable(dataset, varied)
    if len(varied) > 1:
        return chart(_middle_of(dataset, varied[:-2]), name, ax=ax, footer=footer)
    return curve(dataset, name, varied[0], ax=ax, footer=footer)


def _grid_dimensions(dataset: xr.Dataset) -> list[str]:
    """Dimensions of the grid, by the fields that were varied; several may share one."""
    names = str(dataset.attrs.get("over", "")).split()
    dims = [dataset[name].dims if name in dataset.variables else (name,) for name in names]
    found = dict.fromkeys(str(dim) for several in dims for dim in several)
    return [dim for dim in found if dim in dataset.dims]


def _numbered(dataset: xr.Dataset, dims: list[str]) -> xr.Dataset:
    """Dimensions without values of their own have numbers, by which they can be drawn."""
    numbers = {dim: np.arange(dataset.sizes[dim]) for dim in dims if dim not in dataset.coords}
    return dataset.assign_coords(numbers)


def save_overview(dataset: xr.Dataset, path: Path) -> None:
    """Draw the figure that suits a result into a file, without a screen."""
    import matplotlib as mpl

    if path.suffix.lower() not in _PICTURES:
        raise InputError(
            "--out",
            must=f"end in one of {', '.join(_PICTURES)}",
            got=str(path),
            why="The ending says the format.",
            fix="Use .pdf or .svg for papers, .png for screens.",
        )
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    overview(dataset)
    plt.savefig(path)
    plt.close("all")


def _curves_of_bifurcations(dataset: xr.Dataset, varied: list[str], ax: Axes | None) -> Any:
    """The second parameter of curves of bifurcations against the first."""
    from matplotlib import pyplot as plt

    first, second = (dataset[str(name)] for name in list(dataset.data_vars)[:2])
    axes = ax or plt.subplots(layout="constrained")[1]
    few = _few_lines(dataset, varied)
    lines = few.transpose("point", ...)
    drawn = axes.plot(
        lines[first.name].values.reshape(lines.sizes["point"], -1),
        lines[second.name].values.reshape(lines.sizes["point"], -1),
    )
    axes.set(xlabel=axis_label(first), ylabel=axis_label(second))
    return drawn


def _few_lines(dataset: xr.Dataset, varied: list[str]) -> xr.Dataset:
    """At most five values of the first parameter, the middle of all others."""
    fewer = _middle_of(dataset, varied[1:])
    if not varied or dataset.sizes[varied[0]] <= _MAX_LINES:
        return fewer
    places = np.linspace(0, dataset.sizes[varied[0]] - 1, _MAX_LINES).round().astype(int)
    return fewer.isel({varied[0]: places})


def _middle_of(dataset: xr.Dataset, dims: list[str]) -> xr.Dataset:
    places: dict[Hashable, int] = {dim: (dataset.sizes[dim] - 1) // 2 for dim in dims}
    return dataset.isel(places)


def _main_variable(dataset: xr.Dataset, varied: list[str]) -> str:
    """The variable of which a chart or a curve is drawn."""
    per_point = [
        str(name)
        for name, variable in dataset.data_vars.items()
        if varied and set(variable.dims) == set(varied) and variable.dtype.kind in "fi"
    ]
    chosen = [name for name in _MAIN_VARIABLES if name in per_point]
    further = (name for name in per_point if not name.endswith(("_error", "_status")))
    chosen += sorted(further, key=lambda name: name in _LAST_VARIABLES)
    if not chosen:
        raise InputError(
            "dataset",
            must="have a number for each point of a grid",
            got=f"dimensions {', '.join(map(str, dataset.dims)) or 'none'}",
            why="A chart or a curve is drawn of one variable.",
            fix="Select what is to be seen, and pass it to a function of rm.plot.",
        )
    return chosen[0]
