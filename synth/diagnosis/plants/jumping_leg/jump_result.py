"""The result of a jumping leg's diagnosis: the entries of a swinging leg's, and those specific to jumps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from synth.diagnosis.diagnosis_result import Diagnosis
from synth.diagnosis.plants.jumping_leg.jump_across import DesignTrends
from synth.diagnosis.plants.jumping_leg.jump_figures import JumpGaps
from synth.diagnosis.plants.jumping_leg.jump_where import MissingHipTorque
from synth.diagnosis.prediction_error import shrink_of_best
from synth.units import quantity


@dataclass(frozen=True, eq=False)
class JumpGapResult(Diagnosis):
    """The whole diagnosis of a jumping leg.

    ``gaps`` : scored trials with every stage's prediction; ``lacks`` : missing torque of each scored trial;
    ``across`` :
    dependence of the rise's error on length and ratio. ``noise`` : the upper link's, rad. ``unknowns`` : estimated
    deviations of the design's numbers, in units of their tolerances.
    """

    name: str
    gaps: JumpGaps
    lacks: tuple[MissingHipTorque, ...]
    across: DesignTrends
    held_out: bool
    noise: float
    unknowns: Mapping[str, float]

    def as_json(self) -> dict[str, Any]:
        """``gap.json`` without its input section."""
        errors = self.gaps.errors
        before, after, best = errors.figure("before"), errors.figure("after"), errors.best_possible
        of_best = shrink_of_best(before.value, after.value, best.value, errors.floor.value)
        return {
            **self.said_as_json(self.name),
            "gap": {
                "as_designed": errors.figure("as_designed").as_json(),
                "before": before.as_json(),
                "after": after.as_json(),
                "noise_floor": errors.floor.as_json(),
                "best_possible": best.as_json(),
                "shrink": errors.shrink().as_json(),
                "shrink_of_best": None if of_best is None else quantity(of_best, "1"),
                "scored_on": [trial.name for trial in self.gaps.trials],
            },
            "across": self.across.as_json(),
            "noise": {"hip": quantity(self.noise, "deg")},
            "next_experiment": self.next_as_json(),
        }
