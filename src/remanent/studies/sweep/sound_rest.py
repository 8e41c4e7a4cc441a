"""What is left of a study file without its faults, so that the verb can be asked of the rest."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

from remanent.models.drives.base import Drive
from remanent.models.plain import to_plain_data
from remanent.models.system import System
from remanent.studies.sweep.faults import Fault
from remanent.studies.sweep.parts_of_file import KIND, public_kinds

#: Keys of [actuator] on which names of numeric fields depend.
_STRUCTURAL: Final = frozenset({"material", "dissipation", "heat", "magnet", "si", "edges"})


def without_faults(document: Mapping[str, Any], faults: Iterable[Fault]) -> dict[str, Any]:
    """The tables of a file without the keys that have faults.

    Parameters
    ----------
    document : mapping
        The whole file.
    faults : iterable of Fault

    Returns
    -------
    dict
        A table is missing where nothing is known of what it would be without its faults.
    """
    wrong: dict[str, set[str]] = {}
    for fault in faults:
        table, *key = map(str, fault.path or ("",))
        wrong.setdefault(table, set()).add(key[0] if key else "")
    rest = {name: _rest(name, table, wrong.get(name, set())) for name, table in document.items()}
    return {name: table for name, table in rest.items() if table is not None}


def _rest(name: str, table: Any, wrong: set[str]) -> Any:
    """A table without some of its keys; None where it cannot do without them."""
    if not wrong:
        return table
    lost = (
        "" in wrong or not isinstance(table, dict) or (name == "actuator" and wrong & _STRUCTURAL)
    )
    if lost:
        return None
    rest = {key: value for key, value in table.items() if key not in wrong}
    return _completed_drive(rest) if name == "drive" else rest


def _completed_drive(rest: dict[str, Any]) -> dict[str, Any] | None:
    """A drive with usual numbers where it has none."""
    cls: Any = public_kinds(Drive).get(str(rest.get(KIND)))
    return None if cls is None else {**to_plain_data(cls.example()), **rest}


def usual_over(system: System) -> dict[str, list[float]]:
    """One field of a system with its own value."""
    name, value = next(iter(system.parameter_values().items()), ("", 0.0))
    return {name: [value]} if name else {}
