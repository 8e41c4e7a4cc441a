"""The equations of motion as a reader wants to see them."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import fill

import sympy as sp

from remanent._errors import InputError, shortened_repr
from remanent.derivation import block
from remanent.derivation.energy_balance import temperature_rate
from remanent.derivation.lagrange import mass_matrix_and_force
from remanent.derivation.motion import Motion
from remanent.derivation.symbols import Expression, Symbol
from remanent.derivation.unexpanded import Unexpanded
from remanent.derivation.written_equations import lagrange_equations, symbols_by_name
from remanent.models.actuator import Actuator
from remanent.models.own_systems.first_order_system import FirstOrderSystem
from remanent.models.own_systems.lagrangian_system import LagrangianSystem
from remanent.models.own_systems.written_system import WrittenSystem
from remanent.models.system import System

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
    latex
        All of them as LaTeX.
    """

    second_order: tuple[Expression, ...]
    first_order: tuple[Expression, ...]
    definitions: tuple[Expression, ...]
    latex: str

    def __str__(self) -> str:
        """The equations in a terminal, broken into lines of at most 100 characters."""
        rows = (*self.second_order, *self.first_order, *self.definitions)
        return "\n\n".join(
            fill(f"{row.lhs} = {row.rhs}", _TERMINAL_WIDTH, subsequent_indent="    ")
            for row in rows
        )

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex}$"


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
    lines = [_equation_latex(e, motion) for e in (*rows, *internal, *definitions)]
    return Equations(rows, internal, definitions, _join_latex_lines(lines))


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
    lines = [
        str(sp.latex(row, symbol_names={s: letters.get(s.name, s.name) for s in row.free_symbols}))
        for row in (*second, *first)
    ]
    return Equations(second, first, (), _join_latex_lines(lines))


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


#: Letters of the numbers and internal variables of dissipative elements.
_LATEX_OF_NAME = {
    "modulus": r"\mu_v",
    "relaxation_time": "t_r",
    "viscous_stretch": r"\xi",
    "viscous_stretch_1": r"\xi_1",
    "viscous_stretch_2": r"\xi_2",
}


def time_derivative_symbol(symbol: Symbol) -> Symbol:
    """The symbol of a time derivative."""
    return sp.Symbol(f"{symbol.name}'", real=True)


def _equation_latex(equation: Expression, motion: Motion) -> str:
    names = {
        "c": "c",
        "shear_modulus": r"\hat\mu",
        "density": r"\hat\rho",
        "remanence": r"\hat B_r",
        "temperature": "T",
        "reference_temperature": "T_0",
        "theta": r"\theta",
        "stiffness": "g",
        "load": "m",
        "effective_load": "m_T",
        "material.entropic_fraction": "f",
        "material.jm": "J_m",
        "material.locking_stretch": "L_m",
        "magnet.temperature_coefficient": r"\alpha",
        "magnet.demagnetisation": "d",
        "heat.coupling": "k",
        "heat.exchange": "h",
        "body_temperature": "T",
        "body_temperature'": "T'",
        "area": "A",
        "thickness": r"\lambda_3",
        "thickness_rate": r"{\lambda_3'}",
    }
    if motion.heat_balance is not None:
        names["temperature"] = r"T_\infty"
    return str(
        sp.latex(
            equation, symbol_names=_latex_of_symbol(equation, names | _latex_of_motion_name(motion))
        )
    )


def _latex_of_motion_name(motion: Motion) -> dict[str, str]:
    """Letters of stretches, their rates and the dead loads."""
    letters = {}
    for i, (stretch, rate) in enumerate(zip(motion.coordinates, motion.rates, strict=True), 1):
        index = f"_{i}" if len(motion.coordinates) > 1 else ""
        letters[stretch.name] = rf"\lambda{index}"
        letters[rate.name] = rf"{{\lambda{index}'}}"
        letters[time_derivative_symbol(rate).name] = rf"{{\lambda{index}''}}"
        letters["prestress" + index] = f"S{index}"
    return letters


def _latex_of_symbol(equation: Expression, names: dict[str, str]) -> dict[Expression, str]:
    return {s: names.get(s.name, _latex_of_field_name(s.name)) for s in equation.free_symbols}


def _latex_of_field_name(name: str) -> str:
    """For ``dissipation.0.eta`` the letter eta with the index 0."""
    words = name.split(".")
    letter = _LATEX_OF_NAME.get(words[-1].rstrip("'"))
    if letter is not None:
        prime = "'" if name.endswith("'") else ""
        return f"{{{letter}^{{({words[1]})}}{prime}}}"
    index = [word for word in words[1:-1] if word.isdigit()]
    return str(sp.latex(sp.Symbol("_".join([words[-1], *index]))))


def _join_latex_lines(lines: list[str]) -> str:
    return "\\begin{gathered} " + r" \\ ".join(lines) + " \\end{gathered}"
