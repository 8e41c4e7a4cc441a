"""A picture by every public function of ``rm.plot``, with variants of its results.

A new function takes part by itself where it draws one of the results here; else its test says
that it needs one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.container import BarContainer
from matplotlib.figure import Figure

import remanent as rm
from remanent._errors import InputError
from remanent.plots import style
from remanent.results import build, provenance
from remanent.results.si import to_si
from tests.unit.plots import synthetic

#: Inches of the smallest figure in which all text has its place.
SMALL = (3.4, 2.5)
TEMPERATURE = "temperature"


def _equilibria() -> xr.Dataset:
    over = {"m": np.linspace(1.8, 3.2, 8), TEMPERATURE: synthetic.TEMPERATURES - 60.0}
    return rm.equilibria(rm.Actuator(prestress=2.2), over=over)


def _diagram() -> xr.Dataset:
    dataset = synthetic.diagram().isel(prestress=0, drop=True)
    # One multiplier is 1 at the fold, where the amplitude is 0.6.
    first = dataset["amplitude"].values + 0.4
    moduli = np.stack([first, np.full_like(first, 0.5)], axis=-1).astype(complex)
    pair = xr.Variable((*dataset["omega"].dims, "multiplier"), moduli)
    return dataset.assign(multipliers=pair)


def _peaks() -> xr.Dataset:
    at, count = (TEMPERATURE, "peak"), (3, 2)
    kinds = np.array(["superharmonic", "primary"])
    words = {"resonance_kind": kinds, "stability": np.array(["stable", "saddle"])}
    rise = np.linspace(0.0, 0.3, 3)[:, None]
    return build.dataset(
        {
            "omega": (at, np.array([0.6, 1.1]) + rise),
            "amplitude": (at, np.array([0.1, 0.7]) - 0.3 * rise),
            **{name: (at, np.broadcast_to(word, count)) for name, word in words.items()},
            "order_p": (at, np.broadcast_to([2, 1], count)),
            "order_q": (at, np.ones(count, dtype=int)),
        },
        {TEMPERATURE: ((TEMPERATURE,), synthetic.TEMPERATURES)},
        provenance.attributes(synthetic.ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-9),
    )


def _measures() -> xr.Dataset:
    at = (TEMPERATURE,)
    return build.dataset(
        {
            "final": (at, np.array([1.1, 1.06, 1.05])),
            "rise_time": (at, np.array([0.9, 0.8, 0.7])),
            "settling_time": (at, np.array([5.0, 4.0, 3.0])),
        },
        {TEMPERATURE: (at, synthetic.TEMPERATURES)},
        provenance.attributes(synthetic.ACTUATOR, rm.Steps((0.0,), (0.16,)), 1e-9, band=0.02),
    )


def _bars() -> xr.Dataset:
    fields = [TEMPERATURE, "c", "b"]
    values = np.array([[1.0, -2.0, 0.5], [0.1, 0.2, 0.3], [0.4, -0.6, 0.2]])
    return xr.Dataset(
        {"elasticity": (("measure", "field"), values),
         "elasticity_error": (("measure", "field"), 0.1 * np.abs(values))},
        coords={"measure": ["fold", "peak", "resonance"], "field": fields},
    )  # fmt: skip


def _fit() -> xr.Dataset:
    time = np.linspace(0.0, 6.0, 13)
    stretch = 1.0 + 0.1 * np.sin(time)
    dataset = build.dataset(
        {"observed": (("observation",), stretch), "predicted": (("observation",), stretch + 0.01)},
        {"time": (("observation",), time),
         "quantity": (("observation",), np.full(time.size, "thickness_stretch"))},
        provenance.attributes(synthetic.ACTUATOR, rm.Constant(0.16), 1e-9),
    )  # fmt: skip
    return dataset


def _balance() -> xr.Dataset:
    damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    return rm.energy_balance(damped, rm.SineSquared(0.4, 1.25), times=np.linspace(0.0, 9.0, 46))


#: Results, each over temperature where one can be.
RESULTS: Mapping[str, Callable[[], xr.Dataset]] = {
    "motion": lambda: synthetic.constant(6.0, 61).isel(prestress=0),
    "section": lambda: synthetic.sections(0.0, 1.25, 12),
    "response": lambda: synthetic.frequency_response(7, 10.0).isel(prestress=0),
    "potential": lambda: synthetic.potential().isel(prestress=0),
    "equilibria": _equilibria,
    "diagram": _diagram,
    "peaks": _peaks,
    "regimes": synthetic.regimes,
    "basins": synthetic.basins_of_two,
    "bars": _bars,
    "fit": _fit,
    "balance": _balance,
}
#: The result that a function is meant for; others take the first that they draw.
MEANT: Mapping[str, str] = {
    "basins": "basins",
    "curve": "motion",
    "overview": "motion",
    "step_response": "motion",
}
#: Arguments that a function has beside its result.
MORE: Mapping[str, Callable[[], dict[str, Any]]] = {
    "curve": lambda: {"variable": "thickness_stretch", "x": "time"},
    "step_response": lambda: {"measures": _measures()},
}


@dataclass(frozen=True)
class Picture:
    """What was drawn.

    Attributes
    ----------
    title : str
        The function, the variant of its result and the style.
    dataset : xarray.Dataset
        Its result.
    artists : list
        What it returned, as a list.
    axes : matplotlib.axes.Axes
        What it drew in.
    figure : matplotlib.figure.Figure
        Laid out.
    """

    title: str
    dataset: xr.Dataset
    artists: list[Any]
    axes: Axes
    figure: Figure

    @property
    def legend_texts(self) -> list[str]:
        legend = self.axes.get_legend()
        return [] if legend is None else [text.get_text() for text in legend.get_texts()]

    @property
    def words(self) -> str:
        """Everything that is written in axes and legend, in one line."""
        texts = [text.get_text() for text in self.axes.texts]
        return " ".join([*self.legend_texts, *texts]).replace("\n", " ")


def drawing_of(name: str) -> Callable[..., Any]:
    draw: Callable[..., Any] = getattr(rm.plot, name)
    return draw


@cache
def result_of(name: str) -> xr.Dataset:
    """The result of a function: that which it is meant for, or the first that it draws."""
    if name in MEANT:
        return RESULTS[MEANT[name]]()
    for make in RESULTS.values():
        dataset = make()
        try:
            drawing_of(name)(dataset, **more_of(name, dataset), ax=Figure().add_subplot())
        except (InputError, KeyError):
            continue
        return dataset
    message = f"no result in tests/unit/plots/pictures.py is drawn by rm.plot.{name}: add one"
    raise AssertionError(message)


def more_of(name: str, dataset: xr.Dataset) -> dict[str, Any]:
    """Further arguments, selected as the result was."""
    more = MORE.get(name, dict)()
    if "measures" in more and dataset.sizes.get(TEMPERATURE, 0) != 3:
        count = dataset.sizes.get(TEMPERATURE)
        more["measures"] = more["measures"].isel(
            {TEMPERATURE: 0 if count is None else np.arange(count) % 3}
        )
    return more


def many(dataset: xr.Dataset, count: int) -> xr.Dataset | None:
    """The result at so many temperatures; None where it has not one for each."""
    if TEMPERATURE not in dataset.dims:
        return None
    values = np.linspace(250.0, 400.0, count)
    picked = dataset.isel({TEMPERATURE: np.arange(count) % dataset.sizes[TEMPERATURE]})
    attrs = dataset[TEMPERATURE].attrs
    return picked.assign_coords({TEMPERATURE: (TEMPERATURE, values, attrs)})


def in_words(dataset: xr.Dataset, count: int) -> xr.Dataset | None:
    """The result of so many cases that have names."""
    dim = TEMPERATURE if TEMPERATURE in dataset.dims else "measure"
    if dim not in dataset.dims:
        return None
    picked = dataset.isel({dim: np.arange(count) % dataset.sizes[dim]})
    names = pd.Index([f"case {k + 1}" for k in range(count)], name="case")
    return picked.drop_vars(dim).rename({dim: "case"}).assign_coords(case=names)


def at_one(dataset: xr.Dataset) -> xr.Dataset | None:
    """One temperature, which stays as a coordinate without a dimension."""
    return dataset.isel({TEMPERATURE: 0}) if TEMPERATURE in dataset.dims else None


def with_losses(dataset: xr.Dataset) -> xr.Dataset:
    """The first member without a value, or of what has no members a part of its numbers."""
    dataset = dataset.copy(deep=True)
    for variable in dataset.data_vars.values():
        if variable.dtype.kind not in "fc" or not variable.ndim:
            continue
        if TEMPERATURE in variable.dims:
            variable[{TEMPERATURE: 0}] = np.nan
        else:
            variable[{variable.dims[-1]: slice(-1, None)}] = np.nan
    if "basin" in dataset:
        dataset["basin"][-1] = -1
    elif "regime" in dataset:
        dataset["regime"][-1, -1] = ""
    return dataset


def in_si(dataset: xr.Dataset) -> xr.Dataset | None:
    """The result in SI; None where nothing in it has a unit."""
    converted = to_si(synthetic.with_scales(dataset))
    units = [array.attrs.get("units", "1") for array in converted.variables.values()]
    return converted if set(units) - {"1", "rad", "K", ""} else None


#: Variants of a result; those that it does not have are None.
VARIANTS: Mapping[str, Callable[[xr.Dataset], xr.Dataset | None]] = {
    "whole": lambda dataset: dataset,
    **{f"{n} members": partial(many, count=n) for n in (1, 2, 6, 7, 12)},
    **{f"{n} words": partial(in_words, count=n) for n in (2, 5, 12)},
    "one temperature": at_one,
    "losses": with_losses,
    "SI": in_si,
}
#: Styles of axes: ours, and those of users.
STYLES: Mapping[str, Callable[[], AbstractContextManager[Any]]] = {
    "house": lambda: mpl.rc_context({}),
    "grid": lambda: mpl.rc_context({"axes.grid": True}),
    "dark": lambda: plt.style.context("dark_background"),
}


def axes_in(looks: str) -> tuple[Figure, Axes]:
    """Axes of the smallest figure in a style; inside the style where it is the user's."""
    if looks == "house":
        return style.subplots(figsize=SMALL)
    return plt.subplots(figsize=SMALL, layout="constrained")


@cache
def picture(name: str, variant: str = "whole", looks: str = "house") -> Picture | None:
    """The picture of a variant in a style; None where the variant is none of this result's.

    The function may refuse what is too much for it, in the words of the package.
    """
    dataset = VARIANTS[variant](result_of(name))
    if dataset is None:
        return None
    with STYLES[looks]():
        figure, axes = axes_in(looks)
        try:
            found = drawing_of(name)(dataset, **more_of(name, dataset), ax=axes)
        except InputError:
            return None
        figure.draw_without_rendering()
    plt.close(figure)  # pyplot forgets it; it can still be looked at
    artists = found if isinstance(found, list) else [found]
    return Picture(f"{name}, {variant}, {looks}", dataset, artists, axes, figure)


def main_artist(found: Any) -> Any:
    """What an artist is drawn by: of bars the first one."""
    return found.patches[0] if isinstance(found, BarContainer) else found
