"""Linearised trials, whose own unknowns are projected out, against dense least squares of all unknowns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from synth.arrays import Array
from synth.estimation.linearisation import Linearisation, LinearisedNormal, TrialLinearisation
from synth.estimation.normal_equations import StepLimits

COMMON, MORE, OWN, SAMPLES = 3, 2, 2, 12
SIZE = COMMON + MORE


@dataclass(frozen=True)
class Dense:
    """Trials' derivatives by shared (M, 5) and own unknowns (M, 2), residuals (M,), and the shared ones (5,) now."""

    shared: list[Array]
    own: list[Array]
    residuals: list[Array]
    prior: Array
    weight: float

    @classmethod
    def drawn(cls, weight: float = 1.0, trials: int = 4) -> Dense:
        draw = np.random.default_rng(5).normal
        shared, own = ([draw(size=(SAMPLES, size)) for _ in range(trials)] for size in (SIZE, OWN))
        return cls(shared, own, [draw(size=SAMPLES) for _ in range(trials)], draw(size=SIZE), weight)

    def normal(self) -> LinearisedNormal:
        trials = tuple(
            TrialLinearisation(shared[:, :COMMON], *np.linalg.qr(own))
            for shared, own in zip(self.shared, self.own, strict=True)
        )
        more = [shared[:, COMMON:] for shared in self.shared]
        return Linearisation(trials).normal(self.residuals, more, self.weight, self.prior)

    def solved(self, kept: list[int], *, prior: bool = True) -> tuple[Array, list[Array]]:
        """Step of the shared unknowns and of each kept trial's own that minimises w |r + J x|^2 + |prior + x|^2."""
        rows, aims = ([np.eye(SIZE, SIZE + OWN * len(kept))], [-self.prior]) if prior else ([], [])
        for place, trial in enumerate(kept):
            row = np.zeros((SAMPLES, SIZE + OWN * len(kept)))
            row[:, :SIZE] = self.shared[trial]
            row[:, SIZE + OWN * place : SIZE + OWN * (place + 1)] = self.own[trial]
            rows.append(np.sqrt(self.weight) * row)
            aims.append(-np.sqrt(self.weight) * self.residuals[trial])
        found = np.linalg.lstsq(np.vstack(rows), np.concatenate(aims), rcond=None)[0]
        return found[:SIZE], list(found[SIZE:].reshape(-1, OWN))

    def squares_after(self, kept: list[int], step: Array) -> float:
        """Sum of squares of the kept trials after a step (5,) of the shared unknowns, their own refitted."""
        total = 0.0
        for trial in kept:
            left = self.residuals[trial] + self.shared[trial] @ step
            total += float(
                np.sum((left - self.own[trial] @ np.linalg.lstsq(self.own[trial], left, rcond=None)[0]) ** 2)
            )
        return total


def step_of(normal: LinearisedNormal) -> tuple[Array, tuple[Array, ...]]:
    free = np.full(SIZE, -np.inf), np.full(SIZE, np.inf)
    (made,) = normal.steps(np.zeros(SIZE), np.zeros(1), normal.scale, free, StepLimits())
    return made.common, made.own


@pytest.mark.parametrize("weight", [1.0, 0.05, 2.0])
def test_the_step_is_that_of_all_unknowns_together(weight: float) -> None:
    dense = Dense.drawn(weight)
    common, own = step_of(dense.normal())
    expected, expected_own = dense.solved([0, 1, 2, 3])
    np.testing.assert_allclose(common, expected, rtol=1e-9)
    np.testing.assert_allclose(own, expected_own, rtol=1e-9)


@pytest.mark.parametrize("weight", [1.0, 0.05, 2.0])
def test_without_a_trial(weight: float) -> None:
    dense = Dense.drawn(weight)
    normal, kept = dense.normal(), [0, 2, 3]
    np.testing.assert_allclose(normal.without(1), dense.solved(kept)[0], rtol=1e-9)
    step = np.linspace(-1.0, 2.0, SIZE)
    assert normal.squares_without(1, step) == pytest.approx(dense.squares_after(kept, step))


@pytest.mark.parametrize("weight", [1.0, 0.05, 2.0])
@pytest.mark.parametrize("diverged", [False, True])
def test_without_a_fold_all_that_is_asked_holds_for_the_trials_left(weight: float, *, diverged: bool) -> None:
    """The result kept the parts and squares of the trials left out: a further trial's step was that of five trials."""
    dense = Dense.drawn(weight)
    if diverged:
        dense.residuals[1][:] = np.nan
    out, kept = (1, 3), [0, 2]
    normal = dense.normal().without_fold(out, dense.prior)
    expected, expected_own = dense.solved(kept)
    common, own = step_of(normal)
    np.testing.assert_allclose(common, expected, rtol=1e-9)
    np.testing.assert_allclose([own[trial] for trial in kept], expected_own, rtol=1e-9)
    if not diverged:  # a trial left out follows the others' step
        for trial in out:
            left = dense.residuals[trial] + dense.shared[trial] @ expected
            np.testing.assert_allclose(own[trial], -np.linalg.lstsq(dense.own[trial], left, rcond=None)[0], rtol=1e-9)
    np.testing.assert_allclose(normal.without(2), dense.solved([0])[0], rtol=1e-9)
    np.testing.assert_allclose(normal.without(1), expected, rtol=1e-9)
    step = np.linspace(-1.0, 2.0, SIZE)
    assert normal.squares_without(0, step) == pytest.approx(dense.squares_after([2], step))
    trials = sum(
        (shared.T @ (np.eye(SAMPLES) - own @ np.linalg.pinv(own)) @ shared)
        for shared, own in ((dense.shared[trial], dense.own[trial]) for trial in kept)
    )
    inverse = np.linalg.inv(weight * trials + np.eye(SIZE))
    spread = inverse @ (0.7 * weight**2 * trials + np.eye(SIZE)) @ inverse
    np.testing.assert_allclose(normal.covariance(0.7), spread, rtol=1e-9)
