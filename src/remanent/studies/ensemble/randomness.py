"""Where random numbers come from: the argument `rng` of every verb that draws some."""

from __future__ import annotations

from copy import deepcopy

import numpy as np

from remanent._errors import InputError

#: What `rng` accepts.
Rng = int | np.random.Generator | None
#: The seed of ``rng=None``: the same numbers in every run.
DEFAULT_SEED = 0
#: Seeds drawn from a generator lie below this.
_SEED_LIMIT = 2**31


def as_generator(rng: Rng) -> np.random.Generator:
    """A generator of random numbers that depends on the value of `rng` alone.

    Parameters
    ----------
    rng : int, numpy.random.Generator or None
        A seed, a generator, or None for :data:`DEFAULT_SEED`.  A generator is copied: no
        verb changes its arguments, and the tiles of a sweep draw what the whole grid draws.

    Raises
    ------
    InputError
        It is something else, or a negative seed.
    """
    if isinstance(rng, np.random.Generator):
        return deepcopy(rng)
    if rng is None:
        return np.random.default_rng(DEFAULT_SEED)
    if isinstance(rng, bool) or not isinstance(rng, int | np.integer) or rng < 0:
        raise InputError(
            "rng", "be a seed of at least 0, a numpy.random.Generator or None", repr(rng)[:80],
            "It says which random numbers are drawn.", "Pass for example 1, or leave it out.",
        )  # fmt: skip
    return np.random.default_rng(int(rng))


def as_seed(rng: Rng) -> int:
    """A seed that depends on the value of `rng` alone, for draws that are made many times."""
    generator = as_generator(rng)
    if isinstance(rng, np.random.Generator):
        return int(generator.integers(_SEED_LIMIT))
    return DEFAULT_SEED if rng is None else int(rng)
