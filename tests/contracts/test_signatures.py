"""Names, arguments and defaults that users call: what a version number promises to keep."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import remanent as rm
from tests.contracts.test_reference import METHODS, PUBLIC

#: A line for each public function or class; ``python -m tests.contracts.test_signatures`` writes
#: them.  A change here is one that `CHANGELOG.md` tells.
SIGNATURES = Path(__file__).with_name("signatures.txt")


def signature(value: Callable[..., Any]) -> str:
    """Arguments and defaults, without types."""
    found = inspect.signature(value)
    arguments = [p.replace(annotation=p.empty) for p in found.parameters.values()]
    return str(found.replace(parameters=arguments, return_annotation=found.empty))


def signatures() -> str:
    """What `signatures.txt` must hold."""
    methods = {f"Actuator.{name}": method for name, method in METHODS.items()}
    functions = {
        name: value
        for name, value in {**PUBLIC, **methods}.items()
        if callable(value) and not (isinstance(value, type) and issubclass(value, BaseException))
    }
    del functions["Status"]  # whose members are its values, which datasets document
    return "".join(f"{name}{signature(functions[name])}\n" for name in sorted(functions))


def test_arguments_and_defaults_are_those_promised() -> None:
    """A default that changes, changes the results of a script that says nothing of it."""
    kept = SIGNATURES.read_text("utf-8").splitlines()
    assert signatures().splitlines() == kept
    assert len(kept) > len(rm.__all__)


if __name__ == "__main__":
    SIGNATURES.write_text(signatures(), encoding="utf-8")
