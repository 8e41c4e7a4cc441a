"""A study as the text of a study file: the way back from `read_study`, for tests."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def study_text(plain: Mapping[str, Any]) -> str:
    """TOML with the plain data of a study; sizes in SI and two-dimensional grids have no file."""
    system = dict(plain["system"])
    title = "system"
    if system["kind"] == "Actuator":
        title = "actuator"
        system = {k: v for k, v in system.items() if k not in ("kind", "scales", "physical_sizes")}
    lines = [f"verb = {value_text(plain['verb'])}", *table(title, system)]
    if "drive" in plain:
        drive = plain["drive"]
        lines += table("drive", drive["drives"] if drive["kind"] == "Loads" else drive)
    over = {name: _values(name, entry) for name, entry in plain["over"].items()}
    return "\n".join([*lines, *table("over", over), *table("options", plain["options"]), ""])


def table(title: str, content: Mapping[str, Any]) -> list[str]:
    """The lines of a table."""
    given = {key: value for key, value in content.items() if value is not None}
    return [
        f"[{title}]",
        *(f"{json.dumps(key)} = {value_text(value)}" for key, value in given.items()),
    ]


def value_text(value: Any) -> str:
    """A value as TOML has it; numbers keep their last bit."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        pairs = (f"{json.dumps(k)} = {value_text(v)}" for k, v in value.items() if v is not None)
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(value_text, value))}]"
    return repr(value)


def _values(name: str, entry: Mapping[str, Any]) -> Any:
    """What [over] has for a field."""
    (dim,) = entry["dims"]
    return entry["values"] if dim == name else {"values": entry["values"], "dim": dim}
