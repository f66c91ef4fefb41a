"""A result's intervals belong to its estimates, also where the fit's last step was not simulated."""

from __future__ import annotations

import numpy as np
import pytest

from fit.simulated_legs import Rig, fitted, releases, robot
from synth.estimation.intervals import NORMAL90
from synth.fit import report_fit
from synth.fit.joint_correlation import spread_of
from synth.fit.least_squares import STALE_STEP, Stage, resimulated
from synth.fit.recordings import Recording
from synth.fit.trajectories import TrajectoryModel

OVERDAMPED = robot(spring=[60.0, 8.0, 0.45], damper=[12.0, 3.0, 0.063])


def test_intervals_are_those_of_the_information_at_the_estimates(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last step moves the knee by a seventh: the information before it gave an interval narrower by 12 %."""
    stages: list[tuple[TrajectoryModel, list[Recording], Stage]] = []
    link_errors = report_fit.link_errors

    def noted(model, recordings, stage, *rest):  # type: ignore[no-untyped-def]
        stages.append((model, recordings, stage))
        return link_errors(model, recordings, stage, *rest)

    monkeypatch.setattr(report_fit, "link_errors", noted)
    result = fitted(OVERDAMPED, releases(OVERDAMPED, 3, Rig(1.0, 0, 0.5, 120.0), 2), free_angle="common")
    ((model, recordings, stage),) = stages
    solution = stage.solution
    predicted = [
        model.sensitivity(recording, solution.values, local).prediction
        for recording, local in zip(recordings, solution.locals, strict=True)
    ]
    for found, exact in zip(solution.predictions, predicted, strict=True):
        np.testing.assert_allclose(found, exact, atol=1e-9)
    stale = Stage(type(solution)(**{**vars(solution), "unsimulated": 2.0 * STALE_STEP}), stage.weights)
    fresh = resimulated(model, recordings, stale)
    deviation = np.sqrt(np.diag(spread_of(model, recordings, fresh)))
    for j, joint in enumerate(result.joints.values()):
        rate = joint.spring_rate
        assert rate.low is not None
        assert rate.high is not None
        wide = np.log(rate.high / rate.low) / (2.0 * NORMAL90)
        assert wide == pytest.approx(deviation[model.unknowns.rate_at(j)], rel=1e-6)  # type: ignore[attr-defined]
