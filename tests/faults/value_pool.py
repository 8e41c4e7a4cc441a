"""Values of every type, each by a word for it, and others made of them."""

from __future__ import annotations

import datetime
import re
import warnings
from array import array
from collections import UserDict, defaultdict, deque
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pint
import xarray as xr

import remanent as rm
from remanent.models.dissipation import Dissipation
from remanent.models.materials.base import Material
from remanent.models.parts import Part
from tests.contracts.public import examples
from tests.faults.result_pool import results
from tests.faults.value import Value

NAN, INF = float("nan"), float("inf")
#: A text that no message may repeat as a whole.
LONG_TEXT = "x" * 50_000
#: Keys under which a value is put into a mapping: fields, variables, columns.
KEYS = ("temperature", "omega", "b", "m", "c", "initial.stretch", "stretch", "stretch_rate",
        "shear_modulus", "prestress", "time", "thickness_stretch", "dissipation.0.eta",
        "material.jm", "loads.0", "loads.1", "phases.0", "nothing of the kind")  # fmt: skip


class OwnError(Exception):
    """What a function of the caller raises; it may come out as it is."""


def pool() -> list[Value]:
    """Every value."""
    fixed = [*numbers(), *texts(), *sequences(), *mappings(), *arrays(), *labelled(), *quantities(),
             *things(), *models()]  # fmt: skip
    makers = [Value(f"{k}: {word(value)}", partial(same, value)) for k, value in enumerate(fixed)]
    some = results()[::40]
    return [*makers, *used_up(), *some]


def numbers() -> list[Any]:
    """Numbers of every type and size, and what looks like one."""
    return [None, True, False, 0, 1, -1, 2, 5, 2**31, 2**63, 2**70, 10**400, -(10**400), 0.5, -0.5,
            -0.0, 1.25, 300.0, 5e-324, 1e-300, 1e-20, 1e20, 1e154, 1e300, 1e308, -1e308, NAN, INF,
            -INF, 1j, complex(1.0, 0.0), Decimal("0.5"), Decimal("NaN"), Decimal("1e400"),
            Fraction(1, 3), Fraction(10**400, 3), np.float32(0.5), np.float64(NAN),
            np.longdouble("1e400"), np.int8(1), np.uint64(2**64 - 1), np.bool_(True),
            np.complex128(1), np.str_("omega"), np.datetime64("2020-01-01"), np.datetime64("NaT"),
            np.timedelta64(5, "ms"), rm.Status.OK]  # fmt: skip


def texts() -> list[Any]:
    """Texts: words that mean something, none, markup, and bytes."""
    return ["", " ", "1", "text", "stretch", "omega", "b", "temperature", "initial.stretch", "up",
            "fold", "elasticity", "status", "reason", "100 kPa", "50 Hz", "5 ms", "-1 K", "nan K",
            "1e400 Pa", "20 degC", "5 furlong", "1 T**9**9**9", "[" * 5000, LONG_TEXT,
            "exp(I1/3)", "I1 - 3", "1/0*(I1-3)", "I1**I1**I1**I1", "__import__('os')", "$\\frac{1",
            "\\", "{}", "%s", "\ud800", "é → 🙂", "a\nb", "no such file.csv", "no.nc", "/", "\0",
            b"bytes", bytearray(b"x"), Path("nowhere.mat"), Path()]  # fmt: skip


def sequences() -> list[Any]:
    """Lists and other sequences."""
    endless: list[Any] = []
    endless.append(endless)
    return [
        [], [1], [1.0, 2.0], [2.0, 1.0], [1.0, 1.0], (1.0, 0.0), (0.9, 1.1), (1, 2, 3), [NAN, 1.0],
        [-INF, INF], (5e-324, 1e308), [10**400, 1], [[1.0, 2.0], [3.0, 4.0]], [1.0, [2.0]],
        ["a", "b"], ["1", "2"], ["omega", "b"], ["omega", "omega"], [None], [1j], [True],
        [(1.2, 1.3), (0.35, 0.45)], [0.0, 1.0, 2.0, 3.0], {1, 2}, frozenset(), range(3), endless,
        [[[[]]]], [datetime.timedelta(1)], [datetime.datetime(2020, 1, 1)], [object()], ["\ud800"],
        [Decimal(1), Fraction(1, 2)], deque([1.0, 2.0]), array("d", [1.0, 2.0]), memoryview(b"ab"),
        [rm.Rayleigh(0.1), rm.Zener(0.5, 0.7)], [rm.Actuator()], [5 * pint.Quantity("ms")],
        [1.0] * 1001, [LONG_TEXT],
    ]  # fmt: skip


def mappings() -> list[Any]:
    """Mappings."""
    return [
        {}, {"a": 1.0}, {1: 2}, {None: 1.0}, {("a", "b"): 1.0}, {"temperature": [290.0, 300.0]},
        {"temperature": (290.0, 300.0)}, {"b": 0.3}, {"stretch": (0.9, 1.1)},
        {"stretch": [1.0, 1.1], "stretch_rate": [0.0]}, {"stretch": 1.0, "stretch_rate": 0.0},
        {"time": [0.0, 1.0], "thickness_stretch": [1.0, 1.1]}, {"temperature": None},
        {"omega": 1j}, {"c": "text"}, {"kind": "Gent"}, {"time": "s"}, {LONG_TEXT: 1.0},
        {"\ud800": [1.0, 2.0]}, {"b": [0.3, 0.4], "omega": [1.0, 1.2], "temperature": [293.0]},
        {"b": [1e-300, 1e300], "temperature": [5e-324, 1e308]}, UserDict({"b": [0.3]}),
        defaultdict(list), {"color": "no colour"}, {"status": [1.0]}, {"case": [1.0, 2.0]},
    ]  # fmt: skip


def arrays() -> list[Any]:
    """Arrays of NumPy."""
    return [
        np.empty(0), np.empty((0, 3)), np.array(1.25), np.array([0.5, 1.0]), np.ones((2, 2)),
        np.array([1j, 2.0]), np.array([True, False]), np.array([1.0, None], dtype=object),
        np.array([1.0, 2.0], dtype=object), np.array(None), np.array(["x", "y"]),
        np.array([0, 1], dtype="timedelta64[ms]"), np.array(["2020", "2021"], "datetime64[D]"),
        np.ma.masked_array([1.0, 2.0, 9.0], [False, False, True]), np.ma.masked,
        np.ma.masked_array([1.0, 2.0], True), np.array([1e400, 1.0]), np.array([5e-324, 1e-300]),
        np.zeros(2, dtype=[("x", float)]), np.array([1.0, 2.0], dtype=np.float16), np.array([b"a"]),
        np.array([1, 2], dtype=np.uint64), np.array([1.0, 2.0], dtype=">f8"),
        np.array([[1.0, 2.0]]).view(np.matrix), np.linspace(0.0, 2.0, 7)[::-2],
        np.broadcast_to(1.0, (10**6, 10**6)), np.broadcast_to(1.0, 10**11),
        np.array([1.0, 2.0], dtype=np.longdouble), np.rec.array([(1.0,)], dtype=[("x", float)]),
    ]  # fmt: skip


def labelled() -> list[Any]:
    """Labelled arrays and tables."""
    return [
        xr.DataArray(1.25), xr.DataArray([290.0, 300.0], dims="case"), xr.DataArray([1j], dims="x"),
        xr.DataArray([0.3, 0.4], dims="time"), xr.DataArray([1.0, 2.0], dims="status"),
        xr.DataArray([0.3, 0.4], dims="omega"), xr.DataArray([0.3, NAN], dims="case"),
        xr.DataArray([0.3, 0.4], dims="case", coords={"case": ["x", "y"]}),
        xr.DataArray([0.3, 0.4], dims="case", coords={"case": ["x", "x"]}),
        xr.DataArray([0.3, 0.4], dims="case", coords={"case": [NAN, 1.0]}),
        xr.DataArray([0.3, 0.4], dims="case", coords={"case": [object(), None]}),
        xr.DataArray([0.3, 0.4], dims=""), xr.DataArray([0.3, 0.4], dims=[("a", 1)]),
        xr.DataArray([0.3, 0.4], dims=[3]), xr.DataArray([0.3, 0.4], dims="a/b"),
        xr.DataArray([0.3, 0.4], dims="case", coords={"b": ("case", ["x", "y"])}),
        xr.DataArray([[0.3, 0.4]], dims=("case", "other")), xr.DataArray(np.empty((0,)), dims="c"),
        xr.DataArray(["x", "y"], dims="case"), xr.DataArray([None, 1.0], dims="case"),
        xr.DataArray(np.array(["2020"], "datetime64[ns]"), dims="case"),
        xr.DataArray([0.3, 0.4], dims="case", name="b", attrs={"units": "mT"}),
        xr.Variable("case", [1.0, 2.0]), xr.Dataset(), xr.Dataset({"x": ("t", [1.0, 2.0])}),
        xr.Dataset({1: ((2,), [1.0])}), xr.DataTree(),
        pd.Series([1.0, 2.0]), pd.Series([1.0, None], dtype="Float64"), pd.Index([1.0, 2.0]),
        pd.Series([1, 2], index=["a", "a"]), pd.Series(["x", "y"], dtype="category"),
        pd.DataFrame({"time": [0.0, 1.0], "stretch": [1.0, 1.1]}), pd.DataFrame(),
        pd.DataFrame([[1.0, 2.0]], columns=["time", "time"]),
        pd.Series(pd.to_timedelta([0, 1], "ms")), pd.Timestamp("2020-01-01"), pd.NaT, pd.NA,
        pd.MultiIndex.from_product([[1, 2], ["a"]]), pd.Interval(0, 1), pd.Timedelta("1ms"),
    ]  # fmt: skip


def quantities() -> list[Any]:
    """Numbers with units, of pint."""
    unit = pint.Quantity
    return [
        unit(5.0, "ms"), unit(NAN, "ms"), unit(1e308, "kPa"), unit(1j, "ms"), unit(5.0, ""),
        unit(20.0, "degC"), unit(0.0, "T"), unit(300.0, "K"), unit(100, "kPa"), unit("5 mm"),
        unit(np.array([1.0, 2.0]), "Hz"), unit(np.array([0.0, 1.0]), "s"),
        unit(np.ma.masked_array([1.0, 2.0], [False, True]), "mT"), unit(np.array([]), "s"),
        unit([1.0, 2.0], "1"), pint.Unit("ms"), xr.DataArray(unit([1.0, 2.0], "ms"), dims="time"),
        pint.UnitRegistry().Quantity(5.0, "ms"),
    ]  # fmt: skip


class Unspeakable:
    """Something whose every word is an error."""

    def __repr__(self) -> str:
        raise RuntimeError("no name")

    __str__ = __repr__


class Unusable:
    """Something that says that it is an array, a number and a sequence, and is none."""

    def fail(self, *_: Any, **__: Any) -> Any:
        """Raise."""
        raise RuntimeError("no use")

    __array__ = __float__ = __len__ = __iter__ = __getitem__ = __index__ = fail


def things() -> list[Any]:
    """What is no data."""
    return [
        object(), int, rm.Gent, rm.Actuator, rm.SineSquared, abs, steady, raising, rm,
        Ellipsis, NotImplemented, slice(1, 2), ValueError("x"), np.random.default_rng(1),
        np.random.RandomState(1), rm.simulate, rm.equilibria, rm.plot.history,
        re.compile("x"), Unspeakable(), Unusable(), Part, rm.Status,
    ]  # fmt: skip


def models() -> list[Any]:
    """Actuators and drives of every kind, of extreme numbers, and parts of them."""
    with_parts = [
        *(rm.Actuator(material=part) for part in examples(Material).values()),  # type: ignore[type-abstract]
        *(rm.Actuator(dissipation=part) for part in examples(Dissipation).values()),
    ]
    return [
        *examples(Part).values(), *with_parts, rm.Actuator(), rm.Actuator(prestress=(0.0, 0.1)),
        film(), rm.Actuator(heat=rm.Heat(), dissipation=rm.Zener(0.5, 0.7)), rm.Constant(0.1),
        rm.Actuator(heat=rm.Heat(), magnet=rm.Magnet(temperature_coefficient=1e-3)),
        rm.Actuator(edges=(1.0, 1.0)), rm.Actuator(magnet=rm.Magnet(law="rotation")),
        rm.Actuator(c=1e-300), rm.Actuator(c=1e300), rm.Actuator(prestress=1e300),
        rm.Actuator(prestress=-1e3), rm.Actuator(temperature=1e300), rm.Actuator(prestress=2.2),
        rm.Actuator(reference_temperature=1e300), rm.Actuator(dissipation=rm.Rayleigh(1e300)),
        rm.Actuator(dissipation=rm.Zener(1e-300, 1e-300)), rm.Actuator(material=rm.Gent(1e-300)),
        rm.SineSquared(0.4, 1.25), rm.SineSquared(1e150, 1.25), rm.SineSquared(0.4, 1e-300),
        rm.SineSquared(0.4, 1e300), rm.SineSquared(0.0, 1.25), rm.Sine(0.0, 1.0),
        rm.Sines([0.1, 0.1], [1.0, 2**0.5], 1.0), rm.Sines([0.1, 0.0], [1.0, 2**0.5], 1.0),
        rm.Sines([0.0, 0.0], [1, 3], 1.0), rm.Sines([0.1], [1e-300], 1.0),
        rm.Steps([0.0, 1e-300], [0.1, 0.2]), rm.Ramp([0.0, 1e300], [0.0, 1e300]),
        rm.Constant(1e308), rm.Constant(-0.0), film().scales, rm.equations(rm.Actuator()),
        rm.Measure(rm.equilibria, rm.Actuator(), 0.16, of="turning_upper"),
        rm.Measure(rm.equilibria, rm.Actuator(), 0.16, of=raising),
        rm.Measure(rm.equilibria, rm.Actuator(), 0.16, of="text"),
    ]  # fmt: skip


def used_up() -> list[Value]:
    """Values that are made for each call."""
    return [
        Value("iterator", lambda: iter([1.0, 2.0])), Value("texts", lambda: iter(["b", "omega"])),
        Value("generator", lambda: (x for x in [1.0, 2.0])), Value("failing", lambda: raising),
        Value("failing generator", failing), Value("pairs", {"b": [0.3]}.items),
        Value("axes", lambda: plt.figure().subplots()),
        Value("axes in space", lambda: plt.figure().add_subplot(projection="3d")),
        Value("polar axes", lambda: plt.figure().add_subplot(projection="polar")),
        Value("many axes", lambda: plt.figure().subplots(2, 2)),
        Value("figure", plt.figure),
    ]  # fmt: skip


def in_mapping(key: str, value: Value) -> Value:
    """A mapping with one entry."""
    return Value(f"{{{key}: {value.word}}}", lambda: {key: value.make()})


def in_list(value: Value) -> Value:
    """A list of one entry."""
    return Value(f"[{value.word}]", lambda: [value.make()])


def before_one(value: Value) -> Value:
    """A pair."""
    return Value(f"({value.word}, 1.0)", lambda: (value.make(), 1.0))


def in_array(value: Value) -> Value:
    """A labelled array, where it can be one; else the value itself."""

    def make() -> Any:
        made = value.make()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # units are lost
            try:
                return xr.DataArray([made, made], dims="case")
            except Exception:
                return made

    return Value(f"DataArray of {value.word}", make)


def same(value: Any) -> Any:
    """The value itself."""
    return value


def steady(*_: Any, **__: Any) -> float:
    """A function of anything."""
    return 1.0


def raising(*_: Any, **__: Any) -> float:
    """A function that fails."""
    raise OwnError("of the caller")


def failing() -> Iterator[float]:
    """An iterator that fails on the way."""
    yield 1.0
    raise OwnError("of the caller")


def word(value: Any) -> str:
    """A value in a few letters, without its address."""
    try:
        text = repr(value)[:300]
    except Exception:
        text = type(value).__name__
    shown = re.sub(r"(0x|at )[0-9a-fA-Fx]+", "", " ".join(text.split()))[:160]
    return shown.encode("ascii", "backslashreplace").decode()


@cache
def film() -> rm.Actuator:
    """An actuator with sizes."""
    return rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length="5 mm",
        half_thickness="0.5 mm", remanence="143 mT",
    )  # fmt: skip
