"""The resonances of forced response, named by their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent._field import Role
from remanent._status import Status
from remanent._typing import ArrayLike
from remanent.analysis.orbits.curves import Curve
from remanent.models.actuator import Actuator
from remanent.models.pairs import is_several_numbers
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import DriveArgument
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.orbits._branch_ends import CurveEnds, ends_of_curves, member_status
from remanent.studies.orbits._branch_tables import ColumnTable
from remanent.studies.orbits._checks import (
    require_orbit_period,
    require_slices,
    require_state_box,
)
from remanent.studies.orbits._forced_response import require_frequency_range
from remanent.studies.orbits._members import map_members_in_threads, stack_tables
from remanent.studies.orbits._orbit_tables import ORBIT_DIMENSIONS
from remanent.studies.orbits._tracing import TracingOptions, trace_all_branches
from remanent.studies.response._mean_rest import rest_under_mean_load
from remanent.studies.response._peak_search import Peak, PeakSearch
from remanent.studies.response._peaks import (
    HARMONIC_COUNT,
    describe_peaks,
    empty_peak_table,
    load_harmonics,
    system_and_drive_of_member,
)

#: Points of a branch, in each direction from where it was found.
_MAX_BRANCH_POINTS = 2000


def resonances(
    system: System,
    drive: DriveArgument,
    omega_range: ArrayLike,
    *,
    orbit_periods: Sequence[int] = (1,),
    state_box: Mapping[str, Any] | None = None,
    over: OverArgument | None = None,
    slices: int = 9,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Find the peaks of forced response and say which resonance each of them is.

    Parameters
    ----------
    system : System
        What moves, with one coordinate: an actuator, or a system of one's own by its energies.
    drive : Drive, or mapping of str to Drive
        A load with a field ``omega``, whose value is not used.
    omega_range : (lowest, highest)
        Frequencies, radians per unit of tau, or with a unit, ``("820 Hz", "920 Hz")``, where
        the actuator has SI sizes.
    orbit_periods : sequence of int
        Of the orbits, in drive periods: 1 for primary and superharmonic resonances, 2, 3 ...
        for subharmonic and parametric ones.
    state_box : mapping of name to (lower, upper), optional
        Range of each state variable at phase 0, such as ``{"stretch": (0.3, 4.0)}``, where
        branches end; required of a system of one's own, which is at rest in it.
    over : mapping of name to values, optional
        Values of other numeric fields; they become dimensions of the result.
    slices : int
        At how many frequencies orbits are looked for, at most 10 000.  A branch (an isola) that
        passes none of them is missed.
    tolerance : float
        Of the residual: the distance of an orbit's point from its image.
    progress : bool or callable, optional
        True draws a bar; a callable is called with the share of the combinations in `over`
        that are finished.

    Returns
    -------
    xarray.Dataset
        Along ``peak``, by frequency: ``omega`` with ``omega_error``, how far the peak
        may be from there; ``amplitude`` with its error; ``unbounded``, whether the
        branch rises to the end of `state_box` instead of turning back; ``resonance_kind``
        (``primary``, ``superharmonic``, ``subharmonic``, ``parametric``,
        ``ultrasubharmonic``, ``undecided``), with ``order_p``:``order_q``, oscillations in
        drive periods, 0:0 where undecided; ``orbit_period``; ``stability``; the ``phase_lag``
        behind the load of the harmonic that resonates, in [0, 2π).  Evidence:
        ``harmonics`` (peak, harmonic), complex; ``share``, of that harmonic in the mean
        square; ``free_frequency`` of the free oscillation as large as the orbit, under the
        mean load, without dissipation and at the surroundings' temperature; ``detuning`` of
        the harmonic from it.  Padded where other combinations of `over` have more peaks;
        ``status`` is ``incomplete`` where a branch was not followed to its end or some may be
        missing, for the ``reason`` that is given.

    Raises
    ------
    InputError
        A bad argument; two coordinates, or a system of one's own with internal variables or
        without an energy; no stable equilibrium under the mean load.

    See Also
    --------
    response_diagram : The branches whose peaks these are.
    backbone : The free oscillations that name them.

    Notes
    -----
    A peak is a local maximum of the amplitude along a branch of
    :func:`remanent.response_diagram`.  Undamped branches have none; where they rise to the
    end of the bounds that end stands for it.  The harmonic whose frequency is nearest to the
    free oscillation names the resonance if it is within 10 % of it and holds 5 % of the
    mean square; else the peak is ``undecided``.  Branches that relax make free oscillations
    faster: in the ratio of the modulus of the eigenvalue of small oscillations to the natural
    frequency, at every amplitude; dashpots leave that modulus as it is.  A 1:2 response is
    ``parametric`` where its branch springs from one of period 1, which loses stability there
    (A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations (Wiley, 1979), chapters 4 and 5).

    Examples
    --------
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.05))
    >>> ds = rm.resonances(damped, rm.SineSquared(0.3, 1.0), (0.55, 1.5))
    >>> ds.resonance_kind.values.tolist()
    ['superharmonic', 'primary']
    """
    _require_orbit_periods(orbit_periods)
    ens = lay_out_ensemble(system, drive, over, reserved=ORBIT_DIMENSIONS)
    _require_one_coordinate(ens)
    limits = require_frequency_range(omega_range, ens)
    slices = require_slices(slices)
    plans = [
        TracingOptions(
            "omega", limits, state_box, period, _MAX_BRANCH_POINTS, tolerance
        ).require_valid(ens)
        for period in orbit_periods
    ]
    box = require_state_box("state_box", state_box, ens)

    def find(member: Ensemble) -> tuple[ColumnTable, CurveEnds, str]:
        middle = np.array([0.5 * sum(limits)])
        centred = replace(member, parameter_values={**member.parameter_values, "omega": middle})
        system, drive = system_and_drive_of_member(centred, ens.coords)
        rest = rest_under_mean_load(system, load_harmonics(drive)[0], box)
        peaks: list[Peak] = []
        curves: list[Curve] = []
        missing: list[str] = []
        for options in plans:
            tracing = options.tracing_of_member(centred)
            search = PeakSearch(centred, tracing, rest.natural_frequency)
            branches, reason = trace_all_branches(tracing, slices)
            missing += [reason] if reason else []
            for branch in branches:
                peaks += search.peaks_of(branch)
                curves.append(branch.curve)
        peaks.sort(key=lambda peak: peak.omega)
        unknowns = [*member.vector_field.state_names, "omega"]
        columns = describe_peaks(centred, drive, rest, peaks)
        return columns, ends_of_curves(curves, unknowns), "; ".join(missing)

    outcomes = map_members_in_threads(ens, find, as_progress(progress))
    columns = stack_tables([None if o is None else o[0] for o in outcomes], empty_peak_table())
    ends = [None if outcome is None else outcome[1] for outcome in outcomes]
    variables: dict[str, PerTrajectoryArray] = {
        name: (("peak", "harmonic") if name == "harmonics" else ("peak",), column)
        for name, column in columns.items()
    }
    coords: dict[str, Labelled] = {
        "peak": (("peak",), np.arange(columns["omega"].shape[1])),
        "harmonic": (("harmonic",), np.arange(HARMONIC_COUNT + 1)),
    }
    # Peaks say themselves where a branch runs off to the bounds of the state.
    missing = ["" if outcome is None else outcome[2] for outcome in outcomes]
    status, variables["reason"] = member_status(ens, ends, Status.DIVERGED, (), missing)
    dataset = to_dataset(
        ens, variables, coords=coords, status=status,
        tolerance=tolerance, parameter_range=limits, slices=slices,
    )  # fmt: skip
    # The drive's own frequency has no part in the result.
    return dataset.assign_attrs(over=" ".join([*ens.coords, "omega"]))


def _require_orbit_periods(orbit_periods: Sequence[int]) -> None:
    if not is_several_numbers(orbit_periods) or not len(orbit_periods):
        raise InputError(
            "orbit_periods",
            must="be a sequence of positive integers, at least one",
            got=shortened_repr(orbit_periods),
            why="Peaks of the orbits of each period are found.",
            fix="Pass for example (1, 2).",
        )
    for period in orbit_periods:
        require_orbit_period(period, "orbit_periods")


def _require_one_coordinate(ens: Ensemble) -> None:
    """Refuse what has no backbone."""
    field = ens.vector_field
    is_own = not isinstance(ens.system, Actuator)
    if is_own and not field.energy_names:
        raise InputError(
            "system",
            must="have an energy",
            got=ens.system,
            why="Resonances are named by free oscillations without dissipation, of which a system "
            "given by its rates says nothing.",
            fix="Write it as rm.LagrangianSystem(...), or read the peaks of response_diagram.",
        )
    if len(field.names_of_roles(Role.COORDINATE)) > 1:
        raise InputError(
            "system",
            must="have one coordinate",
            got=ens.system,
            why="Resonances are named by free oscillations of the same amplitude, which two "
            "coordinates have of more than one kind.",
            fix="Pass one number as prestress of an actuator and no edges; of other systems read "
            "the peaks of response_diagram.",
        )
    if is_own and field.roles != (Role.COORDINATE, Role.RATE):
        raise InputError(
            "system",
            must="have no internal variables",
            got=ens.system,
            why="Resonances are named by free oscillations without dissipation; nothing says how "
            f"{', '.join(field.names_of_roles(Role.INTERNAL)) or 'one of first order'} moves then.",
            fix="Read the peaks of response_diagram.",
        )
