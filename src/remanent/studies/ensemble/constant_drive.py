"""The drive of a load that does not change, or of several."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.drives.waves import Constant
from remanent.models.system import System

#: What ``m`` accepts: the load, or the loads by their names.
ConstantLoadArgument: TypeAlias = float | Mapping[str, float]


def constant_drive(system: System, m: ConstantLoadArgument) -> Drive:
    """A constant for each load of a system.

    Parameters
    ----------
    system : System
    m : float, or mapping of str to float
        The load; of a system with loads that have names of their own, a mapping of these to
        numbers, in which those that are left out are 0.

    Raises
    ------
    InputError
        Unknown names, or one number for several loads.
    """
    names = system.load_names
    if isinstance(m, Mapping):
        _require_loads_of_system(m, names)
        given = {name: m.get(name, 0.0) for name in names}
    elif len(names) == 1 or (isinstance(m, int | float) and m == 0.0):
        given = dict.fromkeys(names, m)
    else:
        raise InputError(
            "m",
            must=f"give the loads by their names: {', '.join(names)}",
            got=shortened_repr(m),
            why="One number does not say which load it is.",
            fix=f"Pass {{{', '.join(f'{name!r}: ...' for name in names)}}}.",
        )
    if names == ("load",):
        return Constant(given["load"])
    return Loads({name: Constant(value) for name, value in given.items()})


def _require_loads_of_system(m: Mapping[str, float], names: tuple[str, ...]) -> None:
    """Refuse names of loads that the system does not have, and none at all."""
    if not m:
        raise InputError(
            "m",
            must=f"name loads of the system: {', '.join(names)}",
            got="none",
            why="A mapping says which load has which value.",
            fix=f"Pass for example {{{names[0]!r}: 0.1}}, or leave it out for no load.",
        )
    for name in m:
        if name not in names:
            raise InputError(
                "m",
                must=f"name loads of the system: {', '.join(names)}",
                got=shortened_repr(name),
                why="A load that it does not have changes nothing.",
                fix=f"Pass for example {{{names[0]!r}: 0.1}}.",
            )
