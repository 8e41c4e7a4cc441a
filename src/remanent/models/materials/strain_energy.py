"""A strain energy of one's own, as a formula."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations
from types import MappingProxyType
from typing import Any, ClassVar, Final, Self

import numpy as np

from remanent import _checks
from remanent._checks import Rule
from remanent._errors import InputError
from remanent.models import formula
from remanent.models.formula import Formula
from remanent.models.materials.base import ENTROPIC_FRACTION_RULE, Material
from remanent.models.materials.second_order_ad import DualFunctions, SecondOrderDual

#: Names of the principal stretches in a formula.
_STRETCH_NAMES: Final = ("l1", "l2", "l3")
#: What varies in a formula: stretches, and the invariants of Cauchy's tensor.
_VARIABLE_NAMES: Final = frozenset((*_STRETCH_NAMES, "I1", "I2"))
#: Names that a constant may not have.
_RESERVED_NAMES: Final = _VARIABLE_NAMES | {
    *formula.FUNCTION_NAMES, formula.PI_NAME, "expression", "constants", "entropic_fraction",
}  # fmt: skip
#: Triples of stretches, of product 1, at which all orders of them are compared.
_SAMPLE_STRETCHES: Final = ((1.05, 0.98, 1 / (1.05 * 0.98)), (0.97, 1.01, 1 / (0.97 * 1.01)))
#: Largest difference between these energies, relative to 1 plus the largest of them.
_ISOTROPY_TOLERANCE: Final = 1e-10
#: The rule of the shear modulus that follows from the formula.
_MODULUS_RULE: Final = _checks.positive_rule(
    "It is the curvature of the energy at rest, by which the energy is divided; the undeformed "
    "state must be stable.",
    "Check the formula and the signs of its constants.",
)


@dataclass(frozen=True)
class StrainEnergy(Material):
    r"""A strain energy of one's own, as a formula in stretches or invariants.

    The formula may have any unit and any value at rest:
    :math:`W/\mu = [W(\lambda) - W(1)]/\mu_W`, with :math:`\mu_W` the shear modulus at rest that
    follows from it.  It must not change when stretches
    are exchanged (an isotropic solid), which also makes the undeformed state free of stress.
    A motion never leaves the states in which every logarithm, root and denominator in the
    formula has the sign that it has at rest.

    Parameters
    ----------
    expression : str or SymPy expression
        Text, or a SymPy expression, in the principal stretches ``l1``, ``l2``, ``l3``, or the
        invariants ``I1`` :math:`= \lambda_1^2 + \lambda_2^2 + \lambda_3^2` and ``I2``
        :math:`= \lambda_1^{-2} + \lambda_2^{-2} + \lambda_3^{-2}`, and in the names of
        `constants`; arithmetic, powers, ``sqrt``, ``exp``, ``log``, ``sin``, ``cos`` and ``pi``.
        Text is read, never run.
    constants : mapping of str to float
        Values of the other names: numeric fields of the material, which ``over`` may vary as
        ``material.NAME``.
    entropic_fraction : float
        Share of the modulus that is proportional to temperature.

    Raises
    ------
    InputError
        A formula that is none, unknown or unused names, an energy that is not isotropic, is
        not finite at rest, or has no positive shear modulus there.

    See Also
    --------
    NeoHookean : The default.
    LagrangianSystem : A whole system of one's own.

    Notes
    -----
    mu_W is a quarter of the second derivative of W(exp(e), exp(-e), 1) at e = 0, the modulus
    of pure shear, carried through the formula exactly.  Only its text decides the equations:
    with other constants the compiled code is used again.  The energy is computed as it is
    written, so a formula that cancels near rest has that many digits fewer there.

    Examples
    --------
    >>> solid = StrainEnergy("a*(I1 - 3) + b*(I1 - 3)**2", {"a": 50e3, "b": 2e3})
    >>> float(solid.energy(2.0, 1.0, 0.5, solid.parameter_values(), np))
    1.22625
    """

    expression: str
    constants: Mapping[str, float] | Sequence[tuple[str, float]] = ()
    entropic_fraction: float = 1.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {"entropic_fraction": ENTROPIC_FRACTION_RULE}
    )
    mapping_rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {"constants": _checks.finite_rule("It is a constant of the strain energy.")}
    )
    structural_fields: ClassVar[tuple[str, ...]] = ("expression",)
    expand_energy: ClassVar[bool] = False

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls("a*(I1 - 3) + b*(I1 - 3)**2", {"a": 50e3, "b": 2e3})

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_isotropic(self)

    def checked_fields(self) -> Mapping[str, Any]:
        """The formula as it was understood, if its names are known."""
        text: Any = self.expression
        if formula.is_sympy_expression(text):
            text = formula.sympy_as_formula_text(text)
        if not isinstance(text, str):
            raise InputError(
                "expression",
                must="be text or a SymPy expression",
                got=repr(text),
                why="It is a formula for the strain energy.",
                fix="Pass for example 'I1 - 3'.",
            )
        parsed = formula.parse_formula(text)
        _require_names(
            parsed.variable_names, [name for name, _ in self._mapping_pairs()["constants"]]
        )
        return {"expression": parsed.text}

    def derived_numbers(self, p: Mapping[str, Any]) -> Mapping[str, tuple[Any, Rule]]:
        """The energy's own shear modulus at rest."""
        return {
            "the shear modulus at rest": (
                self._energy_in_pure_shear(p, np).second_derivative / 4,
                _MODULUS_RULE,
            )
        }

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = [W(l1, l2, l3) - W(1, 1, 1)]/mu_W."""
        pure_shear = self._energy_in_pure_shear(p, fn)
        return (self._formula(_variables_by_name(l1, l2, l3) | dict(p), fn) - pure_shear.value) / (
            pure_shear.second_derivative / 4
        )

    def admissibility_conditions(
        self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any
    ) -> Sequence[Any]:
        """Arguments of logarithms and roots, and denominators, over their values at rest."""
        unity = formula.as_exact_number(Fraction(1), fn)
        here, rest = (
            _variables_by_name(l1, l2, l3) | dict(p),
            _variables_by_name(unity, unity, unity) | dict(p),
        )
        parts = self._formula.sign_sensitive_parts(_VARIABLE_NAMES, _VARIABLE_NAMES)
        return tuple(part(here, fn) / part(rest, fn) for part in parts)

    @property
    def _formula(self) -> Formula:
        return formula.parse_formula(self.expression)

    def _energy_in_pure_shear(self, p: Mapping[str, Any], fn: Any) -> SecondOrderDual:
        """W and its first two derivatives along pure shear, l1 = exp(e), l2 = exp(-e), at e = 0."""
        unity = formula.as_exact_number(Fraction(1), fn)
        l1 = SecondOrderDual(unity, unity, unity)
        l2 = SecondOrderDual(unity, -unity, unity)
        energy = self._formula(_variables_by_name(l1, l2, unity) | dict(p), DualFunctions(fn))
        if isinstance(energy, SecondOrderDual):
            return energy
        return SecondOrderDual(energy, 0 * unity, 0 * unity)


def _variables_by_name(l1: Any, l2: Any, l3: Any) -> dict[str, Any]:
    squares = [stretch * stretch for stretch in (l1, l2, l3)]
    return {
        **dict(zip(_STRETCH_NAMES, (l1, l2, l3), strict=True)),
        "I1": squares[0] + squares[1] + squares[2],
        "I2": 1 / squares[0] + 1 / squares[1] + 1 / squares[2],
    }


def _require_names(used: frozenset[str], constants: Sequence[str]) -> None:
    taken = [name for name in constants if name in _RESERVED_NAMES]
    if taken:
        raise InputError(
            "constants",
            must="have names of their own",
            got=", ".join(taken),
            why="These mean something else in the formula.",
            fix="Rename them.",
        )
    unknown, unused = sorted(used - _VARIABLE_NAMES - {*constants}), sorted({*constants} - used)
    if unknown:
        raise InputError(
            "expression",
            must=f"hold {', '.join(sorted(_VARIABLE_NAMES))} and names in `constants` only",
            got=", ".join(unknown),
            why="Every other name is a number that must be given.",
            fix=f"Pass constants={{{unknown[0]!r}: ...}}.",
        )
    if unused:
        raise InputError(
            "constants",
            must="occur in the expression",
            got=", ".join(unused),
            why="A number that changes nothing is probably misspelt.",
            fix="Leave it out.",
        )


def _require_isotropic(material: StrainEnergy) -> None:
    """Raise unless the energy is the same for every order of three stretches."""
    p = {name: np.float64(value) for name, value in material.parameter_values().items()}
    for sample in _SAMPLE_STRETCHES:
        with np.errstate(all="ignore"):
            values = [
                float(material.energy(np.float64(l1), np.float64(l2), np.float64(l3), p, np))
                for l1, l2, l3 in permutations(sample)
            ]
        if np.isfinite(values).any() and not np.ptp(values) <= _ISOTROPY_TOLERANCE * (
            1.0 + max(map(abs, values))
        ):
            raise InputError(
                "expression",
                must="be the same when stretches are exchanged",
                got=repr(material.expression),
                why=f"At {sample} in six orders it is between {min(values):g} and {max(values):g}.",
                fix="Add the terms with the other stretches, or write it in I1 and I2.",
            )
