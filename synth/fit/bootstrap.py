"""Intervals by bootstrap: refits to the fit's prediction plus resampled residuals.

The draws of the residuals have the correlation of the noise, with all joints at the same samples; see
``residual_draws``. The priors' centres, the shifts' and the static points' readings are drawn from their own
distributions, so that refits reflect all inputs of the fit (Bardsley et al., SIAM J. Sci. Comput. 36 (2014) A1895,
"randomize-then-optimize").

All refits run in parallel as lanes of the engine. Each is a separate Newton iteration with exact trajectories and the
fit's Jacobian (the chord method, Kelley, *Iterative Methods*, 1995, section 5.4.1): 200 refits of seven trials cost
about as much as a thousand trajectories. A refit that does not converge is dropped and reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.estimation.intervals import spectrum
from synth.fit.diverged_fit import divergence_refused
from synth.fit.least_squares import HUBER, Stage, start_precision
from synth.fit.random_streams import Stream
from synth.fit.recordings import Recording
from synth.fit.residual_draws import Draw, Places, resample
from synth.fit.trajectories import TrajectoryModel
from synth.fit.uncertainty import residuals
from synth.threads import shared_out

REFITS = 200  # a 5 % quantile rests on ten of them, with an error of a fifth of a deviation
ROUNDS = 8  # chord steps, a choice; a refit that needs more is dropped
SETTLED_STEP = 0.02  # standard deviations: a refit ends when a step is shorter in every unknown
TOLERANCE = 1e-6  # of the integrator, sufficient for derivatives by large differences
LONGEST_STEP = 1.5  # of a log rate or rad, longest step of a refit
TRIALS_TOGETHER = 32  # trials whose motions are kept in memory together


@dataclass(frozen=True)
class Bootstrap:
    """The refits.

    ``values`` (n_refit, p) unknowns of converged refits; ``asked`` number of refits; ``block`` (n_trial,) white
    residuals drawn together; ``sensitivity`` (p,) standard deviations from the sensitivities.
    """

    values: Array
    asked: int
    block: tuple[int, ...]
    sensitivity: Array

    @property
    def deviation(self) -> Array:
        """(p,) standard deviations over the refits."""
        return np.asarray(self.values.std(axis=0, ddof=1))

    def offsets(self, about: Array) -> tuple[Array, Array]:
        """(p,) each, the 5 % and 95 % points of the refits relative to the fit's values ``about`` (p,)."""
        low, high = np.quantile(self.values - about, [0.05, 0.95], axis=0)
        return np.minimum(low, 0.0), np.maximum(high, 0.0)

    def widened(self, covariance: Array, seed: int) -> Bootstrap:
        """With independent normal errors of this ``covariance`` (p, p) in the refits, which do not know of them."""
        if not covariance.any():
            return self
        value, vector = np.linalg.eigh(covariance)
        root = vector * np.sqrt(np.maximum(value, 0.0))
        errors = Stream.MEAN_FREE_ANGLE.generator(seed).normal(size=self.values.shape)
        return replace(self, values=self.values + errors @ root.T)

    def as_json(self, names: Sequence[str]) -> dict[str, Any]:
        """Number of refits, and the ratio of their spread to that of the sensitivities."""
        ratio = self.deviation / self.sensitivity
        return {
            "refits": self.asked,
            "settled": len(self.values),
            "block_samples": list(self.block),
            "over_sensitivities": {name: round(float(r), 3) for name, r in zip(names, ratio, strict=True)},
        }


def bootstrap(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, covariance: Array, *, seed: int = 0
) -> Bootstrap:
    """Refit ``REFITS`` times.

    Parameters
    ----------
    stage : the fit with its weights.
    covariance : (p, p) of the common unknowns, from the sensitivities.

    Raises
    ------
    ArithmeticError : a joint's counts are coarser than its noise, no resampled noise is like the residuals, or fewer
        than half of the refits converge; only the sensitivities' intervals are available.
    """
    _refuse_coarse(model, stage)
    generator = Stream.REFITS.generator(seed)
    solution = stage.solution
    problem = _Problem(model, recordings, stage, generator)
    left = [residuals(r, p) for r, p in zip(recordings, solution.predictions, strict=True)]
    steps = [recording.step for recording in recordings]
    drawn = resample(generator, left, steps, problem.noise, problem.left_over, REFITS)
    values, settled = problem.refit(drawn, np.sqrt(np.diag(covariance)))
    if settled.sum() < REFITS / 2:
        raise ArithmeticError(f"only {int(settled.sum())} of {REFITS} refits converge")
    return Bootstrap(values[:, settled].T, REFITS, tuple(draw.block for draw in drawn), np.sqrt(np.diag(covariance)))


def _refuse_coarse(model: TrajectoryModel, stage: Stage) -> None:
    """Residuals of counts that are coarser than the noise are errors of rounding, which belong to one motion.

    A refit to them would need noise before rounding, rounded again, and the likelihood of its counts.
    """
    names = [name for name, item in zip(model.leg.joint_names, stage.weights.rounding, strict=False) if item]
    if names:
        raise ArithmeticError(
            f"the counts of {', '.join(names)} are coarser than the noise, and their residuals cannot be resampled"
        )


class _Problem:
    """All refits together: unknowns as columns, one common Newton matrix, eliminated trial by trial."""

    def __init__(
        self,
        model: TrajectoryModel,
        recordings: Sequence[Recording],
        stage: Stage,
        generator: np.random.Generator,
    ) -> None:
        self.model, self.recordings = model, recordings
        self.rough = model.at_tolerance(TOLERANCE)
        self.solution, self.noise = stage.solution, stage.weights.noise
        self.evaluations = model.evaluate_all(recordings, self.solution.values, self.solution.locals)
        information = self.solution.information
        self.schur = information.schur()
        self.eliminated = [np.linalg.solve(o, c.T) for o, c in zip(information.own, information.cross, strict=True)]
        self.precision = [model.unknowns.prior[1]]
        for recording in recordings:
            self.precision.append(start_precision(recording, stage.weights.spread, model.shifted(recording)))
        self.pulls = [generator.normal(size=(len(p), REFITS)) * np.sqrt(p)[:, None] for p in self.precision]
        beside = model.unknowns.measured(self.solution.values, stage.weights.points)
        self.beside = np.zeros_like(self.schur) if beside is None else beside[2]
        with divergence_refused():
            values, vectors = spectrum(self.beside)
        self.pulls[0] += vectors @ (
            np.sqrt(np.maximum(values, 0.0))[:, None] * generator.normal(size=(len(values), REFITS))
        )

    def left_over(self, drawn: Sequence[Array]) -> list[Array]:
        """What a refit leaves of residuals (m, n, c) rad, by the sensitivities alone."""
        gradients = [np.zeros((len(self.precision[0]), drawn[0].shape[2]))]
        jacobians = []
        for t, added in enumerate(drawn):
            found = self.evaluations[t]
            assert found.common is not None
            assert found.local is not None
            flat = np.where(self.recordings[t].counts[:, :, None], added / self.noise[t][:, None] ** 2, 0.0)
            flat = flat.reshape(-1, added.shape[2])
            jacobians.append((found.common.reshape(len(flat), -1), found.local.reshape(len(flat), -1)))
            gradients[0] -= jacobians[-1][0].T @ flat
            gradients.append(-jacobians[-1][1].T @ flat)
        common, *owns = self._solve(gradients)
        return [added - (each @ common + own @ moved).reshape(added.shape)
                for added, (each, own), moved in zip(drawn, jacobians, owns, strict=True)]  # fmt: skip

    def refit(self, drawn: Sequence[Draw], deviation: Array) -> tuple[Array, NDArray[np.bool_]]:
        """(p, REFITS) unknowns and (REFITS,) which converged; ``deviation`` (p,) is the scale."""
        steps = [np.zeros((len(precision), REFITS)) for precision in self.precision]
        settled, lost = np.zeros(REFITS, dtype=bool), np.zeros(REFITS, dtype=bool)
        for _ in range(ROUNDS):
            todo = np.flatnonzero(~settled & ~lost)
            if not len(todo):
                break
            moves = self._solve(self._gradients(drawn, [step[:, todo] for step in steps], todo))
            share = np.minimum(1.0, LONGEST_STEP / np.maximum(np.abs(moves[0]).max(axis=0), 1e-300))
            good = np.all(np.isfinite(moves[0]), axis=0)
            lost[todo[~good]] = True
            for step, move in zip(steps, moves, strict=True):
                step[:, todo[good]] += (move * share)[:, good]
            small = np.all(np.abs(moves[0]) <= SETTLED_STEP * deviation[:, None], axis=0)
            settled[todo[good & small]] = True
        return self.solution.values[:, None] + steps[0], settled

    def _solve(self, gradients: list[Array]) -> list[Array]:
        """Newton's step for every column, by the Schur complement."""
        owns = self.solution.information.own
        inner = [np.linalg.solve(own, g) for own, g in zip(owns, gradients[1:], strict=True)]
        side = gradients[0]
        for cross, part in zip(self.solution.information.cross, inner, strict=True):
            side = side - cross @ part
        common = np.asarray(-np.linalg.solve(self.schur, side), dtype=np.float64)
        moves = [common]
        for part, eliminated in zip(inner, self.eliminated, strict=True):
            moves.append(-part - eliminated @ common)
        return moves

    def _gradients(self, drawn: Sequence[Draw], steps: Sequence[Array], which: Places) -> list[Array]:
        """Gradient (p, c) by the common unknowns and (l, c) by each trial's own, at every refit's point."""
        gradients = [
            precision[:, None] * step + pull[:, which]
            for precision, step, pull in zip(self.precision, steps, self.pulls, strict=True)
        ]
        gradients[0] = gradients[0] + self.beside @ steps[0]
        for first in range(0, len(self.recordings), TRIALS_TOGETHER):
            some = range(first, min(first + TRIALS_TOGETHER, len(self.recordings)))
            moved = self._motions(some, steps)
            for t, motion in zip(some, moved, strict=True):
                found, noise = self.evaluations[t], self.noise[t]
                assert found.common is not None
                assert found.local is not None
                target = self.solution.predictions[t][:, :, None] + drawn[t].of(which)
                scaled = (motion - target) / noise[:, None]
                weighted = scaled * np.minimum(1.0, HUBER / np.maximum(np.abs(scaled), 1e-12)) / noise[:, None]
                flat = np.where(self.recordings[t].counts[:, :, None], weighted, 0.0).reshape(-1, len(which))
                gradients[0] += found.common.reshape(len(flat), -1).T @ flat
                gradients[t + 1] += found.local.reshape(len(flat), -1).T @ flat
        return gradients

    def _motions(self, trials: range, steps: Sequence[Array]) -> list[Array]:
        """(m, n, c) rad each, these trials in every refit."""

        def one(k: int) -> Array:
            t = trials[k]
            recording, local, own = self.recordings[t], self.solution.locals[t], steps[t + 1]
            free, shifted, n = recording.free, self.model.shifted(recording), len(local.rotation)
            state = np.repeat(np.concatenate([local.rotation, local.rate])[:, None], own.shape[1], axis=1)
            shift = np.repeat(local.shift[:, None], own.shape[1], axis=1)
            state[[*free, *(n + j for j in free)]] += own[: 2 * len(free)]
            shift[shifted] += own[2 * len(free) :]
            return self.rough.run(recording, self.solution.values[:, None] + steps[0], state, shift)

        return shared_out(one, len(trials))
