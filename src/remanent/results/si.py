"""Results in SI units, for an actuator that knows its scales."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr

from remanent._checks import is_positive_number, require_flag, shortened_repr
from remanent._errors import InputError
from remanent.models.scaling import Scales
from remanent.models.system import System
from remanent.results import provenance
from remanent.results.checks import require_unstacked_dataset
from remanent.results.named_quantities import (
    QuantityPower,
    attribute_numbers,
    attribute_quantity,
    quantities_of,
)
from remanent.results.schema import DESCRIPTIONS, Description, QuantityKind, describe
from remanent.results.si_units import (
    CONVERSIONS,
    LENGTH_CONVERSIONS,
    Conversion,
    product_of_units,
)

__all__ = ["to_si"]

_REQUIRED_SCALES: Final = ("time_s", "frequency_hz", "stress_pa")
#: What begins the names of variables that are a quantity at a point of a branch or at a start.
_POINT_PREFIXES: Final = ("special_", "fold_", "snap_", "initial.")
#: Variables that hold differences of the quantities of another one, and that one.
_DIFFERENCES_OF: Final = {
    "covariance": "estimate",
    "interval_error": "estimate",
    "deviation": None,
    "deviation_error": None,
    "average": None,
    "average_error": None,
}
#: The unit of an array whose entries have several; a coordinate says which.
_SEVERAL_UNITS: Final = "mixed"


def to_si(
    dataset: xr.Dataset, *, system: System | None = None, lengths: bool = False
) -> xr.Dataset:
    """Turn a Dataset to SI: time in ms, frequency in Hz, load in mT, stress in kPa.

    Names stay; ``units``, ``symbol`` and, where the quantity changes, ``long_name``
    change with the values.  `omega` becomes the cyclic frequency of the field,
    omega/(2 pi), and `b` the peak flux density, proportional to b^2.  Stretches,
    temperatures and counts stay as they are, and so do `error` and `tolerance`, which compare
    dimensionless states.  Loads stay, in unit ``"1"``, where the actuator was built
    without a remanence, which ``load_T`` needs.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of an actuator built with ``Actuator.from_si``; its attribute
        ``scales`` holds the scales as JSON: ``time_s`` (s per unit tau),
        ``frequency_hz`` (Hz per unit omega), ``load_T`` (T per unit m),
        ``stress_pa`` (Pa per unit S).
    system : Actuator, optional
        The actuator, where `dataset` does not say which, as after arithmetic.
    lengths : bool
        Whether stretches become lengths in mm: edges and thickness of the block 2 L x 2 L x
        2 H.  Their rates stay rates of stretches.

    Returns
    -------
    xarray.Dataset
        A new Dataset; the attribute ``scales`` is renamed ``scales_applied``.  Where the
        entries of a variable have several units, as the estimates of a fit, its ``units`` are
        ``mixed`` and a coordinate, ``parameter_unit``, says which.  Settings among the
        attributes are converted too; ``settings_units`` has their units.

    Raises
    ------
    InputError
        The Dataset has no scales, or numbers whose quantity is not known: a measure that is a
        function.

    See Also
    --------
    Actuator.from_si : The actuator with its units.
    rescale : A result for another temperature.

    Examples
    --------
    >>> import remanent as rm
    >>> film = rm.Actuator.from_si(
    ...     shear_modulus="100 kPa",
    ...     density="2000 kg/m^3",
    ...     half_length="5 mm",
    ...     half_thickness="0.5 mm",
    ...     remanence="143 mT",
    ... )
    >>> rest = rm.to_si(rm.equilibria(film, film.load("140 mT")), lengths=True)
    >>> float(rest.equilibrium_stretch[0].round(3)), rest.equilibrium_stretch.units
    (1.056, 'mm')
    """
    require_unstacked_dataset("dataset", dataset)
    scales = _read_scales(dataset, system)
    units = _Units(dataset, scales, require_flag("lengths", lengths))
    converted = dataset.copy()
    for name in map(str, dataset.variables):
        for label, variable in units.converted_variable(name).items():
            is_coordinate = label in dataset.coords or label not in dataset.variables
            put = converted.assign_coords if is_coordinate else converted.assign
            converted = put({label: variable})
    converted.attrs = units.converted_attributes()
    return converted


@dataclass(frozen=True)
class _Units:
    """The conversion of one result.

    Attributes
    ----------
    dataset : xarray.Dataset
    scales : mapping of str to float or DataArray
        An array where what they depend on was varied.
    has_lengths : bool
        Whether stretches become lengths.
    """

    dataset: xr.Dataset
    scales: Mapping[str, Any]
    has_lengths: bool

    def converted_variable(self, name: str) -> dict[str, xr.Variable]:
        """A variable in SI by its name, with the units of its labels where these differ.

        Nothing for plain numbers, text and labels.
        """
        array = self.dataset[name]
        if array.dtype.kind not in "fc":
            return {}
        if name.removesuffix("_error") == "elasticity":
            return self._converted_elasticity(name)
        quantities = quantities_of(self.dataset, name)
        conversions = [[self._conversion(str(q)) for q in np.ravel(p.names)] for p in quantities]
        if not any(one is not None for row in conversions for one in row):
            return {}
        values = array
        for power, row in zip(quantities, conversions, strict=True):
            values = self._converted_values(name, values, power, row)
        values = values.transpose(*array.dims)
        return self._labelled(name, values, quantities, conversions)

    def converted_attributes(self) -> dict[str, Any]:
        """Attributes with settings in SI and what their units are."""
        attrs, units = dict(self.dataset.attrs), {}
        for name in map(str, self.dataset.attrs):
            names = attribute_quantity(self.dataset, name)
            if not names:
                continue
            numbers = attribute_numbers(self.dataset, name, len(names))
            rows = np.atleast_1d(numbers).reshape(len(names), -1)
            for row, quantity in zip(rows, names, strict=True):
                conversion = self._conversion(quantity)
                if conversion is not None:
                    factor = self._single_factor(conversion, name)
                    row[:] = (np.sign(row) * row**2 if conversion.squares else row) * factor
                    units[name] = conversion.units
            if name in units:
                attrs[name] = (
                    float(rows[0, 0]) if not numbers.ndim else tuple(rows.ravel().tolist())
                )
        attrs.pop("scales", None)
        plain = {k: v for k, v in self.scales.items() if isinstance(v, float)}
        attrs["scales_applied"] = json.dumps(plain, sort_keys=True)
        if units:
            attrs["settings_units"] = ", ".join(f"{name}: {unit}" for name, unit in units.items())
        return attrs

    def _conversion(self, quantity: str) -> Conversion | None:
        """How a named quantity turns to SI; None where it stays."""
        base = quantity
        for prefix in _POINT_PREFIXES:
            base = base.removeprefix(prefix)
        if self.has_lengths and base.removesuffix("_error") in LENGTH_CONVERSIONS:
            found: Conversion | None = LENGTH_CONVERSIONS[base.removesuffix("_error")]
        else:
            found = CONVERSIONS.get(_kind(quantity))
        known = found is not None and all(need in self.scales for need in found.needs)
        return found if known else None

    def _single_factor(self, conversion: Conversion, name: str) -> float:
        factor = conversion.factor(self.scales)
        if np.ndim(factor):
            raise InputError(
                "dataset",
                must=f"have one unit for {name}",
                got="several, as what it depends on was varied",
                why="A setting is one number.",
                fix="Select one value of what was varied.",
            )
        return float(factor)

    def _converted_values(
        self, name: str, values: xr.DataArray, power: QuantityPower, row: list[Conversion | None]
    ) -> xr.DataArray:
        """Values times the power of the units of one factor."""
        factors = [1.0 if one is None else one.factor(self.scales) for one in row]
        squares = [one is not None and one.squares for one in row]
        if power.dimension is None:
            factor, is_squared = factors[0], xr.DataArray(squares[0])
        else:
            # Units that are arrays do not go with labels: no quantity along labels has one.
            factor = xr.DataArray([float(f) for f in factors], dims=power.dimension)
            is_squared = xr.DataArray(squares, dims=power.dimension)
        if any(squares):
            if _holds_differences(name):
                slope = xr.DataArray(2.0 * np.abs(self._point(name, power)))
                values = values * xr.DataArray(slope**power.power).where(is_squared, 1.0)
            else:
                values = xr.DataArray(np.sign(values) * values**2).where(is_squared, values)
        return values * factor**power.power

    def _point(self, name: str, power: QuantityPower) -> xr.DataArray:
        """The values at which differences of squared quantities are taken."""
        base = name.removesuffix("_error")
        if power.power < 0 or (base == "derivative" and power.dimension == "field"):
            numbers = provenance.read_drive(self.dataset).parameter_values()
            values = [numbers.get(str(field), 0.0) for field in np.ravel(power.names)]
            return xr.DataArray(values, dims=power.dimension)
        if base == "derivative":
            return self.dataset["value"].drop_vars(self.dataset["value"].coords)
        of = "estimate" if base == "covariance" else base
        if of not in self.dataset.variables or base in {"average", "deviation"}:
            raise InputError(
                "dataset",
                must="hold the value that each difference of squares is of",
                got=f"{name} of a load that is a square",
                why="The flux density goes with b², so that its differences go with b.",
                fix="Convert them by hand, or ask for the measure at single values.",
            )
        point = self.dataset[of].drop_vars(self.dataset[of].coords)
        if power.dimension == "other_parameter":
            return point.rename(parameter="other_parameter")
        return point

    def _converted_elasticity(self, name: str) -> dict[str, xr.Variable]:
        """Relative changes by those of a square are half as large, and of a square twice."""
        array = self.dataset[name]
        quantities = quantities_of(self.dataset, name.replace("elasticity", "derivative"))
        factor: Any = 1.0
        for power in quantities:
            rows = [self._conversion(str(one)) for one in np.ravel(power.names)]
            twos = [2.0 if one is not None and one.squares else 1.0 for one in rows]
            factor = (
                factor
                * (xr.DataArray(twos, dims=power.dimension) if power.dimension else twos[0])
                ** power.power
            )
        values = (array * factor).transpose(*array.dims)
        return {name: xr.Variable(array.dims, values.values, array.attrs)}

    def _labelled(
        self,
        name: str,
        values: xr.DataArray,
        quantities: list[QuantityPower],
        conversions: list[list[Conversion | None]],
    ) -> dict[str, xr.Variable]:
        """A converted variable with what it is now, and the units of labels that differ."""
        attrs, result = dict(self.dataset[name].attrs), {}
        powers: dict[str, int] = {}
        mixed = False
        for power, row in zip(quantities, conversions, strict=True):
            texts = [
                one.units if one is not None else _plain_units(str(q))
                for one, q in zip(row, np.ravel(power.names), strict=True)
            ]
            if len(set(texts)) > 1:
                mixed = True
            elif texts:
                powers[texts[0]] = powers.get(texts[0], 0) + power.power
            unit_name = f"{power.dimension}_unit"
            if power.dimension is not None and unit_name in DESCRIPTIONS:
                attributes = describe(unit_name).attributes()
                result[unit_name] = xr.Variable(power.dimension, np.array(texts), attributes)
        attrs["units"] = _SEVERAL_UNITS if mixed else product_of_units(powers)
        own = _own_conversion(name, quantities, conversions)
        if own is not None:
            row_in_si = own.described(describe(name))
            attrs |= row_in_si.attributes()
        result[name] = xr.Variable(values.dims, values.values, attrs)
        return result


def _own_conversion(
    name: str, quantities: list[QuantityPower], conversions: list[list[Conversion | None]]
) -> Conversion | None:
    """The conversion of a variable that is the quantity of its own name."""
    (first, *rest) = quantities
    is_own = not rest and first.dimension is None and str(first.names) == name
    return conversions[0][0] if is_own else None


def _holds_differences(name: str) -> bool:
    """Whether a variable holds differences of quantities, not values of them."""
    return name.endswith("_error") or name in {*_DIFFERENCES_OF, "derivative"}


def _kind(quantity: str) -> QuantityKind:
    try:
        return describe(quantity).kind
    except InputError:  # a label of the caller's own
        return QuantityKind.NONE


def _plain_units(quantity: str) -> str:
    """The unit of what does not change."""
    try:
        row: Description = describe(quantity)
    except InputError:
        return "1"
    return row.units if row.kind is QuantityKind.TEMPERATURE or row.units == "K-1" else "1"


def _read_scales(dataset: xr.Dataset, system: System | None) -> Mapping[str, Any]:
    """Factors by the names that results carry, and the sizes of the body."""
    text = dataset.attrs.get("scales")
    already = "scales_applied" in dataset.attrs
    if already or (text is None and system is None):
        raise InputError(
            "dataset",
            must="carry the scales of its actuator",
            got="a Dataset in SI already" if already else "one without",
            why="Dimensionless numbers turn to SI only by the modulus, density and lengths.",
            fix="Use it as it is."
            if already
            else "Pass system=..., an actuator that Actuator.from_si made.",
        )
    given = None if system is None else _require_scales(system)
    factors = _factors_in_text(str(text)) if given is None else given.si_factors()
    missing = [name for name in _REQUIRED_SCALES if name not in factors]
    if missing:
        raise InputError(
            "dataset",
            must=f"carry the scales {', '.join(_REQUIRED_SCALES)}",
            got=f"one without {', '.join(missing)}",
            why="Each kind of quantity needs its own.",
            fix="Pass system=..., an actuator that Actuator.from_si made.",
        )
    return {**factors, **_body_sizes(dataset, system)}


def _factors_in_text(text: str) -> dict[str, float]:
    """Factors by their names, as the attribute holds them; none where it holds something else."""
    try:
        content = json.loads(text)
    except ValueError:
        return {}
    numbers = content.items() if isinstance(content, dict) else ()
    return {name: factor for name, factor in numbers if is_positive_number(factor)}


def _require_scales(system: object) -> Scales:
    scales = getattr(system, "scales", None)
    if not isinstance(scales, Scales):
        raise InputError(
            "system",
            must="be made by Actuator.from_si",
            got=shortened_repr(system),
            why="Dimensionless numbers alone do not fix a length or a stress.",
            fix="Build it with Actuator.from_si.",
        )
    return scales


def _body_sizes(dataset: xr.Dataset, system: System | None) -> dict[str, Any]:
    """Density, remanence, half lengths and reference temperature, as far as they are known."""
    if system is None:
        try:
            system = provenance.read_system(dataset)
        except InputError:
            return {}
    scales, numbers = getattr(system, "scales", None), system.parameter_values()
    if not isinstance(scales, Scales):
        return {}
    values = {name: _value_of_field(dataset, name, number) for name, number in numbers.items()}
    edge = scales.half_length
    sizes = {
        "density": scales.density,
        "remanence": scales.remanence,
        "reference_temperature": values.get("reference_temperature"),
        "half_thickness": edge * np.sqrt(values["c"]) if "c" in values else None,
        "half_edge": edge,
        "half_edge_1": edge * values.get("edges_1", 1.0),
        "half_edge_2": edge * values.get("edges_2", 1.0),
    }
    return {name: size for name, size in sizes.items() if size is not None}


def _value_of_field(dataset: xr.Dataset, name: str, own: float) -> Any:
    """A field as it was varied, else its own value."""
    varied = str(dataset.attrs.get("over", "")).split()
    if name not in varied or name not in dataset.variables:
        return own
    return dataset[name].drop_vars(dataset[name].coords)
