"""A start for motions that forget theirs: fit pieces of the recordings, join them two by two, and fit again.

From rates that are a little wrong the fit to a whole recording follows a motion of another start, or none, where small
errors grow (``lost_motion``). Pieces with initial states of their own are followed from their first samples, and each
joined pair begins near its optimum (multiple shooting: Bock, *Recent advances in parameter identification techniques
for O.D.E.*, 1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from synth.arrays import Array
from synth.fit.least_squares import FitStart, Stage
from synth.fit.lost_motion import lost_sensitive
from synth.fit.recordings import Recording
from synth.fit.refinement import misfit, refine
from synth.fit.starts import first_locals
from synth.fit.trajectories import Local, TrajectoryModel

PIECE_IN_PACES = 2.0 * np.pi  # paces of the longest first piece, half a period, over which a deviation hardly grows
LEAST_SAMPLES = 24  # of a piece, which has an initial angle and rate a joint
PIECE_ROUNDS = 1  # of noise and fit, of pieces, which only lead to longer ones


def refine_by_pieces(
    model: TrajectoryModel, recordings: Sequence[Recording], best: Stage, values: Array, weight: str, spread: Array
) -> Stage:
    """The given stage, or a better one from pieces of the recordings if it does not follow a sensitive motion.

    Servos have a memory, which a piece would not know.

    Parameters
    ----------
    values : (p,) common unknowns at which the pieces start.
    weight, spread : as for ``refine``.
    """
    servos = any(recording.signals is not None for recording in recordings)
    if servos or not np.isfinite(best.solution.cost) or not lost_sensitive(model, recordings, best.solution):
        return best
    locals_: list[Local] = []
    for number in _numbers(recordings):
        pieces = [piece for recording in recordings for piece in _cut(recording, number)]
        start = FitStart(values, locals_[::2] or first_locals(pieces))
        solution = refine(model, pieces, start, weight, np.zeros_like(spread), rounds=PIECE_ROUNDS).solution
        if not np.isfinite(solution.cost):
            return best
        values, locals_ = solution.values, list(solution.locals)
    if not locals_:
        return best
    found = refine(model, recordings, FitStart(values, locals_[::2]), weight, spread)
    better = np.isfinite(found.solution.cost) and misfit(recordings, found) < misfit(recordings, best)
    return found if better else best


def _numbers(recordings: Sequence[Recording]) -> list[int]:
    """Pieces of each recording, halved down to two; empty if the recordings are too short to be cut."""
    lengths = max(float(r.time[-1]) / (PIECE_IN_PACES * r.smoothed.pace) for r in recordings)
    samples = min(len(r.time) for r in recordings) / LEAST_SAMPLES
    most = int(min(np.ceil(np.log2(max(lengths, 1.0))), np.floor(np.log2(max(samples, 1.0)))))
    return [2**level for level in range(most, 0, -1)]


def _cut(recording: Recording, number: int) -> list[Recording]:
    """The recording in pieces of equal length."""
    ends = np.linspace(0.0, recording.time[-1], number + 1)
    return [recording.between(begin, end) for begin, end in pairwise(ends)]
