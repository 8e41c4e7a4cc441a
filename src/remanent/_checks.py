"""Rules for arguments, written once for a single value and for a whole batch."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from numbers import Real
from typing import Any, TypeGuard

import numpy as np

from remanent._arrays import as_float_array, is_increasing, remedy_for_kind, without_wrapping
from remanent._errors import InputError, shortened_repr
from remanent._typing import ArrayLike, BoolArray, FloatArray

__all__ = [
    "Rule",
    "as_dict",
    "as_float_array",
    "finite_rule",
    "is_increasing",
    "is_integer",
    "is_positive_number",
    "not_negative_rule",
    "positive_rule",
    "require_choice",
    "require_field_names",
    "require_flag",
    "require_increasing",
    "require_instance",
    "require_known_names",
    "require_mapping",
    "require_named_numbers",
    "require_numbers",
    "require_real",
    "shortened_repr",
    "where_rule_broken",
]


@dataclass(frozen=True)
class Rule:
    """What a real number must satisfy, and what to tell whoever breaks it.

    Attributes
    ----------
    must, why, fix
        Parts of the message of :class:`~remanent._errors.InputError`.
    holds_for_finite
        Elementwise on an array of floats: whether each satisfies the rule.  It may
        assume that the numbers are finite, which every rule demands.
    """

    must: str
    holds_for_finite: Callable[[FloatArray], BoolArray]
    why: str
    fix: str

    def is_satisfied_by(self, values: ArrayLike) -> BoolArray:
        """Elementwise: whether each of `values` is finite and satisfies the rule."""
        array = np.asarray(values, dtype=np.float64)
        finite = np.isfinite(array)
        return np.asarray(finite & self.holds_for_finite(np.where(finite, array, 0.0)))


def finite_rule(reason: str, remedy: str = "Pass a finite number.") -> Rule:
    """The rule that every finite number satisfies."""
    return Rule("be a finite number", lambda x: np.ones_like(x, dtype=np.bool_), reason, remedy)


def positive_rule(reason: str, remedy: str) -> Rule:
    """The rule that finite numbers above zero satisfy."""
    return Rule("be a finite number greater than 0", lambda x: x > 0, reason, remedy)


def not_negative_rule(reason: str, remedy: str) -> Rule:
    """The rule that zero and finite numbers above it satisfy."""
    return Rule("be a finite number, at least 0", lambda x: x >= 0, reason, remedy)


def require_real(name: str, value: object, rule: Rule) -> float:
    """`value` as a float, if it is one real number that satisfies `rule`.

    Raises
    ------
    InputError
        If it is not one real number, or breaks the rule.
    """
    content = without_wrapping(value)
    if isinstance(content, np.ndarray) and content.ndim == 0 and not np.ma.is_masked(content):
        content = content.item()  # of a result, for example
    no_number = (bool, np.bool_, np.timedelta64)
    if isinstance(content, no_number) or not isinstance(content, Real):
        raise InputError(
            name,
            must="be one real number",
            got=shortened_repr(value),
            why="It is one value, without a unit.",
            fix=remedy_for_kind(content)
            or "Pass a plain number; many values of a field go into over={...}.",
        )
    number = _to_float(content)
    if not rule.is_satisfied_by(number):
        raise InputError(name, must=rule.must, got=content, why=rule.why, fix=rule.fix)
    return number


def _to_float(value: Real) -> float:
    try:
        return float(value)
    except OverflowError:
        return float("inf")


def require_instance(name: str, value: object, kind: type, example: str) -> None:
    """Raise unless `value` is a `kind`, proposing `example`."""
    if isinstance(value, kind):
        return
    got, fix = shortened_repr(value), f"Pass for example {example}."
    if isinstance(value, type):
        got = f"the class {value.__name__} itself"
        if issubclass(value, kind):
            fix = f"Write {value.__name__}(...), with its numbers in the brackets."
    raise InputError(
        name,
        must=f"be {'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}",
        got=got,
        why="The equations of motion are built from this part.",
        fix=fix,
    )


def is_integer(value: object) -> TypeGuard[int]:
    """Whether this is an integer of Python or NumPy: no truth value, and no length of time."""
    no_integer = isinstance(value, bool | np.bool_ | np.timedelta64)
    return isinstance(value, int | np.integer) and not no_integer


def is_positive_number(value: object) -> bool:
    """Whether this is one finite number above 0."""
    is_number = isinstance(value, Real) and not isinstance(value, bool | np.bool_ | np.timedelta64)
    return is_number and 0.0 < _to_float(value) < float("inf")  # type: ignore[arg-type]


def require_choice(name: str, value: object, choices: Sequence[str]) -> str:
    """`value` if it is one of `choices`; otherwise raise, naming them."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(
            name,
            must=f"be one of {', '.join(map(repr, choices))}",
            got=shortened_repr(value),
            why="Nothing else is defined.",
            fix=f"Pass {_closest_choice(value, choices)!r}, for example.",
        )
    return value


def _closest_choice(value: object, choices: Sequence[str]) -> str:
    """The choice that was most likely meant, or else the first."""
    text = value if isinstance(value, str) else ""
    return next(iter(get_close_matches(text, choices, n=1)), choices[0])


def require_known_names(names: Iterable[str], known: Iterable[str], owner: str) -> None:
    """Raise if one of `names` is not among the `known` fields of `owner`."""
    fields = list(known)
    for name in names:
        if not isinstance(name, str) or name not in fields:
            closest = get_close_matches(str(name), fields, n=1)
            meant = f"Did you mean `{closest[0]}`? " if closest else ""
            listed = f"Name one of its fields: {', '.join(fields)}." if fields else "Leave it out."
            raise InputError(
                name if isinstance(name, str) else "name",
                must=f"be a field of {owner}",
                got=shortened_repr(name),
                why="Unknown fields are refused so that a misspelling does not go unnoticed.",
                fix=f"{meant}{listed}",
            )


def require_field_names(name: str, value: object, known: Iterable[str], owner: str) -> list[str]:
    """Names of numeric fields, at least one, of which a single one may stand by itself.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : str, or iterable of str
        What was passed for it.
    known : iterable of str
        Names that there are.
    owner : str
        What has these names, as in "the actuator".
    """
    names = [value] if isinstance(value, str) else value
    fields = list(known)
    message = {
        "why": "Only fields that enter the equations can be chosen.",
        "fix": f"Name some of its fields: {', '.join(fields)}.",
    }
    is_scalar = getattr(names, "ndim", 1) == 0  # iterable by its type only
    entries: list[str] = []
    for entry in names if isinstance(names, Iterable) and not is_scalar else ():
        if not isinstance(entry, str) or entry not in fields:
            raise InputError(
                name, must=f"name fields of {owner}", got=shortened_repr(entry), **message
            )
        entries.append(entry)
    if not entries:
        raise InputError(
            name, must=f"name fields of {owner}, at least one", got=shortened_repr(value), **message
        )
    return entries


def require_mapping(name: str, value: object, *, what: str, fix: str) -> Mapping[Any, Any]:
    """`value` if it is a mapping, whose keys and values are `what`."""
    if not isinstance(value, Mapping):
        raise InputError(
            name,
            must=f"be a mapping of {what}",
            got=shortened_repr(value),
            why="What is not named keeps its usual value.",
            fix=fix,
        )
    return value


def require_flag(name: str, value: object) -> bool:
    """`value` if it is True or False."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(
            name,
            must="be True or False",
            got=shortened_repr(value),
            why="It switches a part of the work on.",
            fix="Pass True or False.",
        )
    return bool(value)


def require_numbers(name: str, values: object, *, what: str, why: str) -> FloatArray:
    """`values` as an array (entry,) of at least one finite float.

    Parameters
    ----------
    name : str
        Name of the argument.
    values : array_like
        What was passed for it.
    what, why : str
        What they are, in the plural, and a sentence on why they are needed.
    """
    return as_float_array(
        name,
        values,
        what=what,
        why=why,
        fix="Pass a list or a one-dimensional array without NaN.",
        ndim=1,
        least=1,
        finite=True,
    )


def as_dict(value: object) -> dict[Any, Any] | None:
    """A mapping, or its pairs, as a dict; None where it is neither."""
    try:
        return dict(value)  # type: ignore[call-overload, no-any-return]
    except Exception:  # an object of a class of its own ways too
        return None


def require_named_numbers(name: str, values: object, rule: Rule) -> tuple[tuple[str, float], ...]:
    """A mapping of names to numbers, or its pairs, as a tuple of pairs."""
    pairs = as_dict(values)
    for key in [None] if pairs is None else pairs:
        if not (isinstance(key, str) and key.isascii() and key.isidentifier()):
            raise InputError(
                name,
                must="be a mapping of names to numbers",
                got=shortened_repr(values),
                why="Each number is a field of the model, under its name.",
                fix='Pass for example {"a": 0.5}.',
            )
    return tuple((key, require_real(key, value, rule)) for key, value in (pairs or {}).items())


def require_increasing(name: str, values: object, *, what: str, why: str) -> FloatArray:
    """`values` as an array (entry,) of finite floats, each greater than the one before.

    Parameters
    ----------
    name : str
        Name of the argument.
    values : array_like
        What was passed for it.
    what, why : str
        What they are, in the plural, and a sentence on why they are needed.
    """
    numbers = require_numbers(name, values, what=what, why=why)
    if not is_increasing(numbers):
        raise InputError(
            name,
            must="increase from each entry to the next",
            got=shortened_repr(numbers.tolist()),
            why="Unsorted or repeated entries have no unique meaning.",
            fix="Sort them and remove duplicates.",
        )
    return numbers


def where_rule_broken(rules: Mapping[str, Rule], values: Mapping[str, ArrayLike]) -> BoolArray:
    """Where a batch of parameter values breaks a rule.

    Parameters
    ----------
    rules
        Rule of each parameter, by name.
    values
        Values by name, arrays that broadcast against each other.

    Returns
    -------
    array of bool
        True where at least one of the values is not finite or breaks its rule.
    """
    invalid = np.zeros((), dtype=np.bool_)
    for name, value in values.items():
        if name in rules:
            invalid = invalid | ~rules[name].is_satisfied_by(value)
    return np.asarray(invalid)
