"""From equal stretches to two of them: the same systems with both coordinates."""

from __future__ import annotations

from dataclasses import replace

from remanent._field import Role
from remanent.studies.ensemble.checks import require_actuator
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble


def with_two_coordinates(ens: Ensemble) -> tuple[Ensemble, dict[str, str]]:
    """An ensemble of one coordinate with two, and the second variable of each pair.

    The initial states stay those of one coordinate.
    """
    actuator = require_actuator("system", ens.system)
    load = actuator.prestress
    biaxial = lay_out_ensemble(actuator.replace(prestress=(load, load)), ens.drive)
    values = {name: v for name, v in ens.values.items() if name != "prestress"}
    values |= {f"prestress_{i}": ens.values["prestress"] for i in (1, 2)}
    first, second = biaxial.field.names_of_roles(Role.COORDINATE)
    pairs = {first: second}
    pairs |= zip(
        biaxial.field.names_belonging_to(first),
        biaxial.field.names_belonging_to(second),
        strict=True,
    )
    return replace(ens, system=biaxial.system, field=biaxial.field, values=values), pairs
