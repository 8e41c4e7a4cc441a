"""The answer to a step: the motion with its band, its rise and when it has settled."""

from __future__ import annotations

from numbers import Real
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.plots import ensemble, keys, missing, style
from remanent.plots.footer import add_legend_and_footer
from remanent.results.provenance import observable_name

__all__ = ["step_response"]

#: What is read from the measures of a step.
_MEASURES: Final = ("final", "rise_time", "settling_time")
#: Share of the change at which the rise ends.
_RISEN_SHARE: Final = 0.9
#: Share of the change within which a motion has settled, where the measures do not say it.
_USUAL_BAND: Final = 0.02
#: Opacity of the band.
_BAND_OPACITY: Final = 0.3


def step_response(
    dataset: xr.Dataset,
    measures: xr.Dataset,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw a motion after a step with the band that it settles in, its rise and its settling.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``simulate`` under the same drive: the thickness stretch over ``time``, and at
        most two more dimensions.
    measures : xarray.Dataset
        The result of ``step_response``, with the same more dimensions.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name lines and marks above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member, in order of temperature.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    history : A motion without marks.
    remanent.step_response : The measures that are drawn.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> damped, step = rm.Actuator(dissipation=rm.Rayleigh(0.2)), rm.Constant(0.1)
    >>> ds = rm.simulate(damped, step, duration=40.0)
    >>> (line,) = rm.plot.step_response(ds, rm.step_response(damped, step))
    >>> plt.close()
    """
    variable = observable_name(dataset)
    _require_measures(measures, dataset)
    whole = dataset.assign({name: measures[name].variable for name in _MEASURES})
    band = measures.attrs.get("band")
    band = float(band) if isinstance(band, Real) else _USUAL_BAND
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        members = ensemble.split_into_members(
            whole, (variable, "time", *_MEASURES), ("time", "cycle")
        )
        artists = [_draw_motion(axes, member, variable, band, line) for member in members]
        style.label_axes(
            axes, style.axis_label(dataset["time"]), style.axis_label(dataset[variable])
        )
        axes.margins(x=0.0)
        missing.write_in_empty_frame(axes, members, "time", variable)
        ends = missing.mark_ends(axes, members, "time", variable)
        if legend:
            keys.add_colour_bar(axes, members)
        names = keys.line_legend_entries(members, variable)
        entries = [*names, *_mark_entries(members, band), *ends]
        # The reason of what is missing is that of the measures.
        reasons = {name: measures[name] for name in ("status", "reason") if name in measures}
        said = dataset.drop_vars(["status", "reason"], errors="ignore").assign(reasons)
        add_legend_and_footer(axes, ax, said, entries, legend=legend, footer=footer)
    return artists


def _require_measures(measures: xr.Dataset, dataset: xr.Dataset) -> None:
    lost = [name for name in _MEASURES if name not in measures]
    if lost:
        raise InputError(
            "measures",
            must=f"have {', '.join(_MEASURES)}",
            got=f"one without {', '.join(lost)}",
            why="They are marked on the motion.",
            fix="Pass the result of rm.step_response.",
        )
    sizes = {dim: size for name in _MEASURES for dim, size in measures[name].sizes.items()}
    other = {dim: size for dim, size in sizes.items() if dataset.sizes.get(dim) != size}
    if other:
        raise InputError(
            "measures",
            must="have the dimensions of the motion beside time",
            got=", ".join(f"{dim}: {size}" for dim, size in other.items()),
            why="Each motion has marks of its own.",
            fix="Pass both with the same `over`, or select the same values of both.",
        )


def _draw_motion(
    axes: Axes, member: ensemble.Member, variable: str, band: float, line: dict[str, Any]
) -> Line2D:
    """A line, its band, the time that it rises and the mark where it has settled."""
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label, **line}
    time, values = member.data["time"].values, member.data[variable].values
    (artist,) = axes.plot(time, values, **looks)
    final, rise, settled = (float(member.data[name]) for name in _MEASURES)
    start = float(values[0]) if values.size else np.nan
    if not np.isfinite([start, final]).all():
        return artist
    half = band * abs(final - start)
    axes.axhspan(final - half, final + half, color=member.colour, alpha=_BAND_OPACITY, lw=0.0,
                 zorder=1.5)  # fmt: skip
    end = _time_of_level(time, values, start + _RISEN_SHARE * (final - start))
    if np.isfinite([rise, end]).all():
        level = start + 0.5 * (final - start)
        axes.plot([end - rise, end], [level, level], color=style.ink_colour(), marker="|", ms=6.0,
                  lw=0.8, zorder=4, gid="rise")  # fmt: skip
    if np.isfinite(settled) and settled <= time[-1]:
        height = float(np.interp(settled, time, values))
        axes.plot(settled, height, "D", ms=4.0, mfc=axes.get_facecolor(), mec=member.colour,
                  mew=1.0, zorder=5, gid="settled")  # fmt: skip
    return artist


def _time_of_level(time: FloatArray, values: FloatArray, level: float) -> float:
    """When a motion first reaches a level, between two points of its line; NaN if it does not."""
    above = np.sign(values - level) != np.sign(values[0] - level)
    if not above.any():
        return float("nan")
    k = int(np.argmax(above))
    share = (level - values[k - 1]) / (values[k] - values[k - 1])
    return float(time[k - 1] + share * (time[k] - time[k - 1]))


def _mark_entries(members: list[ensemble.Member], band: float) -> list[Any]:
    """Legend entries of the band and of the marks that are there."""
    ink = style.ink_colour()
    has = {name: [np.isfinite(float(m.data[name])) for m in members] for name in _MEASURES}
    entries: list[Any] = []
    if any(has["final"]):
        entries.append(Patch(color=ink, alpha=_BAND_OPACITY, lw=0.0,
                             label=f"final ± {100.0 * band:.3g} %"))  # fmt: skip
    rise = Line2D([], [], color=ink, lw=0.8, marker="|", ms=6.0)
    settled = Line2D([], [], color=ink, linestyle="", marker="D", ms=4.0, mfc="none")
    for sample, name, word in ((rise, "rise_time", "rise"), (settled, "settling_time", "settled")):
        lost = has[name].count(False)
        share = f" ({lost} of {len(members)}: no result)" if lost else ""
        sample.set_label(f"{word}{share}")
        nothing = Line2D([], [], linestyle="", label=f"{word}: no result")
        entries.append(nothing if lost == len(members) else sample)
    return entries
