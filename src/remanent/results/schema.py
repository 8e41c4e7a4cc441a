"""THE table: every variable of every Dataset, with its unit, symbol and meaning.

Everything inside the package is dimensionless: lengths of time in
``sqrt(rho L^2 / mu)``, stresses in ``mu``, energies in ``mu`` per reference volume.
Units follow UDUNITS, so ``"1"`` is dimensionless and ``"rad"`` is an angle; as time
has no unit, an angular frequency is in ``rad`` (radians per unit of tau).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType

import numpy as np

from remanent._errors import InputError
from remanent._status import Status

__all__ = ["FLAGS", "TABLE", "Kind", "Variable", "describe", "flag_attributes"]


class Kind(Enum):
    """How a quantity turns to SI; see :mod:`remanent.results.si`."""

    NONE = "none"
    TIME = "time"
    RATE = "rate"
    SQUARED_RATE = "square of a rate"
    FREQUENCY = "frequency"
    LOAD = "load"
    ROOT_LOAD = "root of load"
    STRESS = "stress"
    OWN_FIELD = "own field"
    COUPLING = "thermoelastic coupling"
    VISCOSITY = "viscosity"
    ENERGY_DENSITY = "energy density"
    TEMPERATURE = "temperature"


@dataclass(frozen=True)
class Variable:
    """One row of the table.

    Attributes
    ----------
    name
        The name in the API and in files.
    units
        UDUNITS text; ``"1"`` where dimensionless.
    long_name
        The meaning in a few words, for axes.
    symbol
        LaTeX for use between dollar signs.
    dims
        The dimension a variable has of its own, beside those of ``over``; empty
        where it has none (one value per trajectory) or is a coordinate.
    kind
        How it turns to SI.
    """

    name: str
    units: str
    long_name: str
    symbol: str
    dims: tuple[str, ...] = ()
    kind: Kind = Kind.NONE

    def attributes(self) -> dict[str, str]:
        """Attributes ``units``, ``long_name`` and ``symbol`` of a Dataset variable."""
        return {"units": self.units, "long_name": self.long_name, "symbol": self.symbol}


_ALONG = ("time",)
_ROWS = (
    # The motion.
    Variable("stretch", "1", "in-plane stretch", r"\lambda", _ALONG),
    Variable("stretch_rate", "1", "in-plane stretch rate", r"\lambda'", _ALONG, Kind.RATE),
    Variable("stretch_1", "1", "stretch along edge 1", r"\lambda_1", _ALONG),
    Variable("stretch_1_rate", "1", "stretch rate along edge 1", r"\lambda_1'", _ALONG, Kind.RATE),
    Variable("stretch_2", "1", "stretch along edge 2", r"\lambda_2", _ALONG),
    Variable("stretch_2_rate", "1", "stretch rate along edge 2", r"\lambda_2'", _ALONG, Kind.RATE),
    Variable("thickness_stretch", "1", "thickness stretch", r"\lambda_3", _ALONG),
    Variable(
        "thickness_stretch_rate", "1", "thickness stretch rate", r"\lambda_3'", _ALONG, Kind.RATE
    ),
    Variable("dissipation.viscous_stretch", "1", "viscous in-plane stretch", r"\xi", _ALONG),
    Variable(
        "dissipation.viscous_stretch_1", "1", "viscous stretch along edge 1", r"\xi_1", _ALONG
    ),
    Variable(
        "dissipation.viscous_stretch_2", "1", "viscous stretch along edge 2", r"\xi_2", _ALONG
    ),
    Variable("body_temperature", "K", "temperature of the body", r"T", _ALONG, Kind.TEMPERATURE),
    Variable("energy", "1", "energy per reference volume", r"E", _ALONG, Kind.ENERGY_DENSITY),
    Variable(
        "energy_drift",
        "1",
        "change of energy per reference volume",
        r"\Delta E",
        _ALONG,
        Kind.ENERGY_DENSITY,
    ),
    Variable(
        "stored_energy",
        "1",
        "energy per reference volume, without that in the field",
        r"E_s",
        _ALONG,
        Kind.ENERGY_DENSITY,
    ),
    Variable("drive_work", "1", "work of the magnetic load", r"W", _ALONG, Kind.ENERGY_DENSITY),
    Variable("dissipated_energy", "1", "dissipated energy", r"D", _ALONG, Kind.ENERGY_DENSITY),
    Variable("balance", "1", "defect of the energy balance", r"r", _ALONG, Kind.ENERGY_DENSITY),
    Variable(
        "heat_given_off",
        "1",
        "heat given to the surroundings",
        r"Q",
        _ALONG,
        Kind.ENERGY_DENSITY,
    ),
    # Entropies are in units of mu/T0.
    Variable("entropy", "1", "entropy per reference volume", r"s", _ALONG),
    Variable("entropy_produced", "1", "entropy produced", r"s_i", _ALONG),
    Variable("entropy_given_off", "1", "entropy given to the surroundings", r"s_e", _ALONG),
    Variable("entropy_balance", "1", "defect of the entropy balance", r"r_s", _ALONG),
    Variable(
        "mean_thickness_stretch", "1", "mean thickness stretch", r"\langle\lambda_3\rangle", _ALONG
    ),
    Variable("load", "1", "magnetic load", r"m", _ALONG, Kind.LOAD),
    # Commands and what follows a step.
    Variable("step", "1", "step of the command", r"k"),
    Variable("step_time", "1", "time of the step", r"\tau_k", ("step",), Kind.TIME),
    Variable("step_load", "1", "magnetic load from the step on", r"m_k", ("step",), Kind.LOAD),
    Variable("switch_time", "1", "time of the last step", r"\tau_n", kind=Kind.TIME),
    Variable("final", "1", "thickness stretch at rest after the last step", r"\lambda_3^\infty"),
    Variable("residual_amplitude", "1", "residual vibration", r"a_r"),
    Variable("residual_energy", "1", "energy above rest", r"E_r", kind=Kind.ENERGY_DENSITY),
    Variable("rise_time", "1", "rise time", r"\tau_r", kind=Kind.TIME),
    Variable("settling_time", "1", "settling time", r"\tau_s", kind=Kind.TIME),
    Variable("farthest", "1", "farthest thickness stretch", r"\lambda_3^{p}"),
    Variable("overshoot", "1", "overshoot over the change", r"o"),
    Variable("shear_modulus", "1", "relative shear modulus", r"\mu/\mu_0"),
    Variable("density", "1", "relative density", r"\rho/\rho_0"),
    Variable("remanence", "1", "relative remanence", r"B_r/B_{r0}"),
    # Fits.
    Variable("parameter", "1", "parameter", r"p"),
    Variable("other_parameter", "1", "parameter", r"q"),
    Variable("bound", "1", "end of the interval", r"\pm"),
    Variable("estimate", "1", "estimate", r"\hat p", ("parameter",)),
    Variable("interval", "1", "confidence interval", r"\hat p_\pm", ("parameter", "bound")),
    Variable(
        "profile_interval",
        "1",
        "interval by profile likelihood",
        r"\hat p_\pm",
        ("parameter", "bound"),
    ),
    Variable("correlation", "1", "correlation", r"r", ("parameter", "other_parameter")),
    Variable("chi_square", "1", "sum of squares over variances", r"\chi^2"),
    Variable("degrees", "1", "degrees of freedom", r"\nu"),
    Variable("noise", "1", "noise over the given deviations", r"s"),
    Variable("observation", "1", "number of the observation", r"k"),
    Variable("quantity", "1", "what was measured", r"x"),
    Variable("observed", "1", "measured", r"x", ("observation",)),
    Variable("predicted", "1", "fitted", r"\hat x", ("observation",)),
    Variable("decrement", "1", "logarithmic decrement", r"\delta"),
    Variable("damping_ratio", "1", "damping ratio", r"\zeta"),
    # Sensitivities, designs, uncertainty.
    Variable("field", "1", "field", r"p"),
    Variable("measure", "1", "measure", r"f"),
    Variable("value", "1", "value of the measure", r"f"),
    Variable("derivative", "1", "derivative by the field", r"\partial f/\partial p", ("field",)),
    Variable("elasticity", "1", "elasticity", r"\partial\ln f/\partial\ln p", ("field",)),
    Variable("quantile", "1", "share of what may happen", r"q"),
    Variable("average", "1", "mean over the uncertain fields", r"\langle f\rangle"),
    Variable("deviation", "1", "standard deviation by the uncertain fields", r"\sigma_f"),
    Variable("known", "1", "share of the sample that is known", r"n"),
    Variable("first_index", "1", "first-order Sobol index", r"S_p", ("field",)),
    Variable("total_index", "1", "total Sobol index", r"S_p^T", ("field",)),
    Variable("solution", "1", "value of the field", r"p", ("field",)),
    Variable("target", "1", "wanted value", r"f^*", ("measure",)),
    Variable("reached", "1", "value reached", r"f", ("measure",)),
    # Where along a run.
    Variable("time", "1", "time", r"\tau", kind=Kind.TIME),
    Variable("cycle", "1", "sample within the run", r"k"),
    Variable("period", "1", "drive periods", r"n"),
    Variable("crossing", "1", "number of the crossing", r"k"),
    Variable("crossing_time", "1", "time of the crossing", r"\tau_k", ("crossing",), Kind.TIME),
    Variable("direction", "1", "direction of the crossing", r"\pm", ("crossing",)),
    Variable("crossings", "1", "number of crossings", r"n"),
    Variable("drive_period", "1", "smallest period of the load", r"\tau_m", kind=Kind.TIME),
    Variable("section_phase", "1", "phase of the section within the drive period", r"s"),
    # Forced response.
    Variable("amplitude", "1", "thickness stretch amplitude", r"\lambda_3^a"),
    Variable("maximum", "1", "largest thickness stretch", r"\lambda_3^{\max}"),
    Variable("minimum", "1", "smallest thickness stretch", r"\lambda_3^{\min}"),
    Variable("resonance", "rad", "resonance frequency", r"\omega_r", kind=Kind.FREQUENCY),
    Variable("resonance_amplitude", "1", "amplitude at resonance", r"\lambda_3^a(\omega_r)"),
    Variable("frequency", "rad", "frequency", r"\omega_0", kind=Kind.FREQUENCY),
    # Evidence.
    Variable("error", "1", "estimated largest error of the state", r"\varepsilon"),
    Variable("horizon", "1", "time up to which the error bound holds", r"\tau_h", kind=Kind.TIME),
    Variable("status", "1", "status", r"\mathrm{status}"),
    Variable("residual", "1", "residual", r"r"),
    # Equilibria and the potential.
    Variable(
        "potential",
        "1",
        "potential energy per reference volume",
        r"U",
        ("thickness_stretch",),
        Kind.ENERGY_DENSITY,
    ),
    Variable("level", "1", "energy of the motion", r"E_0", kind=Kind.ENERGY_DENSITY),
    Variable("turning_lower", "1", "lower turning point", r"\lambda_3^-"),
    Variable("turning_upper", "1", "upper turning point", r"\lambda_3^+"),
    Variable("equilibrium", "1", "number of the equilibrium", r"k"),
    Variable("fold", "1", "number of the fold", r"j"),
    Variable("snap", "1", "number of the threshold", r"j"),
    Variable("snap_direction", "1", "direction in which the motion passes", r"\pm", ("snap",)),
    Variable(
        "equilibrium_stretch",
        "1",
        "thickness stretch at equilibrium",
        r"\lambda_3^{\mathrm{eq}}",
        ("equilibrium",),
    ),
    Variable(
        "equilibrium_potential",
        "1",
        "potential energy at equilibrium",
        r"U^{\mathrm{eq}}",
        ("equilibrium",),
        Kind.ENERGY_DENSITY,
    ),
    Variable("stability", "1", "stability", r"\mathrm{stability}", ("equilibrium",)),
    Variable(
        "natural_frequency",
        "rad",
        "natural frequency",
        r"\omega_n",
        ("equilibrium",),
        Kind.FREQUENCY,
    ),
    Variable("mode", "1", "number of the mode", r"j"),
    # Statistics and orbits.
    Variable("exponent", "1", "largest Lyapunov exponent", r"\Lambda", kind=Kind.RATE),
    Variable("exponent_number", "1", "number of the exponent", r"j"),
    Variable(
        "exponent_history",
        "1",
        "mean growth of tangents so far",
        r"\Lambda(n)",
        ("period",),
        Kind.RATE,
    ),
    Variable("symmetry", "1", "symmetry of the in-plane stretches", r"\mathrm{symmetry}"),
    Variable("transverse_growth", "1", "growth of a difference of stretches, logarithm", r"g_a"),
    Variable(
        "transverse_exponent",
        "1",
        "exponent of a difference of stretches",
        r"\Lambda_a",
        kind=Kind.RATE,
    ),
    Variable(
        "transverse_multipliers",
        "1",
        "Floquet multipliers of a difference of stretches",
        r"\rho_a",
        ("multiplier",),
    ),
    Variable(
        "transverse_stiffness",
        "1",
        "square of the frequency at which stretches part",
        r"\omega_a^2",
        ("equilibrium",),
        Kind.SQUARED_RATE,
    ),
    Variable("local_error", "1", "estimated largest error of one period", r"\varepsilon_1"),
    Variable("run_periods", "1", "length of the run in drive periods", r"N"),
    Variable("rotation_number", "1", "rotation number", r"\nu"),
    Variable("rotation_digits", "1", "converged digits of the rotation number", r"d_\nu"),
    Variable("digits", "1", "converged digits of weighted averages", r"d"),
    Variable("zero_one", "1", "result of the 0-1 test", r"K"),
    Variable("sali", "1", "smaller alignment index", r"A"),
    Variable("margin", "1", "factor by which the evidence clears its line", r"q"),
    Variable("defect", "1", "return defect relative to the extent", r"\delta"),
    Variable("attractor", "1", "number of the attractor", r"k"),
    Variable("basin", "1", "number of the attractor that is reached", r"k"),
    Variable(
        "attractor_regime", "1", "regime of the attractor", r"\mathrm{regime}", ("attractor",)
    ),
    Variable("attractor_period", "1", "period of the attractor", r"n_k", ("attractor",)),
    Variable("attractor_state", "1", "a point of the attractor", r"y_k", ("attractor", "state")),
    Variable("fraction", "1", "fraction of initial states", r"f", ("attractor",)),
    Variable("sweep", "1", "direction of the sweep", r"\pm"),
    Variable("regime", "1", "regime of the motion", r"\mathrm{regime}"),
    Variable("orbit", "1", "number of the orbit", r"k"),
    Variable("orbits", "1", "how many orbits exist side by side", r"n"),
    Variable("state", "1", "state variable", r"\mathrm{state}"),
    Variable("initial", "1", "initial state of the orbit", r"y_0", ("orbit", "state")),
    Variable("multiplier", "1", "number of the multiplier", r"j"),
    Variable("branch", "1", "number of the branch", r"k"),
    Variable("point", "1", "point of the branch", r"i"),
    Variable("special", "1", "special point", r"j"),
    Variable("end", "1", "end of the branch", r"e"),
    Variable("end_reason", "1", "why the branch ends", r"\mathrm{reason}", ("branch", "end")),
    Variable("special_kind", "1", "kind of the special point", r"\mathrm{kind}", ("special",)),
    Variable("multipliers", "1", "Floquet multipliers", r"\rho", ("orbit", "multiplier")),
    Variable("peak", "1", "number of the peak", r"k"),
    Variable("unbounded", "1", "whether the branch runs off", r"\infty", ("peak",)),
    Variable("resonance_kind", "1", "kind of resonance", r"\mathrm{kind}", ("peak",)),
    Variable("order_p", "1", "oscillations", r"p", ("peak",)),
    Variable("order_q", "1", "drive periods they take", r"q", ("peak",)),
    Variable("orbit_period", "1", "period of the orbit in drive periods", r"n", ("peak",)),
    Variable("phase_lag", "rad", "phase lag behind the load", r"\varphi", ("peak",)),
    Variable("harmonic", "1", "number of the harmonic", r"k"),
    Variable("harmonics", "1", "harmonics of the thickness stretch", r"c_k", ("peak", "harmonic")),
    Variable("share", "1", "share of the harmonic in the mean square", r"s", ("peak",)),
    Variable(
        "free_frequency",
        "rad",
        "frequency of the free oscillation as large",
        r"\omega_0",
        ("peak",),
        Kind.FREQUENCY,
    ),
    Variable("detuning", "1", "detuning from the free oscillation", r"\sigma", ("peak",)),
    # The reconstruction of what [Thermal] leaves unstated.
    Variable(
        "misfit", "rad", "largest resonance misfit", r"\max|\Delta\omega_r|", kind=Kind.FREQUENCY
    ),
    Variable(
        "published",
        "rad",
        "published resonance frequency",
        r"\omega_r^{\mathrm{pub}}",
        kind=Kind.FREQUENCY,
    ),
    Variable("window", "1", "length of the response window", r"\tau_w", kind=Kind.TIME),
    Variable("law", "1", "forcing law", r"m(\tau)"),
    Variable("case", "1", "case", r"\mathrm{case}"),
    Variable("solver", "1", "integration", r"\mathrm{solver}"),
    # The actuator's and the drive's own fields.
    Variable("c", "1", "slenderness", r"c"),
    Variable("temperature", "K", "temperature", r"T", kind=Kind.TEMPERATURE),
    Variable("reference_temperature", "K", "reference temperature", r"T_0", kind=Kind.TEMPERATURE),
    Variable("prestress", "1", "prestress", r"S", kind=Kind.STRESS),
    Variable("prestress_1", "1", "prestress along edge 1", r"S_1", kind=Kind.STRESS),
    Variable("prestress_2", "1", "prestress along edge 2", r"S_2", kind=Kind.STRESS),
    Variable("edges_1", "1", "edge 1 over L", r"L_1/L"),
    Variable("edges_2", "1", "edge 2 over L", r"L_2/L"),
    Variable("tolerance", "1", "tolerance", r"\mathrm{tol}"),
    Variable("m", "1", "magnetic load", r"m", kind=Kind.LOAD),
    Variable("b", "1", "root of the peak magnetic load", r"b", kind=Kind.ROOT_LOAD),
    Variable("mean", "1", "mean magnetic load", r"\bar m", kind=Kind.LOAD),
    Variable("omega", "rad", "drive frequency", r"\omega", kind=Kind.FREQUENCY),
    Variable("phase", "rad", "phase of the drive", r"\varphi"),
    Variable("start", "rad", "drive frequency at the start", r"\omega_0", kind=Kind.FREQUENCY),
    Variable("stop", "rad", "drive frequency at the end", r"\omega_1", kind=Kind.FREQUENCY),
    Variable("duration", "1", "length of the run", r"\tau_w", kind=Kind.TIME),
    Variable(
        "magnet.temperature_coefficient",
        "K-1",
        "temperature coefficient of the remanence",
        r"\alpha",
    ),
    Variable(
        "magnet.demagnetisation",
        "1",
        "strength of the magnet in itself",
        r"B_r^2/\mu\mu_0",
        kind=Kind.OWN_FIELD,
    ),
    Variable("material.c1", "1", "constant of the first invariant", r"c_1"),
    Variable("material.c2", "1", "constant of the second invariant", r"c_2"),
    Variable("material.locking_stretch", "1", "locking stretch of a chain", r"\lambda_m"),
    Variable("material.jm", "1", "limiting value of the first invariant", r"J_m"),
    Variable("material.entropic_fraction", "1", "entropic fraction", r"f"),
    Variable("heat.coupling", "1", "thermoelastic coupling", r"k", kind=Kind.COUPLING),
    Variable("heat.exchange", "1", "rate of heat exchange", r"h", kind=Kind.RATE),
    Variable("dissipation.eta", "1", "viscosity", r"\eta", kind=Kind.VISCOSITY),
    Variable(
        "dissipation.modulus", "1", "modulus of the viscous branch", r"\mu_v", kind=Kind.STRESS
    ),
    Variable("dissipation.relaxation_time", "1", "relaxation time", r"t_r", kind=Kind.TIME),
)

#: Every row by name.
TABLE: Mapping[str, Variable] = MappingProxyType({row.name: row for row in _ROWS})

#: Dimensions of points at which other rows have a value, ``fold_m`` for example.
_PLACES: Mapping[str, str] = MappingProxyType(
    {"special": "special point", "fold": "fold", "snap": "dynamic threshold"}
)

#: Variables whose values are numbered meanings, with the meanings in order of code from 0.
FLAGS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"status": tuple(code.meaning for code in sorted(Status))}
)


def describe(name: str) -> Variable:
    """Look a variable up.

    Besides the rows themselves, the table describes by rule:

    * ``initial.<state>``, the initial value of a state variable;
    * ``special_<name>``, ``fold_<name>``, ``snap_<name>``, a row at a special point of a
      branch, at a fold of equilibria, at the dynamic threshold of a snap;
    * ``dissipation.0.eta`` and the like, the row without the number;
    * ``<name>_error``, the estimated error of a row, in the same unit;
    * any other dotted name, a dimensionless field of the user's own part.

    Parameters
    ----------
    name
        Name of a variable or coordinate.

    Returns
    -------
    Variable

    Raises
    ------
    InputError
        Nothing in the table describes that name.

    Examples
    --------
    >>> describe("omega").units
    'rad'
    >>> describe("dissipation.0.eta").long_name
    'viscosity (0)'
    >>> describe("amplitude_error").long_name
    'estimated error: thickness stretch amplitude'
    """
    if name in TABLE:
        return TABLE[name]
    for rule in (_initial, _special, _numbered, _error, _own_part):
        found = rule(name)
        if found is not None:
            return found
    raise InputError(
        "name",
        must="be a variable of the schema",
        got=repr(name),
        why="Every variable of a Dataset has a unit, a meaning and a symbol.",
        fix="Add a row to remanent/results/schema.py.",
    )


def flag_attributes(name: str) -> dict[str, object]:
    """CF attributes ``flag_values`` and ``flag_meanings`` of a flag variable, else nothing."""
    if name not in FLAGS:
        return {}
    meanings = FLAGS[name]
    return {
        "flag_values": np.arange(len(meanings), dtype=np.int8),
        "flag_meanings": " ".join(meanings),
    }


def _initial(name: str) -> Variable | None:
    base = name.removeprefix("initial.")
    if base == name or (base not in TABLE and _numbered(base) is None):
        return None
    row = describe(base)
    return replace(
        row, name=name, long_name=f"initial {row.long_name}", symbol=f"{row.symbol}(0)", dims=()
    )


def _special(name: str) -> Variable | None:
    prefix, _, base = name.partition("_")
    if not base or prefix not in _PLACES:
        return None
    row = describe(base)
    return replace(
        row, name=name, long_name=f"{row.long_name} at the {_PLACES[prefix]}", dims=(prefix,)
    )


def _numbered(name: str) -> Variable | None:
    match = re.fullmatch(r"(\w+)\.(\d+)\.(\w+)", name)
    if match is None or f"{match[1]}.{match[3]}" not in TABLE:
        return None
    row = TABLE[f"{match[1]}.{match[3]}"]
    index = f"^{{({match[2]})}}" if row.dims and "_" in row.symbol else f"_{{{match[2]}}}"
    symbol = row.symbol if "_" in row.symbol and not row.dims else row.symbol + index
    return replace(row, name=name, long_name=f"{row.long_name} ({match[2]})", symbol=symbol)


def _error(name: str) -> Variable | None:
    base = name.removesuffix("_error")
    if base == name or base not in TABLE:
        return None
    row = TABLE[base]
    return replace(
        row,
        name=name,
        long_name=f"estimated error: {row.long_name}",
        symbol=rf"\delta({row.symbol})",
        kind=Kind.NONE if row.kind is Kind.ROOT_LOAD else row.kind,
    )


def _own_part(name: str) -> Variable | None:
    part, *rest = name.split(".")
    if not rest or part not in {"material", "dissipation", "heat", "magnet", "initial", "drive"}:
        return None
    words = name.replace(".", " ").replace("_", " ")
    return Variable(name, "1", words, rf"\mathrm{{{rest[-1].replace('_', ' ')}}}")
