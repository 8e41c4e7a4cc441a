"""How much memory a request needs, and the refusal of what is too large."""

from __future__ import annotations

from remanent._errors import InputError
from remanent._machine import available_memory_bytes

#: Bytes that a trajectory costs while it is computed, beside its samples.
BYTES_PER_TRAJECTORY = 1024.0
#: Bytes of one sample of a trajectory: its state, its observables, and their copies.
BYTES_PER_SAMPLE = 80.0
#: Bytes of a request that is granted without a look at the machine, which takes a while.
_SMALL_REQUEST_BYTES = 2.0**20
#: Share of the memory that this process may use which one request may take.
_ALLOWED_MEMORY_SHARE = 0.5


def require_memory(name: str, needed: float, what: str) -> None:
    """Refuse a request that is too large, before anything of its size is allocated.

    Parameters
    ----------
    name : str
        The argument that makes it large.
    needed : float
        Bytes that the results and what is needed on the way take.
    what : str
        What they are, as in ``"100 x 2001 states"``.

    Raises
    ------
    InputError
        If it is more than half of the memory that this process may use; a MiB is always granted.
    """
    if needed <= _SMALL_REQUEST_BYTES:
        return
    limit = _ALLOWED_MEMORY_SHARE * available_memory_bytes()
    if needed > limit:
        raise InputError(
            name,
            must=f"ask for results of at most {limit / 2**30:.1f} GiB",
            got=f"{what}, about {needed / 2**30:.1f} GiB",
            why="The request was refused before any memory was allocated.",
            fix="Pass fewer values, fewer times, or split the request.",
        )
