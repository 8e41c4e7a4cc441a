"""Ensembles over physical sizes, which are numeric fields of an actuator like others.

Shear modulus, density and remanence enter the equations of motion themselves, in the units of
the actuator as it was built (see :class:`~remanent.models.physical_sizes.PhysicalSizes`), so
that nothing has to be converted from one trajectory to the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import ArrayLike, FloatArray
from remanent.integrate.ensemble.problem import Problem
from remanent.models.drives.base import Drive
from remanent.models.physical_sizes import PHYSICAL_SIZE_RULE, PHYSICAL_SIZES
from remanent.models.system import System
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem

__all__ = ["PHYSICAL_SIZES", "PHYSICAL_SIZE_RULE", "PhysicalScales", "lay_out_physical_scales"]


@dataclass(frozen=True)
class PhysicalScales:
    """An ensemble in which shear modulus, density and remanence differ as well.

    Attributes
    ----------
    ensemble_in_own_units
        Its values are in the units of the actuator as it was built.
    """

    ensemble_in_own_units: Ensemble

    @property
    def time_factor_to_trajectory_unit(self) -> FloatArray:
        """1: every trajectory has the actuator's unit of time, array (trajectory,)."""
        return np.ones(self.ensemble_in_own_units.trajectory_count)

    @property
    def load_factor_to_trajectory_unit(self) -> FloatArray:
        """1: every trajectory has the actuator's unit of load, array (trajectory,)."""
        return np.ones(self.ensemble_in_own_units.trajectory_count)

    def build_problem_lasting(self, duration: FloatArray) -> Problem:
        """The trajectories, each lasting `duration`."""
        return initial_value_problem(self.ensemble_in_own_units, duration)


def lay_out_physical_scales(
    system: System,
    drive: Drive,
    over: OverArgument | None = None,
    initial: ArrayLike | None = None,
    *,
    reserved: frozenset[str] = frozenset({"time", "cycle", "step"}),
    tells: bool = True,
) -> PhysicalScales:
    """Lay out trajectories over numeric fields, the physical sizes among them."""
    return PhysicalScales(
        lay_out_ensemble(system, drive, over, initial, reserved=reserved, tells=tells)
    )
