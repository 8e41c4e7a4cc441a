"""Step commands that land a block at rest on a target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._checks import positive, require_known, require_real
from remanent._errors import InputError
from remanent._typing import ArrayLike
from remanent.analysis import shaping
from remanent.analysis.shaping import Design
from remanent.models.actuator import Actuator
from remanent.models.drives.piecewise import Steps
from remanent.models.drives.waves import Constant
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.control._terminal_conditions import Arrival
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.ensemble import Ensemble, Over, ensemble
from remanent.studies.ensemble.physical_scales import PHYSICAL
from remanent.studies.orbits._period_map import at
from remanent.studies.statics._static_state import Body

_TARGET = positive("It is a thickness stretch, a ratio of lengths.", "Pass for example 1.2.")
#: Stages in which the target is moved out from the start, where one does not do.
_STAGES = (1, 4, 16)
#: Spacing of the steps over half a period where the start is not at rest.
_UNEVEN = 0.8
#: A state nearer to rest than this is at rest.
_STILL = 1e-9
#: A design is taken if its conditions are met to this many times the tolerance.
_ACCEPTED = 100.0


def shape_command(
    actuator: Actuator,
    target: float,
    *,
    initial: ArrayLike | None = None,
    robust_to: str | Sequence[str] = (),
    tolerance: float = 1e-10,
) -> Steps:
    r"""Steps of the magnetic load that land on a thickness stretch at rest.

    Parameters
    ----------
    actuator
        Any: prestressed, damped, of any material, with internal variables.
    target
        Thickness stretch λ₃ at which it is to stay.
    initial : (stretch, rate)
        From where; (1, 0) by default, as in every verb, also with prestress, where it is not
        an equilibrium under no load.  For a move from there pass the ``stretch`` that
        :func:`remanent.equilibria` gives, and 0.
    robust_to
        Fields of the actuator (``"temperature"`` ...), or ``"shear_modulus"``, ``"density"``,
        ``"remanence"``: the residual vibration shall not change, to first order, with each of
        them.  The command is longer by about half a period for each.
    tolerance
        Of the state at the last step.

    Returns
    -------
    Steps
        The drive; its last load is held for ever.

    Raises
    ------
    InputError
        A bad argument, a target that is no stable equilibrium under any load, or no command
        found.

    Notes
    -----
    Without prestress and damping, for the neo-Hookean solid, the answer is two steps:
    m₁ = θ(x − 1)(x + 2)/(2x), whose motion from rest turns at x, for half its period, then
    m₂ = θ(x³ − 1)/x², under which x is an equilibrium.  In general the last load and state of
    rest solve the equations of equilibrium; loads and durations before it solve
    y(end) = y(rest), and dy(end)/dp = dy(rest)/dp for each p in `robust_to`, by least squares
    from the answer for small moves (:func:`remanent.analysis.shaping.fractions`).

    Examples
    --------
    >>> import remanent as rm
    >>> command = rm.shape_command(rm.Actuator(), 1.5)
    >>> [round(m, 6) for m in command.loads]
    [0.583333, 1.055556]
    """
    found = shape_commands(
        actuator, target, initial=initial, robust_to=robust_to, tolerance=tolerance
    )
    return Steps(found.step_time.values, found.step_load.values)


def shape_commands(
    actuator: Actuator,
    target: float,
    *,
    initial: ArrayLike | None = None,
    robust_to: str | Sequence[str] = (),
    over: Over | None = None,
    tolerance: float = 1e-10,
) -> xr.Dataset:
    """Commands of :func:`remanent.shape_command` for many values of the actuator's fields.

    Parameters
    ----------
    actuator, target, initial, robust_to, tolerance
        As there.
    over
        Values of fields of the actuator; they become dimensions.

    Returns
    -------
    xarray.Dataset
        Along ``step``: ``step_time`` and ``step_load``; ``switch_time``, that of the last
        step, with ``switch_time_error``; ``residual``, the largest distance of the state from
        rest then.  NaN where there is no command.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.shape_commands(rm.Actuator(), 1.5, over={"temperature": [250.0, 350.0]})
    >>> ds.switch_time.values.round(4).tolist()
    [1.5415, 1.3028]
    """
    target = require_real("target", target, _TARGET)
    require_tolerance(tolerance)
    sizes = (robust_to,) if isinstance(robust_to, str) else tuple(robust_to)
    ens = ensemble(actuator, Constant(0.0), over, initial, reserved=frozenset({"step"}))
    known = [name for name in ens.field.parameters if name != "m"]
    require_known(sizes, [*known, *PHYSICAL], "the actuator, or a physical size")
    found: list[Design | None] = []
    last = []
    for k in range(ens.count):
        try:
            design, load = _command(at(ens, k), target, sizes, tolerance)
        except InputError:
            if not ens.sizes:
                raise
            design, load = None, np.nan
        found.append(design)
        last.append(load)
    return _labelled(ens, target, sizes, found, last, tolerance)


def _command(
    single: Ensemble, target: float, sizes: Sequence[str], tolerance: float
) -> tuple[Design, float]:
    """The steps before the last, and the last load, for one actuator."""
    if single.invalid[0]:
        raise _impossible(target, "a field is invalid")
    actuator = single.system
    for name, value in actuator.parameters().items():
        if single.values[name][0] != value:
            actuator = actuator.with_parameter(name, float(single.values[name][0]))
    row = np.array([float(single.values[name][0]) for name in single.field.parameters])
    body = Body(single.field, row, single.initial[0])
    here = body.thickness()
    start = body.at_target(here) or body
    away = np.where(np.abs(body.state - start.state) > _STILL, body.state - start.state, 0.0)
    fine = 0.1 * tolerance * max(1.0, float(np.abs(body.state).max()))
    accepted = _ACCEPTED * max(tolerance, fine)
    for stages in _STAGES:
        parts = np.linspace(0.0, 1.0, stages + 1)[1:]
        ends = [body.at_target(here + part * (target - here)) for part in parts]
        finals = [end for end in ends if end is not None]
        if len(finals) < stages:
            raise _impossible(target, "no load holds it there")
        guess = _linear(finals[0], start.load, len(sizes), target, moving=bool(away.any()))
        last = parts[0]
        for part, final in zip(parts, finals, strict=True):
            loads = start.load + part / last * (guess.loads - start.load)
            arrival = Arrival(actuator, final, start.state + part * away, sizes, fine)
            scale = max(abs(final.load - start.load), float(np.abs(away).max()), 1e-3)
            guess = shaping.solve(
                arrival, replace(guess, loads=loads), scale=scale, tolerance=tolerance
            )
            last = part
            if guess.residual > accepted:
                break  # shorter stages are next
        if guess.residual <= accepted:
            return guess, finals[-1].load
    raise _impossible(target, f"the best command misses rest by {guess.residual:.1e}")


def _linear(final: Body, before: float, extra: int, target: float, *, moving: bool) -> Design:
    """The steps for a small move, by the linear motion about the target.

    A start that is not at rest needs as many steps as there are poles; at another spacing
    than half a period no two of their roots are one.
    """
    found = shaping.poles(*final.linear())
    if (found.real > 1e-9 * np.abs(found).max()).any():
        raise _impossible(target, "the equilibrium there is unstable")
    spacing = shaping.interval(found) * (_UNEVEN if moving else 1.0)
    parts = shaping.fractions(found, spacing, 1 + extra)
    loads = before + (final.load - before) * np.cumsum(parts)[:-1]
    return Design(loads, np.full(loads.size, spacing))


def _impossible(target: float, why: str) -> InputError:
    return InputError(
        "target", "be a thickness stretch that steps can reach at rest", target,
        f"For this actuator {why}.", "Pass one nearer to the start, or leave `robust` out.",
    )  # fmt: skip


def _labelled(
    ens: Ensemble,
    target: float,
    sizes: Sequence[str],
    found: Sequence[Design | None],
    last: Sequence[float],
    tolerance: float,
) -> xr.Dataset:
    most = max((d.loads.size for d in found if d is not None), default=0) + 1
    times, loads = np.full((2, ens.count, most), np.nan)
    residual, error = np.full((2, ens.count), np.nan)
    for k, (design, load) in enumerate(zip(found, last, strict=True)):
        if design is not None:
            n = design.loads.size
            times[k, : n + 1] = np.concatenate([[0.0], np.cumsum(design.durations)])
            loads[k, : n + 1] = np.append(design.loads, load)
            residual[k], error[k] = design.residual, design.error
    dims = (*ens.dims, "step")
    switch = np.fmax.reduce(times, axis=1)
    variables: dict[str, Labelled] = {
        "step_time": (dims, ens.shaped(times)),
        "step_load": (dims, ens.shaped(loads)),
        "switch_time": (ens.dims, ens.shaped(switch)),
        "switch_time_error": (ens.dims, ens.shaped(error)),
        "residual": (ens.dims, ens.shaped(residual)),
    }
    coords: dict[str, Labelled] = {**ens.coords, "step": (("step",), np.arange(most))}
    attributes = provenance.attributes(
        ens.system,
        None,
        tolerance,
        over=ens.coords,
        target=target,
        robust=" ".join(sizes) or None,
    )
    return build.dataset(variables, coords, attributes)
