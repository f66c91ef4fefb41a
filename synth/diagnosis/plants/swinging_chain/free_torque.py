"""A free-form torque at each joint, fitted in addition to the library: it describes effects outside the library.

The torque is a sum of hat functions (``torque_hats``): over deflection for each direction of motion, or over
speed. Tolerances, with their priors, and initial states are fitted together with it. The fit starts from the torque
missing along the recordings, and its derivatives are renewed along the resulting motion, so that it also converges if
phases differ by radians. Each fold of trials is then predicted by a fit without it; the value of a shape is the error
that it removes there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import TrialErrors
from synth.diagnosis.left_out_fold import FitWithoutFold, evaluated_without_fold, normal_without_fold
from synth.diagnosis.plants.swinging_chain.chain_candidates import NaturalSizes
from synth.diagnosis.plants.swinging_chain.chain_result import FreeTorque, Over
from synth.diagnosis.plants.swinging_chain.chain_where import MissingTorque, missing_torque
from synth.diagnosis.plants.swinging_chain.torque_hats import Hats
from synth.diagnosis.prediction_error import LEAST_GAP
from synth.diagnosis.sifting import few_trials
from synth.diagnosis.unseen import block_errors, errors_on_unseen_trials, folds, jackknife
from synth.diagnosis.workbench import DAMPING_RULE, Workbench
from synth.estimation.intervals import NORMAL90
from synth.estimation.levenberg_marquardt import Iterate, LeastSquares, minimise
from synth.estimation.linearisation import LinearisedNormal
from synth.estimation.normal_equations import ParameterStep, StepLimits
from synth.swing.leg_model import Leg
from synth.threads import in_parallel

INDEPENDENT_VARIABLES: tuple[Over, ...] = ("deflection", "speed")
# Prior deviation of a hat, in natural torques: a missing torque as large as the driving torque is rare. It is fixed:
# choosing it by the error on left-out trials would bias that error.
PRIOR_DEVIATION = 0.1
LEAST_MENTIONED_SHARE = 0.2  # least share of the error on unseen trials for a free torque to be mentioned
RENEWALS = 3  # times that derivatives are renewed along the resulting motion
JOINTS_CONTINUED = 2  # joints that continue: those with the best fit on a few trials after the first step
STEPS_A_RENEWAL = 2  # iterations with the same derivatives
STEPS_A_FOLD = 2  # iterations of the fit without a fold, with the derivatives of the fit to all trials
SAMPLES_A_TRIAL, INTEGRATION_TOLERANCE = 200, 1e-5  # per trial; of the integrator: sufficient for a shape
LAST_STEP_FALL = 0.5  # decrease of the cost below which a step is the last
DAMPING_FACTORS = (1.0, 1e3)  # on the damping, tried in parallel


@dataclass(frozen=True)
class _TorqueFit(FitWithoutFold):
    """A fit with a free torque; ``unknowns`` holds the whitened hats after the tolerances.

    ``slopes`` (M, k) per trial: whitened derivatives by the hats, at the point of ``frame``.
    """

    slopes: tuple[Array, ...] = ()


@dataclass(frozen=True)
class _TorqueFits(LeastSquares[_TorqueFit]):
    """Fits with a torque of one joint's hats."""

    bench: Workbench
    hats: Hats

    @cached_property
    def root(self) -> Array:
        """(k, k) heights in natural torques from whitened ones."""
        return PRIOR_DEVIATION * self.hats.prior_root()

    def heights(self, point: _TorqueFit) -> Array:
        """(k,) in natural torques."""
        return np.asarray(self.root @ point.unknowns[self.bench.n_tolerance :])

    def driven(self, point: _TorqueFit) -> Workbench:
        """The trials with the torque applied."""
        heights = self.heights(point)
        return replace(self.bench, trials=tuple(self.hats.driven(trial, heights) for trial in self.bench.trials))

    def evaluate(self, points: Sequence[_TorqueFit]) -> list[_TorqueFit]:
        """Residuals and cost of each; each has its own known torque, so none share lanes."""
        return [self._evaluated(point) for point in points]

    def _evaluated(self, point: _TorqueFit) -> _TorqueFit:
        plain = EvaluatedHypothesis((), point.unknowns[: self.bench.n_tolerance], point.states)
        residuals = self.driven(point).evaluate([plain])[0].residuals
        return evaluated_without_fold(self.bench, replace(point, residuals=residuals))

    def framed(self, point: _TorqueFit) -> _TorqueFit:
        """The fit with derivatives at its own point."""
        plain = EvaluatedHypothesis((), point.unknowns[: self.bench.n_tolerance], point.states, point.residuals)
        heights = self.heights(point)

        def slopes(i: int) -> Array:
            column = self.hats.columns(self.bench, plain, i, heights) @ self.root
            wide = np.zeros((len(point.residuals[i]), column.shape[1]))
            wide[: len(column)] = column
            return wide

        found = in_parallel(slopes, len(self.bench.trials))
        return replace(point, frame=self.driven(point).frame(plain), slopes=tuple(found))

    def normal(self, point: _TorqueFit) -> LinearisedNormal:
        """Normal equations of the trials that count; the others' states are refitted."""
        return normal_without_fold(self.bench, point, point.slopes)

    def bounds(self, point: _TorqueFit) -> tuple[Array, Array]:
        """Lowest and highest unknowns, (p,) each: of the tolerances; the hats have no bounds."""
        low, high = self.bench.bounds(())
        free = np.full(self.hats.count, np.inf)
        return np.concatenate([low, -free]), np.concatenate([high, free])

    def limits(self, point: _TorqueFit) -> StepLimits:
        """The states are refitted."""
        return StepLimits(follow=True)

    def damping_factors(self, point: _TorqueFit) -> tuple[float, ...]:
        """Limited, because a free shape diverges easily where the motion is nonlinear."""
        return DAMPING_FACTORS

    def moved(self, point: _TorqueFit, step: ParameterStep) -> _TorqueFit:
        """After a step, not evaluated."""
        states = self.bench.moved_states(point, step.own)
        return point.start_at(unknowns=point.unknowns + step.common, states=states, frame=point.frame)

    def least_gain(self, cost: float) -> float:
        """Independent of the cost."""
        return LAST_STEP_FALL

    def improved(self, points: Sequence[_TorqueFit], steps: int) -> list[_TorqueFit]:
        """Evaluated points with derivatives after at most so many steps."""
        ends = minimise(self, [Iterate(point, 1e-3) for point in points], DAMPING_RULE, steps)
        return [end.point for end in ends]


def free_torques(
    leg: Leg, nominal: Leg, bench: Workbench, base: EvaluatedHypothesis, scales: NaturalSizes
) -> tuple[FreeTorque, ...]:
    """The better of both shapes at the most promising joints, the most effective joint first.

    Parameters
    ----------
    base : the nominal leg's best fit, which lacks the torque; ``nominal`` that leg.

    Returns
    -------
    Empty if the nominal leg reaches the noise, or if there is only one trial, which cannot be predicted from
    others.
    """
    if len(bench.trials) < 2 or sum(float(r @ r) for r in base.residuals) <= (1.0 + LEAST_GAP) * bench.total:
        return ()
    coarse = replace(
        bench,
        predictor=bench.predictor.coarser(INTEGRATION_TOLERANCE),
        trials=tuple(trial.thinner(SAMPLES_A_TRIAL) for trial in bench.trials),
    )
    missing = [missing_torque(nominal, trial) for trial in bench.trials]
    promising = _promising_hats(leg, coarse, base, scales, missing)
    (start,) = coarse.evaluate([EvaluatedHypothesis((), base.unknowns, base.states)])
    (before,) = errors_on_unseen_trials(coarse, [start])
    found = []
    for hats in promising[:JOINTS_CONTINUED]:
        problem = _TorqueFits(coarse, hats)
        fit = _best_start(problem, start, hats.from_missing(bench.trials, missing))
        found.append(_free_torque_of(leg, problem, *_errors_on_unseen_trials(problem, fit), before))
    return tuple(sorted(found, key=lambda item: -item.taken))


def _promising_hats(
    leg: Leg, bench: Workbench, base: EvaluatedHypothesis, scales: NaturalSizes, missing: Sequence[MissingTorque]
) -> list[Hats]:
    """The better shape of each joint, joints in order of their fit on a few trials."""
    few = few_trials(bench)
    some = replace(bench, trials=tuple(bench.trials[i] for i in few))
    best: dict[int, tuple[float, Hats]] = {}
    for joint in sorted({j for trial in bench.trials for j in trial.free}):
        for over in INDEPENDENT_VARIABLES:
            hats = Hats.of(bench.trials, joint, over, scales, float(leg.rest[joint]))
            problem = _TorqueFits(some, hats)
            here = EvaluatedHypothesis((), base.unknowns, tuple(base.states[i] for i in few))
            begun = _best_start(problem, here, hats.from_missing(bench.trials, missing))
            cost = problem.improved([problem.framed(begun)], 1)[0].cost
            if joint not in best or cost < best[joint][0]:
                best[joint] = cost, hats
    return [hats for _, hats in sorted(best.values(), key=lambda item: item[0])]


def _best_start(problem: _TorqueFits, base: EvaluatedHypothesis, heights: Array) -> _TorqueFit:
    """Starting from the torque missing along the recordings, from a part of it, or from zero, whichever fits best."""
    white = np.linalg.solve(problem.root, heights)
    starts = [_TorqueFit((), np.concatenate([base.unknowns, share * white]), base.states) for share in (1.0, 0.3, 0.0)]
    return min(problem.evaluate(starts), key=lambda fit: fit.cost)


def _errors_on_unseen_trials(problem: _TorqueFits, fit: _TorqueFit) -> tuple[TrialErrors, Array]:
    """The error of the shape on unseen trials, and its heights (n_fold, k) without each fold."""
    for _ in range(RENEWALS - 1):
        before = fit.cost
        fit = problem.improved([problem.framed(fit)], STEPS_A_RENEWAL)[0]
        if before - fit.cost < LAST_STEP_FALL:
            break
    framed = problem.framed(fit)
    starts = problem.evaluate([replace(framed, out=out) for out in folds(problem.bench)])
    ends = problem.improved(starts, STEPS_A_FOLD)
    left = {index: end for end in ends for index in end.out}
    made = [block_errors(problem.bench, i, left[i].residuals[i]) for i in range(len(problem.bench.trials))]
    found = TrialErrors(*(np.array(column) for column in zip(*made, strict=True)))
    return found, np.array([problem.heights(end) for end in ends])


def free_torque_sentence(found: Sequence[FreeTorque]) -> str:
    """The sentence on the first of them for an unexplained gap; empty if it removes too little."""
    if not found or found[0].taken < LEAST_MENTIONED_SHARE:
        return ""
    first = found[0]
    over = "its deflection and direction" if first.over == "deflection" else "its speed"
    return (
        f" The missing torque acts at the {first.joint} and depends on {over}: a free-form torque there "
        f"removes {first.taken:.0%} of the error on trials that it was not fitted to."
    )


def _free_torque_of(leg: Leg, problem: _TorqueFits, left: TrialErrors, each: Array, before: TrialErrors) -> FreeTorque:
    """From the heights (n_fold, k), each without one fold, to a curve in the measured angle's sense."""
    hats = problem.hats
    sign = leg.joints[hats.joint].sign
    torque, spread = sign * each.mean(axis=0) * hats.torque, NORMAL90 * jackknife(each) * hats.torque
    if hats.over == "speed":
        place, direction = sign * hats.nodes, np.zeros(len(hats.nodes))
    else:
        place = sign * (np.tile(hats.nodes, 2) - hats.rest)
        direction = sign * np.repeat([1.0, -1.0], len(hats.nodes))
    order = np.lexsort((place, direction))
    return FreeTorque(
        leg.joint_names[hats.joint], hats.over, place[order], direction[order], torque[order],
        (torque - spread)[order], (torque + spread)[order], left.taken_in_all(before), left,
    )  # fmt: skip
