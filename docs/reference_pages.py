"""What the pages of the reference are made of, from the package itself.

A page holds ``<!-- Family: Drives -->`` where the public names of that family go, and
``<!-- Table: variables -->`` where a table goes that a function below makes.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from numpydoc.docscrape import NumpyDocString
from pydantic_core import PydanticUndefined

import remanent
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.base import Material
from remanent.models.temperature_shift import TemperatureShift
from remanent.results import schema
from remanent.studies.sweep import parts_of_file, si_sizes, study_file, values_over
from remanent.studies.sweep.study import NO_OPTIONS, verb_function, verbs_of_studies

#: Stands in a page for what is made here.
PLACE = re.compile(r"<!-- (Family|Table): (.+?) -->")
#: What users call of an actuator; the other members are what verbs ask of any system.
ACTUATOR_MEMBERS = (
    "from_si, replace, parameter_values, load, frequency, time, stress, viscosity, coupling, "
    "in_unit, coordinate_count, conservative"
)


def filled(text: str) -> str:
    """The text of a page with its places filled."""
    return PLACE.sub(lambda place: _made(place[1], place[2]), text)


def _made(kind: str, name: str) -> str:
    return _family(families()[name]) if kind == "Family" else TABLES[name]()


def families() -> dict[str, list[str]]:
    """The public names of each family in the stub of the package, in order."""
    text = Path(str(remanent.__file__)).with_suffix(".pyi").read_text("utf-8")
    parts = (part.partition("\n") for part in text.split("# Family: ")[1:])
    listed = re.compile(r"^from \S+ import (\w+) as \1$", re.M)
    return {heading: listed.findall(lines) for heading, _, lines in parts}


def _family(names: Sequence[str]) -> str:
    entries = "\n\n".join(map(_entry, names))
    return f"```{{eval-rst}}\n{entries}\n```"


def _entry(name: str) -> str:
    """The directive that documents one name."""
    value = getattr(remanent, name)
    if not inspect.isclass(value):
        return f".. autofunction:: remanent.{name}"
    if issubclass(value, BaseException):
        return f".. autoexception:: remanent.{name}"
    shown = {"Actuator": f" {ACTUATOR_MEMBERS}", "Status": "", "Measure": " at"}
    members = f"\n   :members:{shown[name]}" if name in shown else ""
    return f".. autoclass:: remanent.{name}{members}"


def _table(head: Sequence[str], rows: Iterator[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _code(text: object) -> str:
    return f"`{text}`" if text not in ("", None) else ""


# All names ----------------------------------------------------------------------------------


def names() -> str:
    """Every public name with its summary, by family."""

    def rows(listed: Sequence[str]) -> Iterator[Sequence[str]]:
        for name in listed:
            doc = NumpyDocString(inspect.getdoc(getattr(remanent, name)) or "")
            yield f"{{py:obj}}`~remanent.{name}`", _escaped(" ".join(doc["Summary"]))

    parts = (
        f"### {heading}\n\n{_table(['name', 'what it is'], rows(listed))}"
        for heading, listed in families().items()
    )
    return "\n\n".join(parts)


def _escaped(text: str) -> str:
    """Text of a docstring inside a table of Markdown."""
    text = re.sub(r":\w+:`~?(?:remanent\.)?([^`]+)`", r"`\1`", text)
    # Formulas in plain text have characters that mean something else here.
    return re.sub(r"([|*_\[\]])", r"\\\1", text) if "`" not in text else text.replace("|", r"\|")


# The variables of results -------------------------------------------------------------------


def variables() -> str:
    """Every variable of any result, under the headings of the table."""
    text = Path(schema.__file__).with_name("variables.csv").read_text("utf-8")
    known = schema.DESCRIPTIONS
    _, _, rest = text.partition("\nname,")
    blocks = re.split(r"^# (.*)$", rest, flags=re.M)[1:]
    parts = []
    for heading, lines in zip(blocks[::2], blocks[1::2], strict=True):
        listed = [line.split(",")[0].strip() for line in lines.splitlines() if line.strip()]
        rows = (_variable_row(known[name]) for name in listed)
        head = ["name", "symbol", "meaning", "unit", "dimensions of its own"]
        parts.append(f"### {heading}\n\n{_table(head, rows)}")
    return "\n\n".join(parts)


def _variable_row(row: schema.Description) -> list[str]:
    symbol = f"${row.symbol}$" if row.symbol else ""
    dims = ", ".join(map(_code, row.dims))
    return [_code(row.name), symbol, row.long_name, _unit(row), dims]


def _unit(row: schema.Description) -> str:
    """The unit, and what the number is counted in where there is none."""
    return row.units if row.units != "1" else {
        schema.QuantityKind.TIME: "1 (τ)",
        schema.QuantityKind.RATE: "1 (per τ)",
        schema.QuantityKind.SQUARED_RATE: "1 (per τ²)",
        schema.QuantityKind.STRESS: "1 (µ)",
        schema.QuantityKind.ENERGY_DENSITY: "1 (µ)",
        schema.QuantityKind.ENTROPY_DENSITY: "1 (µ/T₀)",
    }.get(row.kind, "1")  # fmt: skip


# Study files --------------------------------------------------------------------------------


def keys_at_the_top() -> str:
    """The keys and tables of a study file."""
    meanings = {
        "point_seconds": "Seconds after which a point is given up; needs `--workers`.",
        "actuator": "The body; `[actuator]` alone is a cube at 293 K.",
        "system": "A system of one's own, in place of `[actuator]`.",
        "drive": "The load; left out for verbs that take none.",
        "over": "The fields that take many values.",
        "options": "Other arguments of the verb.",
    }
    return _keys(study_file._Top, meanings)


def keys_of_actuator() -> str:
    """The keys of [actuator], which are the fields of an Actuator, and [actuator.si]."""
    told = _texts_of_parameters(Actuator)
    model = parts_of_file._actuator_table()
    meanings = told | {"si": "The sizes of the block, with units."}
    return _keys(model, meanings, {field.name: field.default for field in fields(Actuator)})


def keys_of_sizes() -> str:
    """The keys of [actuator.si]."""
    return _keys(si_sizes._sizes_table(), {"force": "The force on each edge, or a pair of them."})


def keys_of_values() -> str:
    """The keys of a field in [over]."""
    meanings = {
        "values": "A list of numbers.",
        "from": "The first value of a range.",
        "to": "The last value of a range.",
    }
    return _keys(values_over.Values, meanings)


def keys_of_points() -> str:
    """The keys of [over.sobol]."""
    return _keys(values_over.SobolPoints, {})


def _keys(model: Any, meanings: dict[str, str], usual: dict[str, Any] | None = None) -> str:
    """The keys of a table; `usual` has the values that stand for those left out."""
    rows = (
        [
            _code(key),
            _default((usual or {}).get(name, field.default)),
            meanings.get(key) or field.description or "",
            ", ".join(map(_code, field.examples or ())),
        ]
        for name, field in model.model_fields.items()
        for key in [field.alias or name]
    )  # fmt: skip
    rows_ = list(rows)
    missing = [row[0] for row in rows_ if not row[2]]
    if missing:
        raise ValueError(f"keys without a meaning: {missing}")
    if any(row[3] for row in rows_):
        return _table(["key", "by default", "meaning", "example"], iter(rows_))
    return _table(["key", "by default", "meaning"], (row[:3] for row in rows_))


def _default(value: object) -> str:
    if value is PydanticUndefined:
        return "required"
    return _code(value) if isinstance(value, int | float | str) else ""


def _texts_of_parameters(cls: type) -> dict[str, str]:
    """What the docstring of a class says of each parameter."""
    entries = NumpyDocString(inspect.getdoc(cls) or "")["Parameters"]
    return {
        name: _escaped(" ".join(" ".join(entry.desc).split()))
        for entry in entries
        for name in entry.name.split(", ")
    }


def kinds() -> str:
    """The classes that a table names as ``kind``, with their keys."""
    places: dict[str, type] = {
        "`material`": Material, "`dissipation`": Dissipation, "`heat`": Heat, "`magnet`": Magnet,
        "`shift`, of an element": TemperatureShift, "`[drive]`": Drive,
    }  # fmt: skip

    def rows() -> Iterator[Sequence[str]]:
        for place, kind in places.items():
            for k, (name, cls) in enumerate(parts_of_file.public_kinds(kind).items()):
                if cls is not Loads:
                    yield place if k == 0 else "", f"{{py:obj}}`~remanent.{name}`", _fields(cls)
        for k, cls in enumerate((remanent.LagrangianSystem, remanent.FirstOrderSystem)):
            yield (
                "`[system]`" if k == 0 else "",
                f"{{py:obj}}`~remanent.{cls.__name__}`",
                _fields(cls),
            )

    return _table(["where", "`kind`", "keys, with their usual values"], rows())


def _fields(cls: Any) -> str:
    def text(field: Any) -> str:
        if field.default is MISSING and field.default_factory is MISSING:
            return f"`{field.name}`"
        plain = isinstance(field.default, int | float | str) and field.default != ""
        return f"`{field.name} = {field.default!r}`" if plain else f"`{field.name}` (optional)"

    return ", ".join(text(field) for field in fields(cls) if field.init)


def options() -> str:
    """The options of each verb that a study runs."""

    def rows() -> Iterator[Sequence[str]]:
        for verb in verbs_of_studies():
            parameters = inspect.signature(verb_function(verb)).parameters.values()
            listed = [p for p in parameters if p.name not in NO_OPTIONS and p.name != "store"]
            yield f"{{py:obj}}`~remanent.{verb}`", ", ".join(map(_option, listed))

    return _table(["`verb`", "options, with their usual values"], rows())


def _option(parameter: inspect.Parameter) -> str:
    if parameter.default is inspect.Parameter.empty:
        return f"`{parameter.name}`"
    if parameter.default is None or parameter.default == ():
        return f"`{parameter.name}` (optional)"
    return f"`{parameter.name} = {parameter.default!r}`"


def statuses() -> str:
    """Every status code."""
    rows = ([str(s.value), _code(s.meaning), s.explanation] for s in remanent.Status)
    return _table(["code", "flag", "meaning"], rows)


#: What makes each table.
TABLES: dict[str, Callable[[], str]] = {
    "names": names, "variables": variables, "statuses": statuses,
    "keys at the top": keys_at_the_top, "keys of actuator": keys_of_actuator,
    "keys of actuator.si": keys_of_sizes, "keys of values": keys_of_values,
    "keys of sobol": keys_of_points, "kinds": kinds, "options": options,
}  # fmt: skip
