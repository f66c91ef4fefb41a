"""Many candidates at once: every candidate's trajectories of a trial are lanes of the compiled engine."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from synth.fit.recordings import Recording
from synth.fit.trajectories import FIT_STEPS, TrajectoryModel
from synth.model.leg import Array
from synth.threads import thread_count


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

    def one(pair: tuple[Recording, Candidates]) -> Array:
        recording, found = pair
        layout = model.chain.layout
        base = model.chain.parameters(model.leg, recording.conditions)
        lanes = np.repeat(base[:, None], found.values.shape[1], axis=1)
        model.unknowns.write(lanes, found.values)
        lanes[layout.rows("rest")] += found.shift
        lanes[layout.rows("rotation")], lanes[layout.rows("rate")] = found.rotation, found.rate
        return model.chain.run(
            lanes, recording.time, tolerance, known_torque=recording.known_torque, max_steps=FIT_STEPS
        )

    pairs = list(zip(recordings, candidates, strict=True))
    if len(pairs) == 1 or thread_count() == 1:
        return [one(pair) for pair in pairs]
    return list(_workers().map(one, pairs))


@lru_cache(maxsize=1)
def _workers() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=thread_count(), thread_name_prefix="synth-candidates")
