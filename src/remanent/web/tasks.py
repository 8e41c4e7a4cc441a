"""What the processes behind the server do: each task takes plain data and gives plain data.

What only some tasks need is imported where it is used: the page waits for the first of them.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import remanent as rm
from remanent._errors import RemanentError
from remanent.page.kinds import kinds
from remanent.page.model import page_model
from remanent.page.presets import presets
from remanent.studies.ensemble.progress import ProgressFunction
from remanent.studies.sweep.faults import FaultsError
from remanent.web.costs import run_seconds
from remanent.web.errors import RefusalError, over_budget_refusal
from remanent.web.limits import SLIDER_CAP
from remanent.web.subjects import initial_state, read_subject, spec_from_toml

#: A task: arguments, and a function that is told the share that is done.
Task = Callable[[Any, ProgressFunction], Any]
_SHORTER: Final = "Ask for fewer periods."


def start(arguments: Mapping[str, Any], report: ProgressFunction) -> dict[str, Any]:
    """What a page begins with.

    Parameters
    ----------
    arguments : mapping
        ``spec``, or None for that of the first preset.
    report : callable
    """
    shown = presets()
    spec = arguments["spec"] if arguments["spec"] is not None else shown[0]["spec"]
    return {**model({"spec": spec}, report), "kinds": kinds(), "presets": shown}


def model(arguments: Mapping[str, Any], _: ProgressFunction) -> dict[str, Any]:
    """The page model of a spec, or of the text of a study file, and its field module."""
    toml = arguments.get("toml")
    spec = arguments["spec"] if toml is None else spec_from_toml(toml)
    subject = read_subject(spec)
    made = page_model(subject.system, subject.drive, subject.initial)
    return {"model": made.description, "source": made.field_source}


def reproduce(arguments: Mapping[str, Any], _: ProgressFunction) -> dict[str, str]:
    """The lines, and the study file, that make what a spec says."""
    from remanent.page.reproduction import reproduction

    read_subject(arguments["spec"])
    return reproduction(
        arguments["spec"], periods=arguments["periods"], duration=arguments["duration"]
    )


def export(arguments: Mapping[str, Any], _: ProgressFunction) -> dict[str, Any]:
    """The equations in another tool's language."""
    subject = read_subject(arguments["spec"])
    return {"files": rm.export(subject.system, subject.drive, arguments["language"])}


def data(arguments: Mapping[str, Any], report: ProgressFunction) -> bytes:
    """The file of a motion."""
    from remanent.results.files import save

    subject = read_subject(arguments["spec"])
    periods, duration = arguments["periods"], arguments["duration"]
    seconds = run_seconds(subject.drive, periods or 1.0, None if periods else duration)
    if not seconds <= SLIDER_CAP:
        raise over_budget_refusal(seconds, SLIDER_CAP, _SHORTER)
    motion = rm.simulate(
        subject.system, subject.drive, periods=periods, duration=duration,
        initial=initial_state(subject), progress=report,
    )  # fmt: skip
    ending = {"netcdf": ".nc", "csv": ".csv"}[arguments["format"]]
    with tempfile.TemporaryDirectory() as folder:
        return save(motion, Path(folder) / f"motion{ending}").read_bytes()


def job(arguments: Mapping[str, Any], report: ProgressFunction) -> dict[str, Any]:
    """The result of a job, as the page draws it."""
    from remanent.web.jobs import job_result

    subject = read_subject(arguments["spec"])
    return job_result(arguments["job"], subject, arguments["options"], report)


def store(arguments: Mapping[str, Any], _: ProgressFunction) -> dict[str, Any]:
    """What the chart of the store shows."""
    from remanent.web.stores import store_view

    path = Path(arguments["path"])
    with _folders_kept_back(path):
        return store_view(path)


def point(arguments: Mapping[str, Any], _: ProgressFunction) -> dict[str, Any]:
    """The spec of a point of the store."""
    from remanent.web.stores import point_spec

    path = Path(arguments["path"])
    with _folders_kept_back(path):
        return {"spec": point_spec(path, arguments["index"])}


@contextmanager
def _folders_kept_back(path: Path) -> Iterator[None]:
    """Tell an error without the folders that a store is in: a page knows its name alone."""
    try:
        yield
    except RemanentError as error:
        folder = f"{path.parent}{os.sep}"
        if folder not in str(error):
            raise
        raise RefusalError(422, str(error).replace(folder, "")) from error


#: The tasks by their names.
TASKS: Final[Mapping[str, Task]] = MappingProxyType(
    {
        "start": start, "model": model, "reproduce": reproduce, "export": export, "data": data,
        "job": job, "store": store, "point": point,
    }
)  # fmt: skip


def warm_up_steps(arguments: Mapping[str, Any] | None = None) -> list[Callable[[], object]]:
    """What computes a little of each job, so that the kernels behind them are compiled.

    All modules that jobs need are imported first, as an import is not to be broken off.

    Parameters
    ----------
    arguments : mapping, optional
        ``spec`` of the equations; that of the first preset by default.
    """
    from remanent.web.jobs import JOBS

    for name in (*JOBS, "bifurcation_diagram", "simulate"):
        getattr(rm, name)
    spec = presets()[0]["spec"] if arguments is None else arguments["spec"]
    return [partial(_do_little, spec, name) for name in _LITTLE]


def _do_little(spec: Any, name: str) -> None:
    """Compute a little of a job, if it is sound."""
    from remanent.web.jobs import job_result

    with suppress(RemanentError, FaultsError, RefusalError):
        job_result(name, read_subject(spec), _LITTLE[name])


#: Options with which a job takes little more than its kernels.
_LITTLE: Final[Mapping[str, dict[str, Any]]] = MappingProxyType(
    {
        "frequency_response": {"range": [1.0, 1.2], "count": 4, "duration": 4.0},
        "classify": {"periods": 100},
        "response_diagram": {"range": [1.2, 1.21]},
        "equilibria": {},
    }
)
