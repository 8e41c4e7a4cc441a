"""The letter of each number and variable in typeset equations: the field's own symbols."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import sympy as sp

from remanent.derivation.symbols import Expression

#: LaTeX of names that stand alone, and of numbers of parts by their own name.
_LETTERS: Final[Mapping[str, str]] = MappingProxyType(
    {
        # The block
        "shear_modulus": r"\hat\mu",
        "density": r"\hat\rho",
        "remanence": r"\hat B_r",
        "temperature": "T",
        "reference_temperature": "T_0",
        "body_temperature": "T",
        "theta": r"\theta",
        "stiffness": "g",
        "prestress": "S",
        "prestress_1": "S_1",
        "prestress_2": "S_2",
        "edges_1": "L_1",
        "edges_2": "L_2",
        "stretch": r"\lambda",
        "stretch_1": r"\lambda_1",
        "stretch_2": r"\lambda_2",
        "area": "A",
        "thickness": r"\lambda_3",
        "thickness_rate": r"{\lambda_3'}",
        # Parts
        "entropic_fraction": "f",
        "jm": "J_m",
        "locking_stretch": "L_m",
        "moduli": r"\mu",
        "exponents": "a",
        "temperature_coefficient": r"\alpha",
        "demagnetisation": "d",
        "coupling": "k",
        "exchange": "h",
        "modulus": r"\mu_v",
        "relaxation_time": "t_r",
        "activation_temperature": "T_A",
        "viscous_stretch": r"\xi",
        "viscous_stretch_1": r"\xi_1",
        "viscous_stretch_2": r"\xi_2",
        # The load
        "load": "m",
        "effective_load": "m_T",
        "loads": "m",
        "mean": r"\bar m",
        "phase": r"\varphi",
        "phases": r"\varphi",
        "start": r"\omega_0",
        "stop": r"\omega_1",
        "duration": r"\tau_w",
    }
)


def letter(name: str) -> str:
    r"""LaTeX of the number or variable with this name.

    Parameters
    ----------
    name : str
        Dotted, as in ``dissipation.0.eta``; of a rate, with a prime at the end.

    Examples
    --------
    >>> letter("dissipation.0.eta"), letter("stretch_rate'"), letter("temperature")
    ('\\eta_{0}', "{\\lambda''}", 'T')
    """
    base = name.rstrip("'")
    marks = name[len(base) :]
    if base.endswith("_rate") and base not in _LETTERS:
        base, marks = base.removesuffix("_rate"), f"{marks}'"
    words = base.split(".")
    index = ",".join(word for word in words if word.isdigit())
    own = next(word for word in reversed(words) if not word.isdigit())
    found = _LETTERS.get(own) or str(sp.latex(sp.Symbol(own)))
    if index:
        # A letter with an index has the number of its part above, in brackets.
        found = f"{{{found}^{{({index})}}}}" if "_" in found else f"{found}_{{{index}}}"
    return f"{{{found}{marks}}}" if marks else found


def latex(expression: Expression, names: Mapping[str, str] = MappingProxyType({})) -> str:
    """A SymPy expression in these letters.

    Parameters
    ----------
    expression
        Of symbols that are called as numbers and variables are.
    names
        Letters that are others, by name.
    """
    return str(sp.latex(expression, **latex_settings(expression, names)))


def latex_settings(
    expression: Expression, names: Mapping[str, str] = MappingProxyType({})
) -> dict[str, Any]:
    """Keywords of SymPy's printers for an expression in these letters."""
    symbols = {s: names.get(s.name) or letter(s.name) for s in expression.free_symbols}
    return {"symbol_names": symbols, "ln_notation": True}
