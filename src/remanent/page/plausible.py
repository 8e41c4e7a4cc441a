"""How large numbers may be that a page follows: beyond, no block of rubber is meant.

Rules of the model say what is no number of it at all, and the package computes whatever they
allow.  A page is told its numbers by hand and by addresses, where a slip of the keyboard is
likelier than a block at a thousand million kelvin.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.page.spec import write_spec
from remanent.studies.sweep.faults import Fault, KeyPath


@dataclass(frozen=True)
class Bounds:
    """Between which numbers a page follows a value.

    Attributes
    ----------
    least, most
        Both are allowed.
    why
        A sentence.
    """

    least: float
    most: float
    why: str

    @property
    def must(self) -> str:
        """The rule in words."""
        return f"be between {self.least:g} and {self.most:g} on a page"

    @property
    def plain(self) -> dict[str, Any]:
        """As a page knows it."""
        return {
            "least": self.least, "least_included": True,
            "most": self.most, "most_included": True,
            "rule": f"It must {self.must}. {self.why}",
        }  # fmt: skip


_PYTHON: Final = "In Python it can be computed, if it is meant."
_SIZE: Final = 1e9
_USUAL: Final = Bounds(-_SIZE, _SIZE, f"Larger numbers are rarely meant. {_PYTHON}")
_KELVIN: Final = Bounds(
    1.0, 2000.0, f"At other temperatures rubber is glass, or has burnt. {_PYTHON}"
)
_STRESS: Final = Bounds(
    -1e3, 1e3, f"It is a multiple of the shear modulus, which no rubber stands. {_PYTHON}"
)
_LOAD: Final = Bounds(
    -1e3, 1e3, f"It is a multiple of the load that the shear modulus balances. {_PYTHON}"
)
_FREQUENCY: Final = Bounds(
    1e-6, 1e6, f"The block itself vibrates at a few radians in a unit of time. {_PYTHON}"
)
_ENDS_OF_CHIRP: Final = Bounds(-_FREQUENCY.most, _FREQUENCY.most, _FREQUENCY.why)
_RATIO: Final = Bounds(1e-6, 1e6, f"It is a ratio of lengths of one block. {_PYTHON}")
_ANGLE: Final = Bounds(-1e4, 1e4, "It is an angle, of which whole turns change nothing.")
_STRETCH: Final = Bounds(1e-3, 1e3, f"It is a ratio of lengths of one block. {_PYTHON}")
_RATE: Final = Bounds(-1e4, 1e4, f"The block itself moves at rates of about one. {_PYTHON}")
#: By the dotted name, its numbers left out: numbers of parts have names of their own.
_BOUNDS: Final[Mapping[str, Bounds]] = MappingProxyType(
    {
        "temperature": _KELVIN, "reference_temperature": _KELVIN, "body_temperature": _KELVIN,
        "c": _RATIO, "edges": _RATIO, "prestress": _STRESS,
        "stretch": _STRETCH, "dissipation.viscous_stretch": _STRETCH,
        "b": Bounds(-30.0, 30.0, _LOAD.why), "m": _LOAD, "mean": _LOAD, "loads": _LOAD,
        "omega": _FREQUENCY, "start": _ENDS_OF_CHIRP, "stop": _ENDS_OF_CHIRP,
        "phase": _ANGLE, "phases": _ANGLE,
    }
)  # fmt: skip


#: The same of sizes in SI, in units without prefixes.
_PHYSICAL: Final = Bounds(1e-12, 1e15, "No block has such a size, density or stiffness.")


def bounds_of(name: str, system: System) -> Bounds:
    """Between which numbers a page follows a numeric field, or a state variable at the start.

    Parameters
    ----------
    name : str
        Its dotted name.
    system : System
        That it is of, or of whose drive; nothing is known of the numbers of systems of one's own.
    """
    if not isinstance(system, Actuator):
        return _USUAL
    plain = re.sub(r"\.\d+", "", name)
    if plain.endswith("_rate"):
        return _RATE
    return _BOUNDS.get(re.sub(r"_[12]$", "", plain), _USUAL)


def faults_of_size(system: System, drive: Drive, initial: Mapping[str, float]) -> list[Fault]:
    """Every number of a system, a drive and a start that no page follows, with its place."""
    return [
        Fault(path, bounds.must, f"{value:g}", bounds.why, "Give another number.")
        for path, value, bounds in _numbers(system, drive, initial)
        if not bounds.least <= value <= bounds.most
    ]


def _numbers(
    system: System, drive: Drive, initial: Mapping[str, float]
) -> Iterator[tuple[KeyPath, float, Bounds]]:
    """Every number in the tables of a description, with its place and its bounds."""
    waiting: list[tuple[KeyPath, Any]] = [((), write_spec(system, drive, initial))]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, dict):
            waiting += [((*path, key), one) for key, one in value.items()]
        elif isinstance(value, list | tuple):
            waiting += [((*path, k), one) for k, one in enumerate(value)]
        elif path[:2] == ("actuator", "si"):
            yield path, float(str(value).partition(" ")[0]), _PHYSICAL
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield path, float(value), bounds_of(".".join(map(str, path[1:])), system)
