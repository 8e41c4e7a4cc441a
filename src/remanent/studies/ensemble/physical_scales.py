"""Physical sizes that scale several dimensionless numbers at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from remanent._checks import Rule, positive_rule
from remanent._errors import InputError
from remanent._timeline import Timeline
from remanent._typing import ArrayLike, FloatArray
from remanent.integrate.ensemble.problem import Problem
from remanent.models.drives.base import Drive
from remanent.models.drives.piecewise import PiecewiseDrive
from remanent.models.system import System
from remanent.results.schema import QuantityKind, describe
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Names of the sizes; each counts in units of what the actuator was built with.
PHYSICAL_SIZES = ("shear_modulus", "density", "remanence")
PHYSICAL_SIZE_RULE: Rule = positive_rule(
    "It is a physical size over the one that the actuator was built with.",
    "Pass 1 for no change, 1.05 for five per cent more.",
)
#: Exponents of shear modulus, density and remanence in a quantity of each kind, held
#: fixed in SI: stresses count in mu, times in L sqrt(rho/mu), loads in mu mu0/B_r, the
#: own field is B_r^2/(mu mu0), and what couples heat mu/(rho c_p T0).
_SIZE_EXPONENTS_OF_KIND: Mapping[QuantityKind, tuple[float, float, float]] = MappingProxyType(
    {
        QuantityKind.STRESS: (-1.0, 0.0, 0.0),
        QuantityKind.LOAD: (-1.0, 0.0, 1.0),
        QuantityKind.ROOT_LOAD: (-0.5, 0.0, 0.5),
        QuantityKind.OWN_FIELD: (-1.0, 0.0, 2.0),
        QuantityKind.COUPLING: (1.0, -1.0, 0.0),
        QuantityKind.TIME: (0.5, -0.5, 0.0),
        QuantityKind.RATE: (-0.5, 0.5, 0.0),
        QuantityKind.FREQUENCY: (-0.5, 0.5, 0.0),
        QuantityKind.VISCOSITY: (-0.5, -0.5, 0.0),
    }
)


@dataclass(frozen=True)
class PhysicalScales:
    """An ensemble in which shear modulus, density and remanence differ as well.

    Attributes
    ----------
    ensemble_in_own_units
        Its values are in the units of each trajectory's own sizes.
    size_ratios : array (size, trajectory)
        :data:`PHYSICAL_SIZES`, over what the actuator was built with.
    """

    ensemble_in_own_units: Ensemble
    size_ratios: FloatArray

    @property
    def time_factor_to_trajectory_unit(self) -> FloatArray:
        """Own times over times in the actuator's unit, array (trajectory,)."""
        return _trajectory_unit_factor_of_kind(QuantityKind.TIME, self.size_ratios)

    @property
    def load_factor_to_trajectory_unit(self) -> FloatArray:
        """Own loads over loads in the actuator's unit, array (trajectory,)."""
        return _trajectory_unit_factor_of_kind(QuantityKind.LOAD, self.size_ratios)

    def variable_factor_to_trajectory_unit(self, name: str) -> FloatArray:
        """Own values of a variable over those in the actuator's unit, array (trajectory,)."""
        return _trajectory_unit_factor_of_kind(_kind_of_field(name), self.size_ratios)

    def build_problem_lasting(self, duration: FloatArray) -> Problem:
        """The trajectories, each lasting `duration` in the actuator's unit of time."""
        ens = self.ensemble_in_own_units
        if not isinstance(ens.drive, PiecewiseDrive):
            return initial_value_problem(ens, duration * self.time_factor_to_trajectory_unit)
        plain = initial_value_problem(ens, duration)
        line = plain.timeline
        scaled = {
            name: rows * self.load_factor_to_trajectory_unit
            for name, rows in line.piece_parameters.items()
        }
        timeline = Timeline(
            line.piece_lengths * self.time_factor_to_trajectory_unit,
            line.periodic,
            scaled,
            line.waveforms_at_phase,
        )
        return replace(
            plain, timeline=timeline, duration=plain.duration * self.time_factor_to_trajectory_unit
        )


def lay_out_physical_scales(
    system: System,
    drive: Drive,
    over: OverArgument | None = None,
    initial: ArrayLike | None = None,
    *,
    reserved: frozenset[str] = frozenset({"time", "cycle", "step"}),
    tells: bool = True,
) -> PhysicalScales:
    """Lay out trajectories over numeric fields and over :data:`PHYSICAL_SIZES` sizes.

    Flux densities, times, dead loads and viscosities keep their values in SI, so the
    dimensionless numbers change: m ~ B_r/mu, S ~ 1/mu, omega ~ sqrt(rho/mu) ...
    """
    ens = lay_out_ensemble(
        system,
        drive,
        over,
        initial,
        reserved=reserved,
        extra=dict.fromkeys(PHYSICAL_SIZES, 1.0),
        tells=tells,
    )
    sizes = np.stack([ens.parameter_values[name] for name in PHYSICAL_SIZES])
    broken = ~np.all([PHYSICAL_SIZE_RULE.is_satisfied_by(row) for row in sizes], axis=0)
    if not ens.dimension_sizes and broken.any():
        raise InputError(
            "over",
            must=PHYSICAL_SIZE_RULE.must,
            got=sizes[:, 0],
            why=PHYSICAL_SIZE_RULE.why,
            fix=PHYSICAL_SIZE_RULE.fix,
        )
    sizes = np.where(broken, 1.0, sizes)
    values = {
        name: value * _trajectory_unit_factor_of_kind(_kind_of_field(name), sizes)
        for name, value in ens.parameter_values.items()
        if name not in PHYSICAL_SIZES
    }
    start = ens.initial_states.copy()
    for k, name in enumerate(ens.vector_field.state_names):
        start[:, k] *= _trajectory_unit_factor_of_kind(_kind_of_field(name), sizes)
    in_own_units = replace(
        ens, parameter_values=values, initial_states=start, is_invalid=ens.is_invalid | broken
    )
    return PhysicalScales(in_own_units, sizes)


def _trajectory_unit_factor_of_kind(kind: QuantityKind, sizes: FloatArray) -> FloatArray:
    exponents = _SIZE_EXPONENTS_OF_KIND.get(kind, (0.0, 0.0, 0.0))
    return np.asarray(np.prod(sizes ** np.array(exponents)[:, None], axis=0))


def _kind_of_field(name: str) -> QuantityKind:
    """How a field scales; what the table does not name is a plain number."""
    base = "mean" if name.startswith("loads.") else name
    try:
        return describe(base).kind
    except InputError:
        return QuantityKind.NONE
