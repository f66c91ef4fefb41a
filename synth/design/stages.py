"""The three fits of a design: the animal's leg, the robot's links to its motion, the same with real dampers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.design.response import WantedRelease
from synth.errors import Problem, UserError
from synth.files.leg_project import LegProject
from synth.fit.copies import without_copies
from synth.fit.damper_laws import DamperLaw, find_damper_law
from synth.fit.drives_off import drives_off_sentence
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult, TrialFit
from synth.fit.later_samples import recordings_from
from synth.fit.methods import require_method
from synth.fit.recordings import Recording, recordings
from synth.fit.still_start import from_release
from synth.fit.trial_fits import trial_fits
from synth.fit.unseen_score import score
from synth.swing.leg_model import DamperCurve


@dataclass(frozen=True)
class SourceMotion:
    """The animal's fitted and held-out recordings, in its own time scale and in the robot's.

    ``notes`` : a sentence for each recording that was cut or left out because it begins before the release.
    """

    fitted: tuple[Recording, ...]
    held_out: tuple[Recording, ...]
    factor: float
    notes: tuple[str, ...] = ()
    begun_late: bool = False  # they are cut after the release

    def cut(self, start: float) -> SourceMotion:
        """The recordings from ``start`` s after their first sample, in the animal's time."""
        if start == 0.0:
            return self
        fitted, held_out = recordings_from(self.fitted, start), recordings_from(self.held_out, start)
        return replace(
            self, fitted=tuple(fitted or self.fitted), held_out=tuple(held_out or self.held_out), begun_late=True
        )

    @property
    def fitted_scaled(self) -> list[Recording]:
        """The fitted recordings, stretched in time: rates are divided by the factor, amplitudes are unchanged."""
        return [recording.stretched(self.factor) for recording in self.fitted]

    @property
    def held_out_scaled(self) -> list[Recording]:
        """The held-out recordings, stretched in time."""
        return [recording.stretched(self.factor) for recording in self.held_out]


def read_motion(project: LegProject) -> SourceMotion:
    """The project's trials as recordings.

    Raises
    ------
    UserError : every trial is held out, a trial cannot be used, or one is driven by a known torque.
    """
    fitted = [trial for trial in project.trials if not trial.held_out]
    held_out = [trial for trial in project.trials if trial.held_out]
    if not fitted:
        text = "all trials are held out; at least one must be fitted"
        raise UserError(Problem(text, str(project.path), key="source.trials"))
    driven = [
        Problem("has torque columns; a driven motion cannot be scaled to another leg", trial.name)
        for trial in project.trials
        if trial.torques is not None
    ]
    if driven:
        raise UserError(driven)
    sentence = drives_off_sentence(project.target)
    off = [] if sentence is None or sentence in project.messages else [sentence]
    both = recordings(project.source, fitted), recordings(project.source, held_out, ())
    own, checks, copied = without_copies(*both, str(project.path), "source.trials")
    if project.release == "recorded":
        return SourceMotion(tuple(own), tuple(checks), project.time_scale, (*project.messages, *off, *copied))
    begun = [from_release(project.source, some) for some in (own, checks)]
    notes = (*off, *copied, *begun[0].messages, *begun[1].messages)
    return SourceMotion(tuple(begun[0].recordings), tuple(begun[1].recordings), project.time_scale, notes)


def fit_options(project: LegProject, curves: Mapping[str, DamperCurve] | None = None) -> LegFitOptions:
    """The project's fit options.

    Raises
    ------
    UserError : an invalid combination of method and cost.
    """
    require_method(project.fit, str(project.path))
    intervals = project.fit.intervals
    return LegFitOptions(
        project.free_angle,
        project.fit.weight,
        curves or {},
        project.fit.seed,
        intervals=intervals,
        tolerance=project.tolerance,
    )


def scored_trials(result: FitResult, held_out: Sequence[Recording]) -> tuple[TrialFit, ...]:
    """Held-out recordings with the fitted leg's prediction for them."""
    if not held_out:
        return ()
    scored = score(result, held_out)
    return trial_fits(result.leg, result.joints, held_out, scored.locals, scored.predictions, held_out=True)


def with_held_out(result: FitResult, held_out: Sequence[Recording], *, begun_late: bool = False) -> FitResult:
    """The result with the held-out trials scored and listed after the fitted ones."""
    trials = (*result.trials, *scored_trials(result, held_out))
    return replace(result, trials=tuple(trial.begun_late() for trial in trials) if begun_late else trials)


def damper_laws(project: LegProject) -> dict[str, DamperLaw]:
    """The laws of the dampers that were measured by drop tests, by joint."""
    laws = {}
    for joint, measured in project.dampers.items():
        if measured.leg is None:
            continue
        drops = [trial for trial in measured.trials if not trial.held_out]
        held_out = [trial for trial in measured.trials if trial.held_out]
        both = recordings(measured.leg, [*drops, *held_out], (joint,))
        laws[joint] = find_damper_law(measured.leg, joint, both[: len(drops)], both[len(drops) :])
    return laws


def releases(motion: Sequence[Recording], result: FitResult) -> list[WantedRelease]:
    """Each fitted trial's estimated initial state, as a release of the wanted leg.

    A trial's own shift of the free angle is subtracted from the initial pose: the robot's springs do not drift, and the
    wanted motion is the animal's motion about the common rest pose.
    """
    found = []
    names = result.leg.joint_names
    common = np.array([result.joints[name].free_angle.value for name in names])
    for recording, trial in zip(motion, result.trials, strict=False):
        shift = result.leg.sign * (trial.free_angle - common)
        found.append(
            WantedRelease(recording.name, recording.time, trial.rotation - shift, trial.rate, recording.conditions)
        )
    return found
