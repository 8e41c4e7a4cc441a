"""What all parts of a model have in common: named numbers with rules, and options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from dataclasses import replace as replace_fields
from types import MappingProxyType
from typing import Any, ClassVar, Self

from remanent import _checks
from remanent._checks import Rule
from remanent._typing import ArrayLike, BoolArray

#: A nested tuple of names, numbers of terms and options: what identifies equations.
Structure = tuple[Any, ...]


@dataclass(frozen=True)
class Part:
    """A small immutable value: a material, a magnet, a drive ...

    A subclass is a frozen dataclass.  Its numeric fields, those that ``over`` and
    continuation may vary, are the keys of :attr:`rules`, the entries of
    :attr:`tables`, and the numeric fields of the parts in :attr:`nested`.  Fields that
    decide the form of the equations are named in :attr:`choices`.
    """

    #: The rule of each numeric field.
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({})
    #: The rule of the entries of each table of numbers, whose entries are numeric fields
    #: too, ``name.0``, ``name.1`` ...; the form of the equations depends on their count.
    tables: ClassVar[Mapping[str, Rule]] = MappingProxyType({})
    #: Names of the fields on which the form of the equations depends.
    choices: ClassVar[tuple[str, ...]] = ()
    #: The kind of each field that holds another part, or None; see :meth:`parts`.
    nested: ClassVar[Mapping[str, type[Part]]] = MappingProxyType({})

    def __post_init__(self) -> None:
        for name, rule in self.rules.items():
            number = _checks.require_real(name, getattr(self, name), rule)
            object.__setattr__(self, name, number)
        for name, rule in self.tables.items():
            numbers = _checks.require_numbers(name, getattr(self, name))
            for i, number in enumerate(numbers):
                _checks.require_real(f"{name}.{i}", number, rule)
            object.__setattr__(self, name, numbers)
        for name, value in self.checked_options().items():
            object.__setattr__(self, name, value)
        for name, kind in self.nested.items():
            if getattr(self, name) is not None:
                _checks.require_instance(name, getattr(self, name), kind, f"a {kind.__name__}")

    def checked_options(self) -> Mapping[str, Any]:
        """Normalised values of fields that are not plain numbers; raises `InputError`."""
        return {}

    def parts(self) -> dict[str, Part]:
        """The parts within this one, by the names of their fields."""
        found = {name: getattr(self, name) for name in self.nested}
        return {name: part for name, part in found.items() if part is not None}

    def parameters(self) -> dict[str, float]:
        """Value of every numeric field, by name, in the order of definition."""
        entries = {
            f"{name}.{i}": number
            for name in self.tables
            for i, number in enumerate(getattr(self, name))
        }
        inner = {
            f"{name}.{field}": value
            for name, part in self.parts().items()
            for field, value in part.parameters().items()
        }
        return {name: float(getattr(self, name)) for name in self.rules} | entries | inner

    def numeric_rules(self) -> dict[str, Rule]:
        """Rule of every numeric field, by name."""
        entries = {
            f"{name}.{i}": rule
            for name, rule in self.tables.items()
            for i in range(len(getattr(self, name)))
        }
        inner = {
            f"{name}.{field}": rule
            for name, part in self.parts().items()
            for field, rule in part.numeric_rules().items()
        }
        return {**self.rules, **entries, **inner}

    def structure(self) -> Structure:
        """What identifies the equations of this part: its class, choices, lengths of tables."""
        kind = type(self)
        chosen = (getattr(self, name) for name in self.choices)
        lengths = (len(getattr(self, name)) for name in self.tables)
        inner = ((name, part.structure()) for name, part in self.parts().items())
        return (f"{kind.__module__}:{kind.__qualname__}", *chosen, *lengths, *inner)

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed; unknown fields raise `InputError`."""
        entries = [name for name in self.numeric_rules() if name not in self.rules]
        known = [f.name for f in fields(self) if f.init]
        _checks.require_known(changes, [*known, *entries], type(self).__name__)
        whole = {name: value for name, value in changes.items() if name not in entries}
        for name in changes.keys() - whole.keys():
            table, _, i = name.partition(".")
            if table in self.nested:
                part = whole.get(table, getattr(self, table))
                whole[table] = part.replace(**{i: changes[name]})
                continue
            number = _checks.require_real(name, changes[name], self.tables[table])
            row = list(whole.get(table, getattr(self, table)))
            whole[table] = [*row[: int(i)], number, *row[int(i) + 1 :]]
        return replace_fields(self, **whole)

    def invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a batch of values of the numeric fields breaks a rule."""
        return _checks.broken(self.numeric_rules(), values)
