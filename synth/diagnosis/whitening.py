"""What turns a trial's predictions into whitened residuals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.gap_trials import GapTrial


@dataclass(frozen=True)
class Whitener:
    """What turns a trial's predictions into whitened residuals of the samples that count, a row a lane.

    ``index`` places of these samples in a flat (m n,) array; ``measured`` and ``scale`` (count,) theirs.
    """

    index: NDArray[np.intp] | slice
    measured: Array
    scale: Array

    @classmethod
    def of(cls, trial: GapTrial, sigma: Array) -> Whitener:
        """``sigma`` (n,) or (m, n) rad."""
        index = slice(None) if trial.counts.all() else np.flatnonzero(trial.counts)
        scale = 1.0 / np.broadcast_to(sigma, trial.measured.shape)
        return cls(index, trial.measured.reshape(-1)[index], scale.reshape(-1)[index])

    @property
    def count(self) -> int:
        """Number of samples that count."""
        return len(self.measured)

    def lanes(self, prediction: Array, out: Array | None = None) -> Array:
        """(n_lane, count) from predictions (m, n, n_lane) rad."""
        taken = prediction.reshape(-1, prediction.shape[2])[self.index].T
        found = np.empty(taken.shape) if out is None else out
        np.subtract(taken, self.measured, out=found)
        found *= self.scale
        return found
