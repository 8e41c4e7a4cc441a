"""Programs of formulas that somebody wrote, and of plain functions, recorded as they compute."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from remanent._field import UNARY_OPERATIONS, Field, Program
from remanent._instructions import InstructionBuilder, SignedValue
from remanent.models.formula import Formula


def formula_names(field: Field) -> list[str]:
    """Names that a formula on a field may have: states, parameters and what is observed."""
    names = dict.fromkeys((*field.state_names, *field.parameter_names, *field.observables))
    return [name for name in names if name.isidentifier()]


def program_of_formula(field: Field, formula: Formula) -> Program:
    """A program with one output, the value of the formula.

    Parameters
    ----------
    field : Field
    formula : Formula
        In names of :func:`formula_names`.
    """
    into = InstructionBuilder(field.input_names)
    inputs = [_Recorded(into, into.input(name)) for name in field.input_names]
    by_name = dict(zip(field.input_names, inputs, strict=True))
    for name in formula.variable_names - by_name.keys():
        (by_name[name],) = field.observables[name](
            inputs, functions=_FUNCTIONS, constant=lambda x: _as_recorded(into, x)
        )
    value = _as_recorded(into, formula(by_name, _FUNCTIONS))
    return into.build_program([value.value])


def program_of_values(
    input_names: Sequence[str], compute: Callable[[Mapping[str, Any], Any], Any]
) -> Program:
    """A program with one output, recorded while a function computes it.

    Parameters
    ----------
    input_names : sequence of str
        Inputs of the program.
    compute : callable
        ``compute(values, functions)``, which takes the inputs by name and the functions ``sin``,
        ``exp`` and so on of such values.
    """
    return program_of_several_values(
        input_names, lambda values, functions: [compute(values, functions)]
    )


def program_of_several_values(
    input_names: Sequence[str], compute: Callable[[Mapping[str, Any], Any], Sequence[Any]]
) -> Program:
    """A program with an output for each of the values that a function computes.

    Parameters
    ----------
    input_names : sequence of str
        Inputs of the program.
    compute : callable
        As :func:`program_of_values` takes it, of several values.
    """
    into = InstructionBuilder(input_names)
    by_name = {name: _Recorded(into, into.input(name)) for name in input_names}
    values = compute(by_name, _FUNCTIONS)
    return into.build_program([_as_recorded(into, value).value for value in values])


def joined_program(programs: Sequence[Program]) -> Program:
    """The outputs of several programs of the same inputs, what they share computed once.

    Parameters
    ----------
    programs : sequence of Program
        At least one.
    """
    names = programs[0].input_names
    into = InstructionBuilder(names)
    inputs = [_Recorded(into, into.input(name)) for name in names]
    outputs = [
        output
        for program in programs
        for output in program(
            inputs, functions=_FUNCTIONS, constant=lambda x: _as_recorded(into, x)
        )
    ]
    return into.build_program([_as_recorded(into, output).value for output in outputs])


@dataclass(frozen=True)
class _Recorded:
    """A value of straight-line code; arithmetic with it records instructions."""

    into: InstructionBuilder
    value: SignedValue

    def __add__(self, other: Any) -> _Recorded:
        return self._with(self.into.add(self.value, _as_recorded(self.into, other).value))

    __radd__ = __add__

    def __neg__(self) -> _Recorded:
        return self._with((-self.value[0], self.value[1]))

    def __sub__(self, other: Any) -> _Recorded:
        return self + -_as_recorded(self.into, other)

    def __rsub__(self, other: Any) -> _Recorded:
        return _as_recorded(self.into, other) + -self

    def __mul__(self, other: Any) -> _Recorded:
        return self._with(self.into.mul(self.value, _as_recorded(self.into, other).value))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> _Recorded:
        return self._with(self.into.div(self.value, _as_recorded(self.into, other).value))

    def __rtruediv__(self, other: Any) -> _Recorded:
        dividend = _as_recorded(self.into, other)
        return self._with(self.into.div(dividend.value, self.value))

    def __pow__(self, exponent: Any) -> _Recorded:
        if isinstance(exponent, int):
            if exponent == 0:
                return _as_recorded(self.into, 1.0)
            whole = self.into.power(self.value, abs(exponent))
            inverse = self.into.div(self.into.constant(1.0), whole)
            return self._with(whole if exponent > 0 else inverse)
        product = _as_recorded(self.into, exponent) * _FUNCTIONS.log(self)
        power: _Recorded = _FUNCTIONS.exp(product)
        return power

    def __rpow__(self, base: Any) -> _Recorded:
        power: _Recorded = _FUNCTIONS.exp(self * float(np.log(base)))
        return power

    #: Numbers of NumPy leave arithmetic to these methods.
    __array_ufunc__ = None

    def _with(self, value: SignedValue) -> _Recorded:
        return _Recorded(self.into, value)


def _as_recorded(into: InstructionBuilder, number: Any) -> _Recorded:
    if isinstance(number, _Recorded):
        return number
    return _Recorded(into, into.constant(float(number)))


class _RecordedFunctions:
    """Functions of such values, and of plain numbers, under the names of the instructions."""

    pi = float(np.pi)

    def __getattr__(self, name: str) -> Callable[[Any], Any]:
        if name not in UNARY_OPERATIONS:
            raise AttributeError(name)

        def apply(x: Any) -> Any:
            if isinstance(x, _Recorded):
                return _Recorded(x.into, x.into.apply_function(name, x.value))
            with np.errstate(all="ignore"):
                return getattr(np, name)(x)

        return apply


#: The functions that formulas and programs are given.
_FUNCTIONS: Final = _RecordedFunctions()
