"""Numbers of a study file, and quantities with units where the sizes of the actuator are given."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from remanent import _checks
from remanent._checks import Rule
from remanent._errors import InputError
from remanent.models.scaling import Scales
from remanent.results.quantities import dimensionless_numbers
from remanent.results.schema import QuantityKind, describe, is_described
from remanent.studies.sweep.faults import Fault, FaultsError, fault_of, read_each, shown

#: A number in quotes.
_PLAIN_NUMBER: Final = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*")
#: Kinds of quantities that have a unit without the sizes of an actuator.
_KINDS_WITHOUT_SIZES: Final = frozenset({QuantityKind.NONE, QuantityKind.TEMPERATURE})
#: The rule of numbers that have no other.
FINITE_RULE: Final[Rule] = _checks.finite_rule("It enters the equations of motion.")


@dataclass(frozen=True)
class Sizes:
    """The physical sizes by which quantities of a file become numbers.

    Attributes
    ----------
    scales : Scales or None
        None where the file has no [actuator.si].
    known : bool
        False where that table has faults of its own, so that no unit can be judged.
    """

    scales: Scales | None = None
    known: bool = True


def sizes_of(document: Mapping[str, Any]) -> Sizes:
    """The sizes in [actuator.si]; whether the table is sound is told where it is read."""
    actuator = document.get("actuator")
    if not isinstance(actuator, dict) or "si" not in actuator:
        return Sizes()
    names = ("shear_modulus", "density", "half_length", "remanence")
    try:
        given = {name: actuator["si"].get(name) for name in names}
        return Sizes(Scales.from_quantities(**given))
    except (AttributeError, InputError):
        return Sizes(known=False)


def number(value: object, name: str, sizes: Sizes, rule: Rule = FINITE_RULE) -> float:
    """One number of a file.

    Parameters
    ----------
    value : object
        A number, or a quantity with its unit as text.
    name : str
        The variable of results, or the numeric field, whose value it is.
    sizes : Sizes
    rule : Rule
        Which it must satisfy.

    Raises
    ------
    FaultsError
        No number, a unit of another dimension, a unit without sizes, a broken rule.
    """
    if isinstance(value, str):
        if not sizes.known:
            raise FaultsError([])  # the sizes have faults, and nothing is known of this
        value = _without_unit(value, name, sizes.scales)
    try:
        return _checks.require_real(name, value, rule)
    except InputError as error:
        said = fault_of(error, {})
        fix = "Write a number." if error.must == "be one real number" else said.fix
        raise FaultsError([Fault((), said.must, shown(value), said.why, fix)]) from None


def numbers(values: object, name: str, sizes: Sizes, rule: Rule = FINITE_RULE) -> list[float]:
    """A list of numbers of a file; the faults of all of its entries are told together."""
    if not isinstance(values, list) or not values:
        raise FaultsError([
            Fault((), "be a list of at least one number", shown(values), "It holds many values.",
                  "Write for example [0.5, 1.0].")
        ])  # fmt: skip
    entries = dict(enumerate(values))
    return [*read_each(entries, lambda _, value: number(value, name, sizes, rule)).values()]


def _without_unit(text: str, name: str, scales: Scales | None) -> float:
    kind = describe(name).kind if is_described(name) else QuantityKind.NONE
    if _PLAIN_NUMBER.fullmatch(text):
        raise FaultsError([
            Fault((), "be a number, or text of a number and its unit", shown(text),
                  "Numbers stand without quotes.", f"Write {text.strip()} without them.")
        ])  # fmt: skip
    if scales is None and kind not in _KINDS_WITHOUT_SIZES:
        raise FaultsError([
            Fault((), "be a number without a unit", shown(text),
                  "There are no sizes by which units become the numbers in the equations.",
                  "Give the sizes of the actuator in [actuator.si], or write the number.")
        ])  # fmt: skip
    try:
        return float(dimensionless_numbers(name, text, kind, scales))
    except InputError as error:
        said = fault_of(error, {})
        raise FaultsError([Fault((), said.must, shown(text), said.why, said.fix)]) from None
