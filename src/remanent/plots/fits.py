"""Measurements and what was fitted to them."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.plots import style
from remanent.plots.footer import add_legend_and_footer
from remanent.results.provenance import own_variable_texts
from remanent.results.schema import describe

__all__ = ["fit"]


def fit(
    dataset: xr.Dataset,
    quantity: str | None = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    residuals: bool = False,
    model: xr.Dataset | None = None,
    **line: Any,
) -> list[Line2D]:
    """Draw measured points and the fitted curve, or what is left between them.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``fit``.
    quantity : str, optional
        Which of the measured variables; the first by default.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name points and curve above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    residuals : bool
        Draw observed − predicted instead.
    model : xarray.Dataset, optional
        A result of what was fitted, ``rm.read_system(dataset)``, at more times or frequencies,
        which is drawn instead of straight lines between the predictions.
    **line : Any
        Passed to matplotlib's ``plot`` for the points.

    Returns
    -------
    list of matplotlib.lines.Line2D
        The points, then the curve.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    remanent.fit : The result that is drawn.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import numpy as np, remanent as rm
    >>> true = rm.Actuator(dissipation=rm.Rayleigh(0.2))
    >>> run = rm.simulate(true, rm.Constant(0.3), times=np.linspace(0, 10, 60))
    >>> guess = rm.Actuator(dissipation=rm.Rayleigh(0.15))
    >>> data = run[["thickness_stretch"]]
    >>> found = rm.fit(guess, rm.Constant(0.3), data, ["dissipation.0.eta"])
    >>> len(rm.plot.fit(found))  # the points and the curve
    2
    >>> plt.close()
    """
    x = next((name for name in ("time", "omega") if name in dataset.coords), None)
    if x is None or "predicted" not in dataset:
        raise InputError(
            "dataset",
            must="be a result of fit",
            got=list(dataset),
            why="It holds both data and curve.",
            fix="Pass the result of rm.fit.",
        )
    name = quantity or str(dataset["quantity"].values[0])
    data = dataset.isel(observation=np.flatnonzero(dataset["quantity"].values == name))
    level = data["predicted"] if residuals else 0.0 * data["predicted"]
    row = describe(name, own_variable_texts(dataset))
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        looks = {"marker": "o", "ms": 2.6, "mfc": "none", "mew": 0.7, "linestyle": ""}
        points = axes.plot(
            data[x], data["observed"] - level, color=style.OKABE_ITO_COLOURS["blue"],
            label="measured", **{**looks, **line},
        )  # fmt: skip
        fine = _fine_curve(model, data[x], name) if model is not None and not residuals else None
        curve = axes.plot(
            *(fine or (data[x], data["predicted"] - level)),
            color=style.OKABE_ITO_COLOURS["vermillion"],
            label="fitted",
            zorder=points[0].get_zorder() - 0.1,  # so that no point is covered
        )
        measured = xr.Variable((), 0.0, row.attributes())
        words = style.axis_label(measured, words=not residuals)
        words = f"residual of {words}" if residuals else words
        style.label_axes(axes, style.axis_label(data[x]), words)
        entries = [*points, *curve, *_lost_entries(data)]
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return [*points, *curve]


def _fine_curve(model: xr.Dataset, at: xr.DataArray, name: str) -> tuple[FloatArray, FloatArray]:
    """Where the model was computed, and what it gives there."""
    x, units = str(at.name), at.attrs.get("units", "1")
    is_along = name in model and x in model.coords and model[name].dims == model[x].dims
    if not is_along or model[x].attrs.get("units", "1") != units:
        raise InputError(
            "model",
            must=f"have {name} along {x} alone, in the units of the fit",
            got=", ".join(
                f"{n}({', '.join(map(str, a.dims))})" for n, a in model.data_vars.items()
            ),
            why="It is drawn through the measurements.",
            fix="Pass a result with the fitted system and drive, such as rm.simulate gives.",
        )
    return model[x].values, model[name].values


def _lost_entries(data: xr.Dataset) -> list[Line2D]:
    """Legend entries, in words, of points and of parts of the curve that are not there."""
    words = {"observed": "not measured", "predicted": "without a prediction"}
    lost = {name: int((~np.isfinite(data[name].values)).sum()) for name in words}
    return [
        Line2D([], [], linestyle="", marker="", label=f"{count} of {data.sizes['observation']} "
               f"{words[name]}")
        for name, count in lost.items() if count
    ]  # fmt: skip
