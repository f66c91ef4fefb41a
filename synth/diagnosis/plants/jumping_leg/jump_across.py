"""Across designs: whether the error of the predicted jump grows with link length or gear ratio.

The error of a trial is its predicted over its measured rise, less 1. Ordinary least squares on length and ratio
together, where both vary among the trials; intervals by Student's distribution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.diagnosis.plants.jumping_leg.jump_figures import JumpGaps
from synth.estimation.intervals import Estimate

STAGES = ("as_designed", "before", "after")
UNITS = {"length": "1/cm", "gear_ratio": "1"}
LEAST_SPREAD = 0.01  # of a mean: designs that differ by less count as one
LEAST_TREND = 0.02  # of the rise, over the range of the designs: a smaller trend is not reported


@dataclass(frozen=True)
class JumpAcrossDesigns:
    """One jump: its design, and rises in m by ``STAGES`` and measured; ``learnt`` : whether it was fitted.

    ``reach`` : half of the measured rise's 90 % interval, m.
    """

    file: str
    motor: str
    length: float
    gear_ratio: float
    measured: float
    reach: float
    rises: dict[str, float]
    learnt: bool = False

    def error(self, stage: str) -> float:
        """Predicted over measured rise, less 1."""
        return self.rises[stage] / self.measured - 1.0


@dataclass(frozen=True)
class DesignTrends:
    """``slopes`` : "length" or "gear_ratio" -> stage -> change of the error per metre or unit of ratio."""

    designs: tuple[JumpAcrossDesigns, ...]
    slopes: dict[str, dict[str, Estimate]]

    def as_json(self) -> dict[str, Any]:
        """The entry ``across``."""
        from synth.units import quantity

        return {
            "designs": [
                {
                    "file": d.file, "motor": d.motor, "gear_ratio": d.gear_ratio, "learnt_from": d.learnt,
                    "leg_length": quantity(d.length, "mm"),
                    "rise_measured": quantity(d.measured, "mm", (max(0.0, d.measured - d.reach), d.measured + d.reach)),
                    **{f"rise_{stage}": quantity(d.rises[stage], "mm") for stage in STAGES},
                    "error": {stage: quantity(d.error(stage), "percent") for stage in STAGES},
                }
                for d in self.designs
            ],
            "slope": {by: {stage: e.as_json() for stage, e in found.items()} for by, found in self.slopes.items()},
            "says": self.sentences(),
        }  # fmt: skip

    def sentences(self) -> list[str]:
        """The trends in words, as designed and with the explanation."""
        sentences = []
        for by, words in (("length", "the links' length"), ("gear_ratio", "the gear ratio")):
            values = [getattr(d, by) for d in self.designs]
            if by not in self.slopes:
                why = "no rise was measured"
                if values:
                    same = max(values) == min(values)
                    why = "all jumps have the same" if same else "there are too few or too similar jumps"
                sentences.append(f"Whether the error changes with {words} is unknown: {why}.")
                continue
            reach = max(values) - min(values)
            first, last = (self._trend(by, stage, reach) for stage in ("as_designed", "after"))
            sentences.append(
                f"As designed, the predicted rise's error {first} with {words}; with the explanation it {last}."
            )
        return sentences

    def _trend(self, by: str, stage: str, reach: float) -> str:
        slope = self.slopes[by][stage]
        assert slope.low is not None
        assert slope.high is not None
        change = f"{100 * slope.value * reach:+.0f} % from the least to the greatest"
        if slope.low > 0.0 or slope.high < 0.0:
            if abs(slope.value * reach) < LEAST_TREND:
                return f"hardly changes ({change})"
            return f"{'grows' if slope.value > 0.0 else 'falls'} ({change})"
        return f"shows no significant trend ({change})"


def trends_across_designs(gaps: JumpGaps) -> DesignTrends:
    """The comparison from the jumps with a measured rise, scored ones first."""
    designs = []
    scored = list(zip(gaps.trials, gaps.rises, strict=True))
    for trial, rise in [*scored, *gaps.learnt]:
        rises = {stage: getattr(rise, stage) for stage in STAGES}
        if rise.measured is None or rise.measured <= 0.0 or None in rises.values():
            continue
        reach = 0.0 if trial.seen is None else trial.seen.rise_reach
        design = (trial.name, trial.motor.name, trial.leg.length, trial.motor.gear_ratio)
        designs.append(JumpAcrossDesigns(*design, rise.measured, reach, rises))
    columns = {by: np.array([getattr(d, by) for d in designs]) for by in UNITS}
    varied = [
        by for by, values in columns.items() if len(values) > 2 and np.std(values) > LEAST_SPREAD * np.mean(values)
    ]
    slopes: dict[str, dict[str, Estimate]] = {by: {} for by in varied}
    for stage in STAGES if varied else ():
        errors = np.array([d.error(stage) for d in designs])
        for by, estimate in _slopes({by: columns[by] for by in varied}, errors).items():
            slopes[by][stage] = estimate
    return DesignTrends(tuple(designs), {by: found for by, found in slopes.items() if len(found) == len(STAGES)})


def _slopes(columns: dict[str, Array], errors: Array) -> dict[str, Estimate]:
    """Least squares; empty if designs are too few or too similar to separate the columns."""
    from scipy.stats import t as student

    matrix = np.column_stack([np.ones(len(errors)), *(values - values.mean() for values in columns.values())])
    free = len(errors) - matrix.shape[1]
    scale = np.linalg.norm(matrix, axis=0)
    if free < 1 or np.linalg.cond(matrix / scale) > 100.0:
        return {}
    found, *_ = np.linalg.lstsq(matrix, errors, rcond=None)
    left = errors - matrix @ found
    covariance = np.linalg.inv(matrix.T @ matrix) * float(left @ left) / free
    reach = float(student.ppf(0.95, free)) * np.sqrt(np.diag(covariance))
    return {
        by: Estimate(float(found[k]), UNITS[by], float(found[k] - reach[k]), float(found[k] + reach[k]))
        for k, by in enumerate(columns, start=1)
    }
