"""Fit a leg to recordings: weak form, then trajectories, then the choice of common or separate free angles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.fit.another_law import another_law, law_suspected, searched_recordings
from synth.fit.filtered_readings import likely_filter
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import NOTHING_NEAR, model_of, unknowns_of
from synth.fit.fit_result import FitResult, JointFit
from synth.fit.free_angle import (
    LEAST_SPREAD,
    WIDE,
    excess_of_common,
    excess_of_fixed,
    heterogeneity,
    shifts_seen,
    spread_of_another,
)
from synth.fit.free_motion_start import (
    Drift,
    LateFreeMotion,
    cut_of,
    detect_drive,
    drift_of_noise,
    hidden_drive,
    start_sentence,
)
from synth.fit.joint_laws import AnotherLaw
from synth.fit.lasting_noise import lasting_variances
from synth.fit.later_samples import recordings_from
from synth.fit.least_squares import FitStart, Solution, Stage, solve
from synth.fit.link_errors import link_widths
from synth.fit.misfits import MOST_OF_NOISE
from synth.fit.model_error import ModelError
from synth.fit.pieces_start import refine_by_pieces
from synth.fit.point_check import CheckedPoints, check_points, without_balances
from synth.fit.recordings import Recording
from synth.fit.refinement import misfit, refine, refine_other_starts
from synth.fit.report_fit import result_of
from synth.fit.ridge import MISFIT, soften
from synth.fit.starts import first_locals, weak_form_start
from synth.fit.stated_knowledge import stated_knowledge
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.treatments import FittedTreatments, Treatment
from synth.fit.uncertainty import clipped_rms, root_mean_square, sample_scatter, shift_variances
from synth.swing.leg_model import Leg

# Sum of the logarithms of the joints' RMS residuals, by which separate free angles may fit worse than a common one,
# which they include. More: their iteration ended short of the optimum, as at a joint so damped that its inertia is
# hidden, where residuals that are still correlated count as noise. They are then fitted again from the common one's.
WORSE_RESIDUALS = 0.01
# Times the residuals after a cut, up to which those of a law in all samples count as alike: over two hundred samples
# each the ratio of two estimates of the same noise has a deviation of 7 %.
ALIKE_RESIDUALS = 1.1
# Of a shift's variance over the one by the residuals' noise, if noise lasts and a trial's own unknowns take it up: its
# deviation was up to 3.3 times as large in fifty simulated legs. A shift that is beyond a hundred is no such noise.
MOST_TAKEN_UP = 100.0


def fit_leg(
    leg: Leg,
    recordings: Sequence[Recording],
    options: LegFitOptions | None = None,
    *,
    error: ModelError | None = None,
    start: Array | None = None,
) -> FitResult:
    """Estimate spring rate, free angle and damper rate of every joint.

    Parameters
    ----------
    leg : links and gravity; its own springs and dampers are used only through ``options.prior``.
    recordings : at least one; each trial's initial state is estimated too.
    error : of the model, which the intervals are to include.
    start : (p,) common unknowns near the estimate; None to find them by the weak form.

    Raises
    ------
    UserError : there is no trial, or the simulation diverges from every start.
    """
    if not recordings:
        raise UserError("no trial remains to fit: all are held out")
    options = options or LegFitOptions()
    if options.near is not None:
        return _fit_near(leg, recordings, options, options.near)
    return _fit_checked(leg, recordings, options, _checked_points(leg, recordings, options), error, start)


def least_residuals(leg: Leg, recordings: Sequence[Recording], free_angle: str) -> Array:
    """(n,) rad RMS of each joint's angles in the fit of springs and linear dampers, without intervals or a result.

    ``free_angle`` : ``common`` or ``per_trial``, as of a result. All samples are fitted. Infinite where it diverges;
    nan for a joint without samples.
    """
    options = LegFitOptions("per_trial" if free_angle == "per_trial" else "common", release="recorded", laws="linear")
    treatments, _ = _treatments(
        model_of(leg, recordings=recordings), recordings, options, sample_scatter(recordings), None
    )
    solution = treatments.get(options.free_angle, treatments["common"]).stage.solution
    if not np.isfinite(solution.cost):
        return np.full(len(leg.joints), np.inf)
    return root_mean_square(recordings, solution.predictions)


def _checked_points(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions) -> CheckedPoints:
    """The static points that do not contradict the fit to the recordings alone."""
    if not options.static:
        return CheckedPoints(())
    alone, scatter = replace(options, static=()), sample_scatter(recordings)
    model = model_of(leg, options.curves, recordings=recordings, prior=options.prior)
    treatments, probability = _treatments(model, recordings, alone, scatter, None)
    mode, _ = _choose(leg, treatments, probability, alone, len(recordings))
    return check_points(model, recordings, treatments[mode].stage, options, scatter)


def _fit_checked(
    leg: Leg,
    recordings: Sequence[Recording],
    asked: LegFitOptions,
    points: CheckedPoints,
    error: ModelError | None,
    start: Array | None,
) -> FitResult:
    """The fit with the ``points`` of those ``asked``.

    Fits to later samples, or with another law, are asked anew: a point may contradict this model only.
    """
    options = replace(asked, static=points.static)
    model = model_of(leg, options.curves, recordings=recordings, prior=options.prior, static=options.static)
    drive = detect_drive(leg, recordings) if options.release == "free" else None
    if drive is not None and drive.accepted and recordings_from(recordings, cut_of(drive)) is not None:
        law = _law_of_all_samples(model, recordings, options) if options.laws == "auto" else None
        if law is not None and law.named:
            return _fit_with(law, recordings, asked)
        note = start_sentence(drive, cut_of(drive), None, likely_filter(recordings))
        later = partial(_fit_later, leg, recordings, asked, cut_of(drive), note)
        return cut_or_law(model, later(), law, later)
    scatter = sample_scatter(recordings)
    treatments, probability = _treatments(model, recordings, options, scatter, start)
    mode, why = _choose(leg, treatments, probability, options, len(recordings))
    chosen = treatments[mode]
    if not np.isfinite(chosen.stage.solution.cost):
        raise UserError(NOTHING_NEAR)
    hidden, law = None, None
    if drive is not None:
        hidden = hidden_drive(model, recordings, chosen.stage, options, cut_of(drive) if drive.ends else 0.0)
    if options.laws == "auto" and (hidden is not None or law_suspected(recordings, chosen.stage, scatter)):
        law = another_law(leg, recordings, chosen.stage, options, scatter)
        if law is not None and law.named:
            return _fit_with(law, recordings, asked)
    if drive is not None and hidden is not None and law is None:  # no law explains any of it: is it the noise?
        hidden = drift_of_noise(model, recordings, chosen.stage, options, hidden.probability) or hidden
    if drive is not None and isinstance(hidden, LateFreeMotion):
        note = start_sentence(drive, hidden.cut, hidden, likely_filter(recordings))
        later = partial(_fit_later, leg, recordings, asked, hidden.cut, note)
        return cut_or_law(model, later(), law, later)
    softened = _soften_stage(model, recordings, chosen.stage, scatter)
    treatments[mode] = replace(chosen, stage=softened.stage)
    # Along a ridge that was moved the trials do not tell the rate, and what is stated of it holds it by itself.
    stated = None
    if softened.least is None:
        widths = link_widths(leg, options.tolerance, recordings)
        stated = stated_knowledge(leg, model, recordings, softened.stage, widths, options.static)
    if stated is not None:
        model = model_of(stated.leg, options.curves, recordings=recordings, prior=options.prior, static=options.static)
        treatments = {name: _with_links(model, recordings, each, stated.values) for name, each in treatments.items()}
    if isinstance(hidden, Drift):
        error = hidden.error
    fitted = FittedTreatments(
        treatments, mode, why, softened=softened.sentences, least=softened.least, error=error,
        left_out=points.left_out, stated=stated,
    )  # fmt: skip
    return result_of(model, recordings, fitted, scatter, options)


def _with_links(
    model: TrajectoryModel, recordings: Sequence[Recording], treatment: Treatment, values: Array
) -> Treatment:
    """The treatment solved again from these values (p,), with other links than before."""
    stage = treatment.stage
    if not np.isfinite(stage.solution.cost):
        return treatment
    found = solve(model, recordings, FitStart(values, stage.solution.locals), stage.weights)
    return replace(treatment, stage=Stage(found, stage.weights))


def _law_of_all_samples(
    model: TrajectoryModel, recordings: Sequence[Recording], options: LegFitOptions
) -> AnotherLaw | None:
    """The law that explains all samples, where each recording by itself seems to be driven at first."""
    some, none = searched_recordings(recordings), np.zeros(len(model.leg.joints))
    scatter = sample_scatter(some)
    start = FitStart(weak_form_start(model, some, options).values, first_locals(some))
    stage = refine(model, some, start, options.weight, none)
    if not np.isfinite(stage.solution.cost):
        return None
    return another_law(model.leg, some, stage, options, scatter)


def _fit_later(
    leg: Leg,
    recordings: Sequence[Recording],
    options: LegFitOptions,
    start: float,
    note: str,
    error: ModelError | None = None,
) -> FitResult:
    """The fit to the samples from ``start`` s after each recording's first one."""
    cut = recordings_from(recordings, start)
    assert cut is not None
    result = fit_leg(leg, cut, replace(options, release="recorded"), error=error)
    return replace(result, cut=start, warnings=(note, *result.warnings))


def cut_or_law(
    model: TrajectoryModel, cut: FitResult, law: AnotherLaw | None, again: Callable[[ModelError], FitResult]
) -> FitResult:
    """The fit ``cut`` to later samples, or that fit ``again`` where a law leaves no more a sample in all of them.

    Which of the two it is the recordings do not tell then, and the intervals hold for either.
    """
    if law is None or cut.law or np.any(law.rms > ALIKE_RESIDUALS * np.array(list(cut.averaged_rms.values()))):
        return cut
    return again(law.error_of_cut(_common_values(model, cut)))


def _fit_with(law: AnotherLaw, recordings: Sequence[Recording], options: LegFitOptions) -> FitResult:
    """The fit of the leg with the law, from all samples; its coefficients' uncertainty is in the intervals."""
    given = replace(options, laws="linear", release="recorded")
    return replace(fit_leg(law.leg, recordings, given, error=law.error, start=law.values), law=law.as_json())


@dataclass(frozen=True)
class _SoftenedStage:
    """A stage moved along its ridges, the messages on that, and the least-residual solution if it was left."""

    stage: Stage
    sentences: tuple[str, ...] = ()
    least: Solution | None = None


def _fit_near(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions, near: FitResult) -> FitResult:
    """Fit from an earlier result of the same recordings, with each trial's free angle fixed.

    Free, they would absorb the damper's curve: a slow leg in the model would appear to rest
    elsewhere in every trial, and a spring that is far too soft would fit. Points that it left out stay so.
    """
    left_out = [point.balance for point in near.static if point.left_out]
    options = replace(options, static=without_balances(options.static, left_out))
    model = model_of(leg, options.curves, recordings=recordings, prior=options.prior, static=options.static)
    joints = [near.joints[name] for name in model.leg.joint_names]
    common = np.array([joint.free_angle.value for joint in joints])
    spread = np.array([joint.free_angle_spread.value for joint in joints])
    locals_ = [
        Local(trial.rotation, trial.rate, model.leg.sign * (trial.free_angle - common)) for trial in near.trials
    ][: len(recordings)]
    values = _common_values(model, near)
    shifts = np.array([local.shift for local in locals_])
    free = np.array([recording.counts.any(axis=0) for recording in recordings])
    stage = refine(
        model, recordings, FitStart(values, locals_), options.weight, np.full_like(spread, LEAST_SPREAD),
        centre=shifts, points=spread_of_another(spread, free.sum(axis=0).tolist()), rounds=2,
    )  # fmt: skip
    if not np.isfinite(stage.solution.cost):
        raise UserError(NOTHING_NEAR)
    why = "each trial's shift as in the previous fit"
    of_mean = excess_of_fixed(shifts, free) if near.free_angle == "per_trial" else None
    treatments = {near.free_angle: Treatment(stage, spread, _ends_of(joints), of_mean)}
    scatter = sample_scatter(recordings)
    return result_of(model, recordings, FittedTreatments(treatments, near.free_angle, why), scatter, options)


def _common_values(model: TrajectoryModel, result: FitResult) -> Array:
    """(p,) common unknowns of a result."""
    joints = [result.joints[name] for name in model.leg.joint_names]
    rates = np.array([joint.spring_rate.value for joint in joints])
    damping = np.array([joint.damper_rate.value if joint.damper_rate is not None else 0.0 for joint in joints])
    common = np.array([joint.free_angle.value for joint in joints])
    return unknowns_of(model).pack(rates, model.leg.to_rotation(common), damping)


def _ends_of(joints: Sequence[JointFit]) -> Array:
    """(2, n) rad, of the spreads' intervals; nan where there is none."""
    ends = [(joint.free_angle_spread.low, joint.free_angle_spread.high) for joint in joints]
    return np.array([[np.nan if end is None else end for end in pair] for pair in ends]).T


def _treatments(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    options: LegFitOptions,
    scatter: Array,
    start: Array | None,
) -> tuple[dict[str, Treatment], Array]:
    """The leg with separate free angles, if allowed, and with common ones; and the probability (n,) of the shifts.

    The probability of such shifts without any spread; one if not tested.
    """
    n = len(model.leg.joints)
    guess = weak_form_start(model, recordings, options)
    values, locals_ = guess.values if start is None else start, first_locals(recordings)
    made: dict[str, Treatment] = {}
    probability, of_mean = np.ones(n), np.zeros(n)
    if options.free_angle != "common" and len(recordings) > 1:
        shifted = [replace(local, shift=shift) for local, shift in zip(locals_, guess.shifts, strict=True)]
        made["per_trial"], probability, of_mean = _per_trial(model, recordings, values, shifted, options, scatter)
        solution = made["per_trial"].stage.solution
        values = solution.values
        if np.isfinite(solution.cost):
            locals_ = [replace(local, shift=np.zeros_like(local.shift)) for local in solution.locals]
    none = np.zeros(n)
    stage = refine(model, recordings, FitStart(values, locals_), options.weight, none)
    if not made:
        stage = refine_other_starts(model, recordings, stage, scatter, none, weight=options.weight, seed=options.seed)
        stage = refine_by_pieces(model, recordings, stage, values, options.weight, none)
    made["common"] = Treatment(stage, none, of_mean=of_mean)
    if (
        "per_trial" in made
        and misfit(recordings, stage) < misfit(recordings, made["per_trial"].stage) - WORSE_RESIDUALS
    ):
        solution = stage.solution
        made["per_trial"], probability, of_mean = _per_trial(
            model, recordings, solution.values, solution.locals, options, scatter
        )
        made["common"] = replace(made["common"], of_mean=of_mean)
    return made, probability


def _per_trial(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    values: Array,
    locals_: Sequence[Local],
    options: LegFitOptions,
    scatter: Array,
) -> tuple[Treatment, Array, Array]:
    """Separate free angles, first almost free, then within the spread found; probability (n,).

    Static points are first exact: where trials tell little but b/k, rates far off would falsify the spread.
    Shifts for which the noise seems too small are tested again with what the trials' own unknowns took up of noise
    that lasts. Last (n,) rad^2 by which that makes a common free angle less known.
    """
    weight, nearly_free = options.weight, np.full(len(model.leg.joints), WIDE)
    wide = refine(model, recordings, FitStart(values, locals_), weight, nearly_free)
    wide = refine_other_starts(model, recordings, wide, scatter, nearly_free, weight=weight, seed=options.seed)
    wide = refine_by_pieces(model, recordings, wide, values, weight, nearly_free)
    shift = np.array([local.shift for local in wide.solution.locals])
    variances, of_mean = shift_variances(model, recordings, wide.solution), np.zeros(len(model.leg.joints))
    found = heterogeneity(shift, variances)
    certain = heterogeneity(shift, MOST_TAKEN_UP * variances)
    of_noise = not np.any(clipped_rms(recordings, wide.solution.predictions) > MOST_OF_NOISE * scatter)
    if of_noise and np.any(shifts_seen(found.probability) & ~shifts_seen(certain.probability)):
        lasting = lasting_variances(model, recordings, wide, variances)
        tested = heterogeneity(shift, lasting)
        if not np.any(shifts_seen(tested.probability)):  # else each trial has its own free angles anyway
            found, of_mean = tested, excess_of_common(variances, lasting)
    spread = np.maximum(found.spread, LEAST_SPREAD)
    stage = refine(model, recordings, FitStart.at(wide.solution), weight, spread, points=found.of_another)
    kept = np.where(found.spread > LEAST_SPREAD, found.spread, 0.0)
    return Treatment(stage, kept, found.ends, found.excess), found.probability, of_mean


def _soften_stage(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, scatter: Array
) -> _SoftenedStage:
    """The softest leg that fits equally well, if the model error makes the least residual meaningless."""
    rms = clipped_rms(recordings, stage.solution.predictions)
    if not np.any(rms > MISFIT * scatter):
        return _SoftenedStage(stage)
    moved = soften(model, recordings, stage.solution, stage.weights)
    least = stage.solution if moved.sentences else None
    return _SoftenedStage(Stage(moved.solution, stage.weights), moved.sentences, least)


def _choose(
    leg: Leg, treatments: Mapping[str, Treatment], probability: Array, options: LegFitOptions, n_trial: int
) -> tuple[str, str]:
    """Common or per_trial, with the reason; ``probability`` (n,) as in ``_treatments``."""
    if n_trial == 1:
        return "common", "a single trial shows no spread"
    if options.free_angle != "auto":
        return options.free_angle, "asked for"
    shifted = np.flatnonzero(shifts_seen(probability)).tolist()
    if not shifted:
        least = float(np.min(probability))
        return "common", f"the {n_trial} trials show no shift of any free angle (least p = {least:.2g})"
    spread = treatments["per_trial"].spread
    note = ", ".join(f"{leg.joint_names[j]} by {np.degrees(spread[j]):.2g} deg" for j in shifted)
    return "per_trial", f"the free angle shifts from trial to trial ({note}, one standard deviation)"
