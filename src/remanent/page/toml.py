"""Tables of plain data as TOML: study files that a page gives away."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any, Final

#: Keys that need no quotes.
_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(tables: Mapping[str, Any]) -> str:
    """A document: values at its top, and a heading for each table.

    Parameters
    ----------
    tables : mapping of str to plain data
        Numbers, texts, truth values, lists, and mappings, which become tables; those within
        them stand on one line.
    """
    top = [_line(key, value) for key, value in tables.items() if not isinstance(value, Mapping)]
    parts = ["\n".join(top)] if top else []
    for name, table in tables.items():
        if isinstance(table, Mapping):
            lines = [f"[{_key(name)}]", *(_line(key, value) for key, value in table.items())]
            parts.append("\n".join(lines))
    return "\n\n".join(parts) + "\n"


def _line(key: str, value: Any) -> str:
    return f"{_key(key)} = {_value(value)}"


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _text(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, Mapping):
        return (
            f"{{ {', '.join(_line(key, one) for key, one in value.items())} }}" if value else "{}"
        )
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)


def _text(text: str) -> str:
    """A text in quotes; TOML has the escapes of JSON, and wants one more character escaped."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
