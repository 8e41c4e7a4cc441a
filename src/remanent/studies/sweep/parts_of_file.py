"""Actuators, systems of one's own, drives and parts from the tables of a study file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import cache, partial
from typing import Annotated, Any, Final

from pydantic import AfterValidator, ValidationInfo, create_model

import remanent
from remanent import _checks
from remanent._errors import InputError
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.base import Material
from remanent.models.own_systems.first_order_system import FirstOrderSystem
from remanent.models.own_systems.lagrangian_system import LagrangianSystem
from remanent.models.parts import Part
from remanent.models.system import System
from remanent.studies.sweep.faults import Fault, FaultsError, fault_of, meant, read_each, shown
from remanent.studies.sweep.numbers_with_units import Sizes, number, numbers
from remanent.studies.sweep.si_sizes import actuator_from_si, read_sizes
from remanent.studies.sweep.tables import Table, not_a_table_fault, read_table

#: The entry of a table that says which class the value has.
KIND: Final = "kind"
#: Fields of an actuator that hold one part each.
_SINGLE_PARTS: Final[Mapping[str, type]] = {"material": Material, "heat": Heat, "magnet": Magnet}
#: Fields of an actuator that a file gives in another way: by [actuator.si] and by [over].
_NOT_IN_FILES: Final = frozenset({"scales", "physical_sizes"})
#: Fields that are lists of numbers without a rule of their own.
_LISTS: Final = frozenset({"times", "loads", "multiples"})


def actuator_from_table(content: object, sizes: Sizes) -> Actuator:
    """The actuator of [actuator], with the sizes of [actuator.si] where these are given.

    Raises
    ------
    FaultsError
    """
    values = read_table(_actuator_table(), content, "[actuator]", sizes).given
    assert isinstance(content, dict)
    si = values.pop("si", None)
    try:
        return Actuator(**values) if si is None else actuator_from_si(si, values)
    except InputError as error:
        raise FaultsError([fault_of(error, content, "actuator")]) from None


def system_from_table(content: object) -> System:
    """The system of one's own of [system].

    Raises
    ------
    FaultsError
    """
    kinds: dict[str, type] = {
        cls.__name__: cls for cls in (LagrangianSystem, FirstOrderSystem)
    }  # fmt: skip
    system: System = _from_kind(content, kinds, "[system]", "", Sizes())
    return system


def drive_from_table(content: object, sizes: Sizes) -> Drive:
    """The drive of [drive]; a table without `kind` holds a drive for each of several loads.

    Raises
    ------
    FaultsError
    """
    kinds = {name: cls for name, cls in public_kinds(Drive).items() if cls is not Loads}
    several = isinstance(content, dict) and KIND not in content and bool(content)
    if not several or not all(isinstance(one, dict) for one in content.values()):  # type: ignore[attr-defined]
        drive: Drive = _from_kind(content, kinds, "[drive]", "", sizes)
        return drive
    assert isinstance(content, dict)
    drives = read_each(
        content, lambda load, one: _from_kind(one, kinds, f"[drive.{load}]", "", sizes)
    )
    loads: Drive = _made(Loads, {"drives": drives}, content, "drive")
    return loads


@cache
def public_kinds(kind: type) -> dict[str, type]:
    """The public classes of this kind of part, by name."""
    capitalised = (name for name in sorted(remanent.__all__) if name[0].isupper())
    classes = ((name, getattr(remanent, name)) for name in capitalised)
    return {n: cls for n, cls in classes if isinstance(cls, type) and issubclass(cls, kind)}


def _from_kind(
    content: object, kinds: Mapping[str, type], title: str, group: str, sizes: Sizes
) -> Any:
    """The value of a table that names its class.

    Parameters
    ----------
    content : object
        What stands in the file.
    kinds : mapping of name to type
    title : str
        What messages call the table.
    group : str
        What stands before the names of its numeric fields, as in ``dissipation.0.``.
    sizes : Sizes
    """
    if not isinstance(content, dict):
        raise FaultsError([not_a_table_fault(content)])
    cls = _class_of(content.get(KIND), kinds)
    values = read_table(_part_table(cls, group), content, title, sizes).given
    values.pop(KIND)
    return _made(cls, values, content, title.strip("[]"))


def _class_of(name: object, kinds: Mapping[str, type]) -> type:
    if isinstance(name, str) and name in kinds:
        return kinds[name]
    fix = meant(name, list(kinds)) or f"Write for example kind = {next(iter(kinds))!r}."
    raise FaultsError([
        Fault((KIND,), f"be one of {', '.join(kinds)}", "nothing" if name is None else shown(name),
              "It says what the other keys belong to.", fix.strip())
    ])  # fmt: skip


def _made(cls: Any, values: Mapping[str, Any], content: Mapping[str, Any], title: str) -> Any:
    try:
        return cls(**values)
    except InputError as error:
        raise FaultsError([fault_of(error, content, title)]) from None


# The keys of each table ---------------------------------------------------------------------


@cache
def _part_table(cls: Any, group: str) -> type[Table]:
    """The keys of a part: the fields of its class."""
    definitions: dict[str, Any] = {KIND: (str, ...)}
    for field in fields(cls):
        if field.init:
            required = field.default is MISSING and field.default_factory is MISSING
            reader = partial(_part_value, cls, field.name, group)
            definitions[field.name] = (
                Annotated[Any, AfterValidator(_checked(reader))], ... if required else None,
            )  # fmt: skip
    return create_model(cls.__name__, __base__=Table, **definitions)


@cache
def _actuator_table() -> type[Table]:
    """The keys of [actuator]."""
    definitions: dict[str, Any] = {
        field.name: (
            Annotated[Any, AfterValidator(_checked(partial(_actuator_value, field.name)))],
            None,
        )
        for field in fields(Actuator)
        if field.name not in _NOT_IN_FILES
    }
    definitions["si"] = (Annotated[Any, AfterValidator(read_sizes)], None)
    return create_model("Actuator", __base__=Table, **definitions)


def _checked(reader: Callable[[Any, Sizes], Any]) -> Callable[[Any, ValidationInfo], Any]:
    """A reader of one value as pydantic calls it."""

    def check(value: Any, info: ValidationInfo) -> Any:
        return reader(value, info.context or Sizes())

    return check


def _part_value(cls: Any, name: str, group: str, value: Any, sizes: Sizes) -> Any:
    """The value of one field of a part."""
    if not issubclass(cls, Part):
        return _own_system_value(name, value)
    if name in cls.rules:
        return number(value, f"{group}{name}", sizes, cls.rules[name])
    if name in cls.table_rules or name in _LISTS:
        rule = cls.table_rules.get(name, _checks.finite_rule("It is one of many values."))
        return numbers(value, f"{group}{name}", sizes, rule)
    if name in cls.mapping_rules:
        return _named_numbers(value)
    if name in cls.nested_part_types:
        kinds = public_kinds(cls.nested_part_types[name])
        return _from_kind(value, kinds, name, f"{group}{name}.", sizes)
    return value


def _own_system_value(name: str, value: Any) -> Any:
    """The value of a field of a system of one's own, whose constructor checks the others."""
    return _named_numbers(value) if name in ("parameters", "rest") else value


def _named_numbers(value: object) -> dict[str, float]:
    if not isinstance(value, dict):
        raise FaultsError([not_a_table_fault(value)])
    return read_each(value, lambda _, entry: number(entry, "", Sizes()))


def _actuator_value(name: str, value: Any, sizes: Sizes) -> Any:
    """The value of one key of [actuator]."""
    if name in _SINGLE_PARTS:
        return _from_kind(value, public_kinds(_SINGLE_PARTS[name]), name, f"{name}.", sizes)
    if name == "dissipation":
        return _elements(value, sizes)
    rule = Actuator.rules[name]
    if isinstance(value, list) and name in Actuator.pairable_fields:
        return tuple(numbers(value, name, sizes, rule))
    return number(value, name, sizes, rule)


def _elements(value: object, sizes: Sizes) -> tuple[Any, ...]:
    """Dissipative elements: a list of tables, or one table."""
    kinds = public_kinds(Dissipation)
    if isinstance(value, dict):
        return (_from_kind(value, kinds, "dissipation", "dissipation.0.", sizes),)
    if not isinstance(value, list):
        raise FaultsError([
            Fault((), "be a list of tables, or one table", shown(value),
                  "Each is a dissipative element.",
                  'Write for example [{ kind = "Rayleigh", eta = 0.05 }].')
        ])  # fmt: skip
    elements = read_each(
        dict(enumerate(value)),
        lambda k, one: _from_kind(one, kinds, f"dissipation.{k}", f"dissipation.{k}.", sizes),
    )
    return tuple(elements.values())
