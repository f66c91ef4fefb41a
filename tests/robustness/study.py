"""The fit of one random leg: estimates and truth, as a record from which a run can resume."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robustness.random_legs import TOLERANCE_OF_LINKS, Case, random_case
from synth.errors import UserError
from synth.estimation.intervals import Estimate
from synth.files.project_options import FitOptions
from synth.files.trial_list import Trial
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.later_samples import recordings_from
from synth.fit.lost_frames import lost_frames
from synth.fit.methods import fit_by
from synth.fit.recordings import Recording, recordings
from synth.fit.uncertainty import clipped_rms
from synth.fit.unseen_score import score
from synth.motion.release import find_release, free_after
from synth.swing.leg_model import Leg

Array = NDArray[np.float64]

SHORTEST = 30  # samples that a cut must leave
UNCUT = 3  # trials at most, for a driven leg that is fitted as recorded: a model that does not hold is slow to fit
NEAR = 0.01  # of the RMS (its logarithm, over all joints): the fit explains the recordings as well as the truth
QUANTITIES = ("spring_rate", "damper_rate", "free_angle")


def study_case(seed: int, case: Case | None = None) -> dict[str, Any]:
    """The record of one seed; the variant ``default`` is what ``synth fit`` gives for the recordings as they are.

    The fit is given a leg whose links' numbers are off by the usual tolerance, as a user's are; ``exact``: the same
    with the true links and no tolerance. Beside it: all samples (``recorded``), each recording cut where an external
    torque is detected (``free``), and at its known end (``known``).
    """
    case = case or random_case(seed)
    recorder = case.recorder
    record: dict[str, Any] = {
        "seed": seed,
        "joints": list(case.leg.joint_names),
        "damping_ratio": [round(float(ratio), 4) for ratio in case.damping_ratio],
        "noise": recorder.noise,
        "counts": recorder.counts,
        "rate": recorder.rate,
        "trials": recorder.trials,
        "lost": recorder.lost,
        "driven": recorder.driven,
        "uneven": recorder.uneven,
        "duration": float(case.trials[0].time[-1]),
    }
    seen = [hand_until(case, trial) for trial in case.trials]
    record["hands"] = [None if until is None else round(until, 4) for until in seen]
    variants: dict[str, list[Trial]] = {}
    known = [until for until in seen if until is not None]
    if known:
        variants["free"] = [_cut(trial, free_after(known)) for trial in case.trials]
    if recorder.driven:
        variants["known"] = [_cut(trial, recorder.driven) for trial in case.trials]
        if recorder.trials <= UNCUT or not known:
            variants["recorded"] = list(case.trials)
    record["headline"] = "default"
    options = LegFitOptions(tolerance=TOLERANCE_OF_LINKS)
    record["fits"] = {name: fitted(case, case.off, trials, options) for name, trials in variants.items()}
    record["fits"]["default"] = fitted(case, case.off, case.trials, replace(options, release="free", laws="auto"))
    record["fits"]["exact"] = fitted(case, case.bare, case.trials, LegFitOptions(release="free", laws="auto"))
    return record


def hand_until(case: Case, trial: Trial) -> float | None:
    """End of the detected external torque, s; None if none is detected, or the detection fails. All start in motion."""
    try:
        found = find_release(trial.time, trial.angles, case.bare)
    except ValueError:
        return None
    return found.free_from if found.driven_until is not None and found.free_from > trial.time[0] else None


def _cut(trial: Trial, start: float) -> Trial:
    first = int(np.searchsorted(trial.time, start))
    if len(trial.time) - first < SHORTEST:
        return trial
    return replace(trial, time=trial.time[first:], angles=trial.angles[first:])


def fitted(case: Case, given: Leg, trials: Sequence[Trial], options: LegFitOptions) -> dict[str, Any]:
    start = time.process_time()
    try:
        made = recordings(given, trials)
        result = fit_by(given, made, options, FitOptions())
        mended = lost_frames(given, made, options)
        made = made if mended is None else mended.recordings
        made = recordings_from(made, result.cut) or made if result.cut else made
    except UserError as error:
        return {"done": False, "message": str(error.problems[0])}
    seconds = time.process_time() - start
    found = {
        "done": True,
        "cpu": round(seconds, 3),
        "free_angle": result.free_angle,
        "cut": round(result.cut, 4),
        "over": _over_truth(case, result, made),
    }
    joints = []
    for joint in case.leg.joints:
        fit = result.joints[joint.name]
        assert joint.spring is not None
        assert joint.damper is not None
        assert joint.damper.rate is not None
        assert fit.damper_rate is not None
        joints.append(
            {
                "spring_rate": _logarithms(fit.spring_rate, joint.spring.rate),
                "damper_rate": _logarithms(fit.damper_rate, joint.damper.rate),
                "free_angle": _differences(fit.free_angle, joint.spring.free_angle),
            }
        )
    warned = len(result.warnings)
    said = [str(sentence) for sentence in result.warnings]
    return found | {"warnings": warned, "said": said, "not_separable": len(result.not_separable), "joints": joints}


def _over_truth(case: Case, result: FitResult, made: list[Recording]) -> float:
    """Mean over joints of the fit's log RMS minus that of the true leg, whose initial states are fitted too."""
    truth = score(replace(result, leg=case.leg), made).predictions
    ours = [
        np.where(r.counts, case.leg.to_rotation(t.fitted), r.rotation) for r, t in zip(made, result.trials, strict=True)
    ]
    own, true = (np.log(clipped_rms(made, predictions)) for predictions in (ours, truth))
    return round(float(np.mean(own - true)), 5)


def _logarithms(estimate: Estimate, truth: float) -> list[float]:
    """Log of estimate, low and high end over the truth."""
    assert estimate.low is not None
    assert estimate.high is not None
    with np.errstate(divide="ignore"):  # the interval of a rate that is not told from none begins at 0
        return [round(float(np.log(x / truth)), 7) for x in (estimate.value, estimate.low, estimate.high)]


def _differences(estimate: Estimate, truth: float) -> list[float]:
    """Estimate, low and high end minus the truth, rad."""
    assert estimate.low is not None
    assert estimate.high is not None
    return [round(float(x - truth), 7) for x in (estimate.value, estimate.low, estimate.high)]
