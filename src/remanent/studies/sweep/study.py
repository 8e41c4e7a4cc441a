"""A study as a value: which verb, of what, over which grid, with which options."""

from __future__ import annotations

import hashlib
import inspect
import json
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeGuard

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import remanent
from remanent import _checks
from remanent._cache import source_digest
from remanent._errors import InputError, InputWarning, shortened_repr
from remanent.integrate.kernel.compile import host_processor
from remanent.models.drives.base import Drive
from remanent.models.plain import from_plain_data, to_plain_data
from remanent.models.system import System
from remanent.results.provenance import package_versions
from remanent.studies.ensemble.checks import require_drive, require_system
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.over import require_over
from remanent.studies.sweep.grid import Grid, GridPart, is_plain_grid

#: Arguments of verbs that a study has of its own, or that change no result.
NO_OPTIONS: Final = frozenset({"system", "actuator", "drive", "over", "progress"})
#: Verbs whose results for all points belong together, as folds of equilibria along a parameter do.
WHOLE_GRID_VERBS: Final = frozenset({"equilibria"})
#: Verbs whose points have one axis of time, as long as the longest run.
_VERBS_WITH_TIMES: Final = frozenset({"simulate", "energy_balance"})
#: Verbs that search or follow: a point of theirs takes long.
SEARCHING_VERBS: Final = frozenset(
    {
        "backbone", "basins", "bifurcation_diagram", "continue_bifurcation", "continue_orbit",
        "manifold_crossing", "periodic_orbits", "resonances", "response_diagram",
        "shape_commands",
    }
)  # fmt: skip
#: Parts of the package on which a number of a result depends.
_NUMERIC_SOURCES: Final = (
    "analysis", "codegen", "derivation", "integrate", "models", "studies",
    "_field.py", "_instructions.py", "_load_schedule.py", "_roots.py", "_status.py", "_units.py",
)  # fmt: skip


@dataclass(frozen=True)
class Study:
    """A verb, a system and a drive, a grid and options.

    Parameters
    ----------
    verb : str
        Public name of a verb that takes `over`.
    system : System
    drive : Drive or None
        None for verbs without one.
    over : mapping of name to array_like or DataArray
    options : mapping of name to plain data
        Keyword arguments of the verb.
    """

    verb: str
    system: System
    drive: Drive | None
    over: Mapping[str, Any]
    options: Mapping[str, Any]

    def __post_init__(self) -> None:
        function = verb_function(self.verb)
        require_system("system", self.system)
        parameters = inspect.signature(function).parameters
        if "drive" in parameters:
            require_drive(self.drive)
        elif self.drive is not None:
            raise InputError(
                "drive",
                must=f"be left out for {self.verb}",
                got=shortened_repr(self.drive),
                why="This verb asks what happens under constant loads, or without any.",
                fix="Pass None; a constant load is the option `m`.",
            )
        known = [name for name in parameters if name not in NO_OPTIONS]
        _checks.require_known_names(self.options, known, self.verb)
        for name in known:
            if parameters[name].default is inspect.Parameter.empty and name not in self.options:
                raise InputError(
                    name,
                    must=f"be given to {self.verb}",
                    got="nothing",
                    why="It has no usual value.",
                    fix=f"Add {name} to the options.",
                )
        require_over(self.over)
        if not self.over:
            raise InputError(
                "over",
                must="name at least one field",
                got=shortened_repr(self.over),
                why="A study is a verb on a grid.",
                fix="Pass for example {'temperature': [250, 350, 400]}.",
            )

    @cached_property
    def grid(self) -> Grid:
        """The grid that it spans."""
        return Grid.from_over(self.over, self.system)

    @cached_property
    def needs_whole_grid(self) -> bool:
        """Whether the verb has to see all points in one call, since they depend on each other.

        So they do where folds are sought along a parameter, or where the run is as long as the
        slowest point needs.
        """
        if self.verb == "step_response":
            return self.options.get("duration") is None
        if self.verb in _VERBS_WITH_TIMES and self.options.get("periods") is not None:
            return self._has_several_periods()
        return self.verb in WHOLE_GRID_VERBS

    def _has_several_periods(self) -> bool:
        """Whether the period of the drive changes along any dimension of the grid."""
        shape = self.grid.shape
        for axis in range(len(shape)):
            line = tuple(slice(0, n if k == axis else 1) for k, n in enumerate(shape))
            over = self.grid.over(line)
            periods = lay_out_ensemble(
                self.system, require_drive(self.drive), over, tells=False
            ).drive_periods()
            if periods is not None and not np.all(periods == periods[0]):
                return True
        return False

    def result_of(self, part: GridPart, progress: Any = None) -> xr.Dataset:
        """What the verb gives for a part of the grid; warnings of single points are left out."""
        return self.result_over(self.grid.over(part), progress)

    def result_over(self, over: Mapping[str, Any], progress: Any = None) -> xr.Dataset:
        """What the verb gives for these values."""
        function = verb_function(self.verb)
        parameters = inspect.signature(function).parameters
        arguments: dict[str, Any] = {next(iter(parameters)): self.system, **self.options}
        if "drive" in parameters:
            arguments["drive"] = self.drive
        if "progress" in parameters and progress is not None:
            arguments["progress"] = progress
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            result: xr.Dataset = function(**arguments, over=over)
        return result

    @cached_property
    def plain(self) -> dict[str, Any]:
        """The study as plain data, from which :func:`study_from_plain` makes an equal one.

        Raises
        ------
        InputError
            An option is no plain data.
        """
        return {
            "verb": self.verb,
            "system": to_plain_data(self.system),
            **({} if self.drive is None else {"drive": to_plain_data(self.drive)}),
            "over": {
                name: _plain_values(dims, values, self.grid)
                for name, (dims, values) in self.grid.fields.arrays.items()
            },
            "options": {name: plain_option(name, value) for name, value in self.options.items()},
        }

    @cached_property
    def text(self) -> str:
        """The plain data as JSON, always the same for equal studies.

        Names are sorted, but for those of the grid: their order is that of its dimensions.
        """
        parts = {
            key: json.dumps(value, sort_keys=key != "over", ensure_ascii=False)
            for key, value in sorted(self.plain.items())
        }
        return f"{{{', '.join(f'{json.dumps(key)}: {part}' for key, part in parts.items())}}}"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the text."""
        return hashlib.sha256(self.text.encode()).hexdigest()


def study_from_plain(plain: Mapping[str, Any]) -> Study:
    """The study that plain data describes; its numbers are equal bit for bit."""
    drive = plain.get("drive")
    return Study(
        plain["verb"],
        from_plain_data(plain["system"]),
        None if drive is None else from_plain_data(drive),
        {name: _values_from_plain(name, table) for name, table in plain["over"].items()},
        plain["options"],
    )


def code_identity() -> dict[str, str]:
    """What decides numbers beside the study: versions, sources, and the kind of processor."""
    processor = host_processor()
    features = hashlib.sha256(processor.features.encode()).hexdigest()[:16]
    return {
        "versions": package_versions(),
        "sources": source_digest(*_NUMERIC_SOURCES),
        "processor": f"{processor.cpu} {features}",
    }


def verb_function(verb: object) -> Callable[..., xr.Dataset]:
    """The public verb of this name.

    Raises
    ------
    InputError
        There is none that takes `over`.
    """
    if not is_verb_of_studies(verb):
        raise InputError(
            "verb",
            must=f"be one of {', '.join(verbs_of_studies())}",
            got=shortened_repr(verb),
            why="A study runs a verb that takes `over`.",
            fix="Check the name.",
        )
    function: Callable[..., xr.Dataset] = getattr(remanent, verb)
    return function


def verbs_of_studies() -> list[str]:
    """Names of the public verbs that take `over`; all of the package is imported for it."""
    return [name for name in sorted(remanent.__all__) if is_verb_of_studies(name)]


def is_verb_of_studies(name: object) -> TypeGuard[str]:
    """Whether this is the name of a public verb that takes `over`; it alone is imported."""
    if not isinstance(name, str) or name not in remanent.__all__:
        return False
    if not name[0].islower() or name in _OTHER_NAMES:
        return False
    function = getattr(remanent, name)
    return inspect.isfunction(function) and "over" in inspect.signature(function).parameters


#: Entries of an array that is an option of a study.
_MOST_ENTRIES: Final = 1_000_000
#: Lower-case public names that are no verbs, and take a while to import.
_OTHER_NAMES: Final = frozenset({"plot", "sweep"})


def plain_option(name: str, value: Any) -> Any:
    """An option as plain data: numbers, text, lists and tables."""
    if isinstance(value, np.ndarray | np.generic | xr.DataArray):
        value = _plain_entries(name, value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain_option(name, entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain_option(name, entry) for entry in value]
    raise InputError(
        name,
        must="be a number, text, or a list or table of these",
        got=shortened_repr(value),
        why="A study is kept as plain data, which another machine can read.",
        fix="Write it as numbers.",
    )


def _plain_entries(name: str, array: NDArray[Any] | np.generic | xr.DataArray) -> Any:
    if array.size > _MOST_ENTRIES:
        raise InputError(
            name,
            must=f"have at most {_MOST_ENTRIES} entries",
            got=f"{array.size} entries",
            why="A study is kept as plain data, all of which every worker reads.",
            fix="Pass fewer, or leave out the store.",
        )
    return (array.values if isinstance(array, xr.DataArray) else array).tolist()


def _plain_values(dims: tuple[str, ...], values: Any, grid: Grid) -> dict[str, Any]:
    labels = {}
    for dim in dims:
        if dim in grid.fields.labels:
            labels[dim] = _plain_labels(dim, grid.fields.labels[dim][1])
    table: dict[str, Any] = {"dims": list(dims), "values": values.tolist()}
    return {**table, "labels": labels} if labels else table


def _plain_labels(dim: str, labels: NDArray[Any]) -> list[Any]:
    if labels.dtype.kind not in "UOifb":
        raise InputError(
            "over",
            must=f"have labels along {dim!r} that are text or signed numbers",
            got=f"labels of {labels.dtype}",
            why="A study is kept as plain data, which another machine can read.",
            fix="Write them as text, by .astype(str), or leave out the store.",
        )
    plain: list[Any] = labels.tolist()
    return plain


def _values_from_plain(name: str, table: Mapping[str, Any]) -> Any:
    dims, values = tuple(table["dims"]), np.array(table["values"], dtype=np.float64)
    if is_plain_grid(name, dims, values):
        return values
    return xr.DataArray(values, dims=dims, coords=table.get("labels", {}))
