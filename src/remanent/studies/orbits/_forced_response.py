"""All branches of forced response of one system."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from remanent._typing import ArrayLike
from remanent.studies.ensemble.checks import require_drive_frequency, require_parameter_range
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.orbits._branch_tables import BranchTablesOfSystem, describe_branches
from remanent.studies.orbits._checks import require_not_in_over
from remanent.studies.orbits._tracing import TracingOptions, trace_all_branches


def require_frequency_range(omega_range: ArrayLike, ens: Ensemble) -> tuple[float, float]:
    """The lowest and the highest frequency of the drive, where it has one."""
    require_drive_frequency(
        ens.drive, "The frequency of the drive is what varies along the branches."
    )
    require_not_in_over(("omega",), ens)
    return require_parameter_range(
        "omega_range", omega_range, "omega", ens, "Branches are followed between them."
    )


def trace_all_forced_response_branches(
    member: Ensemble, options: TracingOptions, slices: int
) -> BranchTablesOfSystem:
    """All branches of forced response of one trajectory.

    Parameters
    ----------
    member : Ensemble
        Of one trajectory; its own frequency has no meaning, and may be anything.
    options : TracingOptions
        With ``omega`` as the parameter.
    slices : int
        Frequencies at which orbits are looked for.
    """
    middle = np.array([0.5 * sum(options.parameter_range)])
    centred = replace(member, parameter_values={**member.parameter_values, "omega": middle})
    tracing = options.tracing_of_member(centred)
    branches, missing = trace_all_branches(tracing, slices)
    return describe_branches(tracing, branches, options.parameter, missing)
