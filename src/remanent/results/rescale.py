"""From one temperature to another: results of an entropic actuator scale, exactly."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from types import MappingProxyType
from typing import Any, Final, TypeVar

import numpy as np
import xarray as xr

from remanent._checks import positive_rule, require_instance, require_real, shortened_repr
from remanent._errors import InputError
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.parts import Part
from remanent.models.system import System
from remanent.results import provenance
from remanent.results.checks import require_unstacked_dataset
from remanent.results.named_quantities import (
    attribute_numbers,
    attribute_quantity,
    quantities_of,
)
from remanent.results.schema import DESCRIPTIONS, QuantityKind, describe

#: Powers of the ratio of temperatures by which each kind of quantity grows.
_TEMPERATURE_POWERS_BY_KIND: Mapping[QuantityKind, float] = MappingProxyType(
    {
        QuantityKind.TIME: -0.5,
        QuantityKind.RATE: 0.5,
        QuantityKind.SQUARED_RATE: 1.0,
        QuantityKind.FREQUENCY: 0.5,
        QuantityKind.LOAD: 1.0,
        QuantityKind.ROOT_LOAD: 0.5,
        QuantityKind.STRESS: 1.0,
        QuantityKind.OWN_FIELD: 1.0,
        QuantityKind.VISCOSITY: 0.5,
        QuantityKind.ENERGY_DENSITY: 1.0,
    }
)
#: The same for fields of branches, by their last word: moduli are in units of the modulus,
#: which grows itself, and the rate at which a branch relaxes is theta/t_r.
_RELAXATION_FIELD_POWERS: Mapping[str, float] = MappingProxyType(
    {"modulus": 0.0, "relaxation_time": 0.5}
)
#: Tables of constants of materials, which are in units of the modulus or have none.
_UNSCALED_MATERIAL_FIELDS = frozenset({"moduli", "exponents", "constants"})
#: Temperatures of kind, of which only that of the body and its surroundings changes.
_TEMPERATURE_NAMES = frozenset({"temperature", "temperature_error"})
#: Errors of states, which hold stretches beside rates: grown with the rates, never shrunk.
_STATE_ERROR_NAMES = frozenset({"error", "local_error", "residual", "tolerance"})
#: Fields that say what the units are: those of the reference temperature.
_UNSCALED_FIELDS: Final = frozenset({"scales"})
#: Largest ratio of two temperatures.
_LARGEST_RATIO: Final = 1e9
_TEMPERATURE_RULE: Final = positive_rule("Temperatures are absolute.", "Pass kelvin.")

_Model = TypeVar("_Model", bound=Actuator | Part)


def rescale(
    dataset: xr.Dataset,
    *,
    temperature: float,
    system: System | None = None,
    drive: Drive | None = None,
) -> xr.Dataset:
    """Turn a result for one temperature into that for another, without computing it again.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result for one temperature of an actuator whose stress is entropic, without heat
        balance and with a remanence that does not depend on temperature.
    temperature : float
        The other temperature, K.
    system, drive : Actuator and Drive, optional
        Those that made `dataset`; by default they are read from its attributes, which
        some operations on a Dataset drop.

    Returns
    -------
    xarray.Dataset
        The same motions at that temperature, under loads, prestress, frequencies and
        viscosities that have changed in proportion; the attributes ``system`` and ``drive``
        say which.

    Raises
    ------
    InputError
        Several temperatures, an actuator or a drive that does not scale, or a Dataset that
        does not say which actuator made it.

    See Also
    --------
    remanent.to_si : The same result in SI units.

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
    require_unstacked_dataset("dataset", dataset)
    target = require_real("temperature", temperature, _TEMPERATURE_RULE)
    if "scales_applied" in dataset.attrs:
        raise InputError(
            "dataset",
            must="be dimensionless",
            got="a Dataset in SI",
            why="Its numbers scale by other powers there.",
            fix="Rescale it before rm.to_si.",
        )
    source = _require_actuator(provenance.read_system(dataset) if system is None else system)
    if system is None:
        _require_selected_values(dataset, source)
    _require_entropic(dataset, source)
    _require_unscaled_ranges(dataset)
    ratio = _ratio_of_temperatures(target, _single_temperature(dataset, source))
    scaled = dataset.copy()
    for name in dataset.variables:
        variable = _rescaled_variable(dataset, str(name), ratio, target)
        put = scaled.assign_coords if name in dataset.coords else scaled.assign
        scaled = put({name: variable})
    scaled.attrs = _rescaled_attributes(dataset, ratio)
    scaled.attrs.update(
        provenance.model_attributes("system", _rescaled_model(source, ratio, target))
    )
    if drive is None and provenance.has_drive(dataset):
        drive = provenance.read_drive(dataset)
    if drive is not None:
        require_instance("drive", drive, Drive, "Constant(0.1)")
        scaled.attrs.update(
            provenance.model_attributes("drive", _rescaled_model(drive, ratio, target))
        )
    return scaled


def _require_selected_values(dataset: xr.Dataset, source: Actuator) -> None:
    """Refuse a result that lost the value of a field of the actuator, by ``drop=True``."""
    varied = set(str(dataset.attrs.get("over", "")).split())
    lost = sorted(varied & source.parameter_values().keys() - set(map(str, dataset.variables)))
    if lost:
        raise InputError(
            "dataset",
            must="keep the values of the fields that were varied",
            got=f"one without {', '.join(lost)}",
            why="The attributes give the value before `over` changed it.",
            fix="Select without drop=True, or pass system=... with the right value.",
        )


def _require_unscaled_ranges(dataset: xr.Dataset) -> None:
    """Refuse statistics over ranges that would change with the temperature, unsaid."""
    uncertain = str(dataset.attrs.get("uncertain", "")).split()
    changed = [name for name in uncertain if _temperature_power(name) != 0.0]
    if changed:
        raise InputError(
            "dataset",
            must="be over uncertain fields that do not scale with temperature",
            got=f"statistics over {', '.join(changed)}",
            why="Their ranges would change with the temperature.",
            fix="Call rm.uncertainty at the other temperature.",
        )


def _require_actuator(system: object) -> Actuator:
    """The system, if it is one whose numbers are known to scale with temperature."""
    if not isinstance(system, Actuator):
        raise InputError(
            "system",
            must="be an Actuator",
            got=shortened_repr(system),
            why="It is not known how other systems scale with temperature.",
            fix="Compute the result at the other temperature.",
        )
    return system


def _require_entropic(dataset: xr.Dataset, system: Actuator) -> None:
    """Refuse what does not scale with temperature."""
    numbers = system.parameter_values()
    needed = {"material.entropic_fraction": 1.0, "magnet.temperature_coefficient": 0.0}
    obstacles = [
        f"{name.partition('.')[2]} = {numbers[name]}"
        for name, value in needed.items()
        if numbers.get(name, value) != value
    ]
    if system.heat is not None:
        obstacles.append(f"heat = {system.heat}")
    shifts = (getattr(element, "shift", None) for element in system.dissipative_elements())
    obstacles += [f"shift = {shift}" for shift in shifts if shift is not None]
    obstacles += sorted(set(needed) & set(map(str, dataset.coords)))
    if obstacles:
        raise InputError(
            "dataset",
            must="be of an actuator that scales with temperature",
            got=", ".join(obstacles),
            why="Only entropic stress, a constant remanence and viscosity do, and no heat balance.",
            fix="Compute it again at the other temperature.",
        )


def _single_temperature(dataset: xr.Dataset, system: Actuator) -> float:
    """The temperature of the result."""
    for name in ("temperature", "reference_temperature"):
        if name in dataset.coords and dataset[name].size != 1:
            raise InputError(
                "dataset",
                must=f"have one {name}",
                got=dataset[name].values,
                why="One ratio scales all of it.",
                fix=f"Select one: dataset.sel({name}=...).",
            )
    if "temperature" in dataset.coords:
        return float(dataset["temperature"].item())
    return system.temperature


def _ratio_of_temperatures(target: float, own: float) -> float:
    """Of the temperatures, if its powers are numbers that floats hold."""
    ratio = target / own
    if 1.0 / _LARGEST_RATIO <= ratio <= _LARGEST_RATIO:
        return ratio
    raise InputError(
        "temperature",
        must=f"be at most {_LARGEST_RATIO:g} times higher or lower than that of the dataset",
        got=f"{target:g} K for {own:g} K",
        why="Numbers that grow with its powers would be lost.",
        fix="Pass a temperature at which there are actuators.",
    )


def _temperature_power(name: str) -> float:
    """Of the ratio, by which a quantity grows."""
    if name in _TEMPERATURE_NAMES:
        return 1.0
    last = name.removesuffix("_error").rpartition(".")[2]
    if last in _RELAXATION_FIELD_POWERS:
        return _RELAXATION_FIELD_POWERS[last]
    try:
        return _TEMPERATURE_POWERS_BY_KIND.get(describe(name).kind, 0.0)
    except InputError:  # a label of the caller's own
        return 0.0


def _scale_factor(name: str, ratio: float) -> float:
    return (
        max(1.0, math.sqrt(ratio))
        if name in _STATE_ERROR_NAMES
        else ratio ** _temperature_power(name)
    )


def _rescaled_variable(
    dataset: xr.Dataset, name: str, ratio: float, temperature: float
) -> xr.Variable:
    variable = dataset[name].variable.copy(deep=True)
    if name == "temperature":
        return variable.copy(data=np.full(variable.shape, temperature))
    if variable.dtype.kind not in "fc":
        return variable
    factor = xr.Variable((), 1.0)
    for power in quantities_of(dataset, name):
        factors = [_scale_factor(str(one), ratio) ** power.power for one in np.ravel(power.names)]
        factor = factor * (
            xr.Variable((), factors[0])
            if power.dimension is None
            else xr.Variable(power.dimension, factors)
        )
    if (factor.values == 1.0).all():
        return variable
    scaled = (variable * factor).transpose(*variable.dims)
    return xr.Variable(scaled.dims, scaled.values, variable.attrs)


def _rescaled_model(value: _Model, ratio: float, temperature: float) -> _Model:
    """A system, a drive or a part with its numbers at the other temperature."""
    contents = {field.name: getattr(value, field.name) for field in fields(value)}
    return replace(
        value,
        **{
            name: _rescaled_field(name, content, ratio, temperature)
            for name, content in contents.items()
            if name not in _UNSCALED_FIELDS
        },
    )


def _rescaled_field(name: str, content: Any, ratio: float, temperature: float) -> Any:
    """A field at the other temperature: a number, a part, or a table of these."""
    if isinstance(content, Part):
        return _rescaled_model(content, ratio, temperature)
    if isinstance(content, tuple):
        return tuple(_rescaled_field(name, item, ratio, temperature) for item in content)
    if isinstance(content, bool) or not isinstance(content, int | float):
        return content
    return (
        temperature
        if name == "temperature"
        else content * ratio ** _model_field_temperature_power(name)
    )


def _model_field_temperature_power(name: str) -> float:
    """Of a field of the actuator or the drive, which must be known."""
    if name in _UNSCALED_MATERIAL_FIELDS:
        return 0.0
    parts = ("dissipation", "material", "magnet", "heat")
    for candidate in (name, f"{name}_1", *(f"{part}.{name}" for part in parts)):
        if candidate in DESCRIPTIONS:
            return _temperature_power(candidate)
    raise InputError(
        "dataset",
        must="have fields whose unit is known",
        got=name,
        why="It is not known how this one scales.",
        fix="Compute the result at the other temperature.",
    )


def _rescaled_attributes(dataset: xr.Dataset, ratio: float) -> dict[Any, Any]:
    """Settings that are quantities, such as a duration, and the tolerance."""
    scaled = dict(dataset.attrs)
    for name in map(str, dataset.attrs):
        names = ["tolerance"] if name == "tolerance" else attribute_quantity(dataset, name)
        factors = np.array([_scale_factor(one, ratio) for one in names])
        if not names or (factors == 1.0).all():
            continue
        numbers = attribute_numbers(dataset, name, len(names))
        rows = numbers.reshape(len(names), -1) * factors[:, None]
        scaled[name] = tuple(rows.ravel().tolist()) if numbers.ndim else float(rows[0, 0])
    return scaled
