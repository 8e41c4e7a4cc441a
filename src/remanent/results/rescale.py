"""From one temperature to another: results of an entropic actuator scale, exactly."""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import positive, require_real
from remanent._errors import InputError
from remanent.results.checks import require_dataset
from remanent.results.schema import TABLE, Kind, describe

#: Powers of the ratio of temperatures by which each kind of quantity grows.
_POWERS: Mapping[Kind, float] = MappingProxyType(
    {
        Kind.TIME: -0.5,
        Kind.RATE: 0.5,
        Kind.SQUARED_RATE: 1.0,
        Kind.FREQUENCY: 0.5,
        Kind.LOAD: 1.0,
        Kind.ROOT_LOAD: 0.5,
        Kind.STRESS: 1.0,
        Kind.OWN_FIELD: 1.0,
        Kind.VISCOSITY: 0.5,
        Kind.ENERGY_DENSITY: 1.0,
    }
)
#: The same for fields of branches, by their last word: moduli are in units of the modulus,
#: which grows itself, and the rate at which a branch relaxes is theta/t_r.
_OF_BRANCHES: Mapping[str, float] = MappingProxyType({"modulus": 0.0, "relaxation_time": 0.5})
#: Tables of constants of materials, which are in units of the modulus or have none.
_OF_MATERIALS = frozenset({"moduli", "exponents", "constants"})
#: Errors of states, which hold stretches beside rates: grown with the rates, never shrunk.
_ERRORS = frozenset({"error", "local_error", "residual", "tolerance"})
_RULE = positive("Temperatures are absolute.", "Pass kelvin.")


def rescale(dataset: xr.Dataset, *, temperature: float) -> xr.Dataset:
    """Turn a result for one temperature into that for another, without computing it again.

    Parameters
    ----------
    dataset
        A result for one temperature of an actuator whose stress is entropic, without heat
        balance and with a remanence that does not depend on temperature.
    temperature
        The other temperature, K.

    Returns
    -------
    xarray.Dataset
        The same motions at that temperature, under loads, prestress, frequencies and
        viscosities that have changed in proportion; the attributes ``actuator`` and ``drive``
        say which.

    Raises
    ------
    InputError
        Several temperatures, or an actuator or a drive that does not scale.

    Notes
    -----
    With r the ratio of temperatures, time goes with r^(−1/2); rates, frequencies, exponents,
    b, viscosities and relaxation times with r^(1/2); loads, the strength of the magnet in
    itself, stresses and energies with r; stretches and multipliers stay.  In (b²/θ, S/θ,
    ω/√θ) one chart answers for every temperature.  The equations are unchanged by this, so
    nothing is approximate; bounds on errors of states are multiplied by √r where that is
    larger than 1, and kept elsewhere.

    Examples
    --------
    >>> import remanent as rm
    >>> cool = rm.equilibria(rm.Actuator(), 0.16)
    >>> hot = rm.rescale(cool, temperature=586.0)
    >>> bool(hot.equilibrium_stretch[0] == cool.equilibrium_stretch[0])
    True
    >>> round(float(hot.natural_frequency[0] / cool.natural_frequency[0]), 4)
    1.4142
    """
    require_dataset("dataset", dataset)
    wanted = require_real("temperature", temperature, _RULE)
    actuator = _parsed(dataset, "actuator")
    _require_entropic(dataset, actuator)
    ratio = wanted / _temperature(dataset, actuator)
    scaled = dataset.copy()
    for name in dataset.variables:
        variable = _scaled(str(name), dataset[name], ratio, wanted)
        put = scaled.assign_coords if name in dataset.coords else scaled.assign
        scaled = put({name: variable})
    scaled.attrs = _attributes(dataset.attrs, ratio)
    scaled.attrs["actuator"] = ast.unparse(_changed(actuator, ratio, wanted))
    if "drive" in dataset.attrs:
        scaled.attrs["drive"] = ast.unparse(_changed(_parsed(dataset, "drive"), ratio, wanted))
    return scaled


def _parsed(dataset: xr.Dataset, name: str) -> ast.Call:
    try:
        tree = ast.parse(str(dataset.attrs.get(name, "")), mode="eval").body
    except SyntaxError:
        tree = None
    if not isinstance(tree, ast.Call):
        raise InputError(
            "dataset",
            must=f"say which {name} made it",
            got=dataset.attrs.get(name),
            why="Its own values scale with the result.",
            fix="Pass the result of a verb.",
        )
    return tree


def _require_entropic(dataset: xr.Dataset, actuator: ast.Call) -> None:
    """Refuse what does not scale with temperature."""
    fields = dict(_numbers(actuator))
    wrong = [
        f"{name} = {fields[name]}"
        for name, needed in (("entropic_fraction", 1.0), ("temperature_coefficient", 0.0))
        if fields.get(name, needed) != needed
    ]
    nodes = [k for call in _calls(actuator) for k in call.keywords if k.arg in ("heat", "shift")]
    found = [f"{k.arg} = {text}" for k in nodes if (text := ast.unparse(k.value)) != "None"]
    varied = {"material.entropic_fraction", "magnet.temperature_coefficient"}
    wrong += found + sorted(varied & set(map(str, dataset.coords)))
    if wrong:
        raise InputError(
            "dataset",
            must="be of an actuator that scales with temperature",
            got=", ".join(wrong),
            why="Only entropic stress, a constant remanence and viscosity do, and no heat balance.",
            fix="Compute it again at the other temperature.",
        )


def _calls(call: ast.Call) -> list[ast.Call]:
    """A call, and the calls in it."""
    return [node for node in ast.walk(call) if isinstance(node, ast.Call)]


def _numbers(call: ast.Call) -> list[tuple[str, Any]]:
    """Fields of a call, and of the calls in it, that are literals."""
    keywords = [k for one in _calls(call) for k in one.keywords]
    return [
        (str(k.arg), ast.literal_eval(k.value))
        for k in keywords
        if isinstance(k.value, ast.Constant | ast.UnaryOp)
    ]


def _temperature(dataset: xr.Dataset, actuator: ast.Call) -> float:
    """The temperature of the result."""
    for name in ("temperature", "reference_temperature"):
        if name in dataset.coords and dataset[name].ndim:
            raise InputError(
                "dataset",
                must=f"have one {name}",
                got=dataset[name].values,
                why="One ratio scales all of it.",
                fix=f"Select one: dataset.sel({name}=...).",
            )
    if "temperature" in dataset.coords:
        return float(dataset["temperature"])
    return float(dict(_numbers(actuator))["temperature"])


def _power(name: str) -> float:
    """Of the ratio, by which a quantity grows."""
    last = name.rpartition(".")[2]
    if last in _OF_BRANCHES:
        return _OF_BRANCHES[last]
    try:
        return _POWERS.get(describe(name).kind, 0.0)
    except InputError:
        return 0.0


def _factor(name: str, ratio: float) -> float:
    return max(1.0, math.sqrt(ratio)) if name in _ERRORS else ratio ** _power(name)


def _scaled(name: str, array: xr.DataArray, ratio: float, wanted: float) -> xr.Variable:
    variable = array.variable.copy(deep=True)
    if name == "temperature":
        return variable.copy(data=np.full(variable.shape, wanted))
    if "state" in array.dims and name != "state":
        states = [str(one) for one in array["state"].values]
        factors = xr.Variable(("state",), [_factor(one, ratio) for one in states])
        scaled = (variable * factors).transpose(*variable.dims)
        return xr.Variable(scaled.dims, scaled.values, variable.attrs)
    factor = _factor(name, ratio)
    if factor == 1.0:
        return variable
    return xr.Variable(variable.dims, variable.values * factor, variable.attrs)


def _changed(call: ast.Call, ratio: float, wanted: float) -> ast.Call:
    """The call with its numbers at the other temperature."""
    if call.args:  # arrays, whose numbers have no names
        raise _unknown(ast.unparse(call))
    keywords = [
        ast.keyword(k.arg, _value(str(k.arg), k.value, ratio, wanted)) for k in call.keywords
    ]
    return ast.Call(call.func, call.args, keywords)


def _value(name: str, node: ast.expr, ratio: float, wanted: float) -> ast.expr:
    if isinstance(node, ast.Call):
        return _changed(node, ratio, wanted)
    if isinstance(node, ast.Tuple | ast.List):
        parts = [_value(name, one, ratio, wanted) for one in node.elts]
        return type(node)(parts, ast.Load())
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return node
    if isinstance(value, bool) or not isinstance(value, int | float):
        return node
    if name == "temperature":
        return ast.Constant(wanted)
    return ast.Constant(value * ratio ** _own_power(name))


def _own_power(name: str) -> float:
    """Of a field of the actuator or the drive, which must be known."""
    if name in _OF_MATERIALS:
        return 0.0
    parts = ("dissipation", "material", "magnet")
    for known in (name, f"{name}_1", *(f"{part}.{name}" for part in parts)):
        if known in TABLE:
            return _power(known)
    raise _unknown(name)


def _unknown(what: str) -> InputError:
    return InputError(
        "dataset",
        must="have fields whose unit is known",
        got=what,
        why="It is not known how this one scales.",
        fix="Compute the result at the other temperature.",
    )


def _attributes(attrs: Mapping[Any, Any], ratio: float) -> dict[Any, Any]:
    """Settings that are quantities, such as a duration, and the tolerance."""
    names = {*str(attrs.get("settings", "")).split(), "tolerance"}
    found = dict(attrs)
    for name in names & set(attrs):
        value = attrs[name]
        if isinstance(value, int | float) and not isinstance(value, bool):
            factor = _factor(name, ratio)
            found[name] = value if factor == 1.0 else value * factor
    if "parameter_range" in found:
        factor = _factor(str(attrs.get("parameter", "omega")), ratio)
        values = np.ravel(found["parameter_range"])
        found["parameter_range"] = tuple(float(value) * factor for value in values)
    return found
