"""What a diagnosis of a jumping leg found: the same entries as for a swinging one, and what only jumps have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from synth.fit.result import Estimate
from synth.gap.result import FORMAT, Cause, Experiment, Ranked, Verdict, Where
from synth.hopper_gap.across import Across
from synth.hopper_gap.figures import JumpGaps
from synth.hopper_gap.where import Missing
from synth.units import quantity


@dataclass(frozen=True, eq=False)
class JumpGapResult:
    """The whole diagnosis; the entries are those of ``synth.gap.result.GapResult``.

    ``gaps`` : scored trials with every stage's prediction; ``lacks`` : a scored trial's missing torque; ``across`` :
    how the rise's error goes with length and ratio. ``noise`` : the upper link's, rad.
    """

    name: str
    verdict: Verdict
    sentence: str
    explanation: tuple[Cause, ...]
    ranked: tuple[Ranked, ...]
    probability_none: float
    probability_unknown: float
    tied: tuple[tuple[Cause, ...], ...]
    where: Where
    gaps: JumpGaps
    lacks: tuple[Missing, ...]
    across: Across
    held_out: bool
    noise: float
    next_experiment: Experiment | None
    unknowns: Mapping[str, float]
    warnings: tuple[str, ...]

    @property
    def best_possible(self) -> Estimate:
        """RMS that the best set of effects of the library reaches on the scored trials, however unlikely."""
        gap = self.gaps.gap
        return min((gap.figure(name) for name in gap.explanations), key=lambda estimate: estimate.value)

    @property
    def shrink_of_best(self) -> float | None:
        """The shrink as a share of the best that any effects reach; None where these reach nothing."""
        floor = self.gaps.gap.floor.value

        def above(rms: float) -> float:
            return float(max(rms**2 - floor**2, 0.0) ** 0.5)

        before, after = (above(self.gaps.gap.figure(name).value) for name in ("before", "after"))
        best = above(self.best_possible.value)
        return (before - after) / (before - best) if before > best else None

    def as_json(self) -> dict[str, Any]:
        """``gap.json`` without what it rests on."""
        gap = self.gaps.gap
        of_best = self.shrink_of_best
        return {
            "format": FORMAT,
            "name": self.name,
            "verdict": self.verdict,
            "sentence": self.sentence,
            "explanation": [cause.as_json() for cause in self.explanation],
            "ranked": [entry.as_json() for entry in self.ranked],
            "probability_none": self.probability_none,
            "probability_unknown": self.probability_unknown,
            "tied": [[cause.as_json() for cause in causes] for causes in self.tied],
            "where": self.where.as_json(),
            "gap": {
                **{name: gap.figure(name).as_json() for name in ("as_designed", "before", "after")},
                "noise_floor": gap.floor.as_json(),
                "best_possible": self.best_possible.as_json(),
                "shrink": gap.shrink().as_json(),
                "shrink_of_best": None if of_best is None else quantity(of_best, "1"),
                "scored_on": [trial.name for trial in self.gaps.trials],
            },
            "across": self.across.as_json(),
            "noise": {"hip": quantity(self.noise, "deg")},
            "next_experiment": None if self.next_experiment is None else self.next_experiment.as_json(),
        }
