"""Calls that name no argument, or too few: told in the words in which bad values are told."""

from __future__ import annotations

from abc import ABCMeta
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from remanent._errors import InputError

if TYPE_CHECKING:
    import inspect

__all__ = ["ExplainedConstruction", "explained", "require_fitting_arguments"]

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


def explained(function: Callable[_Arguments, _Result]) -> Callable[_Arguments, _Result]:
    """The function, whose calls with names that it does not have raise `InputError`."""

    @wraps(function)
    def call(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Result:
        try:
            return function(*args, **kwargs)
        except TypeError:
            require_fitting_arguments(function, args, kwargs)
            raise

    return call


class ExplainedConstruction(ABCMeta):
    """The class of classes whose instances are made by explained calls."""

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        """Make an instance."""
        try:
            return super().__call__(*args, **kwargs)
        except TypeError:
            require_fitting_arguments(cls, args, kwargs)
            raise

    @property
    def __signature__(cls) -> inspect.Signature:
        """That of ``__init__``, without the instance."""
        import inspect  # takes a while, and is seldom needed

        whole = inspect.signature(cls.__init__)  # type: ignore[misc]  # of this very class
        return whole.replace(parameters=list(whole.parameters.values())[1:])


def require_fitting_arguments(
    function: Callable[..., Any], args: Sequence[Any], kwargs: Mapping[str, Any]
) -> None:
    """Raise unless the arguments of a call are those that the function has.

    Parameters
    ----------
    function : callable
        A function or a class.
    args, kwargs
        Arguments by position and by name.

    Raises
    ------
    InputError
        An unknown name, an argument too many, given twice, or missing.
    """
    import inspect  # takes a while, and is seldom needed

    parameters = inspect.signature(function).parameters
    kind, title = inspect.Parameter, function.__name__
    named = [
        n for n, p in parameters.items() if p.kind not in {kind.VAR_KEYWORD, kind.VAR_POSITIONAL}
    ]
    by_position = [
        n for n in named
        if parameters[n].kind in {kind.POSITIONAL_ONLY, kind.POSITIONAL_OR_KEYWORD}
    ]  # fmt: skip
    takes_any_name = any(p.kind is kind.VAR_KEYWORD for p in parameters.values())
    takes_more = any(p.kind is kind.VAR_POSITIONAL for p in parameters.values())
    for name in kwargs:
        if name not in named and not takes_any_name:
            raise _unknown_argument_error(name, title, named)
        if name in by_position[: len(args)]:
            raise InputError(
                name,
                must="be given once",
                got="a value by position and one by name",
                why="One of them would be lost.",
                fix=f"Leave one of them out of {title}(...).",
            )
    if len(args) > len(by_position) and not takes_more:
        last = ", ".join(by_position) or "none"
        raise InputError(
            title,
            must=f"have at most {len(by_position)} arguments by position: {last}",
            got=f"{len(args)} of them",
            why="The others are given by name, so that they cannot be mistaken.",
            fix="Write the name of each further argument before its value, as in name=value.",
        )
    for name in named:
        missing = parameters[name].default is kind.empty and name not in kwargs
        if missing and name not in by_position[: len(args)]:
            raise InputError(
                name,
                must=f"be given to {title}",
                got="nothing",
                why="It has no usual value.",
                fix=f"Write {title}(..., {name}=...).",
            )


def _unknown_argument_error(name: str, title: str, known: Sequence[str]) -> InputError:
    from difflib import get_close_matches  # takes longer than the rest of the import

    closest = get_close_matches(name, known, n=1)
    meant = f"Did you mean `{closest[0]}`? " if closest else ""
    return InputError(
        name,
        must=f"be an argument of {title}",
        got=f"{name}=...",
        why="Unknown names are refused so that a misspelling does not go unnoticed.",
        fix=f"{meant}{_choose_argument(known)}",
    )


def _choose_argument(known: Sequence[str]) -> str:
    return f"Pass one of its arguments: {', '.join(known)}." if known else "Leave it out."
