"""Odds of hypotheses, near the sensor's noise and far above it.

If the best explanation reaches the sensor's noise, its residuals are white and the fits themselves tell most: the
evidence is the cost with the tolerances' priors, which uses every sample. If it stays far above the noise, the rest is
the model's own remainder: correlated, different from trial to trial, and of unknown size. A trial whose errors have the
mean square ``s`` then counts ``m/2 log(1 + s)``, the log-likelihood of ``m`` independent errors of unknown size; the
trials are reweighted by a Bayesian bootstrap (Rubin, Ann. Stat. 9 (1981) 130), so that a difference due to a single
trial is not taken as certain.

The log-likelihood is the mean of two: that of the fitted trials, and that of the same trials left out. The fits alone
prefer a form that bends to what is left; the trials left out alone would judge a cause by the only trial of its kind (a
tilt, a tip mass), whose error depends on tolerances that no other trial determines. On 164 dirty rigs the first cause's
probability is as near to the truth by the mean as by the fits alone (mean squared error 0.169 for 0.172). Trials left
out also decide whether a further cause is named: there a fit that is too good would add causes.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np

from synth.arrays import Array
from synth.diagnosis.hypotheses import Assessment, F, Key, TrialErrors

# RMS over the noise floor of the best explanation on unseen trials: below the first it is at the floor, above the
# second it is a remainder. At 1.5 floors noise is nearly half of the squared error, at 3 a ninth: the rest is the
# model's, and taken as white noise it would give absurd odds. Decided by ``make blind-rigs``.
FLOOR_RATIO, REMAINDER_RATIO = 1.5, 3.0
# Largest number of independent errors per trial, because model errors are shared by neighbouring swings, and of all
# trials, because they share what the model lacks: nearly equal causes (a reading shifted or scaled, a shifted torque)
# are tied, not separated. Decided by ``make blind-rigs`` and ``make rigs``.
MOST_INDEPENDENT_A_TRIAL, MOST_INDEPENDENT_IN_ALL = 8.0, 20.0
LEAST_FURTHER_SHARE = 0.1  # least share of the whole gap (RMS) of a further cause; less does not matter to a user
BOOTSTRAP_DRAWS = 400  # of the bootstrap: a probability of 0.05 is known to 0.01
# Weight of the trials as recorded, each counted once, beside the draws: a stated choice, which changes little, because
# the draws scatter about the trials as recorded.
WEIGHT_AS_RECORDED = 0.25
# Weight of the log-likelihood of trials left out of the fit beside that of the fitted ones: see above.
WEIGHT_OF_UNSEEN = 0.5


@dataclass(frozen=True)
class Calibration:
    """Constants that convert costs into probabilities; tuned: ``make tune`` (simulated cases of ``tests/blind``).

    ``temperature`` : of the softmax over costs, for effects whose form is not exact. ``per_parameter`` : penalty per
    unknown, ``per_state`` : per initial state of an added link and trial, half the logarithm of a trial's samples
    (without it, free states let a base that yields imitate other causes). ``none``, ``single``,
    ``pair``, ``triple`` : prior probabilities that no, one, two or three causes are missing, divided evenly among their
    hypotheses. ``left`` : share of the squared gap left by the best explanation at which an unknown cause is as
    probable as not, ``left_by_several`` the same for several causes, ``misfit`` : slope of that probability over its
    logarithm. ``doubt`` : least probability of an unknown cause if an effect is missing, because an unknown cause
    sometimes acts exactly like a known one; ``doubt_of_several`` : the same for several causes, which imitate others
    more easily. ``clean`` : RMS over the noise floor up to which no effect is missing; ``far`` : RMS over the floor
    above which less may be left, by its square root: a correct cause leaves little even for a good sensor.
    ``tie_odds`` : odds below which explanations are tied. ``pays`` : least share of the remaining squared gap that a
    further cause must remove; form errors of a correct cause let other causes remove about a tenth.

    For a remainder far above the noise: ``most`` : share of the gap's RMS that the best single cause must remove from
    the fitted trials for an unknown cause to be less probable than not, ``most_of_several`` : the same for several;
    ``steep`` : slope of that probability over the share; ``most_unknown`` : its largest value; ``free_leads`` :
    advantage allowed to a free torque on unseen trials; ``per_unknown_far`` : penalty per unknown, near half the
    logarithm of the 20 independent errors that determine it (1.5; Schwarz, Ann. Stat. 6 (1978) 461); ``per_state_far``
    : penalty per initial state of an added link and trial, times ``log(1 + m)`` for the ``m`` independent errors of
    that trial (near a half: Occam's factor of a normal prior as wide as the errors). ``accuracy`` : gap as a share of
    the motion (RMS) at which a missing effect is as probable as not if no cause of the library removes any of it:
    models of rigs without faults follow them to 0.05 to 0.5 deg of swings of 30 deg; ``accuracy_steep`` : slope over
    the share's logarithm. Tuned: ``make tune-rigs`` (simulated rigs with small causes beside the main one).
    """

    temperature: float = 3.0
    per_parameter: float = 4.0
    per_state: float = 2.0
    none: float = 0.3
    single: float = 0.5
    pair: float = 0.19
    triple: float = 0.01
    misfit: float = 2.0
    left: float = 0.2
    left_by_several: float = 0.07
    pays: float = 0.4
    doubt: float = 0.05
    doubt_of_several: float = 0.25
    clean: float = 1.25
    far: float = 5.0
    tie_odds: float = 6.0
    most: float = 0.68
    most_of_several: float = 0.73
    steep: float = 30.0
    free_leads: float = 0.15
    most_unknown: float = 0.75
    per_unknown_far: float = 2.0
    per_state_far: float = 0.4
    accuracy: float = 0.01
    accuracy_steep: float = 3.0


CALIBRATED = Calibration()


def far_share(hypotheses: Sequence[Assessment[F]]) -> float:
    """Distance of the best explanation from the noise: 0 at the floor, 1 if its remainder is the model's own."""
    known = [h.unseen.typical for h in hypotheses if h.unseen is not None]
    return _distance_from_noise(min(known)) if known else 0.0


def _distance_from_noise(floors: float) -> float:
    """The same of an RMS over the noise floor."""
    return float(np.clip(np.log(max(floors, 1e-9) / FLOOR_RATIO) / np.log(REMAINDER_RATIO / FLOOR_RATIO), 0.0, 1.0))


def price_of_unknown(floors: float, total: float, calibration: Calibration) -> float:
    """What an unknown must take off a fit's cost for the odds to gain by it.

    ``floors`` : RMS of the best fit over the noise. Far from the noise ``MOST_INDEPENDENT_IN_ALL`` errors count, each
    by half the logarithm of its square, while the cost counts the logarithm for ``total`` samples.
    """
    share = _distance_from_noise(floors)
    return (1.0 - share) * calibration.per_parameter + share * calibration.per_unknown_far * total / (
        0.5 * MOST_INDEPENDENT_IN_ALL
    )


def posterior_weights(
    hypotheses: Sequence[Assessment[F]],
    calibration: Calibration,
    singles: int = 0,
    prior_of: Sequence[Assessment[F]] | None = None,
) -> Array:
    """(n,) posterior weights: prior times exp(-cost / temperature), with a penalty for each unknown.

    Far from the noise from the errors by trial instead, see above; in between a mixture of both.
    ``singles`` : number of single causes, if not all are among the hypotheses. ``prior_of`` : the hypotheses whose
    number of causes sets the prior, if others.
    """
    counts = np.array([len(h.keys) for h in prior_of or hypotheses])
    singles = max(int(np.sum(counts == 1)), singles, 1)
    together = [calibration.none, calibration.single, calibration.pair, calibration.triple]
    prior = np.array([np.log(together[k] * factorial(k) / singles**k) for k in counts])
    share = far_share(hypotheses)
    logarithms = prior - _costs_before_draws(hypotheses, share, calibration)
    if share == 0.0:
        return _normalised(logarithms[:, None])[:, 0]
    draws = _normalised(logarithms[:, None] - share * _bootstrapped_costs(hypotheses))
    return np.asarray(WEIGHT_AS_RECORDED * draws[:, 0] + (1.0 - WEIGHT_AS_RECORDED) * draws[:, 1:].mean(axis=1))


def in_order_of_odds(hypotheses: Sequence[Assessment[F]], calibration: Calibration) -> list[Assessment[F]]:
    """By the weights that ``posterior_weights`` gives sets of equally many causes, the trials as recorded; the largest
    first.

    For a choice before the errors on unseen trials are known: the distance from the noise is that of the fits.
    ``hypotheses`` : with their errors by trial.
    """
    against = costs_against(hypotheses, _distance_from_noise(min(h.ratio for h in hypotheses)), calibration)
    return [hypotheses[i] for i in np.argsort(against, kind="stable")]


def costs_against(hypotheses: Sequence[Assessment[F]], share: float, calibration: Calibration) -> Array:
    """(n,) what is against each hypothesis at this ``share`` of the way from the noise, the trials as recorded.

    Before the prior for the number of causes.
    """
    against = _costs_before_draws(hypotheses, share, calibration)
    return against + share * _bootstrapped_costs(hypotheses)[:, 0] if share > 0.0 else against


def _costs_before_draws(hypotheses: Sequence[Assessment[F]], share: float, calibration: Calibration) -> Array:
    """(n,) what is against each hypothesis beside the errors by trial, at this ``share`` of the way from the noise."""
    charged = share * _charges_for_unknowns(hypotheses, calibration)
    if share == 1.0:  # a diverged motion has no finite cost
        return np.asarray(charged)
    trials = _trial_count(hypotheses)
    numbers = [calibration.per_parameter * h.n_unknown + calibration.per_state * trials * h.n_state for h in hypotheses]
    cost = np.array([h.cost for h in hypotheses]) + numbers
    return np.asarray((1.0 - share) * (cost - cost.min()) / calibration.temperature + charged)


def unknowns_and_states(hypotheses: Sequence[Assessment[F]]) -> list[int]:
    """Number of each hypothesis's unknowns, and of the initial states of its own links in all trials."""
    trials = _trial_count(hypotheses)
    return [h.n_unknown + trials * h.n_state for h in hypotheses]


def _charges_for_unknowns(hypotheses: Sequence[Assessment[F]], calibration: Calibration) -> Array:
    """(n,) what the numbers of each hypothesis cost far from the noise, where their priors are not in the likelihood.

    Without the shapes' share a form at the far end of its priors, which bends to whatever is left, would cost no more
    than a plain one.
    """
    unknowns, states, shapes = np.array([(h.n_unknown, h.n_state, shape_cost(h.fit.shapes)) for h in hypotheses]).T
    each = _independent_errors(hypotheses)
    of_states = calibration.per_state_far * float(np.log1p(each).sum()) * states
    return np.asarray(calibration.per_unknown_far * unknowns + of_states + shapes)


def shape_cost(shapes: Array) -> float:
    """What the priors of shapes (n, 2) take off the log-likelihood, as far as the trials determine the shapes.

    The fits count more samples than there are independent errors, and so end too far from the prior. Of a
    log-likelihood with the curvature ``d`` about the fit's value ``x`` and a prior with the curvature 1 about 0, the
    least sum is ``x^2/2 d/(1 + d)``: what the trials hardly determine costs nothing. ``MOST_INDEPENDENT_IN_ALL`` errors
    of unknown size have that many times the second column as curvature.
    """
    with np.errstate(divide="ignore"):  # not determined at all: its share is 1 / (1 + inf)
        share = 1.0 / (1.0 + 1.0 / (MOST_INDEPENDENT_IN_ALL * shapes[:, 1]))
    return float(0.5 * np.sum(share * shapes[:, 0] ** 2))


def _trial_count(hypotheses: Sequence[Assessment[F]]) -> int:
    return max((len(each.independent) for h in hypotheses if (each := _errors_by_trial(h)) is not None), default=0)


def posterior_weights_beside(
    hypotheses: Sequence[Assessment[F]],
    beside: Sequence[Assessment[F]],
    small: Collection[Key],
    calibration: Calibration,
    singles: int = 0,
) -> Array:
    """(n,) weights as by ``posterior_weights``, divided among the causes by what they leave beside the same small
    causes.

    ``beside`` : all fitted sets, some of them a hypothesis with ``small`` causes. Against none the hypotheses have the
    weight that they have alone: small causes are in every rig, and do not show that there is a large one.
    """
    weights = posterior_weights(hypotheses, calibration, singles)
    named = [frozenset(h.keys) for h in hypotheses if h.keys]
    # A set belongs to the largest hypotheses in it: what a further large cause removes is not its parts' merit.
    largest = [(h, [keys for keys in named if keys <= set(h.keys)]) for h in beside if frozenset(h.keys) not in named]
    own = {
        keys: [h for h, within in largest if keys in within and not any(keys < other for other in within)]
        for keys in named
    }
    best = []
    for h in hypotheses:
        sets = [s for s in own.get(frozenset(h.keys), []) if {*s.keys} <= {*h.keys, *small}]
        best.append(_best_beside(h, [s for s in sets if adds_little(s, h, hypotheses[0])], calibration))
    if all(with_small is h for with_small, h in zip(best, hypotheses, strict=True)):
        return weights
    fair = posterior_weights(best, calibration, singles, prior_of=hypotheses)
    causes = np.array([bool(h.keys) for h in hypotheses])
    total = float(weights[causes].sum())
    return np.where(causes, fair * total / max(float(fair[causes].sum()), 1e-300), weights)


def adds_little(item: Assessment[F], own: Assessment[F], none: Assessment[F]) -> bool:
    """Whether each cause that a set adds to a hypothesis takes less than ``LEAST_FURTHER_SHARE`` of the gap, on
    average.
    """
    added = len(item.keys) - len(own.keys)
    return share_removed_from_fitted(item, none) - share_removed_from_fitted(own, none) < LEAST_FURTHER_SHARE * added


def _best_beside(own: Assessment[F], beside: Sequence[Assessment[F]], calibration: Calibration) -> Assessment[F]:
    """A hypothesis, or the most probable of the sets with small causes beside it, unknowns charged."""
    sets = [own, *beside]
    if len(sets) == 1:
        return own
    left = _bootstrapped_costs(sets)[:, 0] + _charges_for_unknowns(sets, calibration)
    return sets[int(np.argmin(left))]


def _normalised(logarithms: Array) -> Array:
    """(n, n_draw) weights with the sum 1 in each column."""
    weights = np.exp(logarithms - logarithms.max(axis=0))
    return np.asarray(weights / weights.sum(axis=0))


def _bootstrapped_costs(hypotheses: Sequence[Assessment[F]]) -> Array:
    """(n, 1 + DRAWS) negative log-likelihood of the trials, each counted once, then reweighted in each draw.

    A hypothesis without errors by trial gets those of the first, minus its gain in all trials.
    """
    known, independent = [_errors_by_trial(h) for h in hypotheses], _independent_errors(hypotheses)
    first = known[0]
    rows = []
    for item, own, grown in zip(hypotheses, known, _growth_on_unseen(hypotheses), strict=True):
        errors = own or first
        assert errors is not None
        gained = 0.0 if own is not None else 2.0 * np.log(item.ratio / hypotheses[0].ratio)
        rows.append(0.5 * independent * (np.log1p(errors.by_trial) + gained + WEIGHT_OF_UNSEEN * grown))
    count = len(independent)
    picks = np.random.default_rng(0).dirichlet(np.ones(count), BOOTSTRAP_DRAWS) * count
    return np.asarray(np.array(rows) @ np.concatenate([np.ones((1, count)), picks]).T)


def _independent_errors(hypotheses: Sequence[Assessment[F]]) -> Array:
    """(n_trial,) independent errors of each trial that count, those of the best hypothesis; none if none is known."""
    known = [each for h in hypotheses if (each := _errors_by_trial(h)) is not None]
    if not known:
        return np.zeros(0)
    independent = np.minimum(min(known, key=lambda each: each.typical).independent, MOST_INDEPENDENT_A_TRIAL)
    return np.asarray(independent * min(1.0, MOST_INDEPENDENT_IN_ALL / float(independent.sum())))


def _growth_on_unseen(hypotheses: Sequence[Assessment[F]]) -> list[Array]:
    """(n_trial,) each: how much ``log(1 + s)`` of each trial is larger if it is left out of the fit.

    The mean of the others for a hypothesis that was not fitted without trials.
    """
    grown = [
        np.log1p(h.unseen.by_trial) - np.log1p(h.seen.by_trial) if h.unseen is not None and h.seen is not None else None
        for h in hypotheses
    ]
    measured = [each for each in grown if each is not None]
    mean = np.mean(measured, axis=0) if measured else np.zeros(1)
    return [mean if each is None else each for each in grown]


def _errors_by_trial(item: Assessment[F]) -> TrialErrors | None:
    """Errors by trial: of the fitted trials, or of those left out if only these are known."""
    return item.seen if item.seen is not None else item.unseen


def share_removed_from_fitted(item: Assessment[F], none: Assessment[F]) -> float:
    """Share of the gap's RMS above the noise that a hypothesis removes from the fitted trials."""
    return 1.0 - item.above / none.above if none.above > 0.0 else 0.0


def share_removed(item: Assessment[F], none: Assessment[F]) -> float:
    """Share of the gap's RMS that a hypothesis removes, on unseen trials if available."""
    if item.unseen is None or none.unseen is None:
        return share_removed_from_fitted(item, none)
    return share_removed_between(item.unseen, none.unseen)


def share_removed_between(left: TrialErrors, before: TrialErrors) -> float:
    """Share of the RMS above the noise that is removed in a typical trial."""
    above = [float(np.sqrt(max(each.typical**2 - 1.0, 0.0))) for each in (left, before)]
    return 1.0 - above[0] / above[1] if above[1] > 0.0 else 0.0
