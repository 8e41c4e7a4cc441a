"""Loads that are held constant: what ``m`` of statics and of free oscillations accepts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, TypeAlias

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.drives.waves import Constant
from remanent.models.system import System

#: The load of systems that have one and do not name it.
_ONE_LOAD: Final = "load"
#: What ``m`` accepts: the load, or the value of each load by its name.
ConstantLoads: TypeAlias = float | Mapping[str, float]


def constant_loads(system: System, m: ConstantLoads) -> Drive:
    """The drive that holds the loads of a system.

    Parameters
    ----------
    system : System
    m : float, or mapping of str to float
        The one load; of a system with named loads the value of each, in any order.

    Returns
    -------
    Drive
        :class:`~remanent.Constant`, or one for each name.

    Raises
    ------
    InputError
        Where `m` does not give the loads that the system has.
    """
    names = system.load_names
    if isinstance(m, Mapping) and set(m) == set(names):
        loads = {name: Constant(m[name]) for name in names}
        return loads[_ONE_LOAD] if names == (_ONE_LOAD,) else Loads(loads)
    if not isinstance(m, Mapping) and names == (_ONE_LOAD,):
        return Constant(m)
    values = ", ".join(f'"{name}": 0.2' for name in names)
    raise InputError(
        "m",
        must=f"give the loads of the system: {', '.join(names)}",
        got=shortened_repr(m),
        why="Every load in the equations of motion has a value.",
        fix="Pass one number." if names == (_ONE_LOAD,) else f"Pass for example {{{values}}}.",
    )
