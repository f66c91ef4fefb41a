"""Levenberg-Marquardt and arrow-shaped normal equations against closed forms, dense algebra and certified values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.estimation.levenberg_marquardt import (
    CONVERGED,
    DIVERGED,
    DampingRule,
    Iterate,
    LeastSquares,
    Marquardt,
    Nielsen,
    minimise,
)
from synth.estimation.normal_equations import (
    ArrowNormal,
    Information,
    NormalEquations,
    ParameterStep,
    ReducedNormal,
    StepLimits,
    TrialNormal,
)

RULES = [
    Nielsen(least=1e-12, most=1e10, memory=0.5, settled=0.1, hardly_damped=1e-3),
    Marquardt(least=1e-7, most=1e6, down=10.0, up=10.0, least_after_failure=1e-2),
]
WIDE = (np.full(2, -np.inf), np.full(2, np.inf))


@dataclass(frozen=True)
class Curve:
    """Two common unknowns and an offset of each trial."""

    unknowns: Array
    own: tuple[Array, ...]
    cost: float = np.inf
    normals: tuple[TrialNormal, ...] = field(default=(), repr=False)


@dataclass(frozen=True)
class Saturation(LeastSquares[Curve]):
    """Misra1a of NIST's Statistical Reference Datasets, y = b1 (1 - exp(-b2 x)), in trials with offsets."""

    x: Array
    y: tuple[Array, ...]
    reduced: bool
    box: tuple[Array, Array] = WIDE

    def evaluate(self, points: Sequence[Curve]) -> list[Curve]:
        made = []
        for point in points:
            (b1, b2), cost, normals = point.unknowns, 0.0, []
            for y, own in zip(self.y, point.own, strict=True):
                fall = np.exp(-b2 * self.x)
                residual = b1 * (1.0 - fall) + own[0] - y
                a = np.column_stack([1.0 - fall, b1 * self.x * fall])
                c = np.ones((len(y), 1))
                # a prior that holds the offsets at zero: what is left is the problem that NIST certifies
                prior = 1e8
                normals.append(
                    TrialNormal(a.T @ a, a.T @ c, c.T @ c + prior, a.T @ residual, c.T @ residual + prior * own)
                )
                cost += 0.5 * float(residual @ residual) + 0.5 * prior * float(own @ own)
            made.append(replace(point, cost=cost if np.isfinite(cost) else np.inf, normals=tuple(normals)))
        return made

    def normal(self, point: Curve) -> NormalEquations:
        if self.reduced:
            return ReducedNormal.of(point.normals, np.zeros((2, 2)), np.zeros(2))
        return arrow_of(point.normals)

    def bounds(self, point: Curve) -> tuple[Array, Array]:
        return self.box

    def moved(self, point: Curve, step: ParameterStep) -> Curve:
        return Curve(point.unknowns + step.common, tuple(a + b for a, b in zip(point.own, step.own, strict=True)))

    def least_gain(self, cost: float) -> float:
        return 1e-13


def arrow_of(normals: Sequence[TrialNormal]) -> ArrowNormal:
    common = sum((trial.common for trial in normals), np.zeros_like(normals[0].common))
    gradient = sum((trial.gradient for trial in normals), np.zeros_like(normals[0].gradient))
    information = Information(common, tuple(t.cross for t in normals), tuple(t.own for t in normals))
    return ArrowNormal.of(information, gradient, [t.own_gradient for t in normals])


X = np.array([77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0])
Y = np.array(
    [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78]
)  # Misra, D., NIST (1978), https://www.itl.nist.gov/div898/strd/nls/data/misra1a.shtml


@pytest.mark.parametrize("rule", RULES, ids=["Nielsen", "factors"])
@pytest.mark.parametrize("reduced", [False, True], ids=["arrow", "reduced"])
@pytest.mark.parametrize("start", [(500.0, 1e-4), (250.0, 5e-4)], ids=["far", "near"])
def test_certified_values_from_both_certified_starts(
    rule: DampingRule, reduced: bool, start: tuple[float, float]
) -> None:
    problem = Saturation(X, (Y,), reduced)
    begun = problem.evaluate([Curve(np.array(start), (np.zeros(1),))])
    (end,) = minimise(problem, [Iterate(begun[0])], rule, 200)
    assert end.reason == CONVERGED
    np.testing.assert_allclose(end.point.unknowns, [2.3894212918e2, 5.5015643181e-4], rtol=1e-5)
    assert end.point.cost == pytest.approx(0.5 * 1.2455138894e-1, rel=1e-6)


def test_parallel_starts_end_like_single_starts() -> None:
    problem = Saturation(X, (Y,), reduced=True)
    begun = problem.evaluate([Curve(np.array(b), (np.zeros(1),)) for b in ((500.0, 1e-4), (250.0, 5e-4))])
    together = minimise(problem, [Iterate(p) for p in begun], RULES[1], 60)
    for point, found in zip(begun, together, strict=True):
        (alone,) = minimise(problem, [Iterate(point)], RULES[1], 60)
        np.testing.assert_array_equal(found.point.unknowns, alone.point.unknowns)
        assert found.count == alone.count


def test_a_bound_is_kept_and_coinciding_bounds_hold_an_unknown() -> None:
    box = (np.array([0.0, 0.0]), np.array([230.0, 1.0]))
    problem = Saturation(X, (Y,), reduced=False, box=box)
    begun = problem.evaluate([Curve(np.array([200.0, 5e-4]), (np.zeros(1),))])
    (end,) = minimise(problem, [Iterate(begun[0])], RULES[0], 200)
    assert end.point.unknowns[0] == 230.0
    held = replace(problem, box=(np.array([200.0, 0.0]), np.array([200.0, 1.0])))
    (end,) = minimise(held, [Iterate(begun[0])], RULES[0], 200)
    assert end.point.unknowns[0] == 200.0
    # then b2 is a problem in one unknown: its gradient is zero there
    b2 = end.point.unknowns[1]
    residual = 200.0 * (1.0 - np.exp(-b2 * X)) + end.point.own[0] - Y
    slope = 200.0 * X * np.exp(-b2 * X)
    assert abs(slope @ residual) < 1e-5 * np.linalg.norm(slope) * np.linalg.norm(residual)


def test_a_diverging_start_is_reported() -> None:
    problem = Saturation(X, (Y,), reduced=True)
    (end,) = minimise(problem, [Iterate(Curve(np.array([1.0, np.nan]), (np.zeros(1),)))], RULES[0], 5)
    assert end.reason == DIVERGED


def random_trials(seed: int, sizes: Sequence[int], p: int = 4) -> tuple[list[TrialNormal], Array, Array]:
    """Trials with so many unknowns of their own; and all of them as one dense system."""
    generator = np.random.default_rng(seed)
    trials, total = [], p + sum(sizes)
    dense, side, first = np.zeros((total, total)), np.zeros(total), p
    for size in sizes:
        jacobian = generator.standard_normal((30, p + size))
        residual = generator.standard_normal(30)
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ residual
        trials.append(TrialNormal(normal[:p, :p], normal[:p, p:], normal[p:, p:], gradient[:p], gradient[p:]))
        places = [*range(p), *range(first, first + size)]
        dense[np.ix_(places, places)] += normal
        side[places] += gradient
        first += size
    return trials, dense, side


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_an_arrow_step_is_that_of_the_dense_system(damping: float) -> None:
    trials, dense, side = random_trials(1, [2, 3, 2])
    normal = arrow_of(trials)
    bounds = (np.full(4, -np.inf), np.full(4, np.inf))
    (step,) = normal.steps(np.zeros(4), np.array([damping]), normal.scale, bounds, StepLimits())
    expected = -np.linalg.solve(dense + damping * np.diag(np.diag(dense)), side)
    np.testing.assert_allclose(np.concatenate([step.common, *step.own]), expected, rtol=1e-9, atol=1e-12)
    if damping == 0.0:
        assert normal.predicted_fall(step) == pytest.approx(-0.5 * float(side @ expected))
        np.testing.assert_allclose(
            np.linalg.inv(normal.information.schur()), np.linalg.inv(dense)[:4, :4], rtol=1e-9, atol=1e-12
        )


def test_a_reduced_step_and_covariance_are_those_of_the_dense_system() -> None:
    trials, dense, side = random_trials(2, [2, 0, 3])
    dense[range(4), range(4)] += 1.0
    normal = ReducedNormal.of(trials, np.eye(4), np.zeros(4))
    bounds = (np.full(4, -np.inf), np.full(4, np.inf))
    for follow in (False, True):
        (step,) = normal.steps(np.zeros(4), np.zeros(1), normal.scale, bounds, StepLimits(follow=follow))
        expected = -np.linalg.solve(dense, side)
        np.testing.assert_allclose(np.concatenate([step.common, *step.own]), expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(normal.covariance(1.0), np.linalg.inv(dense)[:4, :4], rtol=1e-9)


def test_a_fit_without_a_trial_is_that_of_the_others() -> None:
    trials, _, _ = random_trials(3, [2, 2, 3])
    normal = ReducedNormal.of(trials, np.eye(4), np.zeros(4))
    for out in range(3):
        rest = ReducedNormal.of([t for k, t in enumerate(trials) if k != out], np.eye(4), np.zeros(4))
        np.testing.assert_allclose(normal.without(out), -np.linalg.solve(rest.matrix, rest.gradient), rtol=1e-8)


def test_own_unknowns_follow_a_shortened_step() -> None:
    trials, _, _ = random_trials(4, [2])
    normal = ReducedNormal.of(trials, np.eye(4), np.zeros(4))
    bounds = (np.full(4, -np.inf), np.full(4, np.inf))
    (step,) = normal.steps(np.zeros(4), np.zeros(1), normal.scale, bounds, StepLimits(0.01, follow=True))
    assert np.abs(step.common).max() == pytest.approx(0.01)
    (trial,) = trials
    own = -np.linalg.solve(trial.own, trial.own_gradient + trial.cross.T @ step.common)
    np.testing.assert_allclose(step.own[0], own, rtol=1e-9)
    (both,) = normal.steps(np.zeros(4), np.zeros(1), normal.scale, bounds, StepLimits(0.01))
    (whole,) = normal.steps(np.zeros(4), np.zeros(1), normal.scale, bounds, StepLimits())
    np.testing.assert_allclose(both.own[0] / whole.own[0], 0.01 / np.abs(whole.common).max(), rtol=1e-9)


@pytest.mark.parametrize("damping", [1.0, 1e2, 1e4])
def test_own_unknowns_follow_a_damped_common_step(damping: float) -> None:
    """Nearly all of what the common unknown changes, the own one can make up for: a damped step must not leave it."""
    # Of three residuals, by the common and the own unknown.
    slopes = np.array([[100.3, 1e3], [99.6, 1e3], [-100.2, -1e3]])
    residual = np.array([1.0, 1.5, 0.2])
    residual -= slopes[:, 1:] @ np.linalg.lstsq(slopes[:, 1:], residual, rcond=None)[0]  # the own one is at its optimum
    common, own = slopes[:, :1], slopes[:, 1:]
    trial = TrialNormal(common.T @ common, common.T @ own, own.T @ own, common.T @ residual, own.T @ residual)
    normal = ReducedNormal.of([trial], np.zeros((1, 1)), np.zeros(1))
    bounds = np.full(1, -np.inf), np.full(1, np.inf)
    (step,) = normal.steps(np.zeros(1), np.array([damping]), normal.scale, bounds, StepLimits(follow=True))
    after = residual + slopes @ np.concatenate([step.common, step.own[0]])
    assert abs(step.common[0]) > 0.0
    assert float(after @ after) < float(residual @ residual)


@pytest.mark.parametrize("size", [1.0, 3.0, 20.0])
def test_intervals_of_residuals_larger_than_their_weight_hold_their_level(size: float) -> None:
    """Estimates by weight 1 of one trial with an unknown of its own, one common unknown hardly determined."""
    rng, count = np.random.default_rng(4), 4000
    common, own = rng.standard_normal((60, 2)) * [0.5, 0.05], rng.standard_normal((60, 1))
    truth, noise = rng.standard_normal((count, 2)), size * rng.standard_normal((count, 60))
    trial = TrialNormal(common.T @ common, common.T @ own, own.T @ own, np.zeros(2), np.zeros(1))
    normal = ReducedNormal.of([trial], np.eye(2), np.zeros(2))
    free = common - own @ np.linalg.lstsq(own, common, rcond=None)[0]
    estimates = np.linalg.solve(normal.matrix, free.T @ (truth @ common.T + noise).T).T
    reach = NORMAL90 * np.sqrt(np.diag(normal.covariance(size**2)))
    np.testing.assert_allclose(np.mean(np.abs(estimates - truth) <= reach, axis=0), 0.9, atol=0.02)


@pytest.mark.parametrize(
    ("ratio", "factor"),
    [(-1.0, 28.0), (0.0, 2.0), (0.25, 1.125), (0.5, 1.0), (0.75, 0.875), (1.0, 1 / 3), (9.0, 1 / 3)],
)
def test_nielsens_damping_after_a_success(ratio: float, factor: float) -> None:
    """Equation 2.21 there, max(1/3, 1 - (2 rho - 1)^3); consecutive failures double from 2 again."""
    rule = Nielsen(least=1e-12, most=1e10)
    damping, growth = rule.after_success(Iterate(None, 0.3, growth=16.0), 4.0 * ratio, 4.0)
    assert (damping, growth) == pytest.approx((0.3 * factor, 2.0))
    assert rule.after_success(Iterate(None, 1e-12), 4.0, 4.0)[0] == 1e-12


def test_nielsens_damping_after_failures() -> None:
    """2, 4 and 8 times as high: 64 times after three."""
    rule, at = Nielsen(least=1e-12, most=1e10), Iterate(None, 0.3)
    for damping in (0.6, 2.4, 19.2):
        higher, growth = rule.after_failure(at)
        at = Iterate(None, higher, growth=growth)
        assert at.damping == pytest.approx(damping)


def test_marquardts_damping_up_and_down() -> None:
    rule = Marquardt(least=1e-7, most=1e6, down=5.0, up=10.0, least_after_failure=1e-2)
    assert rule.after_success(Iterate(None, 0.3), 1.0, 1.0)[0] == pytest.approx(0.06)
    assert rule.after_success(Iterate(None, 2e-7), 1.0, 1.0)[0] == pytest.approx(1e-7)
    assert rule.after_failure(Iterate(None, 0.3))[0] == pytest.approx(3.0)
    assert rule.after_failure(Iterate(None, 1e-6))[0] == pytest.approx(1e-2)
