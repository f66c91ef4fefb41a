"""Steps and predictions of the normal equations, against the quadratic model written out."""

from __future__ import annotations

import numpy as np
import pytest

from synth.estimation.normal_equations import ArrowNormal, Information, StepLimits


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
