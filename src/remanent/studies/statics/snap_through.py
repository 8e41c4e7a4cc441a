"""From which load on an actuator snaps: slowly, and at a step from rest."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.equilibria import balancing, slope, zeros
from remanent.models.actuator import Actuator
from remanent.models.drives.waves import Constant
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.ensemble import Over, ensemble
from remanent.studies.orbits.continue_orbit import parameter_bounds
from remanent.studies.statics._folds import fold_points, grid_of
from remanent.studies.statics._static_ensemble import AtRest

#: Points between start and saddle at which the energy is compared, and how nearly equal
#: energies may be.
_SAMPLES, _EQUAL = 256, 1e-9
#: A saddle nearer to the start than this is the start itself.
_NEAR = 1e-6
#: A small change of the parameter, relative to its bounds.
_STEP = 1e-6


def snap_through(
    actuator: Actuator,
    parameter: str,
    parameter_range: tuple[float, float],
    *,
    m: float = 0.0,
    initial: float = 1.0,
    over: Over | None = None,
) -> xr.Dataset:
    """Find the static and the dynamic threshold of a snap from one equilibrium to another.

    Parameters
    ----------
    actuator
        An actuator of one coordinate without dissipation and heat balance.
    parameter
        The numeric field that is raised or stepped: ``m``, ``prestress``, ``temperature`` ...
    parameter_range
        Its least and largest value.
    m
        Magnetic load, where it is not the parameter.
    initial
        In-plane stretch from which the motion starts, at zero rate, when the parameter is
        switched on.
    over
        Values of other numeric fields; they become dimensions.

    Returns
    -------
    xarray.Dataset
        Along ``fold``: ``fold_<parameter>``, ``fold_stretch``, ``fold_thickness_stretch``, where
        a stable and an unstable equilibrium meet (slow loading snaps there).  Along ``snap``:
        ``snap_<parameter>``, the value at which the motion from `initial` just reaches an
        unstable equilibrium (which may be the start itself), ``snap_stretch`` and
        ``snap_thickness_stretch`` there, and ``snap_direction``: 1 if beyond it a larger value
        takes the motion to larger in-plane stretches, -1 if to smaller.

    Raises
    ------
    InputError
        A bad argument, or an actuator that dissipates or has two coordinates.

    Notes
    -----
    With f the force and V the potential: folds are f = 0, df/dlambda = 0; thresholds are
    f(lambda) = 0, V(lambda) = V(start), df/dlambda > 0, with V below V(start) on the way.  At the
    threshold itself the motion takes for ever.  Dissipation moves the threshold towards
    the fold.  One value of the parameter is found for
    each stretch, which is all there is for m, prestress and temperature.

    Examples
    --------
    >>> import remanent as rm
    >>> pulled = rm.Actuator(prestress=2.2)
    >>> thin = float(rm.equilibria(pulled, 0.0).stretch[0])
    >>> ds = rm.snap_through(pulled, "m", (1.0, 4.0), initial=thin)
    >>> ds.fold_m.values.round(4).tolist(), ds.snap_m.values.round(4).tolist()
    ([2.1777, 2.8483], [2.4868])
    """
    if not actuator.conservative or actuator.coordinates > 1:
        raise InputError(
            "actuator", "have one coordinate, no dissipation and no heat balance", actuator,
            "The threshold follows from conservation of energy at a held temperature.",
            "Pass one number as prestress, no edges, dissipation=() and heat=None; it snaps "
            "before any that dissipates.",
        )  # fmt: skip
    ens = ensemble(actuator, Constant(m), over, (initial, 0.0))
    low, high = parameter_bounds(parameter, np.asarray(parameter_range), ens)
    if parameter in ens.coords:
        raise InputError(
            "over", f"not hold {parameter}", repr(list(ens.coords)),
            "It is the field that the thresholds are values of.", "Leave it out of `over`.",
        )  # fmt: skip
    at_rest, cases = AtRest(ens), np.flatnonzero(~ens.invalid)
    ends = np.full(cases.size, low), np.full(cases.size, high)
    search = _Search(at_rest, parameter, cases, ends)
    fold_stretch, fold_value = fold_points(at_rest, parameter, cases, ends)
    snap_stretch, snap_value, direction = search.thresholds()
    columns = {
        "fold": {parameter: fold_value, "stretch": fold_stretch,
                 "thickness_stretch": at_rest.thickness(cases[:1], fold_stretch)},
        "snap": {parameter: snap_value, "stretch": snap_stretch,
                 "thickness_stretch": at_rest.thickness(cases[:1], snap_stretch),
                 "direction": direction},
    }  # fmt: skip
    variables: dict[str, Labelled] = {}
    coords = dict(ens.coords)
    for dim, found in columns.items():
        for name, values in found.items():
            rows = np.full((ens.count, values.shape[1]), np.nan)
            rows[cases] = values
            variables[f"{dim}_{name}"] = ((*ens.dims, dim), ens.shaped(rows))
        coords[dim] = ((dim,), np.arange(found["stretch"].shape[1]))
    status = np.where(ens.invalid, Status.INVALID, Status.OK).astype(np.int8)
    variables["status"] = (ens.dims, ens.shaped(status))
    drive = None if parameter == "m" else Constant(m)
    attributes = provenance.attributes(
        actuator,
        drive,
        None,
        over=ens.coords,
        parameter=parameter,
        parameter_range=[low, high],
        initial=initial,
    )
    return build.dataset(variables, coords, attributes)


class _Search:
    """The curve of equilibria, as the parameter that balances the force at each stretch."""

    def __init__(
        self, at_rest: AtRest, name: str, cases: IntArray, ends: tuple[FloatArray, FloatArray]
    ) -> None:
        self.at_rest, self.name, self.cases, self.ends = at_rest, name, cases, ends
        self.start = at_rest.ens.initial[cases, 0]

    def value(self, row: IntArray, x: FloatArray) -> FloatArray:
        """The parameter for which `x` is an equilibrium."""
        force = self.at_rest.force_at(self.name)
        return balancing(lambda i, y, p: force(self.cases[i], y, p), self.ends, row, x)

    def rise(self, row: IntArray, x: FloatArray, value: FloatArray) -> FloatArray:
        """V(x) - V(start)."""
        changed, case = {self.name: value}, self.cases[row]
        potential = self.at_rest.potential
        return potential(case, x, changed=changed) - potential(
            case, self.start[row] + 0.0 * x, changed=changed
        )

    def thresholds(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Stretch, parameter and direction of every threshold, arrays (case, threshold)."""
        grid, count = grid_of(self.at_rest, self.cases), self.cases.size
        found = zeros(lambda i, x: self.rise(i, x, self.value(i, x)), count, grid)
        found = np.where(np.abs(found - self.start[:, None]) > _NEAR, found, np.nan)
        found = np.concatenate([found, self.start[:, None]], axis=1)
        row, x = np.repeat(np.arange(count), found.shape[1]), found.ravel()
        value = self.value(row, x)
        x = np.where(self._reached(row, x, value), x, np.nan)
        value = np.where(np.isnan(x), np.nan, value)
        columns = [a.reshape(found.shape) for a in (x, value, self._direction(row, x, value))]
        order = np.argsort(columns[1], axis=1)  # NaN last
        most = int(np.isfinite(value).reshape(found.shape).sum(axis=1).max(initial=0))
        first, second, third = (np.take_along_axis(a, order, axis=1)[:, :most] for a in columns)
        return first, second, third

    def _direction(self, row: IntArray, x: FloatArray, value: FloatArray) -> FloatArray:
        """1 where a larger parameter takes the motion to larger stretches, -1 to smaller."""
        small = _STEP * (self.ends[1] - self.ends[0])[row]
        barrier = self.rise(row, x, value + small) - self.rise(row, x, value - small)
        push = [
            self.at_rest.force(self.cases[row], x, {self.name: value + side * small})
            for side in (1.0, -1.0)
        ]
        beyond = x - self.start[row]
        return np.sign(np.where(beyond == 0.0, push[0] - push[1], -barrier * beyond))

    def _reached(self, row: IntArray, x: FloatArray, value: FloatArray) -> BoolArray:
        """Whether `x` is a saddle with nothing higher on the way from the start."""
        force = self.at_rest.force_at(self.name)
        steepness = slope(lambda i, y: force(self.cases[i], y, value), row, x)
        share = np.linspace(0.0, 1.0, _SAMPLES)[1:-1]
        begin = self.start[row]
        way = begin[:, None] + (x - begin)[:, None] * share
        many = np.repeat(row, share.size)
        rise = self.rise(many, way.ravel(), np.repeat(value, share.size)).reshape(way.shape)
        below = (rise <= _EQUAL * (1.0 + np.abs(value))[:, None]).all(axis=1)
        return np.asarray((steepness > 0.0) & below)
