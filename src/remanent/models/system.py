"""What verbs know of the system that moves; an actuator is the first of its kind."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, Protocol, Self, runtime_checkable

from remanent._checks import Rule
from remanent._typing import ArrayLike, BoolArray
from remanent.models.parts import EquationStructure
from remanent.models.scaling import Scales
from remanent.models.variable_text import VariableText


@runtime_checkable
class System(Protocol):
    """What every system is to the verbs: numeric fields, equations and their limits.

    State variables with their roles and values at rest, observables and rates are those of
    its field, see :func:`remanent.codegen.field.vector_field_for`.  A class that has these members
    is a system; its equations are found by :mod:`remanent.derivation.derive`.
    """

    @property
    def load_names(self) -> tuple[str, ...]:
        """Names of the loads that a drive has to give."""
        ...

    @property
    def scales(self) -> Scales | None:
        """The physical sizes behind the dimensionless numbers, where there are any."""
        ...

    @property
    def conservative(self) -> bool:
        """Whether there is nothing in the model by which energy could be lost."""
        ...

    @property
    def is_time_reversible(self) -> bool:
        """Whether reversed rates retrace a motion, under a load that is even in time."""
        ...

    def where_dissipative(self, values: Mapping[str, ArrayLike] | None = None) -> BoolArray:
        """Whether motion loses energy.

        Parameters
        ----------
        values : mapping of name to array, optional
            Numeric fields of a batch; those that are missing have the system's own value.

        Returns
        -------
        array of bool
            In the shape to which `values` broadcast.
        """
        ...

    def parameter_values(self) -> dict[str, float]:
        """Value of every numeric field under its dotted name."""
        ...

    def parameter_rules(self) -> dict[str, Rule]:
        """Rule of every numeric field under its dotted name."""
        ...

    def equation_structure(self) -> EquationStructure:
        """What identifies the equations of motion: classes and choices, no numbers.

        The first entry is the class of the system, ``"module:name"``.
        """
        ...

    def where_invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a batch of values of numeric fields breaks a rule."""
        ...

    def where_admissible(
        self, values: Mapping[str, ArrayLike], *coordinates: ArrayLike
    ) -> BoolArray:
        """Where the energies exist.

        Parameters
        ----------
        values : mapping of name to array
            Numeric fields; those that are missing have the system's own value.
        *coordinates : array
            One array for each coordinate, in the order of the field.
        """
        ...

    def describe_coordinate_limits(self) -> str:
        """What limits the admissible coordinates, as a noun in a message."""
        ...

    def needs_load_rate(
        self, values: Mapping[str, ArrayLike], varied: Collection[str] = ()
    ) -> bool:
        """Whether the rates of the loads enter the equations of motion.

        Parameters
        ----------
        values : mapping of name to array
            Numeric fields; those that are missing have the system's own value.
        varied
            Names of numeric fields whose values are not known yet.
        """
        ...

    def warn_if_implausible(self, values: Mapping[str, ArrayLike]) -> None:
        """Warn of allowed values, single or in a batch, that look like a mistake."""
        ...

    def variable_texts(self) -> Mapping[str, VariableText]:
        """Unit, meaning and symbol of variables that are its own, by name; none of an actuator."""
        ...

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed; unknown fields raise `InputError`."""
        ...

    def with_parameter(self, name: str, value: float) -> Self:
        """A copy with one numeric field, given by its dotted name, changed."""
        ...
