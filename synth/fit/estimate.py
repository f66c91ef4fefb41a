"""Fit a leg to recordings: weak form for the start, trajectories for the answer, the free angle as the data ask."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from synth.errors import UserError
from synth.files.options import Prior
from synth.files.static_points import StaticPoint
from synth.fit.free_angle import LEAST_SPREAD, SIGNIFICANCE, WIDE, heterogeneity
from synth.fit.least_squares import HUBER, Solution, Stage, Weights, solve
from synth.fit.recordings import Recording
from synth.fit.report_fit import MISFIT, result_of
from synth.fit.result import FitResult
from synth.fit.ridge import soften
from synth.fit.rounding import Rounding, encoder_counts, rounding_of
from synth.fit.static_points import balances
from synth.fit.trajectories import Local, TrajectoryModel, by_trial
from synth.fit.uncertainty import correlation_times, residuals, root_mean_square, shift_variances
from synth.fit.unknowns import SpringsAndDampers, all_of
from synth.fit.weak_form import WeakForm
from synth.model.chain import compiled_chain
from synth.model.leg import Array, Damper, DamperCurve, Leg, Spring
from synth.model.mechanics import coefficients, outboard_inertia, static_torque
from synth.motion.smoothing import initial_state

WINDOWS = (0.1, 0.2, 0.05)  # s, weak-form windows that are tried
NATURAL_STARTS = ((3.0, 20.0), (6.0, 100.0), (1.0, 2.0), (4.0, 5.0))  # Hz of k/I, 1/s of b/I
NOISE_ROUNDS = 5
ROUGHLY = 3.0  # fall of the log-likelihood that is not worth a step before the noise is known
FINELY = 0.02
NEAR_DAMPING = 1e-6  # of an iteration that starts near its end, as the weak form does
SCREENED_STARTS, KEPT_STARTS = 24, 2
SCREENED_TRIALS = 5  # about so many trials show whether a start leads anywhere
POOR = 4.0  # times the samples' own scatter: beyond it other starts are tried


@dataclass(frozen=True)
class FitOptions:
    """How to fit.

    ``free_angle``: auto, common or per_trial. ``weight``: noise (each joint by its own residual), amplitude (and each
    trial by how far the joint moves in it) or equal (one noise for all). ``curves``: joint name -> its known
    torque-speed curve. ``prior``: how far the leg file's own values may be trusted. ``near``: an earlier
    fit of the same recordings, whose spring rates, free angles and their spread this one starts from and keeps to.
    ``static``: poses in which the leg was held still by known torques. ``intervals``: by sensitivities, or by bootstrap
    over blocks of residuals.
    """

    free_angle: str = "auto"
    weight: str = "noise"
    curves: Mapping[str, DamperCurve] = field(default_factory=dict)
    seed: int = 0
    prior: Prior | None = None
    near: FitResult | None = None
    static: tuple[StaticPoint, ...] = ()
    intervals: str = "sensitivities"


def fit_leg(leg: Leg, recordings: Sequence[Recording], options: FitOptions = FitOptions()) -> FitResult:
    """Find spring rate, free angle and damper rate of every joint.

    Parameters
    ----------
    leg : links and gravity; its own springs and dampers are not used but by ``options.prior``.
    recordings : at least one; each trial's initial state is estimated with the rest.

    Raises
    ------
    UserError : no trajectory of any start stays finite.
    """
    if not recordings:
        raise UserError("no trial is left to fit: every one is held out")
    given, leg = leg, _bare(leg, options.curves)
    chain = compiled_chain(len(leg.joints))
    known = [j for j, name in enumerate(leg.joint_names) if name in options.curves]
    unknowns = all_of(chain, leg, damper_known=known)
    if options.prior is not None:
        unknowns = replace(unknowns, beliefs=_beliefs(unknowns, given, options.prior))
    unknowns = replace(unknowns, balances=balances(leg, options.static))
    model = TrajectoryModel(chain, leg, unknowns)
    if options.near is not None:
        return _fit_near(model, recordings, options, options.near)
    values, shifts = _start(model, recordings, options)
    locals_ = _first_locals(recordings)
    scatter = _scatter(recordings)
    stages: dict[str, tuple[Stage, Array]] = {}
    spread, probability = np.zeros(len(leg.joints)), np.ones(len(leg.joints))
    if options.free_angle != "common" and len(recordings) > 1:
        shifted = [replace(local, shift=shift) for local, shift in zip(locals_, shifts, strict=True)]
        stage, spread, probability = _per_trial(model, recordings, values, shifted, options, scatter)
        stages["per_trial"] = (stage, spread)
        values = stage.solution.values
        if np.isfinite(stage.solution.cost):
            locals_ = [replace(local, shift=np.zeros_like(local.shift)) for local in stage.solution.locals]
    stage = _refine(model, recordings, values, locals_, options, np.zeros_like(spread))
    if not stages:
        stage = _or_another_start(model, recordings, stage, options, scatter, np.zeros_like(spread))
    stages["common"] = (stage, np.zeros_like(spread))
    mode, why = _choose(leg, spread, probability, options, len(recordings))
    if not np.isfinite(stages[mode][0].solution.cost):
        raise UserError("no motion of this leg comes near the trials: check link masses, zero and sign of each joint")
    stage, spread = stages[mode]
    rms = root_mean_square(recordings, stage.solution.predictions)
    softened: tuple[str, ...] = ()
    least: Solution | None = None
    if np.any(rms > MISFIT * scatter):
        moved = soften(model, recordings, stage.solution, stage.weights)
        stages[mode] = (Stage(moved.solution, stage.weights), spread)
        softened = moved.sentences
        least = stage.solution if softened else None
    return result_of(
        model,
        recordings,
        stages,
        mode,
        why,
        scatter,
        softened,
        intervals=options.intervals,
        seed=options.seed,
        least=least,
    )


def _fit_near(
    model: TrajectoryModel, recordings: Sequence[Recording], options: FitOptions, near: FitResult
) -> FitResult:
    """Fit from an earlier result of the same recordings, each trial's free angle staying where it was found.

    Left free they would take up what the damper's curve does: a leg that creeps in the model would be said to rest
    elsewhere in every trial, and a spring far too soft would fit.
    """
    assert isinstance(model.unknowns, SpringsAndDampers)
    joints = [near.joints[name] for name in model.leg.joint_names]
    common = np.array([joint.free_angle.value for joint in joints])
    rates = np.array([joint.spring_rate.value for joint in joints])
    damping = np.array([joint.damper_rate.value if joint.damper_rate is not None else 0.0 for joint in joints])
    spread = np.array([joint.free_angle_spread.value for joint in joints])
    locals_ = [
        Local(trial.rotation, trial.rate, model.leg.sign * (trial.free_angle - common)) for trial in near.trials
    ][: len(recordings)]
    values = model.unknowns.pack(rates, model.leg.to_rotation(common), damping)
    shifts = np.array([local.shift for local in locals_])
    stage = _refine(
        model, recordings, values, locals_, options, np.full_like(spread, LEAST_SPREAD), centre=shifts, rounds=2
    )
    why = "each trial's shift as in the fit before"
    stages = {near.free_angle: (stage, spread)}
    scatter = _scatter(recordings)
    return result_of(
        model, recordings, stages, near.free_angle, why, scatter, intervals=options.intervals, seed=options.seed
    )


def score(result: FitResult, recordings: Sequence[Recording]) -> tuple[tuple[Local, ...], tuple[Array, ...]]:
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


def _beliefs(unknowns: SpringsAndDampers, given: Leg, prior: Prior) -> tuple[tuple[int, float, float], ...]:
    """The user's priors about the leg file's own values: log-normal for rates (their share), normal for angles."""
    found = []
    first_damper = len(unknowns.rates) + len(unknowns.rests)
    for j, joint in enumerate(given.joints):
        if joint.spring is not None and prior.spring is not None and joint.spring.rate > 0:
            found.append((unknowns.rates.index(j), float(np.log(joint.spring.rate)), prior.spring**-2))
        if joint.spring is not None and prior.free_angle is not None:
            rest = joint.sign * (joint.spring.free_angle - joint.zero)
            found.append((len(unknowns.rates) + unknowns.rests.index(j), rest, prior.free_angle**-2))
        if j in unknowns.dampers and joint.damper is not None and joint.damper.rate and prior.damper is not None:
            place = first_damper + unknowns.dampers.index(j)
            found.append((place, float(np.log(joint.damper.rate)), prior.damper**-2))
    return tuple(found)


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
    """(n,) rad, the samples' scatter about local polynomials: about the measuring noise; at least what counts make."""
    squares = [np.where(r.counts.any(axis=0), r.smoothed.noise**2, np.nan) for r in recordings]
    found = np.sqrt(np.nanmean(np.array(squares), axis=0)) + 1e-9
    return np.asarray(np.fmax(found, np.where(np.isnan(found), np.nan, encoder_counts(recordings) / np.sqrt(12.0))))


def _start(model: TrajectoryModel, recordings: Sequence[Recording], options: FitOptions) -> tuple[Array, Array]:
    """The weak form's answer with the window whose trajectories lie nearest the trials, and rest shifts a trial."""
    assert isinstance(model.unknowns, SpringsAndDampers)
    leg, inertia = model.leg, outboard_inertia(model.leg)
    curves = [options.curves.get(name) for name in leg.joint_names]
    weak, tried = WeakForm(leg, recordings, curves), []
    for window in WINDOWS:
        for found in weak.solve(window)[: 2 if len(recordings) > 1 else 1]:
            usable = (found.spring_rate > 0) & ((found.damper_rate > 0) | np.array([c is not None for c in curves]))
            # Noise, or a joint that moves as no passive one does, can turn a rate negative. Then the joint starts where
            # limbs are: from springy to well damped.
            for frequency, decay in NATURAL_STARTS if not np.all(usable) else NATURAL_STARTS[:1]:
                rate = np.where(usable, found.spring_rate, inertia * (2 * np.pi * frequency) ** 2)
                damping = np.where(usable, found.damper_rate, inertia * decay)
                rest, by_trial = _rests(model, recordings, rate)
                rest = np.where(usable, np.nan_to_num(found.rest), rest)
                by_trial = np.where(usable & found.per_trial, found.rest_by_trial, by_trial)
                shift = np.clip(np.nan_to_num(by_trial - rest), -2 * WIDE, 2 * WIDE) * (options.free_angle != "common")
                tried.append((model.unknowns.pack(rate, np.clip(rest, -np.pi, np.pi), damping), shift))
    costs = _quick_costs(model, recordings, [values for values, _ in tried], [shift for _, shift in tried])
    return tried[int(np.argmin(costs))]


def _rests(model: TrajectoryModel, recordings: Sequence[Recording], rate: Array) -> tuple[Array, Array]:
    """Rest angles (n,) and by trial (n_trial, n) that hold each trial's last pose in balance at these spring rates."""
    by_trial = []
    for recording in recordings:
        end = recording.smoothed.angle[-max(2, len(recording.smoothed.angle) // 10) :].mean(axis=0)
        found = coefficients(model.leg, recording.conditions.tip_mass)
        by_trial.append(end + static_torque(found, end, model.leg.tilt + recording.conditions.tilt) / rate)
    rests = np.array(by_trial)
    return np.median(rests, axis=0), rests


def _mean_end(recordings: Sequence[Recording]) -> Array:
    ends = [r.smoothed.angle[-max(2, len(r.smoothed.angle) // 10) :].mean(axis=0) for r in recordings]
    return np.asarray(np.mean(ends, axis=0))


def _quick_costs(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    starts: Sequence[Array],
    shifts: Sequence[Array] | None = None,
) -> Array:
    """(n_start,) squared residuals of trajectories from the smoothed first states; inf where the motion diverges.

    ``shifts`` : of the rests, (n_trial, n) rad a start. All starts are lanes of one run a trial.
    """
    values, locals_ = np.stack(starts, axis=1), _first_locals(recordings)
    none = np.zeros((recordings[0].rotation.shape[1], len(starts)))

    def one(t: int) -> Array:
        shift = none if shifts is None else np.stack([found[t] for found in shifts], axis=1)
        out = model.predictions(recordings[t], values, locals_[t], shift)
        off = np.where(recordings[t].counts[:, :, None], out - recordings[t].rotation[:, :, None], 0.0)
        return np.where(np.all(np.isfinite(out), axis=(0, 1)), np.sum(off**2, axis=(0, 1)), np.inf)

    return np.asarray(np.sum(by_trial(one, len(recordings)), axis=0))


def _refine(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    values: Array,
    locals_: Sequence[Local],
    options: FitOptions,
    spread: Array,
    *,
    centre: Array | None = None,
    rounds: int = NOISE_ROUNDS,
) -> Stage:
    """Solve, estimate each joint's noise from the residuals, and solve again until the noise no longer changes."""
    relative, counts = _relative_noise(recordings, options), encoder_counts(recordings)
    lanes = by_trial(lambda t: model.sensitivity(recordings[t], values, locals_[t]), len(recordings))
    predictions = [found.prediction for found in lanes]
    noise = np.nan_to_num(root_mean_square(recordings, predictions), nan=0.1, posinf=0.1) + 1e-6
    weights = Weights(relative * noise, spread, centre)
    solution = solve(
        model, recordings, values, locals_, weights,
        max_iterations=25, tolerance=ROUGHLY, damping=NEAR_DAMPING, lanes=lanes,
    )  # fmt: skip
    del lanes
    for _ in range(rounds):
        if not np.isfinite(solution.cost):
            break
        found, rounding = _noise(recordings, solution.predictions, options, counts)
        change = np.abs(np.log(found / noise)).max()
        noise = found
        weights = Weights(relative * noise, spread, centre, rounding)
        solution = solve(
            model, recordings, solution.values, solution.locals, weights,
            tolerance=FINELY, damping=min(solution.damping, NEAR_DAMPING), lanes=solution.lanes,
        )  # fmt: skip
        if change < 0.02:
            break
    return Stage(solution, weights)


def _noise(
    recordings: Sequence[Recording], predictions: Sequence[Array], options: FitOptions, counts: Array
) -> tuple[Array, tuple[Rounding | None, ...]]:
    """(n,) rad each joint's noise as its residuals show it, and how counts (n,) rad coarser than it are reckoned with.

    Correlated residuals say less than their number: their noise counts as larger, so that the cost stays a
    log-likelihood and weighs rightly against the spread of the shifts and the prior.
    """
    off = [residuals(r, p) for r, p in zip(recordings, predictions, strict=True)]
    rounding: list[Rounding | None] = [None] * len(counts)
    if options.weight == "noise":
        rounding = [rounding_of(np.concatenate([each[:, j] for each in off]), w) for j, w in enumerate(counts)]
    told = [each.copy() for each in off]
    for j, item in enumerate(rounding):
        if item is not None:
            for each in told:
                each[:, j] = item.surprise(each[:, j], HUBER)
    times = correlation_times(recordings, [r.rotation + t for r, t in zip(recordings, told, strict=True)])
    found = root_mean_square(recordings, predictions) * np.sqrt(times)
    found = np.where(np.isfinite(found), found, 1.0) + 1e-7
    if options.weight == "equal":
        found = np.full_like(found, np.sqrt(np.mean(found**2)))
    for j, item in enumerate(rounding):
        if item is not None:
            rounding[j] = replace(item, correlation=float(times[j]))
            found[j] = item.noise * np.sqrt(times[j])
    return found, tuple(rounding)


def _relative_noise(recordings: Sequence[Recording], options: FitOptions) -> Array:
    """(n_trial, n) factor on each joint's noise: one, or the amplitude a trial over its mean."""
    if options.weight != "amplitude":
        return np.ones((len(recordings), recordings[0].rotation.shape[1]))
    amplitude = np.array([np.ptp(r.smoothed.angle, axis=0) for r in recordings])
    mean = np.maximum(amplitude.mean(axis=0), 1e-6)
    return np.asarray(np.maximum(amplitude / mean, 0.2))


def _or_another_start(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    best: Stage,
    options: FitOptions,
    scatter: Array,
    spread: Array,
) -> Stage:
    """The given stage if it comes near the samples' scatter; else the best of it and of a few starts in natural units.

    The weak form may have led into the wrong valley; a start is screened on a few trials before it is followed.
    """
    assert isinstance(model.unknowns, SpringsAndDampers)
    rms = root_mean_square(recordings, best.solution.predictions)
    if np.all((rms < POOR * scatter) | ~np.isfinite(scatter)):
        return best
    random = np.random.default_rng(options.seed)
    n, inertia = len(model.leg.joints), outboard_inertia(model.leg)
    rest = _mean_end(recordings)
    drawn = []
    for _ in range(SCREENED_STARTS):
        rate = inertia * (2 * np.pi * np.exp(random.uniform(np.log(1.0), np.log(10.0), n))) ** 2
        damping = inertia * np.exp(random.uniform(np.log(1.0), np.log(100.0), n))
        drawn.append(model.unknowns.pack(rate, rest + random.uniform(-0.2, 0.2, n), damping))
    every = max(1, len(recordings) // SCREENED_TRIALS)
    some, weights = recordings[::every], replace(best.weights, noise=best.weights.noise[::every])
    order = np.argsort(_quick_costs(model, some, drawn), kind="stable")
    drawn = [drawn[k] for k in order]
    here = solve(
        model, some, best.solution.values, best.solution.locals[::every], weights, max_iterations=12, tolerance=1
    )
    for values in drawn[:KEPT_STARTS]:
        found = solve(model, some, values, _first_locals(some), weights, max_iterations=12, tolerance=1)
        if found.cost < here.cost - 1.0:
            refined = _refine(model, recordings, found.values, _first_locals(recordings), options, spread)
            if np.isfinite(refined.solution.cost) and _misfit(recordings, refined) < _misfit(recordings, best):
                best = refined
    return best


def _misfit(recordings: Sequence[Recording], stage: Stage) -> float:
    """Sum over joints of the log RMS: what the likelihood compares once each joint's noise is its own residual."""
    return float(np.nansum(np.log(root_mean_square(recordings, stage.solution.predictions) + 1e-12)))


def _per_trial(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    values: Array,
    locals_: Sequence[Local],
    options: FitOptions,
    scatter: Array,
) -> tuple[Stage, Array, Array]:
    """Free angles a trial, first nearly free, then within the spread that this shows; spread (n,), probability (n,)."""
    n = len(model.leg.joints)
    wide = _refine(model, recordings, values, locals_, options, np.full(n, WIDE))
    wide = _or_another_start(model, recordings, wide, options, scatter, np.full(n, WIDE))
    shift = np.array([local.shift for local in wide.solution.locals])
    found = heterogeneity(shift, shift_variances(model, recordings, wide.solution))
    spread = np.maximum(found.spread, LEAST_SPREAD)
    stage = _refine(model, recordings, wide.solution.values, wide.solution.locals, options, spread)
    return stage, np.where(found.spread > LEAST_SPREAD, found.spread, 0.0), found.probability


def _choose(leg: Leg, spread: Array, probability: Array, options: FitOptions, n_trial: int) -> tuple[str, str]:
    """Common or per_trial, and why."""
    if n_trial == 1:
        return "common", "one trial alone cannot show a spread"
    if options.free_angle != "auto":
        return options.free_angle, "asked for"
    shifted = [j for j in range(len(leg.joints)) if probability[j] < SIGNIFICANCE / len(leg.joints)]
    if not shifted:
        least = float(np.min(probability))
        return "common", f"the {n_trial} trials show no shift of any free angle (least p = {least:.2g})"
    said = ", ".join(f"{leg.joint_names[j]} by {np.degrees(spread[j]):.2g} deg" for j in shifted)
    return "per_trial", f"the free angle shifts from trial to trial ({said}, one standard deviation)"
