"""What a page can begin with: the figures of the article, and motions beyond it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

#: The published temperature in the middle of the three, kelvin.
_TEMPERATURE: Final = 350.0
#: The amplitude of the root of the load that gives the published resonances.
_B: Final = 0.4
#: For the two published prestresses the drive frequency of figures 5 and 6.
_MOTIONS: Final = ((0.0, 1.25, "5"), (1.0, 1.08, "6"))
#: Letters of panels without and with prestress.
_PANELS: Final = ((0.0, "a"), (1.0, "b"))


def presets() -> list[dict[str, Any]]:
    """What a page can begin with.

    Returns
    -------
    list of dict
        ``id``, ``title``, ``text`` in a sentence, ``spec`` as
        :func:`~remanent.page.spec.read_spec` takes it, and ``view``: the length of the run in
        ``periods`` or as a ``duration``, and the ``views`` that show the most, the first of
        them first.
    """
    return [*_periodic_loads(), *_constant_loads(), *_responses(), *_beyond()]


def _preset(
    name: str, title: str, text: str, spec: dict[str, Any], views: list[str], **length: float
) -> dict[str, Any]:
    return {"id": name, "title": title, "text": text, "spec": spec,
            "view": {**length, "views": views}}  # fmt: skip


def _squared(omega: float, b: float = _B) -> dict[str, Any]:
    return {"kind": "SineSquared", "b": b, "omega": omega}


def _block(prestress: float = 0.0, **further: Any) -> dict[str, Any]:
    return {"temperature": _TEMPERATURE, "prestress": prestress, **further}


def _periodic_loads() -> Iterator[dict[str, Any]]:
    for prestress, omega, figure in _MOTIONS:
        yield _preset(
            f"figure-{figure}",
            f"Figure {figure}: under a periodic load, S = {prestress:g}",
            f"The published cube at its frequency of resonance, ω = {omega:g}. Move T to 250 and "
            "400 K for the other rows of the figure.",
            {"actuator": _block(prestress), "drive": _squared(omega)},
            ["history", "phase", "section"],
            periods=500,
        )


def _constant_loads() -> Iterator[dict[str, Any]]:
    for figure, views, what in (
        ("2", ["history", "phase"], "stretch against time"),
        ("3", ["phase", "history"], "phase plane"),
    ):
        for prestress, letter in _PANELS:
            yield _preset(
                f"figure-{figure}{letter}",
                f"Figure {figure} ({letter}): {what} under a constant load, S = {prestress:g}",
                "The load is switched on and stays, m = b². Move T between 250 and 400 K for the "
                "curves of the figure.",
                {
                    "actuator": _block(prestress),
                    "drive": {"kind": "Constant", "m": round(_B**2, 12)},
                },
                views,
                duration=40.0,
            )


def _responses() -> Iterator[dict[str, Any]]:
    for prestress, letter in _PANELS:
        omega = _MOTIONS[0][1] if prestress == 0.0 else _MOTIONS[1][1]
        yield _preset(
            f"figure-4{letter}",
            f"Figure 4 ({letter}): frequency response, S = {prestress:g}",
            "The amplitude from rest over the frequency of the drive. Where it is largest depends "
            "on T and on S.",
            {"actuator": _block(prestress), "drive": _squared(omega)},
            ["response", "history"],
            periods=500,
        )


def _beyond() -> Iterator[dict[str, Any]]:
    yield _preset(
        "damped-resonance",
        "A damped block near its resonance",
        "A little damping, and the motion settles on one orbit: the section becomes a point.",
        {
            "actuator": _block(dissipation=[{"kind": "Rayleigh", "eta": 0.05}]),
            "drive": _squared(1.25),
        },
        ["history", "section", "response"],
        periods=200,
    )
    yield _preset(
        "quasi-periodic",
        "A quasi-periodic motion",
        "Without damping a strong load leaves two frequencies: the section is a closed curve.",
        {"actuator": _block(), "drive": _squared(1.6, 0.8)},
        ["section", "phase", "history"],
        periods=500,
    )
    yield _preset(
        "two-wells",
        "Chaos between two wells",
        "Duffing's oscillator with two wells under a sine. Soon the smallest differences decide "
        "which well comes next, and the page says from when on.",
        {
            "system": {
                "kind": "LagrangianSystem",
                "coordinates": ["x"],
                "kinetic": "x_rate**2/2",
                "potential": "-x**2/2 + x**4/4 - load*x",
                "dissipation": "delta*x_rate**2/2",
                "parameters": {"delta": 0.25},
                "observable": "x",
            },
            "drive": {"kind": "Sine", "m": 0.3, "omega": 1.0},
        },
        ["section", "phase", "history"],
        periods=500,
    )
    yield _preset(
        "parametric",
        "Two stretches by parametric resonance",
        "Equal stretches lose their symmetry: a load at twice the natural frequency of the "
        "difference makes it grow from one thousandth.",
        {
            "actuator": {"prestress": [0.0, 0.0]},
            "drive": _squared(round(math.sqrt(6.0), 3), 0.9),
            "initial": {"stretch_1": 1.001},
        },
        ["history", "phase"],
        periods=1000,
    )
    yield _preset(
        "viscoelastic",
        "A viscoelastic block after a step",
        "A spring in series with a dashpot: the block creeps to its rest, and back.",
        {
            "actuator": _block(
                dissipation=[
                    {"kind": "Zener", "modulus": 0.8, "relaxation_time": 6.0},
                    {"kind": "Rayleigh", "eta": 0.2},
                ]
            ),
            "drive": {"kind": "Steps", "times": [0.0, 10.0, 60.0], "loads": [0.0, 0.3, 0.0]},
        },
        ["history", "phase"],
        duration=100.0,
    )
    yield _preset(
        "warming",
        "A block that warms itself",
        "Damping turns motion into heat, and heat makes rubber stiffer. The coupling is a hundred "
        "times that of rubber, so that it can be seen.",
        {
            "actuator": {
                "temperature": 293.0,
                "dissipation": [{"kind": "Rayleigh", "eta": 0.1}],
                "heat": {"kind": "Heat", "coupling": 0.02, "exchange": 0.005},
            },
            "drive": _squared(1.05, 0.8),
        },
        ["history", "section"],
        periods=300,
    )
    yield _preset(
        "limited-chains",
        "Chains near their limit",
        "Gent's rubber stiffens without bound where its chains are stretched out: a strong load "
        "meets a wall.",
        {
            "actuator": _block(
                prestress=0.8,
                material={"kind": "Gent", "jm": 8.0},
                dissipation=[{"kind": "Rayleigh", "eta": 0.02}],
            ),
            "drive": _squared(1.0, 1.2),
        },
        ["history", "phase", "potential"],
        periods=200,
    )
