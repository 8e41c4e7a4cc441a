"""All branches of forced response over the frequency of the drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from remanent._typing import ArrayLike
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.orbits._branch_tables import label_branches
from remanent.studies.orbits._checks import require_slices
from remanent.studies.orbits._forced_response import (
    require_frequency_range,
    trace_all_forced_response_branches,
)
from remanent.studies.orbits._members import map_members_in_threads
from remanent.studies.orbits._orbit_tables import ORBIT_DIMENSIONS
from remanent.studies.orbits._tracing import TracingOptions


def response_diagram(
    system: System,
    drive: DriveArgument,
    omega_range: ArrayLike,
    *,
    state_box: Mapping[str, Any] | None = None,
    orbit_period: int = 1,
    over: OverArgument | None = None,
    slices: int = 9,
    max_points: int = 2000,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """All branches of forced response over the drive's frequency, stable and unstable.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A load with a field ``omega``, whose value is not used.
    omega_range : (lowest, highest)
        Frequencies, radians per unit of tau, or with a unit, ``("820 Hz", "920 Hz")``, where
        the actuator has SI sizes.
    state_box : mapping of name to (lower, upper), optional
        Range of each state variable at phase 0, such as ``{"stretch": (0.3, 4.0)}``, where
        branches end: undamped ones run off to infinite amplitude.  By default stretches
        from 0.3 to 4, rates from −8 to 8, temperatures up to 5 K from that of the
        surroundings.
    orbit_period : int
        Of the orbits in drive periods.
    over : mapping of name to values, optional
        Values of other numeric fields; they become dimensions of the result.
    slices : int
        At how many frequencies orbits are looked for, at most 10 000.  A branch (an isola) that
        passes none of them is missed.
    max_points : int
        Of a branch, in each direction from the orbit where it was found.
    tolerance : float
        Of the residual: the distance of an orbit's point from its image.
    progress : bool or callable, optional
        True draws a bar; a callable is called with the share of the combinations in `over`
        that are finished.

    Returns
    -------
    xarray.Dataset
        Along ``branch`` and ``point``, ``special``, ``branch`` and ``end``: the variables of
        :func:`remanent.continue_orbit`, with ``special_branch``, the branch of each special
        point.  Padded with NaN where there are fewer.  ``status`` is ``incomplete`` where an
        end is ``max_points``, ``lost`` or a bound of the state that was not asked for, or where
        the search for orbits was at one of the frequencies, with the ``reason``: undamped
        branches run off to infinite amplitude.

    Raises
    ------
    InputError
        A bad argument, or a drive without ``omega``.

    See Also
    --------
    continue_orbit : One branch, over any parameter.
    frequency_response : The response from rest, as an experiment sees it.
    resonances : Which resonance each peak of the branches is.

    Notes
    -----
    Orbits are searched at the slices as by :func:`remanent.periodic_orbits`, and each that no
    branch has passed yet is followed both ways as by :func:`remanent.continue_orbit`.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.response_diagram(rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.0), (1.1, 1.4))
    >>> [round(float(w), 4) for w in ds.special_omega[ds.special_kind == "fold"]]
    [1.2668]
    """
    ens = lay_out_ensemble(system, drive, over, reserved=ORBIT_DIMENSIONS)
    limits = require_frequency_range(omega_range, ens)
    options = TracingOptions("omega", limits, state_box, orbit_period, max_points, tolerance)
    options = options.require_valid(ens)
    slices = require_slices(slices)
    tables = map_members_in_threads(
        ens,
        lambda member: trace_all_forced_response_branches(member, options, slices),
        as_progress(progress),
    )
    return label_branches(ens, tables, options, slices=slices)
