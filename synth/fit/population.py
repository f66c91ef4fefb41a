"""Many candidates at once: every candidate's trajectories of a trial are lanes of the compiled engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.fit.recordings import Recording
from synth.fit.trajectories import TrajectoryModel
from synth.model.leg import Array
from synth.threads import shared_out


@dataclass(frozen=True)
class Candidates:
    """Columns of candidates for one trial.

    ``values`` (p, c) unknowns; ``rotation`` and ``rate`` (n, c) initial state; ``shift`` (n, c) rad of the rests.
    """

    values: Array
    rotation: Array
    rate: Array
    shift: Array


def motions(
    model: TrajectoryModel, recordings: Sequence[Recording], candidates: Sequence[Candidates], tolerance: float
) -> list[Array]:
    """(m, n, c) rad for each trial, nan where a motion diverged; the trials are shared out over the cores."""
    rough = TrajectoryModel(model.chain, model.leg, model.unknowns, tolerance)

    def one(t: int) -> Array:
        found = candidates[t]
        return rough.run(recordings[t], found.values, np.concatenate([found.rotation, found.rate]), found.shift)

    return shared_out(one, len(recordings))
