"""Every verb, every argument, bad values of every kind: what the message says is true.

A message has five parts: the argument, the rule, the value received, the reason and the remedy.
The argument named is one of the verb's own, and so is every argument that the remedy names.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.studies.sweep.study import SEARCHING_VERBS
from tests.contracts.sound_calls import (
    ACTUATOR_ONLY,
    BODY,
    DRIVE,
    OF_DATA_ONLY,
    OWN_CHANGES,
    SOUND,
    own_call,
    verbs,
)
from tests.repetitions import fast_and_slow

NAN, INF = float("nan"), float("inf")
#: Lengths of a run, of which exactly one is given: a bad one may be told by another.
LENGTHS = {"duration", "periods", "times"}
#: Arguments that do not go together; which of them is wrong is a matter of taste.
PARTNERS = (LENGTHS, {"measure", "of"})


#: No real number.
NO_NUMBER: tuple[Any, ...] = ("1", NAN, INF, [], [1.0, 2.0], 1j, {}, object())
#: No integer that is positive.
NO_COUNT: tuple[Any, ...] = ("1", NAN, INF, 0, -1, 1.5, [], True, 1j)
#: No interval.
NO_RANGE: tuple[Any, ...] = (
    1.0, "text", "12", [], [1.0], [2.0, 1.0], [1.0, 1.0], [1.0, NAN], [1.0, INF],
    [1.0, 1.2, 1.3], [1j, 2j], [None, 1.0], {}, {"omega": 1.0}, object(),
)  # fmt: skip
#: No state.
NO_STATE: tuple[Any, ...] = (
    1.0, "rest", "10", [], [1.0], [1.0, NAN], [1.0, INF], [1.0] * 9, [1j, 0.0],
    [None, None], ["1", "0"], [-1.0, 0.0], {}, [[1.0, 0.0], [1.0, 0.0]], object(),
)  # fmt: skip
#: No values of a temperature.
NO_VALUES: tuple[Any, ...] = (
    "hot", [], None, [None], ["300"], [300j], [2.0, 1.0], [[300.0]], [1.0, 1.0], [object()],
    np.array(["2020"], "datetime64[D]"),
)  # fmt: skip
#: Nothing that varies a temperature.
NO_OVER: tuple[Any, ...] = (
    1.0, "temperature", ["temperature"], {"nothing": [1.0]}, {1: [1.0]},
    *({"temperature": values} for values in NO_VALUES),
)  # fmt: skip
#: No interval of a stretch.
NO_STRETCHES: tuple[Any, ...] = (
    1.0, None, "text", [], (2.0, 1.0), (1.0, NAN), (-1.0, 1.0), (0.5, 1.0, 2.0), (1j, 2j),
    ("1", "2"),
)  # fmt: skip
#: No box of states.
NO_BOX: tuple[Any, ...] = (
    1.0, "box", [1.0], {"nothing": (0.5, 2.0)}, {1: (0.5, 2.0)},
    *({"stretch": values} for values in NO_STRETCHES),
)  # fmt: skip
#: No text that names something.
NO_NAME: tuple[Any, ...] = (1, NAN, "", "nothing", ["omega", "b"], {}, object())
#: No system and no drive.
NO_PART: tuple[Any, ...] = (1.0, "part", {}, [], object())

#: Bad values of every argument, by its name; None is one of them where it is not the default.
BAD: Mapping[str, tuple[Any, ...]] = {
    "actuator": (*NO_PART, DRIVE),
    "band": (*NO_NUMBER, 0.0, -0.1),
    "branch": (1.0, "branch", {}, xr.Dataset(), object()),
    "confidence": (*NO_NUMBER, 0.0, 1.0, -0.1),
    "count": (*NO_COUNT, 99),
    "data": (1.0, "no such file.csv", {}, {"time": [0.0, 1.0]}, {"time": ["a"]}, object()),
    "dataset": (1.0, "dataset", {}, object()),
    "direction": NO_NAME,
    "discard": (*NO_NUMBER, -1),
    "drive": (*NO_PART, BODY),
    "duration": (*NO_NUMBER, 0.0, -1.0),
    "every": NO_COUNT,
    "fit": (1.0, "fit", {}, xr.Dataset(), object()),
    "grid": (1.0, "stretch", [], {}, {"nothing": [1.0]}, {"stretch": "text"}, {"stretch": []},
             {"stretch": [2.0, 1.0]}, {"stretch": [1j]}, {"stretch": None}),
    "history": (1.0, "history", {}, xr.Dataset(), object()),
    "initial": NO_STATE,
    "k": ("1", NAN, -1, 1.5, [], True, 99),
    "keep": NO_COUNT,
    "kind": NO_NAME,
    "lengths": (1.0, "yes", [], object()),
    "m": NO_NUMBER,
    "max_points": NO_COUNT,
    "measure": (1.0, "simulate", {}, object()),
    "measures": (1.0, "simulate", [], [1.0], object()),
    "names": (1.0, "time", [1.0], {"nothing": "time"}),
    "of": (1.0, "nothing", [1.0]),
    "omega": (1.0, "text", [], [1.0, 0.5], [1.0, 1.0], [1.0, NAN], ["1"], [1j], [None], {},
              [[1.0]], object()),
    "omega_range": NO_RANGE,
    "orbit_period": NO_COUNT,
    "orbit_periods": (1, "1", (), (0,), (1.5,), ("1",), (None,), {}),
    "over": NO_OVER,
    "parameter": NO_NAME,
    "parameter_range": NO_RANGE,
    "parameter_ranges": (1.0, "temperature", {"nothing": (1.0, 2.0)}, {"temperature": (2.0, 1.0)},
                         {"temperature": "text"}, {"temperature": (1.0, NAN)}, {1: (1.0, 2.0)},
                         {"temperature": None}),
    "parameters": (1, NAN, "nothing", "", [], ["nothing"], [1], {"nothing": 1.0}, object()),
    "periods": NO_COUNT,
    "profile": (1.0, "yes", [], object()),
    "progress": (1.0, 0, "yes", [], object()),
    "quantiles": (1.0, "text", [], [0.0], [2.0], [NAN], [0.5, 0.1], [1j], ["0.5"]),
    "resonance_width": (*NO_NUMBER, 0.0, -1.0),
    "rng": (-1, 1.5, "seed", [], True, NAN, object()),
    "robust_to": (1, "nothing", ["nothing"], [1], object()),
    "saddle": NO_STATE,
    "samples": (*NO_COUNT, 100),
    "section_phase": (*NO_NUMBER, -0.1, 1.0),
    "slices": NO_COUNT,
    "smallest": (*NO_NUMBER, -1.0, 1.0),
    "sobol": (1.0, "yes", [], object()),
    "special_point": ("1", NAN, -1, 1.5, [], True, 99),
    "state_box": NO_BOX,
    "step": (*NO_NUMBER, 0.0, -1.0),
    "stretch": ("text", [], [1j], ["1"], [None], {}, object()),
    "system": (*NO_PART, DRIVE),
    "target": (*NO_NUMBER, 0.0, -1.0),
    "targets": ("text", [], [1.0, 2.0], NAN, [NAN], [1j], ["1"], {}, object()),
    "temperature": (*NO_NUMBER, 0.0, -1.0),
    "times": (1.0, "text", [], [0.0, NAN], [1.0, 0.5], [-1.0, 1.0], [1j], ["0", "1"], [None],
              [[0.0, 1.0]], {}, object()),
    "tolerance": (*NO_NUMBER, 0.0, -1.0, 1.0),
    "units": (1.0, "s", [1.0], {"nothing": "s"}, {"time": 1.0}, {"time": "foo"}),
    "value": NO_NUMBER,
    "values": ("text", [], [1j], ["1"], [None], {}, object()),
    "variable": NO_NAME,
    "where": (1.0, "", "nothing - 1", "b", "stretch = 1", [], object()),
    "width": (*NO_NUMBER, 0.0, -1.0),
}  # fmt: skip
#: Bad values where the same name has another meaning.
BAD_IN: Mapping[tuple[str, str], tuple[Any, ...]] = {
    ("bifurcation_diagram", "discard"): ("1", NAN, -1, 1.5, [], True),
    ("poincare_section", "direction"): ("1", NAN, 2, 0.5, [], True),
    ("cycle_losses", "discard"): ("1", NAN, -1, 1.5, [], True),
    ("continue_bifurcation", "parameters"): (1, "omega", [], ["omega"], ["omega", "omega"],
                                             ["omega", "nothing"], ["omega", 1], object()),
    ("continue_bifurcation", "parameter_ranges"): (
        1.0, "text", [], [(1.2, 1.3)], [(1.2, 1.3), 1.0], [(1.2, 1.3), (0.5, 0.4)],
        [(1.2, 1.3), (0.3, NAN)], [(1.2, 1.3), "12"], object()),
    ("fit", "parameter_ranges"): (1.0, "eta", {"nothing": (1.0, 2.0)}, {1: (1.0, 2.0)},
        *({"dissipation.0.eta": bad} for bad in ((2.0, 1.0), "text", None, (0.1, NAN), 1.0))),
    ("regime_chart", "over"): (*NO_OVER, {}),
    ("snap_through", "initial"): (*NO_NUMBER, 0.0, -1.0),
}  # fmt: skip
#: Bad values for an actuator that are sound beside a system of the user's own: a box of coordinates
#: may hold negative ones.
SOUND_OF_OWN_SYSTEMS = {
    (verb, "state_box", "{'stretch': (-1.0, 1.0)}") for verb in ("equilibria", "snap_through")
}
#: Arguments that are handed on to another function as they are.
HANDED_ON = {("sensitivity", "arguments"), ("sensitivity", "options"),
             ("uncertainty", "arguments"), ("uncertainty", "options")}  # fmt: skip


def arguments() -> list[Any]:
    return [
        pytest.param(verb, argument, id=f"{verb}-{argument}")
        for verb, function in sorted(verbs().items())
        for argument in inspect.signature(function).parameters
        if (verb, argument) not in HANDED_ON
    ]


def test_every_verb_has_a_sound_call() -> None:
    """A new verb takes part in this contract, and takes systems of the user's own or refuses."""
    assert set(SOUND) == set(verbs())
    assert set(OWN_CHANGES) == set(SOUND) - ACTUATOR_ONLY - OF_DATA_ONLY


@pytest.mark.parametrize(
    "verb", fast_and_slow(sorted(OWN_CHANGES), {*OWN_CHANGES} - {*SEARCHING_VERBS})
)
def test_sound_calls_with_systems_of_ones_own_are_sound(verb: str) -> None:
    """Each is read back from its result, with the status of something that was done."""
    result = getattr(rm, verb)(**own_call(verb))
    given = own_call(verb)
    system = given.get("system", given.get("actuator"))
    if system is not None and verb != "fit":
        assert rm.read_system(result) == system
    if "status" in result:
        assert not (result.status == rm.Status.NOT_COMPUTED).any()


@pytest.mark.parametrize("verb", sorted(SOUND))
def test_sound_calls_are_sound(verb: str) -> None:
    """Else what is refused of them would not be the bad value."""
    assert getattr(rm, verb)(**SOUND[verb]()) is not None


@pytest.mark.parametrize(("verb", "argument"), arguments())
def test_bad_values_are_refused_in_words_that_are_true(verb: str, argument: str) -> None:
    """An InputError of five parts, whose argument and remedy are in the signature."""
    bad = bad_values(verb, argument)
    wrong = [f"{v!r}: {why}" for v in bad if (why := fault(verb, argument, v, SOUND[verb]()))]
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("verb", "argument"), [one for one in arguments() if one.values[0] in OWN_CHANGES]
)
def test_bad_values_are_refused_beside_systems_of_ones_own(verb: str, argument: str) -> None:
    """The same messages where the system is the user's, some of whose rules are weaker."""
    bad = [
        value
        for value in bad_values(verb, argument)
        if (verb, argument, repr(value)) not in SOUND_OF_OWN_SYSTEMS
    ]
    wrong = [f"{v!r}: {why}" for v in bad if (why := fault(verb, argument, v, own_call(verb)))]
    assert not wrong, "\n".join(wrong)


def bad_values(verb: str, argument: str) -> tuple[Any, ...]:
    """Values of an argument that are refused."""
    default = inspect.signature(getattr(rm, verb)).parameters[argument].default
    bad = BAD_IN.get((verb, argument), BAD[argument])
    return bad if default is None else (None, *bad)


def fault(verb: str, argument: str, value: Any, sound: dict[str, Any]) -> str:
    """What is wrong with what becomes of a bad value; nothing where it is refused well."""
    function = getattr(rm, verb)
    allowed = {*inspect.signature(function).parameters, *fields(sound)}
    call = {**alone(sound, argument), argument: value}
    try:
        function(**call)
    except rm.InputError as error:
        return untrue(error, argument, allowed)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "accepted"


def alone(sound: dict[str, Any], argument: str) -> dict[str, Any]:
    """Without the lengths of the run that exclude each other."""
    drop = LENGTHS if argument in LENGTHS else set()
    return {name: value for name, value in sound.items() if name not in drop}


def fields(sound: Mapping[str, Any]) -> set[str]:
    """Numeric fields of the system and the drive of a call."""
    parts = [sound[name] for name in ("system", "actuator", "drive") if name in sound]
    return {name for part in parts for name in part.parameter_values()}


def untrue(error: rm.InputError, argument: str, allowed: set[str]) -> str:
    """What in a message is not so."""
    message = str(error)
    if not re.fullmatch(r"(?s)`.+` must .+; got .+\. .+\.", message):
        return f"not of five parts: {message}"
    if re.split(r"[\[.]", error.name)[0] not in allowed and error.name not in allowed:
        return f"names no argument: {message}"
    named = re.split(r"[\[.]", error.name)[0]
    if named != argument and not any({named, argument} <= pair for pair in PARTNERS):
        return f"names another argument: {message}"
    unknown = [name for name in re.findall(r"`(\w+)`", error.fix) if name not in allowed]
    return f"proposes what is not there, {unknown}: {message}" if unknown else ""
