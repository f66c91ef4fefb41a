"""A family of legs: the wanted leg of one leg-design project at several time scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import degrees

import numpy as np

from synth.arrays import Array
from synth.comparison.side import MODEL, RECORDED, ComparedMotion, FollowedMotion, Side, StatedFigure, joints_of
from synth.comparison.side_source import Source
from synth.design.stages import SourceMotion, fit_options, read_motion
from synth.design.target_effects import target_of
from synth.files.projects import read_leg_project
from synth.fit.fit_result import FitResult
from synth.fit.methods import fit_by
from synth.fit.recordings import Recording
from synth.fit.wanted_motion import with_wanted_leg
from synth.parts.catalogs import Catalogue
from synth.parts.resolver import resolver
from synth.swing.leg_model import Leg


def scaled_sides(source: Source, scales: Sequence[float]) -> list[Side]:
    """The animal as recorded, and the robot's links fitted to its motion at each scale, which is their ``pace``.

    Without ``scales``: the animal slowed down to the project's own scale, and the robot's links fitted to that. The
    driven beginning of recordings is cut as in ``synth leg``.

    Raises
    ------
    UserError : the project or its trials cannot be used.
    """
    project = read_leg_project(source.path, open_catalogue=lambda paths: resolver(Catalogue.load(paths)))
    project = with_wanted_leg(project)
    options, motion, into = fit_options(project), read_motion(project), target_of(project.target)
    found = fit_by(project.source, motion.fitted, replace(options, release=project.release), project.fit)
    motion = motion.cut(found.cut)
    fits = {
        scale: fit_by(into.ideal, [each.stretched(scale) for each in motion.fitted], options, project.fit)
        for scale in scales or (project.time_scale,)
    }
    sides: list[Side] = []
    if "animal" in source.views and scales:
        sides.append(_recorded(source, found, motion, into.ideal))
    elif "animal" in source.views:
        ((scale, fitted),) = fits.items()
        sides.append(_slowed(source, fitted, motion, scale))
    if "wanted" in source.views:
        wanted = {scale: _wanted(source, fitted, scale) for scale, fitted in fits.items()}
        sides += [_of_family(wanted[s], source, (found, fits[s]), motion, s) if scales else wanted[s] for s in fits]
    return sides


def _wanted(source: Source, fitted: FitResult, scale: float) -> Side:
    known = {name: joint.as_json() for name, joint in fitted.joints.items()}
    stated = tuple(
        StatedFigure(f"{name}: RMS from the animal's motion {scale:g} times slower",
                     {"value": degrees(value), "unit": "deg"}) for name, value in fitted.rms.items()
    )  # fmt: skip
    leg = fitted.leg
    return Side(source.named("wanted"), source.written, MODEL, leg, joints_of(leg, known), stated=stated, bare=True)


def _of_family(
    side: Side, source: Source, fits: tuple[FitResult, FitResult], motion: SourceMotion, scale: float
) -> Side:
    """A wanted leg as one of several, which follows the recordings slowed by its own scale.

    ``fits`` : to the recordings as they are, and slowed.
    """
    first, slowed = fits
    followed = tuple(
        FollowedMotion(recording, slowed.leg.to_rotation(trial.fitted))
        for recording, trial in zip(_as_recorded(first, motion), slowed.trials, strict=False)
    )
    return replace(side, name=f"{source.label} x{scale:g}", pace=scale, followed=followed)


def _recorded(source: Source, fitted: FitResult, motion: SourceMotion, leg: Leg) -> Side:
    """The recordings as recorded, in their own time; ``fitted`` to them, for the starts."""
    return Side(source.named("animal"), source.written, RECORDED, leg, {}, _as_recorded(fitted, motion))


def _as_recorded(fitted: FitResult, motion: SourceMotion) -> tuple[ComparedMotion, ...]:
    """The recordings of a fit, in their own time, from its initial states."""
    none = np.zeros(len(fitted.leg.joints))
    return tuple(
        _motion(trial.rotation, trial.rate, recording, none, cut=motion.begun_late)
        for trial, recording in zip(fitted.trials, motion.fitted, strict=False)
    )


def _slowed(source: Source, fitted: FitResult, motion: SourceMotion, scale: float) -> Side:
    """The recordings, ``scale`` times slower, with each trial's own shift of the free angle subtracted.

    ``fitted`` : to the motion at that scale, for the starts.
    """
    leg = fitted.leg
    common = np.array([fitted.joints[name].free_angle.value for name in leg.joint_names])
    motions = []
    for trial, recording in zip(fitted.trials, motion.fitted, strict=False):
        shift = leg.sign * (trial.free_angle - common)
        motions.append(_motion(trial.rotation - shift, trial.rate * scale, recording, shift, cut=motion.begun_late))
    return Side(source.named("animal"), source.written, RECORDED, leg, {}, tuple(motions), stretch=scale)


def _motion(start: Array, rate: Array, recording: Recording, shift: Array, *, cut: bool) -> ComparedMotion:
    """A recording with its ``shift`` (n,) rad subtracted; ``start`` rad and ``rate`` rad/s (n,), its initial state."""
    rotation = np.where(recording.counts, recording.rotation, np.nan) - shift
    locked = list(recording.conditions.locked)
    rotation[:, locked] = start[locked]
    return ComparedMotion(recording.name, recording.time, rotation, start, rate, recording.conditions, cut=cut)
