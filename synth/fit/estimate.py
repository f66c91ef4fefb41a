"""Fit a leg to recordings: weak form for the start, trajectories for the answer, the free angle as the data ask."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from synth.errors import UserError
from synth.fit.free_angle import LEAST_SPREAD, SIGNIFICANCE, WIDE, heterogeneity
from synth.fit.least_squares import Solution, Weights, solve
from synth.fit.recordings import Recording
from synth.fit.report_fit import result_of
from synth.fit.result import FitResult
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import covariance, residuals, root_mean_square
from synth.fit.unknowns import SpringsAndDampers, all_of
from synth.fit.weak_form import weak_form
from synth.model.chain import compiled_chain
from synth.model.leg import Array, Damper, DamperCurve, Leg, Spring
from synth.model.mechanics import outboard_inertia
from synth.motion.smoothing import initial_state

WINDOWS = (0.1, 0.2, 0.05)  # s, weak-form windows that are tried
NOISE_ROUNDS = 6
RANDOM_STARTS = 6
POOR = 4.0  # times the samples' own scatter: beyond it other starts are tried


@dataclass(frozen=True)
class FitOptions:
    """How to fit.

    ``free_angle``: auto, common or per_trial. ``weight``: noise (each joint by its own residual) or amplitude (and each
    trial by how far the joint moves in it). ``curves``: joint name -> its known torque-speed curve.
    """

    free_angle: str = "auto"
    weight: str = "noise"
    curves: Mapping[str, DamperCurve] = field(default_factory=dict)
    seed: int = 0


@dataclass(frozen=True)
class Stage:
    """A solution with the weights that it was found under, its covariance and rest-shift variances a trial."""

    solution: Solution
    weights: Weights
    covariance: Array
    shift_variance: tuple[Array, ...]


def fit_leg(leg: Leg, recordings: Sequence[Recording], options: FitOptions = FitOptions()) -> FitResult:  # noqa: B008
    """Find spring rate, free angle and damper rate of every joint.

    Parameters
    ----------
    leg : links and gravity; its own springs and dampers are not used.
    recordings : at least one; each trial's initial state is estimated with the rest.

    Raises
    ------
    UserError : no trajectory of any start stays finite.
    """
    if not recordings:
        raise UserError("no trial is left to fit: every one is held out")
    leg = _bare(leg, options.curves)
    chain = compiled_chain(len(leg.joints))
    known = [j for j, name in enumerate(leg.joint_names) if name in options.curves]
    unknowns = all_of(chain, leg, damper_known=known)
    model = TrajectoryModel(chain, leg, unknowns)
    values = _start(model, recordings, options)
    common = _refine(model, recordings, values, _first_locals(recordings), options, np.zeros(len(leg.joints)))
    scatter = _scatter(recordings)
    if np.any(root_mean_square(recordings, common.solution.predictions) > POOR * scatter):
        common = _other_starts(model, recordings, common, options)
    if not np.isfinite(common.solution.cost):
        raise UserError("no motion of this leg comes near the trials: check link masses, zero and sign of each joint")
    per_trial, spread = None, np.zeros(len(leg.joints))
    probability = np.ones(len(leg.joints))
    if options.free_angle != "common" and len(recordings) > 1:
        per_trial, spread, probability = _per_trial(model, recordings, common, options)
    chosen, mode, why = _choose(leg, common, per_trial, spread, probability, options, len(recordings))
    stages = {"common": (common, np.zeros_like(spread))}
    if per_trial is not None:
        stages["per_trial"] = (per_trial, spread)
    return result_of(model, recordings, stages, mode, why, scatter)


def score(
    result: FitResult, recordings: Sequence[Recording], curves: Mapping[str, DamperCurve] | None = None
) -> tuple[tuple[Local, ...], tuple[Array, ...]]:
    """Each trial's own unknowns and prediction (m, n) rad with the fitted leg held fixed.

    Where the fit found that the free angle differs from trial to trial, each scored trial has its own within that
    spread too.
    """
    leg = result.leg
    known = [j for j, joint in enumerate(leg.joints) if joint.damper is not None and joint.damper.curve is not None]
    chain = compiled_chain(len(leg.joints))
    unknowns = all_of(chain, leg, damper_known=known)
    model = TrajectoryModel(chain, leg, unknowns)
    rate = np.array([joint.spring.rate if joint.spring else 0.0 for joint in leg.joints])
    rest = np.array([j.sign * (j.spring.free_angle - j.zero) if j.spring else 0.0 for j in leg.joints])
    damping = np.array([(joint.damper.rate or 0.0) if joint.damper else 0.0 for joint in leg.joints])
    values = unknowns.pack(rate, rest, damping)
    spread = np.array([joint.free_angle_spread.value for joint in result.joints.values()])
    noise = np.array([result.rms[name] for name in leg.joint_names])
    noise = np.where(np.isfinite(noise), noise, 1.0)
    weights = Weights(np.tile(noise, (len(recordings), 1)), spread)
    solution = solve(model, recordings, values, _first_locals(recordings), weights, fixed=True)
    return solution.locals, solution.predictions


def _bare(leg: Leg, curves: Mapping[str, DamperCurve]) -> Leg:
    """The leg without springs, with dampers only where their curve is known."""
    joints = [
        replace(joint, spring=Spring(0.0, joint.zero), damper=Damper(curve=curves.get(joint.name)))
        for joint in leg.joints
    ]
    return replace(leg, joints=tuple(joints))


def _first_locals(recordings: Sequence[Recording]) -> list[Local]:
    locals_ = []
    for recording in recordings:
        rotation, rate = initial_state(recording.smoothed)
        locals_.append(Local(rotation, rate, np.zeros_like(rotation)))
    return locals_


def _scatter(recordings: Sequence[Recording]) -> Array:
    """(n,) rad, the samples' scatter about local polynomials: about the measuring noise."""
    squares = [np.where(r.counts.any(axis=0), r.smoothed.noise**2, np.nan) for r in recordings]
    return np.sqrt(np.nanmean(np.array(squares), axis=0)) + 1e-9


def _start(model: TrajectoryModel, recordings: Sequence[Recording], options: FitOptions) -> Array:
    """The weak form's answer with the window whose trajectories lie nearest the trials."""
    assert isinstance(model.unknowns, SpringsAndDampers)
    leg, inertia = model.leg, outboard_inertia(model.leg)
    curves = [options.curves.get(name) for name in leg.joint_names]
    candidates = []
    for window in WINDOWS:
        for per_trial in (False, True) if len(recordings) > 1 else (False,):
            found = weak_form(leg, recordings, curves, window=window, per_trial_rest=per_trial)
            # A rate that noise turned negative starts from a slow, lightly damped swing: 1 Hz, 2 1/s.
            rate = np.where(found.spring_rate > 0, found.spring_rate, inertia * (2 * np.pi) ** 2)
            damping = np.where(found.damper_rate > 0, found.damper_rate, inertia * 2.0)
            rest = np.where(found.spring_rate > 0, found.rest, _mean_end(recordings))
            candidates.append(model.unknowns.pack(rate, np.clip(np.nan_to_num(rest), -np.pi, np.pi), damping))
    locals_ = _first_locals(recordings)
    costs = [_quick_cost(model, recordings, values, locals_) for values in candidates]
    return candidates[int(np.argmin(costs))]


def _mean_end(recordings: Sequence[Recording]) -> Array:
    return np.mean([r.smoothed.angle[-max(2, len(r.smoothed.angle) // 10) :].mean(axis=0) for r in recordings], axis=0)


def _quick_cost(
    model: TrajectoryModel, recordings: Sequence[Recording], values: Array, locals_: Sequence[Local]
) -> float:
    total = 0.0
    for recording, local in zip(recordings, locals_, strict=True):
        prediction = model.evaluate(recording, values, local, jacobian=False).prediction
        total += float(np.nansum(residuals(recording, prediction) ** 2)) if np.all(np.isfinite(prediction)) else np.inf
    return total


def _refine(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    values: Array,
    locals_: Sequence[Local],
    options: FitOptions,
    spread: Array,
    *,
    rounds: int = NOISE_ROUNDS,
    noise: Array | None = None,
) -> Stage:
    """Solve, estimate each joint's noise from the residuals, and solve again until the noise no longer changes."""
    n = len(model.leg.joints)
    relative = _relative_noise(recordings, options)
    if noise is None:
        predictions = [
            model.evaluate(r, values, local, jacobian=False).prediction
            for r, local in zip(recordings, locals_, strict=True)
        ]
        noise = np.nan_to_num(root_mean_square(recordings, predictions), nan=0.1, posinf=0.1) + 1e-6
    solution: Solution | None = None
    for round_ in range(rounds):
        weights = Weights(relative * noise, spread)
        start = (values, locals_) if solution is None else (solution.values, solution.locals)
        solution = solve(model, recordings, *start, weights, max_iterations=40 if round_ else 25)
        if not np.isfinite(solution.cost):
            break
        found = root_mean_square(recordings, solution.predictions)
        found = np.where(np.isfinite(found), found, 1.0) + 1e-7
        change = np.abs(np.log(found / noise)).max()
        noise = found
        if change < 0.01:
            break
    assert solution is not None
    weights = Weights(relative * noise, spread)
    if not np.isfinite(solution.cost):
        return Stage(solution, weights, np.full((len(values), len(values)), np.inf), ())
    cov, shift_variance = covariance(model, recordings, solution, weights)
    return Stage(solution, weights, cov, shift_variance if n else ())


def _relative_noise(recordings: Sequence[Recording], options: FitOptions) -> Array:
    """(n_trial, n) factor on each joint's noise: one, or the amplitude a trial over its mean."""
    if options.weight == "noise":
        return np.ones((len(recordings), recordings[0].rotation.shape[1]))
    amplitude = np.array([np.ptp(r.smoothed.angle, axis=0) for r in recordings])
    mean = np.maximum(amplitude.mean(axis=0), 1e-6)
    return np.maximum(amplitude / mean, 0.2)


def _other_starts(
    model: TrajectoryModel, recordings: Sequence[Recording], best: Stage, options: FitOptions
) -> Stage:
    """A few starts drawn in natural units, in case the weak form led into the wrong valley; the best is refined."""
    assert isinstance(model.unknowns, SpringsAndDampers)
    random = np.random.default_rng(options.seed)
    n, inertia = len(model.leg.joints), outboard_inertia(model.leg)
    locals_ = _first_locals(recordings)
    rest = _mean_end(recordings)
    for _ in range(RANDOM_STARTS):
        rate = inertia * (2 * np.pi * np.exp(random.uniform(np.log(1.0), np.log(10.0), n))) ** 2
        damping = inertia * np.exp(random.uniform(np.log(1.0), np.log(100.0), n))
        values = model.unknowns.pack(rate, rest + random.uniform(-0.2, 0.2, n), damping)
        found = solve(model, recordings, values, locals_, best.weights, max_iterations=15, tolerance=1e-4)
        if found.cost < 0.98 * best.solution.cost:
            refined = _refine(model, recordings, found.values, found.locals, options, np.zeros(n))
            if np.isfinite(refined.solution.cost):
                best = refined
    return best


def _per_trial(
    model: TrajectoryModel, recordings: Sequence[Recording], common: Stage, options: FitOptions
) -> tuple[Stage, Array, Array]:
    """Free angles a trial, first nearly free, then within the spread that this shows; spread (n,), probability (n,)."""
    n = len(model.leg.joints)
    start, locals_ = common.solution.values, common.solution.locals
    wide = _refine(model, recordings, start, locals_, options, np.full(n, WIDE))
    shift = np.array([local.shift for local in wide.solution.locals])
    found = heterogeneity(shift, np.array(wide.shift_variance))
    spread = np.maximum(found.spread, LEAST_SPREAD)
    stage = _refine(model, recordings, wide.solution.values, wide.solution.locals, options, spread)
    return stage, np.where(found.spread > LEAST_SPREAD, found.spread, 0.0), found.probability


def _choose(
    leg: Leg,
    common: Stage,
    per_trial: Stage | None,
    spread: Array,
    probability: Array,
    options: FitOptions,
    n_trial: int,
) -> tuple[Stage, str, str]:
    if per_trial is None:
        why = "asked for" if options.free_angle == "common" else "one trial alone cannot show a spread"
        return common, "common", why
    if options.free_angle == "per_trial":
        return per_trial, "per_trial", "asked for"
    limit = SIGNIFICANCE / len(leg.joints)
    shifted = [j for j in range(len(leg.joints)) if probability[j] < limit]
    if not shifted:
        least = float(np.min(probability))
        return common, "common", f"the {n_trial} trials show no shift of any free angle (least p = {least:.2g})"
    said = ", ".join(f"{leg.joint_names[j]} by {np.degrees(spread[j]):.2g} deg" for j in shifted)
    return per_trial, "per_trial", f"the free angle shifts from trial to trial ({said}, one standard deviation)"
