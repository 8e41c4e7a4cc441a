"""A system under a drive as a page knows it: a description, and its equations as a module."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from remanent._errors import InputError, InputWarning
from remanent._field import Role, StateVariable
from remanent.codegen.languages.javascript_field import JavaScriptField, javascript_field
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.parts import Part
from remanent.models.system import System
from remanent.page.described import described, described_number
from remanent.page.limits import limits_program
from remanent.page.plausible import bounds_of
from remanent.page.spec import Spec, read_spec, write_spec
from remanent.studies.ensemble.checks import DriveArgument, require_drive, require_system
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.export.export import require_waveforms_as_data

#: The format of descriptions.
FORMAT: Final = 1
#: Parts of an actuator, which are groups of controls.
_PART_GROUPS: Final = ("material", "dissipation", "heat", "magnet")
#: Why a control cannot be moved without new equations.
_FIXED_IN_TABLE: Final = "The pieces of the load are computed from it beforehand."
_FIXED_RATIO: Final = "The periods of the loads are in a fixed ratio."
_FIXED_ZERO: Final = "The period does not count a term whose load is 0."


@dataclass(frozen=True)
class PageModel:
    """A system under a drive as a page shows it.

    Attributes
    ----------
    description : dict
        Plain data: names, units, texts and ranges of all that is shown and moved.
    field_source : str
        The text of a module with its equations.
    """

    description: dict[str, Any]
    field_source: str

    @property
    def id(self) -> str:
        """By which its module is called."""
        return str(self.description["id"])

    @property
    def spec(self) -> Spec:
        """What :func:`page_model_of_spec` makes it from."""
        return dict(self.description["spec"])


def page_model(
    system: System, drive: DriveArgument, initial: Mapping[str, float] | None = None
) -> PageModel:
    """Describe a system under a drive for a page, and write its equations as a module.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        Its load.
    initial : mapping of str to float, optional
        Values of state variables at time 0; those that are not named are at rest.

    Returns
    -------
    PageModel

    Raises
    ------
    InputError
        A bad argument.

    Examples
    --------
    >>> import remanent as rm
    >>> model = page_model(rm.Actuator(), rm.SineSquared(0.4, 1.25))
    >>> [one["name"] for one in model.description["state"]]
    ['stretch', 'stretch_rate']
    >>> model.description["spec"]["drive"]
    {'kind': 'SineSquared', 'b': 0.4, 'omega': 1.25, 'phase': 0.0}
    """
    require_system("system", system)
    drive = require_drive(drive)
    given = dict(initial or {})
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", InputWarning)
        ens = _laid_out(system, drive, given)
        system.warn_if_implausible(system.parameter_values())
    require_waveforms_as_data(drive)
    field = ens.vector_field
    values = {name: float(column[0]) for name, column in ens.parameter_values.items()}
    module = javascript_field(field, drive, values, limits_program(system, field))
    description = {
        "format": FORMAT,
        "id": module.id,
        "title": _title(system, drive),
        "kind": type(system).__name__,
        "spec": write_spec(system, drive, given),
        "state": [_described_state(one, system) for one in field.variables],
        "observables": [described(name, system.variable_texts())
                        for name in module.observable_names],
        "watched": field.observable_name,
        "parameters": _described_parameters(system, drive, values, module),
        "coordinates": len(field.indices_of_roles(Role.COORDINATE)),
        "conservative": bool(system.conservative),
        "drive": _described_drive(drive),
        "si": _si_factors(system),
        "initial": [float(x) for x in ens.initial_states[0]],
        "warnings": [*dict.fromkeys(
            str(one.message) for one in said if issubclass(one.category, InputWarning)
        )],
    }  # fmt: skip
    return PageModel(description, module.source)


def page_model_of_spec(spec: object) -> PageModel:
    """The page model of a description in plain data, as :func:`~remanent.page.spec.read_spec` has.

    Raises
    ------
    FaultsError, InputError
    """
    with warnings.catch_warnings():
        # The model itself holds what these say.
        warnings.simplefilter("ignore", InputWarning)
        system, drive, initial = read_spec(spec)
    return page_model(system, drive, initial)


def _laid_out(system: System, drive: Drive, initial: Mapping[str, float]) -> Ensemble:
    """The one motion, with all checks of a verb."""
    ens = lay_out_ensemble(system, drive)
    names = ens.vector_field.state_names
    for name in initial:
        if name not in names:
            raise InputError(
                "initial",
                must=f"name state variables, {', '.join(names)}",
                got=repr(name),
                why="They are what has a value at time 0.",
                fix="Leave it out.",
            )
    if not initial:
        return ens
    start = np.array(ens.initial_states[0])
    for name, value in initial.items():
        start[names.index(name)] = value
    return lay_out_ensemble(system, drive, None, start)


def _title(system: System, drive: Drive) -> str:
    load = ", ".join(type(one).__name__ for one in drive.parts().values()) or type(drive).__name__
    return f"{type(system).__name__}, {load}"


def _described_state(variable: StateVariable, system: System) -> dict[str, Any]:
    return {
        **described(variable.name, system.variable_texts()),
        "role": str(variable.role),
        "rest": variable.rest,
        "positive": variable.positive,
        "belongs_to": variable.belongs_to,
        "bounds": bounds_of(variable.name, system).plain,
    }


def _described_parameters(
    system: System, drive: Drive, values: Mapping[str, float], module: JavaScriptField
) -> list[dict[str, Any]]:
    """Every number that may be moved, those of the system before those of the drive."""
    own = system.variable_texts()
    rules = {**system.parameter_rules(), **drive.parameter_rules()}
    reasons = _reasons_to_be_fixed(drive, values, module.changeable)
    parameters = []
    for name, rule in rules.items():
        of_drive = name in drive.parameter_rules()
        owner = _owner_of(drive if of_drive else system, name)
        entry = described_number(name, values[name], rule, own, owner)
        entry["group"] = "drive" if of_drive else _group_of(system, name)
        entry["fixed"] = reasons.get(name)
        entry["bounds"] = bounds_of(name, system).plain
        parameters.append(entry)
    return parameters


def _group_of(system: System, name: str) -> str:
    if not isinstance(system, Actuator):
        return "system"
    part = name.partition(".")[0]
    return part if part in _PART_GROUPS else "actuator"


def _owner_of(value: object, name: str) -> type | None:
    """The class that has a field of this dotted name."""
    owner = value
    for step in _steps(name):
        parts = owner.parts() if isinstance(owner, Actuator | Part) else {}
        owner = parts.get(step, owner)
    return type(owner)


def _steps(name: str) -> list[str]:
    """The names of the parts in a dotted name; numbers belong to what they count."""
    steps: list[str] = []
    for word in name.split(".")[:-1]:
        if word.isdigit() and steps:
            steps[-1] += f".{word}"
        else:
            steps.append(word)
    return steps


def _reasons_to_be_fixed(
    drive: Drive, values: Mapping[str, float], changeable: Sequence[str] | frozenset[str]
) -> dict[str, str]:
    """Numbers of the drive that the module does not take, with the reason."""
    own = drive.parameter_values()
    reasons = {}
    if drive.period is None and drive.piece_parameter_names:
        reasons = {name: _FIXED_IN_TABLE for name in own if name not in changeable}
    if isinstance(drive, Loads):
        periods = [name for name, one in drive.parts().items()
                   if isinstance(one, Drive) and one.period is not None]  # fmt: skip
        if len(periods) > 1:
            reasons |= {f"{load}.omega": _FIXED_RATIO for load in periods}
    for name in own:
        is_load = name.rpartition(".")[0].rpartition(".")[2] == "loads"
        if is_load and values[name] == 0.0 and drive.period is not None:
            reasons[name] = _FIXED_ZERO
    return reasons


def _described_drive(drive: Drive) -> dict[str, Any]:
    known = drive.known_until
    return {
        "kind": type(drive).__name__,
        "periodic": drive.period is not None,
        "period_field": drive.period_field_name,
        "known_until": known if math.isfinite(known) else None,
        "last_change": float(drive.last_change),
        "loads": [*drive.load_names],
    }


def _si_factors(system: System) -> dict[str, Any] | None:
    """SI units in one dimensionless unit; None where nothing has a physical size."""
    scales = system.scales
    if scales is None or not isinstance(system, Actuator):
        return None
    factors = scales.si_factors()
    length = scales.half_length
    edges = system.edges or (1.0, 1.0)
    return {
        "time": factors["time_s"],
        "frequency": 1.0 / factors["time_s"],
        "load": factors.get("load_T"),
        "stress": factors["stress_pa"],
        "viscosity": factors["stress_pa"] * factors["time_s"],
        "lengths": {
            "thickness": 2.0 * length * math.sqrt(system.c),
            "edge_1": 2.0 * length * edges[0],
            "edge_2": 2.0 * length * edges[1],
        },
    }
