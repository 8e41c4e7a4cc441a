"""Passages of motions through a value, one row for each trajectory."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._typing import FloatArray
from remanent.integrate.crossings import Crossings
from remanent.integrate.ensemble.problem import Outcome
from remanent.results.build import padding_of
from remanent.studies.ensemble.dataset import to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.memory import require_memory


def passages_dataset(
    ens: Ensemble, passages: Crossings, outcome: Outcome, *, tolerance: float, **settings: Any
) -> xr.Dataset:
    """Passages against ``crossing``, with their times, states, directions and errors."""
    variables = _padded_passage_arrays(ens, passages, outcome.error)
    columns = int(variables["crossings"].max(initial=0))
    return to_dataset(
        ens,
        {name: v if v.ndim == 1 else (("crossing",), v) for name, v in variables.items()},
        coords={"crossing": (("crossing",), np.arange(columns))},
        outcome=outcome,
        tolerance=tolerance,
        **settings,
    )


def _padded_passage_arrays(
    ens: Ensemble, passages: Crossings, error: FloatArray
) -> dict[str, NDArray[Any]]:
    """The passages with one row for each trajectory, padded at its end."""
    row = passages.trajectory
    count = np.bincount(row, minlength=ens.trajectory_count)
    width = int(count.max(initial=0))
    require_memory(
        "over",
        8.0 * ens.trajectory_count * width * (4 + len(ens.vector_field.state_names)),
        "the crossings",
    )
    column = np.arange(row.size) - (np.cumsum(count) - count)[row]

    def padded(values: NDArray[Any], missing: float) -> NDArray[Any]:
        rows = np.full((ens.trajectory_count, width), missing, dtype=values.dtype)
        rows[row, column] = values
        return rows

    columns = {
        "crossing_time": padded(passages.time, np.nan),
        "crossing_time_error": padded(passages.time_error(error[row]), np.nan),
        "state_error": padded(passages.state_error(error[row]), np.nan),
    }
    for k, name in enumerate(ens.vector_field.state_names):
        columns[name] = padded(passages.states[:, k], np.nan)
    directions = passages.direction.astype(np.int8)
    columns["direction"] = padded(directions, padding_of(directions.dtype, "direction"))
    columns["crossings"] = count
    return columns
