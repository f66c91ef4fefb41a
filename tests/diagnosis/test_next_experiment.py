"""The next trial among a menu's."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synth.diagnosis.next_experiment import next_experiment
from synth.estimation.information import TrialForecast


class Menu:
    """A plant whose explanations differ by a shift, of another size in each trial."""

    def __init__(self, sizes: dict[str, float]) -> None:
        self.sizes = sizes

    def menu(self) -> list[Any]:
        rest: dict[str, Any] = {"keys": {}, "release": {}, "ramp": None, "command": None}
        return [SimpleNamespace(what=name, trial=name, **rest) for name in self.sizes]

    def normal(self, fit: float) -> Any:
        return SimpleNamespace(covariance=np.eye(1))

    def forecast(self, fit: float, trial: str, covariance: np.ndarray) -> TrialForecast:
        mean = np.array([self.sizes[trial] * fit, 0.0, 0.0])
        return TrialForecast(mean, np.ones((3, 1)), np.array([[0.0], [0.0], [1.0]]))


@pytest.mark.filterwarnings("ignore:overflow|invalid")
def test_a_trial_whose_numbers_overflow_gives_no_information() -> None:
    """Predictions of a motion that runs away are finite, their squares are not."""
    plant: Any = Menu({"runs away": 1e200, "held": 1.0})
    found = next_experiment(plant, [(4.0, 0.5), (0.0, 0.5)], "Why.")
    assert found is not None
    bits = dict(found.menu)
    assert bits["runs away"] == 0.0
    assert 0.1 < bits["held"] <= 1.0
    assert "Held would give most information" in found.why
