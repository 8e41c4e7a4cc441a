"""The value that both columns share: a vector field as straight-line code.

The symbolic column writes a :class:`Field`; the numeric column compiles or
interprets it.  A field is plain data (names, floats, integers), so it can be
stored, compared and fingerprinted without SymPy and without running any code
that a file might bring.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cached_property
from operator import add, mul, neg, sub, truediv
from types import MappingProxyType
from typing import Any

import numpy as np

#: Binary operations, with the Python operator each stands for.
BINARY_OPERATOR_OF_OPERATION: Mapping[str, Callable[[Any, Any], Any]] = MappingProxyType(
    {
        "add": add,
        "sub": sub,
        "mul": mul,
        "div": truediv,
    }
)
#: Unary operations: ``neg`` and functions looked up by name on the `functions` argument.
UNARY_OPERATIONS = frozenset({"neg", "sqrt", "exp", "log", "sin", "cos", "atan"})


@dataclass(frozen=True)
class Program:
    """Straight-line code over real numbers, each value assigned once.

    Slots are numbered: first the inputs, then the constants, then one slot for
    the result of each instruction.  An instruction is ``(operation, slot)`` or
    ``(operation, slot, slot)`` and may use earlier slots only.
    """

    input_names: tuple[str, ...]
    constants: tuple[float, ...]
    instructions: tuple[tuple[str, int] | tuple[str, int, int], ...]
    output_slots: tuple[int, ...]

    def __post_init__(self) -> None:
        first = len(self.input_names) + len(self.constants)
        for position, (operation, *operands) in enumerate(self.instructions):
            arity = (
                2
                if operation in BINARY_OPERATOR_OF_OPERATION
                else 1
                if operation in UNARY_OPERATIONS
                else 0
            )
            if len(operands) != arity or not all(0 <= k < first + position for k in operands):
                raise ValueError(
                    f"malformed instruction {position}: {self.instructions[position]!r}"
                )
        if not all(0 <= k < first + len(self.instructions) for k in self.output_slots):
            raise ValueError("an output names a slot that does not exist")

    def __call__(
        self,
        values: Sequence[Any],
        *,
        functions: Any,
        constant: Callable[[float], Any] = lambda x: x,
        divide: Callable[[Any, Any], Any] = truediv,
    ) -> list[Any]:
        """Run the program on numbers of any kind.

        Parameters
        ----------
        values
            One value per input: NumPy arrays, mpmath numbers, lanes of a kernel.
        functions
            Where ``sqrt``, ``exp``, ``log``, ``sin``, ``cos``, ``atan`` of such numbers
            are found as attributes, for example the module ``numpy`` or ``mpmath``.
        constant
            Turns a float into such a number.
        divide
            How a quotient of two such numbers is formed.

        Returns
        -------
        list
            One value per output.
        """
        if len(values) != len(self.input_names):
            raise ValueError(f"expected {len(self.input_names)} values, got {len(values)}")
        operators: dict[str, Callable[..., Any]]
        operators = {**BINARY_OPERATOR_OF_OPERATION, "div": divide, "neg": neg}
        operators |= {name: getattr(functions, name) for name in self._function_names}
        slots = [*values, *map(constant, self.constants)]
        # Where the equations lose their meaning, numbers are infinite or NaN, which callers see.
        with np.errstate(all="ignore"):
            for instruction in self.instructions:
                if len(instruction) == 3:
                    operation, first, second = instruction
                    slots.append(operators[operation](slots[first], slots[second]))
                else:
                    operation, first = instruction
                    slots.append(operators[operation](slots[first]))
        return [slots[k] for k in self.output_slots]

    def inputs_behind(self, *outputs: int) -> frozenset[int]:
        """Numbers of the inputs that outputs, given by number, are computed from."""
        first = len(self.input_names) + len(self.constants)
        behind = {self.output_slots[k] for k in outputs}
        for slot in range(first + len(self.instructions) - 1, first - 1, -1):
            if slot in behind:
                behind.update(self.instructions[slot - first][1:])
        return frozenset(behind & {*range(len(self.input_names))})

    @cached_property
    def _function_names(self) -> frozenset[str]:
        """Names of the functions that it calls."""
        return frozenset(step[0] for step in self.instructions) & UNARY_OPERATIONS - {"neg"}


class Role(StrEnum):
    """What a state variable is, so that nobody has to guess it from its name."""

    #: A generalised coordinate: a stretch.
    COORDINATE = "coordinate"
    #: The rate of a coordinate.
    RATE = "rate"
    #: An internal variable of a dissipative element, of first order in time.
    INTERNAL = "internal"
    #: The temperature of the body, in kelvin.
    TEMPERATURE = "temperature"
    #: A derivative of a state variable along a direction, or a small difference of two.
    VARIATION = "variation"
    #: The integral over time of an observable.
    INTEGRAL = "integral"


@dataclass(frozen=True)
class StateVariable:
    """One component of the state.

    Attributes
    ----------
    name
        Its name in results.
    role
        What it is.
    rest : float or str
        Its value at rest: a number, or the name of the parameter that holds it (of a
        temperature, the temperature of the surroundings).
    belongs_to : str or None
        Name of another variable of the same state: of a rate, its coordinate; of an
        internal variable, the coordinate that it relaxes to; of a variation, what varies.
        None where there is none or it is not known.
    positive
        Whether only positive values have a meaning (stretches, absolute temperatures).
    """

    name: str
    role: Role
    rest: float | str = 0.0
    belongs_to: str | None = None
    positive: bool = False

    def value_at_rest(self, parameters: Mapping[str, Any]) -> Any:
        """The value at rest, given values of parameters by name, single or in arrays."""
        return parameters[self.rest] if isinstance(self.rest, str) else self.rest


@dataclass(frozen=True)
class Field:
    """A vector field ``dy/dtau = f(phase, y, p, u)`` with what is observed of it.

    Every program takes the inputs ``("drive_phase", *state, *parameters,
    *waveforms)`` in this order.  `phase` is the phase of the drive in [0, 1), or the
    fraction of the current piece where the load has no period; `u` are the
    waveforms of the drive at that instant, the same for all trajectories.

    Attributes
    ----------
    variables
        The state variables in order, with their roles and values at rest.
    load_names
        Names of the loads, each of which is an observable too; an actuator has one,
        ``load``.
    parameter_names, waveform_names
        Names.  Parameters are the user's own numeric fields under their own names.
    rates
        One output per state variable.
    observable_name
        Name of the quantity whose extremes are followed between steps, ``thickness_stretch``
        of an actuator; its rate is observed under this name and ``_rate``.
    observable_and_rates
        Four outputs: that quantity, its first and second time derivative, and a cheaper
        quantity with the sign of the first.
    observables
        Further quantities by name, one output each (``thickness_stretch``,
        ``thickness_stretch_rate``, ``energy``, ``load`` ...).
    """

    variables: tuple[StateVariable, ...]
    load_names: tuple[str, ...]
    parameter_names: tuple[str, ...]
    waveform_names: tuple[str, ...]
    rates: Program
    observable_name: str
    observable_and_rates: Program
    observables: Mapping[str, Program]

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the state variables, in order."""
        return tuple(variable.name for variable in self.variables)

    @cached_property
    def roles(self) -> tuple[Role, ...]:
        """Role of each state variable."""
        return tuple(variable.role for variable in self.variables)

    @cached_property
    def default_initial_values(self) -> tuple[float | str, ...]:
        """Value at rest of each state variable, a number or the name of a parameter."""
        return tuple(variable.rest for variable in self.variables)

    @property
    def observable_and_rate_names(self) -> tuple[str, str]:
        """Names of the quantity whose extremes are followed, and of its rate."""
        return self.observable_name, f"{self.observable_name}_rate"

    @cached_property
    def watched_variables(self) -> tuple[int, ...]:
        """Positions in the state of the variables that enter the formula of this quantity."""
        behind = self.observable_and_rates.inputs_behind(0)
        return tuple(k for k in range(len(self.variables)) if k + 1 in behind)

    def is_driven(self, program: Program) -> bool:
        """Whether the phase or a waveform of the drive enters a program of the field."""
        first = len(self.input_names) - len(self.waveform_names)
        behind = program.inputs_behind(*range(len(program.output_slots)))
        return not behind.isdisjoint({0, *range(first, len(self.input_names))})

    @property
    def energy_names(self) -> tuple[str, ...]:
        """The name of the energy among the observables, where there is one."""
        return ("energy",) if "energy" in self.observables else ()

    def indices_of_roles(self, *roles: Role) -> list[int]:
        """Positions in the state of the variables that have one of these roles."""
        return [k for k, role in enumerate(self.roles) if role in roles]

    def names_of_roles(self, *roles: Role) -> list[str]:
        """Names of the state variables that have one of these roles."""
        return [self.state_names[k] for k in self.indices_of_roles(*roles)]

    def state_variable(self, name: str) -> StateVariable:
        """The state variable of this name."""
        return self.variables[self.state_names.index(name)]

    def names_belonging_to(self, name: str) -> list[str]:
        """Names of the state variables that belong to the variable `name`, in order."""
        return [variable.name for variable in self.variables if variable.belongs_to == name]

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs of every program of this field, in order."""
        return ("drive_phase", *self.state_names, *self.parameter_names, *self.waveform_names)

    def __post_init__(self) -> None:
        object.__setattr__(self, "observables", MappingProxyType(dict(self.observables)))
        if any(v.belongs_to not in {None, *self.state_names} for v in self.variables):
            raise ValueError("a state variable belongs to one that does not exist")
        if not {*self.load_names} <= {*self.observables}:
            raise ValueError("a load is not observed")
        if not {v.rest for v in self.variables if isinstance(v.rest, str)} <= {
            *self.parameter_names
        }:
            raise ValueError("a value at rest is a parameter that does not exist")
        for program in (self.rates, self.observable_and_rates, *self.observables.values()):
            if program.input_names != self.input_names:
                raise ValueError(
                    f"program inputs {program.input_names} differ from {self.input_names}"
                )
        if (
            len(self.rates.output_slots) != len(self.state_names)
            or len(self.observable_and_rates.output_slots) != 4
        ):
            raise ValueError("wrong number of outputs")

    def __hash__(self) -> int:
        """Of the fingerprint, so that what follows from a field can be remembered."""
        return hash(self.fingerprint)

    @cached_property
    def fingerprint(self) -> str:
        """A digest of the whole field, equal for equal fields on every machine."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()[:32]

    def to_json(self) -> str:
        """The field as JSON text; floats survive the round trip bit for bit."""
        return json.dumps(
            {
                "variables": [asdict(variable) for variable in self.variables],
                "loads": self.load_names,
                "parameters": self.parameter_names,
                "waveforms": self.waveform_names,
                "rates": _program_to_dict(self.rates),
                "observable": self.observable_name,
                "watched": _program_to_dict(self.observable_and_rates),
                "observables": {k: _program_to_dict(v) for k, v in self.observables.items()},
            },
            sort_keys=True,
        )

    @classmethod
    def from_json(cls, text: str) -> Field:
        """Read what :meth:`to_json` wrote; malformed text raises ``ValueError``."""
        try:
            plain = json.loads(text)
            variables = tuple(map(_variable_from_dict, plain["variables"]))
            loads, parameters, waveforms = (
                tuple(map(str, plain[k])) for k in ("loads", "parameters", "waveforms")
            )
            state = (variable.name for variable in variables)
            inputs = ("drive_phase", *state, *parameters, *waveforms)
            return cls(
                variables=variables,
                load_names=loads,
                parameter_names=parameters,
                waveform_names=waveforms,
                rates=_program_from_dict(inputs, plain["rates"]),
                observable_name=str(plain["observable"]),
                observable_and_rates=_program_from_dict(inputs, plain["watched"]),
                observables={
                    k: _program_from_dict(inputs, v) for k, v in plain["observables"].items()
                },
            )
        except (KeyError, TypeError) as error:
            raise ValueError(f"not a stored field: {error!r}") from error


def _variable_from_dict(plain: Mapping[str, Any]) -> StateVariable:
    rest, belongs_to = plain["rest"], plain["belongs_to"]
    return StateVariable(
        name=str(plain["name"]),
        role=Role(plain["role"]),
        rest=rest if isinstance(rest, str) else float(rest),
        belongs_to=None if belongs_to is None else str(belongs_to),
        positive=bool(plain["positive"]),
    )


def _program_to_dict(program: Program) -> dict[str, Any]:
    return {
        "constants": program.constants,
        "code": program.instructions,
        "outputs": program.output_slots,
    }


def _program_from_dict(inputs: tuple[str, ...], plain: Mapping[str, Any]) -> Program:
    return Program(
        input_names=inputs,
        constants=tuple(float(x) for x in plain["constants"]),
        instructions=tuple((str(step[0]), *map(int, step[1:])) for step in plain["code"]),  # type: ignore[misc]
        output_slots=tuple(int(k) for k in plain["outputs"]),
    )
