"""Frames that a recording without time stamps has lost: found by a fit, told, and put back into its time.

Rates from such a recording are wrong: of 40 simulated legs of which a camera lost 1 % of the frames, one or two at
once, 66 % of the 90 % intervals held the truth; with the frames put back 88 % do, 90 % of the same legs without losses
(``python -m robustness.dirty --kind lost_frames --seed 41``). The steps of ``frame_paths`` are believed only if the
angles jump by them: no torque makes an angle jump, so a hand or another law leaves a residual that is smooth there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.frame_paths import Frames, FrameStep, StepGains, best_path, price, steps_of, timed
from synth.fit.free_angle import WIDE
from synth.fit.least_squares import FitStart, Stage
from synth.fit.recordings import Recording
from synth.fit.refinement import refine, refine_other_starts
from synth.fit.starts import first_locals, weak_form_start
from synth.fit.trajectories import TrajectoryModel
from synth.fit.uncertainty import clipped_rms, sample_scatter
from synth.motion.smoothing import smooth
from synth.remarks import decisive
from synth.swing.leg_model import Leg

EVEN = 0.1  # of a step, by which the stamps of an even clock may be off: 120 Hz in whole milliseconds are 0.06 off
ROUNDS = 25  # fits, one for each step that is added at most; each begins where the last ended
# Rounds, and times the samples' scatter, residuals above which something else is wrong; a choice between the time of a
# search in vain and a fit that is far off at first.
PATIENCE, HOPELESS_RESIDUAL = 4, 2.0
AROUND = 8  # samples on either side of a step, in which a smooth misfit is a cubic
DEGREE = 3
# Of the angles' jumps, in units of a log-likelihood: of all steps together, and of each.
LEAST_SHOWN, LEAST_OF_STEP = 6.0, 0.0
LEAST_OF_MOVE = 1.0  # in the same units, what a step gains that is moved to another place
# Times the samples' scatter, residuals above which something else is wrong: of 40 simulated legs that lost frames all
# but one came within 1.2 (that one ended in a wrong minimum), of 20 with a hand, or with markers
# on soft tissue, none below 1.4.
MOST_RESIDUAL = 1.25
LEAST_SHARE = 0.5  # of the log-likelihood that steps of these sizes show on average, which these must show together
TOLD = 4  # steps that a sentence tells


@dataclass(frozen=True)
class LostFrames:
    """``recordings`` with the lost frames put back into their time, and the ``steps`` of each."""

    recordings: list[Recording]
    steps: tuple[tuple[FrameStep, ...], ...]

    @property
    def sentences(self) -> list[str]:
        """One on all recordings, at the times that their files have."""
        told = []
        for recording, steps in zip(self.recordings, self.steps, strict=True):
            places = [f"{step.lost} before {step.row * recording.step:.3g} s" for step in steps[:TOLD]]
            more = [f"{len(steps) - TOLD} times more"] if len(steps) > TOLD else []
            if places:
                told.append(f"{recording.name}: {', '.join([*places, *more])}")
        count = sum(step.lost for steps in self.steps for step in steps)
        frames, were = ("frame", "was") if count == 1 else ("frames", "were")
        return [
            decisive(
                f"{count} {frames} {were} lost that the time does not show ({'; '.join(told)}): all joints jump there "
                "by what they turn in so many steps. The fit puts them back. Frames that are lost while the limb "
                "hardly moves cannot be found, and are not in the intervals",
                "Export the camera's time stamps or frame numbers (a column `frame`), or record without losses; of an "
                "encoder's log find out why its time jumps.",
            )
        ]


def lost_frames(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions) -> LostFrames | None:
    """The frames that recordings of even clocks lost; None if they show none.

    None too where a recording has another clock, is driven, or was averaged: a step is not one frame there.
    """
    if not recordings or not all(_even(recording) for recording in recordings):
        return None
    model = model_of(leg, options.curves, recordings=recordings, prior=options.prior)
    found = _aligned(model, recordings, options)
    if found is None:
        return None
    left, scatter = clipped_rms(found.recordings, found.predictions), np.fmax(sample_scatter(recordings), 1e-9)
    if np.any(left > MOST_RESIDUAL * scatter) or not found.shows(LEAST_SHOWN):
        return None
    made = [_with_steps(recording, steps) for recording, steps in zip(recordings, found.steps, strict=True)]
    return LostFrames(made, found.steps)


def _even(recording: Recording) -> bool:
    """Whether the stamps may be frames over a rate."""
    if recording.driven or recording.thinning or any(count > 1 for count in recording.averaged):
        return False
    even = recording.step * np.arange(len(recording.time))
    return bool(np.abs(recording.time - even).max() < EVEN * recording.step)


@dataclass(frozen=True)
class _Aligned:
    """``recordings`` with the time of ``paths``, their fit's ``stage``, and its ``cost``."""

    recordings: list[Recording]
    paths: list[Frames]
    stage: Stage
    cost: float

    @property
    def predictions(self) -> tuple[Array, ...]:
        """(m, n) rad of each."""
        return self.stage.solution.predictions

    @cached_property
    def _jumps(self) -> list[list[tuple[FrameStep, float]]]:
        """The steps by which the angles jump, each with what it would show on average."""
        scatter, found = np.fmax(sample_scatter(self.recordings), 1e-9), []
        for recording, prediction, path in zip(self.recordings, self.predictions, self.paths, strict=True):
            shown = [(step, *_shown(recording, prediction, step, scatter)) for step in steps_of(path)]
            found.append([(replace(s, gain=gain), usual) for s, gain, usual in shown if gain > LEAST_OF_STEP])
        return found

    @property
    def steps(self) -> tuple[tuple[FrameStep, ...], ...]:
        """Those of each recording by which its angles jump."""
        return tuple(tuple(step for step, _ in each) for each in self._jumps)

    def shows(self, least: float) -> bool:
        """Whether the jumps gain so much together, and a good part of what they would on average."""
        every = [pair for each in self._jumps for pair in each]
        shown, usual = sum(step.gain for step, _ in every), sum(usual for _, usual in every)
        return shown > least and shown > LEAST_SHARE * usual


def _aligned(model: TrajectoryModel, recordings: Sequence[Recording], options: LegFitOptions) -> _Aligned | None:
    """The best fit with lost frames; None without any step, or if they hardly help."""
    spread = np.full(len(model.leg.joints), WIDE if len(recordings) > 1 else 0.0)
    start, scatter = weak_form_start(model, recordings, options).values, sample_scatter(recordings)
    stage = refine(model, recordings, FitStart(start, first_locals(recordings)), "noise", spread)
    stage = refine_other_starts(model, recordings, stage, scatter, spread, weight="noise", seed=options.seed)
    best = _of_paths(recordings, [np.zeros(len(each.time), dtype=np.intp) for each in recordings], stage)
    for count in range(ROUNDS):
        further = _further(model, recordings, best) if np.isfinite(best.cost) else None
        if further is None:
            break
        now = [timed(recording, path) for recording, path in zip(recordings, further, strict=True)]
        solution = best.stage.solution
        stage = refine(model, now, FitStart(solution.values, solution.locals), "noise", spread)
        found = _of_paths(now, further, stage)
        if not found.cost < best.cost:
            break
        best = found
        left = clipped_rms(best.recordings, best.predictions)
        if count == PATIENCE and np.any(left > HOPELESS_RESIDUAL * scatter):
            return None
    return best if any(path.any() for path in best.paths) else None


def _of_paths(recordings: Sequence[Recording], paths: list[Frames], stage: Stage) -> _Aligned:
    """With minus the log-likelihood, each joint's noise estimated from its residual, and the price of the steps."""
    if not np.isfinite(stage.solution.cost):
        return _Aligned(list(recordings), paths, stage, np.inf)
    rms = clipped_rms(recordings, stage.solution.predictions)
    samples = np.sum([recording.counts.sum(axis=0) for recording in recordings], axis=0)
    steps = sum(price(r) * len(steps_of(path)) for r, path in zip(recordings, paths, strict=True))
    return _Aligned(list(recordings), paths, stage, float(np.nansum(samples * np.log(rms + 1e-12))) + steps)


def _further(model: TrajectoryModel, recordings: Sequence[Recording], at: _Aligned) -> list[Frames] | None:
    """Better paths than those of ``at``; None if there are none. ``recordings`` : with their even clocks."""
    scatter, solution = clipped_rms(at.recordings, at.predictions) + 1e-9, at.stage.solution
    scatter = np.where(np.isfinite(scatter), scatter, 1.0)
    made = [
        best_path(model, recording, solution.values, local, scatter)
        for recording, local in zip(recordings, solution.locals, strict=True)
    ]
    if any(not np.array_equal(new, old) for new, old in zip(made, at.paths, strict=True)):
        return made
    gains, single = StepGains(model, at.recordings, solution, scatter), []
    for t, recording in enumerate(recordings):
        step = gains.best(t)
        single.append(at.paths[t] + _rise(step, at.paths[t]) if step and step.gain > price(recording) else at.paths[t])
    if any(new is not old for new, old in zip(single, at.paths, strict=True)):
        return single
    return _with_one_moved(gains, at.paths)


def _with_one_moved(gains: StepGains, paths: list[Frames]) -> list[Frames] | None:
    """The paths with that step moved to another place that gains most by it; None if none gains."""
    found: tuple[float, int, Frames] | None = None
    for t, path in enumerate(paths):
        for step in steps_of(path):
            other = gains.instead(t, step)
            if other is not None and other.gain > max(LEAST_OF_MOVE, 0.0 if found is None else found[0]):
                found = other.gain, t, path - _rise(step, path) + _rise(other, path)
    return None if found is None else [found[2] if t == found[1] else path for t, path in enumerate(paths)]


def _rise(step: FrameStep, path: Frames) -> Frames:
    """(m,) frames that a step adds to a path."""
    return np.where(np.arange(len(path)) >= step.row, step.lost, 0)


def _shown(recording: Recording, prediction: Array, step: FrameStep, scatter: Array) -> tuple[float, float]:
    """Gain in the log-likelihood of the jump at a step, and its expectation, if the misfit beside it is smooth.

    Without the step the readings from ``step.row`` on lie ahead by what the joints turn in that time.
    """
    rows = slice(max(step.row - AROUND, 0), step.row + AROUND)
    since = np.arange(len(recording.time))[rows] - step.row
    smooth_part = np.vander(since / AROUND, DEGREE + 1)
    ahead = np.gradient(prediction, recording.time, axis=0)[rows] * recording.step * step.lost
    gain = expected = 0.0
    for j in recording.free:
        good = recording.counts[rows, j]
        if good.sum() <= DEGREE + 1:
            continue
        basis, _ = np.linalg.qr(smooth_part[good])
        jump = np.where(since >= 0, ahead[:, j], 0.0)[good] / scatter[j]
        off = (recording.rotation - prediction)[rows, j][good] / scatter[j] + jump  # about the fit without the step
        jump, off = (each - basis @ (basis.T @ each) for each in (jump, off))
        # A misfit that is no cubic there is scatter of its own.
        beside = max(1.0, float(np.sum((off - jump) ** 2)) / float(good.sum() - DEGREE - 1))
        square = float(jump @ jump) / beside
        gain += float(jump @ off) / beside - 0.5 * square
        expected += 0.5 * square
    return gain, expected


def _with_steps(recording: Recording, steps: Sequence[FrameStep]) -> Recording:
    """The recording with the time that was lost, smoothed anew; as it is without steps."""
    if not steps:
        return recording
    rows = np.arange(len(recording.time))
    path = np.sum([step.lost * (rows >= step.row) for step in steps], axis=0)
    time = recording.time + recording.step * path
    held = np.isin(np.arange(recording.rotation.shape[1]), recording.conditions.locked)
    smoothed = smooth(time, recording.rotation, ~(recording.known | held), locked=recording.conditions.locked)
    for j in recording.conditions.locked:
        smoothed.rate[:, j] = 0.0
    return replace(recording, time=time, smoothed=smoothed)
