"""The remainder: the error of the explanation, or of the nominal model, beyond the sensor's noise, and its location.

The accuracy of a model is limited by the rig, not by the sensor: a rig that reads to a hundredth of a
degree is seldom modelled to better than a tenth.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from synth.diagnosis.prediction_error import LEAST_GAP, PredictionErrors
from synth.estimation.intervals import Estimate

MOSTLY_SHARE = 0.5  # least share of the remainder for a place to be named in the sentence


@dataclass(frozen=True)
class Remainder:
    """On the scored trials.

    ``rms`` rad above the noise; ``share`` of the initial gap above the noise, above 1 if the explanation predicts
    worse; ``times_noise`` : over the noise floor. ``joint``, ``phase`` : name -> share of its squares.
    """

    rms: Estimate
    share: float
    times_noise: float
    joint: Mapping[str, float]
    phase: Mapping[str, float]

    @classmethod
    def of(
        cls, errors: PredictionErrors, label: str, joint: Mapping[str, float], phase: Mapping[str, float]
    ) -> Remainder:
        """The remainder under a ``label`` of the errors."""
        rms, before = errors.above_noise(label), errors.above_noise("before")
        share = rms.value / before.value if before.value > 0.0 else 0.0
        if before.value**2 <= LEAST_GAP * errors.floor.value**2:
            share = min(share, 1.0)
        return cls(rms, share, rms.value / errors.floor.value if errors.floor.value > 0.0 else 0.0, joint, phase)

    def place(self, *, released: bool = True) -> str:
        """The place with most of it, in words; empty if it is spread out. Without a phase of trials without release."""
        found = []
        for shares, words in ((self.joint, "at the {}"), (self.phase if released else {}, PHASE_WORDS)):
            first = max(shares, key=lambda name: shares[name], default=None)
            if first is not None and len(shares) > 1 and shares[first] > MOSTLY_SHARE:
                found.append(words.format(first) if isinstance(words, str) else words[first])
        return " ".join(found)

    def as_json(self) -> dict[str, Any]:
        """The entry ``remainder`` of ``gap.json``."""
        return {
            "rms": self.rms.as_json(),
            "share": self.share,
            "times_noise": self.times_noise,
            "where": {"joint": dict(self.joint), "phase": dict(self.phase)},
        }


PHASE_WORDS = {
    "release": "right after the release",
    "swing": "while it swings",
    "settle": "while it settles",
    "rest": "at rest",
}
