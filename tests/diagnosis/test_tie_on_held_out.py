"""What a held-out trial says of tied explanations is told and does not decide."""

from __future__ import annotations

import numpy as np

from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL, PredictionErrors
from synth.diagnosis.tie_on_held_out import held_out_trial_that_distinguishes
from synth.remarks import Remark

SAMPLES = 10.0  # of a block
NAMES = ("level.csv", "tilted.csv")


def errors(noise: float = 0.02, **rms: tuple[float, float]) -> PredictionErrors:
    """RMS errors in degrees of both trials by label, the noise too."""

    def squared(each: tuple[float, float]) -> np.ndarray:
        return np.repeat((SAMPLES * np.radians(each) ** 2)[:, None], BLOCKS_A_TRIAL, axis=1)

    counts = np.full((2, BLOCKS_A_TRIAL), SAMPLES)
    return PredictionErrors({label: squared(each) for label, each in rms.items()}, counts, squared((noise, noise)), 0)


def told(made: PredictionErrors) -> tuple[str, ...]:
    labels = [label for label in made.squares if label != "before"]
    return held_out_trial_that_distinguishes(made, labels, [f"the cause {label}" for label in labels], NAMES)


def test_the_trial_that_ends_the_tie_is_named_with_its_errors() -> None:
    made = errors(before=(0.3, 0.3), after=(0.04, 0.11), tilt=(0.05, 0.03), scale=(0.04, 0.1))
    (said,) = told(made)
    assert "tilted.csv" in said
    assert "0.03° with the cause tilt" in said
    assert "0.11° with the cause after" in said
    assert said.index("cause tilt") < said.index("cause scale") < said.index("cause after")
    assert isinstance(said, Remark)
    assert "held_out" in said.remedy


def test_of_many_the_best_and_the_worst_are_told() -> None:
    made = errors(before=(0.3, 0.3), a=(0.04, 0.11), b=(0.04, 0.03), c=(0.04, 0.05), d=(0.04, 0.07))
    (said,) = told(made)
    assert [f"cause {label}" in said for label in "abcd"] == [True, True, True, False]


def test_errors_that_differ_only_below_the_noise_tell_nothing() -> None:
    assert told(errors(before=(0.3, 0.3), after=(0.02, 0.015), tilt=(0.02, 0.005), noise=0.02)) == ()
    assert told(errors(before=(0.3, 0.3), after=(0.04, 0.05), tilt=(0.04, 0.03))) == ()
