"""Where an actuator is after a sequence of constant loads, with all derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._field import Field
from remanent._typing import ArrayLike, FloatArray
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.variations import tangent
from remanent.models.actuator import Actuator
from remanent.models.drives.waves import Constant
from remanent.studies.ensemble.physical_scales import PHYSICAL, PhysicalScales, lay_out_physical
from remanent.studies.statics._static_state import Body

#: Half the relative change of a size over which insensitivity is asked.
HALF_WIDTH = 1e-3


@dataclass(frozen=True)
class Arrival:
    """Conditions that the state after some steps is one of rest, for analysis to solve.

    Attributes
    ----------
    actuator
        What moves.
    final
        The body at rest at the target, under the last load.
    initial
        The state at tau = 0.
    sizes
        Names of fields and physical sizes; the derivative by each of the distance from rest
        shall vanish too.
    tolerance
        Of the states.
    """

    actuator: Actuator
    final: Body
    initial: ArrayLike | None
    sizes: Sequence[str]
    tolerance: float

    def __call__(
        self, loads: FloatArray, durations: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See :data:`remanent.analysis.control.shaping.Arrive`."""
        state, by_load, by_time = self._carried(loads, durations)
        rows = self.final.moving
        distance = (state - self._rest)[:, rows]
        return (
            self._conditions(distance),
            self._conditions(by_load[:, rows]),
            self._conditions(by_time[:, rows]),
        )

    def _conditions(self, values: FloatArray) -> FloatArray:
        """Values of the nominal actuator, and central differences by each size."""
        pairs = values[1:].reshape(-1, 2, *values.shape[1:])
        rows = [values[:1], (pairs[:, 1] - pairs[:, 0]) / (2.0 * HALF_WIDTH)]
        joined = np.concatenate(rows)
        return joined.reshape(joined.shape[0] * joined.shape[1], *joined.shape[2:])

    @cached_property
    def variants(self) -> PhysicalScales:
        """The actuator itself, then with each size a little less and a little more."""
        own = {**self.actuator.parameters(), **dict.fromkeys(PHYSICAL, 1.0)}
        count = 1 + 2 * len(self.sizes)
        over = {}
        for k, name in enumerate(self.sizes):
            values = np.full(count, own[name])
            values[1 + 2 * k : 3 + 2 * k] += np.array([-1.0, 1.0]) * HALF_WIDTH * (own[name] or 1.0)
            over[name] = xr.DataArray(values, dims="variant")
        return lay_out_physical(self.actuator, Constant(self.final.load), over, self.initial)

    @cached_property
    def _rest(self) -> FloatArray:
        """States of rest of all variants under the last load, array (variant, state)."""
        ens = self.variants.ensemble
        columns = np.column_stack([ens.values[name] for name in ens.field.parameters])
        found = [replace(self.final, parameters=row).at_rest() for row in columns]
        if any(body is None for body in found):
            raise InputError(
                "robust",
                must="name fields whose small changes leave a state of rest",
                got=self.sizes,
                why="The target is at the edge of where rest is possible.",
                fix="Leave it out.",
            )
        return np.array([body.state for body in found if body is not None])

    @cached_property
    def _field(self) -> Field:
        field = self.variants.ensemble.field
        return tangent(field, directions=len(field.state), parameters=("m",))

    def _carried(
        self, loads: FloatArray, durations: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        ens, d = self.variants.ensemble, len(self.final.state)
        m = ens.field.parameters.index("m")
        state = ens.initial
        by_load = np.zeros((ens.count, d, loads.size))
        by_time = np.zeros_like(by_load)
        for k, (load, duration) in enumerate(zip(loads, durations, strict=True)):
            plain = self.variants.problem(np.full(ens.count, duration))
            plain.parameters[:, m] = load * self.variants.load
            start = np.hstack([state, np.tile(np.eye(d).ravel(), (ens.count, 1)),
                               np.zeros((ens.count, d))])  # fmt: skip
            outcome = integrate(
                replace(plain, field=self._field, initial=start),
                Request(times=plain.duration[:, None]),
                tolerance=self.tolerance,
            )
            assert outcome.states is not None
            ends = outcome.states[:, 0]
            state, carried = ends[:, :d], ends[:, d:].reshape(ens.count, d + 1, d)
            turned = np.moveaxis(carried[:, :d], 1, 2)
            by_load, by_time = turned @ by_load, turned @ by_time
            by_load[:, :, k] = carried[:, d] * self.variants.load[:, None]
            rates = ens.field.rates([0.0, *state.T, *plain.parameters.T], functions=np)
            by_time[:, :, k] = np.column_stack(rates) * self.variants.time[:, None]
        return state, by_load, by_time
