"""What the verb of a study has against its arguments, found before anything is computed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from remanent._errors import InputError
from remanent._threads import WorkStopped, work_stopped_after
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.invalid import FINITE_RULE
from remanent.studies.ensemble.layout import numeric_fields
from remanent.studies.sweep.faults import (
    Fault,
    KeyPath,
    fault_of,
    in_file,
    meant,
    shown,
    unknown_key_fault,
)
from remanent.studies.sweep.grid import Grid
from remanent.studies.sweep.study import NO_OPTIONS, Study, verb_function

#: Arguments of verbs that have a table of their own.
_OWN_TABLES: Final[Mapping[str, str]] = {
    "system": "system", "actuator": "actuator", "drive": "drive", "over": "over",
}  # fmt: skip
#: Values of options of every kind that verbs must be given, to look for faults of the others.
_STAND_INS: Final = (
    None, 200, 1.1, [1.0, 1.1], "omega", "stretch", "fold", {"stretch": [1.0, 1.1]},
    ["omega", "b"], [[1.0, 1.1], [0.3, 0.4]],
)  # fmt: skip
#: Most points of a grid.
_MAX_POINTS: Final = 1_000_000_000


def option_names(verb: str) -> list[str]:
    """Names of the options of a verb."""
    return [name for name in inspect.signature(verb_function(verb)).parameters
            if name not in NO_OPTIONS]  # fmt: skip


def faults_of_options(verb: str, options: Mapping[str, Any]) -> list[Fault]:
    """Options that the verb does not have, and those that are missing."""
    known = option_names(verb)
    title = f"[options] of {verb}"
    faults = [
        _own_table_fault(name) if name in _OWN_TABLES else unknown_key_fault(name, known, title, v)
        for name, v in options.items()
        if name not in known
    ]
    parameters = inspect.signature(verb_function(verb)).parameters
    faults += [
        Fault((name,), f"be given for {verb}", "nothing", "It has no usual value.",
              f"Write {name} = ... below [options].")
        for name in known
        if parameters[name].default is inspect.Parameter.empty and name not in options
    ]  # fmt: skip
    return [fault.below("options") for fault in faults]


def _own_table_fault(name: str) -> Fault:
    return Fault((name,), "be left out of [options]", "a value", "It has a table of its own.",
                 f"Write it as [{_OWN_TABLES[name]}].")  # fmt: skip


def faults_of_fields(over: Mapping[str, Any], system: System, drive: Drive | None) -> list[Fault]:
    """Names in [over] that no field has, and values that break the rule of their field."""
    rules = {**system.parameter_rules(), **({} if drive is None else drive.parameter_rules())}
    known = _field_names(system, drive)
    faults = []
    for name, values in over.items():
        rule = rules.get(name, FINITE_RULE)
        broken = np.asarray(values)[~rule.is_satisfied_by(values)]
        if name not in known and not name.startswith("initial."):
            faults.append(_unknown_field_fault(name, known))
        elif broken.size:
            got = shown(float(broken[0]))
            faults.append(Fault((name,), rule.must, got, rule.why, in_file(rule.fix)))
    return [fault.below("over") for fault in faults]


def _field_names(system: System, drive: Drive | None) -> list[str]:
    """Names of the numeric fields; verbs without a drive have a constant load."""
    return [*numeric_fields(system), *(("m",) if drive is None else drive.parameter_values())]


def _unknown_field_fault(name: str, known: list[str]) -> Fault:
    return Fault(
        (name,), "be a numeric field of the system or of the drive", shown(name),
        "Only fields that enter the equations of motion can be varied.",
        f"{meant(name, known)}Write one of {', '.join(known)}, or initial.NAME of a state.",
    )  # fmt: skip


def faults_of_verb(
    verb: str,
    system: System,
    drive: Drive | None,
    over: Mapping[str, Any],
    options: Mapping[str, Any],
) -> list[Fault]:
    """What the verb refuses, one argument after the other.

    The verb is called for the first point of the grid, and stopped when it begins to compute.
    What it refuses is left out, or replaced where it has to be given, and the verb is called
    again, until it refuses nothing more.

    Parameters
    ----------
    verb : str
    system : System
    drive : Drive or None
    over, options : mapping of name to value

    Returns
    -------
    list of Fault
    """
    faults: list[Fault] = []
    over, options = dict(over), dict(options)

    def refusal(**others: Any) -> InputError | None:
        return _refusal(verb, system, drive, over, {**options, **others})

    for _ in range(len(over) + len(option_names(verb)) + 1):
        error = refusal()
        if error is None:
            break
        path = _place(error, over, options, system)
        faults.append(_fault_at(path, error))
        name = str(path[-1] if path[0] == "over" else path[min(1, len(path) - 1)])
        if path[0] == "over" and name in over and len(over) > 1:
            del over[name]
            continue
        given = options.pop(name, None)
        stand_in = _stand_in(name, refusal) if path[0] == "options" else None
        options |= {} if stand_in is None else {name: stand_in}
        if given is None and stand_in is None:
            break
    return faults


def _stand_in(name: str, refusal: Callable[..., InputError | None]) -> object:
    """A value that the verb does not refuse for an option, None where it can be left out."""
    for value in _STAND_INS:
        error = refusal(**{} if value is None else {name: value})
        if error is None or error.name.partition("[")[0] != name:
            return value
    return None


def message_for_file(error: InputError, study: Study) -> str:
    """What a verb said against a study, with the table and key of the file that it is about."""
    path = _place(error, study.over, study.options, study.system)
    return _fault_at(path, error).text


def _refusal(
    verb: str,
    system: System,
    drive: Drive | None,
    over: Mapping[str, Any],
    options: Mapping[str, Any],
) -> InputError | None:
    try:
        study = Study(verb, system, drive, over, options)
        _require_points(study.grid)
        with work_stopped_after(0.0):
            study.result_of(tuple(slice(0, 1) for _ in study.grid.shape))
    except InputError as error:
        return error
    except WorkStopped:
        return None
    return None


def _fault_at(path: KeyPath, error: InputError) -> Fault:
    said = fault_of(error, {})
    return Fault(path, said.must, said.got, said.why, said.fix)


def _require_points(grid: Grid) -> None:
    if grid.point_count > _MAX_POINTS:
        raise InputError(
            "over",
            must=f"have at most {_MAX_POINTS} points",
            got=f"{' x '.join(map(str, grid.shape))} = {grid.point_count}",
            why="A store has a number for each.",
            fix="Take fewer values, or quasi-random points in [over.sobol].",
        )


def _place(
    error: InputError, over: Mapping[str, Any], options: Mapping[str, Any], system: System
) -> KeyPath:
    """Where in a file the argument stands that an error is about."""
    tables = {"over": over, "options": options}
    inner = fault_of(error, tables).path
    table = "actuator" if isinstance(system, Actuator) else "system"
    if inner[0] in ("over", "options", "drive"):
        return inner
    if inner[0] in ("system", "actuator"):
        return (table,)
    if error.name in numeric_fields(system) and error.name not in options:
        return (table, error.name)
    head = error.name.partition(".")[0]
    return ("options", head if head in options else error.name)
