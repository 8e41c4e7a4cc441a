"""What is looked at, as plain data: the tables of a study file, read and written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from remanent import _checks
from remanent._errors import InputError
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.physical_sizes import PhysicalSizes
from remanent.models.plain import KIND_KEY, to_plain_data
from remanent.models.scaling import Scales
from remanent.models.system import System
from remanent.studies.sweep.faults import Fault, FaultsError, shown
from remanent.studies.sweep.numbers_with_units import sizes_of
from remanent.studies.sweep.parts_of_file import (
    actuator_from_table,
    drive_from_table,
    system_from_table,
)

#: A description of a system, a drive and a start, in plain data.
Spec = dict[str, Any]
#: The tables that a description may have.
_TABLES: Final = ("actuator", "system", "drive", "initial")
#: The rule of a value in the initial state.
_INITIAL_RULE: Final = _checks.finite_rule("It is a component of the state at time 0.")


def read_spec(content: object) -> tuple[System, Drive, dict[str, float]]:
    """The system, the drive and the initial values that a description holds.

    Parameters
    ----------
    content : object
        A table with ``actuator`` or ``system``, ``drive`` and perhaps ``initial``; the first two
        as in a study file.

    Returns
    -------
    system : System
    drive : Drive
    initial : dict of str to float
        Values of state variables at time 0; those that are not named are at rest.

    Raises
    ------
    FaultsError
        Every fault with its place, the rule and the remedy.
    """
    tables = _require_tables(content)
    faults: list[Fault] = []
    system: System | None = None
    drive: Drive | None = None
    initial: dict[str, float] = {}
    sizes = sizes_of(tables)
    for name in tables:
        try:
            if name == "actuator":
                system = actuator_from_table(tables[name], sizes)
            elif name == "system":
                system = system_from_table(tables[name])
            elif name == "drive":
                drive = drive_from_table(tables[name], sizes)
            else:
                initial = _initial_values(tables[name])
        except FaultsError as error:
            faults += [fault.below(name) for fault in error.faults]
    if faults or system is None or drive is None:
        raise FaultsError(faults)
    return system, drive, initial


def write_spec(system: System, drive: Drive, initial: Mapping[str, float]) -> Spec:
    """The description from which :func:`read_spec` reads a system, a drive and a start.

    Raises
    ------
    InputError
        A class that is not public, or physical sizes that are varied: no table says them.
    """
    spec: Spec = {}
    if isinstance(system, Actuator):
        spec["actuator"] = actuator_table(system)
    else:
        spec["system"] = to_plain_data(system)
    spec["drive"] = _drive_table(drive)
    if initial:
        spec["initial"] = {name: float(value) for name, value in initial.items()}
    return spec


def _require_tables(content: object) -> dict[str, Any]:
    """The tables in the order in which they are read, if they are those of a description."""
    if not isinstance(content, dict):
        raise FaultsError([_fault((), "be a table", shown(content))])
    faults = [
        _fault((str(name),), f"be one of {', '.join(_TABLES)}", shown(content[name]))
        for name in content
        if name not in _TABLES
    ]
    if ("actuator" in content) == ("system" in content):
        both = "both" if "actuator" in content else "neither"
        faults.append(_fault(("actuator",), "be there, or system, and not both", both))
    if "drive" not in content:
        faults.append(_fault(("drive",), "be given", "nothing"))
    if faults:
        raise FaultsError(faults)
    return {name: content[name] for name in _TABLES if name in content}


def _fault(path: tuple[str, ...], must: str, got: str) -> Fault:
    return Fault(
        path, must, got, "A motion is that of one system under one drive.",
        'Write for example {"actuator": {}, "drive": {"kind": "Constant", "m": 0.1}}.',
    )  # fmt: skip


def _initial_values(content: object) -> dict[str, float]:
    if not isinstance(content, dict):
        raise FaultsError([_fault((), "be a table of numbers", shown(content))])
    values: dict[str, float] = {}
    faults = []
    for name, value in content.items():
        try:
            values[str(name)] = _checks.require_real(str(name), value, _INITIAL_RULE)
        except InputError as error:
            faults.append(Fault((str(name),), error.must, shown(value), error.why, error.fix))
    if faults:
        raise FaultsError(faults)
    return values


def actuator_table(actuator: Actuator) -> dict[str, Any]:
    """The table [actuator]; sizes in SI stand in its table ``si``."""
    table = to_plain_data(actuator)
    del table[KIND_KEY]
    if table.pop("physical_sizes", None) is not None and actuator.physical_sizes != PhysicalSizes():
        raise InputError(
            "system",
            must="have physical sizes of 1",
            got=repr(actuator.physical_sizes),
            why="A study file gives sizes in its table [actuator.si].",
            fix="Build the actuator with rm.Actuator.from_si.",
        )
    scales = table.pop("scales", None)
    if scales is not None and actuator.scales is not None:
        table["si"] = _si_table(actuator, actuator.scales)
        # They follow from the lengths.
        for name in ("c", "edges"):
            table.pop(name, None)
    return table


def _si_table(actuator: Actuator, scales: Scales) -> dict[str, str]:
    length = scales.half_length
    table = {
        "shear_modulus": f"{scales.shear_modulus!r} Pa",
        "density": f"{scales.density!r} kg/m^3",
        "half_length": f"{length!r} m",
        "half_thickness": f"{math.sqrt(actuator.c) * length!r} m",
    }
    if actuator.edges is not None:
        table["half_width"] = f"{actuator.edges[1] * length!r} m"
    if scales.remanence is not None:
        table["remanence"] = f"{scales.remanence!r} T"
    return table


def _drive_table(drive: Drive) -> dict[str, Any]:
    """The table [drive]; of several loads, a table for each."""
    if isinstance(drive, Loads):
        return {name: to_plain_data(one) for name, one in drive.parts().items()}
    return to_plain_data(drive)
