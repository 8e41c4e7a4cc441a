"""Equilibria against a parameter: branches joined by continuity, stable solid, unstable dashed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.plots import ensemble, keys, missing, style
from remanent.plots.footer import add_legend_and_footer
from remanent.results.provenance import ACTUATOR_OBSERVABLE, observable_name

__all__ = ["equilibria"]

#: Line styles by stability.
_LINE_STYLES: Final[Mapping[str, Any]] = MappingProxyType(
    {"stable": "-", "unstable": (0, (3.2, 1.4)), "undecided": ":"}
)
#: Variable of the thickness stretch of an actuator at rest.
_EQUILIBRIUM_STRETCH: Final = "equilibrium_stretch"
#: Names that variables of equilibria have at folds, where they are others.
_NAMES_AT_FOLDS: Final[Mapping[str, str]] = MappingProxyType(
    {_EQUILIBRIUM_STRETCH: ACTUATOR_OBSERVABLE}
)
#: Values at folds of variables that results do not give there: a fold is where stiffness is 0.
_VALUES_AT_FOLDS: Final[Mapping[str, float]] = MappingProxyType({"natural_frequency": 0.0})
#: Words where a search found that there is none.
_NO_EQUILIBRIUM: Final = "no equilibrium"
#: Step of a branch, over the height of all, above which two equilibria are not joined where
#: their number changes: one may have vanished and another appeared.
_MAX_STEP_BESIDE_FOLD: Final = 0.25
#: Distance of a fold from the nearer of its two arms, over that between them, at least.
_MIN_ARM_SHARE: Final = 1e-3
#: Cost at which two equilibria of different stability would be one.
_FORBIDDEN_COST: Final = 1e30


_Point = tuple[float, float]


@dataclass(frozen=True)
class _Branch:
    """Equilibria of one stability, joined by continuity, in order of the parameter."""

    stability: str
    points: tuple[_Point, ...]


def equilibria(
    dataset: xr.Dataset,
    variable: str | None = None,
    parameter: str | None = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw equilibria against a parameter, each branch by itself.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``equilibria`` with `parameter` in its ``over``: ``equilibrium_stretch`` (of a
        system of one's own its observable), ``stability`` and `variable` over ``equilibrium`` and
        at most two more dimensions beside that of `parameter`.  Folds that were located are
        circles, and branches lead into them; where two equilibria meet at no located fold, their
        branches end.
    variable : str, optional
        What to draw, ``natural_frequency`` for example; by default the thickness stretch, or the
        observable of a system of one's own.
    parameter : str, optional
        Against what; by default the first field of ``over``.
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
        One per branch and member: solid where stable, dashed where unstable.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    remanent.equilibria : The result that is drawn.
    landscape : The potential behind them.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import numpy as np, remanent as rm
    >>> ds = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": np.linspace(1.0, 4.0, 31)})
    >>> len(rm.plot.equilibria(ds)) >= 3  # two stable branches and an unstable one between them
    True
    >>> plt.close()
    """
    x, place = _parameter(dataset, parameter), _place_name(dataset)
    variable = place if variable is None else variable
    _require_values_of_equilibria(dataset, variable)
    at_folds = (f"fold_{x}", _name_at_folds(place), _name_at_folds(variable))
    folds = [name for name in at_folds if name in dataset]
    names = dict.fromkeys((variable, place, "stability", x, *folds))
    along = ("equilibrium", "fold", *map(str, dataset[x].dims))
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        members = ensemble.split_by_colour(dataset, names, along)
        artists: list[Line2D] = []
        circles: list[Line2D] = []
        for member in members:
            for branch in _branches(member.data, variable, x, place):
                look = _LINE_STYLES.get(branch.stability, ":")
                looks = {"color": member.colour, "linestyle": look, **line}
                artists += axes.plot(*np.transpose(branch.points), gid=branch.stability, **looks)
            circles += _mark_folds(axes, member, variable, x, place)
        style.label_axes(axes, style.axis_label(dataset[x]), style.axis_label(dataset[variable]))
        missing.write_in_empty_frame(axes, members, x, variable)
        words = _NO_EQUILIBRIUM if variable == place else missing.NO_RESULT
        gaps = missing.mark_gaps(axes, members, x, variable, words)
        if legend:
            keys.add_colour_bar(axes, members)
        ink = style.ink_colour()
        kinds = [Line2D([], [], color=ink, linestyle=look, label=name)
                 for name, look in _LINE_STYLES.items()
                 if any(artist.get_gid() == name for artist in artists)]  # fmt: skip
        entries = [*keys.line_legend_entries(members, variable), *kinds, *circles[:1], *gaps]
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artists


def _place_name(dataset: xr.Dataset) -> str:
    """The variable by which equilibria are put in order: that of which the observable is told."""
    name = observable_name(dataset)
    return _EQUILIBRIUM_STRETCH if name == ACTUATOR_OBSERVABLE else name


def _parameter(dataset: xr.Dataset, given: str | None) -> str:
    """The parameter that was given, or the first field of ``over`` that varies."""
    names = [given] if given is not None else str(dataset.attrs.get("over", "")).split()
    dims = set(dataset["stability"].dims) - {"equilibrium"} if "stability" in dataset else set()
    varying = [
        name
        for name in names
        if name in dataset.variables
        and dataset[name].ndim == 1
        and dims.issuperset(dataset[name].dims)
    ]
    if not varying and given is not None and dims:
        raise InputError(
            "parameter",
            must="be a field along which equilibria were computed",
            got=shortened_repr(given),
            why=f"Equilibria vary along {', '.join(sorted(map(str, dims)))}.",
            fix="Pass one of these, or leave it out for the first.",
        )
    if not varying:
        raise InputError(
            "dataset",
            must="be a result of equilibria over a parameter",
            got=", ".join(map(str, dataset.sizes)) or "single values",
            why="Equilibria are drawn against it.",
            fix='Pass rm.equilibria(..., over={"m": [...]}), or name a parameter that varies.',
        )
    return varying[0]


def _require_values_of_equilibria(dataset: xr.Dataset, variable: str) -> None:
    """Refuse what equilibria do not have a value of each."""
    if variable in dataset and "equilibrium" not in dataset[variable].dims:
        raise InputError(
            "variable",
            must="have a value for each equilibrium",
            got=f"{variable!r} along {', '.join(map(str, dataset[variable].dims)) or 'none'}",
            why="Equilibria are drawn at its values.",
            fix="Pass for example 'equilibrium_stretch' or 'natural_frequency'.",
        )


@dataclass(frozen=True)
class _Step:
    """How equilibria go on from one value of the parameter to the next.

    Attributes
    ----------
    joined : dict of int to int
        The equilibrium at the next value that each at this one continues to.
    ending, beginning : dict of int to (float, float)
        The fold that an equilibrium at this value ends in, or one at the next value begins in.
    """

    joined: Mapping[int, int]
    ending: Mapping[int, _Point]
    beginning: Mapping[int, _Point]


@dataclass(frozen=True)
class _Row:
    """Equilibria at one value of the parameter, in order of their stretch."""

    stretches: FloatArray
    stabilities: tuple[str, ...]
    points: tuple[_Point, ...]


def _branches(data: xr.Dataset, variable: str, x: str, place_name: str) -> list[_Branch]:
    """All branches of one member."""
    (along,) = data[x].dims
    data = data.sortby(x) if along == x else data.isel({along: np.argsort(data[x].values)})
    rows = _rows(data, variable, x, place_name)
    folds = _folds(data, variable, x, place_name)
    stretches = np.concatenate([np.zeros(0), *(row.stretches for row in rows)])
    height = float(np.ptp(stretches)) if stretches.size else 0.0
    done: list[_Branch] = []
    going: dict[int, _Branch] = {}
    before = _Row(np.empty(0), (), ())
    last = -np.inf
    for place, row in zip(data[x].values, rows, strict=True):
        step = _step(before, row, folds[(folds[:, 1] > last) & (folds[:, 1] <= place)], height)
        done += [
            _Branch(branch.stability, (*branch.points, *_only(step.ending.get(k))))
            for k, branch in going.items()
            if k not in step.joined
        ]
        earlier = {step.joined[k]: going[k].points for k in step.joined}
        going = {
            k: _Branch(word, (*earlier.get(k, ()), *_only(step.beginning.get(k)), row.points[k]))
            for k, word in enumerate(row.stabilities)
        }
        before, last = row, float(place)
    return [branch for branch in [*done, *going.values()] if _is_seen(branch)]


def _is_seen(branch: _Branch) -> bool:
    """Whether there are two neighbours to draw a line between."""
    known = np.isfinite(np.reshape(branch.points, (-1, 2))).all(axis=1)
    return bool((known[1:] & known[:-1]).any())


def _only(point: _Point | None) -> tuple[_Point, ...]:
    return () if point is None else (point,)


def _rows(data: xr.Dataset, variable: str, x: str, place_name: str) -> list[_Row]:
    (along,) = data[x].dims
    columns = [data[n].transpose(along, "equilibrium").values
               for n in (place_name, variable, "stability")]  # fmt: skip
    rows = []
    for place, stretch, value, word in zip(data[x].values, *columns, strict=True):
        order = [k for k in np.argsort(stretch) if np.isfinite(stretch[k])]
        points = tuple((float(place), float(value[k])) for k in order)
        rows.append(_Row(stretch[order], tuple(str(word[k]) for k in order), points))
    return rows


def _folds(data: xr.Dataset, variable: str, x: str, place_name: str) -> FloatArray:
    """Stretch, parameter and value of each fold, array (fold, 3)."""
    own, at_place = _name_at_folds(variable), _name_at_folds(place_name)
    if not {f"fold_{x}", at_place} <= set(data):
        return np.empty((0, 3))
    columns = [np.atleast_1d(data[n].values) for n in (at_place, f"fold_{x}")]
    at_fold = _VALUES_AT_FOLDS.get(variable, np.nan)
    columns.append(
        np.atleast_1d(data[own].values) if own in data else np.full(columns[0].shape, at_fold)
    )
    found = np.stack(columns, axis=1).astype(np.float64)
    return np.asarray(found[np.isfinite(found[:, :2]).all(axis=1)])


def _name_at_folds(variable: str) -> str:
    """The name of a variable of equilibria where folds have it."""
    return f"fold_{_NAMES_AT_FOLDS.get(variable, variable)}"


def _step(before: _Row, now: _Row, folds: FloatArray, height: float) -> _Step:
    """Join neighbouring rows: through folds where one lies between, else to the nearest."""
    ending: dict[int, _Point] = {}
    beginning: dict[int, _Point] = {}
    all_used = True
    for stretch, place, value in folds:
        left = _pair_around(before, stretch, ending)
        right = _pair_around(now, stretch, beginning)
        fewer = len(now.stretches) < len(before.stretches)
        if left and (fewer or not right):
            ending |= dict.fromkeys(left, (float(place), float(value)))
        elif right:
            beginning |= dict.fromkeys(right, (float(place), float(value)))
        else:
            all_used = False
    old = [k for k in range(len(before.stretches)) if k not in ending]
    new = [k for k in range(len(now.stretches)) if k not in beginning]
    if not old or not new:
        return _Step({}, ending, beginning)
    cost = np.abs(before.stretches[old][:, None] - now.stretches[new][None, :])
    alike = np.array([[before.stabilities[i] == now.stabilities[k] for k in new] for i in old])
    # No branch leads past a fold: where it is, the branch turns back.
    ends = np.stack(np.broadcast_arrays(before.stretches[old][:, None], now.stretches[new]), axis=2)
    low, high = ends.min(axis=2)[..., None], ends.max(axis=2)[..., None]
    alike &= ~((low < folds[:, 0]) & (folds[:, 0] < high)).any(axis=2)
    from scipy.optimize import linear_sum_assignment  # takes a while

    pairs = zip(*linear_sum_assignment(np.where(alike, cost, _FORBIDDEN_COST)), strict=True)
    is_sure = all_used and len(old) == len(new)
    longest = np.inf if is_sure else _MAX_STEP_BESIDE_FOLD * height
    joined = {old[i]: new[k] for i, k in pairs if alike[i, k] and cost[i, k] <= longest}
    return _Step(joined, ending, beginning)


def _pair_around(row: _Row, stretch: float, used: Mapping[int, _Point]) -> tuple[int, int] | None:
    """Two neighbours of different stability with a fold's stretch between them."""
    k = int(np.searchsorted(row.stretches, stretch))
    if not 0 < k < len(row.stretches) or {k - 1, k} & set(used):
        return None
    low, high = row.stretches[k - 1], row.stretches[k]
    # Where the parameter takes the value of the fold itself, one of the two is the fold.
    if min(stretch - low, high - stretch) < _MIN_ARM_SHARE * (high - low):
        return None
    return (k - 1, k) if row.stabilities[k - 1] != row.stabilities[k] else None


def _mark_folds(
    axes: Axes, member: ensemble.Member, variable: str, x: str, place_name: str
) -> list[Line2D]:
    """Circles at the folds within the range, and their legend entry."""
    folds = _folds(member.data, variable, x, place_name)
    places = member.data[x].values
    inside = (
        np.isfinite(folds[:, 2]) & (folds[:, 1] >= places.min()) & (folds[:, 1] <= places.max())
    )
    if not inside.any():
        return []
    looks: dict[str, Any] = {"marker": "o", "ms": 4.0, "mew": 1.0, "linestyle": ""}
    axes.plot(folds[inside, 1], folds[inside, 2], mfc=axes.get_facecolor(), mec=member.colour,
              zorder=5, **looks)  # fmt: skip
    return [Line2D([], [], color=style.ink_colour(), mfc="none", label="fold", **looks)]
