"""The line under a figure: which actuator, drive, tolerance and version made it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from numbers import Real
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from remanent._errors import InputError
from remanent.models.variable_text import VariableText
from remanent.plots import missing
from remanent.plots.labels import math_symbol, number_with_unit
from remanent.plots.legends import height_above
from remanent.plots.style import (
    FAINT_COLOUR,
    HouseFigure,
    add_legend_above,
    fit_label,
    format_number,
    value_label,
)
from remanent.results import provenance
from remanent.results.named_quantities import attribute_quantity
from remanent.results.schema import describe
from remanent.results.si import to_si

#: Says a value by its name.
_Say = Callable[[str, object], str]

__all__ = ["add_footer", "add_legend_and_footer", "footer_text"]

#: Fields that say nothing at this value.
_FIELD_VALUES_LEFT_OUT: Final[Mapping[str, object]] = MappingProxyType(
    {
        "entropic_fraction": 1.0,
        "temperature_coefficient": 0.0,
        "phase": 0.0,
        "mean": 0.0,
        "discard": 0.0,
        "every": 1,
        "section_phase": 0.0,
        "orbit_period": 1,
        "shear_modulus": 1.0,
        "density": 1.0,
        "remanence": 1.0,
    }
)
#: Symbol, factor and unit of the quantities that an actuator in SI was built with.
_SCALE_SYMBOLS: Final[Mapping[str, tuple[str, float, str]]] = MappingProxyType(
    {
        "shear_modulus": (r"\mu", 1e-3, "kPa"),
        "density": (r"\rho", 1.0, "kg m$^{-3}$"),
        "half_length": ("L", 1e3, "mm"),
        "remanence": ("B_r", 1e3, "mT"),
    }
)
#: Fields that may be two numbers, each with a name of its own.
_TWO_NUMBER_FIELDS: Final = frozenset({"prestress", "edges"})
#: Parts of which a figure says nothing: the units, which the axes show.
_OMITTED_PARTS: Final = frozenset({"scales"})
#: Settings of which a figure says nothing: its axes or its legend show them.
_OMITTED_SETTINGS: Final = frozenset({"measure", "parameter", "direction"})
#: Settings that are said in these words, and not by the symbol of a variable of their name.
_SETTING_WORDS: Final[Mapping[str, str]] = MappingProxyType({"step": "step", "rng": "seed"})
#: The part whose fields are said without its name: ratios to what the actuator was built with.
_PART_OF_RATIOS: Final = "physical_sizes"
#: The kind of a magnet, which is named only where it has something to say.
_CLASS_OMITTED_WITHOUT_FIELDS: Final = "Magnet"
#: The field of a system of the user's own that holds its numbers by name.
_OWN_PARAMETERS: Final = "parameters"
#: What parts the pieces of the footer.
_PIECE_SEPARATOR: Final = "   "
#: Height of a legend for which a figure has room, in points: that of two rows.
_USUAL_HEIGHT_ABOVE_POINTS: Final = 33.0
#: Size of its letters, in points.
_FONT_SIZE_POINTS: Final = 6.0
#: Width of a letter over its size, on average.
_LETTER_WIDTH_RATIO: Final = 0.43
#: Longest description that is shown where a system or a drive is no plain data.
_MAX_DESCRIPTION_LENGTH: Final = 90


def add_legend_and_footer(
    axes: Axes,
    given: Axes | None,
    dataset: xr.Dataset,
    entries: Sequence[Artist] = (),
    *,
    legend: bool = True,
    footer: bool = True,
    hide: Iterable[str] = (),
) -> None:
    """Add the legend and, to a figure of our own, the footer: the end of every plot.

    Files of a figure of our own hold the footer in their metadata, whether it is drawn or not.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What was drawn in.
    given : matplotlib.axes.Axes or None
        What the user asked to draw in; None where the figure is ours.
    dataset : xarray.Dataset
        The result that was drawn; a search that stopped early is named with its reason.
    entries : sequence of matplotlib.artist.Artist
        What the legend names; a line alone needs no name.
    legend : bool
        Whether there is a legend.
    footer : bool
        Whether the footer is drawn.
    hide : iterable of str
        Fields that the footer leaves out, see :func:`add_footer`.
    """
    if legend:
        add_legend_above(axes, entries, missing.incomplete_note(dataset))
    if given is None:
        figure = axes.get_figure(root=True)
        assert isinstance(figure, Figure)
        # A long legend makes the figure higher instead of the axes smaller.
        more = max(height_above(axes) - _USUAL_HEIGHT_ABOVE_POINTS, 0.0) / 72.0
        figure.set_figheight(figure.get_figheight() + more)
        if isinstance(figure, HouseFigure):
            figure.description = footer_text(dataset, hide=hide)
        if footer:
            add_footer(figure, dataset, hide=hide)
    fit_label(axes)


def add_footer(figure: Figure, dataset: xr.Dataset, *, hide: Iterable[str] = ()) -> None:
    """Write the footer below everything else in a figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        A figure with constrained layout, which makes room for it.
    dataset : xarray.Dataset
        The result that was drawn.
    hide : iterable of str
        Fields that took many values on the way to what is drawn; ``"drive"`` leaves
        the whole drive out.
    """
    line = footer_text(dataset, hide=hide)
    if line:
        letters = figure.get_figwidth() * 72.0 / (_FONT_SIZE_POINTS * _LETTER_WIDTH_RATIO)
        figure.supxlabel(
            _wrap_pieces(line, letters), x=0.01, ha="left", fontsize=_FONT_SIZE_POINTS,
            color=FAINT_COLOUR, linespacing=1.3,
        )  # fmt: skip


def footer_text(dataset: xr.Dataset, *, hide: Iterable[str] = ()) -> str:
    """Return the footer: parameters that the picture does not show, settings, tolerance, version.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result with the attributes of :mod:`remanent.results.provenance`; what is missing
        among them is left out.
    hide : iterable of str
        Fields that took many values on the way to what is drawn; ``"drive"`` leaves the
        whole drive out.

    Returns
    -------
    str
        Pieces parted by three blanks; empty without provenance.
    """
    attrs = dataset.attrs
    say = _value_texts(dataset)
    given = [*map(str, dataset.coords), *str(attrs.get("over", "")).split()]
    shown = {part for name in [*given, *hide] for part in (name, name.split(".")[-1])}
    single = [array for array in dataset.coords.values() if array.ndim == 0]
    pieces = [
        *(value_label(array, array.item()) for array in single),
        *_scale_texts(dataset),
        *_model_texts(dataset, provenance.SYSTEM_ATTRIBUTE, shown, say),
        *(
            []
            if "drive" in shown
            else _model_texts(dataset, provenance.DRIVE_ATTRIBUTE, shown, say)
        ),
        *_settings_texts(dataset),
    ]
    if isinstance(attrs.get("tolerance"), Real) and "tolerance" not in dataset.dims:
        pieces.append(f"tolerance ${format_number(attrs['tolerance'])}$")
    version = re.search(r"remanent \d[^,]*", str(attrs.get("versions", "")))
    return _PIECE_SEPARATOR.join([*pieces, version[0] if version else ""]).strip()


def _value_texts(dataset: xr.Dataset) -> _Say:
    """How dimensionless values are said: in SI where the Dataset is."""
    scales = dataset.attrs.get("scales_applied")
    if scales is None:
        return partial(_value_text, own=provenance.own_variable_texts(dataset))

    def say(name: str, value: object) -> str:
        variable = _variable_in_si(name, value, scales) if isinstance(value, (int, float)) else None
        if variable is None:
            return _value_text(name, value)
        return value_label(variable, float(variable))

    return say


def _variable_in_si(name: str, value: float, scales: object) -> xr.Variable | None:
    """A dimensionless value in SI, with its symbol and unit; None for a field of one's own."""
    try:
        row = describe(name)
    except InputError:
        return None
    single = xr.Dataset({name: ((), float(value), row.attributes())}, attrs={"scales": scales})
    return to_si(single)[name].variable


def _settings_texts(dataset: xr.Dataset) -> Iterator[str]:
    """The settings of a run, whose numbers are in the units of the Dataset already."""
    attrs = dataset.attrs
    for name in str(attrs.get("settings", "")).split():
        if name in attrs and name not in _OMITTED_SETTINGS and not _is_left_out(name, attrs[name]):
            yield from _setting_texts(dataset, name)


def _setting_texts(dataset: xr.Dataset, name: str) -> Iterator[str]:
    """A setting by its symbol or in words, and a range of values by the symbol of each field."""
    value = dataset.attrs[name]
    quantities = _quantities_of_setting(dataset, name)
    variables = [_variable_of(dataset, quantity) for quantity in quantities]
    words = _SETTING_WORDS.get(name)
    if quantities and isinstance(value, Real) and words is None and variables[0] is not None:
        is_its_own = quantities == [name]
        number = (value_label if is_its_own else number_with_unit)(variables[0], value)
        yield number if is_its_own else f"{name.replace('_', ' ')} {number}"
    elif quantities and np.size(value) == 2 * len(quantities):
        ranges = np.reshape(value, (-1, 2)).tolist()
        for quantity, variable, (low, high) in zip(quantities, variables, ranges, strict=True):
            known = xr.Variable((), low, {"units": "1"}) if variable is None else variable
            symbol = (variable is not None and math_symbol(variable)) or quantity
            yield f"{symbol} from ${format_number(low)}$ to {number_with_unit(known, high)}"
    elif words is not None:
        yield f"{words} ${format_number(value)}$" if isinstance(value, Real) else f"{words} {value}"
    else:
        yield _value_text(name, value)


def _quantities_of_setting(dataset: xr.Dataset, name: str) -> list[str]:
    """What the numbers of a setting are; nothing for a count, a word, or what is not known."""
    try:
        return attribute_quantity(dataset, name)
    except InputError:
        return []


def _variable_of(dataset: xr.Dataset, name: str) -> xr.Variable | None:
    """A quantity with its symbol and its unit in a Dataset; None for a field of one's own."""
    scales = dataset.attrs.get("scales_applied")
    if scales is not None:
        return _variable_in_si(name, 1.0, scales)
    try:
        row = describe(name, provenance.own_variable_texts(dataset))
    except InputError:
        return None
    return xr.Variable((), 1.0, row.attributes())


def _scale_texts(dataset: xr.Dataset) -> list[str]:
    """What turned a Dataset to SI: the quantities that the actuator was built with."""
    if "scales_applied" not in dataset.attrs:
        return []
    system = provenance.read_plain_model(dataset, provenance.SYSTEM_ATTRIBUTE) or {}
    scales = system.get("scales")
    if not isinstance(scales, dict):
        return []
    return [
        f"${symbol} = {format_number(scales[name] * factor)}$ {unit}"
        for name, (symbol, factor, unit) in _SCALE_SYMBOLS.items()
        if _is_number(scales.get(name))
    ]


def _model_texts(dataset: xr.Dataset, name: str, shown: set[str], say: _Say) -> list[str]:
    """Say a system or a drive in symbols: the number fields by symbol, the parts by name."""
    table = provenance.read_plain_model(dataset, name)
    if table is None:
        source = str(dataset.attrs.get(f"{name}_text", ""))
        return [_shorten_description(source)] if source else []
    if isinstance(table.get("drives"), dict):
        return [_load_text(load, drive, shown, say) for load, drive in table["drives"].items()]
    fields = [*_field_texts(table, shown, say)]
    if name == provenance.SYSTEM_ATTRIBUTE:
        return fields
    return [f"{_class_name(table)}: {', '.join(fields)}" if fields else _class_name(table)]


def _load_text(load: str, table: Mapping[str, Any], shown: set[str], say: _Say) -> str:
    """The drive of one of several loads, without the fields of this load that are shown."""
    own = {name.removeprefix(f"{load}.") for name in shown if name.startswith(f"{load}.")}
    fields = ", ".join(_field_texts(table, own, say))
    kind = _class_name(table)
    return f"{load.replace('_', ' ')}: {kind} ({fields})" if fields else f"{load}: {kind}"


def _field_texts(
    table: Mapping[str, Any], shown: set[str], say: _Say, owner: str = ""
) -> Iterator[str]:
    """The fields of a table of plain data, those of parts within it in brackets."""
    for name, content in table.items():
        if isinstance(content, dict) and name == _PART_OF_RATIOS:
            yield from _field_texts(content, shown, say)
        elif isinstance(content, dict) and "kind" in content and name not in _OMITTED_PARTS:
            yield from _part_texts(content, shown, say, name)
        elif isinstance(content, dict) and name == _OWN_PARAMETERS:
            yield from _field_texts(content, shown, say)
        elif isinstance(content, list):
            yield from _list_texts(name, content, shown, say)
        elif _is_number(content) and name not in shown and not _is_left_out(name, content):
            yield say(f"{owner}.{name}" if owner else name, content)


def _is_number(content: object) -> bool:
    return isinstance(content, int | float) and not isinstance(content, bool)


def _list_texts(name: str, entries: list[Any], shown: set[str], say: _Say) -> Iterator[str]:
    """The parts of a list, and the numbers of a pair."""
    for k, entry in enumerate(entries):
        if isinstance(entry, dict):
            owner = name if len(entries) == 1 else f"{name}.{k}"
            yield from _part_texts(entry, shown, say, owner)
        elif name in _TWO_NUMBER_FIELDS and f"{name}_{k + 1}" not in shown:
            yield say(f"{name}_{k + 1}", entry)


def _is_left_out(name: str, value: object) -> bool:
    return name in _FIELD_VALUES_LEFT_OUT and bool(value == _FIELD_VALUES_LEFT_OUT[name])


def _part_texts(table: Mapping[str, Any], shown: set[str], say: _Say, owner: str) -> Iterator[str]:
    kind, fields = _class_name(table), list(_field_texts(table, shown, say, owner))
    if fields or kind != _CLASS_OMITTED_WITHOUT_FIELDS:
        yield f"{kind} ({', '.join(fields)})" if fields else kind


def _class_name(table: Mapping[str, Any]) -> str:
    """The name of a class, without its module."""
    return str(table.get("kind", "")).rpartition(".")[2]


def _value_text(
    name: str, value: object, own: Mapping[str, VariableText] = MappingProxyType({})
) -> str:
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiu":
        numbers = ", ".join(f"${format_number(number)}$" for number in value)
        return f"{name.replace('_', ' ')} {numbers}"
    if not isinstance(value, (int, float)):
        return f"{name.replace('_', ' ')} {value}"
    try:
        row = describe(name, own)
    except InputError:  # a field of the user's own
        return f"{name.replace('_', ' ')} ${format_number(value)}$"
    if own:
        return value_label(xr.Variable((), value, row.attributes()), value)
    unit = f" {row.units}" if row.units == "K" else ""
    return f"${row.symbol} = {format_number(value)}${unit}"


def _shorten_description(source: str) -> str:
    flat = " ".join(source.split()).replace("$", r"\$")
    return (
        flat if len(flat) <= _MAX_DESCRIPTION_LENGTH else f"{flat[: _MAX_DESCRIPTION_LENGTH - 1]}…"
    )


def _wrap_pieces(line: str, letters: float) -> str:
    """Break between pieces where a line would be longer than the figure."""
    lines = [""]
    whole = line.split(_PIECE_SEPARATOR)
    pieces = [part for piece in whole for part in _parts_of_long_piece(piece, letters)]
    for piece in pieces:
        longer = f"{lines[-1]}{_PIECE_SEPARATOR}{piece}".strip()
        if lines[-1] and _typeset_letter_count(longer) > letters:
            lines.append(piece)
        else:
            lines[-1] = longer
    return "\n".join(lines)


def _parts_of_long_piece(piece: str, letters: float) -> list[str]:
    """A piece, at its commas where it is longer than a line."""
    if _typeset_letter_count(piece) <= letters:
        return [piece]
    return re.split(r"(?<=,) ", piece)


def _typeset_letter_count(line: str) -> int:
    """Letters once typeset, roughly: a LaTeX command counts as one."""
    return len(re.sub(r"\\mathrm|[${}^_]", "", re.sub(r"\\(?!mathrm)[A-Za-z]+", "x", line)))
