"""The page as one file, with results that are computed before it is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

import remanent as rm
from remanent._errors import RemanentError, error_sentence
from remanent.page.assemble import saved_page
from remanent.page.model import page_model
from remanent.page.presets import presets
from remanent.results.atomic import atomic_replacement
from remanent.studies.sweep.faults import FaultsError
from remanent.web.errors import RefusalError
from remanent.web.explorer import Opened
from remanent.web.jobs import job_result
from remanent.web.subjects import Subject, initial_state, read_subject

#: Told of the stage and the share that is done.
StageFunction: TypeAlias = Callable[[str, float], None]
#: Cells along one side of the charts of a saved page.
_CELLS: Final = 32
#: Range of a state variable of which nothing is known.
_UNKNOWN_RANGE: Final = (0.5, 1.5)
#: The least value of a positive variable, as a share of the least that the motion has.
_LEAST_SHARE: Final = 0.3
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
    if not path.parent.is_dir():
        raise RemanentError(f"{path} cannot be written: its folder is not there. Create it first.")
    subject = read_subject(opened.spec if opened.spec is not None else presets()[0]["spec"])
    model = page_model(subject.system, subject.drive, subject.initial)
    results = results_of(subject, model.description["state"], report)
    text = saved_page(model, results, presets=presets())
    try:
        with atomic_replacement(path) as file:
            file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RemanentError(f"{path} cannot be written: {error_sentence(error)}") from error
    return path


def results_of(
    subject: Subject, states: Sequence[Mapping[str, Any]], report: StageFunction
) -> dict[str, dict[str, Any]]:
    """What the engine has to say of a subject, by the names of the jobs.

    Parameters
    ----------
    subject : Subject
    states : sequence of mapping
        The state variables, as a page model describes them.
    report : callable
        Told of each job and of the share that is done.

    Notes
    -----
    A job that is refused, as basins are under a load without a period, has its ``reason`` alone.
    """
    asked = _options(subject, states)
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


def _options(subject: Subject, states: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Options of the jobs, as the page of the server chooses them."""
    drive = subject.drive.parameter_values()
    strength = next((name for name in ("b", "m") if drive.get(name)), None)
    options: dict[str, dict[str, Any]] = {
        "frequency_response": {"sweeps": True},
        "response_diagram": {},
        "classify": {"periods": 500},
        "equilibria": {},
    }
    if len(states) > 1:
        options["basins"] = {"grid": _grid_of_states(subject, states), "count": _CELLS}
    if strength is not None and "omega" in drive:
        axes = {name: _around(drive[name]) for name in ("omega", strength)}
        options["regime_chart"] = {"grid": axes, "count": _CELLS}
    return options


def _around(value: float) -> list[float]:
    return sorted(share * value for share in _MULTIPLES)


def _grid_of_states(
    subject: Subject, states: Sequence[Mapping[str, Any]]
) -> dict[str, list[float]]:
    """Ranges of the first coordinate and its rate, about what the motion covers."""
    of_roles = [[one for one in states if one["role"] == role] for role in ("coordinate", "rate")]
    shown = [ones[0] for ones in of_roles] if all(of_roles) else list(states[:2])
    try:
        motion = rm.simulate(
            subject.system, subject.drive, periods=_PERIODS_LOOKED_AT,
            initial=initial_state(subject),
        )  # fmt: skip
    except RemanentError:
        return {one["name"]: list(_UNKNOWN_RANGE) for one in shown}
    return {
        one["name"]: _with_margin(motion[one["name"]].values, is_positive=bool(one["positive"]))
        for one in shown
    }


def _with_margin(values: Any, *, is_positive: bool) -> list[float]:
    known = values[np.isfinite(values)]
    if not known.size:
        return list(_UNKNOWN_RANGE)
    low, high = float(known.min()), float(known.max())
    margin = _MARGIN * ((high - low) or 1.0)
    return [max(low - margin, _LEAST_SHARE * low) if is_positive else low - margin, high + margin]
