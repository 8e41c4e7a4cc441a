"""Values of any type, for every argument of every public name.

Law: Any values.
"""

from __future__ import annotations

from itertools import islice

import pytest

import remanent as rm
from tests.contracts.sound_calls import SOUND
from tests.faults.any_values import Attempt, attempts
from tests.faults.own_systems import DUFFING, own_sound_calls
from tests.faults.subjects import Subject, subjects

#: Names that are called by nobody with values: exceptions, a warning, codes, a version.
NOT_CALLED = {"RemanentError", "InputError", "InputWarning", "Status", "plot", "__version__"}
#: Calls of the fast test, and of one seed of the slow one.
FEW, MANY = 100, 2100


def wrong(calls: list[Attempt]) -> list[str]:
    return [f"{call}: {why}" for call in calls if (why := call.outcome())]


def test_every_public_name_takes_part() -> None:
    """A new verb, class or picture is called like the others."""
    called = {subject.name.removeprefix("rm.").partition(".")[0] for subject in subjects()}
    assert {*rm.__all__} - NOT_CALLED <= called
    pictures = {subject.name for subject in subjects() if subject.name.startswith("rm.plot.")}
    assert pictures == {f"rm.plot.{name}" for name in rm.plot.__all__}


@pytest.mark.parametrize("verb", SOUND)
def test_every_verb_is_tried_with_a_system_of_ones_own(verb: str) -> None:
    """Or refuses it, by the name of the argument."""
    sound = SOUND[verb]()
    name = next((name for name in ("system", "actuator") if name in sound), None)
    if name is None or verb in own_sound_calls():
        return
    with pytest.raises(rm.InputError) as refused:
        getattr(rm, verb)(**{**sound, name: DUFFING})
    assert refused.value.name == name


@pytest.mark.slow
@pytest.mark.parametrize(
    "subject",
    [s for s in subjects() if s.name.removeprefix("rm.") not in SOUND],
    ids=lambda subject: subject.name,
)
def test_sound_calls_are_sound(subject: Subject) -> None:
    """Else what is refused of them would not be the spoilt value; verbs are tried elsewhere."""
    assert Attempt(subject, {}).outcome() == ""
    assert subject.call(**subject.sound()) is not None


@pytest.mark.slow
def test_a_few_hundred_calls() -> None:
    """An InputError, a documented status or an answer, soon, and no warning but ours."""
    assert not wrong(list(islice(attempts(subjects(), seed=0), FEW)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 11))
def test_many_thousand_calls(seed: int) -> None:
    """The same, twenty-one thousand times."""
    assert not wrong(list(islice(attempts(subjects(), seed=seed), MANY)))
