"""Scan along a ridge: one joint's spring rate is fixed at several values and everything else is refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.fit.fit_problem import box_of
from synth.fit.fit_result import FitResult
from synth.fit.least_squares import FitStart, Weights, solve
from synth.fit.recordings import Recording
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import clipped_rms, correlation_times, root_mean_square
from synth.fit.unknowns import unknowns_of_leg
from synth.swing.chain import compiled_chain
from synth.swing.leg_model import Damper, Spring

HELD_PRECISION = 1e8  # precision of a fixed log rate
LARGEST_STEP = np.log(1.3)  # largest step of the log rate, so that each fit starts near its minimum
LEAST_SPREAD = np.radians(2.0)  # least spread of the free angles, which may then absorb creep


@dataclass(frozen=True)
class RidgePoint:
    """The fit at a fixed ``spring_rate`` (N m/rad): ``damper_rate`` N m s/rad and residual ``rms`` rad of the joint."""

    spring_rate: float
    damper_rate: float
    rms: float


def rate_scan(fit: FitResult, recordings: Sequence[Recording], joint: str, rates: Sequence[float]) -> list[RidgePoint]:
    """Fits with the joint's spring rate fixed at each of ``rates`` (N m/rad), in their order.

    The rates of the other joints stay at their fitted values; initial states and free angles are refitted.
    """
    names = fit.leg.joint_names
    j = names.index(joint)
    bare = replace(
        fit.leg, joints=tuple(replace(item, spring=Spring(0.0, item.zero), damper=Damper()) for item in fit.leg.joints)
    )
    chain = compiled_chain(len(names))
    unknowns = unknowns_of_leg(chain, bare, box=box_of(recordings))
    joints = fit.joints.values()
    common = np.array([item.free_angle.value for item in joints])
    values = unknowns.pack(
        np.array([item.spring_rate.value for item in joints]),
        bare.to_rotation(common),
        np.array([item.damper_rate.value if item.damper_rate else 0.0 for item in joints]),
    )
    n = len(names)
    others = tuple((p, float(values[p]), HELD_PRECISION) for i in range(n) if i != j for p in (i, 2 * n + i))
    locals_ = [Local(trial.rotation, trial.rate, bare.sign * (trial.free_angle - common)) for trial in fit.trials]
    spread = np.array([max(item.free_angle_spread.value, LEAST_SPREAD) for item in joints])
    predictions = [bare.to_rotation(trial.fitted) for trial in fit.trials]
    noise = clipped_rms(recordings, predictions) * np.sqrt(correlation_times(recordings, predictions))
    weights = Weights(np.where(np.isfinite(noise), noise, 1.0), spread)
    best = float(np.exp(values[j]))
    found: dict[float, RidgePoint] = {}
    for side in (sorted(r for r in rates if r >= best), sorted((r for r in rates if r < best), reverse=True)):
        at, own = values.copy(), tuple(locals_)
        for rate in side:
            steps = max(1, int(np.ceil(abs(np.log(rate) - at[j]) / LARGEST_STEP)))
            for target in np.linspace(at[j], np.log(rate), steps + 1)[1:]:
                held = replace(unknowns, beliefs=(*others, (j, float(target), HELD_PRECISION)))
                moved = at.copy()
                moved[2 * n + j] += target - at[j]
                moved[j] = target
                model = TrajectoryModel(chain, bare, held)
                solution = solve(model, recordings, FitStart(moved, own), weights, tolerance=0.01)
                at, own = solution.values, solution.locals
            left = float(root_mean_square(recordings, solution.predictions)[j])
            found[rate] = RidgePoint(float(np.exp(at[j])), float(np.exp(at[2 * n + j])), left)
    return [found[rate] for rate in rates]
