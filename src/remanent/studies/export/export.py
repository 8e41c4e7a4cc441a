"""The field of a system under a load as source text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType
from typing import Final

from remanent._checks import require_choice
from remanent._errors import InputError, shortened_repr
from remanent._field import Role
from remanent._typing import FloatArray
from remanent.codegen.languages.auto07p import auto07p_files
from remanent.codegen.languages.c import c_files
from remanent.codegen.languages.javascript import javascript_files
from remanent.codegen.languages.julia import julia_files
from remanent.codegen.languages.matlab import matlab_files
from remanent.codegen.languages.python import python_files
from remanent.codegen.languages.written import StateText, WrittenEquations, written_equations
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble

#: What writes the files of each language.
_FILES: Final[Mapping[str, Callable[[Ensemble], dict[str, str]]]] = MappingProxyType(
    {
        "matlab": lambda ens: matlab_files(_written(ens)),
        "python": lambda ens: python_files(_written(ens)),
        "julia": lambda ens: julia_files(_written(ens)),
        "auto07p": lambda ens: auto07p_files(_with_parameters(ens), *_starting_orbit(ens)),
        "c": lambda ens: c_files(_written(ens)),
        "javascript": lambda ens: javascript_files(_written(ens)),
    }
)
#: The languages.
EXPORT_LANGUAGES: Final = tuple(_FILES)
#: Longest description of a system or a drive in a header, in characters.
_LONGEST_DESCRIPTION: Final = 600


def export(system: System, drive: DriveArgument, language: str) -> dict[str, str]:
    """Write the equations of motion under a load as source text for another tool.

    It is the straight-line code that the compiled kernels run, with the load as a function of
    time, the parameters by name, and a header that says what it is.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        Its load.
    language : str
        ``matlab`` (functions, and a script with ``ode45``; Octave runs them too), ``python`` (for
        SciPy), ``julia`` (for DifferentialEquations.jl), ``auto07p`` (equations, constants and a
        periodic orbit to start from, under a load with a period), ``c`` or ``javascript`` (a
        module).

    Returns
    -------
    dict of str to str
        The text of each file by its name.  ``system.py`` has ``rates(t, y)``, ``load(t)``,
        ``initial``, ``parameters``, ``state_names`` and ``breaks``; ``system.jl``,
        ``system.js`` and ``remanent_rates.m`` have the like; ``system.c`` has
        ``void remanent_rates(double t, const double *y, double *dydt)``.  With several loads
        each has a function, ``load_voltage(t)``.

    Raises
    ------
    InputError
        A bad argument; for ``auto07p`` also a load without a period, no parameter to vary, or no
        orbit to start from.

    See Also
    --------
    rates : The same as a function, evaluated with NumPy.
    equations : The equations of motion as formulas.

    Notes
    -----
    Names that a language reserves get a number after them, which the header tells.  At a jump of
    the load, the load after it is taken: an integrator is to be started anew at the times in
    ``breaks``.

    In the files for AUTO the phase of the load is one more state variable, and the problem is one
    with boundary values (IPS = 7): U(1), U(2) ... are the state, and the interval from 0 to 1 is
    one period of the load.  The orbit is one of those that are found near the motion from rest,
    or, of an actuator, of all; a stable one where there is one.  Where the rates are no numbers F
    is 1e30, of which AUTO makes a smaller step.

    Examples
    --------
    >>> import remanent as rm
    >>> files = rm.export(rm.Actuator(), rm.SineSquared(0.4, 1.25), "python")
    >>> list(files)
    ['system.py']
    >>> print(files["system.py"].splitlines()[0])
    # The equations of motion of an Actuator under a SineSquared load, y' = rates(t, y).
    """
    language = require_choice("language", language, EXPORT_LANGUAGES)
    ens = lay_out_ensemble(system, drive)
    require_waveforms_as_data(ens.drive)
    return _FILES[language](ens)


def require_waveforms_as_data(drive: Drive) -> None:
    """Refuse a drive of somebody else's that has waveforms and does not say what they are."""
    if len(drive.waveforms) != len(drive.waveform_names):
        raise InputError(
            "drive",
            must="say as data what its waveforms are",
            got=f"a {type(drive).__name__} drive",
            why="Their values at a phase cannot be written as text.",
            fix="Define its property waveforms, or pass one of the drives of the package.",
        )


def _written(ens: Ensemble) -> WrittenEquations:
    values = {name: float(column[0]) for name, column in ens.parameter_values.items()}
    texts = ens.system.variable_texts()
    state = tuple(
        StateText(name, texts[name].units if name in texts else _usual_unit(name, ens), float(x))
        for name, x in zip(ens.vector_field.state_names, ens.initial_states[0], strict=True)
    )
    return written_equations(ens.vector_field, ens.drive, values, state, _description(ens))


def _starting_orbit(ens: Ensemble) -> tuple[FloatArray, FloatArray, bool]:
    """The orbit from which AUTO starts; the other languages do without the search for it."""
    from remanent.studies.export._starting_orbit import starting_orbit

    return starting_orbit(ens)


def _with_parameters(ens: Ensemble) -> WrittenEquations:
    """The equations, in which there has to be something to vary."""
    equations = _written(ens)
    if not equations.parameters:
        raise InputError(
            "system",
            must="have a parameter, or its load a frequency",
            got=shortened_repr(ens.system),
            why="AUTO continues an orbit while a parameter varies.",
            fix="Put a number of a formula into `parameters`.",
        )
    return equations


def _usual_unit(name: str, ens: Ensemble) -> str:
    """The unit of a state variable of an actuator."""
    return "K" if name in ens.vector_field.names_of_roles(Role.TEMPERATURE) else "1"


def _description(ens: Ensemble) -> tuple[str, ...]:
    system, drive = (type(one).__name__ for one in (ens.system, ens.drive))
    return (
        f"The equations of motion of {_article(system)} under {_article(drive)} load, "
        "y' = rates(t, y).",
        f"Made by remanent {_version()}.",
        "",
        f"System: {_shortened(ens.system)}",
        f"Drive: {_shortened(ens.drive)}",
        f"Units: {_units(ens)}",
    )


def _units(ens: Ensemble) -> str:
    scales = ens.system.scales
    if scales is not None:
        return f"dimensionless; one unit of time is {scales.time_unit!r} s."
    if ens.system.variable_texts():
        time = ens.system.variable_texts().get("time")
        return f"as given{f'; of time {time.units}' if time else ''}; 1 where none was given."
    return "dimensionless; temperatures in K."


def _article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"


def _shortened(value: object) -> str:
    text = " ".join(repr(value).split())
    cut = text[: _LONGEST_DESCRIPTION - 3]
    return text if len(text) <= _LONGEST_DESCRIPTION else f"{cut}..."


def _version() -> str:
    try:
        return version("remanent")
    except PackageNotFoundError:
        return "(not installed)"
