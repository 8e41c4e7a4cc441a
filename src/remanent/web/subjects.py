"""What a request looks at: a system, a drive and a start, read as a study file is."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.page.plausible import faults_of_size
from remanent.page.spec import read_spec
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.sweep.faults import Fault, FaultsError, shown
from remanent.studies.sweep.toml_text import faults_of_values, read_document

#: Most numbers in a request: a sampled load has thousands, not more.
_MOST_NUMBERS: Final = 20_000


@dataclass(frozen=True)
class Subject:
    """What a request looks at.

    Attributes
    ----------
    system : System
    drive : Drive
    initial : dict of str to float
        Values of some state variables at the start; the others are at rest.
    """

    system: System
    drive: Drive
    initial: dict[str, float]


def read_subject(spec: object) -> Subject:
    """What the tables of a request say.

    Raises
    ------
    FaultsError
        With every fault and its place.
    """
    if isinstance(spec, dict):
        _require_plain(spec)
        faults = faults_of_values(spec)
        if faults:
            raise FaultsError(faults)
    system, drive, initial = read_spec(spec)
    faults = faults_of_size(system, drive, initial)
    if faults:
        raise FaultsError(faults)
    return Subject(system, drive, initial)


def spec_from_toml(text: str) -> dict[str, Any]:
    """The tables of a request that the text of a study file has; its other keys are for studies.

    Raises
    ------
    StudyFileError
        The text is no TOML, or too long.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.toml"
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        document = read_document(path)
    return {name: document[name] for name in ("actuator", "system", "drive") if name in document}


def initial_state(subject: Subject) -> FloatArray | None:
    """The state at the start, array (state,); None for rest.

    Raises
    ------
    FaultsError
        A name is none of a state variable.
    """
    if not subject.initial:
        return None
    ens = lay_out_ensemble(subject.system, subject.drive)
    names = ens.vector_field.state_names
    unknown = [name for name in subject.initial if name not in names]
    if unknown:
        raise FaultsError(
            Fault(("initial", name), f"be one of {', '.join(names)}", shown(name),
                  "It is the value of a state variable at the start.", "Check the name.")
            for name in unknown
        )  # fmt: skip
    state = np.array(ens.initial_states[0])
    for name, value in subject.initial.items():
        state[names.index(name)] = value
    return state


def _require_plain(spec: dict[str, Any]) -> None:
    """Refuse tables with so many values that reading them takes long, and halves of letters."""
    waiting: list[Any] = [spec]
    seen = 0
    while waiting:
        value = waiting.pop()
        seen += 1
        if seen > _MOST_NUMBERS:
            raise FaultsError([
                Fault((), f"hold at most {_MOST_NUMBERS} values", "more",
                      "The page follows a slider at once.", "Give fewer samples of the load.")
            ])  # fmt: skip
        if isinstance(value, str) and not _is_text(value):
            raise FaultsError([
                Fault((), "hold text in Unicode", ascii(value[:40]),
                      "Half of a pair of surrogates is no letter.", "Remove it.")
            ])  # fmt: skip
        if isinstance(value, dict):
            waiting += [*value, *value.values()]
        elif isinstance(value, list):
            waiting += value


def _is_text(value: str) -> bool:
    try:
        value.encode()
    except UnicodeEncodeError:
        return False
    return True
