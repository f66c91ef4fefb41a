"""Residuals of whole trajectories and their Jacobian, from lanes: one nominal and its perturbations step together.

Internal numerical differentiation (Bock 1983, as told in Hairer et al., *Solving ODEs I*, section II.6 and Nocedal &
Wright, *Numerical Optimization*, section 8.1): perturbed trajectories that share the nominal's steps differ from it
smoothly, so forward differences at rtol 1e-5 are good to 3e-5 of the largest. That is too little for an overdamped
joint, whose steps lie at the limit of stability: how its error of 1e-5 rad depends on b then looks like information
that separates k from b, and the interval comes out up to seven times too narrow (measured: hip at 60 N m/rad and
12 N m s/rad, 0.3 deg noise). At rtol 1e-7 it comes out right, and fits take no longer: the iteration does not grope
in noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from synth.fit.recordings import Recording
from synth.fit.unknowns import Unknowns
from synth.model.chain import Chain, Conditions
from synth.model.layout import LANES
from synth.model.leg import Array, Leg
from synth.threads import thread_count

PERTURBATION = 1e-6  # of log rates, rad, and 10x that of rad/s
FIT_STEPS = 8000
FIT_TOLERANCE = 1e-7


@dataclass(frozen=True)
class Local:
    """What belongs to one trial: initial rotation (n,), initial rate (n,) and shift of the rest angles (n,)."""

    rotation: Array
    rate: Array
    shift: Array


@dataclass(frozen=True)
class Evaluation:
    """Prediction (m, n) rad of one trial; Jacobians (m, n, n_unknown) and (m, n, n_local), None if not asked for.

    Local columns: initial rotations of the free joints, their initial rates, then shifts of the joints whose rest is
    among the unknowns.
    """

    prediction: Array
    common: Array | None = None
    local: Array | None = None


@lru_cache(maxsize=1)
def _workers() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=thread_count(), thread_name_prefix="synth-lanes")


class TrajectoryModel:
    """Predicts recordings of one leg for given unknowns; keeps the constant part of each trial's lane."""

    def __init__(self, chain: Chain, leg: Leg, unknowns: Unknowns, tolerance: float = FIT_TOLERANCE) -> None:
        self.chain, self.leg, self.unknowns, self.tolerance = chain, leg, unknowns, tolerance
        self._base: dict[Conditions, Array] = {}

    def shifted(self, recording: Recording) -> list[int]:
        """Joints whose rest may shift in this trial: free, with the rest among the unknowns."""
        return [j for j in recording.free if self.unknowns.rest_index[j] is not None]

    def evaluate(self, recording: Recording, values: Array, local: Local, *, jacobian: bool = True) -> Evaluation:
        """Prediction of one trial, with Jacobians if asked for; nan where the motion diverged."""
        layout, free = self.chain.layout, recording.free
        n_common, n_state = len(values), 2 * len(free)
        steps = [(0, k) for k in range(n_common)] + [(1, k) for k in range(n_state)] if jacobian else []
        per_group = LANES - 1
        groups = [steps[i : i + per_group] for i in range(0, len(steps), per_group)] or [[]]
        lanes = np.repeat(self._lane(recording.conditions)[:, None], len(steps) + len(groups), axis=1)
        column, places, nominals = 0, [], []
        common = np.repeat(values[:, None], lanes.shape[1], axis=1)
        state = np.concatenate([local.rotation, local.rate])
        states = np.repeat(state[:, None], lanes.shape[1], axis=1)
        rows = [*free, *[layout.n + j for j in free]]
        for group in groups:
            nominals.append(column)
            for offset, (kind, k) in enumerate(group):
                place = column + 1 + offset
                places.append((place, column))
                if kind == 0:
                    common[k, place] += PERTURBATION
                else:
                    states[rows[k], place] += PERTURBATION * (1.0 if k < len(free) else 10.0)
            column += 1 + len(group)
        self.unknowns.write(lanes, common)
        lanes[layout.rows("rest")] += local.shift[:, None]
        lanes[layout.rows("rotation")], lanes[layout.rows("rate")] = states[: layout.n], states[layout.n :]
        out = self.chain.run(
            lanes, recording.time, self.tolerance, known_torque=recording.known_torque, max_steps=FIT_STEPS
        )
        prediction = out[:, :, 0]
        if not jacobian:
            return Evaluation(prediction)
        width = np.r_[np.full(n_common, 1.0), np.full(len(free), 1.0), np.full(len(free), 10.0)] * PERTURBATION
        moved, still = np.array(places).T
        full = (out[:, :, moved] - out[:, :, still]) / width
        rest = [self.unknowns.rest_index[j] for j in self.shifted(recording)]
        shift = full[:, :, [k for k in rest if k is not None]]
        return Evaluation(prediction, full[:, :, :n_common], np.concatenate([full[:, :, n_common:], shift], axis=2))

    def evaluate_all(
        self, recordings: Sequence[Recording], values: Array, locals_: Sequence[Local], *, jacobian: bool = True
    ) -> list[Evaluation]:
        """``evaluate`` for every trial, on all cores: the compiled code runs without the interpreter's lock."""

        def share(first: int) -> list[Evaluation]:
            mine = zip(recordings[first::workers], locals_[first::workers], strict=True)
            return [self.evaluate(recording, values, local, jacobian=jacobian) for recording, local in mine]

        workers = min(thread_count(), len(recordings))  # one task a core: a trial alone is over too soon
        found: list[list[Evaluation]] = list(_workers().map(share, range(workers)))
        return [found[index % workers][index // workers] for index in range(len(recordings))]

    def _lane(self, conditions: Conditions) -> Array:
        if conditions not in self._base:
            self._base[conditions] = self.chain.parameters(self.leg, conditions)
        return self._base[conditions]

    def step_local(self, recording: Recording, local: Local, step: Array) -> Local:
        """A trial's own unknowns after a step in the order of ``Evaluation.local``."""
        free, shifted = recording.free, self.shifted(recording)
        rotation, rate, shift = local.rotation.copy(), local.rate.copy(), local.shift.copy()
        rotation[free] += step[: len(free)]
        rate[free] += step[len(free) : 2 * len(free)]
        shift[shifted] += step[2 * len(free) :]
        return Local(rotation, rate, shift)
