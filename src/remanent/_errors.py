"""The exceptions that this package raises, one family."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from typing import Final

#: Packages between a call of this one and the warning: itself, and what makes its values.
_OWN_PACKAGES: Final = frozenset({"remanent", "dataclasses"})
#: What to do about what only a mistake in this package leads to.
FAULT: Final = "Report this as a fault of remanent."
#: Longest rule that a message states, in characters; some list the names that there are.
_MAX_RULE_CHARACTERS: Final = 1500
#: Longest value that a message shows, in characters.
_MAX_SHOWN_CHARACTERS: Final = 200


class RemanentError(Exception):
    """Base of every exception this package raises on purpose.

    See Also
    --------
    InputError : An argument breaks a rule.

    Examples
    --------
    >>> issubclass(InputError, RemanentError)
    True
    """


class InputError(RemanentError, ValueError):
    """An argument breaks a rule.

    Parameters
    ----------
    name : str
        Name of the argument, with the entry in brackets where it is one of many:
        ``over['omega']``, ``initial[2]``.
    must : str
        The rule, as the verb that follows "must".
    got : object
        The value received.
    why : str
        The reason for the rule, a sentence.
    fix : str
        The remedy, a sentence.  An argument it names stands in backticks.

    See Also
    --------
    RemanentError : The base of every exception of the package.
    Status : What a point of a grid carries in its place.

    Examples
    --------
    >>> import remanent as rm
    >>> try:
    ...     rm.Actuator(c=-1.0)
    ... except InputError as error:
    ...     print(error.name, "|", error.fix)
    c | Pass 1 for a cube, less for a film.
    """

    def __init__(self, name: str, *, must: str, got: object, why: str, fix: str) -> None:
        self.name, self.must, self.got, self.why, self.fix = name, must, got, why, fix
        shown = _shortened(_text(got), _MAX_SHOWN_CHARACTERS)
        rule = _shortened(must, _MAX_RULE_CHARACTERS)
        super().__init__(f"`{_shortened(name, 80)}` must {rule}; got {shown}. {why} {fix}")

    def __reduce__(self) -> tuple[Callable[..., InputError], tuple[str, ...]]:
        """Keywords do not survive pickling by themselves, as workers of a pool need."""
        return _restore_input_error, (self.name, self.must, _text(self.got), self.why, self.fix)


def _restore_input_error(name: str, must: str, got: str, why: str, fix: str) -> InputError:
    return InputError(name, must=must, got=got, why=why, fix=fix)


def shortened_repr(values: object) -> str:
    """`values` as they are written, on one line of at most 80 characters."""
    try:
        text = repr(values)
    except Exception:  # an integer of more digits than Python writes, or a class of its own ways
        text = f"a {type(values).__name__} that cannot be written"
    return _shortened(text, 80)


def error_sentence(error: Exception) -> str:
    """What an error of another package says, as a short sentence on one line."""
    said = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"{_shortened(said, _MAX_SHOWN_CHARACTERS).rstrip('.') or type(error).__name__}."


def _shortened(text: str, length: int) -> str:
    """A text on one line of at most so many characters."""
    line = " ".join(text[: 10 * length].split())
    return line if len(line) <= length else f"{line[: length - 3]}..."


def _text(value: object) -> str:
    try:
        return str(value)
    except Exception:
        return shortened_repr(value)


class InputWarning(UserWarning):
    """An argument is allowed but looks like a mistake.

    See Also
    --------
    InputError : An argument that is not allowed.

    Examples
    --------
    A temperature in degrees Celsius looks like a mistake:

    >>> import remanent as rm
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     cold = rm.Actuator(temperature=25.0)
    >>> caught[0].category.__name__
    'InputWarning'
    """


def warn_of_input(message: str) -> None:
    """Warn of an argument, at the line of the caller's own code that passed it."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and _is_own_code(frame.f_globals.get("__name__", "")):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, InputWarning, stacklevel=level)


def _is_own_code(module_name: str) -> bool:
    """Whether a module belongs to this package, or carries one of its calls on."""
    return module_name.partition(".")[0] in _OWN_PACKAGES
