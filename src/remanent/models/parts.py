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
    continuation may vary, are the keys of :attr:`rules`.  Fields that decide the form
    of the equations are named in :attr:`choices`.
    """

    #: The rule of each numeric field.
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({})
    #: Names of the fields on which the form of the equations depends.
    choices: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        for name, rule in self.rules.items():
            number = _checks.require_real(name, getattr(self, name), rule)
            object.__setattr__(self, name, number)
        for name, value in self.checked_options().items():
            object.__setattr__(self, name, value)

    def checked_options(self) -> Mapping[str, Any]:
        """Normalised values of fields that are not plain numbers; raises `InputError`."""
        return {}

    def parameters(self) -> dict[str, float]:
        """Value of every numeric field, by name, in the order of definition."""
        return {name: float(getattr(self, name)) for name in self.rules}

    def structure(self) -> Structure:
        """What identifies the equations of this part: its class and its choices."""
        kind = type(self)
        chosen = (getattr(self, name) for name in self.choices)
        return (f"{kind.__module__}:{kind.__qualname__}", *chosen)

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed; unknown fields raise `InputError`."""
        known = [f.name for f in fields(self) if f.init]
        _checks.require_known(changes, known, type(self).__name__)
        return replace_fields(self, **changes)

    def invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a batch of values of the numeric fields breaks a rule."""
        return _checks.broken(self.rules, values)
