"""The exceptions that this package raises, one family."""

from __future__ import annotations

from collections.abc import Callable


class RemanentError(Exception):
    """Base of every exception this package raises on purpose."""


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
    """

    def __init__(self, name: str, *, must: str, got: object, why: str, fix: str) -> None:
        self.name, self.must, self.got, self.why, self.fix = name, must, got, why, fix
        super().__init__(f"`{name}` must {must}; got {got}. {why} {fix}")

    def __reduce__(self) -> tuple[Callable[..., InputError], tuple[str, ...]]:
        """Keywords do not survive pickling by themselves, as workers of a pool need."""
        return _restore_input_error, (self.name, self.must, str(self.got), self.why, self.fix)


def _restore_input_error(name: str, must: str, got: str, why: str, fix: str) -> InputError:
    return InputError(name, must=must, got=got, why=why, fix=fix)


class InputWarning(UserWarning):
    """An argument is allowed but looks like a mistake."""
