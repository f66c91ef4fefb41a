"""How late each channel is against the others, as far as the leg as designed can tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.diagnosis.check.cause_responses import CauseResponse, products
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.workbench import EvaluatedHypothesis, Workbench
from synth.estimation.intervals import NORMAL90, Estimate

LEAST_FREE = 2  # joints that move in the same trial: a channel alone is late against nothing
SURE = 3.0  # standard deviations that a lag must be from nought to be said


@dataclass(frozen=True)
class Lag:
    """One channel: how late it looks, s, with what the trials leave open of it."""

    joint: str
    late: Estimate

    def as_json(self) -> dict[str, Any]:
        """The entry under ``lags``."""
        return {"joint": self.joint, "late": self.late.as_json()}


def lags(bench: Workbench, at: EvaluatedHypothesis, found: Sequence[CauseResponse]) -> tuple[Lag, ...]:
    """One step from the leg as designed, each channel's lag alone beside tolerances and initial states.

    The deviation is widened by how far the design misses the trials: what else is wrong may pass for a lag.
    """
    late = [response for response in found if response.key[0] == "latency"]
    if not late or all(len(trial.free) < LEAST_FREE for trial in bench.trials):
        return ()
    moved = bench.residuals([response.fit for response in late])
    rows = [[*(residual - at.residuals[i] for residual in trial), at.residuals[i]] for i, trial in enumerate(moved)]
    gram = products(bench, at, rows).gram
    left = float(np.sqrt(max(gram[-1, -1] / bench.total, 1.0)))
    made: dict[str, Lag] = {}
    for k, response in enumerate(late):
        size = next(iter(response.candidate.named(response.fit.unknowns[bench.n_tolerance :]).values()))
        per_second = gram[k, k] / size**2
        value = -float(gram[k, -1]) / size / per_second
        deviation = left / float(np.sqrt(per_second))
        lag = Lag(response.key[1], Estimate(value, "ms", value - NORMAL90 * deviation, value + NORMAL90 * deviation))
        made.setdefault(response.key[1], lag)
    return tuple(made.values())


def lag_findings(made: Sequence[Lag]) -> list[Finding]:
    """Channels that look late beyond doubt.

    A note and no doubt: what else is missing may pass for a lag, and only a diagnosis weighs them.
    """
    found = []
    for lag in made:
        assert lag.late.low is not None
        deviation = (lag.late.value - lag.late.low) / NORMAL90
        if lag.late.value > SURE * deviation:
            low, high = 1e3 * lag.late.low, 1e3 * (lag.late.high or 0.0)
            text = f"looks {low:.3g} to {high:.3g} ms late against the other channels, if nothing else is missing"
            remedy = "see whether its channel is read later or filtered more than the others"
            found.append(Finding("note", text, remedy, "", lag.joint))
    return found
