"""Messages about arguments that a verb takes in a form of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from remanent._errors import InputError


@contextmanager
def rename_arguments_in_errors(arguments: Mapping[str, str]) -> Iterator[None]:
    """Give errors the names that the verb's own arguments have.

    Some verbs add what they are given to the values of ``over`` before trajectories are laid
    out.  What is wrong with them is then said of ``over``, which the caller may not have
    passed at all.

    Parameters
    ----------
    arguments : mapping of str to str
        Names in errors, and what the verb calls them.
    """
    try:
        yield
    except InputError as error:
        if error.name not in arguments:
            raise
        raise InputError(
            arguments[error.name], must=error.must, got=error.got, why=error.why, fix=error.fix
        ) from None
