"""Members of an ensemble that are worked on one by one, and joined with padding."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from remanent._errors import InputError
from remanent._threads import results_of_all
from remanent.results.build import padding_of
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.progress import ProgressFunction

MemberResult = TypeVar("MemberResult")


def map_members_in_threads(
    ens: Ensemble,
    compute: Callable[[Ensemble], MemberResult],
    report: ProgressFunction | None = None,
) -> list[MemberResult | None]:
    """What `compute` makes of each trajectory of an ensemble alone, on all processors.

    Parameters
    ----------
    ens : Ensemble
    compute : callable
        Takes an ensemble of one trajectory.  All arguments are to be checked before: an
        InputError then means that this trajectory has no result.
    report : callable, optional
        Called with the share of the trajectories that are finished.

    Returns
    -------
    list
        None for trajectories that are invalid or have no result.

    Raises
    ------
    InputError
        From `compute`, where there is only a single trajectory.
    """
    finished: list[int] = []

    def compute_member(k: int) -> MemberResult | None:
        outcome = None
        if not ens.is_invalid[k]:
            try:
                outcome = compute(ens.single_member(k))
            except InputError:
                if not ens.dimension_sizes:
                    raise
        finished.append(k)
        if report is not None:
            report(len(finished) / ens.trajectory_count)
        return outcome

    return results_of_all(compute_member, range(ens.trajectory_count))


def stack_padded(arrays: Sequence[NDArray[Any]], shortest: NDArray[Any]) -> NDArray[Any]:
    """Arrays of one rank as one array with a new first axis, padded where they are shorter.

    Numbers are padded with NaN, counts and indices with -1, text with "".

    Parameters
    ----------
    arrays : sequence of array
    shortest : array
        Least shape, and the kind where there are no arrays.
    """
    shape = np.max([np.shape(a) for a in (*arrays, shortest)], axis=0, initial=0)
    kind = np.result_type(shortest, *arrays)
    stacked = np.full((len(arrays), *shape), padding_of(kind), dtype=kind)
    for row, array in zip(stacked, arrays, strict=True):
        row[tuple(slice(n) for n in np.shape(array))] = array
    return stacked


def stack_tables(
    tables: Sequence[dict[str, NDArray[Any]] | None], shortest: dict[str, NDArray[Any]]
) -> dict[str, NDArray[Any]]:
    """Tables with the same columns as one, each column padded; see :func:`stack_padded`.

    Parameters
    ----------
    tables : sequence of dict of name to array
        None where there is none: its columns are all padding.
    shortest : dict of name to array
        Least shape of each column, and its kind.
    """
    return {
        name: stack_padded([least if t is None else t[name] for t in tables], least)
        for name, least in shortest.items()
    }
