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
from remanent.report.settings import (
    FORCING_LAWS,
    MAX_RESONANCE_MISFIT,
    MOTION_FREQUENCIES,
    PRESTRESSES,
)

#: Depth of modulation from which a motion is said to beat.
_MIN_BEATING_DEPTH = 0.5
#: Late over early range of a history below which it is said to settle.
_MAX_SETTLED_RANGE_RATIO = 0.9
#: Change of energy, in units of the estimated error, up to which it counts as none.
_MAX_ENERGY_CHANGE_IN_ERRORS = 100.0
#: Excursion beyond the state of rest, in units of the estimated error, that counts as none.
_MAX_STRETCH_EXCURSION_IN_ERRORS = 10.0
#: Stretch below which a motion is said to be bounded.
_MAX_BOUNDED_STRETCH = 10.0
#: Growth of the separation of neighbours below which they are said to stay near.
_MAX_NEAR_SEPARATION_GROWTH = 1.1


@dataclass(frozen=True)
class Finding:
    """Whether a statement holds for one setting and reading, and by which numbers."""

    holds: bool
    numbers_text: str


#: FindingsByReading by reading; a statement that can be read in one way has the reading "".
FindingsByReading = Mapping[str, Finding]


@dataclass(frozen=True)
class Claim:
    """A statement to audit.

    Attributes
    ----------
    id
        Number in the list of statements, with a letter where one was split.
    statement
        The statement, in our words.
    test
        ClaimEvidence in, findings out.
    picture_name
        Name of the picture that shows it.
    """

    id: str
    statement: str
    test: Callable[[ClaimEvidence], FindingsByReading]
    picture_name: str


def _unambiguous_finding(holds: bool | np.bool_, numbers: str) -> FindingsByReading:
    """The finding on a statement that can be read in one way."""
    return {"": Finding(bool(holds), numbers)}


def _format_list(values: FloatArray, digits: str = ".4f") -> str:
    """Values at the three temperatures."""
    return ", ".join(format(float(v), digits) for v in np.ravel(values))


def _is_decreasing(values: FloatArray) -> bool:
    return bool((np.diff(values) < 0).all())


def _format_by_prestress(values: FloatArray, digits: str = ".4f") -> str:
    rows = zip(PRESTRESSES, values, strict=True)
    return "; ".join(f"S = {s:g}: {_format_list(row, digits)}" for s, row in rows)


# Free oscillation under constant load ------------------------------------------------


def _test_closed_orbits(e: ClaimEvidence) -> FindingsByReading:
    change, error = (
        measures.largest_energy_change(e.constant_load_motion),
        measures.array_by_prestress_and_temperature(e.constant_load_motion, "error"),
    )
    bound = _MAX_ENERGY_CHANGE_IN_ERRORS * error
    bounded = np.isfinite(measures.stretch_half_range(e.constant_load_motion)).all()
    return _unambiguous_finding(
        bounded and (change <= bound).all(),
        "One degree of freedom, bounded, and the energy returns: its largest change over the "
        f"window is {change.max():.1e} at an estimated state error of {error.max():.1e}, so "
        "every motion runs round one level curve of the energy.",
    )


def _test_settles(e: ClaimEvidence) -> FindingsByReading:
    ratio = measures.late_over_early_range(e.constant_load_motion)
    return _unambiguous_finding(
        (ratio < _MAX_SETTLED_RANGE_RATIO).all(),
        "Range in the last quarter of the window over that in the first, T = 250, 350, 400 K: "
        f"{_format_by_prestress(ratio, '.6f')}. Nothing decays; the model has no dissipation.",
    )


def _test_amplitude_falls_with_temperature(row: int, e: ClaimEvidence) -> FindingsByReading:
    swing = measures.stretch_half_range(e.constant_load_motion)[row]
    return _unambiguous_finding(
        _is_decreasing(swing), f"(max λ₃ − min λ₃)/2 at 250, 350, 400 K: {_format_list(swing)}."
    )


def _test_expansion_and_compression(e: ClaimEvidence) -> FindingsByReading:
    x = e.constant_load_motion["thickness_stretch"]
    error = float(e.constant_load_motion["error"].max())
    low = float(x.sel(prestress=0.0).min())
    high = float(x.sel(prestress=1.0).max())
    return _unambiguous_finding(
        low >= 1.0 - _MAX_STRETCH_EXCURSION_IN_ERRORS * error
        and high <= 1.0 + _MAX_STRETCH_EXCURSION_IN_ERRORS * error,
        f"From rest at λ₃ = 1 the least λ₃ at S = 0 is {low:.6f}, the largest at S = 1 is "
        f"{high:.6f}, over all temperatures.",
    )


def _test_modulus_falls_with_temperature(e: ClaimEvidence) -> FindingsByReading:
    frequency = e.unloaded_equilibria["natural_frequency"].isel(equilibrium=0).values
    modulus = frequency**2 * (1.0 + 2.0 * e.setting.actuator.c) / 18.0
    return _unambiguous_finding(
        _is_decreasing(modulus),
        "Small-strain shear modulus over μ, from the natural frequency of the unloaded block "
        f"at 250, 350, 400 K: {_format_list(modulus)} = T/T₀. An entropic elastomer stiffens.",
    )


def _farthest_stretches(e: ClaimEvidence, row: int) -> FloatArray:
    """λ₃ farthest from 1 in each history, array (temperature,)."""
    x = (
        e.constant_load_motion["thickness_stretch"]
        .isel(prestress=row)
        .transpose("temperature", "time")
    )
    farthest = np.abs(x.values - 1.0).argmax(axis=-1)
    return np.asarray(np.take_along_axis(x.values, farthest[:, None], axis=-1)[:, 0])


def _test_thickness_falls_with_temperature(
    row: int, kind: str, e: ClaimEvidence
) -> FindingsByReading:
    stretch = (
        measures.array_by_prestress_and_temperature(e.landscape, "equilibrium_stretch")[row]
        if kind == "equilibrium"
        else _farthest_stretches(e, row)
    )
    return _unambiguous_finding(
        _is_decreasing(stretch), f"λ₃ at {kind}, 250, 350, 400 K: {_format_list(stretch)}."
    )


def _test_prestress_deforms_more(e: ClaimEvidence) -> FindingsByReading:
    strain = np.abs(
        measures.array_by_prestress_and_temperature(e.landscape, "equilibrium_stretch") - 1.0
    )
    holds = (strain[1] > strain[0]).all()
    return _unambiguous_finding(holds, f"|λ₃ − 1| at equilibrium: {_format_by_prestress(strain)}.")


# Resonances ------------------------------------------------------------------------------


def _resonance_frequencies(e: ClaimEvidence) -> FloatArray:
    return measures.array_by_prestress_and_temperature(e.response, "resonance")


def _resonance_amplitudes(e: ClaimEvidence) -> FloatArray:
    return measures.array_by_prestress_and_temperature(e.response, "resonance_amplitude")


def _test_resonance_frequency_rises_with_temperature(e: ClaimEvidence) -> FindingsByReading:
    omega = _resonance_frequencies(e)
    return _unambiguous_finding(
        (np.diff(omega, axis=1) > 0).all(), f"ω of the largest λ₃ᵃ: {_format_by_prestress(omega)}."
    )


def _test_six_frequencies(e: ClaimEvidence) -> FindingsByReading:
    difference = _resonance_frequencies(e) - measures.array_by_prestress_and_temperature(
        e.response, "published"
    )
    reference = Finding(
        bool((np.abs(difference) <= MAX_RESONANCE_MISFIT).all()),
        f"Computed minus published: {_format_by_prestress(difference, '+.4f')}.",
    )
    alternatives = {
        f"forcing law {FORCING_LAWS[law].text}": Finding(
            misfit <= MAX_RESONANCE_MISFIT,
            f"The best choice of b₀, T₀ and window still misses by {misfit:.4f}."
            if misfit > MAX_RESONANCE_MISFIT
            else f"The best choice of b₀, T₀ and window comes within {misfit:.4f}.",
        )
        for law, misfit in e.least_misfits.items()
        if law != e.setting.law_name
    }
    return {f"forcing law {FORCING_LAWS[e.setting.law_name].text}": reference, **alternatives}


def _test_intensity_falls_with_temperature(e: ClaimEvidence) -> FindingsByReading:
    peak = _resonance_amplitudes(e)[0]
    return _unambiguous_finding(
        _is_decreasing(peak), f"Largest λ₃ᵃ at 250, 350, 400 K: {_format_list(peak)}."
    )


def _test_intensity_rises_then_falls(e: ClaimEvidence) -> FindingsByReading:
    peak = _resonance_amplitudes(e)[1]
    holds = peak[1] > peak[0] and peak[2] < peak[1]
    return _unambiguous_finding(holds, f"Largest λ₃ᵃ at 250, 350, 400 K: {_format_list(peak)}.")


def _test_peaks_compared(e: ClaimEvidence) -> FindingsByReading:
    free, prestressed = _resonance_amplitudes(e)
    holds = free[0] > prestressed[0] and free[1] < prestressed[1] and free[2] > prestressed[2]
    return _unambiguous_finding(
        holds, f"Largest λ₃ᵃ: {_format_by_prestress(np.array([free, prestressed]))}."
    )


def _test_higher_frequency(row: int, e: ClaimEvidence) -> FindingsByReading:
    omega = _resonance_frequencies(e)
    return _unambiguous_finding(
        (omega[row] > omega[1 - row]).all(), f"Resonances: {_format_by_prestress(omega)}."
    )


def _test_heat_damps(e: ClaimEvidence) -> FindingsByReading:
    change, error = (
        measures.largest_energy_change(e.constant_load_motion),
        measures.array_by_prestress_and_temperature(e.constant_load_motion, "error"),
    )
    energy = e.constant_load_motion["energy"].transpose("prestress", "temperature", "time").values
    lost = energy[..., 0] - energy[..., -1]
    return _unambiguous_finding(
        bool(
            (np.diff(lost, axis=1) > 0).all()
            and (lost[:, -1] > _MAX_ENERGY_CHANGE_IN_ERRORS * error[:, -1]).all()
        ),
        f"Energy lost over the window: {_format_by_prestress(lost, '.1e')}; largest change of "
        f"either sign {change.max():.1e}. The equation of motion has no dissipative term at any "
        "temperature; amplitudes fall because the entropic stiffness grows.",
    )


# Beating -----------------------------------------------------------------------------------


def _test_beats_at_resonance(e: ClaimEvidence) -> FindingsByReading:
    depth = measures.beating_depth(e.periodic_load_motion, 0.0)
    return _unambiguous_finding(
        depth[1] >= _MIN_BEATING_DEPTH,
        f"Depth of modulation (a_max − a_min)/(a_max + a_min) of the local amplitude at 250, "
        f"350, 400 K, ω = {MOTION_FREQUENCIES[0]:g}, S = 0: {_format_list(depth, '.2f')}.",
    )


def _test_beats_nowhere_else(e: ClaimEvidence) -> FindingsByReading:
    depth = measures.beating_depth(e.periodic_load_motion, 0.0)
    return _unambiguous_finding(
        max(depth[0], depth[2]) < _MIN_BEATING_DEPTH,
        f"Depth of modulation at 250 and 400 K: {_format_list(depth[[0, 2]], '.2f')}"
        f", against {depth[1]:.2f} at 350 K. Undamped motion from rest holds the free "
        "oscillation beside the forced one and beats at every temperature.",
    )


def _test_beats_near_natural(e: ClaimEvidence) -> FindingsByReading:
    natural = measures.array_by_prestress_and_temperature(
        e.mean_load_equilibria, "natural_frequency"
    )[0]
    load = 2.0 * MOTION_FREQUENCIES[0]
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


def _regimes_and_evidence_text(e: ClaimEvidence, row: int) -> tuple[list[str], str]:
    """Regimes at the three temperatures, and the evidence for them."""
    dataset = e.regimes.isel(prestress=row).transpose("temperature", ...)
    regimes = [str(name) for name in dataset["regime"].values]
    exponents = ", ".join(
        f"{float(exponent):.1e} ± {float(error):.1e}"
        for exponent, error in zip(dataset["exponent"], dataset["exponent_error"], strict=True)
    )
    return regimes, (
        f"At S = {PRESTRESSES[row]:g}, ω = {MOTION_FREQUENCIES[row]:g}, T = 250, 350, 400 K the "
        f"motion is {', '.join(regimes)}, judged after "
        f"{_format_list(dataset['run_periods'].values, '.0f')} drive periods. "
        f"Lyapunov exponents {exponents}; weighted averages agree to "
        f"{_format_list(dataset['digits'].values, '.1f')} digits; turns per period "
        f"{_format_list(dataset['rotation_number'].values)}, known to "
        f"{_format_list(dataset['rotation_digits'].values, '.1f')} digits. "
        "The weakest evidence clears its line by the factors "
        f"{_format_list(dataset['margin'].values, '.2f')}."
    )


def _test_aperiodic_at_resonance(row: int, e: ClaimEvidence) -> FindingsByReading:
    regimes, numbers = _regimes_and_evidence_text(e, row)
    return _unambiguous_finding(regimes[1] == "chaotic", numbers)


def _test_quasi_periodic_elsewhere(row: int, e: ClaimEvidence) -> FindingsByReading:
    regimes, numbers = _regimes_and_evidence_text(e, row)
    return _unambiguous_finding(regimes[0] == regimes[2] == "quasi-periodic", numbers)


def _test_transition(e: ClaimEvidence) -> FindingsByReading:
    regimes = [_regimes_and_evidence_text(e, row)[0] for row in range(len(PRESTRESSES))]
    counts = Counter(name for row in regimes for name in row)
    holds = all(row == ["quasi-periodic", "chaotic", "quasi-periodic"] for row in regimes)
    numbers = ", ".join(f"{number} {name}" for name, number in counts.most_common())
    return _unambiguous_finding(
        holds, f"Of the six motions: {numbers}. Temperature moves them from one curve to another."
    )


def _test_settles_faster(e: ClaimEvidence) -> FindingsByReading:
    ratio = measures.late_over_early_range(e.constant_load_motion)
    return _unambiguous_finding(
        (ratio[0] < _MAX_SETTLED_RANGE_RATIO).all() and (ratio[0] < ratio[1]).all(),
        f"Range in the last quarter over that in the first: {_format_by_prestress(ratio, '.6f')}. "
        "Neither settles.",
    )


def _test_bounded_is_stable(e: ClaimEvidence) -> FindingsByReading:
    growth = measures.separation_growth(e.section, e.neighbour_section)
    ratio = measures.late_over_early_range(e.periodic_load_motion)
    largest = float(e.section["stretch"].max())
    return {
        "stable means bounded": Finding(
            bool(np.isfinite(e.section["stretch"].values).all() and largest < _MAX_BOUNDED_STRETCH),
            f"All six stay below λ = {largest:.3f} over {e.section.sizes['period'] - 1} periods.",
        ),
        "stable means that neighbours stay near": Finding(
            bool((growth < _MAX_NEAR_SEPARATION_GROWTH).all()),
            f"The separation of neighbours grows without bound, in proportion to time: "
            f"{_format_by_prestress(growth, '.2f')} from the first half to the whole.",
        ),
        "stable means that disturbances die out": Finding(
            bool((ratio < _MAX_SETTLED_RANGE_RATIO).all()),
            "Range in the last quarter over that in the first: "
            f"{_format_by_prestress(ratio, '.2f')}; an area-preserving map has no attractors.",
        ),
    }


#: Ends several claims.
_AS_TEMPERATURE_RISES = "as the temperature rises"
#: Every claim, in the order of [Thermal].
CLAIMS: tuple[Claim, ...] = (
    Claim("1", "Under constant load the motion is a closed orbit for every temperature and S.",
          _test_closed_orbits, "figure_3"),
    Claim("2", "The actuator oscillates towards a final equilibrium and settles there.",
          _test_settles, "figure_2"),
    Claim("3a", f"The oscillation amplitude falls {_AS_TEMPERATURE_RISES}, S = 0.",
          partial(_test_amplitude_falls_with_temperature, 0), "landscapes"),
    Claim("3b", f"The oscillation amplitude falls {_AS_TEMPERATURE_RISES}, S = 1.",
          partial(_test_amplitude_falls_with_temperature, 1), "landscapes"),
    Claim("4", "Without prestress the block thickens (λ₃ > 1), with S = 1 it thins (λ₃ < 1).",
          _test_expansion_and_compression, "figure_3"),
    Claim("5", f"The elastic modulus falls {_AS_TEMPERATURE_RISES}.",
          _test_modulus_falls_with_temperature, "landscapes"),
    *(
        Claim(f"6{letter}", f"The thickness stretch at {kind} falls {_AS_TEMPERATURE_RISES}, "
              f"S = {s:g}.", partial(_test_thickness_falls_with_temperature, row, kind),
              "landscapes")
        for letter, (row, s, kind) in zip("abcd", [
            (row, s, kind) for row, s in enumerate(PRESTRESSES)
            for kind in ("equilibrium", "the extreme")], strict=True)
    ),
    Claim("7", "With prestress the block deforms more at equilibrium, at every temperature.",
          _test_prestress_deforms_more, "landscapes"),
    Claim("8a", f"The resonance frequency rises {_AS_TEMPERATURE_RISES}.",
          _test_resonance_frequency_rises_with_temperature, "figure_4"),
    Claim("8b", "The resonances are 1.05, 1.25, 1.35 (S = 0) and 0.85, 1.08, 1.19 (S = 1).",
          _test_six_frequencies, "figure_4"),
    Claim("9", f"The intensity at resonance falls {_AS_TEMPERATURE_RISES}, S = 0.",
          _test_intensity_falls_with_temperature, "figure_4"),
    Claim("10", f"The intensity at resonance first rises, then falls {_AS_TEMPERATURE_RISES}, "
          "S = 1.", _test_intensity_rises_then_falls, "figure_4"),
    Claim("11", "The peak at S = 0 is above that at S = 1 at 250 and 400 K, below it at 350 K.",
          _test_peaks_compared, "figure_4"),
    Claim("12a", "Without prestress the resonance lies at the higher frequency, at each T.",
          partial(_test_higher_frequency, 0), "figure_4"),
    Claim("12b", "With prestress the resonance lies at the higher frequency, at each T.",
          partial(_test_higher_frequency, 1), "figure_4"),
    Claim("13", "Higher temperature brings damping that dissipates energy.",
          _test_heat_damps, "tolerance"),
    Claim("14a", "The motion beats at resonance (350 K).", _test_beats_at_resonance, "figure_5"),
    Claim("14b", "At other temperatures, same frequency, the beating disappears.",
          _test_beats_nowhere_else, "figure_5"),
    Claim("14c", "The beating occurs because the drive is near the natural frequency.",
          _test_beats_near_natural, "figure_5"),
    Claim("15", "At 350 K, ω = 1.25, S = 0 the section is disordered: the motion is aperiodic.",
          partial(_test_aperiodic_at_resonance, 0), "tolerance"),
    Claim("16", "At 250 and 400 K, ω = 1.25, S = 0 the section is a closed curve: quasi-periodic.",
          partial(_test_quasi_periodic_elsewhere, 0), "tolerance"),
    Claim("17a", "At 350 K, ω = 1.08, S = 1 the motion is aperiodic.",
          partial(_test_aperiodic_at_resonance, 1), "tolerance"),
    Claim("17b", "At 250 and 400 K, ω = 1.08, S = 1 the section is a closed curve: quasi-periodic.",
          partial(_test_quasi_periodic_elsewhere, 1), "tolerance"),
    Claim("18", "Temperature drives a transition between aperiodic and quasi-periodic motion.",
          _test_transition, "tolerance"),
    Claim("19", "Without prestress the actuator settles faster.", _test_settles_faster, "figure_2"),
    Claim("20", "Bounded phase portraits show that the vibration is stable.",
          _test_bounded_is_stable, "figure_5"),
)  # fmt: skip
