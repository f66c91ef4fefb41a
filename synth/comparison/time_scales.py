"""A family of legs: the wanted leg of one leg-design project at several time scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import degrees

import numpy as np

from synth.comparison.side import MODEL, RECORDED, ComparedMotion, Side, StatedFigure, joints_of
from synth.comparison.side_source import Source
from synth.design.stages import fit_options, read_motion
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
    """The animal at the robot's time scale, and the robot's links fitted to its motion at each scale.

    Without ``scales``: the project's own. The driven beginning of recordings is cut as in ``synth leg``.

    Raises
    ------
    UserError : the project or its trials cannot be used.
    """
    project = read_leg_project(source.path, open_catalogue=lambda paths: resolver(Catalogue.load(paths)))
    project = with_wanted_leg(project)
    options, motion, into = fit_options(project), read_motion(project), target_of(project.target)
    found = fit_by(project.source, motion.fitted, replace(options, release=project.release), project.fit)
    motion = motion.cut(found.cut)
    own = project.time_scale
    common = own if own in scales or not scales else scales[0]  # time scale at which the animal is shown
    sides: list[Side] = []
    wanted: list[Side] = []
    for scale in scales or (own,):
        recordings = [recording.stretched(scale) for recording in motion.fitted]
        fitted = fit_by(into.ideal, recordings, options, project.fit)
        if scale == common and "animal" in source.views:
            sides.append(_animal(source, fitted, recordings, cut=motion.begun_late))
        side = _wanted(source, fitted, scale, scale / common)
        wanted.append(replace(side, name=f"{source.label} x{scale:g}") if scales else side)
    return [*sides, *wanted] if "wanted" in source.views else sides


def _wanted(source: Source, fitted: FitResult, scale: float, pace: float) -> Side:
    known = {name: joint.as_json() for name, joint in fitted.joints.items()}
    stated = tuple(
        StatedFigure(f"{name}: RMS from the animal's motion {scale:g} times slower",
                     {"value": degrees(value), "unit": "deg"}) for name, value in fitted.rms.items()
    )  # fmt: skip
    leg = fitted.leg
    return Side(source.named("wanted"), source.written, MODEL, leg, joints_of(leg, known), stated=stated, pace=pace)


def _animal(source: Source, fitted: FitResult, recordings: Sequence[Recording], *, cut: bool) -> Side:
    """The recordings with each trial's own shift of the free angle subtracted."""
    leg = fitted.leg
    common = np.array([fitted.joints[name].free_angle.value for name in leg.joint_names])
    motions = []
    for trial, recording in zip(fitted.trials, recordings, strict=False):
        shift = leg.sign * (trial.free_angle - common)
        motions.append(_motion(leg, trial.rotation - shift, trial.rate, recording, shift, cut=cut))
    return Side(source.named("animal"), source.written, RECORDED, leg, {}, tuple(motions))


def _motion(
    leg: Leg,
    start: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    rate: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    recording: Recording,
    shift: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    *,
    cut: bool,
) -> ComparedMotion:
    rotation = np.where(recording.counts, recording.rotation, np.nan) - shift
    locked = list(recording.conditions.locked)
    rotation[:, locked] = start[locked]
    return ComparedMotion(recording.name, recording.time, rotation, start, rate, recording.conditions, cut=cut)
