"""What all systems have in common whose equations a user writes as formulas."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from dataclasses import replace as replace_fields
from functools import reduce
from typing import Any, ClassVar, Final, Self

import numpy as np

from remanent import _checks
from remanent._calls import ExplainedConstruction
from remanent._checks import Rule
from remanent._errors import InputError
from remanent._typing import ArrayLike, BoolArray
from remanent.models import formula
from remanent.models.formula import Formula
from remanent.models.own_systems.names import RATE_SUFFIX, require_names
from remanent.models.parts import EquationStructure
from remanent.models.scaling import Scales
from remanent.models.shown import ShownInNotebook
from remanent.models.variable_text import VariableText

#: A mapping of names, or its pairs, as it is kept.
Pairs = Mapping[str, Any] | Sequence[tuple[str, Any]]
#: Name under which an observable is found that is no state variable by itself.
OBSERVABLE_NAME: Final = "observable"
#: Largest number of coordinates, or of state variables of first order.
MAX_COORDINATES: Final = 8
#: The rule of every number of a system of one's own.
NUMBER_RULE: Final = _checks.finite_rule("It enters the equations of motion.")
#: Names that are written as the letter, as text.
_GREEK_TEXT: Final = """
    alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma phi chi psi
    Gamma Delta Theta Lambda Xi Sigma Phi Psi Omega
"""
#: These names.
_GREEK_LETTERS: Final = frozenset(_GREEK_TEXT.split())
#: Largest number of characters of a unit or a symbol.
_MAX_LABEL_CHARACTERS: Final = 60


@dataclass(frozen=True)
class WrittenSystem(ShownInNotebook, metaclass=ExplainedConstruction):
    """A system in formulas; a subclass says which there are and what they mean.

    A subclass is a frozen dataclass with the fields ``parameters``, ``observable``, ``rest``,
    ``loads``, ``units`` and ``symbols``, and fields with formulas.
    """

    #: Fields that are kept as pairs of a name and a value.
    mapping_fields: ClassVar[tuple[str, ...]] = ("parameters", "rest", "units", "symbols")
    #: Nothing of it has a physical size: its numbers are in the user's own units.
    scales: ClassVar[Scales | None] = None

    # What a subclass says -----------------------------------------------------------------

    @property
    @abstractmethod
    def state_names(self) -> tuple[str, ...]:
        """Names of the state variables, in the order of the state."""

    @abstractmethod
    def formulas(self) -> Mapping[str, Formula]:
        """Every formula by the name of its argument, without the observable."""

    @abstractmethod
    def _coordinate_names(self) -> tuple[str, ...]:
        """Names of the state variables that are no rates."""

    @property
    @abstractmethod
    def conservative(self) -> bool:
        """Whether there is nothing in the equations by which energy could be lost."""

    @abstractmethod
    def where_dissipative(self, values: Mapping[str, ArrayLike] | None = None) -> BoolArray:
        """Whether motion loses or gains energy."""

    # What follows -------------------------------------------------------------------------

    @property
    def load_names(self) -> tuple[str, ...]:
        """Names of the loads that a drive has to give."""
        return tuple(self._own("loads"))

    @property
    def observable_name(self) -> str:
        """Under which name the observable is found: its own where it is a state variable."""
        text = self.observable_formula.text
        return text if text in self.state_names else OBSERVABLE_NAME

    @property
    def observable_formula(self) -> Formula:
        """The quantity whose extremes are followed."""
        return formula.parse_formula(self._own("observable"), "observable")

    def rest_values(self) -> dict[str, float]:
        """Value of each state variable at rest."""
        given = dict(self._own("rest"))
        return {name: given.get(name, 0.0) for name in self.state_names}

    def parameter_values(self) -> dict[str, float]:
        """Value of every numeric field by name."""
        return {name: float(value) for name, value in self._own("parameters")}

    def parameter_rules(self) -> dict[str, Rule]:
        """Rule of every numeric field by name: any finite number."""
        return dict.fromkeys(self.parameter_values(), NUMBER_RULE)

    def equation_structure(self) -> EquationStructure:
        """What identifies the equations: the class, names, formulas and values at rest."""
        kind = type(self)
        return (
            f"{kind.__module__}:{kind.__qualname__}",
            *("state", *self.rest_values().items()),
            *("parameters", *self.parameter_values()),
            *("loads", *self.load_names),
            *((name, one.text) for name, one in self.formulas().items()),
            ("observable", self.observable_formula.text),
        )

    def where_invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a batch of values of numeric fields breaks a rule."""
        return _checks.where_rule_broken(self.parameter_rules(), values)

    def sign_conditions(self) -> list[Formula]:
        """Parts of the formulas whose sign must stay what it is at rest.

        Factors of arguments of logarithms and roots, of bases of fractional and negative
        powers, and of denominators, in which a state variable occurs.
        """
        states, positive = frozenset(self.state_names), frozenset[str]()
        parts = {
            factor.text: factor
            for one in self.formulas().values()
            for part in one.sign_sensitive_parts(states, positive)
            for factor in part.factors()
            if factor.variable_names & states
        }
        return list(parts.values())

    def where_admissible(
        self, values: Mapping[str, ArrayLike], *coordinates: ArrayLike
    ) -> BoolArray:
        """Where every logarithm, root and denominator has the sign that it has at rest.

        Loads are 0 here; those that vary are looked at where the motion is.

        Parameters
        ----------
        values : mapping of name to array
            Numeric fields; those that are missing have the system's own value.
        *coordinates : array
            One array for each coordinate, in the order of the field.
        """
        arrays = [np.asarray(x, dtype=np.float64) for x in coordinates]
        everywhere = np.ones(np.broadcast_shapes(*(x.shape for x in arrays)), dtype=np.bool_)
        p = {k: np.asarray(values.get(k, v)) for k, v in self.parameter_values().items()}
        nothing = dict.fromkeys((*self.load_names, *self.rate_names()), 0.0)
        rest = {**nothing, **p, **self.rest_values()}
        here = {**rest, **dict(zip(self._coordinate_names(), arrays, strict=False))}
        with np.errstate(all="ignore"):
            met = [
                np.asarray(part(here, np) * part(rest, np) > 0.0) for part in self.sign_conditions()
            ]
        return np.asarray(reduce(np.logical_and, met, everywhere))

    def describe_coordinate_limits(self) -> str:
        """What limits the coordinates, as a noun in a message."""
        parts = ", ".join(part.text for part in self.sign_conditions())
        return f"where {parts or 'the energies'} would change sign"

    def warn_if_implausible(self, values: Mapping[str, ArrayLike]) -> None:
        """Nothing is known to be implausible."""

    def needs_load_rate(
        self, values: Mapping[str, ArrayLike], varied: Collection[str] = ()
    ) -> bool:
        """Whether the rates of the loads enter: where the observable's own rate has a load."""
        return bool(self._names_in_observable_rate() & {*self.load_names})

    @abstractmethod
    def _names_in_observable_rate(self) -> frozenset[str]:
        """Names on which the rate of the observable may depend."""

    def variable_texts(self) -> dict[str, VariableText]:
        """Unit, meaning and symbol of every variable that is the user's own."""
        units, symbols = dict(self._own("units")), dict(self._own("symbols"))
        names = [*self.state_names, *self.parameter_values(), *self.load_names, OBSERVABLE_NAME]
        names += [f"{self.observable_name}{RATE_SUFFIX}", f"mean_{self.observable_name}"]
        names += [name for name in (*units, *symbols) if name not in names]
        texts = {
            name: VariableText(
                units.get(name, self._default_units(name, units)),
                name.replace("_", " "),
                symbols.get(name, self._default_symbol(name, symbols)),
            )
            for name in names
        }
        return {**texts, OBSERVABLE_NAME: texts[self.observable_name]}

    def _default_units(self, name: str, units: Mapping[str, str]) -> str:
        return "1"

    def _default_symbol(self, name: str, symbols: Mapping[str, str]) -> str:
        letter, _, index = name.partition("_")
        if len(letter) > 1:
            letter = f"\\{letter}" if letter in _GREEK_LETTERS else rf"\mathrm{{{letter}}}"
        return rf"{letter}_{{\mathrm{{{index.replace('_', ' ')}}}}}" if index else letter

    # Copies -------------------------------------------------------------------------------

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed.

        Mappings are merged with what they were: ``replace(parameters={"delta": 0.2})`` keeps
        the other parameters.
        """
        _checks.require_known_names(changes, [f.name for f in fields(self)], type(self).__name__)
        for name in self.mapping_fields:
            if isinstance(changes.get(name), Mapping):
                changes[name] = {**dict(self._own(name)), **changes[name]}
        return replace_fields(self, **changes)

    def with_parameter(self, name: str, value: float) -> Self:
        """A copy with one numeric field changed."""
        _checks.require_known_names([name], self.parameter_values(), "the system")
        return self.replace(parameters={name: value})

    # Checks -------------------------------------------------------------------------------

    def _own(self, name: str) -> Any:
        """The value of a field of the subclass."""
        return getattr(self, name)

    def _keep(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check_names_and_numbers(self, states: Sequence[str]) -> None:
        """Normalise and check everything but the formulas; `states` are checked names."""
        loads = names_in_sequence("loads", self._own("loads"))
        require_loads(loads, states)
        self._keep("loads", loads)
        pairs = _checks.require_named_numbers("parameters", self._own("parameters"), NUMBER_RULE)
        require_names("parameters", (k for k, _ in pairs), taken=(*states, *loads))
        self._keep("parameters", pairs)
        rest = _checks.require_named_numbers("rest", self._own("rest"), NUMBER_RULE)
        require_known("rest", (k for k, _ in rest), states, "state variables")
        self._keep("rest", rest)

    def _check_labels(self) -> None:
        known = [*self.state_names, *self.parameter_values(), *self.load_names]
        known += [OBSERVABLE_NAME, "energy", "time"]
        for name in ("units", "symbols"):
            pairs = named_texts(name, self._own(name))
            require_known(name, (k for k, _ in pairs), known, "variables")
            self._keep(name, pairs)

    def _check_formulas(self, known: Mapping[str, Iterable[str]]) -> None:
        """Raise where a formula has a name that it may not have.

        Parameters
        ----------
        known
            For each formula the names that it may have, beside those of parameters.
        """
        parameters = self.parameter_values()
        used: set[str] = set(self.observable_formula.variable_names)
        for name, one in {**self.formulas(), "observable": self.observable_formula}.items():
            require_formula_names(name, one, [*known[name], *parameters])
            used |= one.variable_names
        unused = [name for name in parameters if name not in used]
        if unused:
            raise InputError(
                "parameters",
                must="occur in a formula",
                got=", ".join(unused),
                why="A number that changes nothing is probably misspelt.",
                fix="Leave it out, or use it.",
            )
        self._require_finite_at_rest()

    def _require_finite_at_rest(self) -> None:
        values = {name: np.float64(x) for name, x in self.rest_values().items()}
        values |= dict.fromkeys(self.load_names, np.float64(0.0))
        values |= {name: np.float64(x) for name, x in self.parameter_values().items()}
        values |= dict.fromkeys(self.rate_names(), np.float64(0.0))
        for name, one in {**self.formulas(), "observable": self.observable_formula}.items():
            with np.errstate(all="ignore"):
                value = float(one(values, np))
            if not np.isfinite(value):
                raise InputError(
                    name,
                    must="be finite at rest",
                    got=f"{value:g} at {_text_of(self.rest_values())}",
                    why="Motions start there unless `initial` says otherwise.",
                    fix="Pass rest={...} with a state at which everything is finite.",
                )

    def rate_names(self) -> tuple[str, ...]:
        """Names of rates that formulas may have and that are no state variables."""
        return ()


def read_formula(argument: str, value: object) -> str:
    """The text of a formula: as it was understood, from text, a number or a SymPy expression."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        value = repr(value)
    if formula.is_sympy_expression(value):
        value = formula.sympy_as_formula_text(value, argument)
    if not isinstance(value, str):
        raise InputError(
            argument,
            must="be text or a SymPy expression",
            got=_checks.shortened_repr(value),
            why="It is a formula.",
            fix="Pass for example 'x**2/2'.",
        )
    return formula.parse_formula(value, argument).text


def require_formula_names(argument: str, one: Formula, known: Sequence[str]) -> None:
    """Raise where a formula has a name that stands for nothing in it."""
    unknown = sorted(one.variable_names - {*known})
    if unknown:
        raise InputError(
            argument,
            must=f"hold {', '.join(known)} only",
            got=", ".join(unknown),
            why="Every other name is a number that must be given.",
            fix=f"Pass parameters={{{unknown[0]!r}: ...}}, or correct the name.",
        )


def names_in_sequence(argument: str, value: object) -> tuple[str, ...]:
    """One name, or several in a sequence, as a tuple."""
    if isinstance(value, str):
        return (value,)
    if not isinstance(value, Sequence) or not 0 < len(value) <= MAX_COORDINATES:
        raise InputError(
            argument,
            must=f"be one to {MAX_COORDINATES} names",
            got=_checks.shortened_repr(value),
            why="Each is a variable of the system.",
            fix="Pass for example ('x',).",
        )
    return tuple(value)


def _is_load(name: object) -> bool:
    return isinstance(name, str) and name == "load"


def require_loads(loads: Sequence[str], states: Sequence[str]) -> None:
    """Raise unless loads have names; ``load`` is one that they may have."""
    require_names("loads", (name for name in loads if not _is_load(name)), taken=states)
    if len({*loads}) < len(loads):
        raise InputError(
            "loads", must="have names of their own", got=", ".join(loads),
            why="Each has a law in time.", fix="Rename one of them.",
        )  # fmt: skip


def require_known(argument: str, names: Iterable[str], known: Sequence[str], what: str) -> None:
    """Raise where a name is not among those that there are."""
    for name in names:
        if name not in known:
            raise InputError(
                argument,
                must=f"name {what} only",
                got=repr(name),
                why="A name that means nothing is probably misspelt.",
                fix=f"Name one of: {', '.join(known)}.",
            )


def named_texts(argument: str, value: object) -> tuple[tuple[str, str], ...]:
    """A mapping of names to short texts, as pairs."""
    given = _checks.as_dict(value)
    pairs: dict[Any, Any] = {None: None} if given is None else given
    for key, text in pairs.items():
        if not (isinstance(key, str) and isinstance(text, str)) or (
            len(text) > _MAX_LABEL_CHARACTERS
        ):
            raise InputError(
                argument,
                must=f"be a mapping of names to text of at most {_MAX_LABEL_CHARACTERS} characters",
                got=_checks.shortened_repr(value),
                why="It labels results.",
                fix='Pass for example {"x": "m"}.',
            )
    return tuple(pairs.items())


def _text_of(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in values.items())
