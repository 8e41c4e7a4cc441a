"""Fields that carry more along a motion: derivatives of the state, integrals of observables.

Both are written from a field's straight-line code by running it on numbers that record what
is done with them, so they hold for any field, and no symbols are needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from remanent._field import Field, Program, Role, StateVariable
from remanent._instructions import InstructionBuilder, SignedValue

#: Stands among `parameters` of :func:`field_with_tangents` for the logarithm of the length of
#: a cycle.
LOG_PERIOD_PARAMETER_NAME = "log_period"
#: Widened fields that are remembered, so that verbs that are called again need not write them.
_REMEMBERED_FIELDS = 64


def field_with_tangents(field: Field, *, directions: int, parameters: Sequence[str] = ()) -> Field:
    """A field whose state also holds derivatives of the state.

    Equations, with f the rates, J = df/dy: w' = J w for each direction, and
    w' = J w + df/dp for the derivative with respect to a parameter p.  All of it is
    differentiated at a fixed phase of the drive.  The length L of a cycle enters through
    dtau = L dphase only: the derivative with respect to log L obeys w' = J w + f.

    Parameters
    ----------
    field : Field
        With state variables y.
    directions : int
        How many derivatives along changes of the initial state.
    parameters : sequence of str
        Names of parameters, or :data:`LOG_PERIOD_PARAMETER_NAME`.

    Returns
    -------
    Field
        State ``(*y, *w[0], *w[1], ...)``: first the directions, then the parameters.
    """
    return _field_with_tangents(field, directions, tuple(parameters))


@lru_cache(maxsize=_REMEMBERED_FIELDS)
def _field_with_tangents(field: Field, directions: int, parameters: tuple[str, ...]) -> Field:
    columns = directions + len(parameters)
    added = tuple(
        StateVariable(f"tangent.{k}.{name}", Role.VARIATION, belongs_to=name)
        for k in range(columns)
        for name in field.state_names
    )
    inputs = _widened_input_names(field, added)
    into = InstructionBuilder(inputs)
    values = [_Dual(into, into.input(name), (None,) * columns) for name in field.input_names]
    for i, name in enumerate(field.state_names):
        slopes = tuple(into.input(f"tangent.{k}.{name}") for k in range(columns))
        values[1 + i] = replace(values[1 + i], slopes=slopes)
    for k, name in enumerate(parameters, start=directions):
        if name != LOG_PERIOD_PARAMETER_NAME:
            at = field.input_names.index(name)
            unit = tuple(into.constant(1.0) if j == k else None for j in range(columns))
            values[at] = replace(values[at], slopes=unit)
    rates = _run_with_duals(field.rates, values, into, columns)
    outputs = [rate.recorded_value for rate in rates]
    for k in range(columns):
        itself = k >= directions and parameters[k - directions] == LOG_PERIOD_PARAMETER_NAME
        for rate in rates:
            slope = rate.slopes[k] or into.constant(0.0)
            outputs.append(into.add(slope, rate.recorded_value) if itself else slope)
    return _widened_field(field, added, into.build_program(outputs))


def transverse_field(field: Field, pairs: Mapping[str, str]) -> Field:
    """The motion of like variables that are equal, and how small differences of them grow.

    Equation, where x and y are columns of like variables and the motion keeps x = y:
    (x - y)' = (df_x/dx - df_x/dy) (x - y), differentiated along the motion with x = y.
    This is the variational equation transverse to the invariant set x = y; exponents and
    multipliers of it are the transverse ones.  Rounding cannot break the equality, since each
    pair is one variable here.

    Parameters
    ----------
    field : Field
        Whose equations are the same where x and y are exchanged.
    pairs : mapping of str to str
        Second variable of each pair by the first.

    Returns
    -------
    Field
        State: the variables but the second ones, then ``"transverse.NAME"`` for each pair.
    """
    return _transverse_field(field, tuple(pairs.items()))


@lru_cache(maxsize=_REMEMBERED_FIELDS)
def _transverse_field(field: Field, pairs_in_order: tuple[tuple[str, str], ...]) -> Field:
    pairs = dict(pairs_in_order)
    kept_variables = tuple(v for v in field.variables if v.name not in pairs.values())
    added = tuple(
        StateVariable(f"transverse.{name}", Role.VARIATION, belongs_to=name) for name in pairs
    )
    variables = (*kept_variables, *added)
    state = tuple(variable.name for variable in variables)
    inputs = ("drive_phase", *state, *field.parameter_names, *field.waveform_names)
    into = InstructionBuilder(inputs)
    first_of = {second: name for name, second in pairs.items()}
    values = []
    for name in field.input_names:
        representative = first_of.get(name, name)
        # Along (1, -1): a change of the first by the difference, of the second by its negative.
        difference = into.input(f"transverse.{representative}") if representative in pairs else None
        slope = difference and (_negated(difference) if name in first_of else difference)
        values.append(_Dual(into, into.input(representative), (slope,)))
    rates = dict(zip(field.state_names, _run_with_duals(field.rates, values, into, 1), strict=True))
    zero = into.constant(0.0)
    outputs = [rates[variable.name].recorded_value for variable in kept_variables]
    outputs += [rates[name].slopes[0] or zero for name in pairs]
    names = {name: first_of.get(name, name) for name in field.input_names}
    return Field(
        variables=variables,
        load_names=field.load_names,
        parameter_names=field.parameter_names,
        waveform_names=field.waveform_names,
        rates=into.build_program(outputs),
        observable_name=field.observable_name,
        observable_and_rates=_program_with_inputs(field.observable_and_rates, inputs, names),
        observables={
            k: _program_with_inputs(p, inputs, names) for k, p in field.observables.items()
        },
    )


def field_with_integrals(field: Field, names: Sequence[str]) -> Field:
    """A field whose state also holds integrals over time of some of its observables.

    Parameters
    ----------
    field : Field
        With state variables y.
    names : sequence of str
        Of observables.

    Returns
    -------
    Field
        State ``(*y, "integral.NAME", ...)``.
    """
    added = tuple(StateVariable(f"integral.{name}", Role.INTEGRAL) for name in names)
    into = InstructionBuilder(_widened_input_names(field, added))
    values = [_Dual(into, into.input(name), ()) for name in field.input_names]
    programs = (field.rates, *(field.observables[name] for name in names))
    outputs = [
        rate.recorded_value
        for program in programs
        for rate in _run_with_duals(program, values, into, 0)
    ]
    return _widened_field(field, added, into.build_program(outputs))


@lru_cache(maxsize=_REMEMBERED_FIELDS)
def observable_derivatives(field: Field, name: str, variables: tuple[str, ...]) -> Program:
    """An observable, or a state variable, and its partial derivatives.

    Parameters
    ----------
    field : Field
    name : str
        Of the observable or state variable.
    variables : tuple of str
        State variables or parameters to differentiate with respect to.

    Returns
    -------
    Program
        Outputs: the value, then one derivative for each of `variables`.
    """
    into = InstructionBuilder(field.input_names)
    one, columns = into.constant(1.0), len(variables)
    values = [
        _Dual(into, into.input(i), tuple(one if i == v else None for v in variables))
        for i in field.input_names
    ]
    if name in field.state_names:
        value = values[field.input_names.index(name)]
    else:
        (value,) = _run_with_duals(field.observables[name], values, into, columns)
    return into.build_program(
        [value.recorded_value, *(s or into.constant(0.0) for s in value.slopes)]
    )


def _widened_input_names(field: Field, added: Sequence[StateVariable]) -> tuple[str, ...]:
    names = (variable.name for variable in added)
    return (
        "drive_phase",
        *field.state_names,
        *names,
        *field.parameter_names,
        *field.waveform_names,
    )


def _run_with_duals(
    program: Program, values: Sequence[_Dual], into: InstructionBuilder, columns: int
) -> list[_Dual]:
    return program(
        values,
        functions=_DualFunctions,
        constant=lambda x: _Dual(into, into.constant(x), (None,) * columns),
    )


def _widened_field(field: Field, added: tuple[StateVariable, ...], rates: Program) -> Field:
    inputs = _widened_input_names(field, added)
    return Field(
        variables=(*field.variables, *added),
        load_names=field.load_names,
        parameter_names=field.parameter_names,
        waveform_names=field.waveform_names,
        rates=rates,
        observable_name=field.observable_name,
        observable_and_rates=_program_with_inputs(field.observable_and_rates, inputs),
        observables={
            name: _program_with_inputs(p, inputs) for name, p in field.observables.items()
        },
    )


def _program_with_inputs(
    program: Program, inputs: tuple[str, ...], names: Mapping[str, str] = MappingProxyType({})
) -> Program:
    """The same code for another list of inputs, of which some have other names."""
    before, more = len(program.input_names), len(inputs) - len(program.input_names)

    def moved(slot: int) -> int:
        if slot >= before:
            return slot + more
        name = program.input_names[slot]
        return inputs.index(names.get(name, name))

    return Program(
        input_names=inputs,
        constants=program.constants,
        instructions=tuple((step[0], *map(moved, step[1:])) for step in program.instructions),  # type: ignore[misc]
        output_slots=tuple(map(moved, program.output_slots)),
    )


@dataclass(frozen=True)
class _Dual:
    """A recorded value and its derivative along each direction; None stands for zero."""

    instructions: InstructionBuilder
    recorded_value: SignedValue
    slopes: tuple[SignedValue | None, ...]

    def __add__(self, other: _Dual) -> _Dual:
        return self._combined(
            self.instructions.add(self.recorded_value, other.recorded_value), other, self._slope_sum
        )

    def __sub__(self, other: _Dual) -> _Dual:
        return self + -other

    def __neg__(self) -> _Dual:
        return _Dual(
            self.instructions,
            _negated(self.recorded_value),
            tuple(s and _negated(s) for s in self.slopes),
        )

    def __mul__(self, other: _Dual) -> _Dual:
        def slope(a: SignedValue | None, b: SignedValue | None) -> SignedValue | None:
            return self._slope_sum(
                self._scaled_slope(other.recorded_value, a),
                self._scaled_slope(self.recorded_value, b),
            )

        return self._combined(
            self.instructions.mul(self.recorded_value, other.recorded_value), other, slope
        )

    def __truediv__(self, other: _Dual) -> _Dual:
        """a/b by the reciprocal of b, which its derivative (a' - (a/b) b')/b needs too."""
        if not any((*self.slopes, *other.slopes)):
            return replace(
                self,
                recorded_value=self.instructions.div(self.recorded_value, other.recorded_value),
            )
        inverse = self.instructions.div(self.instructions.constant(1.0), other.recorded_value)
        quotient = self.instructions.mul(self.recorded_value, inverse)

        def slope(a: SignedValue | None, b: SignedValue | None) -> SignedValue | None:
            change = self._scaled_slope(quotient, b)
            return self._scaled_slope(inverse, self._slope_sum(a, change and _negated(change)))

        return self._combined(quotient, other, slope)

    def with_chain_rule(self, value: SignedValue, factor: SignedValue) -> _Dual:
        """A function of this value with the derivative `factor`."""
        return _Dual(
            self.instructions, value, tuple(self._scaled_slope(factor, s) for s in self.slopes)
        )

    def _combined(self, value: SignedValue, other: _Dual, slope: Any) -> _Dual:
        pairs = zip(self.slopes, other.slopes, strict=True)
        return _Dual(self.instructions, value, tuple(slope(a, b) for a, b in pairs))

    def _scaled_slope(self, factor: SignedValue, slope: SignedValue | None) -> SignedValue | None:
        return None if slope is None else self.instructions.mul(factor, slope)

    def _slope_sum(self, a: SignedValue | None, b: SignedValue | None) -> SignedValue | None:
        if a is None or b is None:
            return b if a is None else a
        return self.instructions.add(a, b)


def _negated(a: SignedValue) -> SignedValue:
    return -a[0], a[1]


class _DualFunctions:
    """The functions of programs, with their derivatives."""

    @staticmethod
    def sqrt(x: _Dual) -> _Dual:
        root = x.instructions.apply_function("sqrt", x.recorded_value)
        return x.with_chain_rule(root, x.instructions.div(x.instructions.constant(0.5), root))

    @staticmethod
    def exp(x: _Dual) -> _Dual:
        value = x.instructions.apply_function("exp", x.recorded_value)
        return x.with_chain_rule(value, value)

    @staticmethod
    def log(x: _Dual) -> _Dual:
        return x.with_chain_rule(
            x.instructions.apply_function("log", x.recorded_value),
            x.instructions.div(x.instructions.constant(1.0), x.recorded_value),
        )

    @staticmethod
    def sin(x: _Dual) -> _Dual:
        return x.with_chain_rule(
            x.instructions.apply_function("sin", x.recorded_value),
            x.instructions.apply_function("cos", x.recorded_value),
        )

    @staticmethod
    def cos(x: _Dual) -> _Dual:
        return x.with_chain_rule(
            x.instructions.apply_function("cos", x.recorded_value),
            _negated(x.instructions.apply_function("sin", x.recorded_value)),
        )

    @staticmethod
    def atan(x: _Dual) -> _Dual:
        one = x.instructions.constant(1.0)
        slope = x.instructions.div(
            one, x.instructions.add(one, x.instructions.mul(x.recorded_value, x.recorded_value))
        )
        return x.with_chain_rule(x.instructions.apply_function("atan", x.recorded_value), slope)
