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

    independent, most_rivals = np.inf, 4

    def __init__(self, sizes: dict[str, float], remainder: float = 1.0) -> None:
        self.sizes, self.left = sizes, remainder

    def remainder(self, fit: float) -> float:
        return self.left

    def variations(self, best: list[Any], number: int) -> list[Any]:
        return []

    def menu(self) -> list[Any]:
        rest: dict[str, Any] = {"keys": {}, "release": {}, "ramp": None, "command": None, "state": ""}
        return [SimpleNamespace(what=name, trial=name, **rest) for name in self.sizes]

    def covariance(self, fit: float) -> Any:
        return np.eye(1)

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


def test_far_above_the_noise_a_trial_is_as_good_as_it_leads_over_the_remainder() -> None:
    """Both trials separate the rivals by many noise floors, but only one by more than what no model explains."""
    apart = 40.0 / 30.0  # remainders; two equally probable rivals so far apart give -log2((1 + exp(-apart^2/8)) / 2)
    for remainder, small in ((1.0, 1.0), (30.0, -np.log2(0.5 + 0.5 * np.exp(-(apart**2) / 8.0)))):
        plant: Any = Menu({"small": 10.0, "large": 100.0}, remainder)
        found = next_experiment(plant, [(4.0, 0.5), (0.0, 0.5)], "Why.")
        assert found is not None
        bits = dict(found.menu)
        assert bits["large"] > 0.1
        assert bits["small"] == pytest.approx(small, abs=0.01)
        assert "Large would give" in found.why  # of two that separate all rivals the more distinct one


def test_no_trial_is_suggested_that_would_tell_nothing() -> None:
    plant: Any = Menu({"small": 0.01, "large": 0.02})
    assert next_experiment(plant, [(4.0, 0.5), (0.0, 0.5)], "Why.") is None


def test_the_best_variation_is_the_trial() -> None:
    class Varied(Menu):
        def variations(self, best: list[Any], number: int) -> list[Any]:
            if number > 9:
                return []
            self.sizes[f"round {number}"] = 1.0 + number
            rest: dict[str, Any] = {"keys": {}, "release": {}, "ramp": None, "command": None, "state": ""}
            return [SimpleNamespace(what=f"round {number}", trial=f"round {number}", **rest)]

    plant: Any = Varied({"held": 0.5})
    found = next_experiment(plant, [(4.0, 0.5), (0.0, 0.5)], "Why.")
    assert found is not None
    assert [what for what, _ in found.menu] == ["round 9", "held"]


class LateFit(float):
    """An explanation with one cause."""

    def __new__(cls, value: float, effect: str) -> LateFit:
        made = super().__new__(cls, value)
        made.hypothesis = [SimpleNamespace(key=(effect, "knee"))]
        return made

    hypothesis: list[Any]


@pytest.mark.parametrize(
    ("effects", "release", "keys", "said"),
    [
        (("latency", "torque_delay"), {"knee": 0.5}, {}, True),
        (("latency", "torque_delay"), {"hip": 0.1, "knee": 0.5}, {"locked": ["hip"]}, True),
        (("latency", "torque_delay"), {"hip": 0.1, "knee": 0.5}, {}, False),  # late against the other
        (("torque_gain", "torque_delay"), {"knee": 0.5}, {}, False),
    ],
)
def test_a_late_reading_shows_in_free_motion_only_from_the_release_on(
    effects: tuple[str, str], release: dict[str, float], keys: dict[str, Any], said: bool
) -> None:
    class Released(Menu):
        def menu(self) -> list[Any]:
            (item,) = super().menu()
            return [SimpleNamespace(**{**vars(item), "release": release, "keys": keys})]

    plant: Any = Released({"a release": 1.0})
    rivals = [(LateFit(4.0, effects[0]), 0.5), (LateFit(0.0, effects[1]), 0.5)]
    found = next_experiment(plant, rivals, "Why.")
    assert found is not None
    assert ("if its recording begins exactly at the release" in found.why) is said
    assert found.why.endswith(".")


def next_beside_doubt(sizes: dict[str, float], present: list[tuple[float, float]], plant: Any = None) -> Any:
    """The next trial between two causes 1 apart and one far away, which holds 30 % in doubt."""
    rivals = [(near := present[0][0], 0.35), (other := present[1][0], 0.35), (far := 1e6, 0.3)]
    assert near != other != far
    return next_experiment(plant or Menu(sizes), rivals, "Why.", present)


def test_a_trial_that_separates_only_rejected_causes_is_not_suggested() -> None:
    """By the odds with doubt it gave 0.9 bit, and its playing left the tie as it was."""
    assert next_beside_doubt({"step": 1.0}, [(1.0, 0.5), (1.1, 0.5)]) is None


def test_a_trial_that_hardly_separates_the_leading_causes_says_so() -> None:
    found = next_beside_doubt({"step": 8.0}, [(1.0, 0.5), (1.1, 0.5)])
    assert 0.01 < found.information < 0.2
    assert "No trial of those tried separates them well: step would give most information" in found.why
    assert "of the 1 that are open" in found.why


def test_a_trial_that_separates_the_leading_causes_comes_first() -> None:
    found = next_beside_doubt({"step": 1.0, "sine": 80.0}, [(1.0, 0.5), (1.1, 0.5)])
    assert found.menu[0][0] == "sine"
    assert 0.9 < found.information <= 1.0
    assert "Sine would give most information" in found.why


def test_a_nearly_sure_cause_is_tested_against_those_that_are_rejected() -> None:
    """Information is at most what the present odds leave open."""
    found = next_beside_doubt({"step": 100.0}, [(1.0, 0.995), (1.1, 0.005)])
    assert 0.01 < found.information < 0.05
    assert found.why == "Why. Step would separate it best from the causes that these trials reject."


def test_beside_a_sure_cause_no_trial_is_suggested_nor_searched() -> None:
    """The odds of servo rigs with a verdict left 1e-44 bit and less; a search of commands took a third of the run."""

    class Unasked(Menu):
        def menu(self) -> list[Any]:
            raise AssertionError

        variations = menu

    assert next_beside_doubt({}, [(1.0, 1.0 - 1e-4), (1.1, 1e-4)], Unasked({"step": 100.0})) is None
