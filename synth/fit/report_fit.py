"""From solved stages to a ``FitResult``: intervals, trials beside their fit, and what is to be said about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from synth.effects import effect_named
from synth.fit.least_squares import Solution, Stage
from synth.fit.recordings import Recording
from synth.fit.result import Estimate, FitResult, JointFit, TrialFit, Variant
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import covariance, mass_scale_sentence, not_separable, residuals, root_mean_square
from synth.fit.unknowns import NORMAL90, SpringsAndDampers
from synth.model.leg import Array, Damper, Leg, Spring
from synth.motion.characteristics import characteristics

MISFIT = 3.0  # RMS over sample scatter from which the model itself is called into question


def result_of(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    stages: Mapping[str, tuple[Stage, Array]],
    mode: str,
    why: str,
    scatter: Array,
    softened: Sequence[str] = (),
) -> FitResult:
    """Assemble the result of the chosen ``mode`` out of the stages, name -> (Stage, spread (n,) rad)."""
    unknowns = model.unknowns
    assert isinstance(unknowns, SpringsAndDampers)
    leg, names = model.leg, model.leg.joint_names
    variants = []
    for name, (stage, spread) in stages.items():
        joints = _joints(unknowns, stage.solution, covariance(model, stage.solution), spread, len(recordings))
        rms = dict(zip(names, root_mean_square(recordings, stage.solution.predictions).tolist(), strict=True))
        variants.append(
            Variant(
                name,
                {n: joint.spring_rate for n, joint in joints.items()},
                {n: joint.damper_rate for n, joint in joints.items() if joint.damper_rate is not None},
                rms,
                dict(zip(names, spread.tolist(), strict=True)),
            )
        )
        if name == mode:
            chosen, chosen_joints, chosen_rms = stage, joints, rms
    said = not_separable(unknowns, covariance(model, chosen.solution, with_prior=False), chosen.solution.values)
    scale = mass_scale_sentence(recordings)
    said += [*softened, *([scale] if scale else [])]
    warnings = [
        f"{name}: the fit leaves {np.degrees(chosen_rms[name]):.2g} deg where the samples scatter by only "
        f"{np.degrees(scatter[j]):.2g} deg: the model lacks something at this joint or beside it"
        for j, name in enumerate(names)
        if chosen_rms[name] > MISFIT * scatter[j] and chosen_rms[name] > np.radians(0.3)
    ]
    warnings += [*_at_edges(unknowns, chosen.solution.values), *_left_out(leg)]
    return FitResult(
        leg=_fitted_leg(leg, chosen_joints),
        joints=chosen_joints,
        rms=chosen_rms,
        trials=trial_fits(leg, chosen_joints, recordings, chosen.solution.locals, chosen.solution.predictions),
        free_angle=mode,
        free_angle_why=why,
        variants=tuple(variants),
        noise=dict(zip(names, scatter.tolist(), strict=True)),
        not_separable=tuple(said),
        warnings=tuple(warnings),
        method="least_squares",
        iterations=chosen.solution.iterations,
        reason=chosen.solution.reason,
        lost_samples=sum(recording.n_lost for recording in recordings),
    )


def _left_out(leg: Leg) -> list[str]:
    """Sentences on effects of the leg file that the fit does not reckon with: all but torques at the joints."""
    held = [(f"{joint.name}: ", name) for joint in leg.joints for name in joint.effects]
    held += [("", name) for name in leg.effects]
    return [
        f"{place}{name} is not in the fit: it takes links as rigid, the base as fixed and readings as they are"
        for place, name in held
        if effect_named(name).way != "torque"
    ]


def _at_edges(unknowns: SpringsAndDampers, values: Array) -> list[str]:
    """Sentences on rates that the search stopped at the edge of its box: their intervals know nothing of it."""
    sentences = []
    first_damper = len(unknowns.rates) + len(unknowns.rests)
    sides = (("least", unknowns.lower), ("greatest", unknowns.upper))
    for what, unit, joints, first in (
        ("spring rate", "N*m/rad", unknowns.rates, 0),
        ("damper rate", "N*m*s/rad", unknowns.dampers, first_damper),
    ):
        for position, j in enumerate(joints):
            value = values[first + position]
            for name, side in sides:
                if abs(value - side[first + position]) < 1e-6:
                    sentences.append(
                        f"{unknowns.leg.joint_names[j]}: the {what} lies on the edge of what is searched, "
                        f"{np.exp(value):.3g} {unit} is the {name}: the true one lies beyond or the model does not "
                        "hold, and the interval does not count"
                    )
    return sentences


def _joints(
    unknowns: SpringsAndDampers, solution: Solution, covariance: Array, spread: Array, n_trial: int
) -> dict[str, JointFit]:
    """Estimates by joint with 90 % intervals: log-normal for rates, normal for angles."""
    leg = unknowns.leg
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    n_rate, n_rest = len(unknowns.rates), len(unknowns.rests)

    def rate(place: int, unit: str) -> Estimate:
        value, half = solution.values[place], min(NORMAL90 * deviation[place], 300.0)
        low, high = np.exp(value - half), np.exp(min(value + half, 700.0))
        return Estimate(float(np.exp(value)), unit, float(low), float(high))

    found = {}
    for j, joint in enumerate(leg.joints):
        place = n_rate + unknowns.rests.index(j)
        angle = joint.zero + joint.sign * float(solution.values[place])
        half = NORMAL90 * float(deviation[place])
        damper = rate(n_rate + n_rest + unknowns.dampers.index(j), "N*m*s/rad") if j in unknowns.dampers else None
        found[joint.name] = JointFit(
            spring_rate=rate(unknowns.rates.index(j), "N*m/rad"),
            free_angle=Estimate(angle, "deg", angle - half, angle + half),
            free_angle_spread=_spread(float(spread[j]), n_trial),
            damper_rate=damper,
            damper="linear" if damper is not None else "curve",
        )
    return found


def _spread(value: float, n_trial: int) -> Estimate:
    """A standard deviation over trials, with the interval that chi-squared leaves for that many trials."""
    if value == 0.0 or n_trial < 2:
        return Estimate(value, "deg")
    from scipy.special import gammaincinv

    half = (n_trial - 1) / 2
    quantiles = [2 * float(gammaincinv(half, p)) for p in (0.95, 0.05)]
    low, high = (value * np.sqrt((n_trial - 1) / q) for q in quantiles)
    return Estimate(value, "deg", float(low), float(high))


def _fitted_leg(leg: Leg, joints: Mapping[str, JointFit]) -> Leg:
    made = []
    for joint in leg.joints:
        found = joints[joint.name]
        damper = joint.damper if found.damper_rate is None else Damper(found.damper_rate.value)
        made.append(replace(joint, spring=Spring(found.spring_rate.value, found.free_angle.value), damper=damper))
    return replace(leg, joints=tuple(made))


def trial_fits(
    leg: Leg,
    joints: Mapping[str, JointFit],
    recordings: Sequence[Recording],
    locals_: Sequence[Local],
    predictions: Sequence[Array],
    *,
    held_out: bool = False,
) -> tuple[TrialFit, ...]:
    """Each recording beside its prediction, in measured angles, with the characteristics of the predicted motion.

    Characteristics are taken from the smoothed recording, not from the model: they describe the data.
    """
    common = np.array([joint.free_angle.value for joint in joints.values()])
    fits = []
    for recording, local, prediction in zip(recordings, locals_, predictions, strict=True):
        residual = residuals(recording, prediction)
        counted = np.asarray(recording.counts.any(axis=0))
        rms = np.full(len(counted), np.nan)
        rms[counted] = np.sqrt(np.nanmean(residual[:, counted] ** 2, axis=0))
        smoothed = recording.smoothed
        measured = leg.to_measured(smoothed.angle)
        found = {
            leg.joint_names[j]: characteristics(smoothed.time, measured[:, j], float(smoothed.noise[j]))
            for j in recording.free
        }
        rotation = np.where(recording.counts, recording.rotation, np.nan)
        fits.append(
            TrialFit(
                recording.name,
                recording.time,
                leg.to_measured(rotation),
                leg.to_measured(prediction),
                rms,
                common + leg.sign * local.shift,
                local.rotation,
                local.rate,
                found,
                held_out,
            )
        )
    return tuple(fits)
