"""The lines of Python, and the study file, that make what a page shows."""

from __future__ import annotations

import warnings
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, Final

from remanent._errors import InputWarning
from remanent._field import Field as VectorField
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.own_systems.written_system import WrittenSystem
from remanent.models.system import System
from remanent.page.spec import Spec, actuator_table, read_spec, write_spec
from remanent.page.toml import toml_text
from remanent.studies.ensemble.layout import lay_out_ensemble

#: Length of a run where the page says none.
_PERIODS: Final = 500
_DURATION: Final = 100.0
#: Longest line before a call is written over several.
_LINE_LENGTH: Final = 88


def reproduction(
    spec: object, *, periods: int | None = None, duration: float | None = None
) -> dict[str, str]:
    """The lines of Python and the study file that make what a page shows.

    Parameters
    ----------
    spec : object
        As :func:`~remanent.page.spec.read_spec` takes it.
    periods : int, optional
        Length of the run in periods of the load.
    duration : float, optional
        Length of the run, where that is not given.

    Returns
    -------
    dict of str to str
        ``python``, and ``study``, the text of a study file for `remanent run`.

    Raises
    ------
    FaultsError, InputError

    Examples
    --------
    >>> drive = {"kind": "SineSquared", "b": 0.4, "omega": 1.25}
    >>> print(reproduction({"actuator": {"temperature": 350}, "drive": drive})["python"])
    import remanent as rm
    <BLANKLINE>
    system = rm.Actuator(temperature=350.0)
    drive = rm.SineSquared(b=0.4, omega=1.25)
    motion = rm.simulate(system, drive, periods=500)
    section = rm.poincare_section(system, drive, periods=500)
    rm.plot.history(motion)
    <BLANKLINE>
    """
    with warnings.catch_warnings():
        # The page itself shows what these say.
        warnings.simplefilter("ignore", InputWarning)
        system, drive, initial = read_spec(spec)
        ens = lay_out_ensemble(system, drive)
    length = _length(drive, periods, duration)
    start = None
    if initial:
        rest = map(float, ens.initial_states[0])
        states = zip(ens.vector_field.state_names, rest, strict=True)
        start = [initial.get(name, value) for name, value in states]
    return {
        "python": _python(system, drive, start, length),
        "study": _study(system, drive, ens.vector_field, start, length),
    }


def _length(drive: Drive, periods: int | None, duration: float | None) -> tuple[str, float]:
    """The argument for the length of the run, and its value."""
    if drive.period is not None and (periods is not None or duration is None):
        return "periods", int(periods or _PERIODS)
    return "duration", min(float(duration or _DURATION), drive.known_until)


def _python(
    system: System, drive: Drive, start: list[float] | None, length: tuple[str, float]
) -> str:
    name, value = length
    further = {name: repr(value)} if start is None else {"initial": "initial", name: repr(value)}
    arguments = ", ".join(["system", "drive", *(f"{k}={x}" for k, x in further.items())])
    lines = [
        "import remanent as rm",
        "",
        f"system = {_system_text(system)}",
        f"drive = {_drive_text(drive)}",
        *([] if start is None else [f"initial = {start!r}"]),
        f"motion = rm.simulate({arguments})",
    ]
    if drive.period is not None and name == "periods":
        lines.append(f"section = rm.poincare_section({arguments})")
    return "\n".join([*lines, "rm.plot.history(motion)", ""])


def _study(
    system: System,
    drive: Drive,
    field: VectorField,
    start: list[float] | None,
    length: tuple[str, float],
) -> str:
    """A study of one point, of the one field that is varied first as a rule."""
    values = {**system.parameter_values(), **drive.parameter_values()}
    usual = [drive.period_field_name, "temperature", *values]
    varied = next((name for name in usual if name in values), None)
    over = {varied: [values[varied]]} if varied is not None else {}
    if not over:
        first = field.state_names[0]
        over = {f"initial.{first}": [field.variables[0].value_at_rest(values)]}
    if start is not None:
        over |= {f"initial.{name}": [x] for name, x in zip(field.state_names, start, strict=True)}
    tables = {
        "verb": "simulate",
        "store": "motion.zarr",
        **write_spec(system, drive, {}),
        "over": over,
        "options": {length[0]: length[1]},
    }
    return toml_text(tables)


# Values as they are written in Python ----------------------------------------------------


def _system_text(system: System) -> str:
    if isinstance(system, Actuator) and system.scales is not None:
        return _si_text(system)
    return _value_text(system)


def _si_text(actuator: Actuator) -> str:
    """An actuator by its sizes: what follows from them is left out."""
    table: Spec = actuator_table(actuator)
    parts = {
        field.name: getattr(actuator, field.name)
        for field in fields(actuator)
        if field.name in ("material", "dissipation", "heat", "magnet")
    }
    given = _changed(Actuator, parts)
    numbers = {
        f"{name}": f'"{getattr(actuator, name)!r} K"'
        for name in ("temperature", "reference_temperature")
    }
    sizes = {name: f'"{text}"' for name, text in table["si"].items()}
    call = _call_text("rm.Actuator.from_si", {**sizes, **numbers, **given})
    if actuator.prestress in (0.0, (0.0, 0.0)):
        return call
    return f"{call}.replace(prestress={actuator.prestress!r})"


def _drive_text(drive: Drive) -> str:
    if not isinstance(drive, Loads):
        return _value_text(drive)
    drives = (f'"{name}": {_value_text(one)}' for name, one in drive.parts().items())
    return f"{{{', '.join(drives)}}}"


def _value_text(value: Any) -> str:
    """A value of the package as a call; what has its usual value is left out."""
    if is_dataclass(value) and not isinstance(value, type):
        content = {field.name: getattr(value, field.name) for field in fields(value) if field.init}
        pairs = value.mapping_fields if isinstance(value, WrittenSystem) else ()
        pairs = (*pairs, *getattr(value, "mapping_rules", ()))
        content |= {name: dict(content[name]) for name in pairs}
        return _call_text(f"rm.{type(value).__name__}", _changed(type(value), content))
    if isinstance(value, tuple | list):
        inner = ", ".join(map(_value_text, value))
        return f"({inner},)" if len(value) == 1 else f"({inner})"
    return repr(value)


def _changed(cls: Any, content: dict[str, Any]) -> dict[str, str]:
    """The text of each field that has not its usual value."""
    given = {field.name: field for field in fields(cls)}
    return {
        name: _value_text(value)
        for name, value in content.items()
        if value is not None and _differs(given[name], value)
    }


def _differs(field: Field[Any], value: Any) -> bool:
    if field.default_factory is not MISSING:
        return bool(value != field.default_factory())
    if isinstance(value, dict):
        return bool(value)
    return field.default is MISSING or bool(value != field.default)


def _call_text(name: str, arguments: dict[str, str]) -> str:
    """A call, over several lines where it is long."""
    texts = [f"{key}={value}" for key, value in arguments.items()]
    line = f"{name}({', '.join(texts)})"
    if len(line) <= _LINE_LENGTH:
        return line
    inner = "".join(f"    {text},\n" for text in texts)
    return f"{name}(\n{inner})"
