"""Where the energies of a system exist, as straight-line code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from remanent._field import Field, Program, Role
from remanent.codegen.formula_program import program_of_several_values
from remanent.models.actuator import Actuator
from remanent.models.own_systems.written_system import WrittenSystem
from remanent.models.parts import part_parameters
from remanent.models.system import System


def limits_program(system: System, field: Field) -> Program | None:
    """What must be positive in every state that a motion reaches, besides positive variables.

    Parameters
    ----------
    system : System
    field : Field
        Its vector field.

    Returns
    -------
    Program or None
        One output for each condition; None where there is none.
    """

    def conditions(values: Mapping[str, Any], functions: Any) -> Sequence[Any]:
        if isinstance(system, Actuator):
            return _conditions_of_material(system, field, values, functions)
        if isinstance(system, WrittenSystem):
            return _conditions_of_signs(system, values, functions)
        return ()

    program = program_of_several_values(field.input_names, conditions)
    return program if program.output_slots else None


def _conditions_of_material(
    actuator: Actuator, field: Field, values: Mapping[str, Any], functions: Any
) -> Sequence[Any]:
    stretches = [values[name] for name in field.names_of_roles(Role.COORDINATE)]
    l1, l2 = stretches[0], stretches[-1]
    p = part_parameters("material", values)
    return actuator.material.admissibility_conditions(l1, l2, 1.0 / (l1 * l2), p, functions)


def _conditions_of_signs(
    system: WrittenSystem, values: Mapping[str, Any], functions: Any
) -> Sequence[Any]:
    """Each part of a formula that keeps its sign, times the same part at rest."""
    nothing = dict.fromkeys((*system.load_names, *system.rate_names()), 0.0)
    given = {name: values[name] for name in (*system.state_names, *system.parameter_values())}
    here = {**nothing, **given}
    rest = {**nothing, **given, **system.rest_values()}
    return [part(here, functions) * part(rest, functions) for part in system.sign_conditions()]
