"""From which load on an actuator snaps: slowly, and at a step from rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import finite_rule, require_real
from remanent._errors import InputError
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.statics.equilibria import balancing_parameter, find_force_zeros, force_slope
from remanent.models.actuator import Actuator
from remanent.models.system import System
from remanent.studies.ensemble.checks import (
    require_parameter,
    require_parameter_range,
    require_system,
)
from remanent.studies.ensemble.constant_drive import ConstantLoadArgument, constant_drive
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.statics._folds import fold_points, stretch_grid_of_cases
from remanent.studies.statics._static_box import require_no_box
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_errors import (
    balancing_parameter_error,
    largest,
    least,
    thickness_error,
)
from remanent.studies.statics._written_snap_through import written_thresholds

#: Points between start and saddle at which the energy is compared.
_ENERGY_SAMPLE_COUNT_TO_SADDLE = 256
#: How much higher than at the start the energy on the way may seem, by rounding.
_ENERGY_ROUNDING = 1e-9
#: A saddle nearer to the start than this is the start itself.
_SAME_STRETCH_DISTANCE = 1e-6
#: A small change of the parameter, relative to its range.
_RELATIVE_PARAMETER_STEP = 1e-6
_COORDINATE_RULE = finite_rule("It is a value of the coordinate.", "Leave it out for rest.")
_STRETCH_RULE = finite_rule(
    "It is a stretch, a ratio of lengths.", "Pass 1 for the undeformed block."
)


def snap_through(
    actuator: System,
    parameter: str,
    parameter_range: tuple[float, float],
    *,
    m: ConstantLoadArgument = 0.0,
    initial: float | None = None,
    state_box: Mapping[str, Any] | None = None,
    over: OverArgument | None = None,
) -> xr.Dataset:
    """Find the static and the dynamic threshold of a snap from one equilibrium to another.

    Parameters
    ----------
    actuator : System
        An actuator of one coordinate without dissipation and heat balance, or any system of
        one's own.
    parameter : str
        The numeric field that is raised or stepped: ``m``, ``prestress``, ``temperature`` ...;
        of a load by its name ``pressure.m``.
    parameter_range : (float, float)
        Its least and largest value.
    m : float, or mapping of str to float
        Magnetic load, where it is not the parameter; of a system of one's own its load, or its
        loads by their names, 0 where they are left out.
    initial : float, optional
        In-plane stretch, or value of the one coordinate, from which the motion starts, at zero
        rate, when the parameter is switched on: rest by default.
    state_box : mapping of str to (float, float), optional
        Of a system of one's own: where its coordinates and internal variables may be.
    over : mapping of str to array_like or DataArray, optional
        Values of other numeric fields; they become dimensions.

    Returns
    -------
    xarray.Dataset
        Along ``fold``: ``fold_<parameter>``, ``fold_stretch``, ``fold_thickness_stretch``, where
        a stable and an unstable equilibrium meet (slow loading snaps there).  Along ``snap``:
        ``snap_<parameter>``, the value at which the motion from `initial` just reaches an
        unstable equilibrium (which may be the start itself), ``snap_stretch`` and
        ``snap_thickness_stretch`` there, and ``snap_direction``: 1 if beyond it a larger value
        takes the motion to larger in-plane stretches, -1 if to smaller.  Each number has its
        error, ``snap_stretch_error`` for example: a bound of what rounding does to it.
        Of a system of one's own: all folds in the box, ``fold_`` with the names of the parameter,
        of coordinates and internal variables and ``observable``, and ``fold_stability``, which is
        ``stable`` where a stable equilibrium is lost; along ``branch_point`` the same where
        branches of equilibria cross, as in the buckling of a symmetric structure; along ``snap``
        the thresholds of a system with one coordinate that loses no energy, of others nothing.
        ``status`` is ``incomplete``, with the ``reason``, where some may be missing.

    Raises
    ------
    InputError
        A bad argument, or an actuator that dissipates or has two coordinates; a start where no
        thresholds of a motion are found.

    See Also
    --------
    equilibria : The equilibria themselves, and folds along a parameter.

    Notes
    -----
    With f the force and V the potential: folds are f = 0, df/dlambda = 0; thresholds are
    f(lambda) = 0, V(lambda) = V(start), df/dlambda > 0, with V below V(start) on the way.  At the
    threshold itself the motion takes for ever.  Dissipation moves the threshold towards
    the fold.  One value of the parameter is found for
    each stretch, which is all there is for m, prestress and temperature.  Of a system of one's own
    folds are zeros of the balance of forces (or of the rates) together with the determinant of its
    derivatives, and thresholds zeros of the force and of the mean force on the way, all those in
    the box and the range, by cells; where branches cross, the extended system for that (Griewank
    and Reddien, 1984) is solved.  No fold is told apart from a crossing that is nearer than 1.6 %
    of the box.

    Examples
    --------
    >>> import remanent as rm
    >>> pulled = rm.Actuator(prestress=2.2)
    >>> thin = float(rm.equilibria(pulled, 0.0).stretch[0])
    >>> ds = rm.snap_through(pulled, "m", (1.0, 4.0), initial=thin)
    >>> ds.fold_m.values.round(4).tolist(), ds.snap_m.values.round(4).tolist()
    ([2.1777, 2.8483], [2.4868])
    """
    actuator = require_system("actuator", actuator)
    if not isinstance(actuator, Actuator):
        return _thresholds_of_own_system(
            actuator, parameter, parameter_range, m, initial, state_box, over
        )
    _require_conservative(actuator)
    require_no_box(state_box)
    initial = require_real("initial", 1.0 if initial is None else initial, _STRETCH_RULE)
    drive = constant_drive(actuator, m)
    ens = lay_out_ensemble(actuator, drive, over, (initial, 0.0), system_argument="actuator")
    low, high = _require_parameter_and_range(parameter, parameter_range, ens)
    static, cases = StaticEnsemble(ens), np.flatnonzero(~ens.is_invalid)
    ends = np.full(cases.size, low), np.full(cases.size, high)
    folds = fold_points(static, parameter, cases, ends)
    snaps = _SnapSearch(static, parameter, cases, ends).thresholds()
    variables: dict[str, PerTrajectoryArray] = {
        f"{dim}_{name}": ((dim,), _rows_for_all_cases(values, cases, ens.trajectory_count))
        for dim, columns in (("fold", folds), ("snap", snaps))
        for name, values in columns.items()
    }
    return to_dataset(
        ens,
        variables,
        coords={
            "fold": (("fold",), np.arange(folds["stretch"].shape[1])),
            "snap": (("snap",), np.arange(snaps["stretch"].shape[1])),
        },
        tolerance=None,
        driven=parameter != "m",
        parameter=parameter,
        parameter_range=[low, high],
        initial=initial,
    )


def _thresholds_of_own_system(
    system: System,
    parameter: str,
    parameter_range: tuple[float, float],
    m: ConstantLoadArgument,
    initial: float | None,
    state_box: Mapping[str, Any] | None,
    over: OverArgument | None,
) -> xr.Dataset:
    """Folds, branch points and dynamic thresholds of a system of one's own."""
    start = None
    if initial is not None:
        start = (require_real("initial", initial, _COORDINATE_RULE), 0.0)
    drive = constant_drive(system, m)
    ens = lay_out_ensemble(system, drive, over, system_argument="actuator")
    has_one_coordinate = len(ens.vector_field.state_names) == 2
    if start is not None and has_one_coordinate:
        ens = lay_out_ensemble(system, drive, over, start, system_argument="actuator")
    limits = _require_parameter_and_range(parameter, parameter_range, ens)
    variables, coords, status, box = written_thresholds(
        ens, parameter, limits, state_box, has_start=start is not None
    )
    return to_dataset(
        ens,
        variables,
        coords=coords,
        status=status,
        tolerance=None,
        driven=set(drive.parameter_values()) != {parameter},
        parameter=parameter,
        parameter_range=list(limits),
        initial=None if start is None else start[0],
        state_box=box.ravel(),
    )


def _require_parameter_and_range(
    parameter: str, parameter_range: object, ens: Ensemble
) -> tuple[float, float]:
    """The range of a parameter that `over` does not vary."""
    require_parameter("parameter", parameter, ens)
    limits = require_parameter_range(
        "parameter_range", parameter_range, parameter, ens, "Thresholds are sought between them."
    )
    _require_not_varied(parameter, ens)
    return limits


def _require_conservative(actuator: Actuator) -> None:
    if not actuator.conservative or actuator.coordinate_count > 1:
        raise InputError(
            "actuator",
            must="have one coordinate, no dissipation and no heat balance",
            got=actuator,
            why="The threshold follows from conservation of energy at a held temperature.",
            fix="Pass one number as prestress, no edges, dissipation=() and heat=None; it snaps "
            "before any that dissipates.",
        )


def _require_not_varied(parameter: str, ens: Ensemble) -> None:
    if parameter in ens.coords:
        raise InputError(
            "over",
            must=f"not hold {parameter}",
            got=repr(list(ens.coords)),
            why="It is the field that the thresholds are values of.",
            fix="Leave it out of `over`.",
        )


def _rows_for_all_cases(values: FloatArray, cases: IntArray, count: int) -> FloatArray:
    """Values of some cases (case, point) with a row of NaN for each of the others."""
    rows = np.full((count, values.shape[1]), np.nan)
    rows[cases] = values
    return rows


@dataclass(frozen=True)
class _SnapSearch:
    """The curve of equilibria, as the parameter that balances the force at each stretch.

    Attributes
    ----------
    static : StaticEnsemble
    parameter_name : str
        The parameter.
    valid_cases : array (case,)
        Trajectories of the ensemble that are valid.
    parameter_ends : two arrays (case,)
        Least and largest value of the parameter.
    """

    static: StaticEnsemble
    parameter_name: str
    valid_cases: IntArray
    parameter_ends: tuple[FloatArray, FloatArray]

    @cached_property
    def start_stretch(self) -> FloatArray:
        """Stretch from which the motion starts, array (case,)."""
        return np.asarray(self.static.ensemble.initial_states[self.valid_cases, 0])

    def balancing_parameter(self, row: IntArray, x: FloatArray) -> FloatArray:
        """The parameter for which `x` is an equilibrium."""
        force = self.static.first_acceleration_function(self.parameter_name)
        return balancing_parameter(
            lambda i, y, p: force(self.valid_cases[i], y, p), self.parameter_ends, row, x
        )

    def potential_rise(self, row: IntArray, x: FloatArray, value: FloatArray) -> FloatArray:
        """V(x) - V(start)."""
        changed, case = {self.parameter_name: value}, self.valid_cases[row]
        potential = self.static.potential
        return potential(case, x, changed=changed) - potential(
            case, self.start_stretch[row] + 0.0 * x, changed=changed
        )

    def thresholds(self) -> dict[str, FloatArray]:
        """Parameter, stretch and direction of every threshold, and errors, (case, threshold)."""
        grid, count = stretch_grid_of_cases(self.static, self.valid_cases), self.valid_cases.size
        # Equilibria whose energy is that of the start, and the start, which has it anyway.
        level = find_force_zeros(
            lambda i, x: self.potential_rise(i, x, self.balancing_parameter(i, x)), count, grid
        )
        level = np.where(
            np.abs(level - self.start_stretch[:, None]) > _SAME_STRETCH_DISTANCE, level, np.nan
        )
        level = np.concatenate([level, self.start_stretch[:, None]], axis=1)
        row, x = np.repeat(np.arange(count), level.shape[1]), level.ravel()
        value = self.balancing_parameter(row, x)
        x = np.where(self._is_reached_saddle(row, x, value), x, np.nan)
        value = np.where(np.isnan(x), np.nan, value)
        error, value_error = self._threshold_errors(row, x, value)
        case = self.valid_cases[row]
        columns = {
            self.parameter_name: value,
            f"{self.parameter_name}_error": value_error,
            "stretch": x,
            "stretch_error": error,
            "thickness_stretch": self.static.thickness(case, x),
            "thickness_stretch_error": thickness_error(self.static, case, x, error),
            "direction": self._stretch_direction_beyond_threshold(row, x, value),
        }
        order = np.argsort(value.reshape(level.shape), axis=1)  # NaN last
        width = int(np.isfinite(value).reshape(level.shape).sum(axis=1).max(initial=0))
        return {
            name: np.take_along_axis(column.reshape(level.shape), order, axis=1)[:, :width]
            for name, column in columns.items()
        }

    def _threshold_errors(
        self, row: IntArray, x: FloatArray, value: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Errors of stretch and parameter of thresholds.

        Along the curve of equilibria the level V(x) - V(start) changes by the parameter alone,
        as the force vanishes, and the parameter by -(df/dx)/(df/dp).
        """
        name, case, start = self.parameter_name, self.valid_cases[row], self.start_stretch[row]
        changed = {name: value}
        of_force = [
            self.static.first_acceleration_with_rounding(case, x, along=along, changed=changed)
            for along in ("", name)
        ]
        of_level = [
            self.static.potential_with_rounding(case, place + 0.0 * x, along=name, changed=changed)
            for place in (x, start)
        ]
        rise = of_level[0] - of_level[1]
        with np.errstate(all="ignore"):
            own = balancing_parameter_error(self.static, name, case, x, value)
            slope = largest(of_force[0].slope) / least(of_force[1].slope)
            steepness = least(rise.slope) * least(of_force[0].slope) / largest(of_force[1].slope)
            left = largest(rise.value) + largest(rise.slope) * own
            error = np.where(x == start, 0.0, left / steepness)
            return error, own + slope * error

    def _stretch_direction_beyond_threshold(
        self, row: IntArray, x: FloatArray, value: FloatArray
    ) -> FloatArray:
        """1 where a larger parameter takes the motion to larger stretches, -1 to smaller."""
        small = _RELATIVE_PARAMETER_STEP * (self.parameter_ends[1] - self.parameter_ends[0])[row]
        barrier = self.potential_rise(row, x, value + small) - self.potential_rise(
            row, x, value - small
        )
        forces = [
            self.static.first_acceleration(
                self.valid_cases[row], x, {self.parameter_name: value + side * small}
            )
            for side in (1.0, -1.0)
        ]
        beyond = x - self.start_stretch[row]
        return np.sign(np.where(beyond == 0.0, forces[0] - forces[1], -barrier * beyond))

    def _is_reached_saddle(self, row: IntArray, x: FloatArray, value: FloatArray) -> BoolArray:
        """Whether `x` is a saddle with nothing higher on the way from the start."""
        force = self.static.first_acceleration_function(self.parameter_name)
        steepness = force_slope(lambda i, y: force(self.valid_cases[i], y, value), row, x)
        share = np.linspace(0.0, 1.0, _ENERGY_SAMPLE_COUNT_TO_SADDLE)[1:-1]
        begin = self.start_stretch[row]
        way = begin[:, None] + (x - begin)[:, None] * share
        many = np.repeat(row, share.size)
        rise = self.potential_rise(many, way.ravel(), np.repeat(value, share.size)).reshape(
            way.shape
        )
        below = (rise <= _ENERGY_ROUNDING * (1.0 + np.abs(value))[:, None]).all(axis=1)
        return np.asarray((steepness > 0.0) & below)
