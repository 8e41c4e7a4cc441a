"""The actuator a user builds: dimensionless numbers and the parts of its model."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from dataclasses import replace as replace_fields
from functools import reduce
from types import MappingProxyType
from typing import Any, ClassVar, Final, Self

import numpy as np

from remanent import _checks, _units
from remanent._calls import ExplainedConstruction, explained
from remanent._checks import Rule
from remanent._errors import InputError
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent._units import Quantity
from remanent.models.dissipation import Dissipation
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.base import Material
from remanent.models.materials.named import NeoHookean
from remanent.models.pairs import is_several_numbers, split_by_direction
from remanent.models.parts import EquationStructure, Part, part_parameters
from remanent.models.physical_sizes import PHYSICAL_SIZES, PhysicalSizes
from remanent.models.plausibility import warn_of_implausible_temperatures
from remanent.models.scaling import Scales
from remanent.models.shown import ShownInNotebook
from remanent.models.temperature_shift import TemperatureShift
from remanent.models.variable_text import VariableText

#: Fields that hold one part of the model each.
_SINGLE_PART_FIELDS: Final = ("material", "heat", "magnet")

#: Fields that are parts of the model.
_PART_FIELDS: Final = (*_SINGLE_PART_FIELDS, "dissipation")

#: What `Actuator.from_si` takes besides the parts of the model.
_SIZE_ARGUMENTS: Final = (
    "shear_modulus", "density", "half_length", "half_thickness", "half_width", "force",
    "remanence", "temperature", "reference_temperature", "own_field",
)  # fmt: skip

#: The rule of both temperatures.
_TEMPERATURE_RULE: Final = _checks.positive_rule(
    "It is an absolute temperature in kelvin.", "Pass t + 273.15 for t degrees Celsius."
)


@dataclass(frozen=True, kw_only=True)
class Actuator(ShownInNotebook, metaclass=ExplainedConstruction):
    """A block of hard-magnetic elastomer under in-plane dead loads.

    Equal dead loads and edges keep both in-plane stretches equal: the motion has one
    coordinate, ``stretch``.  A pair of dead loads, or `edges`, makes two of it,
    ``stretch_1`` and ``stretch_2``; pairs of equal numbers too, so that a loss of that
    symmetry can be seen (see :func:`remanent.symmetry_check`).

    Parameters
    ----------
    c : float
        Slenderness H^2/L^2, thickness over edge, squared.
    temperature, reference_temperature : float
        T, and T0 at which the shear modulus mu and the remanence are given; kelvin.
    prestress : float or (float, float)
        Nominal stress of the dead loads over mu, S = P/(4 L H mu); a pair (S1, S2) for
        two coordinates, whose numbers are called ``prestress_1`` and ``prestress_2``.
    material : Material
        Strain energy.
    dissipation : Dissipation or sequence of Dissipation
        Dissipative elements in parallel; one element may stand by itself.
    heat : Heat, optional
        Heat balance; None holds the temperature constant.
    magnet : Magnet
        Magnetisation law and B_r(T).
    edges : (float, float), optional
        Edges of the block over L, a pair (L1/L, L2/L), called ``edges_1`` and ``edges_2``,
        for two coordinates; None for equal edges, L1 = L2 = L.
    physical_sizes : PhysicalSizes, optional
        Shear modulus, density and remanence over those that the actuator was built with; its
        numbers are called ``shear_modulus``, ``density`` and ``remanence``.  None where they
        are not varied.  `over`, `parameters` and `parameter_ranges` of verbs take these names
        of any actuator.
    scales : Scales, optional
        Scales that turn results to SI; :meth:`from_si` gives them.

    Raises
    ------
    InputError
        A number out of its range, a part of another kind, or a law of temperature that does not
        hold at the actuator's temperature.

    See Also
    --------
    Actuator.from_si : The same from sizes with units.
    equations : Its equations of motion as formulas.
    LagrangianSystem : A system of one's own, by its energies.

    Notes
    -----
    The equation of motion is [Thermal, eq. 16] with what the parts add; the page on the model
    has it, with its limits.

    Examples
    --------
    >>> Actuator(temperature=350).replace(prestress=1).parameter_values()["prestress"]
    1.0
    >>> Actuator(prestress=(0, 1)).coordinate_count
    2
    """

    c: float = 1.0
    temperature: float = 293.0
    reference_temperature: float = 293.0
    prestress: float | Sequence[float] = 0.0
    material: Material = field(default_factory=NeoHookean)
    dissipation: Dissipation | Sequence[Dissipation] = ()
    heat: Heat | None = None
    magnet: Magnet = field(default_factory=Magnet)
    edges: Sequence[float] | None = None
    physical_sizes: PhysicalSizes | None = None
    #: The physical sizes behind an actuator made by :meth:`from_si`.
    scales: Scales | None = field(default=None, compare=False, repr=False)

    #: The rule of each of the actuator's own numeric fields.
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "c": _checks.positive_rule(
                "It is the square of a ratio of lengths, H^2/L^2.",
                "Pass 1 for a cube, less for a film.",
            ),
            "temperature": _TEMPERATURE_RULE,
            "reference_temperature": _TEMPERATURE_RULE,
            "prestress": _checks.finite_rule("It is a nominal stress over the shear modulus."),
            "edges": _checks.positive_rule("It is a ratio of lengths.", "Pass 1 for an edge 2 L."),
        }
    )
    #: Fields that may be pairs; the numbers of a pair have their own names.
    pairable_fields: ClassVar[tuple[str, ...]] = ("prestress", "edges")

    def __post_init__(self) -> None:
        for name, values in self._own_numbers_by_field().items():
            numbers = [
                _checks.require_real(full, value, self.rules[name])
                for full, value in values.items()
            ]
            object.__setattr__(self, name, numbers[0] if name in values else tuple(numbers))
        object.__setattr__(self, "dissipation", _as_dissipative_elements(self.dissipation))
        _checks.require_instance("material", self.material, Material, "rm.NeoHookean()")
        _checks.require_instance("magnet", self.magnet, Magnet, "rm.Magnet()")
        if self.heat is not None:
            _checks.require_instance("heat", self.heat, Heat, "rm.Heat()")
        if self.scales is not None:
            _checks.require_instance(
                "scales", self.scales, Scales, "actuator.scales of one that from_si made"
            )
        if self.physical_sizes is not None:
            _checks.require_instance("physical_sizes", self.physical_sizes, PhysicalSizes, "None")
        self.warn_if_implausible(self.parameter_values())
        _require_valid_shifts(self)

    @property
    def coordinate_count(self) -> int:
        """1 where both in-plane stretches are equal, else 2.

        Examples
        --------
        >>> Actuator(prestress=(0.5, 0.0)).coordinate_count
        2
        """
        return 2 if self.edges is not None or is_several_numbers(self.prestress) else 1

    @property
    def load_names(self) -> tuple[str, ...]:
        """Names of the loads that a drive has to give: the magnetic load."""
        return ("load",)

    @property
    def conservative(self) -> bool:
        """Whether there is nothing in the model by which energy could be lost.

        Examples
        --------
        >>> Actuator().conservative, Actuator(heat=Heat()).conservative
        (True, False)
        """
        return not self.dissipative_elements() and self.heat is None

    @property
    def is_time_reversible(self) -> bool:
        """Whether reversed rates retrace a motion: where nothing is lost."""
        return self.conservative

    def where_dissipative(self, values: Mapping[str, ArrayLike] | None = None) -> BoolArray:
        """Whether motion loses energy, for a batch of values of numeric fields or its own."""
        p: dict[str, Any] = {**self.parameter_values(), **(values or {})}
        strengths = [
            f"dissipation.{i}.{e.strength_field_name}"
            for i, e in enumerate(self.dissipative_elements())
        ]
        if self.heat is not None:
            strengths.append("heat.exchange")
        loses = np.zeros((), dtype=np.bool_)
        for name in strengths:
            loses = loses | (np.asarray(p[name]) > 0.0)
        return np.asarray(loses)

    def needs_load_rate(
        self, values: Mapping[str, ArrayLike], varied: Collection[str] = ()
    ) -> bool:
        """Whether the rate of the load enters the equations: it warms or cools the magnet.

        That is so where the temperature is a state and the remanence depends on it.
        """
        name = "magnet.temperature_coefficient"
        coefficient = values.get(name, self.magnet.temperature_coefficient)
        depends = name in varied or bool(np.any(np.asarray(coefficient) != 0.0))
        return self.heat is not None and depends

    def _own_numbers_by_field(self) -> dict[str, dict[str, Any]]:
        """For each field that is no part of the model, its numbers under their names."""
        values = {name: getattr(self, name) for name in self.rules}
        if self.edges is None:
            del values["edges"]
        if self.coordinate_count == 1:
            return {name: {name: value} for name, value in values.items()}
        return {
            name: split_by_direction(name, value) if name in self.pairable_fields else {name: value}
            for name, value in values.items()
        }

    def dissipative_elements(self) -> tuple[Dissipation, ...]:
        """The dissipative elements, one or several, as a tuple."""
        return _as_dissipative_elements(self.dissipation)

    def parts(self) -> dict[str, Part]:
        """Every part of the model by its dotted name."""
        elements = {f"dissipation.{i}": part for i, part in enumerate(self.dissipative_elements())}
        heat = {} if self.heat is None else {"heat": self.heat}
        return {"material": self.material, **elements, **heat, "magnet": self.magnet}

    def parameter_values(self) -> dict[str, float]:
        """Value of every numeric field under its dotted name.

        Returns
        -------
        dict of str to float
            Values by the names that `over`, continuation, fits and sensitivities take.

        See Also
        --------
        Actuator.replace : A copy with other values.

        Examples
        --------
        >>> Actuator(prestress=0.5, heat=Heat()).parameter_values()["heat.coupling"]
        0.0002
        """
        single = {
            k: float(x)
            for values in self._own_numbers_by_field().values()
            for k, x in values.items()
        }
        nested = {
            f"{prefix}.{name}": value
            for prefix, part in self.parts().items()
            for name, value in part.parameter_values().items()
        }
        sizes = {} if self.physical_sizes is None else self.physical_sizes.parameter_values()
        return single | sizes | nested

    def equation_structure(self) -> EquationStructure:
        """What identifies the equations of motion: classes and choices, no numbers."""
        kind = type(self)
        shape = (
            *("coordinates", self.coordinate_count, "edges", self.edges is not None),
            *("physical_sizes", self.physical_sizes is not None),
        )
        name = f"{kind.__module__}:{kind.__qualname__}"
        return (
            name,
            shape,
            *((name, part.equation_structure()) for name, part in self.parts().items()),
        )

    def parameter_rules(self) -> dict[str, Rule]:
        """Rule of every numeric field under its dotted name."""
        nested = {
            f"{prefix}.{name}": rule
            for prefix, part in self.parts().items()
            for name, rule in part.parameter_rules().items()
        }
        return {**self._own_number_rules(), **nested}

    def _own_number_rules(self) -> dict[str, Rule]:
        """Rules of the numbers that are no part of the model."""
        own = {
            k: self.rules[name]
            for name, values in self._own_numbers_by_field().items()
            for k in values
        }
        return own if self.physical_sizes is None else {**own, **PhysicalSizes.rules}

    def where_invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a batch of values of numeric fields breaks a rule.

        Parameters
        ----------
        values
            Arrays by dotted name that broadcast against each other; other names are
            ignored.
        """
        broken = _checks.where_rule_broken(self._own_number_rules(), values)
        for prefix, part in self.parts().items():
            broken = broken | part.where_invalid(part_parameters(prefix, values))
        shifts = self._temperature_shifts()
        if not shifts:
            return np.asarray(broken)
        p = {**self.parameter_values(), **values}
        temperature, reference = (
            np.asarray(p[name]) for name in ("temperature", "reference_temperature")
        )
        for prefix, shift in shifts.items():
            holds = shift.where_valid(temperature, reference, part_parameters(prefix, p))
            broken = broken | ~np.asarray(holds)
        return np.asarray(broken)

    def _temperature_shifts(self) -> dict[str, TemperatureShift]:
        """Every dependence of a viscosity on temperature by its dotted name."""
        return {
            f"{prefix}.{name}": inner
            for prefix, part in self.parts().items()
            for name, inner in part.parts().items()
            if isinstance(inner, TemperatureShift)
        }

    def where_admissible(
        self, values: Mapping[str, ArrayLike], *coordinates: ArrayLike
    ) -> BoolArray:
        """Where stretches lie within the limits of the material.

        Parameters
        ----------
        values : mapping of name to array
            Numeric fields; those that are missing have the actuator's own value.
        *coordinates : array
            Positive in-plane stretches, one that stands for both or two, which broadcast
            with the values.
        """
        l1, l2 = (np.asarray(coordinates[k], dtype=np.float64) for k in (0, -1))
        given = {k: np.asarray(v) for k, v in part_parameters("material", values).items()}
        p = self.material.parameter_values() | given
        with np.errstate(all="ignore"):
            conditions = self.material.admissibility_conditions(l1, l2, 1.0 / (l1 * l2), p, np)
            met = [np.asarray(condition > 0.0) for condition in conditions]
        everywhere = np.ones(np.broadcast_shapes(l1.shape, l2.shape), dtype=np.bool_)
        return np.asarray(reduce(np.logical_and, met, everywhere))

    def describe_coordinate_limits(self) -> str:
        """What limits the stretches, as a noun in a message."""
        return f"the limiting chain extension of {self.material!r}"

    def warn_if_implausible(self, values: Mapping[str, ArrayLike]) -> None:
        """Warn of allowed values, single or in a batch, that look like a mistake."""
        warn_of_implausible_temperatures(values)

    def variable_texts(self) -> dict[str, VariableText]:
        """Nothing: the table of variables has all that an actuator's results hold."""
        return {}

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed; unknown fields raise `InputError`.

        Parameters
        ----------
        **changes : Any
            New values of fields, by name, such as ``temperature=350``.

        Returns
        -------
        Actuator
            The copy; the actuator itself stays as it was.

        Raises
        ------
        InputError
            An unknown field, or a value that breaks its rule.

        See Also
        --------
        Actuator.parameter_values : The numbers, by name.

        Examples
        --------
        >>> Actuator().replace(temperature=350).temperature
        350.0
        """
        _checks.require_known_names(changes, [f.name for f in fields(self)], "Actuator")
        return replace_fields(self, **changes)

    def with_parameter(self, name: str, value: float) -> Self:
        """A copy with one numeric field, given by its dotted name, changed."""
        known = [*self.parameter_values(), *PHYSICAL_SIZES]
        _checks.require_known_names([name], known, "the actuator and its parts")
        if name in PHYSICAL_SIZES:
            sizes = self.physical_sizes or PhysicalSizes()
            return self.replace(physical_sizes=sizes.replace(**{name: value}))
        for field_name, values in self._own_numbers_by_field().items():
            if name in values:
                numbers = tuple({**values, name: value}.values())
                return self.replace(**{field_name: numbers[0] if field_name == name else numbers})
        parts = {
            prefix: part.replace(**{name.removeprefix(f"{prefix}."): value})
            if name.startswith(f"{prefix}.")
            else part
            for prefix, part in self.parts().items()
        }
        elements = tuple(part for part in parts.values() if isinstance(part, Dissipation))
        single = {name: part for name, part in parts.items() if name in _SINGLE_PART_FIELDS}
        return self.replace(dissipation=elements, **single)

    @classmethod
    @explained
    def from_si(
        cls,
        *,
        shear_modulus: Quantity,
        density: Quantity,
        half_length: Quantity,
        half_thickness: Quantity,
        half_width: Quantity | None = None,
        force: Quantity | Sequence[Quantity] = "0 N",
        remanence: Quantity | None = None,
        temperature: Quantity = "293 K",
        reference_temperature: Quantity = "293 K",
        own_field: bool = False,
        **parts: Any,
    ) -> Self:
        """An actuator from quantities with units, ``"100 kPa"`` or pint's.

        Parameters
        ----------
        shear_modulus, remanence : str or quantity
            mu and B_r at the reference temperature.
        density, half_length, half_thickness : str or quantity
            rho, L and H of the undeformed block 2 L x 2 L x 2 H.
        half_width : str or quantity, optional
            L2 of a block 2 L x 2 L2 x 2 H, whose motion has two coordinates.
        force : str or quantity, or two of them
            P on each edge; the nominal stress is P/(4 L H).  A pair (P1, P2) makes two
            coordinates; P1 pulls along the edge 2 L, with the stress P1/(4 L2 H).
        temperature, reference_temperature : str or quantity
            T and T0.
        own_field : bool
            Whether the magnet's field in itself acts too: the magnet then gets the
            `demagnetisation` that the remanence and the shear modulus imply.
        **parts : Any
            `material`, `dissipation`, `heat`, `magnet`.

        Returns
        -------
        Actuator
            Dimensionless, with the scales that :func:`remanent.to_si` needs.

        Raises
        ------
        InputError
            A quantity of another kind, one that is not positive, or an unknown part.

        See Also
        --------
        to_si : Results in SI units.
        Actuator.load : The magnetic load of a flux density.

        Examples
        --------
        >>> film = Actuator.from_si(
        ...     shear_modulus="100 kPa",
        ...     density="2000 kg/m^3",
        ...     half_length="5 mm",
        ...     half_thickness="0.5 mm",
        ...     remanence="143 mT",
        ... )
        >>> round(film.c, 12), round(film.load("140 mT"), 4), round(film.frequency("300 Hz"), 4)
        (0.01, 0.1593, 1.3329)
        >>> round(film.time("1 s"), 1), round(film.stress("50 kPa"), 12)
        (1414.2, 0.5)
        >>> round(film.viscosity("20 Pa s"), 4), round(film.coupling("1.9 kJ/(kg K)"), 6)
        (0.2828, 9e-05)
        """
        known = (*_SIZE_ARGUMENTS, *_PART_FIELDS)
        _checks.require_known_names(parts, known, "Actuator.from_si")
        scales = Scales.from_quantities(
            shear_modulus=shear_modulus,
            density=density,
            half_length=half_length,
            remanence=remanence,
        )
        thickness = _units.positive_magnitude("half_thickness", half_thickness, "m")
        own_field = _checks.require_flag("own_field", own_field)
        edges = None
        if half_width is not None:
            edges = (
                1.0,
                _units.positive_magnitude("half_width", half_width, "m") / scales.half_length,
            )
        if own_field:
            magnet = parts.get("magnet", Magnet())
            _checks.require_instance("magnet", magnet, Magnet, "rm.Magnet()")
            parts["magnet"] = magnet.replace(demagnetisation=scales.demagnetisation)
        return cls(
            c=(thickness / scales.half_length) ** 2,
            temperature=_units.single_magnitude("temperature", temperature, "K"),
            reference_temperature=_units.single_magnitude(
                "reference_temperature", reference_temperature, "K"
            ),
            prestress=scales.dimensionless_nominal_stress(force, thickness, edges),
            edges=edges,
            scales=scales,
            **parts,
        )

    # From SI, by the scales that `from_si` remembered ------------------------------------

    def stress(self, stress: Quantity) -> float | FloatArray:
        """Stress or modulus over mu, ``"50 kPa"``.

        Parameters
        ----------
        stress : str, quantity or array of them
            With a unit of stress.

        Returns
        -------
        float or array
            Dimensionless.

        Raises
        ------
        InputError
            An actuator that was not made by :meth:`from_si`, or another kind of quantity.

        See Also
        --------
        Actuator.in_unit : The way back.
        """
        return self._require_scales().dimensionless_stress(stress)

    def viscosity(self, viscosity: Quantity) -> float | FloatArray:
        """Dimensionless eta of a viscosity, ``"20 Pa s"``.

        Parameters
        ----------
        viscosity : str, quantity or array of them
            With a unit of viscosity.

        Returns
        -------
        float or array
            Dimensionless, in units of mu times the unit of time.

        Raises
        ------
        InputError
            An actuator that was not made by :meth:`from_si`, or another kind of quantity.

        See Also
        --------
        Rayleigh : A dashpot with such a viscosity.
        Actuator.in_unit : The way back.
        """
        return self._require_scales().dimensionless_viscosity(viscosity)

    def coupling(self, heat_capacity: Quantity) -> float | FloatArray:
        """The coupling number mu/(rho c_p T0) of a heat capacity, ``"1.9 kJ/(kg K)"``.

        Parameters
        ----------
        heat_capacity : str, quantity or array of them
            Per mass, with its unit.

        Returns
        -------
        float or array
            Dimensionless.

        Raises
        ------
        InputError
            An actuator that was not made by :meth:`from_si`, or another kind of quantity.

        See Also
        --------
        Heat : The heat balance that it enters.
        """
        scales = self._require_scales()
        return scales.thermal_coupling(heat_capacity, self.reference_temperature)

    def load(self, flux_density: Quantity) -> float | FloatArray:
        """Magnetic load m = B_r B/(mu mu0) of a flux density, ``"140 mT"``.

        Parameters
        ----------
        flux_density : str, quantity or array of them
            B, with a unit of flux density; negative against the remanence.

        Returns
        -------
        float or array
            Dimensionless.

        Raises
        ------
        InputError
            An actuator that was not made by :meth:`from_si`, or another kind of quantity.

        See Also
        --------
        Constant : A drive with such a load.
        Actuator.in_unit : The way back.
        """
        return self._require_scales().dimensionless_load(flux_density)

    def frequency(self, frequency: Quantity) -> float | FloatArray:
        """Dimensionless omega of a frequency, ``"50 Hz"`` or ``"314 rad/s"``.

        Parameters
        ----------
        frequency : str, quantity or array of them
            With a unit of frequency or of angular frequency.

        Returns
        -------
        float or array
            Radians per unit of tau.

        Raises
        ------
        InputError
            An actuator that was not made by :meth:`from_si`, or another kind of quantity.

        See Also
        --------
        SineSquared : A drive with such a frequency.
        Actuator.in_unit : The way back.
        """
        return self._require_scales().dimensionless_frequency(frequency)

    def time(self, time: Quantity) -> float | FloatArray:
        """Dimensionless tau of a time, ``"1 s"``.

        Parameters
        ----------
        time : str, quantity or array of them
            With a unit of time.

        Returns
        -------
        float or array
            In units of tau.

        Raises
        ------
        InputError
            An actuator that was not made by :meth:`from_si`, or another kind of quantity.

        See Also
        --------
        Actuator.in_unit : The way back.
        """
        return self._require_scales().dimensionless_time(time)

    # Back to SI ---------------------------------------------------------------------------

    def in_unit(self, values: ArrayLike, unit: str) -> float | FloatArray:
        """Dimensionless numbers in a unit: the way back from :meth:`time`, :meth:`load` ...

        Parameters
        ----------
        values : array_like
            Times for ``"ms"``, angular frequencies for ``"Hz"`` and ``"rad/s"``, magnetic loads
            for ``"mT"``, stresses for ``"kPa"``, viscosities for ``"Pa s"``.
        unit : str
            A unit that pint knows.

        Returns
        -------
        float or array
            In that unit.

        Raises
        ------
        InputError
            An actuator that was not made by :meth:`from_si`, or a unit of another kind.

        See Also
        --------
        to_si : A whole result in SI units.

        Examples
        --------
        >>> film = Actuator.from_si(
        ...     shear_modulus="100 kPa",
        ...     density="2000 kg/m^3",
        ...     half_length="5 mm",
        ...     half_thickness="0.5 mm",
        ...     remanence="143 mT",
        ... )
        >>> round(film.in_unit(0.1, "Pa s"), 3), round(film.in_unit(film.load("140 mT"), "mT"), 9)
        (7.071, 140.0)
        """
        return self._require_scales().in_unit(values, unit)

    def _require_scales(self) -> Scales:
        if self.scales is None:
            raise InputError(
                "actuator",
                must="be made by Actuator.from_si to convert units",
                got="a dimensionless actuator",
                why="Dimensionless numbers alone do not fix a length or a stress.",
                fix="Build it with Actuator.from_si.",
            )
        return self.scales


def _require_valid_shifts(actuator: Actuator) -> None:
    """Raise where a law of temperature does not hold at the actuator's temperature."""
    if actuator.where_invalid({}):
        raise InputError(
            "temperature",
            must="be above T0 - c2 of every WLF shift",
            got=actuator.temperature,
            why="The law has a pole there: the element is frozen.",
            fix="Raise the temperature, pass a larger c2, or use Arrhenius.",
        )


def _as_dissipative_elements(dissipation: Any) -> tuple[Dissipation, ...]:
    """One element or several, as a tuple."""
    several = isinstance(dissipation, list | tuple)
    items = tuple(dissipation) if several else (dissipation,)
    for i, item in enumerate(items):
        name = f"dissipation.{i}" if several else "dissipation"
        eta = item if _checks.is_positive_number(item) else 0.1
        _checks.require_instance(name, item, Dissipation, f"rm.Rayleigh({eta})")
    return items
