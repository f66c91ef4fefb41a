"""Hat functions over a joint's deflection and direction, or over its speed: the basis of a free-form torque.

Each hat evaluated along the *measured* motion is a known torque; so is a sum of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import NaturalSizes
from synth.diagnosis.plants.swinging_chain.chain_result import Over
from synth.diagnosis.plants.swinging_chain.chain_where import MissingTorque
from synth.diagnosis.workbench import Workbench
from synth.fit.recordings import Recording

HATS_OVER_DEFLECTION = 9  # hats over the range of deflection, for each direction of motion
HATS_OVER_SPEED = 15  # hats over speed, both directions
FINE_SPEED_SHARE = 0.05  # of the largest speed: below it hats are evenly spaced, above it logarithmically
TURNING_SHARE = 0.02  # of the largest speed, width of the transition between directions of motion
CORRELATION_LENGTH = 2.0  # in hats, correlation length of the smooth part of the prior
DIRECTION_CORRELATION = 0.5  # prior correlation between the curves of both directions of motion
KNOTS_A_TRIAL = 250  # points of the torque along a trial, linear between them
HEIGHT_STEP = 0.01  # of the joint's natural torque, step of the derivative by each hat


@dataclass(frozen=True)
class Hats:
    """Hats of a joint: ``nodes`` rad (of q) or rad/s; ``rest`` rad; natural ``torque`` N m; largest ``speed`` rad/s."""

    joint: int
    over: Over
    nodes: Array
    rest: float
    torque: float
    speed: float

    @classmethod
    def of(cls, trials: Sequence[AngleTrial], joint: int, over: Over, scales: NaturalSizes, rest: float) -> Hats:
        """Hats over the range of the joint's motion in the trials."""
        moving = [trial.recording.smoothed for trial in trials if joint in trial.free]
        angle = np.concatenate([smoothed.angle[:, joint] for smoothed in moving])
        # The largest speed without the fastest hundredth, which may contain smoothing artefacts.
        speed = float(np.percentile(np.abs(np.concatenate([smoothed.rate[:, joint] for smoothed in moving])), 99))
        if over == "deflection":
            nodes = np.linspace(angle.min(), angle.max(), HATS_OVER_DEFLECTION)
        else:
            nodes = (
                FINE_SPEED_SHARE
                * speed
                * np.sinh(np.linspace(-1.0, 1.0, HATS_OVER_SPEED) * np.arcsinh(1.0 / FINE_SPEED_SHARE))
            )
        return cls(joint, over, nodes, rest, float(scales.torque[joint]), max(speed, 1e-9))

    @property
    def count(self) -> int:
        """Number of hats."""
        return len(self.nodes) * (2 if self.over == "deflection" else 1)

    def prior_root(self) -> Array:
        """(k, k) square root of the hats' prior covariance, in natural torques."""
        covariance = _smooth_covariance(len(self.nodes))
        if self.over == "deflection":
            covariance = np.asarray(
                np.kron([[1.0, DIRECTION_CORRELATION], [DIRECTION_CORRELATION, 1.0]], covariance), dtype=float
            )
        return np.asarray(np.linalg.cholesky(covariance + 1e-9 * np.eye(len(covariance))))

    def along(self, trial: AngleTrial) -> Array:
        """(n_time, k) each hat along the trial's smoothed motion."""
        smoothed = trial.recording.smoothed
        angle, rate = smoothed.angle[:, self.joint], smoothed.rate[:, self.joint]
        if self.over == "speed":
            scaled = np.arcsinh(rate / (FINE_SPEED_SHARE * self.speed))
            return _hat_values(scaled, np.arcsinh(self.nodes / (FINE_SPEED_SHARE * self.speed)))
        direction = np.tanh(rate / (TURNING_SHARE * self.speed))
        hats = _hat_values(angle, self.nodes)
        forth, back = (np.maximum(side * direction, 0.0)[:, None] for side in (1.0, -1.0))
        return np.concatenate([hats * forth, hats * back], axis=1)

    def driven(self, trial: AngleTrial, heights: Array) -> AngleTrial:
        """The trial with the torque of these heights (k,), in natural torques, added to its known torques."""
        if self.joint not in trial.free:
            return trial
        recording = trial.recording
        time, basis = self._along_knots(trial)
        known = np.zeros((len(time), trial.measured.shape[1]))
        if recording.known_torque is not None:
            times, torques = recording.known_torque
            known = np.column_stack([np.interp(time, times, column) for column in torques.T])
        known[:, self.joint] += self.torque * (basis @ heights)
        return replace(trial, recording=replace(recording, known_torque=(time, known)))

    def _along_knots(self, trial: AngleTrial) -> tuple[Array, Array]:
        """Times (n_knot,) s and hats (n_knot, k) there; a driven trial keeps all times of its torque."""
        key = id(trial.recording)
        if key not in self._kept:
            smoothed, driven = trial.recording.smoothed, trial.recording.known_torque
            every = max(1, len(smoothed.time) // KNOTS_A_TRIAL)
            time = smoothed.time[::every] if driven is None else np.union1d(smoothed.time[::every], driven[0])
            along = self.along(trial)
            basis = np.column_stack([np.interp(time, smoothed.time, column) for column in along.T])
            self._kept[key] = trial.recording, time, basis
        return self._kept[key][1:]

    @cached_property
    def _kept(self) -> dict[int, tuple[Recording, Array, Array]]:
        """The cached result of ``_along_knots``."""
        return {}

    def columns(self, bench: Workbench, fit: EvaluatedHypothesis, index: int, heights: Array) -> Array:
        """(count, k) change of a trial's whitened prediction per natural torque of each hat.

        ``bench`` : without the free torque; ``heights`` (k,) of it at ``fit``.
        """
        trial = bench.trials[index]
        white = bench.whitener(trial)
        if self.joint not in trial.free:
            return np.zeros((white.count, self.count))
        block = Block(fit.hypothesis, fit.unknowns[:, None], fit.states[index][None, :, None])

        def predicted(at: Array) -> Array:
            return np.asarray(white.lanes(bench.predictor.predict([self.driven(trial, at)], [block])[0])[0])

        still = predicted(heights)
        return np.column_stack(
            [(predicted(heights + HEIGHT_STEP * hat) - still) / HEIGHT_STEP for hat in np.eye(self.count)]
        )

    def from_missing(self, trials: Sequence[AngleTrial], missing: Sequence[MissingTorque]) -> Array:
        """(k,) heights, in natural torques, nearest to the torque missing along the recordings.

        Ridge regression with the prior's shape; without simulation, and therefore valid for any phase error.
        """
        root = self.prior_root()
        rows, wanted = [], []
        for trial, lacking in zip(trials, missing, strict=True):
            if self.joint in trial.free and len(lacking.time):
                at = np.clip(np.searchsorted(trial.recording.smoothed.time, lacking.time), 0, None)
                found = self.along(trial)[np.minimum(at, len(trial.recording.smoothed.time) - 1)]
                good = np.isfinite(lacking.torque[:, self.joint])
                rows.append(found[good] @ root)
                wanted.append(lacking.torque[good, self.joint] / self.torque)
        if not rows:
            return np.zeros(self.count)
        matrix, right = np.concatenate(rows), np.concatenate(wanted)
        noise = max(float(np.mean(right**2)), 1e-30)
        white = np.linalg.solve(matrix.T @ matrix / noise + np.eye(self.count), matrix.T @ right / noise)
        return np.asarray(root @ white)


def _smooth_covariance(count: int) -> Array:
    """(k, k) prior covariance of consecutive hats: a constant, a straight line, and a smooth part (squared
    exponential).

    Outside the range of the other trials, a trial is then predicted by their straight line rather than by zero.
    """
    place = np.arange(float(count))
    line = np.linspace(-1.0, 1.0, count)
    apart = place[:, None] - place[None, :]
    return np.asarray(1.0 + np.outer(line, line) + np.exp(-0.5 * (apart / CORRELATION_LENGTH) ** 2))


def _hat_values(x: Array, nodes: Array) -> Array:
    """(n, k) hats at evenly spaced ``nodes`` (k,), constant beyond the ends."""
    place = np.clip((x - nodes[0]) / (nodes[1] - nodes[0]), 0.0, len(nodes) - 1.0)
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(place[:, None] - np.arange(len(nodes)))))
