"""What all parts of a model have in common: named numbers with rules, and options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from dataclasses import replace as replace_fields
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np

from remanent import _checks
from remanent._calls import ExplainedConstruction
from remanent._checks import Rule
from remanent._typing import ArrayLike, BoolArray
from remanent.models.shown import ShownInNotebook

#: A nested tuple of names, numbers of terms and options: what identifies equations.
EquationStructure = tuple[Any, ...]


@dataclass(frozen=True)
class Part(ShownInNotebook, metaclass=ExplainedConstruction):
    """A small immutable value: a material, a magnet, a drive ...

    A subclass is a frozen dataclass.  Its numeric fields, those that ``over`` and
    continuation may vary, are the keys of :attr:`rules`, the entries of
    :attr:`table_rules`, the names in :attr:`mapping_rules`, and the numeric fields of the parts in
    :attr:`nested_part_types`.  Fields that decide the form of the equations are named in
    :attr:`structural_fields`.
    """

    #: The rule of each numeric field.  One that is None, where that is
    #: the default, is left out of the equations.
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({})
    #: The rule of the entries of each table of numbers, whose entries are numeric fields
    #: too, ``name.0``, ``name.1`` ...; the form of the equations depends on their count.
    table_rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({})
    #: The rule of the values of each mapping of names to numbers, which are numeric fields
    #: under these names; it is kept as a tuple of pairs.
    mapping_rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({})
    #: Names of the fields on which the form of the equations depends.
    structural_fields: ClassVar[tuple[str, ...]] = ()
    #: The kind of each field that holds another part, or None; see :meth:`parts`.
    nested_part_types: ClassVar[Mapping[str, type[Part]]] = MappingProxyType({})

    def __post_init__(self) -> None:
        for name, rule in self._single_number_rules().items():
            number = _checks.require_real(name, getattr(self, name), rule)
            object.__setattr__(self, name, number)
        for name, rule in self.table_rules.items():
            numbers = _checks.require_numbers(
                name, getattr(self, name), what="one for each term", why="They enter the equations."
            ).tolist()
            for i, number in enumerate(numbers):
                _checks.require_real(f"{name}.{i}", number, rule)
            object.__setattr__(self, name, tuple(numbers))
        for name, rule in self.mapping_rules.items():
            pairs = _checks.require_named_numbers(name, getattr(self, name), rule)
            object.__setattr__(self, name, pairs)
        for name, value in self.checked_fields().items():
            object.__setattr__(self, name, value)
        for name, kind in self.nested_part_types.items():
            if getattr(self, name) is not None:
                _checks.require_instance(name, getattr(self, name), kind, f"a {kind.__name__}")
        for name, (value, rule) in self._derived_numbers_for({}).items():
            _checks.require_real(name, float(value), rule)

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part.

        A class whose fields have no defaults gives them here; see ``tests/contracts``.
        """
        return cls()

    def checked_fields(self) -> Mapping[str, Any]:
        """Normalised values of fields that are not plain numbers; raises `InputError`."""
        return {}

    def parts(self) -> dict[str, Part]:
        """The parts within this one, by the names of their fields."""
        values = {name: getattr(self, name) for name in self.nested_part_types}
        return {name: part for name, part in values.items() if part is not None}

    def derived_numbers(self, p: Mapping[str, Any]) -> Mapping[str, tuple[Any, Rule]]:
        """Numbers that follow from several numeric fields, by name, each with its rule.

        `p` holds values of all numeric fields, single or in arrays.
        """
        return {}

    def parameter_values(self) -> dict[str, float]:
        """Value of every numeric field, by name, in the order of definition."""
        entries = {
            f"{name}.{i}": number
            for name in self.table_rules
            for i, number in enumerate(getattr(self, name))
        }
        inner = {
            f"{name}.{field}": value
            for name, part in self.parts().items()
            for field, value in part.parameter_values().items()
        }
        single = {name: float(getattr(self, name)) for name in self._single_number_rules()}
        named = {k: v for pairs in self._mapping_pairs().values() for k, v in pairs}
        return single | entries | named | inner

    def parameter_rules(self) -> dict[str, Rule]:
        """Rule of every numeric field, by name."""
        entries = {
            f"{name}.{i}": rule
            for name, rule in self.table_rules.items()
            for i in range(len(getattr(self, name)))
        }
        named = {
            k: self.mapping_rules[name]
            for name, pairs in self._mapping_pairs().items()
            for k, _ in pairs
        }
        inner = {
            f"{name}.{field}": rule
            for name, part in self.parts().items()
            for field, rule in part.parameter_rules().items()
        }
        return self._single_number_rules() | entries | named | inner

    def equation_structure(self) -> EquationStructure:
        """What identifies the equations of this part.

        Its class, choices, lengths of tables, names in mappings, fields that are left out.
        """
        kind = type(self)
        chosen = (getattr(self, name) for name in self.structural_fields)
        lengths = (len(getattr(self, name)) for name in self.table_rules)
        names = (tuple(k for k, _ in pairs) for pairs in self._mapping_pairs().values())
        missing = filter(self._is_left_out_of_equations, self.rules)
        inner = ((name, part.equation_structure()) for name, part in self.parts().items())
        form = (*chosen, *lengths, *names, *missing, *inner)
        return (f"{kind.__module__}:{kind.__qualname__}", *form)

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed; unknown fields raise `InputError`."""
        entries = [name for name in self.parameter_rules() if name not in self.rules]
        field_names = [f.name for f in fields(self) if f.init]
        _checks.require_known_names(changes, [*field_names, *entries], type(self).__name__)
        values = {name: value for name, value in changes.items() if name not in entries}
        # Several entries of one table change together, so each starts from what is in `values`.
        for name in changes.keys() - values.keys():
            number = _checks.require_real(name, changes[name], self.parameter_rules()[name])
            owner, new = self._owner_with_entry_changed(name, number, values)
            values[owner] = new
        return replace_fields(self, **values)

    def where_invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a batch of values of the numeric fields breaks a rule."""
        broken = _checks.where_rule_broken(self.parameter_rules(), values)
        for value, rule in self._derived_numbers_for(values).values():
            broken = broken | ~rule.is_satisfied_by(value)
        return np.asarray(broken)

    def _derived_numbers_for(
        self, values: Mapping[str, ArrayLike]
    ) -> Mapping[str, tuple[Any, Rule]]:
        """The derived numbers, of `values` where these have a field, else of its own value."""
        p = {
            k: np.asarray(values.get(k, v), dtype=np.float64)
            for k, v in self.parameter_values().items()
        }
        with np.errstate(all="ignore"):
            return self.derived_numbers(p)

    def _single_number_rules(self) -> dict[str, Rule]:
        return {
            name: rule
            for name, rule in self.rules.items()
            if not self._is_left_out_of_equations(name)
        }

    def _is_left_out_of_equations(self, name: str) -> bool:
        return getattr(self, name) is None and getattr(type(self), name, 0) is None

    def _mapping_pairs(self) -> dict[str, tuple[tuple[str, float], ...]]:
        return {name: getattr(self, name) for name in self.mapping_rules}

    def _owner_with_entry_changed(
        self, name: str, number: float, values: Mapping[str, Any]
    ) -> tuple[str, Any]:
        """The table, mapping or part that holds an entry, and its value with it changed."""
        for owner, pairs in self._mapping_pairs().items():
            if name in dict(pairs):
                changed = {**dict(values.get(owner, pairs)), name: number}
                return owner, tuple(changed.items())
        table, _, i = name.partition(".")
        value = values.get(table, getattr(self, table))
        if table in self.nested_part_types:
            return table, value.replace(**{i: number})
        row = list(value)
        return table, (*row[: int(i)], number, *row[int(i) + 1 :])


def part_parameters(prefix: str, p: Mapping[str, Any]) -> dict[str, Any]:
    """Numeric fields of the part called `prefix`, under the names that they have there.

    Examples
    --------
    >>> part_parameters("material", {"c": 1.0, "material.jm": 50.0})
    {'jm': 50.0}
    """
    start = f"{prefix}."
    return {name.removeprefix(start): v for name, v in p.items() if name.startswith(start)}
