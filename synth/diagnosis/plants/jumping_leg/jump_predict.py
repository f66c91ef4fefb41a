"""Predicted sensor readings for many sets of unknowns at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from synth.arrays import Array
from synth.diagnosis.plants.jumping_leg.jump_candidates import JumpCandidate
from synth.diagnosis.plants.jumping_leg.jump_data import ANGLE, CURRENT, FORCE, Jump
from synth.diagnosis.plants.jumping_leg.jump_tolerances import JumpTolerances
from synth.hopper.fold import first_state, fold, parameters_of
from synth.jump.hopper_leg import PRB_GAMMA, PRB_STIFFNESS
from synth.jump.jump_lanes import JumpLanes
from synth.jump.jump_layout import LANES
from synth.jump.jump_runs import FIRST_STEP, MAX_STEPS, compiled_jump
from synth.jump.planar_jump import planar_record
from synth.jump.recorder import record

TOLERANCE = 1e-5  # of the lanes: angles within 2e-5 rad of a run a hundred times finer
PLANAR_TOLERANCE = 1e-4  # of the integrator, as ``jump_runs.TOLERANCE``
N_TRIAL_UNKNOWN = 2  # unknowns per trial: start angle and switch-on time, or a pull-up's first angle and rate
START_ANGLE, START_RATE = np.radians(0.5), 0.5  # rad, rad/s: accuracy of a pull-up's start from its first samples
ERROR_WHERE_ENDED = 30.0  # whitened error of a sample that a simulation does not reach


@dataclass(frozen=True)
class JumpPredictor:
    """Predictions for unknowns ``x`` (n_unknown, n_lane) and each trial's own ``own`` (2, n_lane), all whitened."""

    tolerances: JumpTolerances
    bending: str
    body_inertia: float

    def columns(self, jump: Jump, hypothesis: Sequence[JumpCandidate], x: Array, own: Array) -> JumpLanes:
        """The legs that correspond to the unknowns."""
        made = jump.jumps.repeat(x.shape[1])
        size = self.tolerances.size
        self.tolerances.apply(made, x[:size], jump.group)
        first = size
        for candidate in hypothesis:
            candidate.apply(made, x[first : first + candidate.size])
            first += candidate.size
        if jump.torque is None:
            # Just short of the angle where the lower links lock.
            made.start[:] = np.minimum(
                made.start + self.tolerances.tolerance.crouch * own[0], 0.999 * _locking_angle(made)
            )
        return made

    def predict(self, jump: Jump, hypothesis: Sequence[JumpCandidate], x: Array, own: Array) -> dict[str, Array]:
        """Channel -> (m, n_lane) for the trial's channels; nan after a simulation ends."""
        made = self.columns(jump, hypothesis, x, own)
        if jump.torque is not None:
            found = {ANGLE: _pull_up_angle(jump, made, own)}
        elif jump.leaning:
            found = self._planar(jump, made, own)
        else:
            found = self._upright(jump, made, own)
        if ANGLE in found:
            found[ANGLE] = found[ANGLE] + self.tolerances.shift(x, "angle", jump.group)
        if FORCE in found:
            found[FORCE] = found[FORCE] * np.exp(self.tolerances.shift(x, "force", jump.group))
        if CURRENT in found:
            found["supply"] = made.voltage - made.supply_resistance * found[CURRENT]
        return {name: found[name] for name in jump.measured if name in found}

    def _times(self, jump: Jump, own: Array) -> Array:
        """(m, n_lane) s since each lane's switch-on."""
        return np.asarray(jump.time[:, None] - hypot(self.tolerances.tolerance.start, jump.start_deviation) * own[1])

    def _upright(self, jump: Jump, made: JumpLanes, own: Array) -> dict[str, Array]:
        jumper = compiled_jump(self.bending)
        layout = jumper.layout
        rows = np.array([layout.row("angle"), layout.row("normal"), layout.row("drawn")])
        where = np.array([layout.n_state, layout.row("derivative"), layout.row("alive"), layout.row("normal")])
        workspace, times = made.workspace(), self._times(jump, own)
        found = np.empty((len(times), len(rows), made.count))
        for first in range(0, made.count, LANES):
            lanes = np.minimum(np.arange(first, first + LANES), made.count - 1)
            out = np.empty((len(times), len(rows), LANES))
            record(jumper.right_hand_side, np.ascontiguousarray(workspace[:, lanes]), where, rows,
                   np.ascontiguousarray(times[:, lanes]), TOLERANCE, FIRST_STEP, MAX_STEPS, out)  # fmt: skip
            found[:, :, first : first + LANES] = out[:, :, : made.count - first]
        return {ANGLE: found[:, 0], FORCE: found[:, 1], CURRENT: found[:, 2]}

    def _planar(self, jump: Jump, made: JumpLanes, own: Array) -> dict[str, Array]:
        times = self._times(jump, own)
        names = {ANGLE: "angle", FORCE: "normal", CURRENT: "current", "pitch": "pitch", "foot slide": "slide"}
        found = {name: np.full((len(times), made.count), np.nan) for name in names}
        for lane in range(made.count):
            one = made.take(slice(lane, lane + 1))
            record = planar_record(
                one, self.body_inertia, jump.slip_speed, jump.trial.lean, times[:, lane], PLANAR_TOLERANCE
            )
            for name, row in names.items():
                found[name][:, lane] = record[row]
        return found

    def residual(self, jump: Jump, predicted: dict[str, Array]) -> Array:
        """(M, n_lane) whitened errors of all channels; a trial's samples count as ``EFFECTIVE`` at most."""
        parts = [
            (predicted[name] - measured[:, None]) * (np.sqrt(jump.weight) / jump.sigma[name][:, None])
            for name, measured in jump.measured.items()
        ]
        found: Array = np.nan_to_num(
            np.concatenate(parts), nan=ERROR_WHERE_ENDED, posinf=ERROR_WHERE_ENDED, neginf=-ERROR_WHERE_ENDED
        )
        return found


def _locking_angle(jumps: JumpLanes) -> Array:
    """Largest upper angle that the lower links reach."""
    share = (jumps.lower_length - 0.5 * jumps.hip_spacing) / jumps.length
    return np.asarray(np.arcsin(np.minimum(share, 1.0)))


def _pull_up_angle(jump: Jump, made: JumpLanes, own: Array) -> Array:
    """Rigid links; the hip encoder's share of their bending is added afterwards: a quarter of torque over rate."""
    assert jump.torque is not None
    level, slope = first_state(jump.time, jump.measured[ANGLE])
    start, rate = level + START_ANGLE * own[0], slope + START_RATE * own[1]
    angle = fold(parameters_of(made), jump.time, jump.torque, start, rate)
    if jump.leg.bending == "none":
        return np.asarray(angle)
    rate = PRB_GAMMA * PRB_STIFFNESS * made.bending_stiffness / made.length
    return np.asarray(angle + 0.25 * jump.torque[:, None] / rate)
