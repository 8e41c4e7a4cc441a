"""Where the lines between regimes are drawn, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass

#: Return defect of a closed orbit, relative to its extent.
MAX_CLOSED_RETURN_DEFECT = 1e-6


@dataclass(frozen=True)
class RegimeThresholds:
    """The numbers that evidence is compared with.

    A motion between two lines stays undecided: every pair leaves a gap on purpose.  Where no
    theory gives a number, it was set on the thousand known motions of
    ``tests/literature/regimes`` so that no label is wrong; an entry says so by "measured".

    Attributes
    ----------
    max_closed_return_defect, min_open_return_defect : float
        Distance after a period, relative to the extent.  Below the first the orbit is closed,
        above the second it is open.
    max_regular_log_growth_excess : float
        Tangents of regular motion grow at most like n e^excess over n periods.
    max_torus_late_log_growth, max_torus_late_log_growth_if_rotation_converges : float
        Growth between the second and the last quarter of a run, on a torus.  The second holds
        where only the rotation number converges.
    min_torus_late_log_growth, min_torus_late_defect_share : float
        Damped motion on a torus: it does not close in on a periodic orbit.
    min_torus_digits : float
        Digits to which weighted averages agree on a torus.
    min_torus_digits_if_rotation_converges, min_torus_rotation_digits : float
        Fewer digits suffice where the rotation number has the second number of digits.
    max_torus_zero_one, max_torus_zero_one_if_rotation_converges : float
        Result of the 0-1 test on a torus.
    min_torus_relative_band_scatter : float
        Extent of every eighth point relative to that of all points, on a torus of damped motion.
    min_chaos_exponent_over_error : float
        Standard errors by which a chaotic exponent exceeds 0.
    min_chaos_growth_power, min_chaos_log_growth_excess : float
        In chaos tangents grow at least like n^power e^excess.
    min_chaos_log_growth_per_half : float
        In chaos they grow at least by e^this in each half of the run.
    max_chaos_digits : float
        Digits to which averages within bands agree in chaos.
    max_exponent_ratio_between_tolerances : float
        Between exponents of one chaotic motion at two tolerances.
    """

    # --- return -------------------------------------------------------------------------
    # Ten times the error that a period adds at the loosest of the default tolerances.
    max_closed_return_defect: float = MAX_CLOSED_RETURN_DEFECT
    # Ten times the line above: between them an orbit may still be settling.
    min_open_return_defect: float = 1e-5

    # --- growth of tangents: logarithms over the run --------------------------------------
    # Twist makes tangents grow like n on a torus, so their logarithm is ln n and a constant.
    # The constant depends on the coordinates; measured, it stays below 2.
    max_regular_log_growth_excess: float = 2.0
    # Between the middles of these quarters growth like n gives ln(7/3) = 0.85, growth like n^2
    # gives 1.7, and an exponent L gives L n/2, which passes any line when the run is long.
    max_torus_late_log_growth: float = 2.5
    # Keeps out n^2 where the other evidence is weaker.
    max_torus_late_log_growth_if_rotation_converges: float = 1.5
    # Decay by more than e between these quarters belongs to motion that still settles.
    min_torus_late_log_growth: float = -1.0
    # So does a return that is twice as good at the end of the run as over the whole of it.
    min_torus_late_defect_share: float = 0.5

    # --- convergence of weighted averages ---------------------------------------------------
    # On a torus they converge faster than any power of n (Das et al. 2017), in chaos like
    # n^(-1/2), which makes one or two digits in 500 periods.  Measured.
    min_torus_digits: float = 5.0
    # Slow tori, which turn a few times within a run, reach fewer digits.  Measured.
    min_torus_digits_if_rotation_converges: float = 3.4
    # Their rotation numbers converge all the same.  Measured.
    min_torus_rotation_digits: float = 4.5

    # --- 0-1 test ---------------------------------------------------------------------------
    # 0 for regular motion and 1 for chaos (Gottwald and Melbourne 2009).  It stays near 0 in
    # thin chaotic layers too, so it can refuse a torus and cannot be asked for in chaos.
    max_torus_zero_one: float = 0.4
    # Half of that where the averages say less.
    max_torus_zero_one_if_rotation_converges: float = 0.2

    # --- bands ------------------------------------------------------------------------------
    # At the end of a cascade of doublings motion is as regular as on a torus, but lies in
    # 2^k narrow bands: every eighth point then stays in one of them.
    min_torus_relative_band_scatter: float = 0.1

    # --- chaos ------------------------------------------------------------------------------
    # The usual three standard errors.
    min_chaos_exponent_over_error: float = 3.0
    # Regular motion has power 1; the gap up to 1.5 is left undecided.
    min_chaos_growth_power: float = 1.5
    # Twice the constant of regular motion.
    min_chaos_log_growth_excess: float = 4.0
    # A factor of 90 in each half: growth that stops half way is a transient.
    min_chaos_log_growth_per_half: float = 4.5
    # Averages that agree to more digits speak against chaos.  Measured.
    max_chaos_digits: float = 3.5
    # Exponents at other tolerances belong to other orbits of the same chaotic set; a larger
    # ratio means that one of the runs sticks to an island.
    max_exponent_ratio_between_tolerances: float = 3.0
