"""Why nothing is computed at a point: the rule that a varied value breaks, in words."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from remanent._checks import Rule, finite_rule
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.ensemble import Ensemble

#: What a varied initial value must be, and fields without a rule of their own.
FINITE_RULE: Final = finite_rule("Nothing is computed from anything else.")
#: What is said where each value by itself is allowed.
NO_SINGLE_REASON: Final = "the values do not go together, or the start is no state"


def varied_rules(system: System, drive: Drive) -> dict[str, Rule]:
    """The rules of the numeric fields of a system and a drive by name."""
    return {**system.parameter_rules(), **drive.parameter_rules()}


def reasons_of_invalid(ens: Ensemble) -> NDArray[np.str_]:
    """Why nothing is computed for a trajectory, array (trajectory,); empty where something is."""
    rules = varied_rules(ens.system, ens.drive)
    reasons: NDArray[Any] = np.where(ens.is_invalid, NO_SINGLE_REASON, "").astype(object)
    for name in ens.coords:
        rule = rules.get(name, FINITE_RULE)
        broken = ens.is_invalid & ~rule.is_satisfied_by(_values_of(ens, name))
        reasons[broken] = f"{name} must {rule.must}"
    return reasons.astype(np.str_)


def _values_of(ens: Ensemble, name: str) -> FloatArray:
    """Values of a varied field for each trajectory; zeros where it is none that is kept."""
    state_name = name.removeprefix("initial.")
    if name != state_name and state_name in ens.vector_field.state_names:
        return ens.initial_states[:, ens.vector_field.state_names.index(state_name)]
    return ens.parameter_values.get(name, np.ones(ens.trajectory_count))
