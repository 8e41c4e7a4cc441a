"""A mechanical system of one's own, by its energies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from dataclasses import replace as replace_fields
from itertools import combinations
from typing import Any, Final, Self

import numpy as np

from remanent._errors import InputError
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.models import formula
from remanent.models.formula import Formula
from remanent.models.own_systems.names import RATE_SUFFIX, require_names
from remanent.models.own_systems.written_system import (
    Pairs,
    WrittenSystem,
    names_in_sequence,
    read_formula,
)

#: The names of the formulas.
_ENERGY_NAMES: Final = ("kinetic", "potential", "dissipation")
#: Largest share of the kinetic energy that may be of a degree other than 0, 1 and 2.
_DEGREE_TOLERANCE: Final = 1e-9
#: Smallest eigenvalue of the mass matrix at rest, over its largest.
_SINGULAR_SHARE: Final = 1e-12
#: How far from rest dissipation is looked for, as shares of 1 + the size of a coordinate.
_DISSIPATION_OFFSETS: Final = (0.0, 0.37, -0.53, 1.9)


@dataclass(frozen=True, kw_only=True)
class LagrangianSystem(WrittenSystem):
    """A mechanical system by its kinetic energy, potential energy and dissipation function.

    Lagrange's equations with Rayleigh's dissipation function are derived, solved for the
    accelerations and compiled, as those of an :class:`~remanent.Actuator` are.

    Parameters
    ----------
    coordinates : str or sequence of str
        Names of the generalised coordinates; the rate of ``x`` is called ``x_rate``.
    kinetic : str or SymPy expression
        Kinetic energy T, a formula in coordinates, rates and parameters, at most quadratic in
        the rates.  A coordinate whose rate is not in it is of first order, an internal
        variable: the dissipation function then gives its rate, dD/dq' = -dV/dq.
    potential : str or SymPy expression
        Potential energy V, a formula in coordinates, parameters and loads.
    dissipation : str or SymPy expression
        Rayleigh's dissipation function D, half of the power that is lost where it is quadratic in
        the rates; a formula in coordinates, rates and parameters.
    parameters : mapping of str to float
        Values of the other names in the formulas: numeric fields, which ``over``,
        continuation, sensitivities and fits may vary.
    observable : str or SymPy expression, optional
        The quantity whose extremes are followed, a formula in states and parameters: the
        first coordinate by default.  Results call it by its name where it is a state
        variable, else ``observable``.
    rest : mapping of str to float
        State from which motions start by default; what is not named is 0.
    loads : str or sequence of str
        Names of the loads, which a drive gives; one, ``load``, by default.
    units, symbols : mapping of str to str
        Units (UDUNITS) and symbols (LaTeX) of states, parameters, loads, ``observable``,
        ``energy`` and ``time``, by name, for labels.

    Raises
    ------
    InputError
        A formula that is none, unknown, reserved or unused names, a kinetic energy of higher
        degree in the rates, or a mass matrix that is singular or not positive at rest.

    See Also
    --------
    FirstOrderSystem : A system without energies, by its rates.
    equations : The equations that were derived.
    Loads : A drive for each of several loads.

    Notes
    -----
    Formulas have ``+ - * / **``, parentheses, ``sqrt``, ``exp``, ``log``, ``sin``, ``cos``,
    numbers and ``pi``; SymPy expressions are taken too.  Text is read, never run.  ``energy``
    of results is T + V; where T has terms that are linear in the rates or free of them, it is
    the energy function T2 - T0 + V, which is what such a system conserves.  A motion never
    leaves the states in which every logarithm, root and denominator has the sign that it has
    at rest.

    Examples
    --------
    >>> pendulum = LagrangianSystem(
    ...     coordinates="theta",
    ...     kinetic="theta_rate**2/2",
    ...     potential="-cos(theta) - load*sin(theta)",
    ...     dissipation="delta*theta_rate**2/2",
    ...     parameters={"delta": 0.1},
    ... )
    >>> pendulum.state_names
    ('theta', 'theta_rate')
    >>> pendulum.replace(parameters={"delta": 0.2}).parameter_values()
    {'delta': 0.2}
    """

    coordinates: str | Sequence[str]
    kinetic: Any
    potential: Any
    dissipation: Any = "0"
    parameters: Pairs = ()
    observable: Any = None
    rest: Pairs = ()
    loads: str | Sequence[str] = ("load",)
    units: Pairs = ()
    symbols: Pairs = ()

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers: Duffing's oscillator with two wells."""
        return cls(
            coordinates="x",
            kinetic="x_rate**2/2",
            potential="-x**2/2 + x**4/4 - load*x",
            dissipation="delta*x_rate**2/2",
            parameters={"delta": 0.15},
        )

    def __post_init__(self) -> None:
        names = names_in_sequence("coordinates", self.coordinates)
        require_names("coordinates", names)
        rates = tuple(f"{name}{RATE_SUFFIX}" for name in names)
        require_names("coordinates", rates, taken=names)
        self._keep("coordinates", names)
        if self.observable is None:
            self._keep("observable", names[0])
        for name in (*_ENERGY_NAMES, "observable"):
            self._keep(name, read_formula(name, getattr(self, name)))
        self._check_names_and_numbers((*names, *rates))
        loads = self.load_names
        self._check_formulas(
            {
                "kinetic": (*names, *rates),
                "potential": (*names, *loads),
                "dissipation": (*names, *rates),
                "observable": self.state_names,
            }
        )
        self._check_labels()
        _require_quadratic(self, "kinetic", self.rate_names())
        internal = [f"{q}{RATE_SUFFIX}" for q in self.first_order_names]
        _require_quadratic(self, "dissipation", internal)
        _require_rates_determined(self)

    # States -------------------------------------------------------------------------------

    @property
    def second_order_names(self) -> tuple[str, ...]:
        """Coordinates that have a kinetic energy."""
        in_kinetic = self.formulas()["kinetic"].variable_names
        return tuple(q for q in self._coordinate_names() if f"{q}{RATE_SUFFIX}" in in_kinetic)

    @property
    def first_order_names(self) -> tuple[str, ...]:
        """Coordinates that have none: internal variables."""
        return tuple(q for q in self._coordinate_names() if q not in self.second_order_names)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Coordinates with their rates in turn, then internal variables."""
        pairs = ((q, f"{q}{RATE_SUFFIX}") for q in self.second_order_names)
        return (*(name for pair in pairs for name in pair), *self.first_order_names)

    def _coordinate_names(self) -> tuple[str, ...]:
        return tuple(self.coordinates)

    def rate_names(self) -> tuple[str, ...]:
        """Names of the rates of all coordinates."""
        return tuple(f"{q}{RATE_SUFFIX}" for q in self.coordinates)

    def formulas(self) -> Mapping[str, Formula]:
        """The energies and the dissipation function."""
        return {name: formula.parse_formula(getattr(self, name), name) for name in _ENERGY_NAMES}

    @property
    def conservative(self) -> bool:
        """Whether the dissipation function is zero."""
        return bool(self.dissipation == "0")

    @property
    def is_time_reversible(self) -> bool:
        """Whether the kinetic energy is even in the rates, and nothing is lost."""
        rates = {name: 0.7 - 0.2 * k for k, name in enumerate(self.rate_names())}
        place = {name: x + 0.31 for name, x in self.rest_values().items()}
        ahead = self.energy_at("kinetic", place, rates)
        back = self.energy_at("kinetic", place, {name: -v for name, v in rates.items()})
        even = abs(ahead - back) <= _DEGREE_TOLERANCE * (abs(ahead) + abs(back))
        return self.conservative and even and not self.first_order_names

    def where_dissipative(self, values: Mapping[str, ArrayLike] | None = None) -> BoolArray:
        """Whether the dissipation function is not zero, near rest, for a batch of values."""
        p = {k: np.asarray((values or {}).get(k, v)) for k, v in self.parameter_values().items()}
        rest, found = self.rest_values(), np.zeros((), dtype=np.bool_)
        for offset in _DISSIPATION_OFFSETS:
            state = {k: x + offset * (1.0 + abs(x)) for k, x in rest.items()}
            rates = {name: 0.7 - 0.2 * k for k, name in enumerate(self.rate_names())}
            with np.errstate(all="ignore"):
                value = self.formulas()["dissipation"]({**p, **state, **rates}, np)
            found = found | (np.isfinite(value) & (np.asarray(value) != 0.0))
        return np.asarray(found)

    def _names_in_observable_rate(self) -> frozenset[str]:
        """The loads enter it where the observable has rates or internal variables."""
        smooth = {*self.second_order_names, *self.parameter_values()}
        if self.observable_formula.variable_names <= smooth:
            return frozenset()
        return self.formulas()["potential"].variable_names

    def _default_units(self, name: str, units: Mapping[str, str]) -> str:
        coordinate = name.removesuffix(RATE_SUFFIX)
        if coordinate == name or coordinate not in self.coordinates:
            return "1"
        time = units.get("time", "1")
        return (
            units.get(coordinate, "1") if time == "1" else f"{units.get(coordinate, '1')} {time}-1"
        )

    def _default_symbol(self, name: str, symbols: Mapping[str, str]) -> str:
        coordinate = name.removesuffix(RATE_SUFFIX)
        if coordinate != name and coordinate in self.coordinates:
            return (
                rf"\dot{{{symbols.get(coordinate, super()._default_symbol(coordinate, symbols))}}}"
            )
        return super()._default_symbol(name, symbols)

    def without_dissipation(self) -> Self:
        """The same energies with nothing lost, without parameters that only dissipation has."""
        kept = self.observable_formula.variable_names
        for name in ("kinetic", "potential"):
            kept |= self.formulas()[name].variable_names
        gone = {name for name in self.parameter_values() if name not in kept}
        pairs = {
            name: tuple(pair for pair in getattr(self, name) if pair[0] not in gone)
            for name in ("parameters", "units", "symbols")
        }
        return replace_fields(self, dissipation="0", **pairs)

    # The kinetic energy -------------------------------------------------------------------

    def energy_at(self, name: str, state: Mapping[str, float], rates: Mapping[str, float]) -> float:
        """One of the energies without loads; rates that are not named are 0."""
        values = {**self.parameter_values(), **state, **dict.fromkeys(self.load_names, 0.0)}
        values |= {**dict.fromkeys(self.rate_names(), 0.0), **rates}
        with np.errstate(all="ignore"):
            value = self.formulas()[name]({k: np.float64(x) for k, x in values.items()}, np)
        return float(value)

    def mass_matrix_at_rest(self) -> FloatArray:
        """d2T/dq'_i dq'_j of the coordinates of second order, exact for a quadratic T."""
        rest = self.rest_values()
        names = [f"{q}{RATE_SUFFIX}" for q in self.second_order_names]

        def energy(**rates: float) -> float:
            return self.energy_at("kinetic", rest, rates)

        at_rest = energy()
        mass = np.diag([energy(**{v: 1.0}) + energy(**{v: -1.0}) - 2.0 * at_rest for v in names])
        for (i, v), (j, w) in combinations(enumerate(names), 2):
            both = energy(**{v: 1.0, w: 1.0}) - energy(**{v: 1.0, w: -1.0})
            mass[i, j] = mass[j, i] = 0.5 * (both - 2.0 * _odd_part(energy, w))
        return mass


def _odd_part(energy: Any, name: str) -> float:
    """Half of the difference of the energies at rates 1 and -1: its linear term."""
    return float(0.5 * (energy(**{name: 1.0}) - energy(**{name: -1.0})))


def _require_quadratic(system: LagrangianSystem, name: str, rates: Sequence[str]) -> None:
    """Raise unless an energy is a polynomial of degree 2 in some rates, others being 0.

    Along any line of rates through zero a quadratic polynomial is fixed by three values; it is
    compared with the energy at others.
    """
    rng = np.random.default_rng(0)
    rest = system.rest_values()
    for _ in range(4):
        state = {k: x + 0.1 * (1.0 + abs(x)) * rng.uniform(-1.0, 1.0) for k, x in rest.items()}
        direction = rng.uniform(-1.0, 1.0, len(rates))

        def along(s: float, state: Any = state, direction: Any = direction) -> float:
            moved = {v: s * float(d) for v, d in zip(rates, direction, strict=True)}
            return system.energy_at(name, state, moved)

        low, mid, high = along(-1.0), along(0.0), along(1.0)
        for s in (2.0, -3.0):
            quadratic = mid + s * (high - low) / 2 + s**2 * (high + low - 2 * mid) / 2
            size = max(abs(along(s)), abs(low), abs(mid), abs(high), 1e-300)
            if np.isfinite(size) and not abs(along(s) - quadratic) <= _DEGREE_TOLERANCE * size:
                raise InputError(
                    name,
                    must=f"be at most quadratic in {', '.join(rates)}",
                    got=repr(getattr(system, name)),
                    why="Lagrange's equations are then linear in what they are solved for.",
                    fix="Put what depends on rates in another way into `dissipation` of a "
                    "coordinate with a mass, or write the equations as rm.FirstOrderSystem.",
                )


def _require_rates_determined(system: LagrangianSystem) -> None:
    """Raise where the mass matrix is singular, or nothing gives the rate of a coordinate."""
    in_dissipation = system.formulas()["dissipation"].variable_names
    for q in system.first_order_names:
        if f"{q}{RATE_SUFFIX}" not in in_dissipation:
            raise InputError(
                "kinetic",
                must=f"have a term in {q}{RATE_SUFFIX}, or the dissipation function must",
                got=repr(system.kinetic),
                why="Otherwise nothing says how the coordinate moves: the mass matrix is singular.",
                fix=f"Add for example {q}{RATE_SUFFIX}**2/2, or take {q} out of `coordinates`.",
            )
    mass = system.mass_matrix_at_rest()
    if not mass.size:
        return
    lowest, highest = np.linalg.eigvalsh(mass)[[0, -1]] if np.isfinite(mass).all() else (0.0, 0.0)
    if not lowest > _SINGULAR_SHARE * abs(highest):
        raise InputError(
            "kinetic",
            must="have a mass matrix with positive eigenvalues",
            got=f"the lowest is {lowest:g} at rest",
            why="Otherwise accelerations do not follow from forces.",
            fix="Give every coordinate a mass, or leave its rate out of the kinetic energy: it "
            "is then of first order.",
        )
