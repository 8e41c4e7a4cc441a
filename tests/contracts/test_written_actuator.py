"""An actuator written by hand as formulas gives what `Actuator` gives, within both errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent._instructions import program_cost
from remanent.codegen.field import vector_field_for
from remanent.models.system import System
from tests.contracts.sound_calls import ACTUATOR_ONLY, OF_DATA_ONLY, verbs
from tests.repetitions import fast_and_slow

DRIVE = rm.SineSquared(0.4, 1.25)
#: Numbers of the block of one coordinate.
NUMBERS = {"c": 1.0, "temperature": 350.0, "reference_temperature": 293.0, "prestress": 0.1}


def written(eta: float, **numbers: float) -> rm.LagrangianSystem:
    """One coordinate: energies per 8 H L^2 mu of equal stretches."""
    system = rm.LagrangianSystem(
        coordinates="stretch",
        kinetic="stretch_rate**2/3 + 2*c*stretch_rate**2/(3*stretch**6)",
        potential="temperature/reference_temperature*(2*stretch**2 + stretch**-4 - 3)/2"
        " - load/stretch**2 - 2*prestress*(stretch - 1)",
        dissipation="eta*stretch_rate**2",
        parameters={**NUMBERS, "eta": eta, **numbers},
        observable="stretch**-2",
        rest={"stretch": 1.0},
    )
    return system if eta else system.without_dissipation()


def built(eta: float, **numbers: float) -> rm.Actuator:
    """The same block."""
    body = rm.Actuator(dissipation=rm.Rayleigh(eta) if eta else ())
    return body.replace(**{**NUMBERS, **numbers})


WRITTEN, BUILT = written(0.05), built(0.05)
#: Two coordinates, of unequal dead loads.
BUILT_PAIR = rm.Actuator(prestress=(0.1, 0.05), dissipation=rm.Rayleigh(0.1))
WRITTEN_PAIR = rm.LagrangianSystem(
    coordinates=("stretch_1", "stretch_2"),
    kinetic="(stretch_1_rate**2 + stretch_2_rate**2 + c*(stretch_1_rate*stretch_2"
    " + stretch_2_rate*stretch_1)**2/(stretch_1*stretch_2)**4)/6",
    potential="(stretch_1**2 + stretch_2**2 + 1/(stretch_1*stretch_2)**2 - 3)/2"
    " - load/(stretch_1*stretch_2) - s_1*(stretch_1 - 1) - s_2*(stretch_2 - 1)",
    dissipation="eta*(stretch_1_rate**2 + stretch_2_rate**2)/2",
    parameters={"c": 1.0, "s_1": 0.1, "s_2": 0.05, "eta": 0.1},
    observable="1/(stretch_1*stretch_2)",
    rest={"stretch_1": 1.0, "stretch_2": 1.0},
)
BOX = {"stretch": (0.5, 2.5), "stretch_rate": (-2.0, 2.0)}
PAIR_BOX = {
    "stretch_1": (0.7, 1.5), "stretch_1_rate": (-0.5, 0.5),
    "stretch_2": (0.7, 1.5), "stretch_2_rate": (-0.5, 0.5),
}  # fmt: skip

SPAN = {"stretch": (0.3, 4.0)}
#: A fold, and a branch that doubles.
HOT, FOLDING = {"prestress": 0.0}, rm.SineSquared(0.4, 1.2668)
COLD, FAST = {"temperature": 293.0, "prestress": 0.0}, rm.SineSquared(0.8, 2.4)
#: Verbs that do not take long of one coordinate, and of two.
QUICK_ONES = {
    "simulate", "poincare_section", "rates", "crossings", "energy_balance", "frequency_response",
    "equilibria", "snap_through", "periodic_orbits", "fit", "sensitivity", "logarithmic_decrement",
}  # fmt: skip
QUICK_PAIRS = {"poincare_section", "rates", "simulate"}
#: Words that are to be the same.
EQUAL = "equal"


@dataclass(frozen=True)
class Case:
    """A call of a verb, and what of its results is compared.

    Attributes
    ----------
    call : callable
        Of a system, and of the name that it has for the viscosity.
    compared : mapping of str to str or float
        Variables with the names of their errors, a bound of the difference, or `EQUAL`.
    eta, numbers : float, mapping
        Of the block.
    pair : bool
        Whether two coordinates are compared too.
    own : mapping
        Arguments that a system of one's own needs besides.
    """

    call: Callable[..., xr.Dataset]
    compared: Mapping[str, str | float]
    eta: float = 0.05
    numbers: Mapping[str, float] = field(default_factory=dict)
    pair: bool = False
    own: Mapping[str, Any] = field(default_factory=dict)


def box_of(system: System) -> dict[str, tuple[float, float]]:
    return PAIR_BOX if system in (WRITTEN_PAIR, BUILT_PAIR) else BOX


def first_of(system: System) -> str:
    return next(iter(box_of(system)))


def eta_of(system: System) -> str:
    return "eta" if isinstance(system, rm.LagrangianSystem) else "dissipation.0.eta"


def at_six(system: System) -> rm.Measure:
    return rm.Measure(rm.simulate, system, DRIVE, times=[6.0], of=first_of(system))


@cache
def ringing() -> xr.Dataset:
    """A motion that is measured."""
    return rm.simulate(BUILT, rm.Constant(0.3), times=np.linspace(0.0, 8.0, 30))[["stretch"]]


@cache
def branch_of(system: System) -> xr.Dataset:
    return rm.continue_orbit(system, FAST, "omega", (2.25, 2.45), state_box=BOX)


#: Of every verb that makes no use of what only an actuator has.
CASES: dict[str, Case] = {
    "simulate": Case(
        lambda s: rm.simulate(s, DRIVE, duration=20.0),
        {"stretch": "error", "energy": "error", "load": "error"}, pair=True,
    ),
    "poincare_section": Case(
        lambda s: rm.poincare_section(s, DRIVE, periods=20), {"stretch": "error"}, pair=True,
    ),
    "rates": Case(
        lambda s: as_dataset(rm.rates(s, DRIVE)(0.7, [1.1, 0.2, 0.9, -0.1][: 2 * len(names(s))])),
        {"value": 1e-12}, pair=True,
    ),
    "period_map": Case(
        lambda s: as_dataset(rm.period_map(s, DRIVE)([1.1, 0.0] * len(names(s))).images),
        {"value": 1e-8}, pair=True,
    ),
    "crossings": Case(
        lambda s: rm.crossings(s, DRIVE, "stored_energy", 0.01, duration=20.0),
        {"crossing_time": "crossing_time_error"}, pair=True,
    ),
    "energy_balance": Case(
        lambda s: rm.energy_balance(s, DRIVE, duration=10.0),
        {"drive_work": "drive_work_error", "dissipated_energy": "dissipated_energy_error"},
        pair=True,
    ),
    "cycle_losses": Case(
        lambda s: rm.cycle_losses(s, DRIVE, periods=5),
        {"dissipated_energy": "dissipated_energy_error"}, pair=True,
    ),
    "lyapunov": Case(
        lambda s: rm.lyapunov(s, DRIVE, periods=60), {"exponent": "exponent_error"}, pair=True,
    ),
    "classify": Case(
        lambda s: rm.classify(s, DRIVE, periods=200),
        {"exponent": "exponent_error", "regime": EQUAL, "period": EQUAL}, pair=True,
    ),
    "regime_chart": Case(
        lambda s: rm.regime_chart(s, DRIVE, {"b": [0.2, 0.4], "c": [0.8, 1.0]}, periods=100),
        {"regime": EQUAL, "period": EQUAL}, pair=True,
    ),
    "basins": Case(
        lambda s: rm.basins(s, DRIVE, {first_of(s): [0.9, 1.1]}, periods=200),
        {"basin": EQUAL, "attractor_period": EQUAL, "attractor_state": 1e-6}, pair=True,
    ),
    "bifurcation_diagram": Case(
        lambda s: rm.bifurcation_diagram(s, DRIVE, "b", [0.3, 0.4], discard=200, keep=2),
        {"stretch": 1e-6}, pair=True,
    ),
    "frequency_response": Case(
        lambda s: rm.frequency_response(s, DRIVE, np.linspace(1.0, 1.4, 9), duration=40.0),
        {"amplitude": "amplitude_error", "resonance": "resonance_error"}, pair=True,
    ),
    "resonances": Case(
        lambda s: rm.resonances(s, DRIVE, (1.1, 1.4), state_box=BOX, slices=1),
        {
            **{name: f"{name}_error" for name in (
                "omega", "amplitude", "phase_lag", "share", "free_frequency", "detuning",
            )},
            **dict.fromkeys(("resonance_kind", "order_p", "order_q"), EQUAL),
        },
    ),
    "backbone": Case(
        lambda s: rm.backbone(s, [1.2, 2.0]),
        {"frequency": "frequency_error", "maximum": "error", "amplitude": "amplitude_error"},
        eta=0.0,
    ),
    "equilibria": Case(
        lambda s, **own: rm.equilibria(s, over={"m": [-0.3, 0.0, 0.16]}, **own),
        {"stretch": "stretch_error", "natural_frequency": "natural_frequency_error",
         "stability": EQUAL},
        pair=True, own={"state_box": SPAN},
    ),
    "snap_through": Case(
        lambda s, **own: rm.snap_through(s, "m", (-1.0, 8.0), initial=2.0, **own),
        {
            **{name: f"{name}_error" for name in (
                "fold_m", "fold_stretch", "fold_thickness_stretch",
                "snap_m", "snap_stretch", "snap_thickness_stretch",
            )},
            "snap_direction": EQUAL,
        },
        eta=0.0, numbers={"prestress": 2.2, "temperature": 293.0}, own={"state_box": SPAN},
    ),
    "periodic_orbits": Case(
        lambda s: rm.periodic_orbits(s, DRIVE, state_box=box_of(s)),
        {"initial": "error", "amplitude": "amplitude_error", "stability": EQUAL}, pair=True,
    ),
    "continue_orbit": Case(
        lambda s: ends(rm.continue_orbit(s, DRIVE, "omega", (1.1, 1.5), state_box=box_of(s))),
        {"amplitude": "amplitude_error", "omega": 1e-12, "special_omega": "special_error",
         "special_kind": EQUAL},
        pair=True,
    ),
    "response_diagram": Case(
        lambda s: rm.response_diagram(s, DRIVE, (1.1, 1.4), slices=1, state_box=BOX),
        {"special_omega": "special_error", "special_kind": EQUAL},
    ),
    "switch_branch": Case(
        lambda s: rm.switch_branch(branch_of(s), 1, max_points=20, state_box=BOX),
        {"special_omega": "special_error", "special_kind": EQUAL}, eta=0.01, numbers=COLD,
    ),
    "locate_bifurcation": Case(
        lambda s: rm.locate_bifurcation(s, FOLDING, "fold", "omega", initial=(1.2268, 0.0)),
        {"omega": "omega_error", "stretch": "error"}, eta=0.0, numbers=HOT,
    ),
    "continue_bifurcation": Case(
        lambda s: ends(rm.continue_bifurcation(
            s, FOLDING, "fold", ("omega", "b"), [(1.24, 1.28), (0.38, 0.42)],
            initial=(1.2268, 0.0), state_box=BOX,
        )),
        {"omega": "error", "b": "error"}, eta=0.0, numbers=HOT,
    ),
    "manifold_crossing": Case(
        lambda s: rm.manifold_crossing(
            s, DRIVE, "omega", (1.25, 1.26), saddle=(1.433, 0.0), width=1e-4
        ),
        {"omega": "omega_error"}, eta=0.0, numbers=HOT,
    ),
    "fit": Case(
        lambda s: rm.fit(s, rm.Constant(0.3), ringing(), {eta_of(s): 0.06, "c": 0.9}),
        {"estimate": 1e-6, "noise": 1e-7},
    ),
    "sensitivity": Case(
        lambda s: rm.sensitivity(at_six(s), parameters=["c", "b"]),
        {"derivative": "derivative_error", "elasticity": "elasticity_error"}, pair=True,
    ),
    "design": Case(
        lambda s: rm.design(at_six(s), targets=1.05, parameters="b"),
        {"solution": "solution_error"}, pair=True,
    ),
    "uncertainty": Case(
        lambda s: rm.uncertainty(at_six(s), parameter_ranges={"b": (0.38, 0.42)}, samples=256),
        {"average": "average_error", "deviation": "deviation_error"}, pair=True,
    ),
    "logarithmic_decrement": Case(
        lambda s: rm.logarithmic_decrement(
            rm.simulate(s, rm.Constant(0.3), duration=60.0), first_of(s)
        ),
        {"decrement": "decrement_error", "frequency": "frequency_error"},
    ),
}  # fmt: skip
#: What only an actuator has, and a word of the message that says so.
REFUSED: dict[str, tuple[Callable[[System], object], str]] = {
    "shape_command": (lambda s: rm.shape_command(s, 1.1), "`actuator` must be an actuator"),  # type: ignore[arg-type]
    "shape_commands": (lambda s: rm.shape_commands(s, 1.1), "`actuator` must be an actuator"),  # type: ignore[arg-type]
    "step_response": (
        lambda s: rm.step_response(s, rm.Steps((0.0,), (0.1,)), duration=5.0),
        "`system` must be an actuator",
    ),
    "symmetry_check": (lambda s: rm.symmetry_check(s, DRIVE), "`system` must be an actuator"),
    "to_si": (lambda s: rm.to_si(rm.simulate(s, DRIVE, duration=1.0)), "`dataset` must"),
    "rescale": (
        lambda s: rm.rescale(rm.simulate(s, DRIVE, duration=1.0), temperature=300.0),
        "must be an Actuator",
    ),
}


def names(system: System) -> list[str]:
    """The coordinates."""
    return [name for name in box_of(system) if not name.endswith("_rate")]


def as_dataset(values: Any) -> xr.Dataset:
    return xr.Dataset({"value": (("k",), np.ravel(values)), "status": ((), 1)})


def ends(branch: xr.Dataset) -> xr.Dataset:
    """The ends of a curve, which lie where the range of a parameter ends, in their order."""
    last = branch.isel(point=[0, -1])
    return last.isel(point=np.argsort(last.omega.values, kind="stable"))


def assert_alike(one: xr.Dataset, other: xr.Dataset, compared: Mapping[str, str | float]) -> None:
    """Variables of a written system and of an actuator agree, most within both errors."""
    if "status" in other:
        np.testing.assert_array_equal(one.status, other.status)
    known = 0
    for name, error in compared.items():
        for mine, theirs in same_variables(other, name):
            a, b = one[mine], other[theirs]
            assert a.shape == b.shape, name
            if error == EQUAL:
                np.testing.assert_array_equal(a, b, err_msg=name)
                continue
            slack = 1e-12 * (1.0 + np.abs(b.values))
            if isinstance(error, str):
                errors = (one[error.replace(name, mine)], other[error.replace(name, theirs)])
                for own in errors:
                    slack = slack + own.values.reshape(own.shape + (1,) * (a.ndim - own.ndim))
            else:
                slack = slack + error
            np.testing.assert_array_equal(np.isnan(a), np.isnan(b), err_msg=name)
            known += int(np.isfinite(a).sum())
            left = np.abs(a.values - b.values) - slack
            assert (np.nan_to_num(left) <= 0.0).all(), name
    assert known or set(compared.values()) == {EQUAL}  # something was compared


def same_variables(other: xr.Dataset, name: str) -> list[tuple[str, str]]:
    """The names of a variable in results of a written system and of an actuator.

    Two coordinates have a number each.
    """
    if name in other:
        return [(name.replace("thickness_stretch", "observable"), name)]
    both = [(f"{name}_{k}", f"{name}_{k}") for k in (1, 2)]
    assert all(theirs in other for _, theirs in both), name
    return both


def called(case: Case, system: System) -> xr.Dataset:
    own = case.own if isinstance(system, rm.LagrangianSystem) else {}
    return case.call(system, **own)


@pytest.mark.parametrize("name", fast_and_slow(list(CASES), QUICK_ONES))
def test_a_written_actuator_of_one_coordinate(name: str) -> None:
    """Lagrange's equations from the energies alone."""
    case = CASES[name]
    systems: tuple[System, ...] = (WRITTEN, BUILT)
    if case.eta != 0.05 or case.numbers:
        systems = (written(case.eta, **case.numbers), built(case.eta, **case.numbers))
    one, other = (called(case, system) for system in systems)
    assert_alike(one, other, case.compared)


@pytest.mark.parametrize(
    "name", fast_and_slow([n for n, case in CASES.items() if case.pair], QUICK_PAIRS)
)
def test_a_written_actuator_of_two_coordinates(name: str) -> None:
    """The same of a pair of coupled coordinates."""
    case = CASES[name]
    if name == "equilibria":
        case = replace(case, own={"state_box": {"stretch_1": (0.3, 4.0), "stretch_2": (0.3, 4.0)}})
    one, other = (called(case, system) for system in (WRITTEN_PAIR, BUILT_PAIR))
    assert_alike(one, other, case.compared)


@pytest.mark.parametrize("name", REFUSED)
def test_what_needs_an_actuator_says_so(name: str) -> None:
    """By the name of the argument, with the reason."""
    call, message = REFUSED[name]
    with pytest.raises(rm.InputError, match=message) as caught:
        call(WRITTEN)
    assert "ctuator" in str(caught.value)


def test_every_verb_is_compared_or_refuses() -> None:
    """A new verb takes a written system, or says by name why it does not."""
    every = {*verbs(), "rates", "period_map"}
    assert set(REFUSED) == ACTUATOR_ONLY
    assert sorted(every) == sorted({*CASES, *REFUSED, *OF_DATA_ONLY})


def drawn(artists: Any) -> list[Any]:
    """The numbers that lines are drawn at."""
    lines = [np.asarray(line.get_xydata(), dtype=float) for line in artists]
    plt.close("all")
    return lines


#: Pictures of results, by the verb that makes them.
PICTURES: dict[str, Callable[[xr.Dataset], Any]] = {
    "simulate": rm.plot.history,
    "frequency_response": rm.plot.response,
    "equilibria": rm.plot.equilibria,
    "continue_orbit": rm.plot.multipliers,
    "fit": rm.plot.fit,
    "backbone": lambda ds: rm.plot.curve(ds, "frequency", "amplitude"),
}


@pytest.mark.parametrize("name", PICTURES)
def test_pictures_of_a_written_actuator(name: str) -> None:
    """They are drawn at the same numbers, under other names."""
    case = CASES[name]
    systems = (written(case.eta), built(case.eta))
    one, other = (drawn(PICTURES[name](called(case, system))) for system in systems)
    assert len(one) == len(other) > 0
    for mine, yours in zip(one, other, strict=True):
        np.testing.assert_allclose(mine, yours, rtol=1e-6, atol=1e-6)


def test_the_code_of_a_written_actuator_is_short() -> None:
    """No longer than that of the block, of one coordinate and of two."""
    for written, built in ((WRITTEN, BUILT), (WRITTEN_PAIR, BUILT_PAIR)):
        one, other = (program_cost(vector_field_for(s, DRIVE).rates) for s in (written, built))
        assert one <= other
