"""From findings to verdicts: every admissible setting of what is unstated votes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from remanent.report.claims import CLAIMS, Claim, Finding
from remanent.report.evidence import ClaimEvidence
from remanent.report.settings import Setting


@dataclass(frozen=True)
class ClaimVerdict:
    """What the votes say of a claim.

    Attributes
    ----------
    claim : Claim
        The statement.
    verdict : str
        ``supported``, ``contradicted`` or ``depends``.
    evidence_text : str
        The numbers at the reference setting, and on which choice the verdict depends.
    """

    claim: Claim
    verdict: str
    evidence_text: str


def audit(reference: ClaimEvidence, alternatives: Sequence[ClaimEvidence]) -> list[ClaimVerdict]:
    """Decide every claim.

    A claim is supported where it holds, or contradicted where it fails, for every setting and
    every reading; else it depends on these.

    Parameters
    ----------
    reference : ClaimEvidence
        Evidence for the reference setting, whose numbers are reported.
    alternatives : sequence of ClaimEvidence
        Evidence for further settings of what [Thermal] leaves unstated. One for the setting of
        `reference` is left out: no setting votes twice.

    Returns
    -------
    list of ClaimVerdict
        One for each of :data:`~remanent.report.claims.CLAIMS`, in their order.
    """
    further = [evidence for evidence in alternatives if evidence.setting != reference.setting]
    return [_decide_claim(claim, reference, further) for claim in CLAIMS]


def _decide_claim(
    claim: Claim, reference: ClaimEvidence, alternatives: Sequence[ClaimEvidence]
) -> ClaimVerdict:
    votes = [
        (e.setting, reading, finding)
        for e in (reference, *alternatives)
        for reading, finding in claim.test(e).items()
    ]
    numbers = " ".join(
        f"{reading}: {f.numbers_text}" if reading else f.numbers_text
        for setting, reading, f in votes
        if setting == reference.setting
    )
    holds = [finding.holds for _, _, finding in votes]
    if all(holds):
        return ClaimVerdict(claim, "supported", numbers + _agreement_text(alternatives))
    if not any(holds):
        return ClaimVerdict(claim, "contradicted", numbers + _agreement_text(alternatives))
    return ClaimVerdict(claim, "depends", f"{numbers} {_dependence_text(votes)}")


def _agreement_text(alternatives: Sequence[ClaimEvidence]) -> str:
    """At how many further settings the answer is the same."""
    if not alternatives:
        return ""
    settings = f"{len(alternatives)} further setting{'s' if len(alternatives) > 1 else ''}"
    return f" The same at {settings} of what the article leaves unstated."


def _dependence_text(votes: Sequence[tuple[Setting, str, Finding]]) -> str:
    """On which reading, or on which setting, the answer depends."""
    by_reading = {
        reading: {f.holds for _, r, f in votes if r == reading} for _, reading, _ in votes
    }
    # Where each reading has one answer at all settings, the settings need no mention.
    if len(by_reading) > 1 and all(len(v) == 1 for v in by_reading.values()):
        yes = [r for r, v in by_reading.items() if True in v]
        no = [r for r, v in by_reading.items() if False in v]
        return f"It depends on the reading. Holds if {'; '.join(yes)}. Fails if {'; '.join(no)}."
    yes = [_setting_and_reading_text(s, r) for s, r, f in votes if f.holds]
    no = [_setting_and_reading_text(s, r) for s, r, f in votes if not f.holds]
    return (
        f"It depends on what the article leaves unstated. Holds at: {'; '.join(yes)}. "
        f"Fails at: {'; '.join(no)}."
    )


def _setting_and_reading_text(setting: Setting, reading: str) -> str:
    return f"{setting}, {reading}" if reading else str(setting)
