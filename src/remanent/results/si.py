"""Results in SI units, for an actuator that knows its scales."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._errors import InputError
from remanent.results.checks import require_dataset
from remanent.results.schema import Description, QuantityKind, describe, is_described

__all__ = ["to_si"]

_Array = NDArray[Any]
_Scales = Mapping[str, float]


@dataclass(frozen=True)
class _Conversion:
    """How values of one kind turn to SI: unit, conversion and, where it changes, symbol."""

    units: str
    convert: Callable[[_Array, _Scales], _Array]
    symbol_replacements: Mapping[str, str] = field(default_factory=dict)
    long_name_replacements: Mapping[str, str] = field(default_factory=dict)


#: t = tau t_0; f = omega f_0 with f_0 = 1/(2 pi t_0); B = m B_0 and, as m = b^2, B = b^2 B_0;
#: sigma = S mu; energy per reference volume = E mu; eta mu t_0 for viscosities.
_CONVERSIONS: Mapping[QuantityKind, _Conversion] = MappingProxyType(
    {
        QuantityKind.TIME: _Conversion("ms", lambda x, s: x * s["time_s"] * 1e3, {r"\tau": "t"}),
        QuantityKind.RATE: _Conversion("s-1", lambda x, s: x / s["time_s"]),
        QuantityKind.SQUARED_RATE: _Conversion("s-2", lambda x, s: x / s["time_s"] ** 2),
        QuantityKind.FREQUENCY: _Conversion(
            "Hz", lambda x, s: x * s["frequency_hz"], {r"\omega": "f"}
        ),
        QuantityKind.LOAD: _Conversion(
            "mT",
            lambda x, s: x * s["load_T"] * 1e3,
            {"m": "B", r"\bar m": r"\bar B"},
            {"magnetic load": "flux density", "mean magnetic load": "mean flux density"},
        ),
        QuantityKind.ROOT_LOAD: _Conversion(
            "mT",
            lambda x, s: x**2 * s["load_T"] * 1e3,
            {"b": r"B_{\max}"},
            {"root of the peak magnetic load": "peak flux density"},
        ),
        QuantityKind.STRESS: _Conversion(
            "kPa", lambda x, s: x * s["stress_pa"] / 1e3, {"S": r"\sigma"}
        ),
        QuantityKind.ENERGY_DENSITY: _Conversion("kJ m-3", lambda x, s: x * s["stress_pa"] / 1e3),
        QuantityKind.VISCOSITY: _Conversion("Pa s", lambda x, s: x * s["stress_pa"] * s["time_s"]),
    }
)
_LOAD_KINDS = frozenset({QuantityKind.LOAD, QuantityKind.ROOT_LOAD})
_REQUIRED_SCALES = ("time_s", "frequency_hz", "stress_pa")


def to_si(dataset: xr.Dataset) -> xr.Dataset:
    """Turn a Dataset to SI: time in ms, frequency in Hz, load in mT, stress in kPa.

    Names stay; ``units``, ``symbol`` and, where the quantity changes, ``long_name``
    change with the values.  `omega` becomes the cyclic frequency of the field,
    omega/(2 pi), and `b` the peak flux density, proportional to b^2.  Stretches,
    temperatures and counts stay as they are, and so does `error`, which compares
    dimensionless states.  Loads stay, in unit ``"1"``, where the actuator was built
    without a remanence, which ``load_T`` needs.

    Parameters
    ----------
    dataset
        A result of an actuator built with ``Actuator.from_si``; its attribute
        ``scales`` holds the scales as JSON: ``time_s`` (s per unit tau),
        ``frequency_hz`` (Hz per unit omega), ``load_T`` (T per unit m),
        ``stress_pa`` (Pa per unit S).

    Returns
    -------
    xarray.Dataset
        A new Dataset; the attribute ``scales`` is renamed ``scales_applied``.

    Raises
    ------
    InputError
        The Dataset has no scales.
    """
    require_dataset("dataset", dataset)
    scales = _read_scales(dataset)
    converted = dataset.copy()
    for name in dataset.variables:
        if not is_described(str(name)):  # labels of the caller's own
            continue
        row = describe(str(name))
        if row.kind in _CONVERSIONS and ("load_T" in scales or row.kind not in _LOAD_KINDS):
            converted = _replace_variable(
                converted, str(name), _convert_variable(dataset[name].variable, row, scales)
            )
    converted.attrs["scales_applied"] = converted.attrs.pop("scales")
    return converted


def _convert_variable(variable: xr.Variable, row: Description, scales: _Scales) -> xr.Variable:
    rule = _CONVERSIONS[row.kind]
    row = replace(
        row,
        units=rule.units,
        symbol=_rename_symbol(row.symbol, rule.symbol_replacements),
        long_name=rule.long_name_replacements.get(row.long_name, row.long_name),
    )
    values = rule.convert(np.asarray(variable.values), scales)
    return xr.Variable(variable.dims, values, {**variable.attrs, **row.attributes()})


def _rename_symbol(symbol: str, symbols: Mapping[str, str]) -> str:
    """Exchange the leading symbol and keep its decorations (index, exponent, argument)."""
    for old, new in symbols.items():
        if symbol == old or symbol.startswith((f"{old}_", f"{old}^", f"{old}(")):
            return new + symbol[len(old) :]
    return symbol


def _replace_variable(dataset: xr.Dataset, name: str, variable: xr.Variable) -> xr.Dataset:
    if name in dataset.coords:
        return dataset.assign_coords({name: variable})
    return dataset.assign({name: variable})


def _read_scales(dataset: xr.Dataset) -> _Scales:
    text = dataset.attrs.get("scales")
    already = "scales_applied" in dataset.attrs
    if text is None:
        raise InputError(
            "dataset",
            must="carry the scales of its actuator",
            got="a Dataset in SI already" if already else "one without",
            why="Dimensionless numbers turn to SI only by the modulus, density and lengths.",
            fix="Use it as it is." if already else "Build the actuator with Actuator.from_si.",
        )
    scales: dict[str, float] = json.loads(text)
    missing = [name for name in _REQUIRED_SCALES if name not in scales]
    if missing:
        raise InputError(
            "dataset",
            must=f"carry the scales {', '.join(_REQUIRED_SCALES)}",
            got=f"one without {', '.join(missing)}",
            why="Each kind of quantity needs its own.",
            fix="Build the actuator with Actuator.from_si.",
        )
    return scales
