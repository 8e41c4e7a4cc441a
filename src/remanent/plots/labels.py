"""Words, symbols and numbers of figures, from the attributes of variables and the schema."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from types import MappingProxyType

import xarray as xr

from remanent._errors import InputError
from remanent.models.variable_text import VariableText
from remanent.results.provenance import SYSTEM_ATTRIBUTE, read_plain_model
from remanent.results.schema import describe

__all__ = [
    "axis_label",
    "field_label",
    "format_number",
    "lone_part_names",
    "math_symbol",
    "number_with_unit",
    "value_label",
]


def axis_label(array: xr.DataArray | xr.Variable, *, words: bool = True) -> str:
    """Return the text of an axis: meaning, symbol and, where it has one, unit.

    Parameters
    ----------
    array : xarray.DataArray or xarray.Variable
        A variable with the attributes of the schema; those that arithmetic dropped are
        looked up by its name.
    words : bool
        Whether the meaning is spelt out before the symbol.

    Returns
    -------
    str

    Examples
    --------
    >>> import xarray as xr
    >>> attrs = {"units": "ms", "long_name": "time", "symbol": "t"}
    >>> axis_label(xr.Variable((), 0.0, attrs))
    'time, $t$ (ms)'
    """
    sign = math_symbol(array)
    name = _schema_attribute(array, "long_name")
    # The symbol of one's own variable is its name, where none was given: it is said once.
    sign = "" if sign == rf"$\mathrm{{{name}}}$" else sign
    text = ", ".join(filter(None, (name, sign))) if words else sign or name
    units = _typeset_units(array)
    return f"{text} ({units})" if units else text


def math_symbol(array: xr.DataArray | xr.Variable) -> str:
    """Return the symbol between dollar signs; empty where there is none.

    Examples
    --------
    >>> import xarray as xr
    >>> math_symbol(xr.DataArray(0.0, name="b"))
    '$b$'
    """
    text = _schema_attribute(array, "symbol")
    return f"${text}$" if text else ""


def value_label(array: xr.DataArray | xr.Variable, value: object) -> str:
    """Return ``symbol = value unit``, for legends and panels.

    Examples
    --------
    >>> import xarray as xr
    >>> value_label(xr.Variable((), 0.0, {"units": "K", "symbol": "T", "long_name": ""}), 250.0)
    '$T = 250$ K'
    """
    if isinstance(value, str):
        return value
    return number_with_unit(array, value, before=f"{_schema_attribute(array, 'symbol')} = ")


def number_with_unit(array: xr.DataArray | xr.Variable, value: object, *, before: str = "") -> str:
    """Return ``value unit``, with something in the formula before the value.

    Examples
    --------
    >>> import xarray as xr
    >>> attrs = {"units": "ms", "long_name": "time", "symbol": "t"}
    >>> number_with_unit(xr.Variable((), 0.0, attrs), 14.14)
    '$14.14$ ms'
    """
    units = _typeset_units(array)
    text = f"${before}{format_number(value)}$"
    return f"{text} {units}" if units else text


def field_label(
    name: object,
    own: Mapping[str, VariableText] = MappingProxyType({}),
    lone: Collection[str] = (),
) -> str:
    r"""Return the meaning and the symbol of a field; the name itself where it has none.

    Parameters
    ----------
    name : object
    own : mapping of str to VariableText, optional
        What a system of the user's own says of its variables.
    lone : collection of str, optional
        Lists of parts with one entry, which needs no number; see :func:`lone_part_names`.

    Examples
    --------
    >>> field_label("c"), field_label("my gain")
    ('slenderness, $c$', 'my gain')
    >>> field_label("dissipation.0.eta", lone=["dissipation"])
    'viscosity, $\\eta$'
    """
    part, _, rest = str(name).partition(".0.")
    try:
        row = describe(f"{part}.{rest}" if rest and part in lone else str(name), own)
    except InputError:  # a field of the user's own
        return str(name)
    return f"{row.long_name}, ${row.symbol}$"


def lone_part_names(dataset: xr.Dataset) -> frozenset[str]:
    """Fields of the system that are lists of one part, such as ``dissipation``."""
    table = read_plain_model(dataset, SYSTEM_ATTRIBUTE) or {}
    return frozenset(
        str(name) for name, part in table.items() if isinstance(part, list) and len(part) == 1
    )


def format_number(value: object) -> str:
    """Format a number for mathtext, in at most six digits and without ``e``."""
    text = f"{float(value):.6g}"  # type: ignore[arg-type]
    mantissa, _, exponent = text.partition("e")
    if not exponent:
        return mantissa
    power = f"10^{{{int(exponent)}}}"
    return power if mantissa == "1" else rf"{mantissa}\times {power}"


def _schema_attribute(array: xr.DataArray | xr.Variable, key: str) -> str:
    """An attribute of a variable; where it is missing, that of the schema, or the name."""
    if key in array.attrs:
        return str(array.attrs[key])
    name = getattr(array, "name", None)
    if name is None:
        return ""
    try:
        return describe(str(name)).attributes()[key]
    except InputError:  # a variable of the user's own
        return str(name).replace("_", " ") if key == "long_name" else ""


def _typeset_units(array: xr.DataArray | xr.Variable) -> str:
    """Units in mathtext; nothing where dimensionless (angles are)."""
    units = _schema_attribute(array, "units")
    if units in {"", "1", "rad"}:
        return ""
    return re.sub(r"(?<=[A-Za-z])(-?\d+)", r"$^{\1}$", units)
