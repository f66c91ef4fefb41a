"""Steps and predictions of the normal equations, against the quadratic model written out."""

from __future__ import annotations

import numpy as np
import pytest

from synth.estimation.normal_equations import ArrowNormal, Information, ReducedNormal, StepLimits


@pytest.mark.parametrize(
    "limits", [StepLimits(), StepLimits(common=0.05, own=0.02), StepLimits(common=0.1, follow=True)]
)
@pytest.mark.parametrize("damping", [1e-9, 1e-2, 1.0, 1e3])
def test_the_predicted_fall_is_the_quadratic_models_of_an_undamped_step(damping: float, limits: StepLimits) -> None:
    """Of any other, damped, shortened or clipped, at least half of it."""
    generator = np.random.default_rng(0)
    jacobian = generator.normal(size=(60, 3 + 2 + 2))
    residual = generator.normal(size=60)
    matrix, gradient = jacobian.T @ jacobian, jacobian.T @ residual
    matrix[3:5, 5:] = matrix[5:, 3:5] = 0.0  # two trials share no unknowns of their own
    own = [slice(3, 5), slice(5, 7)]
    information = Information(
        matrix[:3, :3], tuple(matrix[:3, each] for each in own), tuple(matrix[each, each] for each in own)
    )
    normal = ArrowNormal.of(information, gradient[:3], [gradient[each] for each in own])
    bounds = np.full(3, -np.inf), np.array([np.inf, np.inf, 0.01])  # the third may be clipped
    (step,) = normal.steps(np.zeros(3), np.array([damping]), normal.scale, bounds, limits)
    taken = np.concatenate([step.common, *step.own])
    model = -(gradient @ taken + 0.5 * taken @ matrix @ taken)
    assert normal.predicted_fall(step) >= 0.5 * model
    if damping < 1e-6 and limits.common is np.inf:
        free = np.full(3, -np.inf), np.full(3, np.inf)
        (step,) = normal.steps(np.zeros(3), np.array([damping]), normal.scale, free, limits)
        taken = np.concatenate([step.common, *step.own])
        model = -(gradient @ taken + 0.5 * taken @ matrix @ taken)
        assert normal.predicted_fall(step) == pytest.approx(model, rel=1e-6)


@pytest.mark.parametrize("at_bound", [True, False])
@pytest.mark.parametrize("upper", [True, False])
def test_an_unknown_at_its_bound_is_left_out_of_the_system(*, upper: bool, at_bound: bool) -> None:
    """Exactly at its bound and pushed outwards; inside it, the step is clipped and the others stay."""
    matrix, gradient = np.array([[2.0, 1.0, 0.5], [1.0, 3.0, 0.7], [0.5, 0.7, 4.0]]), np.array([1.0, 2.0, -3.0])
    free = -np.linalg.solve(matrix, gradient)
    outward = np.sign(free[1])
    at, far = np.array([0.3, 0.2, 0.1]), np.full(3, np.inf)
    side = 1.0 if upper else -1.0
    gradient *= side * outward  # the second unknown is pushed to that side
    low, high = at - far, at + far
    (high if upper else low)[1] = at[1] + (0.0 if at_bound else side * 1e-3)
    normal = ReducedNormal((), matrix, gradient, (), 1.0)
    (step,) = normal.steps(at, np.zeros(1), normal.scale, (low, high), StepLimits())
    rest = [0, 2]
    expected = side * outward * free
    if at_bound:
        expected[1], expected[rest] = 0.0, -np.linalg.solve(matrix[np.ix_(rest, rest)], gradient[rest])
    else:
        expected[1] = side * 1e-3
    np.testing.assert_allclose(step.common, expected, rtol=1e-9)


def test_an_unknown_without_room_is_left_out_of_the_system() -> None:
    """Equal bounds fix it, in whichever direction it would move, though it is beside them."""
    matrix, gradient = np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([1.0, 2.0])
    at = np.array([0.3, 0.2])
    for beside in (-0.1, 0.1):
        low, high = np.array([-np.inf, 0.2 + beside]), np.array([np.inf, 0.2 + beside])
        normal = ReducedNormal((), matrix, gradient, (), 1.0)
        (step,) = normal.steps(at, np.zeros(1), normal.scale, (low, high), StepLimits())
        np.testing.assert_allclose(step.common, [-0.5, beside], rtol=1e-9)


@pytest.mark.parametrize("weight", [1.0, 0.05, 2.0])
def test_the_covariance_is_that_of_repeated_fits(weight: float) -> None:
    """Of a straight fit with a prior, whose residuals have another variance than the cost presumes."""
    generator, variance, draws = np.random.default_rng(7), 0.6, 40_000
    jacobian = generator.normal(size=(10, 2))
    trial = weight * jacobian.T @ jacobian
    normal = ReducedNormal((), trial + np.eye(2), np.zeros(2), ((trial, np.zeros(2)),), weight)
    noise = np.sqrt(variance) * generator.normal(size=(draws, 10))
    prior = generator.normal(size=(draws, 2))  # errors of what the priors state: they hold as stated
    found = np.linalg.solve(normal.matrix, (weight * noise @ jacobian + prior).T)
    np.testing.assert_allclose(np.cov(found), normal.covariance(variance), rtol=0.05, atol=2e-3)
