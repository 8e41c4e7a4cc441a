"""Laws of labelling."""

from __future__ import annotations

import numpy as np
import pytest

from remanent._errors import InputError
from remanent.results import build


def test_everything_is_labelled() -> None:
    """Variables and coordinates alike get unit, meaning and symbol."""
    found = build.dataset(
        {
            "stretch": (("temperature", "time"), np.ones((2, 3))),
            "error": (("temperature",), np.zeros(2)),
        },
        {
            "temperature": (("temperature",), np.array([250.0, 350.0])),
            "time": (("time",), np.array([0.0, 1.0, 2.0])),
        },
        {"actuator": "Actuator()"},
    )
    assert dict(found.sizes) == {"temperature": 2, "time": 3}
    assert found.attrs == {"actuator": "Actuator()"}
    for variable in found.variables.values():
        assert {"units", "long_name", "symbol"} <= set(variable.attrs)


def test_status_is_a_cf_flag() -> None:
    """`status` is int8 whatever came in, with its meanings beside it."""
    found = build.dataset({"status": ((), np.array(3))}, {}, {})["status"]
    assert found.dtype == np.int8
    meanings = found.attrs["flag_meanings"].split()
    assert meanings[found.attrs["flag_values"].tolist().index(int(found))] == "escaped"


@pytest.mark.parametrize(
    ("variables", "match"),
    [
        ({"strech": (("time",), np.zeros(3))}, "schema"),
        ({"stretch": (("time",), np.zeros(4))}, "length 3 along `time`"),
        ({"stretch": (("time",), np.zeros((3, 1)))}, "1 dimensions"),
    ],
)
def test_wrong_input_is_refused(variables: dict[str, build.Labelled], match: str) -> None:
    """An unknown name or a wrong shape raises, naming it."""
    with pytest.raises(InputError, match=match):
        build.dataset(variables, {"time": (("time",), np.arange(3.0))}, {})
