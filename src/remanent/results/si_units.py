"""The SI unit of each kind of quantity, and what the quantity is called there."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Final

from remanent.results.schema import Description, QuantityKind

__all__ = ["CONVERSIONS", "LENGTH_CONVERSIONS", "Conversion", "product_of_units"]

#: Scales by name, as results carry them.
Scales = Mapping[str, Any]


@dataclass(frozen=True)
class Conversion:
    """How values of one kind turn to SI.

    Attributes
    ----------
    units : str
        UDUNITS text of the SI unit.
    factor : callable
        Of the scales: SI units in one dimensionless unit.
    needs : tuple of str
        Scales without which values stay dimensionless.
    symbols, words : mapping of str to str
        What takes the place of leading symbols, and of words in long names.
    squares : bool
        Whether the square of the value is proportional to the quantity in SI.
    """

    units: str
    factor: Callable[[Scales], Any]
    needs: tuple[str, ...] = ()
    symbols: Mapping[str, str] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)
    squares: bool = False

    def described(self, row: Description) -> Description:
        """What a variable is in SI."""
        words = row.long_name
        for old, new in self.words.items():
            words = words.replace(old, new)
        return replace(
            row, units=self.units, symbol=_renamed(row.symbol, self.symbols), long_name=words
        )


def _renamed(symbol: str, symbols: Mapping[str, str]) -> str:
    r"""Exchange the leading symbol and keep its decorations: index, exponent, argument.

    The symbol of an error is ``\delta(...)`` of that of the quantity.
    """
    start, end = r"\delta(", ")"
    if symbol.startswith(start) and symbol.endswith(end):
        return start + _renamed(symbol.removeprefix(start).removesuffix(end), symbols) + end
    for old, new in symbols.items():
        if symbol == old or symbol.startswith((f"{old}_", f"{old}^", f"{old}(", f"{old}/")):
            return new + symbol[len(old) :]
    return symbol


#: t = tau t_0; f = omega f_0 with f_0 = 1/(2 pi t_0); B = m B_0 and, as m = b^2, B = b^2 B_0;
#: sigma = S mu; energy per reference volume = E mu; eta mu t_0 for viscosities; entropies count
#: in mu/T0; physical sizes are over those of the actuator as it was built.
CONVERSIONS: Final[Mapping[QuantityKind, Conversion]] = MappingProxyType(
    {
        QuantityKind.TIME: Conversion("ms", lambda s: s["time_s"] * 1e3, symbols={r"\tau": "t"}),
        QuantityKind.RATE: Conversion("s-1", lambda s: 1.0 / s["time_s"]),
        QuantityKind.SQUARED_RATE: Conversion("s-2", lambda s: 1.0 / s["time_s"] ** 2),
        QuantityKind.FREQUENCY: Conversion(
            "Hz",
            lambda s: s["frequency_hz"],
            symbols={r"\omega": "f", r"\max|\Delta\omega_r|": r"\max|\Delta f_r|"},
        ),
        QuantityKind.LOAD: Conversion(
            "mT",
            lambda s: s["load_T"] * 1e3,
            ("load_T",),
            {"m": "B", r"\bar m": r"\bar B"},
            {"magnetic load": "flux density"},
        ),
        QuantityKind.ROOT_LOAD: Conversion(
            "mT",
            lambda s: s["load_T"] * 1e3,
            ("load_T",),
            {"b": r"B_{\max}"},
            {"root of the peak magnetic load": "peak flux density"},
            squares=True,
        ),
        QuantityKind.STRESS: Conversion(
            "kPa",
            lambda s: s["stress_pa"] / 1e3,
            symbols={"S": r"\sigma"},
            words={"prestress": "nominal stress of the dead loads"},
        ),
        QuantityKind.ENERGY_DENSITY: Conversion("kJ m-3", lambda s: s["stress_pa"] / 1e3),
        QuantityKind.ENTROPY_DENSITY: Conversion(
            "J m-3 K-1",
            lambda s: s["stress_pa"] / s["reference_temperature"],
            ("reference_temperature",),
        ),
        QuantityKind.VISCOSITY: Conversion("Pa s", lambda s: s["stress_pa"] * s["time_s"]),
        QuantityKind.SHEAR_MODULUS: Conversion(
            "kPa", lambda s: s["stress_pa"] / 1e3, (), {r"\mu/\mu_0": r"\mu"}, {"relative ": ""}
        ),
        QuantityKind.DENSITY: Conversion(
            "kg m-3",
            lambda s: s["density"],
            ("density",),
            {r"\rho/\rho_0": r"\rho"},
            {"relative ": ""},
        ),
        QuantityKind.REMANENCE: Conversion(
            "mT",
            lambda s: s["remanence"] * 1e3,
            ("remanence",),
            {r"B_r/B_{r0}": "B_r"},
            {"relative ": ""},
        ),
    }
)


def _edge_conversion(name: str) -> Conversion:
    """In-plane stretches into edges of the block."""
    words = {"in-plane stretch": "edge", "stretch along edge": "edge"}
    return Conversion("mm", lambda s: 2e3 * s[name], (name,), {r"\lambda": "l"}, words)


_THICKNESS = Conversion(
    "mm",
    lambda s: 2e3 * s["half_thickness"],
    ("half_thickness",),
    {r"\lambda_3": "h", r"\langle\lambda_3\rangle": r"\langle h\rangle"},
    {"thickness stretch": "thickness"},
)
#: Stretches times the edges and the thickness of the undeformed block 2 L1 x 2 L2 x 2 H, by
#: the names of variables.
LENGTH_CONVERSIONS: Final[Mapping[str, Conversion]] = MappingProxyType(
    {
        "stretch": _edge_conversion("half_edge"),
        "stretch_1": _edge_conversion("half_edge_1"),
        "stretch_2": _edge_conversion("half_edge_2"),
        **dict.fromkeys(
            (
                "thickness_stretch", "mean_thickness_stretch", "final", "farthest", "amplitude",
                "maximum", "minimum", "resonance_amplitude", "turning_lower", "turning_upper",
                "equilibrium_stretch", "residual_amplitude",
            ),
            _THICKNESS,
        ),
    }
)  # fmt: skip


def product_of_units(powers: Mapping[str, int]) -> str:
    """UDUNITS text of a product of units, each to its power; ``1`` where nothing is left."""
    parts = []
    for units, power in powers.items():
        if power == 0 or units in {"1", ""}:
            continue
        if power == 1:
            parts.append(units)
        elif re.fullmatch("[A-Za-z]+", units):
            parts.append(f"{units}{power}")
        else:
            parts.append(f"({units}){power}")
    return " ".join(parts) or "1"
