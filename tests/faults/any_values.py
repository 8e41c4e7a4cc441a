"""Values of every type, calls of every public name with them, and what may come of a call.

Calls are made from signatures and from sound arguments, so that a new name takes part by itself.
"""

from __future__ import annotations

import datetime
import inspect
import random
import re
import signal
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from decimal import Decimal
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from tempfile import mkdtemp
from types import FrameType
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pint
import xarray as xr
from tests.contracts.public import examples
from tests.contracts.sound_calls import SOUND
from tests.unit.plots import synthetic

import remanent as rm
from remanent.models.drives.base import Drive
from remanent.models.parts import Part

NAN, INF = float("nan"), float("inf")
#: Nothing may take longer, in seconds; a sound call of the slowest verb takes a tenth of it.
CAP_SECONDS = 30
#: Arguments that are results.
TAKES_RESULTS = frozenset({"dataset", "branch", "history", "data"})
#: Share of calls that are given a name which no argument has.
UNKNOWN_NAME_SHARE = 0.02


def values() -> dict[str, Callable[[], Any]]:
    """A maker of each value, by a word for it: makers, as some values are used up."""
    numbers = [None, True, False, 0, 1, -1, 2, 5, 2**70, 10**400, 0.5, -0.5, 1.25, 300.0, 5e-324,
               1e308, NAN, INF, -INF, 1j, Decimal("0.5"), Fraction(1, 3), np.float32(0.5),
               np.int8(1), np.bool_(True), np.datetime64("2020-01-01"), np.timedelta64(5, "ms"),
               rm.Status.OK]  # fmt: skip
    texts = ["", " ", "1", "text", "stretch", "omega", "b", "temperature", "100 kPa", "50 Hz",
             "5 ms", "1 T**9**9**9", "[" * 5000, "exp(I1/3)", "no such file.csv", "no.nc", "\0",
             b"bytes", Path("nowhere.mat"), Path()]  # fmt: skip
    sequences: list[Any] = [
        [], [1], [1.0, 2.0], [2.0, 1.0], [1.0, 1.0], (1.0, 0.0), (0.9, 1.1), (1, 2, 3), [NAN, 1.0],
        [[1.0, 2.0], [3.0, 4.0]], [1.0, [2.0]], ["a", "b"], ["1", "2"], [None], [1j], [True],
        [(1.2, 1.3), (0.35, 0.45)], [0.0, 1.0, 2.0, 3.0], {1, 2}, frozenset(), range(3),
        [datetime.timedelta(1)], [object()],
    ]  # fmt: skip
    mappings: list[Any] = [
        {}, {"a": 1.0}, {1: 2}, {"temperature": [290.0, 300.0]}, {"temperature": (290.0, 300.0)},
        {"b": 0.3}, {"stretch": (0.9, 1.1)}, {"stretch": [1.0, 1.1], "stretch_rate": [0.0]},
        {"time": [0.0, 1.0], "thickness_stretch": [1.0, 1.1]}, {"temperature": None},
        {"omega": 1j}, {"c": "text"}, {"kind": "Gent"}, {"time": "s"},
    ]  # fmt: skip
    arrays: list[Any] = [
        np.empty(0), np.array(1.25), np.array([0.5, 1.0]), np.ones((2, 2)), np.array([1j, 2.0]),
        np.array([True, False]), np.array([1.0, None], dtype=object), np.array(["x", "y"]),
        np.array([0, 1], dtype="timedelta64[ms]"), np.array(["2020", "2021"], "datetime64[D]"),
        np.ma.masked_array([1.0, 2.0, 9.0], [False, False, True]), np.array([1e400, 1.0]),
        np.zeros(2, dtype=[("x", float)]), np.array([1.0, 2.0], dtype=np.float16), np.array([b"a"]),
    ]  # fmt: skip
    labelled: list[Any] = [
        xr.DataArray(1.25), xr.DataArray([290.0, 300.0], dims="case"),
        xr.DataArray([0.3, 0.4], dims="time"), xr.DataArray([1.0, 2.0], dims="status"),
        xr.DataArray([0.3, 0.4], dims="case", coords={"case": ["x", "y"]}),
        xr.DataArray(["x", "y"], dims="case"), xr.Dataset(), xr.Dataset({"x": ("t", [1.0, 2.0])}),
        pd.Series([1.0, 2.0]), pd.DataFrame({"time": [0.0, 1.0], "stretch": [1.0, 1.1]}),
        pd.Series(pd.to_timedelta([0, 1], "ms")), pd.Timestamp("2020-01-01"), pd.NaT,
        pint.Quantity(5.0, "ms"), pint.Quantity(np.array([1.0, 2.0]), "Hz"),
    ]  # fmt: skip
    things: list[Any] = [
        object(), int, rm.Gent, rm.Actuator, rm.SineSquared, abs, str.upper, steady, rm, Ellipsis,
        NotImplemented, slice(1, 2), ValueError("x"), np.random.default_rng(1), rm.simulate,
    ]  # fmt: skip
    models: list[Any] = [
        *examples(Part).values(), rm.Actuator(), rm.Actuator(prestress=(0.0, 0.1)), film(),
        rm.Actuator(heat=rm.Heat(), dissipation=rm.Zener(0.5, 0.7)), rm.Constant(0.1),
        rm.SineSquared(0.4, 1.25), rm.Sines([0.1, 0.1], [1.0, 2**0.5], 1.0),
    ]  # fmt: skip
    fixed = [*numbers, *texts, *sequences, *mappings, *arrays, *labelled, *things, *models]
    makers: dict[str, Callable[[], Any]] = {
        f"{k}: {word(v)}": partial(same, v) for k, v in enumerate(fixed)
    }
    results: dict[str, Callable[[], Any]] = {
        f"result of {verb}": partial(result_of, verb) for verb in SOUND
    }
    used: dict[str, Callable[[], Any]] = {
        "iterator": lambda: iter([1.0, 2.0]), "axes": lambda: plt.figure().subplots(),
    }  # fmt: skip
    return {**makers, **results, **used}


def same(value: Any) -> Any:
    """The value itself."""
    return value


def steady(*_: Any, **__: Any) -> float:
    """A function of anything."""
    return 1.0


def word(value: Any) -> str:
    """A value in a few letters, without its address."""
    return re.sub(r"(0x|at )[0-9a-fA-Fx]+", "", " ".join(repr(value)[:60].split()))


@cache
def film() -> rm.Actuator:
    """An actuator with sizes."""
    return rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length="5 mm",
        half_thickness="0.5 mm", remanence="143 mT",
    )  # fmt: skip


@dataclass(frozen=True)
class Subject:
    """Something public that is called, with sound arguments to spoil."""

    name: str
    call: Callable[..., Any]
    sound: Callable[[], Mapping[str, Any]]

    def argument_names(self) -> list[str]:
        """Names of the arguments that may be passed by name."""
        kinds = inspect.Parameter
        return [
            p.name
            for p in inspect.signature(self.call).parameters.values()
            if p.kind not in {kinds.VAR_POSITIONAL, kinds.VAR_KEYWORD, kinds.POSITIONAL_ONLY}
        ]


@dataclass(frozen=True)
class Attempt:
    """One call."""

    subject: Subject
    spoilt: Mapping[str, str]

    def __str__(self) -> str:
        return f"{self.subject.name}({', '.join(f'{k}={v}' for k, v in self.spoilt.items())})"

    def outcome(self) -> str:
        """What is wrong with what became of it; nothing where all is well."""
        pool = values()
        arguments = dict(self.subject.sound())
        arguments |= {k: pool[v]() for k, v in self.spoilt.items()}
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", rm.InputWarning)
            try:
                with alarm(CAP_SECONDS):
                    result = self.subject.call(**arguments)
                    if isinstance(result, xr.Dataset):
                        return untold(result)
            except rm.InputError as error:
                return "" if len(str(error)) < 2500 else f"a message of {len(str(error))} letters"
            except Exception as error:
                return f"{type(error).__name__}: {error}"
            finally:
                plt.close("all")
        return ""


def attempts(subjects: list[Subject], seed: int) -> Iterator[Attempt]:
    """Calls without end, the same for the same seed."""
    draw = random.Random(seed)
    words = list(values())
    while True:
        subject = draw.choice(subjects)
        names = subject.argument_names()
        if subject.name.startswith("rm.") and draw.random() < UNKNOWN_NAME_SHARE:
            names = ["tolerence"]
        count = min(len(names), draw.choice([1, 1, 1, 2, 3]))
        spoilt = {name: draw_word(draw, name, words) for name in draw.sample(names, count)}
        yield Attempt(subject, spoilt)


def draw_word(draw: random.Random, name: str, words: list[str]) -> str:
    """A value for an argument: often one that is nearly right, where results are asked for."""
    near = [word for word in words if word.startswith("result of")]
    return draw.choice(near if name in TAKES_RESULTS and draw.random() < 0.7 else words)


class TooLong(BaseException):
    """A call took longer than the cap."""


class alarm:  # noqa: N801, used as a statement
    """Raise in the main thread after some seconds."""

    def __init__(self, seconds: int) -> None:
        self.seconds = seconds

    def __enter__(self) -> None:
        def ring(_: int, __: FrameType | None) -> None:
            raise TooLong

        self.previous = signal.signal(signal.SIGALRM, ring)
        signal.alarm(self.seconds)

    def __exit__(self, kind: type[BaseException] | None, error: Any, trace: Any) -> None:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, self.previous)
        if kind is TooLong:
            raise TimeoutError(f"more than {self.seconds} s") from None


def untold(ds: xr.Dataset) -> str:
    """A status that is none, or infinity or NaN beside status ok."""
    if "status" not in ds:
        return ""
    codes = np.unique(ds.status.values)
    if not {*codes.tolist()} <= {int(code) for code in rm.Status}:
        return f"status {codes}"
    return ""


def subjects() -> list[Subject]:
    """Everything public that is called: verbs, classes, methods of values, plots, files."""
    values_and_names = {name: getattr(rm, name) for name in rm.__all__}
    verbs_ = [Subject(f"rm.{name}", getattr(rm, name), sound) for name, sound in SOUND.items()]
    classes = [
        Subject(f"rm.{name}", cls, partial(example_fields, cls))
        for name, cls in values_and_names.items()
        if isinstance(cls, type) and hasattr(cls, "example")
    ]
    plots = [
        Subject(f"rm.plot.{name}", getattr(rm.plot, name), DRAWN[name]) for name in rm.plot.__all__
    ]
    return [*verbs_, *classes, *others(), *plots]


def fields_of(value: Any) -> dict[str, Any]:
    """The arguments that make a value."""
    return {field.name: getattr(value, field.name) for field in fields(value) if field.init}


#: Methods of an actuator that take a quantity: name, argument, a sound one.
SI_METHODS = (
    ("stress", "stress", "50 kPa"), ("viscosity", "viscosity", "20 Pa s"),
    ("load", "flux_density", "140 mT"), ("coupling", "heat_capacity", "1.9 kJ/(kg K)"),
    ("frequency", "frequency", "50 Hz"), ("time", "time", "1 s"),
)  # fmt: skip


def example_fields(cls: Any) -> dict[str, Any]:
    """The arguments that make the example of a class."""
    return fields_of(cls.example())


def others() -> list[Subject]:
    """What is neither a verb nor made by its example."""
    folder = Path(mkdtemp())
    sizes = {"shear_modulus": "100 kPa", "density": "2000 kg/m^3", "half_length": "5 mm",
             "half_thickness": "0.5 mm"}  # fmt: skip
    methods = [
        Subject(f"actuator.{name}", getattr(film(), name), partial(dict, {argument: text}))
        for name, argument, text in SI_METHODS
    ]
    replaced = [
        Subject(f"{type(value).__name__}.replace", replacing(value), lambda: {})
        for value in (film(), rm.SineSquared(0.4, 1.25), rm.Ogden.example(), rm.WLF(8.0, 200.0))
    ]
    loads = [
        Subject(f"{type(drive).__name__}(...)", drive.__call__, lambda: {"tau": 0.5})
        for drive in examples(Drive).values()  # type: ignore[type-abstract]
    ]
    return [
        Subject("rm.Actuator", rm.Actuator, lambda: {}),
        Subject("rm.Actuator.from_si", rm.Actuator.from_si, lambda: dict(sizes)),
        Subject("rm.Measure", rm.Measure, lambda: {"verb": rm.equilibria, "of": "natural_frequency",
                                                   "actuator": rm.Actuator(), "m": 0.16}),
        Subject("rm.equations", rm.equations, lambda: {"system": rm.Actuator()}),
        Subject("rm.rates", rm.rates, lambda: {"system": rm.Actuator(),
                                               "drive": rm.SineSquared(0.4, 1.25)}),
        Subject("rm.period_map", rm.period_map, lambda: {"system": rm.Actuator(),
                                                         "drive": rm.SineSquared(0.4, 1.25)}),
        Subject("rm.save", rm.save, lambda: {"dataset": motion(), "path": folder / "it.nc"}),
        Subject("rm.load", rm.load, lambda: {"path": saved(folder)}),
        *methods, *replaced, *loads,
    ]  # fmt: skip


def replacing(value: Any) -> Callable[..., Any]:
    """The `replace` of a value, with its fields as arguments."""
    names = [field.name for field in fields(value) if field.init]
    keyword = inspect.Parameter.KEYWORD_ONLY

    def replace(**changes: Any) -> Any:
        return value.replace(**changes)

    replace.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [inspect.Parameter(name, keyword, default=None) for name in names]
    )
    return replace


@cache
def saved(folder: Path) -> Path:
    """A file with a motion."""
    return rm.save(motion(), folder / "motion.nc")


@cache
def motion() -> xr.Dataset:
    """A short motion of two actuators."""
    over = {"temperature": [290.0, 300.0]}
    return rm.simulate(rm.Actuator(), rm.SineSquared(0.4, 1.25), duration=1.0, over=over)


@cache
def result_of(verb: str) -> xr.Dataset:
    """The result of a sound call."""
    result: xr.Dataset = getattr(rm, verb)(**SOUND[verb]())
    return result


@cache
def equilibria_over_loads() -> xr.Dataset:
    """Equilibria against the load, with the two folds of a bistable block."""
    return rm.equilibria(rm.Actuator(prestress=2.2), over={"m": np.linspace(1.0, 4.0, 13)})


#: Arguments of a sound picture of each kind.
DRAWN: Mapping[str, Callable[[], dict[str, Any]]] = {
    "bars": lambda: {"dataset": result_of("sensitivity")},
    "basins": lambda: {"dataset": synthetic.basins_of_two()},
    "branch": lambda: {"dataset": result_of("continue_orbit")},
    "curve": lambda: {"dataset": motion(), "variable": "stretch", "x": "time"},
    "equilibria": lambda: {"dataset": equilibria_over_loads()},
    "fit": lambda: {"dataset": result_of("fit")},
    "history": lambda: {"dataset": motion()},
    "landscape": lambda: {"dataset": synthetic.potential()},
    "map": lambda: {"dataset": result_of("regime_chart")},
    "multipliers": lambda: {"dataset": result_of("continue_orbit")},
    "phase": lambda: {"dataset": motion()},
    "response": lambda: {"dataset": result_of("frequency_response")},
    "section": lambda: {"dataset": result_of("poincare_section")},
}
