"""What every picture is given: a Dataset, axes, flags, names, and words for Matplotlib."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from matplotlib.axes import Axes

from remanent._arrays import is_quantity
from remanent._calls import require_fitting_arguments
from remanent._checks import require_flag, shortened_repr
from remanent._errors import InputError, error_sentence
from remanent.results.checks import require_dataset

__all__ = ["checked_picture"]

_Arguments = ParamSpec("_Arguments")
_Artists = TypeVar("_Artists")
#: What Matplotlib raises of words that it does not know, or values that these do not have.
_MATPLOTLIB_ERRORS = (
    AttributeError, TypeError, ValueError, KeyError, RuntimeError, ArithmeticError,
)  # fmt: skip
#: Arguments that name what is drawn along an axis.
_DRAWN_ARGUMENTS = frozenset({"variable", "x", "y", "quantity", "parameter"})
#: Those of pictures that draw words too.
_ARGUMENTS_OF_WORDS = {"map": frozenset({"variable"}), "curve": frozenset({"x"})}


def checked_picture(draw: Callable[_Arguments, _Artists]) -> Callable[_Arguments, _Artists]:
    """The picture, whose arguments are checked before anything is drawn.

    Parameters
    ----------
    draw : callable
        A function of a `dataset`, names of variables, axes `ax`, flags, and further words that
        Matplotlib takes.

    Returns
    -------
    callable
        The same function; a bad argument raises :class:`~remanent.InputError`.
    """
    signature = inspect.signature(draw)
    words = next(n for n, p in signature.parameters.items() if p.kind is p.VAR_KEYWORD)

    @wraps(draw)
    def picture(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Artists:
        require_fitting_arguments(draw, args, kwargs)
        given = signature.bind(*args, **kwargs).arguments
        for name, value in given.items():
            if name != words:
                _require_kind(name, value, signature.parameters[name])
        _require_numbers(draw.__name__, given)
        if draw.__name__ == "phase":
            _require_same_dimensions(given, signature)
        _require_no_units(given.get(words, {}))
        try:
            return draw(*args, **kwargs)
        except InputError:
            raise
        except _MATPLOTLIB_ERRORS as error:
            if not given.get(words):
                raise
            raise _unknown_words_error(given[words], draw.__name__, error) from error

    return picture


def _require_kind(name: str, value: object, parameter: inspect.Parameter) -> None:
    """Refuse a value of another kind than the argument's."""
    kind = str(parameter.annotation)
    if name == "dataset":
        require_dataset(name, value)
    elif name == "ax":
        _require_axes(value)
    elif isinstance(parameter.default, bool):
        require_flag(name, value)
    elif kind.startswith("str"):
        several = "Sequence" in kind and isinstance(value, list | tuple) and len(value) > 0
        for entry in list(value) if several else [value]:  # type: ignore[call-overload]
            if not isinstance(entry, str) and not (entry is None and parameter.default is None):
                raise InputError(
                    name,
                    must="name a variable" if "Sequence" not in kind else "name variables",
                    got=shortened_repr(value),
                    why="What is drawn is read from the Dataset by its name.",
                    fix="Pass its name, as in 'thickness_stretch'.",
                )


def _require_numbers(picture: str, given: Mapping[str, Any]) -> None:
    """Refuse a variable of words where numbers are drawn: everywhere but in charts."""
    dataset = given["dataset"]
    for name in sorted(_DRAWN_ARGUMENTS - _ARGUMENTS_OF_WORDS.get(picture, frozenset())):
        variable = given.get(name)
        if not isinstance(variable, str) or variable not in dataset:
            continue
        kind = dataset[variable].dtype
        if kind.kind in "OSU":
            raise InputError(
                name,
                must="be a variable of numbers",
                got=f"{variable!r}, which holds {kind}",
                why="Words have no place on an axis.",
                fix="Pass the name of another, as in 'thickness_stretch'.",
            )


def _require_same_dimensions(given: Mapping[str, Any], signature: inspect.Signature) -> None:
    """Refuse a curve through two variables that do not go together."""
    dataset = given["dataset"]
    names = [given.get(name, signature.parameters[name].default) for name in ("x", "y")]
    if any(name not in dataset for name in names):
        return  # told later
    x, y = (dataset[name].dims for name in names)
    if set(x) != set(y):
        raise InputError(
            "x",
            must=f"have the dimensions of {names[1]}, {', '.join(map(str, y)) or 'none'}",
            got=f"{names[0]!r} along {', '.join(map(str, x)) or 'none'}",
            why="A curve goes through their values one by one.",
            fix="Pass two variables of the state.",
        )


def _require_no_units(words: Mapping[str, Any]) -> None:
    """Refuse quantities among words for Matplotlib, which would drop their units."""
    for name, value in words.items():
        if is_quantity(value):
            raise InputError(
                name,
                must="be plain numbers",
                got=shortened_repr(value),
                why="Matplotlib would drop the unit.",
                fix="Pass the number in points, without a unit.",
            )


def _require_axes(value: object) -> None:
    if value is not None and not isinstance(value, Axes):
        raise InputError(
            "ax",
            must="be Matplotlib axes",
            got=shortened_repr(value),
            why="The picture is drawn in them.",
            fix="Pass what plt.subplots() returns second, or leave it out for a new figure.",
        )


def _unknown_words_error(words: Mapping[str, Any], title: str, error: Exception) -> InputError:
    return InputError(
        ", ".join(words),
        must=f"be an argument of {title}, or one that Matplotlib takes for what it draws",
        got=shortened_repr(dict(words)),
        why=error_sentence(error),
        fix="Check the spelling and the value.",
    )
