"""A torque of free shape at each joint, fitted beside the library: it describes what no effect of the library says.

The shape is a sum of hat functions, once over deflection for each direction of motion, once over speed. Each hat, taken
along the *measured* motion, is a known torque; its effect on the predicted motion is one simulated column, so the fit
is a linear least squares in which tolerances (with their priors) and initial states take part. Each trial is then
predicted by the fit without it, in closed form: what a shape takes away there is what it is worth.

The torque is linear in its hats only as long as it moves the predicted phase by little; for a large effect it would
have to be taken again from the motion that it makes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import Scales
from synth.diagnosis.plants.swinging_chain.chain_result import FreeTorque, Over
from synth.diagnosis.workbench import Fit, Workbench
from synth.estimation.intervals import NORMAL90
from synth.estimation.linearisation import Linearisation, LinearisedNormal
from synth.swing.leg_model import Leg
from synth.threads import in_parallel

SHAPES: tuple[Over, ...] = ("deflection", "speed")
PLACES = 9  # hats over the range of deflection, for each direction of motion
SPEEDS = 15  # hats over speed, both directions
FINE = 0.05  # of the largest speed: below it hats are evenly spaced, above it logarithmically
TURNING = 0.02  # of the largest speed, over which the direction of motion changes over
# Prior deviations of a hat, in natural torques; the one that predicts left-out trials best is taken.
SIZES = (1.0, 0.3, 0.1, 0.03, 0.01)
SMOOTH = 2.0  # hats over which the smooth part of the prior is alike
ALIKE = 0.5  # prior correlation of the curves for both directions of motion
STEP = 0.01  # of the joint's natural torque, by which each hat is tried
TELLING = 0.2  # share of the error that a free torque must take on unseen trials to be worth a sentence
LEAST_GAP = 0.05  # of the noise's squares, as for the shrink: less is no gap
ROUNDS = 6  # of the reweighting by the size of the residuals; it settles in three


def free_torques(leg: Leg, bench: Workbench, base: Fit, scales: Scales) -> tuple[FreeTorque, ...]:
    """The better of both shapes at each free joint, the joint that it does most for first.

    Parameters
    ----------
    base : the nominal leg at its best, from which the torque is missing.

    Returns
    -------
    Empty where the nominal leg is as near as the noise, or where there is only one trial, so that nothing can be
    predicted that took no part.
    """
    if len(bench.trials) < 2:
        return ()
    frame = base.frame or bench.frame(base)
    floor = bench.total
    none, _ = _left_out(bench, base, frame, [np.zeros((0, 0))] * len(bench.trials))
    before = float(none.sum()) - floor
    if before <= LEAST_GAP * floor:
        return ()
    found = []
    for j in sorted({j for trial in bench.trials for j in trial.free}):
        tried = []
        for over in SHAPES:
            hats = _Hats.of(bench.trials, j, over, scales, float(leg.rest[j]))
            columns = in_parallel(lambda i, hats=hats: _columns(bench, base, i, hats), len(bench.trials))  # type: ignore[misc]
            for size in SIZES:
                root = size * hats.prior_root()
                squares, each = _left_out(bench, base, frame, [column @ root for column in columns])
                tried.append((max(float(squares.sum()) - floor, 0.0), hats, each @ root.T))
        after, hats, each = min(tried, key=lambda item: item[0])
        found.append(_result(leg.joint_names[j], leg.joints[j].sign, hats, each, 1.0 - float(np.sqrt(after / before))))
    return tuple(sorted(found, key=lambda item: -item.taken))


@dataclass(frozen=True)
class _Hats:
    """Hats of a joint: ``nodes`` rad (of q) or rad/s; ``rest`` rad; natural ``torque`` N m; largest ``speed`` rad/s."""

    joint: int
    over: Over
    nodes: Array
    rest: float
    torque: float
    speed: float

    @classmethod
    def of(cls, trials: Sequence[AngleTrial], joint: int, over: Over, scales: Scales, rest: float) -> _Hats:
        moving = [trial.recording.smoothed for trial in trials if joint in trial.free]
        angle = np.concatenate([smoothed.angle[:, joint] for smoothed in moving])
        # The largest speed but for the fastest hundredth, which glitches of the smoothing may hold.
        speed = float(np.percentile(np.abs(np.concatenate([smoothed.rate[:, joint] for smoothed in moving])), 99))
        if over == "deflection":
            nodes = np.linspace(angle.min(), angle.max(), PLACES)
        else:
            nodes = FINE * speed * np.sinh(np.linspace(-1.0, 1.0, SPEEDS) * np.arcsinh(1.0 / FINE))
        return cls(joint, over, nodes, rest, float(scales.torque[joint]), max(speed, 1e-9))

    def prior_root(self) -> Array:
        """(k, k) square root of the hats' prior covariance, in natural torques."""
        covariance = _smooth(len(self.nodes))
        if self.over == "deflection":
            covariance = np.asarray(np.kron([[1.0, ALIKE], [ALIKE, 1.0]], covariance), dtype=float)
        return np.asarray(np.linalg.cholesky(covariance + 1e-9 * np.eye(len(covariance))))

    def along(self, trial: AngleTrial) -> Array:
        """(n_time, k) each hat along the trial's smoothed motion."""
        smoothed = trial.recording.smoothed
        angle, rate = smoothed.angle[:, self.joint], smoothed.rate[:, self.joint]
        if self.over == "speed":
            scaled = np.arcsinh(rate / (FINE * self.speed))
            return _hats(scaled, np.arcsinh(self.nodes / (FINE * self.speed)))
        direction = np.tanh(rate / (TURNING * self.speed))
        hats = _hats(angle, self.nodes)
        forth, back = (np.maximum(side * direction, 0.0)[:, None] for side in (1.0, -1.0))
        return np.concatenate([hats * forth, hats * back], axis=1)


def _smooth(count: int) -> Array:
    """(k, k) prior covariance of hats in a row: a constant, a straight line, and a smooth rest (squared exponential).

    Where the other trials did not go, a trial is then predicted by their straight line and not by nothing.
    """
    place = np.arange(float(count))
    line = np.linspace(-1.0, 1.0, count)
    apart = place[:, None] - place[None, :]
    return np.asarray(1.0 + np.outer(line, line) + np.exp(-0.5 * (apart / SMOOTH) ** 2))


def _hats(x: Array, nodes: Array) -> Array:
    """(n, k) hats at even ``nodes`` (k,), the outer ones constant beyond their ends."""
    place = np.clip((x - nodes[0]) / (nodes[1] - nodes[0]), 0.0, len(nodes) - 1.0)
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(place[:, None] - np.arange(len(nodes)))))


def _columns(bench: Workbench, base: Fit, index: int, hats: _Hats) -> Array:
    """(count, k) change of a trial's whitened prediction by each hat at the joint's natural torque."""
    trial = bench.trials[index]
    along = hats.along(trial)
    white = bench.whitener(trial)
    if hats.joint not in trial.free:
        return np.zeros((white.count, along.shape[1]))
    smoothed, recording = trial.recording.smoothed, trial.recording
    known = np.zeros((len(smoothed.time), trial.measured.shape[1]))
    if recording.known_torque is not None:
        times, torques = recording.known_torque
        known = np.column_stack([np.interp(smoothed.time, times, column) for column in torques.T])
    block = Block(base.hypothesis, base.unknowns[:, None], base.states[index][:, None])

    def predicted(extra: Array) -> Array:
        torque = known.copy()
        torque[:, hats.joint] += extra
        driven = replace(trial, recording=replace(recording, known_torque=(smoothed.time, torque)))
        return np.asarray(white.lanes(bench.predictor.predict(driven, [block])[0])[0])

    still = predicted(np.zeros(len(smoothed.time)))
    step = STEP * hats.torque
    return np.column_stack([(predicted(step * column) - still) / STEP for column in along.T])


def _left_out(bench: Workbench, base: Fit, frame: Linearisation, columns: Sequence[Array]) -> tuple[Array, Array]:
    """Squares (n_trial,) of each trial predicted without it, and the hats' unknowns (n_trial, k) of these fits.

    ``columns`` : of the hats, (count, k) a trial. Their unknowns have a unit normal prior;
    residuals far above the noise are weighted as in ``Workbench.cost``.
    """
    padded = []
    for residual, column in zip(base.residuals, columns, strict=True):
        wide = np.zeros((len(residual), column.shape[1]))
        wide[: len(column)] = column
        padded.append(wide)
    p = bench.n_tolerance
    prior = np.concatenate([base.unknowns[:p], np.zeros(padded[0].shape[1])])
    squares = sum(float(r @ r) for r in base.residuals)
    for _ in range(ROUNDS):
        normal = frame.normal(base.residuals, padded, 2.0 / (1.0 + squares / bench.total), prior)
        step = np.asarray(-np.linalg.solve(normal.matrix, normal.gradient), dtype=float)
        squares = float(sum(_squares_after(normal, trial, step) for trial in range(len(padded))))
    steps = [normal.without(trial) for trial in range(len(padded))]
    missed = [_squares_after(normal, trial, step) for trial, step in enumerate(steps)]
    return np.array(missed), np.array([step[p:] for step in steps])


def _squares_after(normal: LinearisedNormal, trial: int, step: Array) -> float:
    """A trial's projected sum of squares after a step (p + k,) of the common unknowns, to first order."""
    matrix, gradient = (part / normal.weight for part in normal.parts[trial])
    return normal.squares[trial] + 2.0 * float(gradient @ step) + float(step @ matrix @ step)


def described(found: Sequence[FreeTorque]) -> str:
    """What the first of them says of a gap that no effect explains; empty where it takes too little to tell."""
    if not found or found[0].taken < TELLING:
        return ""
    first = found[0]
    over = "its deflection and direction" if first.over == "deflection" else "its speed"
    return (
        f" The missing torque acts at the {first.joint} and depends on {over}: a free shape there takes "
        f"{first.taken:.0%} of the error on trials that it was not fitted to."
    )


def _result(joint: str, sign: int, hats: _Hats, each: Array, taken: float) -> FreeTorque:
    """From the hats' unknowns (n_trial, k), each without one trial, to a curve in the measured angle's sense."""
    count = len(each)
    middle = each.mean(axis=0)
    deviation = np.sqrt((count - 1) / count * np.sum((each - middle) ** 2, axis=0))  # jackknife (Efron 1982)
    torque, spread = sign * middle * hats.torque, NORMAL90 * deviation * hats.torque
    if hats.over == "speed":
        place, direction = sign * hats.nodes, np.zeros(len(hats.nodes))
    else:
        place = sign * (np.tile(hats.nodes, 2) - hats.rest)
        direction = sign * np.repeat([1.0, -1.0], len(hats.nodes))
    order = np.lexsort((place, direction))
    return FreeTorque(
        joint, hats.over, place[order], direction[order], torque[order], (torque - spread)[order],
        (torque + spread)[order], taken,
    )  # fmt: skip
