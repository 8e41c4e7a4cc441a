"""Any verb on a grid, in tiles."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from typing import Any

import xarray as xr

from remanent._errors import InputError, shortened_repr
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results import stores
from remanent.results.files import require_path
from remanent.studies.ensemble.over import OverArgument
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.sweep.dask_engine import run_on_workers
from remanent.studies.sweep.run import Progress, run_here, writable_store
from remanent.studies.sweep.sample import sample_on
from remanent.studies.sweep.study import Study, is_verb_of_studies, verb_function


def sweep(
    system: System,
    drive: Drive | None,
    over: OverArgument,
    verb: str | Callable[..., xr.Dataset],
    *,
    store: str | PathLike[str] | None = None,
    client: Any = None,
    progress: ProgressArgument = None,
    **options: Any,
) -> xr.Dataset:
    """Run a verb on a grid, in tiles; into a store that a later call goes on with.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive or None
        None for verbs without a drive, such as `equilibria`.
    over : mapping of name to array_like or DataArray
        Numeric fields with their values, as every verb takes them.
    verb : str or callable
        A verb that takes `over`, itself or its name.
    store : str or path, optional
        A folder in which results are kept.  Where it has a part of this study, the rest is
        computed; where it has all, nothing is.  Without it results are kept in memory.
    client : distributed.Client, optional
        Of a Dask cluster whose workers see the store under the same path.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share that is done, in [0, 1].
    **options
        Keyword arguments of the verb.

    Returns
    -------
    xarray.Dataset
        What the verb itself returns for the same grid, equal to it bit for bit; with `store`
        the study is among the attributes.

    Raises
    ------
    InputError
        What the verb refuses, a store of another study, a client without a store.
    RemanentError
        The store is being written by another process, or was begun by other code.

    See Also
    --------
    remanent.load : Reads a store.

    Examples
    --------
    >>> import remanent as rm
    >>> body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    >>> drive = rm.SineSquared(0.4, 1.25)
    >>> loss = rm.sweep(body, drive, {"b": [0.3, 0.4]}, rm.cycle_losses, periods=2)
    >>> loss.equals(rm.cycle_losses(body, drive, periods=2, over={"b": [0.3, 0.4]}))
    True
    """
    name = _name_of_verb(verb)
    study = Study(name, system, drive, over, options)
    report = as_progress(progress)
    if store is None:
        _require_no_client(client)
        return study.result_of(study.grid.whole, report)
    path = require_path("store", store)
    _require_client(client)

    def tell(state: Progress) -> None:
        if report is not None:
            report(state.done / state.total)

    if client is None:
        with writable_store(path, study) as opened:
            run_here(opened, report=tell)
    else:
        with writable_store(path, study, take_sample=sample_on(client)) as opened:
            run_on_workers(opened, client, report=tell)
    return stores.read(path)


def _name_of_verb(verb: object) -> str:
    """Its name, where it is a verb of this package and not another function of the same name."""
    if isinstance(verb, str):
        return verb
    name = str(getattr(verb, "__name__", shortened_repr(verb)))
    if is_verb_of_studies(name) and verb_function(name) is not verb:
        raise InputError(
            "verb",
            must="be a verb of this package, or its name",
            got=shortened_repr(verb),
            why="A study is run by name, wherever its workers are.",
            fix=f"Pass {name!r} for that of this package.",
        )
    return name


def _require_no_client(client: object) -> None:
    if client is not None:
        raise InputError(
            "client",
            must="come with a store",
            got=shortened_repr(client),
            why="Workers write their results where this process can read them.",
            fix="Pass store='name.zarr', in a folder that all workers see.",
        )


def _require_client(client: Any) -> None:
    if client is not None and not (hasattr(client, "submit") and hasattr(client, "scheduler_info")):
        raise InputError(
            "client",
            must="be a distributed.Client",
            got=shortened_repr(client),
            why="Its workers compute the tasks.",
            fix="Pass distributed.Client('tcp://host:8786'), or leave it out for this process.",
        )
