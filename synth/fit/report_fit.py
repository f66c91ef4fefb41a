"""From solved stages to a ``FitResult``: intervals, trials with their fit, and messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import Estimate
from synth.fit.behind_filter import bent_by_filter
from synth.fit.bootstrap import Bootstrap, bootstrap
from synth.fit.draws import DrawnLegs, draws
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import unknowns_of
from synth.fit.fit_result import FitResult, JointFit, Variant
from synth.fit.interval_ends import interval_ends
from synth.fit.interval_sources import sources_of
from synth.fit.joint_correlation import spread_of
from synth.fit.known import Known, with_links_and_law
from synth.fit.later_samples import untold_start
from synth.fit.least_squares import Solution, Stage, resimulated
from synth.fit.left_out_trials import moved_by_one_trial
from synth.fit.link_errors import LinkErrors, link_errors, link_widths
from synth.fit.lost_motion import sentences_on_trials
from synth.fit.misfits import beyond_noise, follower, lacking, misfits
from synth.fit.none_rates import NoneRates, none_rates
from synth.fit.proposal import proposals
from synth.fit.rate_spread import spread_over_trials
from synth.fit.recordings import Recording, sentences_on_reading
from synth.fit.ridge import MISFIT
from synth.fit.ridge_family import RidgeFamily, families
from synth.fit.search_box import NEAR_ANGLE, NEAR_LOGARITHM
from synth.fit.stated_knowledge import with_stated
from synth.fit.static_points import JudgedPoint, judge_points
from synth.fit.trajectories import TrajectoryModel
from synth.fit.treatments import FittedTreatments, Treatment
from synth.fit.trial_fits import trial_fits
from synth.fit.uncertainty import (
    clipped_rms,
    covariance,
    mass_scale_sentence,
    not_separable,
    rms_as_recorded,
    scatter_as_recorded,
)
from synth.fit.unknowns import SpringsAndDampers
from synth.remarks import Remark, at_joint, noted
from synth.swing.effects import effect_named
from synth.swing.leg_model import Damper, Leg, Spring

MISPLACED_POINT = 3.0  # standard deviations from which a static point is reported


def result_of(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    fitted: FittedTreatments,
    scatter: Array,
    options: LegFitOptions,
) -> FitResult:
    """Assemble the result.

    ``scatter`` (n,) rad, the readings' noise. ``options.intervals``: of the chosen treatment's estimates, from
    ``sensitivities`` or ``bootstrap``; all include the uncertainty of the links, ``options.tolerance``.
    """
    fitted, widths = _resimulate_all(model, recordings, fitted), link_widths(model.leg, options.tolerance, recordings)
    treatments, mode, leg, names = fitted.treatments, fitted.mode, model.leg, model.leg.joint_names
    unknowns, solutions = unknowns_of(model), {name: each.stage.solution for name, each in treatments.items()}
    (excess, differ), chosen = _excesses(model, recordings, fitted, options), solutions[mode]
    spreads = {n: spread_of(model, recordings, t.stage, options.weight) + excess[n] for n, t in treatments.items()}
    refits, lost = _refits(model, recordings, fitted.stage, (spreads[mode], excess[mode]), options)
    links = {n: link_errors(model, recordings, t.stage, widths, options.static) for n, t in treatments.items()}
    spreads[mode], links[mode] = with_stated(fitted, (spreads[mode], covariance(model, chosen)), links[mode])
    alone, nones = _none_rates(model, fitted, solutions, links, excess[mode])
    offsets = interval_ends(unknowns, (mode, chosen), spreads, refits, nones, fitted.error, fitted.least)
    joints = {name: _joints(unknowns, each, offsets[name]) for name, each in treatments.items()}
    rms = {name: _by_joint_name(names, rms_as_recorded(recordings, s.predictions)) for name, s in solutions.items()}
    own_angles = _own_free_angles(unknowns, mode, offsets[mode])
    static, edges = _static(unknowns, fitted), at_edges(unknowns, chosen.values, nones[mode].places)
    drawn = _draws(fitted, spreads[mode], refits, nones[mode].links, options.seed)
    made, left = _fitted_leg(leg, joints[mode]), clipped_rms(recordings, chosen.predictions)
    trials = trial_fits(leg, joints[mode], recordings, chosen.locals, chosen.predictions)
    clipped, noise = (_by_joint_name(names, each) for each in (left, scatter_as_recorded(recordings, scatter)))
    alike = _equal_pairs(model, recordings, fitted, misfit=bool(np.any(left > MISFIT * scatter)))
    beyond = beyond_noise(recordings, left, scatter) & (options.wanted or (not differ and fitted.error is None))
    ridges, scale = (*fitted.softened, *(e.sentence for e in alike)), _mass_scale(unknowns, recordings, fitted, options)
    total, told = with_links_and_law(nones[mode].links, fitted.error, alone), _by_unknown(unknowns, joints[mode])
    known = Known(alone, total, chosen.values, offsets[mode], told, widths, fitted.least)
    return FitResult(
        leg=made,
        joints=joints[mode],
        rms=rms[mode],
        clipped_rms=clipped,
        trials=trials,
        free_angle=mode,
        free_angle_why=fitted.why,
        variants=tuple(_variant(name, joints[name], rms[name], each.spread) for name, each in treatments.items()),
        noise=noise,
        not_separable=(*not_separable(unknowns, known), *ridges, *scale),
        warnings=(
            *(*_first_sentences(fitted, leg, recordings, options), *lost),
            *([] if fitted.searched else misfits(rms[mode], noise, lacking(left, scatter), options, beyond)),
            *(*differ, *_moved(model, recordings, fitted, told, options, lacks=bool(lacking(left, scatter).any()))),
            *sentences_on_trials(model, recordings, made, trials, chosen, own_angles, follower(options)),
            *(*edges.values(), *_left_out(leg), *_contradicting_points(leg, static)),
        ),
        at_bound=tuple(edges),
        method="least_squares",
        iterations=chosen.iterations,
        reason=chosen.reason,
        lost_samples=sum(recording.n_lost for recording in recordings),
        static=static,
        proposals=proposals(unknowns, recordings, chosen.values, known, fitted.stage.weights.points),
        families=alike,
        drawn=DrawnLegs.of(unknowns, nones[mode].drawn(unknowns, chosen.values, drawn)),
        intervals={"by": "bootstrap", **refits.as_json(unknowns.names)} if refits else {"by": "sensitivities"},
        sources=sources_of(unknowns, known, nones[mode].links, fitted.error),
    )


def _moved(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    fitted: FittedTreatments,
    told: Mapping[str, Estimate],
    options: LegFitOptions,
    *,
    lacks: bool,
) -> list[str]:
    """Sentences on rates that depend on a single trial; where the model explains all joints, intervals tell it."""
    if not lacks or fitted.searched or options.wanted:
        return []
    return moved_by_one_trial(model, recordings, fitted.stage, fitted.least, told)


def _resimulate_all(
    model: TrajectoryModel, recordings: Sequence[Recording], fitted: FittedTreatments
) -> FittedTreatments:
    """Every treatment with its predictions and information at its own estimates."""
    treatments = {
        name: replace(each, stage=resimulated(model, recordings, each.stage))
        for name, each in fitted.treatments.items()
    }
    return replace(fitted, treatments=treatments)


def _by_unknown(unknowns: SpringsAndDampers, joints: Mapping[str, JointFit]) -> dict[str, Estimate]:
    """The estimates by the unknowns' names."""
    named = [(name, *name.split(" ", 1)) for name in unknowns.names]
    return {name: getattr(joints[joint], kind) for name, kind, joint in named}


def _by_joint_name(names: Sequence[str], values: Array) -> dict[str, float]:
    """Values (n,) by the joints' names."""
    return dict(zip(names, values.tolist(), strict=True))


def _first_sentences(
    fitted: FittedTreatments, leg: Leg, recordings: Sequence[Recording], options: LegFitOptions
) -> tuple[str, ...]:
    """The first sentences: on static points left out, on the model's law, on the start, and on what is fitted."""
    points = [each.sentence(leg.joint_names[each.balance.joint]) for each in fitted.left_out]
    laws = [fitted.error.sentence] if fitted.error is not None else []
    laws += fitted.stated.sentences if fitted.stated is not None else ()
    if options.release == "free" and fitted.error is None:
        laws += untold_start(recordings, fitted.stage.weights.spread)
    once = fitted.seen_once(leg.joint_names, recordings)
    return (*points, *laws, *once, *sentences_on_reading(recordings))


def _none_rates(
    model: TrajectoryModel,
    fitted: FittedTreatments,
    solutions: Mapping[str, Solution],
    links: Mapping[str, LinkErrors | None],
    excess: Array,
) -> tuple[Array, dict[str, NoneRates]]:
    """The chosen treatment's covariance (p, p) by the trials alone; and each treatment's rates not told from none.

    ``excess`` (p, p), of the chosen treatment, see ``_excess``.
    """
    unknowns, mode = unknowns_of(model), fitted.mode
    alone = {name: covariance(model, solution, with_prior=False) for name, solution in solutions.items()}
    nones = {name: none_rates(unknowns, s, alone[name], links[name]) for name, s in solutions.items() if name != mode}
    nones[mode] = none_rates(unknowns, solutions[mode], alone[mode], links[mode], fitted.error, fitted.least)
    return alone[mode] + excess, nones


def _excess(model: TrajectoryModel, recordings: Sequence[Recording], treatment: Treatment) -> Array:
    """(p, p) covariance of what neither readings' noise nor links explain: free angles' spread, a filter's bending."""
    bent = bent_by_filter(model, recordings, treatment.stage)
    spread = treatment.excess(unknowns_of(model), covariance(model, treatment.stage.solution))
    return spread + np.outer(bent, bent)


def _excesses(
    model: TrajectoryModel, recordings: Sequence[Recording], fitted: FittedTreatments, options: LegFitOptions
) -> tuple[dict[str, Array], list[str]]:
    """Each treatment's ``_excess`` with what its trials differ by; and the chosen one's sentences on that."""
    apart = {name: spread_over_trials(model, recordings, fitted, name, options) for name in fitted.treatments}
    excess = {name: _excess(model, recordings, t) + apart[name].covariance for name, t in fitted.treatments.items()}
    return excess, apart[fitted.mode].sentences


def _draws(
    fitted: FittedTreatments, spread: Array, refits: Bootstrap | None, links: LinkErrors | None, seed: int
) -> Array:
    """Draws (k, p) of the unknowns, with the model's error in them."""
    drawn = draws(fitted.stage.solution.values, spread, refits, links, seed)
    return drawn if fitted.error is None else fitted.error.added_to(drawn, seed)


def _equal_pairs(
    model: TrajectoryModel, recordings: Sequence[Recording], fitted: FittedTreatments, *, misfit: bool
) -> tuple[RidgeFamily, ...]:
    """The pairs of rates that fit equally well; where the model misfits, by its residuals and not by its cost."""
    if fitted.searched:
        return ()
    return families(model, recordings, fitted.stage, fitted.least or (fitted.stage.solution if misfit else None))


def _refits(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    stage: Stage,
    spread: tuple[Array, Array],
    options: LegFitOptions,
) -> tuple[Bootstrap | None, list[str]]:
    """The bootstrap's refits if requested, or None with the reason.

    ``spread`` : covariances (p, p) of all, and of the part that refits do not show; see ``_excess``.
    """
    if options.intervals != "bootstrap":
        return None, []
    try:
        refits = bootstrap(model, recordings, stage, spread[0], seed=options.seed)
        return refits.widened(spread[1], options.seed), []
    except ArithmeticError as error:
        return None, [noted(f"bootstrap: {error}; the intervals are from the sensitivities")]


def _variant(name: str, joints: Mapping[str, JointFit], rms: Mapping[str, float], spread: Array) -> Variant:
    return Variant(
        name,
        {n: joint.spring_rate for n, joint in joints.items()},
        {n: joint.damper_rate for n, joint in joints.items() if joint.damper_rate is not None},
        rms,
        dict(zip(joints, spread.tolist(), strict=True)),
    )


def _mass_scale(
    unknowns: SpringsAndDampers, recordings: Sequence[Recording], fitted: FittedTreatments, options: LegFitOptions
) -> list[Remark]:
    """The sentence on the mass scale, if neither the trials nor what is stated tells it."""
    if options.computed:
        return []
    stated = fitted.stated
    weighed = any(balance.weighed for balance in unknowns.balances) or (stated is not None and stated.tells_scale)
    scale = mass_scale_sentence(unknowns.leg, recordings, weighed=weighed)
    return [scale] if scale else []


def _static(unknowns: SpringsAndDampers, fitted: FittedTreatments) -> tuple[JudgedPoint, ...]:
    """The static points and their fit, those that are no part of it last."""
    rate, rest = unknowns.springs(fitted.stage.solution.values)
    rate, spread = np.exp(rate), fitted.stage.weights.points
    others = judge_points([each.balance for each in fitted.left_out], rate, rest, spread, left_out=True)
    return (*judge_points(unknowns.balances, rate, rest, spread), *others)


def _contradicting_points(leg: Leg, static: Sequence[JudgedPoint]) -> list[str]:
    """Sentences on static points that contradict the trials."""
    return [
        f"static point {item.balance.name}, {leg.joint_names[item.balance.joint]}: the spring torque is "
        f"{item.balance.torque:.3g} N*m there by the point and {item.fitted:.3g} N*m by the fit, "
        f"{abs(item.deviations):.1f} standard deviations apart: a wrong reading, link masses that are off, or a spring "
        "that is not linear"
        for item in static
        if abs(item.deviations) > MISPLACED_POINT and not item.left_out
    ]


def _own_free_angles(unknowns: SpringsAndDampers, mode: str, offsets: tuple[Array, Array]) -> list[int]:
    """Joints that have a free angle in each trial, of a spring that is told from none."""
    if mode != "per_trial":
        return []
    return [j for j in unknowns.rests if offsets[0][unknowns.rest_at(j)] != -np.inf]


def _left_out(leg: Leg) -> list[str]:
    """Sentences on effects of the leg file that the fit ignores: all except torques at the joints."""
    ignored = "is ignored by the fit, which assumes rigid links, a fixed base and exact readings"
    at_joints = [(joint.name, name) for joint in leg.joints for name in joint.effects]
    return [
        *(at_joint(joint, f"{name} {ignored}") for joint, name in at_joints if effect_named(name).way != "torque"),
        *(f"{name} {ignored}" for name in leg.effects if effect_named(name).way != "torque"),
    ]


def at_edges(unknowns: SpringsAndDampers, values: Array, none: Sequence[int] = ()) -> dict[str, Remark]:
    """Estimates at a bound of the search or near it, by name, each with a sentence: its interval is invalid.

    ``none`` : places of rates that are not told from none. Their intervals begin at 0, below the least rate.
    """
    sentences = {}
    sides = (("least", unknowns.lower), ("greatest", unknowns.upper))
    for what, unit, joints, at in (
        ("spring rate", "N*m/rad", unknowns.rates, unknowns.rate_at),
        ("damper rate", "N*m*s/rad", unknowns.dampers, unknowns.damper_at),
    ):
        for j in joints:
            value = values[at(j)]
            for name, side in sides:
                if abs(value - side[at(j)]) < NEAR_LOGARITHM and not (name == "least" and at(j) in none):
                    found, bound = np.exp([value, side[at(j)]])
                    remark = _at_edge(unknowns, j, what, f"{found:.3g} {unit}", f"{bound:.3g}", name)
                    sentences[unknowns.names[at(j)]] = remark
    for j in unknowns.rests:
        value = values[unknowns.rest_at(j)]
        for name, side in sides:
            if abs(value - side[unknowns.rest_at(j)]) < NEAR_ANGLE:
                joint = unknowns.leg.joints[j]
                told = [np.degrees(joint.zero + joint.sign * v) for v in (value, side[unknowns.rest_at(j)])]
                name = name if joint.sign > 0 else {"least": "greatest", "greatest": "least"}[name]
                remark = _at_edge(unknowns, j, "free angle", f"{told[0]:.0f} deg", f"{told[1]:.0f}", name)
                sentences[unknowns.names[unknowns.rest_at(j)]] = remark
    return sentences


def _at_edge(unknowns: SpringsAndDampers, j: int, what: str, found: str, bound: str, name: str) -> Remark:
    """The sentence on one estimate."""
    text = (
        f"the {what} is at a bound of the search or near it: {found}, {bound} is the {name}. The true value is beyond, "
        "or the model does not hold, and the interval does not count"
    )
    return at_joint(unknowns.leg.joint_names[j], text, "decide")


def _joints(unknowns: SpringsAndDampers, treatment: Treatment, offsets: tuple[Array, Array]) -> dict[str, JointFit]:
    """Estimates by joint with 90 % intervals, ``offsets`` (p,) below and above the values: factors for rates."""
    leg, solution = unknowns.leg, treatment.stage.solution

    def rate(place: int, unit: str) -> Estimate:
        value = solution.values[place]
        # exp(300) is finite, and open in any case; exp(-inf) is 0.
        low, high = value + offsets[0][place], value + min(offsets[1][place], 300.0)
        # exp(709) is the largest double.
        return Estimate(float(np.exp(value)), unit, float(np.exp(low)), float(np.exp(min(high, 700.0))))

    found = {}
    for j, joint in enumerate(leg.joints):
        if j not in unknowns.rates:
            found[joint.name] = JointFit.of_locked()
            continue
        place = unknowns.rest_at(j)
        angle = joint.zero + joint.sign * float(solution.values[place])
        # The free angle of a spring that may not be there is anywhere: where the search may put it.
        rests = np.clip(
            [solution.values[place] + each[place] for each in offsets], *_rest_bounds(unknowns, place, offsets)
        )
        ends = sorted(joint.zero + joint.sign * float(rest) for rest in rests)
        damper = rate(unknowns.damper_at(j), "N*m*s/rad") if j in unknowns.dampers else None
        found[joint.name] = JointFit(
            spring_rate=rate(unknowns.rate_at(j), "N*m/rad"),
            free_angle=Estimate(angle, "deg", *ends),
            free_angle_spread=_spread(treatment, j),
            damper_rate=damper,
            damper="linear" if damper is not None else "curve",
        )
    return found


def _rest_bounds(unknowns: SpringsAndDampers, place: int, offsets: tuple[Array, Array]) -> tuple[float, float]:
    """Bounds (rad) of a rest angle's interval: the search's where the interval has no ends."""
    if np.isfinite([each[place] for each in offsets]).all():
        return -np.inf, np.inf
    return float(unknowns.lower[place]), float(unknowns.upper[place])


def _spread(treatment: Treatment, joint: int) -> Estimate:
    """A standard deviation over trials."""
    value = float(treatment.spread[joint])
    if treatment.ends is None or not np.isfinite(treatment.ends[:, joint]).all():
        return Estimate(value, "deg")
    return Estimate(value, "deg", *treatment.ends[:, joint].tolist())


def _fitted_leg(leg: Leg, joints: Mapping[str, JointFit]) -> Leg:
    made = []
    for joint in leg.joints:
        found = joints[joint.name]
        damper = joint.damper if found.damper_rate is None else Damper(found.damper_rate.value)
        made.append(replace(joint, spring=Spring(found.spring_rate.value, found.free_angle.value), damper=damper))
    return replace(leg, joints=tuple(made))
