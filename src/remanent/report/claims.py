"""The audit: each statement of [Thermal], and the test that decides it.

A test looks at the evidence for one setting and says, for every reading of the
statement, whether it holds and by which numbers.  Whether the statement is supported,
contradicted, or depends on an unstated choice follows from the votes of all settings
that bring the published resonances back; see :func:`remanent.report.audit.audit`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from remanent._typing import FloatArray
from remanent.report import measures
from remanent.report.evidence import ClaimEvidence
from remanent.report.settings import FORCING_LAWS, FREQUENCIES, PRESTRESSES, RESONANCE_AGREEMENT

#: Depth of modulation from which a motion is said to beat.
_BEATING_DEPTH = 0.5
#: Late over early range of a history below which it is said to settle.
_SETTLED_RATIO = 0.9
#: Change of energy, in units of the estimated error, up to which it counts as none.
_ENERGY_ERRORS = 100.0
#: Excursion beyond the state of rest, in units of the estimated error, that counts as none.
_STRETCH_ERRORS = 10.0
#: Stretch below which a motion is said to be bounded.
_BOUND = 10.0
#: Growth of the separation of neighbours below which they are said to stay near.
_SEPARATION_GROWTH = 1.1


@dataclass(frozen=True)
class Finding:
    """Whether a statement holds for one setting and reading, and by which numbers."""

    holds: bool
    numbers: str


#: Findings by reading; a statement that can be read in one way has the reading "".
Findings = Mapping[str, Finding]


@dataclass(frozen=True)
class Claim:
    """A statement to audit.

    Attributes
    ----------
    id
        Number in the list of statements, with a letter where one was split.
    claim
        The statement, in our words.
    test
        ClaimEvidence in, findings out.
    figure
        Name of the picture that shows it.
    """

    id: str
    claim: str
    test: Callable[[ClaimEvidence], Findings]
    figure: str


def _finding(holds: bool | np.bool_, numbers: str) -> Findings:
    """The finding on a statement that can be read in one way."""
    return {"": Finding(bool(holds), numbers)}


def _format_list(values: FloatArray, digits: str = ".4f") -> str:
    """Values at the three temperatures."""
    return ", ".join(format(float(v), digits) for v in np.ravel(values))


def _falls(values: FloatArray) -> bool:
    return bool((np.diff(values) < 0).all())


def _by_prestress(values: FloatArray, digits: str = ".4f") -> str:
    rows = zip(PRESTRESSES, values, strict=True)
    return "; ".join(f"S = {s:g}: {_format_list(row, digits)}" for s, row in rows)


# Free oscillation under constant load ------------------------------------------------


def _closed_orbits(e: ClaimEvidence) -> Findings:
    change, error = measures.energy_change(e.constant), measures.values_by_case(e.constant, "error")
    bound = _ENERGY_ERRORS * error
    bounded = np.isfinite(measures.stretch_range(e.constant)).all()
    return _finding(
        bounded and (change <= bound).all(),
        "One degree of freedom, bounded, and the energy returns: its largest change over the "
        f"window is {change.max():.1e} at an estimated state error of {error.max():.1e}, so "
        "every motion runs round one level curve of the energy.",
    )


def _settles(e: ClaimEvidence) -> Findings:
    ratio = measures.late_range_ratio(e.constant)
    return _finding(
        (ratio < _SETTLED_RATIO).all(),
        "Range in the last quarter of the window over that in the first, T = 250, 350, 400 K: "
        f"{_by_prestress(ratio, '.6f')}. Nothing decays; the model has no dissipation.",
    )


def _amplitude_falls(row: int, e: ClaimEvidence) -> Findings:
    swing = measures.stretch_range(e.constant)[row]
    return _finding(
        _falls(swing), f"(max λ₃ − min λ₃)/2 at 250, 350, 400 K: {_format_list(swing)}."
    )


def _expansion_and_compression(e: ClaimEvidence) -> Findings:
    x = e.constant["thickness_stretch"]
    error = float(e.constant["error"].max())
    low = float(x.sel(prestress=0.0).min())
    high = float(x.sel(prestress=1.0).max())
    return _finding(
        low >= 1.0 - _STRETCH_ERRORS * error and high <= 1.0 + _STRETCH_ERRORS * error,
        f"From rest at λ₃ = 1 the least λ₃ at S = 0 is {low:.6f}, the largest at S = 1 is "
        f"{high:.6f}, over all temperatures.",
    )


def _modulus_falls(e: ClaimEvidence) -> Findings:
    frequency = e.unloaded["natural_frequency"].isel(equilibrium=0).values
    modulus = frequency**2 * (1.0 + 2.0 * e.setting.actuator.c) / 18.0
    return _finding(
        _falls(modulus),
        "Small-strain shear modulus over μ, from the natural frequency of the unloaded block "
        f"at 250, 350, 400 K: {_format_list(modulus)} = T/T₀. An entropic elastomer stiffens.",
    )


def _extreme(e: ClaimEvidence, row: int) -> FloatArray:
    """λ₃ farthest from 1 in each history, array (temperature,)."""
    x = e.constant["thickness_stretch"].isel(prestress=row).transpose("temperature", "time")
    farthest = np.abs(x.values - 1.0).argmax(axis=-1)
    return np.asarray(np.take_along_axis(x.values, farthest[:, None], axis=-1)[:, 0])


def _thickness_falls(row: int, kind: str, e: ClaimEvidence) -> Findings:
    stretch = (
        measures.values_by_case(e.landscape, "equilibrium_stretch")[row]
        if kind == "equilibrium"
        else _extreme(e, row)
    )
    return _finding(_falls(stretch), f"λ₃ at {kind}, 250, 350, 400 K: {_format_list(stretch)}.")


def _prestress_deforms_more(e: ClaimEvidence) -> Findings:
    strain = np.abs(measures.values_by_case(e.landscape, "equilibrium_stretch") - 1.0)
    holds = (strain[1] > strain[0]).all()
    return _finding(holds, f"|λ₃ − 1| at equilibrium: {_by_prestress(strain)}.")


# Resonances ------------------------------------------------------------------------------


def _resonances(e: ClaimEvidence) -> FloatArray:
    return measures.values_by_case(e.response, "resonance")


def _peaks(e: ClaimEvidence) -> FloatArray:
    return measures.values_by_case(e.response, "resonance_amplitude")


def _resonance_rises(e: ClaimEvidence) -> Findings:
    omega = _resonances(e)
    return _finding(
        (np.diff(omega, axis=1) > 0).all(), f"ω of the largest λ₃ᵃ: {_by_prestress(omega)}."
    )


def _six_frequencies(e: ClaimEvidence) -> Findings:
    difference = _resonances(e) - measures.values_by_case(e.response, "published")
    reference = Finding(
        bool((np.abs(difference) <= RESONANCE_AGREEMENT).all()),
        f"Computed minus published: {_by_prestress(difference, '+.4f')}.",
    )
    alternatives = {
        f"forcing law {FORCING_LAWS[law].text}": Finding(
            misfit <= RESONANCE_AGREEMENT,
            f"The best choice of b₀, T₀ and window still misses by {misfit:.4f}."
            if misfit > RESONANCE_AGREEMENT
            else f"The best choice of b₀, T₀ and window comes within {misfit:.4f}.",
        )
        for law, misfit in e.misfits.items()
        if law != e.setting.law
    }
    return {f"forcing law {FORCING_LAWS[e.setting.law].text}": reference, **alternatives}


def _intensity_falls(e: ClaimEvidence) -> Findings:
    peak = _peaks(e)[0]
    return _finding(_falls(peak), f"Largest λ₃ᵃ at 250, 350, 400 K: {_format_list(peak)}.")


def _intensity_rises_then_falls(e: ClaimEvidence) -> Findings:
    peak = _peaks(e)[1]
    holds = peak[1] > peak[0] and peak[2] < peak[1]
    return _finding(holds, f"Largest λ₃ᵃ at 250, 350, 400 K: {_format_list(peak)}.")


def _peaks_compared(e: ClaimEvidence) -> Findings:
    free, prestressed = _peaks(e)
    holds = free[0] > prestressed[0] and free[1] < prestressed[1] and free[2] > prestressed[2]
    return _finding(holds, f"Largest λ₃ᵃ: {_by_prestress(np.array([free, prestressed]))}.")


def _higher_frequency(row: int, e: ClaimEvidence) -> Findings:
    omega = _resonances(e)
    return _finding((omega[row] > omega[1 - row]).all(), f"Resonances: {_by_prestress(omega)}.")


def _heat_damps(e: ClaimEvidence) -> Findings:
    change, error = measures.energy_change(e.constant), measures.values_by_case(e.constant, "error")
    energy = e.constant["energy"].transpose("prestress", "temperature", "time").values
    lost = energy[..., 0] - energy[..., -1]
    return _finding(
        bool(
            (np.diff(lost, axis=1) > 0).all()
            and (lost[:, -1] > _ENERGY_ERRORS * error[:, -1]).all()
        ),
        f"Energy lost over the window: {_by_prestress(lost, '.1e')}; largest change of either "
        f"sign {change.max():.1e}. The equation of motion has no dissipative term at any "
        "temperature; amplitudes fall because the entropic stiffness grows.",
    )


# Beating -----------------------------------------------------------------------------------


def _beats_at_resonance(e: ClaimEvidence) -> Findings:
    depth = measures.beating_depth(e.motion, 0.0)
    return _finding(
        depth[1] >= _BEATING_DEPTH,
        f"Depth of modulation (a_max − a_min)/(a_max + a_min) of the local amplitude at 250, "
        f"350, 400 K, ω = {FREQUENCIES[0]:g}, S = 0: {_format_list(depth, '.2f')}.",
    )


def _beats_nowhere_else(e: ClaimEvidence) -> Findings:
    depth = measures.beating_depth(e.motion, 0.0)
    return _finding(
        max(depth[0], depth[2]) < _BEATING_DEPTH,
        f"Depth of modulation at 250 and 400 K: {_format_list(depth[[0, 2]], '.2f')}"
        f", against {depth[1]:.2f} at 350 K. Undamped motion from rest holds the free "
        "oscillation beside the forced one and beats at every temperature.",
    )


def _beats_near_natural(e: ClaimEvidence) -> Findings:
    natural = measures.values_by_case(e.mean, "natural_frequency")[0]
    load = 2.0 * FREQUENCIES[0]
    detuning = np.abs(natural - load)
    return {
        "frequency of the load, 2ω": Finding(
            int(detuning.argmin()) == 1,
            "Natural frequencies about the mean load at 250, 350, 400 K: "
            f"{_format_list(natural, '.3f')}; the load oscillates at 2ω = {load:g}.",
        ),
        "frequency of the flux, ω": Finding(
            int(np.abs(natural - load / 2).argmin()) == 1,
            f"The flux oscillates at ω = {load / 2:g}, nearest to {natural.min():.3f}.",
        ),
    }


# Regimes -----------------------------------------------------------------------------------


def _regimes(e: ClaimEvidence, row: int) -> tuple[list[str], str]:
    """Regimes at the three temperatures, and the evidence for them."""
    dataset = e.regimes.isel(prestress=row).transpose("temperature", ...)
    regimes = [str(name) for name in dataset["regime"].values]
    exponents = ", ".join(
        f"{float(exponent):.1e} ± {float(error):.1e}"
        for exponent, error in zip(dataset["exponent"], dataset["exponent_error"], strict=True)
    )
    return regimes, (
        f"At S = {PRESTRESSES[row]:g}, ω = {FREQUENCIES[row]:g}, T = 250, 350, 400 K the motion is "
        f"{', '.join(regimes)}, judged after "
        f"{_format_list(dataset['run_periods'].values, '.0f')} drive periods. "
        f"Lyapunov exponents {exponents}; weighted averages agree to "
        f"{_format_list(dataset['digits'].values, '.1f')} digits; turns per period "
        f"{_format_list(dataset['rotation_number'].values)}, known to "
        f"{_format_list(dataset['rotation_digits'].values, '.1f')} digits. "
        "The weakest evidence clears its line by the factors "
        f"{_format_list(dataset['margin'].values, '.2f')}."
    )


def _aperiodic_at_resonance(row: int, e: ClaimEvidence) -> Findings:
    regimes, numbers = _regimes(e, row)
    return _finding(regimes[1] == "chaotic", numbers)


def _quasi_periodic_elsewhere(row: int, e: ClaimEvidence) -> Findings:
    regimes, numbers = _regimes(e, row)
    return _finding(regimes[0] == regimes[2] == "quasi-periodic", numbers)


def _transition(e: ClaimEvidence) -> Findings:
    regimes = [_regimes(e, row)[0] for row in range(len(PRESTRESSES))]
    counts = Counter(name for row in regimes for name in row)
    holds = all(row == ["quasi-periodic", "chaotic", "quasi-periodic"] for row in regimes)
    numbers = ", ".join(f"{number} {name}" for name, number in counts.most_common())
    return _finding(
        holds, f"Of the six motions: {numbers}. Temperature moves them from one curve to another."
    )


def _settles_faster(e: ClaimEvidence) -> Findings:
    ratio = measures.late_range_ratio(e.constant)
    return _finding(
        (ratio[0] < _SETTLED_RATIO).all() and (ratio[0] < ratio[1]).all(),
        f"Range in the last quarter over that in the first: {_by_prestress(ratio, '.6f')}. "
        "Neither settles.",
    )


def _bounded_is_stable(e: ClaimEvidence) -> Findings:
    growth = measures.separation_growth(e.section, e.neighbour)
    ratio = measures.late_range_ratio(e.motion)
    largest = float(e.section["stretch"].max())
    return {
        "stable means bounded": Finding(
            bool(np.isfinite(e.section["stretch"].values).all() and largest < _BOUND),
            f"All six stay below λ = {largest:.3f} over {e.section.sizes['period'] - 1} periods.",
        ),
        "stable means that neighbours stay near": Finding(
            bool((growth < _SEPARATION_GROWTH).all()),
            f"The separation of neighbours grows without bound, in proportion to time: "
            f"{_by_prestress(growth, '.2f')} from the first half to the whole.",
        ),
        "stable means that disturbances die out": Finding(
            bool((ratio < _SETTLED_RATIO).all()),
            f"Range in the last quarter over that in the first: {_by_prestress(ratio, '.2f')}; "
            "an area-preserving map has no attractors.",
        ),
    }


#: Ends several claims.
_HOT = "as the temperature rises"
#: Every claim, in the order of [Thermal].
CLAIMS: tuple[Claim, ...] = (
    Claim("1", "Under constant load the motion is a closed orbit for every temperature and S.",
          _closed_orbits, "figure_3"),
    Claim("2", "The actuator oscillates towards a final equilibrium and settles there.",
          _settles, "figure_2"),
    Claim("3a", f"The oscillation amplitude falls {_HOT}, S = 0.",
          partial(_amplitude_falls, 0), "landscapes"),
    Claim("3b", f"The oscillation amplitude falls {_HOT}, S = 1.",
          partial(_amplitude_falls, 1), "landscapes"),
    Claim("4", "Without prestress the block thickens (λ₃ > 1), with S = 1 it thins (λ₃ < 1).",
          _expansion_and_compression, "figure_3"),
    Claim("5", f"The elastic modulus falls {_HOT}.", _modulus_falls, "landscapes"),
    *(
        Claim(f"6{letter}", f"The thickness stretch at {kind} falls {_HOT}, S = {s:g}.",
              partial(_thickness_falls, row, kind), "landscapes")
        for letter, (row, s, kind) in zip("abcd", [
            (row, s, kind) for row, s in enumerate(PRESTRESSES)
            for kind in ("equilibrium", "the extreme")], strict=True)
    ),
    Claim("7", "With prestress the block deforms more at equilibrium, at every temperature.",
          _prestress_deforms_more, "landscapes"),
    Claim("8a", f"The resonance frequency rises {_HOT}.", _resonance_rises, "figure_4"),
    Claim("8b", "The resonances are 1.05, 1.25, 1.35 (S = 0) and 0.85, 1.08, 1.19 (S = 1).",
          _six_frequencies, "figure_4"),
    Claim("9", f"The intensity at resonance falls {_HOT}, S = 0.", _intensity_falls, "figure_4"),
    Claim("10", f"The intensity at resonance first rises, then falls {_HOT}, S = 1.",
          _intensity_rises_then_falls, "figure_4"),
    Claim("11", "The peak at S = 0 is above that at S = 1 at 250 and 400 K, below it at 350 K.",
          _peaks_compared, "figure_4"),
    Claim("12a", "Without prestress the resonance lies at the higher frequency, at each T.",
          partial(_higher_frequency, 0), "figure_4"),
    Claim("12b", "With prestress the resonance lies at the higher frequency, at each T.",
          partial(_higher_frequency, 1), "figure_4"),
    Claim("13", "Higher temperature brings damping that dissipates energy.",
          _heat_damps, "tolerance"),
    Claim("14a", "The motion beats at resonance (350 K).", _beats_at_resonance, "figure_5"),
    Claim("14b", "At other temperatures, same frequency, the beating disappears.",
          _beats_nowhere_else, "figure_5"),
    Claim("14c", "The beating occurs because the drive is near the natural frequency.",
          _beats_near_natural, "figure_5"),
    Claim("15", "At 350 K, ω = 1.25, S = 0 the section is disordered: the motion is aperiodic.",
          partial(_aperiodic_at_resonance, 0), "tolerance"),
    Claim("16", "At 250 and 400 K, ω = 1.25, S = 0 the section is a closed curve: quasi-periodic.",
          partial(_quasi_periodic_elsewhere, 0), "tolerance"),
    Claim("17a", "At 350 K, ω = 1.08, S = 1 the motion is aperiodic.",
          partial(_aperiodic_at_resonance, 1), "tolerance"),
    Claim("17b", "At 250 and 400 K, ω = 1.08, S = 1 the section is a closed curve: quasi-periodic.",
          partial(_quasi_periodic_elsewhere, 1), "tolerance"),
    Claim("18", "Temperature drives a transition between aperiodic and quasi-periodic motion.",
          _transition, "tolerance"),
    Claim("19", "Without prestress the actuator settles faster.", _settles_faster, "figure_2"),
    Claim("20", "Bounded phase portraits show that the vibration is stable.",
          _bounded_is_stable, "figure_5"),
)  # fmt: skip
