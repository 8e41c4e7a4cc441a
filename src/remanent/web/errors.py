"""What a client is told of an error: words, where they belong, and a status, never a traceback."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from remanent._errors import InputError, RemanentError, error_sentence
from remanent.studies.sweep.faults import (
    Fault,
    FaultsError,
    StudyFileError,
    first_of_each_place,
)

#: Longest message to a client, in characters.
_MAX_CHARACTERS: Final = 4000
#: Most faults that one answer lists.
_MAX_FAULTS: Final = 40
#: What is said of an error that is nobody's input.
UNEXPECTED: Final = "Something went wrong in the program itself; the terminal tells what."


class RefusalError(Exception):
    """A request that is not answered as asked.

    Parameters
    ----------
    status : int
        Of HTTP.
    message : str
    faults : sequence of dict
        Each with ``table``, ``key`` and ``message``.
    """

    def __init__(self, status: int, message: str, faults: Sequence[Mapping[str, str]] = ()) -> None:
        self.status, self.message, self.faults = status, message, tuple(faults)
        super().__init__(message)

    @property
    def answer(self) -> dict[str, Any]:
        """What is sent."""
        return {
            "status": self.status,
            "message": self.message[:_MAX_CHARACTERS],
            "faults": [dict(fault) for fault in self.faults[:_MAX_FAULTS]],
        }


def busy_refusal() -> RefusalError:
    """Said where as much is computed already as is allowed at once."""
    return RefusalError(
        429, "As much is being computed as this machine allows. Wait for it, or cancel it."
    )


def over_budget_refusal(seconds: float, cap: float, remedy: str) -> RefusalError:
    """Said of work that is too long, before it begins."""
    return RefusalError(
        422,
        f"This takes about {_rounded(seconds)} s, and at most {_rounded(cap)} s are allowed. "
        f"{remedy}",
    )


def out_of_time_refusal(cap: float, remedy: str) -> RefusalError:
    """Said of work that was given up."""
    return RefusalError(422, f"It was given up after {_rounded(cap)} s. {remedy}")


def refusal_of_faults(faults: Iterable[Fault]) -> RefusalError:
    """What is wrong with the tables of a request, place by place."""
    known = first_of_each_place(faults)
    entries = tuple(
        {
            "table": str(fault.path[0]) if fault.path else "",
            "key": ".".join(map(str, fault.path[1:])),
            "message": fault.text,
        }
        for fault in known
    )
    return RefusalError(422, "\n".join(fault.text for fault in known) or "It was refused.", entries)


def refusal_of(error: Exception) -> RefusalError | None:
    """What a client is told of an error; None where it is a defect of the program."""
    if isinstance(error, RefusalError):
        return error
    if isinstance(error, FaultsError | StudyFileError):
        return refusal_of_faults(error.faults)
    if isinstance(error, InputError):
        return RefusalError(
            422, str(error), ({"table": "", "key": error.name, "message": str(error)},)
        )
    said = _sentence_of(error)
    return None if said is None else RefusalError(422, said)


def _sentence_of(error: Exception) -> str | None:
    """What is said of an error that has no place in a request; None of a defect."""
    if isinstance(error, RemanentError):
        return str(error)
    if isinstance(error, MemoryError):
        return "It needs more memory than there is. Ask for less."
    return error_sentence(error) if isinstance(error, OSError) else None


def _rounded(seconds: float) -> str:
    return f"{seconds:.0f}" if seconds < 1e4 else f"{seconds:.0e}"
