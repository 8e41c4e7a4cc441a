"""The equations of motion as a reader wants to see them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from textwrap import fill

import sympy as sp

from remanent._errors import InputError, shortened_repr
from remanent.derivation import block
from remanent.derivation.energy_balance import temperature_rate
from remanent.derivation.lagrange import mass_matrix_and_force
from remanent.derivation.letters import latex, latex_settings
from remanent.derivation.motion import Motion
from remanent.derivation.symbols import Expression, Symbol
from remanent.derivation.unexpanded import Unexpanded, without_mark
from remanent.derivation.written_equations import lagrange_equations, symbols_by_name
from remanent.models.actuator import Actuator
from remanent.models.own_systems.first_order_system import FirstOrderSystem
from remanent.models.own_systems.lagrangian_system import LagrangianSystem
from remanent.models.own_systems.written_system import WrittenSystem
from remanent.models.system import System

#: Terms of a sum on one typeset line, and the most that a sum has that is not broken into lines.
_TERMS_PER_LINE, _MOST_TERMS_ON_ONE_LINE = 5, 7
#: Longest line of equations in a terminal, in characters.
_TERMINAL_WIDTH = 100


@dataclass(frozen=True)
class Equations:
    """Equations of motion of an actuator; a notebook shows them typeset.

    Attributes
    ----------
    second_order
        SymPy equations, one for each coordinate: M q'' + ... = 0, scaled so that for
        one coordinate it is [Thermal, eq. 16].
    first_order
        SymPy equations for the rates of internal variables, and of the temperature where
        that is a state.
    definitions
        What the intermediate symbols stand for, as SymPy equations.
    letters
        LaTeX of names whose letter is not the usual one.
    """

    second_order: tuple[Expression, ...]
    first_order: tuple[Expression, ...]
    definitions: tuple[Expression, ...]
    letters: Mapping[str, str] = field(default_factory=dict, repr=False)

    @property
    def latex(self) -> str:
        """All of them as LaTeX."""
        rows = (*self.second_order, *self.first_order, *self.definitions)
        return _join_latex_lines([latex(row, self.letters) for row in rows])

    def __str__(self) -> str:
        """The equations in a terminal, broken into lines of at most 100 characters."""
        rows = (*self.second_order, *self.first_order, *self.definitions)
        sides = ((_without_marks(row.lhs), _without_marks(row.rhs)) for row in rows)
        return "\n\n".join(
            fill(f"{left} = {right}", _TERMINAL_WIDTH, subsequent_indent="    ")
            for left, right in sides
        )

    def _repr_latex_(self) -> str:
        rows = (*self.second_order, *self.first_order, *self.definitions)
        lines = [equation_latex(row, self.letters) for row in rows]
        return f"$\\displaystyle {_join_latex_lines(lines)}$"


def equations(system: System) -> Equations:
    """The equations of motion of a system under loads that are left as symbols.

    Parameters
    ----------
    system : System
        An actuator, or a system of one's own.  Its numbers play no part; its classes, choices
        and formulas do.

    Returns
    -------
    Equations
        SymPy equations, which a notebook shows typeset.

    Raises
    ------
    InputError
        For a system of another kind.

    See Also
    --------
    remanent.simulate : Solve them.

    Notes
    -----
    For an actuator the equation is [Thermal, eq. 16] with what its parts add.

    Examples
    --------
    >>> equations(Actuator()).second_order[0].rhs
    0
    """
    if isinstance(system, LagrangianSystem):
        return _equations_of_energies(system)
    if isinstance(system, FirstOrderSystem):
        return _equations_of_rates(system)
    if not isinstance(system, Actuator):
        raise InputError(
            "system",
            must="be an actuator, or a system of one's own in formulas",
            got=shortened_repr(system),
            why="Only their equations can be typeset.",
            fix="Pass for example rm.Actuator().",
        )
    motion = block.build_motion(system, None)
    rows = second_order_equations(motion)
    rates = {**motion.internal_rates, **_temperature_rate(motion)}
    internal = tuple(sp.Eq(time_derivative_symbol(k), e, evaluate=False) for k, e in rates.items())
    definitions = tuple(sp.Eq(k, e, evaluate=False) for k, e in motion.definitions.items())
    return Equations(rows, internal, definitions, letters_of_actuator(system))


def _equations_of_energies(system: LagrangianSystem) -> Equations:
    """Lagrange's equations d/dtau dT/dq' - dT/dq + dV/dq + dD/dq' = 0, one a coordinate."""
    parts = lagrange_equations(system)
    accelerations = {v: time_derivative_symbol(v) for v in parts.velocity.values()}
    rows = tuple(
        sp.Eq(
            sp.expand(
                sum(
                    (parts.mass[i, j] * accelerations[parts.velocity[q]]
                     for j, q in enumerate(parts.moving)),
                    start=sp.Integer(0),
                )
                - force
            ),
            0,
            evaluate=False,
        )
        for i, force in enumerate(parts.forces)
    )  # fmt: skip
    inner = tuple(
        sp.Eq(sp.expand(-balance), 0, evaluate=False) for balance in parts.internal_balances
    )
    return _written(system, rows, inner)


def _equations_of_rates(system: FirstOrderSystem) -> Equations:
    symbols = symbols_by_name(system)
    rows = tuple(
        sp.Eq(time_derivative_symbol(symbols[name]), one(symbols, sp), evaluate=False)
        for name, one in zip(system.state_names, system.formulas().values(), strict=True)
    )
    return _written(system, (), rows)


def _written(
    system: WrittenSystem, second: tuple[Expression, ...], first: tuple[Expression, ...]
) -> Equations:
    """Equations in the symbols that the user gave."""
    texts = system.variable_texts()
    letters = {name: text.symbol for name, text in texts.items()}
    letters |= {f"{name}'": rf"\dot{{{text.symbol}}}" for name, text in texts.items()}
    for name in system.state_names:
        base = name.removesuffix("_rate")
        if base != name and base in texts:
            letters[f"{name}'"] = rf"\ddot{{{texts[base].symbol}}}"
    return Equations(second, first, (), letters)


def _temperature_rate(motion: Motion) -> dict[Expression, Expression]:
    """Rate of the temperature, where that is a state."""
    if motion.heat_balance is None:
        return {}
    rates = dict(zip(motion.coordinates, motion.rates, strict=True)) | dict(motion.internal_rates)
    return temperature_rate(motion, motion.heat_balance, rates)


def second_order_equations(motion: Motion) -> tuple[Expression, ...]:
    """Lagrange's equations M q'' - f = 0, times 3/2 for equal stretches, 3 otherwise.

    [Thermal, eq. 16] is Lagrange's equation of the energies per 8 H L^2 mu, where the
    stretch has mass 2/3, times 3/2.
    """
    mass, force = mass_matrix_and_force(motion)
    scale = sp.Rational(3, 2) if len(motion.coordinates) == 1 else sp.Integer(3)
    accelerations = sp.Matrix([time_derivative_symbol(rate) for rate in motion.rates])
    residuals = mass * accelerations - force
    return tuple(sp.Eq(_expand_sum(scale * row), 0, evaluate=False) for row in residuals)


def _expand_sum(expression: Expression) -> Expression:
    """`expression` as a sum, its unexpanded parts as they are written."""
    placeholders = {part: sp.Dummy(real=True) for part in expression.atoms(Unexpanded)}
    expanded = sp.expand(expression.xreplace(placeholders))
    return expanded.xreplace({dummy: part for part, dummy in placeholders.items()})


def _without_marks(expression: Expression) -> Expression:
    """`expression` with its unexpanded parts in parentheses alone."""
    return expression.xreplace({part: part.args[0] for part in expression.atoms(Unexpanded)})


def time_derivative_symbol(symbol: Symbol) -> Symbol:
    """The symbol of a time derivative."""
    return sp.Symbol(f"{symbol.name}'", real=True)


def equation_latex(equation: Expression, letters: Mapping[str, str]) -> str:
    """An equation as LaTeX, a long sum broken into lines.

    Parameters
    ----------
    equation
        SymPy's.
    letters
        Letters that are others than usual, by name.
    """
    left, right = map(without_mark, equation.args)
    if right == 0 and len(sp.Add.make_args(left)) > _MOST_TERMS_ON_ONE_LINE:
        settings = latex_settings(equation, letters)
        text = sp.multiline_latex(right, left, _TERMS_PER_LINE, settings=settings)
        return str(text).replace("align*", "aligned").replace("= & ", "={}& ")
    return f"{latex(left, letters)} = {latex(right, letters)}"


def letters_of_actuator(actuator: Actuator) -> dict[str, str]:
    """Letters that are others than usual: T is the body's where that is a state."""
    return {} if actuator.heat is None else {"temperature": r"T_\infty"}


def _join_latex_lines(lines: list[str]) -> str:
    return "\\begin{gathered} " + r" \\ ".join(lines) + " \\end{gathered}"
