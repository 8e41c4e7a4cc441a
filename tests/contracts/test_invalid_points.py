"""Every verb that takes `over`, where no point of it is valid; a new verb joins by itself.

Law: Bad input.
"""

from __future__ import annotations

import inspect

import numpy as np
import pytest

import remanent as rm
from tests.contracts.sound_calls import OWN_CHANGES, SOUND, own_call, verbs

#: Verbs that vary fields.
SWEEPING = sorted(
    name for name, verb in verbs().items() if "over" in inspect.signature(verb).parameters
)
#: Fields of the actuator that every verb knows, and values that each of them refuses.
SPOILT: dict[str, tuple[float, ...]] = {
    "c": (-1.0, 0.0, np.nan, -np.inf),
    "reference_temperature": (-5.0, 0.0, np.nan, np.inf),
    "temperature": (-5.0, 0.0, np.nan, np.inf),
    "prestress": (np.nan, np.inf, -np.inf),
}
#: What is known of an invalid point: how long a period of its load is.
KNOWN = frozenset({"drive_period"})


@pytest.mark.parametrize("verb", SWEEPING)
@pytest.mark.filterwarnings("ignore::remanent.InputWarning")
def test_a_result_without_a_valid_point_says_so(verb: str) -> None:
    """Invariant: a failure is a status and NaN, whichever field breaks its rule, and none is
    raised by what the verb would do with the points."""
    draw = np.random.default_rng(len(verb))
    drive = SOUND[verb]().get("drive")
    waves = ["phase"] if isinstance(drive, rm.SineSquared) else []
    for field in [*draw.permutation(list(SPOILT))[:2].tolist(), *waves]:
        over = {field: [float(draw.choice(SPOILT.get(field, (np.nan,))))]}
        if verb == "regime_chart":
            over["c" if field != "c" else "prestress"] = [1.0]
        ds = getattr(rm, verb)(**{**SOUND[verb](), "over": over})
        assert (ds.status == rm.Status.INVALID).all(), over
        numbers = [n for n, v in ds.data_vars.items() if v.dtype.kind in "fc" and n not in KNOWN]
        assert [n for n in numbers if np.isfinite(ds[n]).any()] == [], over


@pytest.mark.parametrize("verb", [verb for verb in SWEEPING if verb in OWN_CHANGES])
def test_a_result_of_ones_own_system_without_a_valid_point_says_so(verb: str) -> None:
    """The same of numbers that are none, which is all that such a system refuses."""
    over = {"temperature": [np.nan]}
    if verb == "regime_chart":
        over["c"] = [1.0]
    ds = getattr(rm, verb)(**{**own_call(verb), "over": over})
    assert (ds.status == rm.Status.INVALID).all()
    numbers = [n for n, v in ds.data_vars.items() if v.dtype.kind in "fc" and n not in KNOWN]
    assert [n for n in numbers if np.isfinite(ds[n]).any()] == []


def test_most_verbs_vary_fields() -> None:
    """The list is not empty for some other reason than that there is nothing to say."""
    assert len(SWEEPING) > 20
