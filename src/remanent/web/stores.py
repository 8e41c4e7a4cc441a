"""The store of a study: what its chart shows, and the motion behind a point of it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import xarray as xr

from remanent._errors import InputWarning, RemanentError, error_sentence
from remanent.models.drives.base import Drive
from remanent.models.physical_sizes import PHYSICAL_SIZES
from remanent.models.system import System
from remanent.page.spec import Spec, write_spec
from remanent.results.stores import read
from remanent.studies.ensemble.constant_drive import constant_drive
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.sweep.store import open_store
from remanent.studies.sweep.study import Study
from remanent.web.errors import RefusalError
from remanent.web.views import View, quantity, status_words

#: Most numbers that a chart may hold.
_MOST_VALUES: Final = 400_000
#: What stands before the name of a state variable whose value at the start is varied.
_INITIAL_PREFIX: Final = "initial."


def store_view(path: Path) -> View:
    """What a chart shows of a store: the variables along its grid.

    Returns
    -------
    dict
        ``title``, ``verb``, ``dims`` with their lengths, ``coords`` and ``variables``, each a
        quantity with its ``dims``, ``status`` in words along the grid, and ``point``, the spec
        of the study itself.

    Raises
    ------
    RemanentError
        There is no store, or a part of it cannot be read.
    RefusalError
        It holds more than a page can draw.
    """
    study = open_store(path).study
    dataset = _dataset(path)
    dims = [dim for dim in study.grid.dims if dim in dataset.dims]
    kept = {
        str(name): variable
        for name, variable in dataset.data_vars.items()
        if set(variable.dims) <= set(dims) and name != "status"
    }
    size = sum(variable.size for variable in kept.values())
    if size > _MOST_VALUES:
        raise RefusalError(
            422,
            f"The store holds {size} values along its grid, and a page draws at most "
            f"{_MOST_VALUES}. Open a part of it in Python, by xarray.open_zarr.",
        )
    coords = {
        str(name): variable
        for name, variable in dataset.coords.items()
        if set(variable.dims) <= set(dims)
    }
    return {
        "title": path.resolve().name,
        "verb": study.verb,
        "dims": [{"name": dim, "size": dataset.sizes[dim]} for dim in dims],
        "coords": {name: _with_dims(variable) for name, variable in coords.items()},
        "variables": {name: _with_dims(variable) for name, variable in kept.items()},
        "status": {
            "dims": [str(dim) for dim in dataset.status.dims],
            "values": status_words(dataset.status.values),
        },
        "point": study_spec(study),
    }


def point_spec(path: Path, index: Sequence[int]) -> Spec:
    """The spec of a point of the grid of a store.

    Parameters
    ----------
    path : Path
    index : sequence of int
        Along each dimension, the slowest first.

    Raises
    ------
    RefusalError
        No such point.
    RemanentError
        There is no store, or values at this point that break a rule.
    """
    study = open_store(path).study
    shape = study.grid.shape
    inside = len(index) == len(shape) and all(
        0 <= k < n for k, n in zip(index, shape, strict=False)
    )
    if not inside:
        raise RefusalError(
            422, f"The grid has {' x '.join(map(str, shape))} points, and this is none of them."
        )
    places = dict(zip(study.grid.dims, index, strict=True))
    values = {
        name: float(array[tuple(places[dim] for dim in dims)])
        for name, (dims, array) in study.grid.fields.arrays.items()
    }
    return study_spec(study, values)


def study_spec(study: Study, values: dict[str, float] | None = None) -> Spec:
    """The spec of a study, with some values of the fields that it varies.

    Parameters
    ----------
    study : Study
    values : dict of str to float, optional
        By the names of the fields; the study's own by default.
    """
    values = values or {}
    of_start = {
        name.removeprefix(_INITIAL_PREFIX): value
        for name, value in values.items()
        if name.startswith(_INITIAL_PREFIX)
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        system = _system_with(study.system, values)
        drive = _drive_with(_drive_of(study, values), values)
        initial = _initial_of(study, system, drive) | of_start
        return write_spec(system, drive, initial)


def _system_with(system: Any, values: dict[str, float]) -> Any:
    """A system with those of the values that are of its fields."""
    hardware = sorted(values.keys() & PHYSICAL_SIZES)
    if hardware:
        raise RefusalError(
            422,
            f"This study varies {', '.join(hardware)}, and with it the scales of the actuator; "
            "a page has one set of them.",
        )
    for name in values.keys() & system.parameter_values().keys():
        system = system.with_parameter(name, values[name])
    return system


def _drive_with(drive: Drive, values: dict[str, float]) -> Drive:
    """A drive with those of the values that are of its fields."""
    own = {name: values[name] for name in values.keys() & drive.parameter_values().keys()}
    return drive.replace(**own) if own else drive


def _drive_of(study: Study, values: dict[str, float]) -> Drive:
    """The drive; of verbs without one the constant load."""
    if study.drive is not None:
        return study.drive
    load = values.get("m", study.options.get("m", 0.0))
    return constant_drive(study.system, load)


def _initial_of(study: Study, system: System, drive: Drive) -> dict[str, float]:
    """Where the runs of a study start, by the names of the state variables."""
    given = study.options.get("initial")
    if given is None:
        return {}
    ens = lay_out_ensemble(system, drive, None, given)
    names = ens.vector_field.state_names
    return dict(zip(names, map(float, ens.initial_states[0]), strict=True))


def _dataset(path: Path) -> xr.Dataset:
    try:
        return read(path)
    except RemanentError:
        raise
    except Exception as error:  # what a damaged store raises is not limited
        raise RemanentError(
            f"The store {path.name} cannot be read: {error_sentence(error)} "
            "See what is damaged by `remanent verify`, which computes it again with --repair."
        ) from error


def _with_dims(variable: xr.DataArray) -> View:
    return {**quantity(variable), "dims": [str(dim) for dim in variable.dims]}
