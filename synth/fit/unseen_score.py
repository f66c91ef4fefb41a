"""A fitted leg on left-out recordings: only per-trial unknowns are estimated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.fit.fit_problem import model_of, unknowns_of
from synth.fit.fit_result import FitResult
from synth.fit.least_squares import FitStart, Weights, solve
from synth.fit.recordings import Recording
from synth.fit.starts import first_locals
from synth.fit.trajectories import Local


@dataclass(frozen=True)
class UnseenFit:
    """Each trial's own unknowns, and predictions (m, n) rad a trial."""

    locals: tuple[Local, ...]
    predictions: tuple[Array, ...]


def score(result: FitResult, recordings: Sequence[Recording], *, spread: Array | None = None) -> UnseenFit:
    """Predict recordings with the fitted leg fixed.

    If the fit found separate free angles, each scored trial has its own within that spread; a given ``spread`` (n,) rad
    replaces it and may be so wide that they are almost free.
    """
    leg = result.leg
    curves = {
        joint.name: joint.damper.curve
        for joint in leg.joints
        if joint.damper is not None and joint.damper.curve is not None
    }
    model = model_of(leg, curves, recordings=recordings)
    damping = np.array([(joint.damper.rate or 0.0) if joint.damper else 0.0 for joint in leg.joints])
    values = unknowns_of(model).pack(leg.spring_rate, leg.rest, damping)
    if spread is None:
        spread = np.array([joint.free_angle_spread.value for joint in result.joints.values()])
    noise = np.array([result.clipped_rms[name] for name in leg.joint_names])
    noise = np.where(np.isfinite(noise), noise, 1.0)
    weights = Weights(np.tile(noise, (len(recordings), 1)), spread)
    solution = solve(model, recordings, FitStart(values, first_locals(recordings)), weights, fixed=True)
    return UnseenFit(solution.locals, solution.predictions)
