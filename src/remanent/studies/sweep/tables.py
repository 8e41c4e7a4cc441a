"""Tables of a study file, checked key by key by pydantic in its strict mode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from remanent._errors import InputError
from remanent.studies.sweep.faults import (
    Fault,
    FaultsError,
    KeyPath,
    fault_of,
    shown,
    unknown_key_fault,
)

#: The rule behind each kind of error that pydantic has of a single value.
_RULES: Final[Mapping[str, str]] = {
    "string_type": "be text in quotes",
    "bool_type": "be true or false",
    "int_type": "be a whole number",
    "int_from_float": "be a whole number",
    "float_type": "be a number",
    "dict_type": "be a table",
    "list_type": "be a list",
}


class Table(BaseModel):
    """A table whose keys are known; its values are taken as they are, never converted."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, populate_by_name=False)

    @property
    def given(self) -> dict[str, Any]:
        """What stands in the file, by the names of the fields."""
        return {name: getattr(self, name) for name in self.model_fields_set}


AnyTable = TypeVar("AnyTable", bound=Table)


def read_table(model: type[AnyTable], content: object, title: str, context: Any = None) -> AnyTable:
    """A table, if each of its keys and values is sound.

    Parameters
    ----------
    model : type of Table
    content : object
        What stands in the file.
    title : str
        What messages call the table.
    context : object, optional
        Handed to the checks of the values.

    Raises
    ------
    FaultsError
        All faults, by their places in the table.
    """
    if not isinstance(content, dict):
        raise FaultsError([not_a_table_fault(content)])
    try:
        return model.model_validate(content, context=context)
    except ValidationError as error:
        details = error.errors(include_url=False)
        raise FaultsError(
            fault for one in details for fault in _faults_of(one, model, content, title)
        ) from None


def not_a_table_fault(content: object) -> Fault:
    """What is said where a table was expected."""
    return Fault(
        (), "be a table", shown(content), "It holds several keys.",
        "Write [name] on a line of its own with the keys below, or { key = value, ... }.",
    )  # fmt: skip


def _faults_of(
    details: ErrorDetails, model: type[Table], content: dict[str, Any], title: str
) -> list[Fault]:
    path: KeyPath = details["loc"]
    found = details.get("ctx", {}).get("error")
    if isinstance(found, FaultsError):
        return [fault.below(*path) for fault in found.faults]
    if isinstance(found, InputError):
        fault = fault_of(found, content)
        return [Fault(path, fault.must, shown(details["input"]), fault.why, fault.fix)]
    key = str(path[0]) if path else title
    if details["type"] == "missing":
        return [_missing_fault(key, model)]
    if details["type"] == "extra_forbidden":
        return [unknown_key_fault(key, keys_of(model), title, details["input"])]
    return [_value_fault(path, details, model)]


def keys_of(model: type[Table]) -> list[str]:
    """The keys that a table may have."""
    return [field.alias or name for name, field in model.model_fields.items()]


def _missing_fault(key: str, model: type[Table]) -> Fault:
    why, fix = _prose(key, model)
    return Fault((key,), "be given", "nothing", why or "It has no usual value.",
                 fix or f"Write {key} = ... there.")  # fmt: skip


def _value_fault(path: KeyPath, details: ErrorDetails, model: type[Table]) -> Fault:
    why, fix = _prose(str(path[0]), model)
    limits = details.get("ctx", {})
    must = _RULES.get(details["type"])
    if must is None and "ge" in limits:
        must = f"be at least {limits['ge']}"
    if must is None and "le" in limits:
        must = f"be at most {limits['le']}"
    if must is None and "expected" in limits:
        must = f"be one of {limits['expected']}"
    return Fault(path, must or details["msg"].lower(), shown(details["input"]),
                 why or "Nothing else is defined.", fix or "Write such a value.")  # fmt: skip


def _prose(key: str, model: type[Table]) -> tuple[str, str]:
    """Why a key is there and how it is written, by its description and its example."""
    for name, field in model.model_fields.items():
        if key in (name, field.alias):
            example = next(iter(field.examples or []), None)
            return field.description or "", f"Write for example {example}." if example else ""
    return "", ""
