"""The delay of each channel relative to the others, estimated with the designed leg."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.diagnosis.check.cause_responses import CauseResponse, response_products
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.workbench import Workbench
from synth.estimation.intervals import NORMAL90, Estimate
from synth.units import significant

LEAST_FREE_JOINTS = 2  # joints that move in the same trial; a delay is relative to another channel
SURE_DEVIATIONS = 3.0  # standard deviations from zero for a lag to be reported


@dataclass(frozen=True)
class Lag:
    """One channel: its apparent delay, s, with its uncertainty."""

    joint: str
    late: Estimate

    def as_json(self) -> dict[str, Any]:
        """The entry under ``lags``."""
        return {"joint": self.joint, "late": self.late.as_json()}


def estimate_lags(bench: Workbench, at: EvaluatedHypothesis, found: Sequence[CauseResponse]) -> tuple[Lag, ...]:
    """One Gauss-Newton step from the designed leg: each channel's lag alone with tolerances and initial states.

    The deviation is widened by the design's error in the trials, because other causes may look like a lag.
    """
    late = [response for response in found if response.key[0] == "latency"]
    if not late or all(len(trial.free) < LEAST_FREE_JOINTS for trial in bench.trials):
        return ()
    moved = bench.residuals([response.fit for response in late])
    rows = [[*(residual - at.residuals[i] for residual in trial), at.residuals[i]] for i, trial in enumerate(moved)]
    gram = response_products(bench, at, rows).gram
    left = float(np.sqrt(max(gram[-1, -1] / bench.total, 1.0)))
    made: dict[str, Lag] = {}
    for k, response in enumerate(late):
        named, name = (
            response.candidate.named(response.fit.unknowns[bench.n_tolerance :]),
            response.candidate.shape.free[0],
        )
        size = named[name] - response.candidate.designed.get(name, 0.0)
        per_second = gram[k, k] / size**2
        value = -float(gram[k, -1]) / size / per_second
        deviation = left / float(np.sqrt(per_second))
        lag = Lag(response.key[1], Estimate(value, "ms", value - NORMAL90 * deviation, value + NORMAL90 * deviation))
        made.setdefault(response.key[1], lag)
    return tuple(made.values())


def lag_findings(made: Sequence[Lag]) -> list[Finding]:
    """Channels that are significantly late.

    A note, not a doubt: another cause may look like a lag, and only a diagnosis weighs them.
    """
    found = []
    for lag in made:
        assert lag.late.low is not None
        deviation = (lag.late.value - lag.late.low) / NORMAL90
        if lag.late.value > SURE_DEVIATIONS * deviation:
            low, high = 1e3 * lag.late.low, 1e3 * (lag.late.high or 0.0)
            text = f"looks {significant(low, 3)} to {significant(high, 3)} ms later than the other channels, "
            text += "if no other effect is missing"
            remedy = "check whether this channel is read later or filtered more than the others"
            found.append(Finding("note", text, remedy, "", lag.joint))
    return found
