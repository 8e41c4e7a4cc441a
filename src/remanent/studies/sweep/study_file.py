"""Reading a study file: TOML in, a study out, or every fault of the file in one message."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, Final, TypeVar

from pydantic import Field

from remanent._checks import positive_rule
from remanent._errors import InputWarning, warn_of_input
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.sweep.faults import (
    Fault,
    FaultsError,
    StudyFileError,
    first_of_each_place,
    meant,
    read_each,
    shown,
)
from remanent.studies.sweep.numbers_with_units import Sizes, number, sizes_of
from remanent.studies.sweep.parts_of_file import (
    actuator_from_table,
    drive_from_table,
    system_from_table,
)
from remanent.studies.sweep.sound_rest import usual_over, without_faults
from remanent.studies.sweep.study import Study, is_verb_of_studies, verb_function, verbs_of_studies
from remanent.studies.sweep.tables import Table, not_a_table_fault, read_table
from remanent.studies.sweep.toml_text import faults_of_values, read_document
from remanent.studies.sweep.values_over import no_fields_fault, option_from_value, over_from_table
from remanent.studies.sweep.verb_checks import (
    faults_of_fields,
    faults_of_options,
    faults_of_verb,
)

Value = TypeVar("Value")
_SECONDS_RULE: Final = positive_rule(
    "A point that takes longer is given up.", "Leave it out for no cap, or write 60."
)


@dataclass(frozen=True)
class StudyFile:
    """What a study file says.

    Attributes
    ----------
    study : Study
    store : Path or None
        Where results go, a folder within that of the file; None where the file names none.
    point_seconds : float or None
        Seconds after which a point is given up; None for no cap.
    """

    study: Study
    store: Path | None
    point_seconds: float | None


def read_study(path: str | Path) -> StudyFile:
    """The study in a file.

    Parameters
    ----------
    path : str or pathlib.Path
        A file in TOML: ``verb``, ``store`` and ``point_seconds``, and the tables ``[actuator]`` or
        ``[system]``, ``[drive]``, ``[over]`` and ``[options]``.  Nothing in it is ever run.

    Returns
    -------
    StudyFile

    Raises
    ------
    StudyFileError
        The file is refused; the message has a line for each fault, with its table and key, the
        rule and the remedy, or names the line where the syntax is wrong.
    RemanentError
        The file cannot be read.

    Notes
    -----
    The verb is asked for what it has against its arguments, without computing anything.  Values
    that are allowed but look like a mistake draw a warning.
    """
    path = Path(path)
    document = read_document(path)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        found, faults = _read(document, path)
    if found is None:
        raise StudyFileError(path.name, first_of_each_place(faults))
    for message in dict.fromkeys(str(one.message) for one in caught):
        warn_of_input(f"{path.name}: {message}")
    return found


class _Top(Table):
    """The keys at the top; what the tables hold is read one by one, as they need each other."""

    verb: str = Field(description="It says what is computed.", examples=['verb = "classify"'])
    store: str | None = Field(
        None, description="It is the folder for the results.", examples=['store = "chart.zarr"']
    )
    point_seconds: Any = None
    actuator: Any = None
    system: Any = None
    drive: Any = None
    over: Any = None
    options: Any = None


def _read(document: dict[str, Any], path: Path) -> tuple[StudyFile | None, list[Fault]]:
    """What a file says, or all of its faults."""
    sizes = sizes_of(document)
    verb, of_verb = _tried(lambda: _known_verb(document.get("verb")), "verb")
    _, of_top = _tried(lambda: read_table(_Top, document, "the file"))
    store, of_store = _tried(lambda: _store(document.get("store"), path), "store")
    seconds, of_cap = _tried(lambda: _seconds(document.get("point_seconds")), "point_seconds")
    system, of_system = _tried(lambda: _system(document, sizes))
    drive, of_drive = _tried(lambda: _drive(document, verb, sizes), "drive")
    over, of_over = _tried(lambda: _over(document, sizes), "over")
    options, of_options = _tried(lambda: _options(document, sizes), "options")
    faults = [
        *faults_of_values(document),
        *of_top, *of_verb, *of_store, *of_cap, *of_system, *of_drive, *of_over, *of_options,
    ]  # fmt: skip
    if verb is not None and options is not None:
        faults += faults_of_options(verb, options)
    has_drive = drive is not None or ("drive" not in document and not of_drive)
    if system is not None and over is not None and has_drive:
        faults += faults_of_fields(over, system, drive)
    if verb is not None:
        faults += _refused_by_verb(verb, document, faults)
    if faults:
        return None, faults
    assert verb is not None
    assert system is not None
    assert over is not None
    study = Study(verb, system, drive, over, options or {})
    return StudyFile(study, store, seconds), []


def _tried(read: Callable[[], Value], *place: str) -> tuple[Value | None, list[Fault]]:
    """What is read, or None and the faults with their place."""
    try:
        return read(), []
    except FaultsError as error:
        return None, [fault.below(*place) for fault in error.faults]


def _refused_by_verb(verb: str, document: dict[str, Any], faults: Sequence[Fault]) -> list[Fault]:
    """What the verb refuses beside what has faults already, which is left out where that goes."""
    sound = without_faults(document, faults)
    sizes = sizes_of(sound)
    try:
        system = _system(sound, sizes)
        drive = _drive(sound, verb, sizes)
        over = _over(sound, sizes) if sound.get("over") else usual_over(system)
        options = _options(sound, sizes)
    except FaultsError:
        return []
    told = faults_of_verb(verb, system, drive, over, options) if over else []
    # Of tables that were changed above nothing is said, as the file does not hold them so.
    changed = {str(fault.path[0]) for fault in faults if fault.path} - {"over", "options"}
    return [fault for fault in told if fault.path[0] not in changed]


# Table by table -----------------------------------------------------------------------------


def _known_verb(verb: object) -> str:
    """The name of a verb; what is no text, and what is missing, is told with the other keys."""
    if isinstance(verb, str) and not is_verb_of_studies(verb):
        names = verbs_of_studies()
        raise FaultsError([
            Fault((), f"be one of {', '.join(names)}", shown(verb),
                  "A study runs a verb that takes `over`.",
                  meant(verb, names).strip() or 'Write for example verb = "classify".')
        ])  # fmt: skip
    if not isinstance(verb, str):
        raise FaultsError([])
    return verb


def _store(name: object, path: Path) -> Path | None:
    """The folder for the results, within that of the file."""
    if not isinstance(name, str):
        return None
    both = (PurePosixPath(name), PureWindowsPath(name))
    outside = any(one.anchor or ".." in one.parts for one in both)
    empty = not PurePosixPath(name).parts or not name.isprintable()
    if outside or empty or (path.parent / name) == path:
        raise FaultsError([
            Fault((), "be the name of a folder within that of the file", shown(name),
                  "A file says nothing of other folders.",
                  'Write for example store = "chart.zarr"; --out takes any path.')
        ])  # fmt: skip
    return path.parent / name


def _seconds(value: object) -> float | None:
    """The cap on a point, in seconds."""
    if value is None:
        return None
    if isinstance(value, str):
        raise FaultsError([
            Fault((), "be a number of seconds", shown(value), "It is the time of a clock.",
                  "Write for example point_seconds = 60.")
        ])  # fmt: skip
    return number(value, "point_seconds", Sizes(), _SECONDS_RULE)


def _system(document: Mapping[str, Any], sizes: Sizes) -> System:
    """The actuator or the system of one's own."""
    given = [name for name in ("actuator", "system") if name in document]
    if len(given) != 1:
        raise FaultsError([
            Fault(("actuator",), "be given, or [system], one of them",
                  "both" if given else "nothing", "One system moves.",
                  "Remove one of them." if given else "Write [actuator] for an actuator at 293 K.")
        ])  # fmt: skip
    content = document[given[0]]
    try:
        return actuator_from_table(content, sizes) if given == ["actuator"] else (
            system_from_table(content)
        )  # fmt: skip
    except FaultsError as error:
        raise FaultsError(fault.below(given[0]) for fault in error.faults) from None


def _drive(document: Mapping[str, Any], verb: str | None, sizes: Sizes) -> Drive | None:
    """The drive, where the verb takes one."""
    takes = verb is None or "drive" in inspect.signature(verb_function(verb)).parameters
    if "drive" in document and not takes:
        raise FaultsError([
            Fault((), f"be left out for {verb}", "a table",
                  "This verb asks what happens under constant loads, or without any.",
                  "Remove the table; a constant load is the option m.")
        ])  # fmt: skip
    if "drive" in document:
        return drive_from_table(document["drive"], sizes)
    if takes and verb is not None:
        raise FaultsError([
            Fault((), f"be given for {verb}", "nothing", "The load is a function of time.",
                  'Write [drive] with kind = "SineSquared", b = 0.4 and omega = 1.25 below it.')
        ])  # fmt: skip
    return None


def _over(document: Mapping[str, Any], sizes: Sizes) -> dict[str, Any]:
    if "over" not in document:
        raise FaultsError([no_fields_fault()])
    return over_from_table(document["over"], sizes)


def _options(document: Mapping[str, Any], sizes: Sizes) -> dict[str, Any]:
    """The options of the verb."""
    options = document.get("options", {})
    if not isinstance(options, dict):
        raise FaultsError([not_a_table_fault(options)])
    return read_each(options, lambda name, value: option_from_value(name, value, sizes))
