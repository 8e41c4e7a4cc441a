"""A labelled ensemble as a list of lines, each with its colour, style and name."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.colors import Colormap, Normalize

from remanent._errors import InputError
from remanent.plots import colours, style
from remanent.plots.labels import field_label, lone_part_names
from remanent.results.provenance import (
    SYSTEM_ATTRIBUTE,
    own_variable_texts,
    read_plain_model,
)

__all__ = [
    "ColourScale", "Member", "MissingVariablesError", "split_by_colour", "split_into_members",
]  # fmt: skip

#: Variables that say what became of a member; they are kept beside what is drawn.
_EVIDENCE_VARIABLES: Final = ("status", "reason")
#: Most dimensions that a message names.
_MAX_NAMED_DIMENSIONS: Final = 2
#: Coordinates whose values are names of fields.
_FIELD_NAME_COORDINATES: Final = frozenset({"field", "parameter", "other_parameter"})
#: Kind of a system whose field ``temperature`` is one, in plain data.
_ACTUATOR_KIND: Final = "Actuator"
#: Fewest numbers that are an ordered set, with a colour map; two are told apart like words.
_MIN_ORDERED_COUNT: Final = 3
#: Most members that differ in words: every pair of a colour and a line style once.
_MAX_WORD_COUNT: Final = len(style.OKABE_ITO_COLOURS) * len(style.LINE_STYLES)


class MissingVariablesError(InputError):
    """A result does not have what is drawn; the picture, which knows whose it is, says more."""


@dataclass(frozen=True)
class ColourScale:
    """What a colour bar of an ensemble needs.

    Attributes
    ----------
    name : str
        Its label.
    normalisation : matplotlib.colors.Normalize
        Numbers to the unit interval.
    colour_map : matplotlib.colors.Colormap
        The unit interval to colours.
    """

    name: str
    normalisation: Normalize
    colour_map: Colormap


@dataclass(frozen=True)
class Member:
    """One member of an ensemble, ready to be drawn.

    Attributes
    ----------
    data : xarray.Dataset
        The Dataset with only the dimensions that are drawn along.
    colour, line_style, marker : Any, Any, str
        How it is drawn, as Matplotlib understands it.
    colour_label, style_label : str
        What its colour and its line style mean; empty where they mean nothing.
    number : float or None
        The number that its colour stands for; None where it stands for a word or nothing.
    scale : ColourScale or None
        The scale of these numbers.
    word_number : int or None
        Its place among words that differ in colour; None where colour is no word.
    """

    data: xr.Dataset
    colour: Any
    line_style: Any
    marker: str
    colour_label: str
    style_label: str
    number: float | None = None
    scale: ColourScale | None = None
    word_number: int | None = None

    @property
    def label(self) -> str:
        """What tells it from the others; empty where it is alone."""
        return ", ".join(filter(None, (self.colour_label, self.style_label)))


def split_into_members(
    dataset: xr.Dataset, names: Iterable[str], along: Iterable[str]
) -> list[Member]:
    """Split an ensemble into lines.

    Temperature is told by colour on its own map, wherever it varies.  Without it, the first
    dimension takes colours: a sequential map for three numbers or more, those of Okabe and
    Ito, with a line style and a marker each, for words and for two numbers.  The other
    dimension, if there is one, takes line styles and markers; where it has more entries than
    there are styles, the two are exchanged.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result with any of the dimensions of ``over``.
    names : iterable of str
        Variables that will be drawn.
    along : iterable of str
        Dimensions a line runs along.

    Returns
    -------
    list of Member
        In order of temperature.

    Raises
    ------
    InputError
        A variable is missing, more than two dimensions are left over, or there are more lines
        than can be told apart.
    """
    subset = _select_variables(dataset, tuple(names))
    along = tuple(along)
    if not set(along) & set(subset.dims):
        raise InputError(
            "dataset",
            must=f"have a dimension to draw along, {' or '.join(along[:_MAX_NAMED_DIMENSIONS])}",
            got=", ".join(map(str, subset.dims)) or "single values",
            why="A line is made of more than one point.",
            fix="Leave that dimension whole, or select a slice of it.",
        )
    free = [dim for dim in subset.dims if dim not in set(along)]
    if len(free) > 2:
        raise InputError(
            "dataset",
            must="have at most two dimensions beside those drawn along",
            got=", ".join(map(str, free)),
            why="Lines differ by colour and by line style, which are two.",
            fix=f"Select values first, for example dataset.isel({free[0]}=0).",
        )
    colour_dim, style_dim = _dimensions_of_colour_and_style(subset, free)
    looks = _colour_looks(subset, colour_dim)
    drawn = []
    for numbers in product(*(range(subset.sizes[dim]) for dim in free)):
        indices: dict[Hashable, int] = dict(zip(free, numbers, strict=True))
        first = indices[colour_dim] if colour_dim is not None else 0
        look = looks[first]
        second = indices[style_dim] if style_dim is not None else look.word_number or 0
        # Of words, the first is an open circle and the second a full one.
        shape = second if style_dim is not None else max(second - 1, 0)
        drawn.append(
            Member(
                data=subset.isel(indices),
                colour=look.colour,
                line_style=style.LINE_STYLES[second % len(style.LINE_STYLES)],
                marker=style.MARKERS[shape % len(style.MARKERS)],
                colour_label=_coordinate_label(subset, colour_dim, indices),
                style_label=_coordinate_label(subset, style_dim, indices),
                number=look.number,
                scale=look.scale,
                word_number=look.word_number,
            )
        )
    return sorted(drawn, key=_member_temperature)


def split_by_colour(
    dataset: xr.Dataset, names: Iterable[str], along: Iterable[str]
) -> list[Member]:
    """Split an ensemble into lines that differ in colour alone, as their style says something.

    Parameters
    ----------
    dataset, names, along : xarray.Dataset, iterable of str, iterable of str
        As for :func:`split_into_members`.

    Returns
    -------
    list of Member
        With solid lines.  Along one dimension colours are those of :func:`split_into_members`;
        of two, each pair has a colour of its own, as a word.

    Raises
    ------
    InputError
        As there, or there are more words or pairs than colours.
    """
    members = [replace(m, line_style="-") for m in split_into_members(dataset, names, along)]
    is_of_pairs = len({member.style_label for member in members}) > 1
    is_of_words = is_of_pairs or any(member.word_number for member in members)
    if is_of_words and len(members) > len(style.OKABE_ITO_COLOURS):
        raise InputError(
            "dataset",
            must=f"have at most {len(style.OKABE_ITO_COLOURS)} {'pairs of ' * is_of_pairs}values",
            got=len(members),
            why="The line style says stability, so that colours alone tell lines apart.",
            fix="Select values first, and draw several figures or axes.",
        )
    if not is_of_pairs:
        return members
    return [
        replace(member, colour=tone, colour_label=member.label, style_label="", number=None,
                scale=None, word_number=None)
        for member, tone in zip(members, colours.category_colours(len(members)), strict=True)
    ]  # fmt: skip


@dataclass(frozen=True)
class _ColourLook:
    """One colour of an ensemble, and what it stands for; see :class:`Member`."""

    colour: Any
    number: float | None = None
    scale: ColourScale | None = None
    word_number: int | None = None


def _select_variables(dataset: xr.Dataset, names: tuple[str, ...]) -> xr.Dataset:
    missing = [name for name in names if name not in dataset.variables]
    if missing:
        raise MissingVariablesError(
            "dataset",
            must=f"have the variables {', '.join(names)}",
            got=f"one without {', '.join(missing)}",
            why="They are what this plot draws.",
            fix="Pass a result that has them.",
        )
    subset = dataset[[name for name in names if name not in dataset.dims]]
    evidence = [
        name
        for name in _EVIDENCE_VARIABLES
        if name in dataset and name not in names and set(dataset[name].dims) <= set(subset.dims)
    ]
    return subset.assign({name: dataset[name] for name in evidence})


def _dimensions_of_colour_and_style(
    dataset: xr.Dataset, free: Sequence[Hashable]
) -> tuple[Hashable | None, Hashable | None]:
    """Which dimension is told by colour and which by line style."""
    temperature = dataset.coords.get("temperature")
    of_temperature = temperature.dims[0] if temperature is not None and temperature.ndim else None
    colour_dim = of_temperature if of_temperature in free else next(iter(free), None)
    style_dim = next((dim for dim in free if dim != colour_dim), None)
    most = len(style.LINE_STYLES)
    if style_dim is not None and dataset.sizes[style_dim] > most:
        colour_dim, style_dim = style_dim, colour_dim
    if style_dim is not None and dataset.sizes[style_dim] > most:
        raise InputError(
            "dataset",
            must=f"have at most {most} values along one of the two dimensions",
            got=", ".join(f"{dim}: {dataset.sizes[dim]}" for dim in free),
            why="There are so many line styles, and two lines must not look the same.",
            fix=f"Select values first, for example dataset.isel({style_dim}=slice({most})).",
        )
    return colour_dim, style_dim


def _colour_looks(dataset: xr.Dataset, dim: Hashable | None) -> list[_ColourLook]:
    """The colours along one dimension."""
    temperature = dataset.coords.get("temperature")
    if dim is None:
        kelvin = _single_temperature(dataset)
        if np.isfinite(kelvin):
            return [_ColourLook(colours.temperature_colours([kelvin])[0])]
        return [_ColourLook(colours.category_colours(1)[0])]
    if temperature is not None and temperature.dims == (dim,):
        kelvins = temperature.values.astype(float).tolist()
        normalisation, map_ = colours.temperature_scale(kelvins), colours.temperature_colour_map()
        scale = ColourScale(style.axis_label(temperature), normalisation, map_)
        return _number_looks(kelvins, colours.temperature_colours(kelvins), scale)
    count, coordinate = dataset.sizes[dim], _number_coordinate(dataset, dim)
    if coordinate is not None and count >= _MIN_ORDERED_COUNT:
        values = coordinate.values.astype(float).tolist()
        scale = ColourScale(
            style.axis_label(coordinate), colours.number_scale(values), colours.number_colour_map()
        )
        return _number_looks(values, colours.number_colours(values), scale)
    if count > _MAX_WORD_COUNT:
        raise InputError(
            "dataset",
            must=f"have at most {_MAX_WORD_COUNT} entries along {dim}",
            got=count,
            why="No more lines can be told apart by colour and line style.",
            fix=f"Select entries first, for example dataset.isel({dim}=slice(6)).",
        )
    return [
        _ColourLook(tone, word_number=k) for k, tone in enumerate(colours.category_colours(count))
    ]


def _single_temperature(dataset: xr.Dataset) -> float:
    """The one temperature of a result, K: its coordinate, or the field of its actuator; or NaN."""
    coordinate = dataset.coords.get("temperature")
    if coordinate is not None:
        return float(coordinate) if coordinate.ndim == 0 else np.nan
    varied = str(dataset.attrs.get("over", "")).split()
    table = read_plain_model(dataset, SYSTEM_ATTRIBUTE)
    if table is None or "temperature" in varied or table.get("kind") != _ACTUATOR_KIND:
        return np.nan
    value = table.get("temperature")
    return float(value) if isinstance(value, int | float) else np.nan


def _number_looks(
    values: Sequence[float], tones: Sequence[Any], scale: ColourScale
) -> list[_ColourLook]:
    return [_ColourLook(tone, x, scale) for tone, x in zip(tones, values, strict=True)]


def _number_coordinate(dataset: xr.Dataset, dim: Hashable) -> xr.DataArray | None:
    """The numbers along a dimension where it has just one set of them, and no words."""
    coords = [array for array in dataset.coords.values() if array.dims == (dim,)]
    numbers = [array for array in coords if array.dtype.kind in "fiu"]
    if len(coords) != 1 or not numbers:
        return None
    values = numbers[0].values
    return numbers[0] if np.unique(values).size == values.size else None


def _coordinate_label(
    dataset: xr.Dataset, dim: Hashable | None, indices: Mapping[Hashable, int]
) -> str:
    """Say where along one dimension a member is, by every coordinate that has just it."""
    if dim is None:
        return ""
    coords = [array for array in dataset.coords.values() if array.dims == (dim,)]
    if not coords:
        return f"{dim} {indices[dim]}"
    own, lone = own_variable_texts(dataset), lone_part_names(dataset)
    values = ((array, np.asarray(array.values[indices[dim]]).item()) for array in coords)
    return ", ".join(
        field_label(value, own, lone)
        if array.name in _FIELD_NAME_COORDINATES
        else style.value_label(array, value)
        for array, value in values
    )


def _member_temperature(member: Member) -> float:
    coordinate = member.data.coords.get("temperature")
    return float(coordinate) if coordinate is not None and coordinate.ndim == 0 else 0.0
