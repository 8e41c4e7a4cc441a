"""The kinds of parts that can be chosen in a page, each with usual numbers to start from."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from remanent.models.dissipation import Dissipation, KelvinVoigt, Rayleigh, Zener
from remanent.models.drives.base import Drive
from remanent.models.drives.chirp import Chirp
from remanent.models.drives.loads import Loads
from remanent.models.drives.piecewise import Ramp, Sampled, Steps
from remanent.models.drives.sines import Sines
from remanent.models.drives.waves import Constant, Sine, SineSquared
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.base import Material
from remanent.models.materials.named import Gent
from remanent.models.parts import Part
from remanent.models.plain import KIND_KEY, to_plain_data
from remanent.models.temperature_shift import TemperatureShift
from remanent.page.described import described_number, summary_of
from remanent.studies.sweep.parts_of_file import public_kinds

#: The kinds of parts, by the names of the groups of controls.
_GROUPS: Final[Mapping[str, type[Part]]] = MappingProxyType(
    {
        "drive": Drive,
        "material": Material,
        "dissipation": Dissipation,
        "heat": Heat,
        "magnet": Magnet,
        "shift": TemperatureShift,
    }
)
#: Times and loads of a sampled load to start from.
_SAMPLES: Final = ((0.0, 20.0, 40.0, 60.0, 80.0), (0.0, 0.2, 0.1, 0.3, 0.0))


def _starts() -> dict[type[Part], Part]:
    """Usual values to start from, where examples of a class are there to test it.

    A sampled load has the numbers of a ramp through its samples, which stands for it here: its
    spline takes a library that is slow to import, and the page waits for the menus.
    """
    values = (
        Constant(0.16), SineSquared(0.4, 1.25), Sine(0.16, 2.5, mean=0.16),
        Sines((0.1, 0.05), (1.0, 3.0), 2.5), Steps((0.0, 30.0, 60.0), (0.16, 0.32, 0.0)),
        Ramp((0.0, 30.0, 60.0), (0.0, 0.3, 0.1)), Chirp(0.05, 1.0, 4.0, 100.0, mean=0.1),
        Gent(30.0), Rayleigh(0.05), KelvinVoigt(0.01), Zener(0.5, 1.0),
    )  # fmt: skip
    return {**{type(value): value for value in values}, Sampled: Ramp(*_SAMPLES)}


def kinds() -> dict[str, list[dict[str, Any]]]:
    """Every kind of drive, material, dissipation, heat, magnet and shift that can be chosen.

    Returns
    -------
    dict of str to list of dict
        For each kind its ``name``, a ``text`` of one line, the ``table`` of a study file with usual
        values, and its numeric ``fields``, each with all that a slider has to know.
    """
    starts = _starts()
    return {
        group: [_kind(group, cls, starts.get(cls) or cls.example()) for cls in _choices(kind)]
        for group, kind in _GROUPS.items()
    }


def _choices(kind: type[Part]) -> list[type[Part]]:
    """The public classes of a kind; several loads at once are for systems of one's own."""
    return [cls for cls in public_kinds(kind).values() if cls is not Loads]


def _kind(group: str, cls: type[Part], value: Part) -> dict[str, Any]:
    prefix = "" if group == "drive" else f"{group}."
    rules = value.parameter_rules()
    fields = [
        described_number(name, number, rules[name], {}, cls, f"{prefix}{name}")
        for name, number in value.parameter_values().items()
    ]
    table = {**to_plain_data(value), KIND_KEY: cls.__name__}
    return {"name": cls.__name__, "text": summary_of(cls), "table": table, "fields": fields}
