"""Channels that are read less often than the file has rows, and stand in between."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.diagnosis.check.finding import Finding
from synth.fit.recordings import Recording

LEAST_RUNS = 20  # readings of their own: fewer may stand equally long by chance
SAME_LENGTH = 0.9  # of the runs: clocks that drift make one a row longer or shorter now and then
UNLIKE = 0.2  # of their mean, standard deviation of the steps: those of counts at one speed are one count each


def held_finding(recording: Recording, joint: int, name: str) -> Finding | None:
    """A channel whose readings each stand for the same number of rows, also while the joint moves; None if not.

    Coarse counts stand for long where the joint is slow and for a row where it is fast, so their runs are not alike; at
    one speed their steps are.
    """
    value = recording.rotation[recording.counts[:, joint], joint]
    runs = _runs(value)[1:-1]  # of the first and last row the rest may be missing
    if len(runs) < LEAST_RUNS:
        return None
    usual = int(np.median(runs))
    steps = np.abs(np.diff(value)[np.diff(value) != 0.0])
    if usual < 2 or np.mean(runs == usual) < SAME_LENGTH or np.std(steps) < UNLIKE * np.mean(steps):
        return None
    rate = 1.0 / (usual * recording.step)
    text = (
        f"its readings each stand {usual} times: this channel is read at {rate:.3g} Hz, and is held between. "
        "The steps count as noise"
    )
    remedy = "leave the repeated cells empty (an empty cell is a missing sample), so that each reading stands once"
    return Finding("doubt", text, remedy, recording.name, name)


def _runs(value: Array) -> Array:
    """Lengths of the runs of equal readings."""
    starts = np.flatnonzero(np.r_[True, np.diff(value) != 0.0])
    return np.diff(np.r_[starts, len(value)])
