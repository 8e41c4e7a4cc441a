"""Values of the kind that an argument takes, most of which are answered."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from remanent.models.drives.base import Drive
from tests.faults.own_systems import (
    FORCE,
    OWN_FIELDS,
    OWN_NAMES,
    loads,
    own_boxes,
    own_overs,
    own_states,
    own_systems,
)
from tests.faults.result_pool import results
from tests.faults.value import Value
from tests.faults.value_pool import models, numbers, same, texts, word

#: Arguments whose sound value does not tell what they take: they are left out in sound calls.
KINDS: Mapping[str, str] = {
    "over": "over", "initial": "state", "state_box": "box", "parameter_ranges": "box",
    "tolerance": "number", "duration": "number", "periods": "count", "discard": "count",
    "times": "row", "orbit_period": "count", "max_points": "count", "m": "number", "rng": "count",
    "every": "count", "section_phase": "number", "direction": "name", "variables": "name",
    "x": "name", "y": "name", "parameter": "name", "variable": "name", "quantity": "name",
    "legend": "flag", "log": "flag", "residuals": "flag", "profile": "flag", "sobol": "flag",
    "progress": "flag", "own_field": "flag", "lengths": "flag", "start": "flag", "heat": "part",
    "dissipation": "part", "magnet": "part", "material": "part", "scales": "part",
    "physical_sizes": "part", "shift": "part", "half_width": "quantity", "force": "quantity",
    "remanence": "quantity", "temperature": "number", "edges": "row", "prestress": "number",
    "phases": "row", "system": "system", "actuator": "system", "drive": "drive",
    "robust_to": "name", "band": "number",
    "confidence": "number", "step": "number", "samples": "count", "quantiles": "row",
    "resonance_width": "number", "smallest": "number", "count": "count", "keep": "count",
    "slices": "count", "special_point": "count", "c": "number", "width": "number",
    "reference_temperature": "number", "saddle": "state", "values": "row", "of": "name",
}  # fmt: skip
#: What follows a kind whose values are those of systems of one's own.
OF_OWN = " of own systems"
#: Fields that may be varied.
FIELDS = ("temperature", "omega", "b", "m", "c", "initial.stretch", "prestress", "shear_modulus",
          "dissipation.0.eta", "magnet.temperature_coefficient")  # fmt: skip
#: Numbers of a usual size.
USUAL = (0.1, 0.3, 0.5, 0.9, 1.0, 1.1, 1.5, 2.0, 3.0, 10.0, 293.0, 350.0, 1e-3, 1e-5, 1e-7)
#: Rows of numbers.
ROWS: tuple[Any, ...] = (
    [1.0, 1.1], [0.3, 0.4], [290.0, 300.0], [0.0, 1.0], [1.2, 1.4], [0.5], [], [1.0, np.nan, 2.0],
    [-1.0, 0.0, 1.0], [0.0, 5e-324, 1e-300], [1e300, 1e308], [1.0, np.inf], [-1e308, 1e308],
    [1.0, 1.0 + 2e-16], np.linspace(0.5, 3.0, 5), np.geomspace(1e-6, 1e6, 4), [5.0], [0.0, 0.0],
)  # fmt: skip
#: States, of one coordinate and of two.
STATES = ([1.0, 0.0], [1.2, 0.1], [0.0, 0.0], [-1.0, 0.0], [1e300, 0.0], [1e-300, 1e300],
          [1.0, 0.0, 1.0, 0.0], [1.0], [1.0, np.nan], [1.05, -0.2])  # fmt: skip
#: Counts.
COUNTS = (0, 1, 2, 3, 5, 7, 16, 64, 100, 257, 2**40, -1)


def kind_of_argument(name: str, sound: object) -> str:
    """What an argument takes, by its sound value or its name."""
    kinds: dict[type, str] = {
        bool: "flag", int: "count", float: "number", str: "name", xr.Dataset: "result",
        rm.Actuator: "system", list: "row", tuple: "row", np.ndarray: "row",
    }  # fmt: skip
    if name in KINDS:
        return KINDS[name]
    return next((kind for cls, kind in kinds.items() if isinstance(sound, cls)), "")


@cache
def values_by_kind() -> dict[str, list[Value]]:
    """Values of each kind; those that systems of one's own take have another word."""
    rows = [valued(row) for row in ROWS]
    real = [x for x in numbers() if isinstance(x, int | float | np.floating)]
    boxes = product(("stretch", "stretch_rate", *FIELDS[:4]), ((0.9, 1.1), *map(tuple, ROWS)))
    model, written = models(), [valued(x) for x in own_systems()]
    drives = [valued(x) for x in (*filter(is_drive, model), *loads())]
    words = [valued(text) for text in texts() if isinstance(text, str)]
    measured = ("amplitude", "thickness_stretch", "stretch", "stretch_rate", "frequency", "omega",
                "regime", "error", "maximum", "energy", "time", *FIELDS)  # fmt: skip
    return {
        "number": [valued(x) for x in (*USUAL * 2, *real)],
        "count": [valued(x) for x in COUNTS],
        "flag": [valued(x) for x in (True, False, np.bool_(True))],
        "name": [*words, *(valued(x) for x in measured * 3), valued(["stretch", "omega"])],
        "row": rows,
        "state": [valued(x) for x in STATES] + rows,
        "box": [valued({k: v}) for k, v in boxes] + [valued({"stretch": (0.9, 1.1)})] * 20,
        "over": [valued({k: v}) for k, v in product(FIELDS, ROWS)] + pairs_of_fields(),
        "system": [valued(x) for x in model if isinstance(x, rm.Actuator)] + written,
        "drive": drives,
        "part": [valued(x) for x in model] + [valued(None)],
        "quantity": [valued(x) for x in ("5 mm", "0 mm", "1e-300 m", "1e300 N", "143 mT", "1 N")],
        "result": results(),
        f"state{OF_OWN}": [valued(x) for x in own_states()] * 2 + rows,
        f"box{OF_OWN}": [valued(x) for x in own_boxes(ROWS)],
        f"over{OF_OWN}": [valued(x) for x in own_overs(ROWS)],
        f"system{OF_OWN}": written,
        f"drive{OF_OWN}": drives + [valued(FORCE)] * len(drives),
        f"name{OF_OWN}": words + [valued(x) for x in (*OWN_NAMES, *OWN_FIELDS)] * 3,
    }


def is_drive(value: object) -> bool:
    """Whether it is a drive."""
    return isinstance(value, Drive)


def pairs_of_fields() -> list[Value]:
    """Two fields that go together, or span a plane."""
    together = [
        {
            "temperature": xr.DataArray([290.0, 300.0], dims="case"),
            name: xr.DataArray([0.3, 0.4], dims="case"),
        }
        for name in FIELDS
    ]
    plane = [{"temperature": [290.0, 300.0], name: [0.3, np.nan, 0.4]} for name in FIELDS]
    return [valued(x) for x in (*together, *plane)]


def valued(value: Any) -> Value:
    """A value that is not used up."""
    return Value(f"near {word(value)}", partial(same, value))
