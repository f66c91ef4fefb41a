"""What next: the trial of a menu that would best separate the explanations that are still open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.gap_trials import GapTrial
from synth.diagnosis.information import expected_information, rivals_of, would_tell
from synth.diagnosis.result import Experiment
from synth.diagnosis.solve import Fit, Workbench
from synth.fit.recordings import Recording
from synth.motion.smoothing import Smoothed
from synth.swing.chain import Conditions
from synth.swing.leg_model import Leg
from synth.threads import in_parallel
from synth.units import write

LENGTH, RATE = 3.0, 100.0  # s and samples a second of an imagined trial
TILT = np.radians(30.0)  # rad, of the base in a suggested trial


@dataclass(frozen=True)
class Choice:
    """One item of the menu: in words, the ``trials:`` keys, conditions, release (n,) rad in the sense of q, torque."""

    what: str
    trial: Mapping[str, object]
    conditions: Conditions
    release: Array
    ramp: tuple[int, float] | None = None  # joint and final torque, N m in the measured sense


def menu(leg: Leg, trials: Sequence[GapTrial]) -> list[Choice]:
    """Releases of other sizes and sides, joints locked, a mass at the tip, the base tilted, a slow ramp of torque."""
    usual = [trial for trial in trials if not trial.recording.conditions.locked] or list(trials)
    starts = np.array([trial.recording.smoothed.angle[0] for trial in usual])
    ends = np.array([trial.recording.smoothed.angle[-1] for trial in usual])
    rest = np.median(ends, axis=0)
    widest = starts[int(np.argmax(np.abs(starts - rest).sum(axis=1)))]
    away, plain = widest - rest, Conditions()

    def pose(share: float) -> Array:
        return _within(leg, rest + share * away)

    made = [
        Choice("a release a third as large", {}, plain, pose(0.33)),
        Choice("a release as large as the largest so far", {}, plain, pose(1.0)),
        Choice("a release half as large again as the largest so far", {}, plain, pose(1.5)),
        Choice("a release from the other side", {}, plain, pose(-1.0)),
    ]
    n, names = len(leg.joints), leg.joint_names
    tip = 0.5 * leg.joints[-1].link.mass
    for what, keys, conditions in (
        (
            f"a mass of {tip * 1e3:.3g} g at the tip",
            {"tip_mass": write(float(f"{tip:.3g}"), "kg")},
            Conditions((), tip),
        ),
        ("the base tilted by 30 deg", {"tilt": "30 deg"}, Conditions((), 0.0, TILT)),
        ("the base tilted by -30 deg", {"tilt": "-30 deg"}, Conditions((), 0.0, -TILT)),
    ):
        made.append(Choice(what, dict(keys), conditions, pose(1.0)))
    for j in range(n if n > 1 else 0):
        made.append(Choice(f"{names[j]} locked", {"locked": [names[j]]}, Conditions((j,)), pose(1.0)))
    if n > 2:
        for j in range(n):
            others = [k for k in range(n) if k != j]
            held = {"locked": [names[k] for k in others]}
            made.append(Choice(f"all but {names[j]} locked", held, Conditions(tuple(others)), pose(1.0)))
    for j, joint in enumerate(leg.joints):
        if joint.spring is not None:
            torque = 0.7 * joint.spring.rate * float(np.abs(away[j]))
            what = f"a torque on {names[j]} that rises slowly to {torque:.3g} N m in {LENGTH:g} s, recorded with it"
            made.append(Choice(what, {}, plain, _within(leg, rest), (j, torque)))
    return made


def _within(leg: Leg, rotation: Array) -> Array:
    """The pose inside the joints' travel where the leg file gives one."""
    measured = leg.to_measured(rotation)
    for j, joint in enumerate(leg.joints):
        if joint.range is not None:
            measured[j] = np.clip(measured[j], *joint.range)
    return leg.to_rotation(measured)


def next_experiment(
    bench: Workbench, rivals: Sequence[tuple[Fit, float]], everything: Sequence[GapTrial], why: str
) -> Experiment | None:
    """The trial of the menu with the largest expected information on which of the rivals holds.

    ``rivals`` : fits with their weights. A prediction is uncertain by the noise, its own initial state, and what the
    trials so far leave open of the leg.
    """
    if len(rivals) < 2:
        return None
    kept, weights = rivals_of(rivals)
    leg = bench.predictor.leg
    choices = menu(leg, everything)
    covariances = [bench.normal(fit).covariance for fit in kept]

    def information(index: int) -> float:
        trial = _imagined(bench, choices[index])
        told = [_predict(bench, fit, trial, choices[index]) for fit in kept]
        predicted = [found for found in told if found is not None]
        if len(predicted) < len(kept):
            return 0.0
        return expected_information(
            weights, lambda a, b, at: _distance(predicted[a], predicted[b], predicted[at], covariances[at])
        )

    bits = in_parallel(information, len(choices))
    order = sorted(range(len(choices)), key=lambda i: -bits[i])
    best = choices[order[0]]
    release = leg.to_measured(best.release)
    names = leg.joint_names
    file = {"file": "trials/next.csv", **best.trial}
    return Experiment(
        would_tell(why, best.what, bits[order[0]]),
        file,
        {name: float(angle) for name, angle in zip(names, release, strict=True)},
        bits[order[0]],
        tuple((choices[i].what, bits[i]) for i in order),
        None if best.ramp is None else (names[best.ramp[0]], best.ramp[1], LENGTH),
    )


def _imagined(bench: Workbench, choice: Choice) -> GapTrial:
    """A trial of that kind without readings."""
    n = len(choice.release)
    time = np.arange(0.0, LENGTH, 1.0 / RATE)
    held = np.tile(choice.release, (len(time), 1))
    smoothed = Smoothed(time, held, np.zeros_like(held), bench.noise, np.zeros(len(time), dtype=bool))
    counts = np.ones((len(time), n), dtype=bool)
    counts[:, list(choice.conditions.locked)] = False
    known = None
    if choice.ramp is not None:
        joint, torque = choice.ramp
        applied = np.zeros((2, n))
        applied[1, joint] = bench.predictor.leg.joints[joint].sign * torque
        known = (np.array([0.0, LENGTH]), applied)
    recording = Recording("next", time, held, counts, choice.conditions, smoothed, known)
    return GapTrial(recording, time, held, counts, held_out=False)


@dataclass(frozen=True)
class _Predicted:
    mean: Array  # (M,) whitened
    state: Array  # (M, l)
    unknown: Array  # (M, n_unknown)


def _predict(bench: Workbench, fit: Fit, trial: GapTrial, choice: Choice) -> _Predicted | None:
    """Prediction and its derivatives by initial state and unknowns, whitened by the noise; None where it diverges."""
    state = np.concatenate([choice.release, np.zeros(len(choice.release))])
    count = len(fit.unknowns)
    prediction, slopes = bench.slopes(trial, fit, state, range(count))
    if not (np.all(np.isfinite(prediction)) and np.all(np.isfinite(slopes))):
        return None
    mean = (prediction / bench.sigma(trial))[trial.counts]
    return _Predicted(mean, slopes[:, count:], slopes[:, :count])


def _distance(a: _Predicted, b: _Predicted, at: _Predicted, covariance: Array) -> float:
    """Squared Mahalanobis distance of two predictions; states are free, unknowns as uncertain as they are left."""
    q, _ = np.linalg.qr(at.state)
    apart = a.mean - b.mean
    apart = apart - q @ (q.T @ apart)
    slopes = at.unknown - q @ (q.T @ at.unknown)
    # Woodbury: (1 + S C S')^-1 = 1 - S (C^-1 + S'S)^-1 S'
    inner = np.linalg.inv(covariance) + slopes.T @ slopes
    along = slopes.T @ apart
    return max(float(apart @ apart) - float(along @ np.linalg.solve(inner, along)), 0.0)
