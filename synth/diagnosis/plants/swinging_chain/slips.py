"""What a user's files have wrong by a slip: told before any cause, since causes that are named beside it imitate it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.cause_findings import Findings
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain.pieces import whole_recordings
from synth.diagnosis.score import score
from synth.diagnosis.verdict import UNKNOWN_IF_CONTRADICTED
from synth.diagnosis.workbench import Workbench
from synth.remarks import decisive

SAMPLES_A_TRIAL = 120  # samples per trial: enough to see errors of degrees
INTEGRATION_TOLERANCE = 1e-4  # rad, of the integrator: errors are a hundred times larger
# Two changes whose errors are nearer than this factor fit alike (a choice, well below the improvement by a change)
ALIKE = 1.5


@dataclass(frozen=True)
class Slip:
    """A slip that is told: ``text`` with the errors of the designed leg, and ``remedy``.

    ``recordings`` : that show it; ``place`` : their names as told, empty for a number that all have. ``left`` : rad
    RMS of the designed leg on them without the slip. ``number`` : a stated number is far off, not what a column means.
    """

    text: str
    remedy: str
    recordings: tuple[str, ...]
    left: float
    place: str = ""
    number: bool = False

    def rather_than(self, left: float) -> bool:
        """Whether it, and not an explanation that leaves ``left`` rad RMS, is what is wrong.

        What a column means has no size to be fitted, as an explanation has.
        """
        return (ALIKE if self.number else 1.0) * self.left < left

    @property
    def sentence(self) -> str:
        """With the place and the remedy."""
        where = f"{self.place}: " if self.place else ""
        return f"{where}{self.text}. {self.remedy[:1].upper()}{self.remedy[1:]}"


def doubting_slips(
    slips: Sequence[Slip], findings: Findings[EvaluatedHypothesis, Array]
) -> Findings[EvaluatedHypothesis, Array]:
    """The findings with a warning on each slip.

    Where the first leaves less than the explanation does, or what columns mean is wrong and the verdict open, the
    sentence and the advice begin with it.
    """
    if not slips:
        return findings
    warnings, first = (*(decisive(slip.sentence) for slip in slips), *findings.warnings), slips[0]
    # Errors of pieces are less than those of whole recordings, by which slips are found: the verdict weighs these.
    leads = first.rather_than(findings.stages.errors.figure("after").value)
    if not leads and (first.number or findings.judged.verdict != "unknown"):
        return replace(findings, warnings=warnings)
    what = "A number is far off" if first.number else "The files say something else than was recorded"
    sentence, planned = f"{what}: {first.text}. {findings.sentence}", findings.next_experiment
    if planned is not None:  # it is chosen by the leg as it is stated
        correct = "Correct the number that is far off first" if first.number else "Correct the files first"
        planned = replace(planned, why=f"{correct}, and run again. {planned.why}")
    return replace(findings, sentence=sentence, next_experiment=planned, warnings=warnings)


def doubt_of_slips(
    slips: Sequence[Slip], bench: Workbench, fit: EvaluatedHypothesis, trials: Sequence[AngleTrial]
) -> float:
    """The probability that an explanation, with its best ``fit``, stands for a slip.

    One that leaves much less of its recordings than the causes do is what is wrong; they imitate it.
    """
    whole = whole_recordings(trials) if slips else []
    for slip in slips:
        chosen = [trial.thinner(SAMPLES_A_TRIAL) for trial in whole if trial.recording.name in slip.recordings]
        found = score(bench, fit, chosen)
        away = [(made - trial.measured)[trial.counts] for trial, (made, _) in zip(chosen, found, strict=True)]
        if away and slip.rather_than(float(np.sqrt(np.mean(np.concatenate(away) ** 2)))):
            return UNKNOWN_IF_CONTRADICTED
    return 0.0
