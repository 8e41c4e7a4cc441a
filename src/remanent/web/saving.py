"""The page as one file, with results that are computed before it is written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

import remanent as rm
from remanent._errors import RemanentError, error_sentence
from remanent._field import Role
from remanent.page.assemble import saved_page
from remanent.page.model import page_model
from remanent.page.presets import presets
from remanent.results.atomic import atomic_replacement
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.sweep.faults import FaultsError
from remanent.web.errors import RefusalError
from remanent.web.explorer import Opened
from remanent.web.jobs import job_result
from remanent.web.subjects import Subject, initial_state, read_subject

#: Told of the stage and the share that is done.
StageFunction: TypeAlias = Callable[[str, float], None]
#: Cells along one side of the charts of a saved page.
_CELLS: Final = 32
#: Frequencies and amplitudes of charts, as multiples of those of the drive.
_MULTIPLES: Final = (0.5, 1.6)
#: Drive periods of the motion by which the grid of initial states is chosen.
_PERIODS_LOOKED_AT: Final = 20
#: Margin around that motion, as a share of what it covers, and of 1 where it covers nothing.
_MARGIN: Final = 0.5


def save_page(opened: Opened, path: Path, report: StageFunction) -> Path:
    """Write one file that works without a server.

    Parameters
    ----------
    opened : Opened
        What the page looks at.
    path : Path
        The file; one that is there is replaced.
    report : callable
        Told of each job and of the share that is done.

    Returns
    -------
    Path

    Raises
    ------
    RemanentError
        The file cannot be written.
    """
    subject = read_subject(opened.spec if opened.spec is not None else presets()[0]["spec"])
    model = page_model(subject.system, subject.drive, subject.initial)
    text = saved_page(model, results_of(subject, report))
    try:
        with atomic_replacement(path) as file:
            file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RemanentError(f"{path} cannot be written: {error_sentence(error)}") from error
    return path


def results_of(subject: Subject, report: StageFunction) -> dict[str, dict[str, Any]]:
    """What the engine has to say of a subject, by the names of the jobs.

    A job that is refused, as basins are under a load without a period, has its ``reason`` alone.
    """
    asked = _options(subject)
    results: dict[str, dict[str, Any]] = {}
    for k, (name, options) in enumerate(asked.items()):
        part = _PartOfWhole(report, name.replace("_", " "), k, len(asked))
        part(0.0)
        try:
            results[name] = job_result(name, subject, options, part)
        except (RefusalError, FaultsError, RemanentError) as error:
            results[name] = {"kind": name, "settings": options, "series": [], "reason": str(error)}
    report("written", 1.0)
    return results


@dataclass(frozen=True)
class _PartOfWhole:
    """Reports the share that is done of one of several jobs as one of them all."""

    report: StageFunction
    stage: str
    number: int
    count: int

    def __call__(self, share: float) -> None:
        """Report a share in [0, 1] of this job."""
        self.report(self.stage, (self.number + share) / self.count)


def _options(subject: Subject) -> dict[str, dict[str, Any]]:
    """Options of the jobs, around what the drive does."""
    drive = subject.drive.parameter_values()
    omega = _around(drive.get("omega", 1.0))
    strength = next((name for name in ("b", "m") if name in drive), None)
    options: dict[str, dict[str, Any]] = {
        "frequency_response": {"range": omega, "sweeps": True},
        "response_diagram": {"range": omega},
        "classify": {"periods": 500},
        "equilibria": {},
        "basins": {"grid": _grid_of_states(subject), "count": _CELLS},
    }
    if strength is not None:
        axes = {"omega": omega, strength: _around(drive[strength])}
        options["regime_chart"] = {"grid": axes, "count": _CELLS}
    return options


def _around(value: float) -> list[float]:
    return sorted(share * value for share in _MULTIPLES)


def _grid_of_states(subject: Subject) -> dict[str, list[float]]:
    """Ranges of the first coordinate and its rate, about what the motion covers."""
    field = lay_out_ensemble(subject.system, subject.drive).vector_field
    names = [*field.names_of_roles(Role.COORDINATE)[:1], *field.names_of_roles(Role.RATE)[:1]]
    names = names if len(names) == 2 else list(field.state_names[:2])
    try:
        motion = rm.simulate(
            subject.system, subject.drive, periods=_PERIODS_LOOKED_AT,
            initial=initial_state(subject),
        )  # fmt: skip
    except RemanentError:
        return {name: [0.5, 1.5] for name in names}
    return {name: _with_margin(motion[name].values) for name in names}


def _with_margin(values: Any) -> list[float]:
    known = values[np.isfinite(values)]
    if not known.size:
        return [0.5, 1.5]
    low, high = float(known.min()), float(known.max())
    margin = _MARGIN * ((high - low) or 1.0)
    return [low - margin, high + margin]
