"""From equal stretches to two of them: the same systems with both coordinates."""

from __future__ import annotations

from dataclasses import replace

from remanent._field import Role
from remanent.studies.ensemble.checks import require_actuator
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble


def ensemble_with_two_coordinates(ens: Ensemble) -> tuple[Ensemble, dict[str, str]]:
    """An ensemble of one coordinate with two, and the second variable of each pair.

    The initial states stay those of one coordinate.
    """
    actuator = require_actuator("system", ens.system)
    load = actuator.prestress
    biaxial = lay_out_ensemble(actuator.replace(prestress=(load, load)), ens.drive)
    values = {name: v for name, v in ens.parameter_values.items() if name != "prestress"}
    values |= {f"prestress_{i}": ens.parameter_values["prestress"] for i in (1, 2)}
    first, second = biaxial.vector_field.names_of_roles(Role.COORDINATE)
    pairs = {first: second}
    pairs |= zip(
        biaxial.vector_field.names_belonging_to(first),
        biaxial.vector_field.names_belonging_to(second),
        strict=True,
    )
    return replace(
        ens, system=biaxial.system, vector_field=biaxial.vector_field, parameter_values=values
    ), pairs
