"""What the page may have computed by the engine: options, cost, caps, and who computes it."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, Final, TypeAlias

import numpy as np
import xarray as xr
from pydantic import Field

import remanent as rm
from remanent._errors import InputWarning
from remanent._status import Status
from remanent._typing import FloatArray
from remanent.models.actuator import Actuator
from remanent.studies.ensemble.checks import require_drive_frequency
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressFunction
from remanent.studies.sweep.faults import Fault, FaultsError
from remanent.studies.sweep.tables import Table, read_table
from remanent.web import views
from remanent.web.costs import run_seconds
from remanent.web.errors import over_budget_refusal
from remanent.web.frequencies import frequency_range
from remanent.web.limits import JOB_LIMITS
from remanent.web.subjects import Subject, initial_state

#: Most points of one curve, and most cells along one side of a chart.
_MOST_POINTS, _MOST_CELLS = 2000, 128
#: Drive periods that pass at each frequency of a sweep before the motion counts as settled.
_PERIODS_PER_STOP: Final = 120
#: Drive periods of which a sweep tells the extremes.
_PERIODS_OF_EXTREMES: Final = 2
#: How much longer than a plain run one takes that is followed with its tangents, at several
#: tolerances, as regimes are.
_REGIME_FACTOR: Final = 2.0
#: Points of a chart that are computed together: few enough to tell often how far it is.
_POINTS_PER_STRIP: Final = 128
#: How many runs of a period a branch takes at each frequency, about.
_RUNS_PER_BRANCH: Final = 4000.0

_Number = Annotated[float, Field(allow_inf_nan=False)]
_Range = Annotated[list[_Number], Field(min_length=2, max_length=2)]


class FrequencyResponseOptions(Table):
    """Of a frequency response."""

    range: _Range | None = Field(
        None,
        description="It is the lowest and the highest omega; without it resonances are inside.",
        examples=["[0.5, 2.0]"],
    )
    count: Annotated[int, Field(ge=2, le=_MOST_POINTS)] = 400
    duration: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 100.0
    sweeps: bool = Field(False, description="Whether rising and falling frequencies follow.")
    sweep_count: Annotated[int, Field(ge=2, le=400)] = 60


class ResponseDiagramOptions(Table):
    """Of branches of forced response."""

    range: _Range | None = Field(
        None,
        description="It is the lowest and the highest omega; without it resonances are inside.",
        examples=["[0.5, 2.0]"],
    )
    orbit_period: Annotated[int, Field(ge=1, le=4)] = 1
    state_box: dict[str, _Range] | None = None
    max_points: Annotated[int, Field(ge=10, le=_MOST_POINTS)] = _MOST_POINTS


class ClassifyOptions(Table):
    """Of the regime of one motion."""

    periods: Annotated[int, Field(ge=100, le=10_000)] = 500


class BasinsOptions(Table):
    """Of a grid of initial states: ranges of two state variables, the first along x."""

    grid: Annotated[dict[str, _Range], Field(min_length=2, max_length=2)]
    count: Annotated[int, Field(ge=2, le=_MOST_CELLS)] = 32
    periods: Annotated[int, Field(ge=100, le=5_000)] = 200


class RegimeChartOptions(Table):
    """Of a grid of parameters: ranges of two of them, the first along x."""

    grid: Annotated[dict[str, _Range], Field(min_length=2, max_length=2)]
    count: Annotated[int, Field(ge=2, le=_MOST_CELLS)] = 32
    periods: Annotated[int, Field(ge=100, le=5_000)] = 300


class EquilibriaOptions(Table):
    """Of rest under a constant load: a number, or the loads by their names."""

    load: float | dict[str, float] = 0.0
    state_box: dict[str, _Range] | None = None


_OverFrequencies: TypeAlias = FrequencyResponseOptions | ResponseDiagramOptions


@dataclass(frozen=True)
class Job:
    """A kind of work.

    Attributes
    ----------
    options : type of Table
    seconds : callable
        About how long it takes, from the subject and the options.
    compute : callable
        The result as the page draws it, from the subject, the options and a function that is told
        the share that is done.
    """

    options: type[Table]
    seconds: Callable[[Subject, Any], float]
    compute: Callable[[Subject, Any, ProgressFunction | None], views.View]


def job_result(
    name: str, subject: Subject, options: Any, report: ProgressFunction | None = None
) -> views.View:
    """The result of a job as the page draws it.

    Parameters
    ----------
    name : str
        One of :data:`JOBS`.
    subject : Subject
    options : mapping
        As they were sent; those that are left out have their usual values.
    report : callable, optional

    Raises
    ------
    FaultsError
        Options that are not sound.
    InputError
        The verb refuses the subject.
    RefusalError
        It would take too long; nothing has been computed then.
    """
    job = JOBS[name]
    try:
        asked = read_table(job.options, options, "options")
    except FaultsError as error:
        raise FaultsError(fault.below("options") for fault in error.faults) from None
    if isinstance(asked, FrequencyResponseOptions | ResponseDiagramOptions):
        asked = _with_range(subject, asked)
    seconds = job.seconds(subject, asked)
    limit = JOB_LIMITS[name]
    if not seconds <= limit.seconds:
        raise over_budget_refusal(seconds, limit.seconds, limit.remedy)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        return job.compute(subject, asked, report)


def _with_range(subject: Subject, options: _OverFrequencies) -> _OverFrequencies:
    """Options with a range of frequencies; one that nobody chose has the resonances inside."""
    if options.range is None:
        require_drive_frequency(subject.drive, "A response varies the frequency of the drive.")
        low, high = frequency_range(subject.system, subject.drive)
        return options.model_copy(update={"range": [low, high]})
    return options


# What each takes ---------------------------------------------------------------------------


def _frequency_response_seconds(subject: Subject, options: FrequencyResponseOptions) -> float:
    low, high = _increasing(options.range, "range")
    plain = run_seconds(subject.drive, options.count, options.duration, (low, high))
    stops = 2 * options.sweep_count * (_PERIODS_PER_STOP + 1) if options.sweeps else 0
    return plain + run_seconds(subject.drive, stops, None, (low, high))


def _response_diagram_seconds(subject: Subject, options: ResponseDiagramOptions) -> float:
    ends = _increasing(options.range, "range")
    runs = _RUNS_PER_BRANCH * options.orbit_period
    return run_seconds(subject.drive, runs, None, ends)


def _classify_seconds(subject: Subject, options: ClassifyOptions) -> float:
    return run_seconds(subject.drive, _REGIME_FACTOR * options.periods, None)


def _chart_seconds(subject: Subject, options: BasinsOptions | RegimeChartOptions) -> float:
    runs = options.count**2 * options.periods * _REGIME_FACTOR
    ends = options.grid.get("omega") if isinstance(options, RegimeChartOptions) else None
    return run_seconds(subject.drive, runs, None, None if ends is None else (ends[0], ends[1]))


def _equilibria_seconds(subject: Subject, _: EquilibriaOptions) -> float:
    return 0.1 if isinstance(subject.system, Actuator) else 2.0


# How each is computed ----------------------------------------------------------------------


def _frequency_response(
    subject: Subject, options: FrequencyResponseOptions, report: ProgressFunction | None
) -> views.View:
    low, high = _increasing(options.range, "range")
    omega = np.linspace(low, high, options.count)
    responses = {
        "rest": rm.frequency_response(
            subject.system, subject.drive, omega, duration=options.duration,
            initial=initial_state(subject), progress=report,
        )
    }  # fmt: skip
    if options.sweeps:
        stops = np.linspace(low, high, options.sweep_count)
        for direction in ("up", "down"):
            responses[direction] = _swept_response(subject, stops, direction)
    return views.frequency_response_view(responses, options.model_dump())


def _swept_response(subject: Subject, omega: FloatArray, direction: str) -> xr.Dataset:
    """Extremes of the motion that each frequency leaves to the next."""
    sweep = rm.bifurcation_diagram(
        subject.system, subject.drive, "omega", omega, direction=direction,
        discard=_PERIODS_PER_STOP, keep=1, initial=initial_state(subject),
    )  # fmt: skip
    names = [name for name in _state_names(subject) if name in sweep]
    starts = {
        f"initial.{name}": xr.DataArray(sweep[name].isel(period=0).values, dims="omega")
        for name in names
    }
    response = rm.frequency_response(
        subject.system, subject.drive, omega, periods=_PERIODS_OF_EXTREMES, over=starts
    )
    status = np.where(sweep.status == Status.OK, response.status, sweep.status)
    return response.assign(status=response.status.copy(data=status.astype(np.int8)))


def _response_diagram(
    subject: Subject, options: ResponseDiagramOptions, report: ProgressFunction | None
) -> views.View:
    diagram = rm.response_diagram(
        subject.system, subject.drive, _increasing(options.range, "range"),
        state_box=options.state_box, orbit_period=options.orbit_period,
        max_points=options.max_points, progress=report,
    )  # fmt: skip
    return views.response_diagram_view(diagram, options.model_dump())


def _classify(
    subject: Subject, options: ClassifyOptions, report: ProgressFunction | None
) -> views.View:
    regime = rm.classify(
        subject.system, subject.drive, periods=options.periods, initial=initial_state(subject),
        progress=report,
    )  # fmt: skip
    return views.classify_view(regime, options.model_dump())


def _basins(
    subject: Subject, options: BasinsOptions, report: ProgressFunction | None
) -> views.View:
    grid, axes = _grid(options.grid, options.count)
    result = rm.basins(
        subject.system, subject.drive, grid, periods=options.periods, progress=report
    )
    return views.basins_view(result, options.model_dump(), axes)


def _regime_chart(
    subject: Subject, options: RegimeChartOptions, report: ProgressFunction | None
) -> views.View:
    grid, (x, y) = _grid(options.grid, options.count)
    rows = max(1, _POINTS_PER_STRIP // options.count)
    strips = []
    for start in range(0, options.count, rows):  # a point does not depend on those beside it
        part = {**grid, y: grid[y][start : start + rows]}
        strips.append(
            rm.regime_chart(
                subject.system, subject.drive, part, periods=options.periods,
                initial=initial_state(subject),
            )
        )  # fmt: skip
        if report is not None:
            report(min(1.0, (start + rows) / options.count))
    chart = xr.concat(strips, y, data_vars="all", coords="minimal", compat="override", join="exact")
    return views.regime_chart_view(chart, options.model_dump(), (x, y))


def _equilibria(
    subject: Subject, options: EquilibriaOptions, _: ProgressFunction | None
) -> views.View:
    result = rm.equilibria(subject.system, options.load, state_box=options.state_box)
    return views.equilibria_view(result, options.model_dump())


def _state_names(subject: Subject) -> tuple[str, ...]:
    names: tuple[str, ...] = lay_out_ensemble(
        subject.system, subject.drive
    ).vector_field.state_names
    return names


def _grid(
    ranges: Mapping[str, list[float]], count: int
) -> tuple[dict[str, FloatArray], tuple[str, str]]:
    """Values along the two axes of a chart, and their names, that of x first."""
    x, y = ranges
    ends = {name: _increasing(pair, "grid", name) for name, pair in ranges.items()}
    return {name: np.linspace(*pair, count) for name, pair in ends.items()}, (x, y)


def _increasing(pair: list[float] | None, *place: str) -> tuple[float, float]:
    assert pair is not None
    low, high = pair
    if not low < high or not math.isfinite(high - low):
        raise FaultsError([
            Fault(("options", *place), "be two increasing numbers", f"{low!r}, {high!r}",
                  "It is a lowest and a highest value.", "Exchange them, or take others.")
        ])  # fmt: skip
    return low, high


#: The jobs by their names.
JOBS: Final[Mapping[str, Job]] = MappingProxyType(
    {
        "frequency_response": Job(
            FrequencyResponseOptions, _frequency_response_seconds, _frequency_response
        ),
        "classify": Job(ClassifyOptions, _classify_seconds, _classify),
        "equilibria": Job(EquilibriaOptions, _equilibria_seconds, _equilibria),
        "response_diagram": Job(
            ResponseDiagramOptions, _response_diagram_seconds, _response_diagram
        ),
        "basins": Job(BasinsOptions, _chart_seconds, _basins),
        "regime_chart": Job(RegimeChartOptions, _chart_seconds, _regime_chart),
    }
)
