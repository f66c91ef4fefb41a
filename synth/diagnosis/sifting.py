"""A few of the trials with fewer samples, on which thousands of starts are ranked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.diagnosis.angle_trials import largest_of_kinds
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.workbench import Workbench

SIFTED_TRIALS, SIFTED_SAMPLES = 4, 300  # trials used in the first screening, and samples of each
SIFTING_TOLERANCE = 1e-5  # relative tolerance of the integrator while candidates are only ranked


def few_trials(bench: Workbench) -> list[int]:
    """Trials for the first screening: one of each kind, then those with the largest motion."""
    chosen = largest_of_kinds(bench.trials)
    taken = np.cumsum([bench.trials[i].share for i in chosen])  # of pieces as many as make so many recordings
    return sorted(chosen[: int(np.searchsorted(taken, SIFTED_TRIALS - 1e-9)) + 1])


@dataclass(frozen=True)
class Sifting:
    """A subset of the trials with fewer samples, to rank candidates; ``few`` : indices among all."""

    bench: Workbench
    few: Sequence[int]

    @classmethod
    def of(cls, bench: Workbench) -> Sifting:
        """A subset of the bench's trials, with a coarser integration."""
        few = few_trials(bench)
        trials = tuple(bench.trials[i].thinner(SIFTED_SAMPLES) for i in few)
        return cls(replace(bench, predictor=bench.predictor.coarser(SIFTING_TOLERANCE), trials=trials), few)

    def beside(self, fit: EvaluatedHypothesis) -> EvaluatedHypothesis:
        """A fit to all trials as a fit to this subset, with its derivatives."""
        here = self.bench.evaluate([fit.start_at(states=[fit.states[i] for i in self.few])])[0]
        return replace(here, frame=self.bench.frame(here))
