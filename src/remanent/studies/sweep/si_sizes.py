"""The sizes of an actuator in SI: the table [actuator.si] of a study file."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial
from typing import Annotated, Any, Final

from pydantic import AfterValidator, Field, StrictBool, create_model

from remanent import _units
from remanent._errors import InputError
from remanent.models.actuator import Actuator
from remanent.studies.sweep.faults import Fault, FaultsError, fault_of, shown
from remanent.studies.sweep.tables import Table, read_table

#: For each size its unit, an example, and its meaning.
_SIZES: Final[Mapping[str, tuple[str, str, str]]] = {
    "shear_modulus": ("Pa", "100 kPa", "It is the modulus at the reference temperature."),
    "density": ("kg/m^3", "2000 kg/m^3", "It is the mass in a volume."),
    "half_length": ("m", "5 mm", "It is half of an edge in the plane."),
    "half_thickness": ("m", "0.5 mm", "It is half of the thickness."),
    "half_width": ("m", "4 mm", "It is half of the other edge in the plane."),
    "remanence": ("T", "143 mT", "It is the residual flux density."),
    "temperature": ("K", "350 K", "It is an absolute temperature."),
    "reference_temperature": ("K", "293 K", "The modulus and the remanence are given at it."),
}
#: Sizes without which there are no others.
_REQUIRED: Final = ("shear_modulus", "density", "half_length", "half_thickness")
#: Keys of [actuator] that say the same as one of [actuator.si].
_SAID_TWICE: Final[Mapping[str, str]] = {
    "prestress": "force",
    "temperature": "temperature",
    "reference_temperature": "reference_temperature",
}
#: Keys of [actuator] that follow from lengths.
_FOLLOWING: Final[Mapping[str, str]] = {
    "c": "half_thickness and half_length",
    "edges": "half_width and half_length",
}


def read_sizes(content: object) -> dict[str, Any]:
    """The arguments of :meth:`remanent.Actuator.from_si` in a table.

    Raises
    ------
    FaultsError
    """
    return read_table(_sizes_table(), content, "[actuator.si]").given


def actuator_from_si(sizes: Mapping[str, Any], others: Mapping[str, Any]) -> Actuator:
    """An actuator by its sizes.

    Parameters
    ----------
    sizes : mapping of name to quantity
        As :func:`read_sizes` gives them.
    others : mapping of name to value
        The other keys of [actuator].

    Raises
    ------
    FaultsError, InputError
        A number is given twice, or the sizes do not go together.
    """
    faults = [_follows_fault(key, source) for key, source in _FOLLOWING.items() if key in others]
    faults += [
        _twice_fault(key, size)
        for key, size in _SAID_TWICE.items()
        if key in others and size in sizes
    ]
    if faults:
        raise FaultsError(faults)
    parts = {name: value for name, value in others.items() if name not in _SAID_TWICE}
    numbers = {name: value for name, value in others.items() if name in _SAID_TWICE}
    temperatures: dict[str, Any] = {
        name: f"{numbers.pop(name)!r} K" for name in [*numbers] if name != "prestress"
    }
    try:
        actuator = Actuator.from_si(**sizes, **temperatures, **parts)
    except InputError as error:
        raise FaultsError([fault_of(error, sizes).below("si")]) from None
    return actuator.replace(**numbers) if numbers else actuator


@cache
def _sizes_table() -> type[Table]:
    """The keys of [actuator.si]."""
    definitions: dict[str, Any] = {
        name: (
            Annotated[Any, AfterValidator(partial(_size, name, unit))],
            Field(
                ... if name in _REQUIRED else None,
                description=meaning,
                examples=[f'{name} = "{example}"'],
            ),
        )
        for name, (unit, example, meaning) in _SIZES.items()
    }
    definitions["force"] = (Annotated[Any, AfterValidator(_force)], None)
    definitions["own_field"] = (
        StrictBool,
        Field(False, description="It switches the magnet's own field on.",
              examples=["own_field = true"]),
    )  # fmt: skip
    return create_model("Sizes", __base__=Table, **definitions)


def _size(name: str, unit: str, value: object) -> object:
    """A size as it stands, if it is a positive quantity of this dimension."""
    _units.positive_magnitude(name, value, unit)
    return value


def _force(value: object) -> object:
    """A force, or a pair of forces."""
    if not isinstance(value, list):
        _units.single_magnitude("force", value, "N")
        return value
    if len(value) != 2:
        raise FaultsError([
            Fault((), "be one force, or a list of two", shown(value), "There are two directions.",
                  'Write for example ["1 N", "2 N"].')
        ])  # fmt: skip
    for entry in value:
        _units.single_magnitude("force", entry, "N")
    return tuple(value)


def _follows_fault(key: str, source: str) -> Fault:
    return Fault(
        (key,), "be left out beside [actuator.si]", "a value",
        f"It follows from {source}.", "Remove it, or remove [actuator.si].",
    )  # fmt: skip


def _twice_fault(key: str, size: str) -> Fault:
    return Fault(
        (key,), f"be left out where [actuator.si] has {size}", "a value",
        "Both say the same.", "Remove one of them.",
    )  # fmt: skip
