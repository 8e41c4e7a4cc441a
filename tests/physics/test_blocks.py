"""Two directions, viscosity and heat against an independent engine.

Laws: Coverage, Independent engines.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import remanent as rm
from tests.physics.block import Block
from tests.repetitions import fast_and_slow

TIMES = np.linspace(0.0, 6.0, 13)
DRIVE = rm.Sine(0.3, 1.7, 0.1, 0.4)
T0 = 300.0


def load(t: float) -> float:
    return 0.1 + 0.3 * math.sin(1.7 * t + 0.4)


def load_rate(t: float) -> float:
    return 0.3 * 1.7 * math.cos(1.7 * t + 0.4)


CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "two directions": ({"prestress": (0.3, -0.2)}, {"loads": (0.3, -0.2)}),
    "film": ({"prestress": (0.3, 0.2), "c": 0.01}, {"loads": (0.3, 0.2), "c": 0.01}),
    "unequal edges": (
        {"edges": (1.0, 0.5), "prestress": 0.2},
        {"weights": (1.0, 0.25), "loads": (0.2, 0.2)},
    ),
    "dashpot": (
        {"prestress": (0.3, 0.0), "dissipation": rm.Rayleigh(0.2)},
        {"loads": (0.3, 0.0), "dashpot": 0.2},
    ),
    "fluid": (
        {"prestress": (0.3, 0.0), "dissipation": rm.KelvinVoigt(0.1)},
        {"loads": (0.3, 0.0), "fluid": 0.1},
    ),
    "zener": (
        {"prestress": (0.3, 0.0), "dissipation": rm.Zener(0.5, 1.3)},
        {"loads": (0.3, 0.0), "branches": ((0.5, 1.3),)},
    ),
    "prony": (
        {"prestress": (0.3, 0.0), "dissipation": (rm.Zener(0.5, 1.3), rm.Zener(0.2, 0.3))},
        {"loads": (0.3, 0.0), "branches": ((0.5, 1.3), (0.2, 0.3))},
    ),
    "heat": (
        {
            "prestress": (0.3, 0.0),
            "dissipation": (rm.Zener(0.5, 1.3), rm.KelvinVoigt(0.05)),
            "heat": rm.Heat(2e-3, 0.1),
            "magnet": rm.Magnet(-1e-3),
        },
        {
            "loads": (0.3, 0.0),
            "branches": ((0.5, 1.3),),
            "fluid": 0.05,
            "coupling": 2e-3,
            "exchange": 0.1,
            "alpha": -1e-3 * T0,
        },
    ),
}


def ours(fields: dict[str, Any], theta: float, tolerance: float = 1e-10) -> Any:
    actuator = rm.Actuator(temperature=T0 * theta, reference_temperature=T0, **fields)
    return rm.simulate(actuator, DRIVE, times=TIMES, tolerance=tolerance)


def columns(ds: Any, block: Block) -> np.ndarray:
    """Our states in the order of the block's, one coordinate twice."""
    names = [str(n) for n in ds.data_vars]
    both = [n if n in names else n.replace("_1", "").replace("_2", "") for n in PAIR]
    inner = [
        f"dissipation.{k}.viscous_stretch{end}"
        for k in range(len(block.branches))
        for end in ("_1", "_2")
    ]
    inner = [n if n in names else n[:-2] for n in inner]
    theta = ds.body_temperature / T0 if "body_temperature" in ds else block.theta + 0.0 * ds.time
    return np.stack([*(ds[n].values for n in (*both, *inner)), theta.values], axis=1)


PAIR = ("stretch_1", "stretch_1_rate", "stretch_2", "stretch_2_rate")


@pytest.mark.parametrize("equal", [False, True], ids=["two", "one"])
@pytest.mark.parametrize("name", fast_and_slow(list(CASES), slow=("prony", "heat")))
def test_states_agree_with_dop853(name: str, equal: bool) -> None:
    """Within our bound and the reference's own error, in one coordinate and in two."""
    fields, numbers = CASES[name]
    if equal:
        fields = {k: v for k, v in fields.items() if k != "edges"} | {"prestress": 0.3}
        numbers = {k: v for k, v in numbers.items() if k != "weights"} | {"loads": (0.3, 0.3)}
    block = Block(**numbers, theta=1.15, m=load, m_rate=load_rate)
    ds = ours(fields, 1.15)
    good, rough = (block.run(TIMES, rtol=rtol) for rtol in (3e-14, 1e-12))
    assert int(ds.status) == 1
    assert float(ds.error) <= 1e-10
    difference = np.abs(columns(ds, block) - good).max()
    assert difference <= float(ds.error) + np.abs(good - rough).max()


def test_the_reference_is_equation_16_where_stretches_are_equal() -> None:
    """The independent block by itself: lambda'' of [Thermal, eq. 16]."""
    x, v, c, theta, S, m = 1.2, 0.3, 0.4, 1.1, 0.2, 0.16
    block = Block(c=c, theta=theta, loads=(S, S), m=lambda _t: m)
    rates = block.rates(0.0, np.array([x, v, x, v, theta]))
    force = theta * (x - x**-5) - S + m * x**-3
    expected = (6.0 * c * x**-7 * v**2 - 3.0 * force) / (1.0 + 2.0 * c * x**-6)
    assert rates[1] == pytest.approx(expected, rel=1e-14)
    assert rates[3] == pytest.approx(expected, rel=1e-14)
    assert replace(block, dashpot=0.1).rates(0.0, np.array([x, v, x, v, theta]))[1] < rates[1]
