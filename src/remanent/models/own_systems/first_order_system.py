"""A system of one's own of first order, by its rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from remanent._checks import as_dict
from remanent._errors import InputError, shortened_repr
from remanent._typing import ArrayLike, BoolArray
from remanent.models import formula
from remanent.models.formula import Formula
from remanent.models.own_systems.names import RATE_SUFFIX, require_names
from remanent.models.own_systems.written_system import (
    MAX_COORDINATES,
    Pairs,
    WrittenSystem,
    read_formula,
)


@dataclass(frozen=True, kw_only=True)
class FirstOrderSystem(WrittenSystem):
    """A system of first order, by the rate of each of its state variables.

    Parameters
    ----------
    rates : mapping of str to str or SymPy expression
        Formula of the rate of each state variable, by its name, in states, parameters and
        loads; the order is that of the state.
    parameters : mapping of str to float
        Values of the other names in the formulas: numeric fields, which ``over``,
        continuation, sensitivities and fits may vary.
    observable : str or SymPy expression, optional
        The quantity whose extremes are followed, a formula in states and parameters: the
        first state variable by default.
    rest : mapping of str to float
        State from which motions start by default; what is not named is 0.
    loads : str or sequence of str
        Names of the loads, which a drive gives; one, ``load``, by default.  A system without
        a load takes ``rm.Constant(0)``.
    units, symbols : mapping of str to str
        Units (UDUNITS) and symbols (LaTeX) of states, parameters, loads, ``observable`` and
        ``time``, by name, for labels.

    Raises
    ------
    InputError
        A formula that is none, or unknown, reserved or unused names.

    See Also
    --------
    LagrangianSystem : A mechanical system, by its energies.
    equations : The equations as formulas.

    Notes
    -----
    Formulas are as for :class:`~remanent.LagrangianSystem`.  There is no energy: verbs that
    need one refuse such a system.

    Examples
    --------
    >>> lorenz = FirstOrderSystem(
    ...     rates={"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"},
    ...     parameters={"sigma": 10.0, "rho": 28.0, "beta": 8 / 3},
    ...     observable="z",
    ...     rest={"x": 1.0, "y": 1.0, "z": 27.0},
    ... )
    >>> lorenz.state_names
    ('x', 'y', 'z')
    """

    rates: Pairs
    parameters: Pairs = ()
    observable: Any = None
    rest: Pairs = ()
    loads: str | Sequence[str] = ("load",)
    units: Pairs = ()
    symbols: Pairs = ()

    mapping_fields: ClassVar[tuple[str, ...]] = (
        "rates", "parameters", "rest", "units", "symbols",
    )  # fmt: skip

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers: van der Pol's oscillator with a force."""
        return cls(rates={"x": "v", "v": "mu*(1 - x**2)*v - x + load"}, parameters={"mu": 0.2})

    def __post_init__(self) -> None:
        given = as_dict(self.rates) or {}
        if not 0 < len(given) <= MAX_COORDINATES:
            raise InputError(
                "rates",
                must=f"be a mapping of one to {MAX_COORDINATES} names to formulas",
                got=shortened_repr(self.rates),
                why="Each state variable has a rate.",
                fix='Pass for example {"x": "v", "v": "-x + load"}.',
            )
        require_names("rates", given)
        self._keep(
            "rates", tuple((k, read_formula(f"rates[{k!r}]", one)) for k, one in given.items())
        )
        names = tuple(given)
        self._keep(
            "observable",
            read_formula("observable", names[0] if self.observable is None else self.observable),
        )
        self._check_names_and_numbers(names)
        known = dict.fromkeys(self.formulas(), (*names, *self.load_names))
        self._check_formulas({**known, "observable": names})
        self._check_labels()
        self._require_rate_names()

    def _require_rate_names(self) -> None:
        """A state variable with the name of the observable's rate must be that rate."""
        name, texts = self.observable_name, dict(self.rates)
        rate_name = f"{name}{RATE_SUFFIX}"
        if rate_name in texts and texts.get(name) != rate_name:
            raise InputError(
                "rates",
                must=f"give {name} the rate {rate_name}, or call that state by another name",
                got=repr(texts.get(name)),
                why=f"Results call the rate of {name} {rate_name}.",
                fix=f"Rename {rate_name}.",
            )

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the state variables, in order."""
        return tuple(dict(self.rates))

    def _coordinate_names(self) -> tuple[str, ...]:
        return self.state_names

    def formulas(self) -> Mapping[str, Formula]:
        """The rate of each state variable."""
        return {
            f"rates[{name!r}]": formula.parse_formula(text, f"rates[{name!r}]")
            for name, text in dict(self.rates).items()
        }

    @property
    def conservative(self) -> bool:
        """Nothing is known of an energy."""
        return False

    @property
    def is_time_reversible(self) -> bool:
        """Nothing is known of a symmetry in time."""
        return False

    def where_dissipative(self, values: Mapping[str, ArrayLike] | None = None) -> BoolArray:
        """Nothing says that phase volume is kept."""
        return np.ones((), dtype=np.bool_)

    def _names_in_observable_rate(self) -> frozenset[str]:
        texts = dict(zip(self.state_names, self.formulas().values(), strict=True))
        names = self.observable_formula.variable_names & {*self.state_names}
        return frozenset[str]().union(*(texts[name].variable_names for name in names))
