"""The estimation method of a project: least squares, or one of the thesis' searches.

``least_squares`` needs no starting guess and is the default. ``piecewise`` and ``swarm`` are the
thesis' methods (``rate_search``, ``simplex``, ``swarm``), to reproduce or compare it: the least-squares result
for the same recordings is always computed and reported too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.project_options import FitOptions as Choice
from synth.fit.behind_filter import clear_of, seen_filter
from synth.fit.costs import Cost, emphasise_transient
from synth.fit.estimate import fit_leg
from synth.fit.filtered_readings import filtered_note, likely_filter
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import NOTHING_NEAR, model_of
from synth.fit.fit_result import FitResult
from synth.fit.free_angle import WIDE, heterogeneity
from synth.fit.free_motion_start import cut_of, detect_drive, start_sentence
from synth.fit.later_samples import recordings_from
from synth.fit.least_squares import FitStart, Stage, Weights, solve
from synth.fit.lost_frames import lost_frames
from synth.fit.rate_search import Bounds, CostByJoint, Search
from synth.fit.recordings import Recording
from synth.fit.report_fit import result_of
from synth.fit.treatments import FittedTreatments, Treatment
from synth.fit.uncertainty import clipped_rms, correlation_times, rms_as_recorded, shift_variances
from synth.motion.low_pass import SeenFilter
from synth.remarks import at_joint
from synth.swing.leg_model import DamperCurve, Leg

FAILED_SEARCH = 1.05  # times the RMS of least squares, above which a search counts as failed


def require_method(choice: Choice, file: str, *, static: bool = False, prior: bool = False) -> None:
    """Refuse contradictory options.

    Raises
    ------
    UserError : with the key in ``fit:`` to change.
    """
    problems = []
    if choice.method == "least_squares" and choice.cost == "characteristics":
        text = (
            "characteristics are discontinuous when a swing falls below the noise; least_squares needs derivatives. "
            "Write method: piecewise or swarm, or cost: trajectory or transient"
        )
        problems.append(Problem(text, file, key="fit.cost"))
    if choice.method != "least_squares":
        for key, given in (("static", static), ("prior", prior)):
            if given:
                text = f"{choice.method} uses the recordings only and would ignore it; use method: least_squares"
                problems.append(Problem(text, file, key=key))
        if choice.intervals == "bootstrap":
            text = f"its refits use least squares, not {choice.method}; use method: least_squares"
            problems.append(Problem(text, file, key="fit.intervals"))
    if problems:
        raise UserError(problems)


def fit_by(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions, choice: Choice) -> FitResult:
    """Fit a leg by the project's method and cost; see ``estimate.fit_leg``.

    A fit with ``options.near``, which adjusts an earlier one, always uses least squares.

    Raises
    ------
    UserError : nothing to fit, or no motion of the leg comes near the trials.
    """
    if options.near is not None:
        return fit_leg(leg, recordings, options)
    found = None if options.wanted or options.computed else lost_frames(leg, recordings, options)
    if found is None:
        return _fit_timed(leg, recordings, options, choice)
    result = _fit_timed(leg, found.recordings, options, choice)
    return replace(result, warnings=(*found.sentences, *result.warnings))


def _fit_timed(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions, choice: Choice) -> FitResult:
    """``fit_by``, of recordings whose time is believed."""
    if recordings and not (options.wanted or options.computed) and recordings[0].behind is None:
        seen = seen_filter(leg, recordings, options)
        if seen is not None:
            return _behind_filter(leg, recordings, options, choice, seen)
    if options.release == "free" and (choice.method, choice.cost) != ("least_squares", "trajectory"):
        return _after_hands(leg, recordings, options, choice)
    if choice.method == "least_squares":
        if choice.cost != "transient":
            return fit_leg(leg, recordings, options)
        return _over_all_samples(fit_leg(leg, emphasise_transient(recordings), options), recordings)
    if not recordings:
        raise UserError("no trial remains to fit: all are held out")
    return _search_rates(leg, recordings, options, choice)


def _behind_filter(
    leg: Leg, recordings: Sequence[Recording], options: LegFitOptions, choice: Choice, seen: SeenFilter
) -> FitResult:
    """Like ``fit_by``, of filtered readings: without what the filter smears, unless all samples are asked for."""
    cut, reach = [replace(recording, behind=seen) for recording in recordings], 0.0
    if options.release == "free":
        cut, reach = clear_of(recordings, seen)
    result = _fit_timed(leg, cut, options, choice)
    return replace(result, cut=result.cut + reach, warnings=(filtered_note(seen, reach), *result.warnings))


def _after_hands(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions, choice: Choice) -> FitResult:
    """Like ``fit_by``, without the driven beginning that most recordings show."""
    drive, free = detect_drive(leg, recordings), replace(options, release="recorded")
    cut = recordings_from(recordings, cut_of(drive)) if drive.accepted else None
    if cut is None:
        return _fit_timed(leg, recordings, free, choice)
    result = _fit_timed(leg, cut, free, choice)
    note = start_sentence(drive, cut_of(drive), None, likely_filter(recordings))
    return replace(result, cut=cut_of(drive), warnings=(note, *result.warnings))


def search_of(
    leg: Leg,
    recordings: Sequence[Recording],
    cost: CostByJoint,
    curves: Mapping[str, DamperCurve] | None = None,
    *,
    common: bool = False,
) -> Search:
    """A search for the rates of a leg; its own springs and dampers are ignored except known ``curves``."""
    return Search(model_of(leg, curves, recordings=recordings), recordings, cost, common)


def _search_rates(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions, choice: Choice) -> FitResult:
    """The thesis' method: piecewise, and from there the swarm."""
    cost = Cost(choice.cost, tuple(recordings), options.weight)
    search = search_of(leg, recordings, cost, options.curves, common=options.free_angle == "common")
    start = search.first([options.curves.get(name) for name in leg.joint_names])
    bounds = Bounds.around(start)
    rates, stages = search.piecewise(start, bounds)
    iterations = sum(stage.iterations for stage in stages)
    if choice.method == "swarm":
        rates, found = search.swarm(rates, bounds, seed=options.seed)
        iterations = found.iterations
    result = _assemble_result(search, rates, options, len(recordings))
    names = leg.joint_names
    searched = [j for j, name in enumerate(names) if result.joints[name].estimated]
    edges = [
        at_joint(
            names[j],
            f"the {what} is at a bound of the {choice.method} search, "
            f"{bounds.lower[row, j]:.3g} to {bounds.upper[row, j]:.3g} {unit}",
        )
        for row, (what, unit) in enumerate((("spring rate", "N*m/rad"), ("damper rate", "N*m*s/rad")))
        for j in searched
        # Within 0.1 %: a search stops short of a bound.
        if not 1.001 * bounds.lower[row, j] < rates[row, j] < 0.999 * bounds.upper[row, j]
    ]
    beside = _compare_with_least_squares(result, fit_leg(leg, recordings, options), choice)
    return replace(
        result,
        method=choice.method,
        cost=choice.cost,
        iterations=iterations,
        reason=f"searched with {search.calls} calls of the engine",
        warnings=(*beside, *edges, *result.warnings),
    )


def _assemble_result(search: Search, rates: Array, options: LegFitOptions, n_trial: int) -> FitResult:
    """The result at these rates (2, n), with intervals from the trajectories' sensitivities there."""
    model, recordings = search.model, search.recordings
    middle, own = search.locals(rates[0])
    values = search.unknowns.pack(rates[0], middle, rates[1])
    n = search.n
    predictions = [motion[:, :, 0] for motion in search.motions(rates[:, :, None])]
    noise = clipped_rms(recordings, predictions) * np.sqrt(correlation_times(recordings, predictions))
    noise = np.where(np.isfinite(noise), noise, 1.0) + 1e-7
    shift = np.array([local.shift for local in own])
    free = np.array([np.isin(np.arange(n), recording.free) for recording in recordings])
    # A trial that still moves ends beside its rest, so its pose there alone would show a spread that is none: the
    # spread is that of the free angles with which the found rates fit each whole trial, less their errors.
    almost_free = Weights(noise, np.full(n, WIDE))
    each = solve(model, recordings, FitStart(values, own), almost_free, fixed=True)
    if not np.isfinite(each.cost):
        raise UserError(NOTHING_NEAR)
    errors = np.where(free, shift_variances(model, recordings, each), np.nan)
    found = heterogeneity(np.array([local.shift for local in each.locals]), errors)
    spread, per_trial = found.spread, (found.spread, found.ends, found.excess)
    weights = Weights(noise, np.maximum(spread, 1e-9), shift)
    solution = solve(model, recordings, FitStart(values, own), weights, max_iterations=0)
    scatter = np.array([r.smoothed.noise for r in recordings]).mean(axis=0)
    mode = "common" if search.common or n_trial == 1 else "per_trial"
    why = "each trial's from the pose in which it ends" if mode == "per_trial" else "from the poses in which trials end"
    stage = Stage(solution, weights)
    treatments = {mode: Treatment(stage, *per_trial) if mode == "per_trial" else Treatment(stage, np.zeros(n))}
    return result_of(model, recordings, FittedTreatments(treatments, mode, why, searched=True), scatter, options)


def _compare_with_least_squares(result: FitResult, best: FitResult, choice: Choice) -> list[str]:
    """Sentences that compare a search's result with least squares."""
    here, there = (np.array([r.rms[name] for name in r.leg.joint_names]) for r in (result, best))
    overall = [float(np.degrees(np.sqrt(np.nanmean(rms**2)))) for rms in (here, there)]
    messages = [
        f"{choice.method} with the cost {choice.cost} leaves {overall[0]:.3g} deg (RMS), least squares on the same "
        f"recordings {overall[1]:.3g} deg"
    ]
    if overall[0] > FAILED_SEARCH * overall[1]:
        messages[0] += "; the intervals describe the recordings, not the distance of this search from the optimum"
    for name, joint in result.joints.items():
        if not joint.estimated:
            continue
        other = best.joints[name]
        parts = [f"k {100 * (joint.spring_rate.value / other.spring_rate.value - 1):+.0f} %"]
        if joint.damper_rate is not None and other.damper_rate is not None:
            parts.append(f"b {100 * (joint.damper_rate.value / other.damper_rate.value - 1):+.0f} %")
        messages.append(at_joint(name, f"compared with least squares {', '.join(parts)}"))
    return messages


def _over_all_samples(result: FitResult, recordings: Sequence[Recording]) -> FitResult:
    """A result of thinned recordings with its residuals over all their samples."""
    leg = result.leg
    predictions = [leg.to_rotation(trial.fitted) for trial in result.trials]
    rms, clipped = (measure(recordings, predictions).tolist() for measure in (rms_as_recorded, clipped_rms))
    trials = []
    for trial, recording in zip(result.trials, recordings, strict=True):
        measured = leg.to_measured(np.where(recording.counts, recording.rotation, np.nan))
        counted, off = recording.counts.any(axis=0), np.full(len(leg.joints), np.nan)
        off[counted] = np.sqrt(np.nanmean((measured - trial.fitted)[:, counted] ** 2, axis=0))
        if recording.spread is not None:
            off = rms_as_recorded([recording], [leg.to_rotation(trial.fitted)])
        trials.append(replace(trial, measured=measured, rms=off))
    return replace(
        result,
        rms=dict(zip(leg.joint_names, rms, strict=True)),
        clipped_rms=dict(zip(leg.joint_names, clipped, strict=True)),
        trials=tuple(trials),
        cost="transient",
    )
