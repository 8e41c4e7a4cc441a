"""The actuator a user builds: dimensionless numbers and the parts of its model."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from dataclasses import replace as replace_fields
from functools import reduce
from types import MappingProxyType
from typing import Any, ClassVar, Final, Self

import numpy as np

from remanent import _checks, _units
from remanent._checks import Rule
from remanent._errors import InputError, InputWarning
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent._units import Quantity
from remanent.models.dissipation import Dissipation, own
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.base import Material
from remanent.models.materials.named import NeoHookean
from remanent.models.parts import Part, Structure
from remanent.models.scaling import Scales
from remanent.models.temperature_shift import Shift

#: Below this temperature, in kelvin, a value is probably meant in degrees Celsius.
COLD: Final = 100.0

#: The rating of plain NdFeB magnets, in kelvin.
WARM: Final = 353.15

#: Fields that are parts of the model.
PARTS: Final = ("material", "dissipation", "heat", "magnet")
_SINGLE: Final = ("material", "heat", "magnet")

_TEMPERATURE: Final = _checks.positive(
    "It is an absolute temperature in kelvin.", "For t degrees Celsius pass t + 273.15."
)


@dataclass(frozen=True, kw_only=True)
class Actuator:
    """A block of hard-magnetic elastomer under in-plane dead loads.

    Equal dead loads and edges keep both in-plane stretches equal: the motion has one
    coordinate, ``stretch``.  A pair of dead loads, or `edges`, makes two of it,
    ``stretch_1`` and ``stretch_2``; pairs of equal numbers too, so that a loss of that
    symmetry can be seen (see :func:`remanent.symmetry_check`).

    Parameters
    ----------
    c
        Slenderness H^2/L^2, thickness over edge, squared.
    temperature, reference_temperature
        T, and T0 at which the shear modulus mu and the remanence are given; kelvin.
    prestress
        Nominal stress of the dead loads over mu, S = P/(4 L H mu); a pair (S1, S2) for
        two coordinates, whose numbers are called ``prestress_1`` and ``prestress_2``.
    material
        Strain energy.
    dissipation
        Dissipative elements in parallel; one element may stand by itself.
    heat
        Heat balance; None holds the temperature constant.
    magnet
        Magnetisation law and B_r(T).
    edges
        Edges of the block over L, a pair (L1/L, L2/L), called ``edges_1`` and ``edges_2``,
        for two coordinates; None for equal edges, L1 = L2 = L.

    Examples
    --------
    >>> Actuator(temperature=350).replace(prestress=1).parameters()["prestress"]
    1.0
    >>> Actuator(prestress=(0, 1)).coordinates
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
    #: The physical sizes behind an actuator made by :meth:`from_si`.
    scales: Scales | None = field(default=None, compare=False, repr=False)

    #: The rule of each of the actuator's own numeric fields.
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "c": _checks.positive(
                "It is the square of a ratio of lengths, H^2/L^2.",
                "Pass 1 for a cube, less for a film.",
            ),
            "temperature": _TEMPERATURE,
            "reference_temperature": _TEMPERATURE,
            "prestress": _checks.finite("It is a nominal stress over the shear modulus."),
            "edges": _checks.positive("It is a ratio of lengths.", "Pass 1 for an edge 2 L."),
        }
    )
    #: Fields that may be pairs; the numbers of a pair have their own names.
    paired: ClassVar[tuple[str, ...]] = ("prestress", "edges")

    def __post_init__(self) -> None:
        for name, values in self._own().items():
            numbers = [
                _checks.require_real(full, value, self.rules[name])
                for full, value in values.items()
            ]
            object.__setattr__(self, name, numbers[0] if name in values else tuple(numbers))
        object.__setattr__(self, "dissipation", _elements(self.dissipation))
        _checks.require_instance("material", self.material, Material, "NeoHookean()")
        _checks.require_instance("magnet", self.magnet, Magnet, "Magnet()")
        if self.heat is not None:
            _checks.require_instance("heat", self.heat, Heat, "Heat()")
        self.warn_if_implausible(self.parameters(), stacklevel=4)
        _require_shifts(self)

    @property
    def coordinates(self) -> int:
        """1 where both in-plane stretches are equal, else 2."""
        return 2 if self.edges is not None or _is_pair(self.prestress) else 1

    @property
    def conservative(self) -> bool:
        """Whether there is nothing in the model by which energy could be lost."""
        return not self.elements() and self.heat is None

    def dissipative(self, values: Mapping[str, ArrayLike] | None = None) -> BoolArray:
        """Whether motion loses energy, for a batch of values of numeric fields or its own."""
        whole: dict[str, Any] = {**self.parameters(), **(values or {})}
        names = [f"dissipation.{i}.{e.strength}" for i, e in enumerate(self.elements())]
        if self.heat is not None:
            names.append("heat.exchange")
        found = np.zeros((), dtype=np.bool_)
        for name in names:
            found = found | (np.asarray(whole[name]) > 0.0)
        return np.asarray(found)

    def _own(self) -> dict[str, dict[str, Any]]:
        """Values of the actuator's own fields, under the name of each number."""
        own = {name: getattr(self, name) for name in self.rules}
        if self.edges is None:
            del own["edges"]
        if self.coordinates == 1:
            return {name: {name: value} for name, value in own.items()}
        return {
            name: _numbered(name, value) if name in self.paired else {name: value}
            for name, value in own.items()
        }

    def elements(self) -> tuple[Dissipation, ...]:
        """The dissipative elements, one or several, as a tuple."""
        return _elements(self.dissipation)

    def parts(self) -> dict[str, Part]:
        """Every part of the model by its dotted name."""
        elements = {f"dissipation.{i}": part for i, part in enumerate(self.elements())}
        heat = {} if self.heat is None else {"heat": self.heat}
        return {"material": self.material, **elements, **heat, "magnet": self.magnet}

    def parameters(self) -> dict[str, float]:
        """Value of every numeric field under its dotted name."""
        own = {k: float(value) for values in self._own().values() for k, value in values.items()}
        nested = {
            f"{prefix}.{name}": value
            for prefix, part in self.parts().items()
            for name, value in part.parameters().items()
        }
        return own | nested

    def structure(self) -> Structure:
        """What identifies the equations of motion: classes and choices, no numbers."""
        shape = ("coordinates", self.coordinates, "edges", self.edges is not None)
        return (shape, *((name, part.structure()) for name, part in self.parts().items()))

    def parameter_rules(self) -> dict[str, Rule]:
        """Rule of every numeric field under its dotted name."""
        nested = {
            f"{prefix}.{name}": rule
            for prefix, part in self.parts().items()
            for name, rule in part.numeric_rules().items()
        }
        return {**self._own_rules(), **nested}

    def _own_rules(self) -> dict[str, Rule]:
        return {k: self.rules[name] for name, values in self._own().items() for k in values}

    def invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a batch of values of numeric fields breaks a rule.

        Parameters
        ----------
        values
            Arrays by dotted name that broadcast against each other; other names are
            ignored.
        """
        wrong = _checks.broken(self._own_rules(), values)
        for prefix, part in self.parts().items():
            wrong = wrong | part.invalid(own(values, prefix))
        whole = {**self.parameters(), **values}
        for prefix, shift in self._shifts().items():
            kelvin = [np.asarray(whole[f"{kind}temperature"]) for kind in ("", "reference_")]
            wrong = wrong | ~np.asarray(shift.holds(kelvin[0], kelvin[1], own(whole, prefix)))
        return np.asarray(wrong)

    def _shifts(self) -> dict[str, Shift]:
        """Every dependence of a viscosity on temperature by its dotted name."""
        return {
            f"{prefix}.{name}": inner
            for prefix, part in self.parts().items()
            for name, inner in part.parts().items()
            if isinstance(inner, Shift)
        }

    def reachable(self, values: Mapping[str, ArrayLike], l1: ArrayLike, l2: ArrayLike) -> BoolArray:
        """Where stretches lie within the limits of the material.

        Parameters
        ----------
        values
            Arrays by dotted name; fields that are missing have the actuator's own value.
        l1, l2
            Positive in-plane stretches, arrays that broadcast with those.
        """
        first, second = np.asarray(l1, dtype=np.float64), np.asarray(l2, dtype=np.float64)
        given = {k: np.asarray(v) for k, v in own(values, "material").items()}
        p = self.material.parameters() | given
        with np.errstate(all="ignore"):
            room = self.material.room(first, second, 1.0 / (first * second), p, np)
            inside = [np.asarray(part > 0.0) for part in room]
        everywhere = np.ones(np.broadcast_shapes(first.shape, second.shape), dtype=np.bool_)
        return np.asarray(reduce(np.logical_and, inside, everywhere))

    def warn_if_implausible(self, values: Mapping[str, ArrayLike], *, stacklevel: int = 2) -> None:
        """Warn of allowed values, single or in a batch, that look like a mistake."""
        for name in ("temperature", "reference_temperature"):
            if np.any(np.asarray(values.get(name, COLD)) < COLD):
                warnings.warn(
                    f"`{name}` is below {COLD:g} K somewhere. Temperatures are in kelvin; "
                    "for t degrees Celsius pass t + 273.15.",
                    InputWarning,
                    stacklevel=stacklevel,
                )
        rated = np.asarray(values.get("magnet.temperature_coefficient", 0.0)) == 0.0
        if np.any(~rated & (np.asarray(values.get("temperature", 0.0)) > WARM)):
            warnings.warn(
                f"`temperature` is above {WARM:g} K (80 degrees Celsius) somewhere, the rating "
                "of plain NdFeB magnets: a constant temperature coefficient is a guess there.",
                InputWarning,
                stacklevel=stacklevel,
            )

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed; unknown fields raise `InputError`."""
        _checks.require_known(changes, [f.name for f in fields(self)], "Actuator")
        return replace_fields(self, **changes)

    def with_parameter(self, name: str, value: float) -> Self:
        """A copy with one numeric field, given by its dotted name, changed."""
        _checks.require_known([name], self.parameters(), "the actuator and its parts")
        for whole, values in self._own().items():
            if name in values:
                numbers = tuple({**values, name: value}.values())
                return self.replace(**{whole: numbers[0] if whole == name else numbers})
        parts = {
            prefix: part.replace(**{name.removeprefix(f"{prefix}."): value})
            if name.startswith(f"{prefix}.")
            else part
            for prefix, part in self.parts().items()
        }
        elements = tuple(part for part in parts.values() if isinstance(part, Dissipation))
        others = {name: part for name, part in parts.items() if name in _SINGLE}
        return self.replace(dissipation=elements, **others)

    @classmethod
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
        shear_modulus, remanence
            mu and B_r at the reference temperature.
        density, half_length, half_thickness
            rho, L and H of the undeformed block 2 L x 2 L x 2 H.
        half_width
            L2 of a block 2 L x 2 L2 x 2 H, whose motion has two coordinates.
        force
            P on each edge; the nominal stress is P/(4 L H).  A pair (P1, P2) makes two
            coordinates; P1 pulls along the edge 2 L, with the stress P1/(4 L2 H).
        temperature, reference_temperature
            T and T0.
        own_field
            Whether the magnet's field in itself acts too: the magnet then gets the
            `demagnetisation` that the remanence and the shear modulus imply.
        **parts
            `material`, `dissipation`, `heat`, `magnet`.

        Examples
        --------
        >>> film = Actuator.from_si(
        ...     shear_modulus="100 kPa",
        ...     density="2000 kg/m^3",
        ...     half_length="5 mm",
        ...     half_thickness="0.5 mm",
        ...     remanence="143 mT",
        ... )
        >>> round(film.c, 12), round(film.load("140 mT"), 4)
        (0.01, 0.1593)
        """
        _checks.require_known(parts, PARTS, "Actuator.from_si")
        scales = Scales.of(
            shear_modulus=shear_modulus,
            density=density,
            half_length=half_length,
            remanence=remanence,
        )
        thickness = _units.positive("half_thickness", half_thickness, "m")
        edges = None
        if half_width is not None:
            edges = (1.0, _units.positive("half_width", half_width, "m") / scales.half_length)
        if own_field:
            magnet = parts.get("magnet", Magnet())
            _checks.require_instance("magnet", magnet, Magnet, "Magnet()")
            parts["magnet"] = magnet.replace(demagnetisation=scales.demagnetisation)
        return cls(
            c=(thickness / scales.half_length) ** 2,
            temperature=_units.single("temperature", temperature, "K"),
            reference_temperature=_units.single(
                "reference_temperature", reference_temperature, "K"
            ),
            prestress=_nominal(force, scales, thickness, edges),
            edges=edges,
            scales=scales,
            **parts,
        )

    def stress(self, stress: Quantity) -> float | FloatArray:
        """Stress or modulus over mu, ``"50 kPa"``."""
        return _units.magnitude("stress", stress, "Pa") / self._known_scales().shear_modulus

    def viscosity(self, viscosity: Quantity) -> float | FloatArray:
        """Dimensionless eta of a viscosity, ``"20 Pa s"``."""
        scales = self._known_scales()
        unit = scales.shear_modulus * scales.time
        return _units.magnitude("viscosity", viscosity, "Pa s") / unit

    def coupling(self, heat_capacity: Quantity) -> float | FloatArray:
        """The coupling number mu/(rho c_p T0) of a heat capacity, ``"1.9 kJ/(kg K)"``."""
        scales = self._known_scales()
        capacity = _units.magnitude("heat_capacity", heat_capacity, "J/(kg K)")
        return scales.shear_modulus / (scales.density * self.reference_temperature * capacity)

    def load(self, flux_density: Quantity) -> float | FloatArray:
        """Magnetic load m = B_r B/(mu mu0) of a flux density, ``"140 mT"``."""
        scales = self._known_scales()
        return _units.magnitude("flux_density", flux_density, "T") / scales.flux_density

    def frequency(self, frequency: Quantity) -> float | FloatArray:
        """Dimensionless omega of a frequency, ``"50 Hz"`` or ``"314 rad/s"``."""
        return _units.angular_frequency("frequency", frequency) * self._known_scales().time

    def time(self, time: Quantity) -> float | FloatArray:
        """Dimensionless tau of a time, ``"1 s"``."""
        return _units.magnitude("time", time, "s") / self._known_scales().time

    def _known_scales(self) -> Scales:
        if self.scales is None:
            raise InputError(
                "actuator",
                must="be made by Actuator.from_si to convert units",
                got="a dimensionless actuator",
                why="Dimensionless numbers alone do not fix a length or a stress.",
                fix="Build it with Actuator.from_si.",
            )
        return self.scales


def _require_shifts(actuator: Actuator) -> None:
    """Raise where a law of temperature does not hold at the actuator's temperature."""
    if actuator.invalid({}):
        raise InputError(
            "temperature",
            must="be above T0 - c2 of every WLF shift",
            got=actuator.temperature,
            why="The law has a pole there: the element is frozen.",
            fix="Raise the temperature, pass a larger c2, or use Arrhenius.",
        )


def _nominal(
    force: Quantity | Sequence[Quantity],
    scales: Scales,
    thickness: float,
    edges: tuple[float, float] | None,
) -> float | tuple[float, float]:
    """Nominal stress over mu of forces on the faces 2 L x 2 H, or of each on its own face."""
    unit = 4.0 * scales.half_length * thickness * scales.shear_modulus
    if edges is None and not _is_pair(force):
        return _units.single("force", force, "N") / unit
    one, two = _numbered("force", force).values()
    across, along = edges or (1.0, 1.0)
    return (
        _units.single("force", one, "N") / (unit * along),
        _units.single("force", two, "N") / (unit * across),
    )


def _is_pair(value: object) -> bool:
    """Whether a field was given as several numbers; text is refused as a number."""
    return isinstance(value, Sequence | np.ndarray) and not isinstance(value, str)


def _numbered(name: str, value: Any) -> dict[str, Any]:
    """The two numbers of a pair under their own names; a single one stands for both."""
    pair = tuple(value) if _is_pair(value) and np.ndim(value) == 1 else (value, value)
    if len(pair) != 2:
        raise InputError(
            name,
            must="be one number or a pair of them",
            got=repr(value)[:80],
            why="There are two in-plane directions.",
            fix=f"Pass {name}=(1.0, 0.5).",
        )
    return {f"{name}_{i}": number for i, number in enumerate(pair, start=1)}


def _elements(dissipation: object) -> tuple[Dissipation, ...]:
    """One element or several, as a tuple."""
    if isinstance(dissipation, Dissipation):
        return (dissipation,)
    items = tuple(dissipation) if isinstance(dissipation, Sequence) else (dissipation,)
    for i, item in enumerate(items):
        _checks.require_instance(f"dissipation.{i}", item, Dissipation, "Rayleigh(0.1)")
    return items
