"""The range that the target states for a joint is a promise: its stops end it, and what it leaves out is told.

A wanted motion, or a rest pose, beyond the stops is not drawn for, and the built leg does not make it: its motions and
forecasts have the stops as contacts, and each release starts in the nearest pose that the stops allow. What is compared
stays the wanted motion.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from synth.arrays import Array
from synth.design.drawn_springs import simulate_built_leg
from synth.design.judged_sets import Judge
from synth.design.leg_design import LegDesign
from synth.design.part_sets import PartSet
from synth.design.response import WantedRelease
from synth.design.stated_range import StatedRange
from synth.design.stop_places import ASKED_STOP
from synth.remarks import decisive
from synth.swing.effects import joint_stop
from synth.swing.leg_model import Joint, Leg

EFFECT = joint_stop.EFFECT.name
STIFFER = 200.0  # of the spring's own rate: a joint leans a 200th of its spring's deflection into its stop
# s/rad: at most its inverse in rad/s comes back of an impact (Hunt & Crossley). With it and STIFFER a joint that meets
# its stop at 7 rad/s stays within 0.2 deg of MuJoCo with mjcf.HARD, whose limits hardly rebound either.
DAMPING = 2.5
FAR_OFF = 2.0  # deg RMS of one joint: below the 3 deg of select.within, which is of all joints together


def stated_ranges(design: LegDesign) -> tuple[StatedRange, ...]:
    """The stated ranges of a design whose motions are simulated without stops, in the leg's order."""
    leg, found = design.built, []
    rest = leg.to_measured(design.rest_pose)
    for j, joint in enumerate(design.project.target.joints):  # the built leg's range is that of the drawn stops
        if joint.range is None:
            continue
        stops = (joint.range[0] - radians(ASKED_STOP), joint.range[1] + radians(ASKED_STOP))
        if design.drawn is not None:
            first, last = design.drawn.dimensions.joints[j].stop_angles
            stops = (radians(first), radians(last))
        wanted, built = (
            np.concatenate([leg.to_measured(motion)[:, j] for motion in motions])
            for motions in (design.wanted.motions, design.built_motions)
        )
        found.append(StatedRange(joint.name, joint.range, stops, _ends(wanted), _ends(built), float(rest[j])))
    return tuple(found)


def _ends(angles: Array) -> tuple[float, float]:
    return float(np.nanmin(angles)), float(np.nanmax(angles))


def held_to_ranges(design: LegDesign) -> LegDesign:
    """The design with its stated ranges: warnings, and stops in its motions and forecasts where they act."""
    ranges = stated_ranges(design)
    said = tuple((item.joint, text) for item in ranges for text in item.warnings())
    design = _with_stops_acting(replace(design, ranges=ranges))
    return replace(design, warnings=(*said, *_far_off(design), *design.warnings))


def _far_off(design: LegDesign) -> tuple[tuple[str, str], ...]:
    """Joint and warning for each joint whose motion, with the stops that act, is far from the wanted one."""
    found = zip(design.built.joint_names, np.degrees(design.errors), strict=True)
    words = "{}: the built leg will move {:.1f} deg (RMS) off the wanted motion"
    return tuple((name, decisive(words.format(name, off))) for name, off in found if off > FAR_OFF)


def _with_stops_acting(design: LegDesign) -> LegDesign:
    acting = {item.joint: item.stops for item in design.ranges if item.stopped}
    if not acting:
        return design
    joints = tuple(
        _with_stops(joint, acting[joint.name]) if joint.name in acting else joint for joint in design.built.joints
    )
    built = replace(design.built, joints=joints)
    releases = tuple(_possible(release, built, acting) for release in design.wanted.releases)
    design = replace(
        design,
        built=built,
        wanted=replace(design.wanted, releases=releases),  # with the wanted motions as they are
    )
    return _forecast_again(simulate_built_leg(design))


def _with_stops(joint: Joint, stops: tuple[float, float]) -> Joint:
    """The joint with contacts at its stops; a stop that the target itself describes is kept."""
    if EFFECT in joint.effects:
        return joint
    assert joint.spring is not None
    contact = {"lower": stops[0], "upper": stops[1], "stiffness": STIFFER * joint.spring.rate, "damping": DAMPING}
    return replace(joint, range=stops, effects={**joint.effects, EFFECT: contact})


def _possible(release: WantedRelease, leg: Leg, stops: dict[str, tuple[float, float]]) -> WantedRelease:
    """The release from the nearest pose between the stops, with no rate into them."""
    measured = leg.to_measured(release.rotation)
    for j, name in enumerate(leg.joint_names):
        if name in stops:
            measured[j] = np.clip(measured[j], *stops[name])
    rotation = leg.to_rotation(measured)
    return replace(release, rotation=rotation, rate=leg.rates_off_stops(rotation, release.rate))


def _forecast_again(design: LegDesign) -> LegDesign:
    """The design with errors and forecasts of all its sets by its built leg, whose effects they had not."""
    project = design.project
    judge = Judge(design.wanted, design.built, project.parts, project.fit.seed)
    errors = judge.errors([item.pairs for item in design.sets.sets])
    sets = tuple(_forecast(judge, item, float(error)) for item, error in zip(design.sets.sets, errors, strict=True))
    return replace(design, sets=replace(design.sets, sets=sets))


def _forecast(judge: Judge, item: PartSet, error: float) -> PartSet:
    """A set's forecasts again, with as many samples as before."""
    come, ready = item.forecast, item.ready
    return replace(
        item,
        error=error,
        forecast=judge.as_they_come(item.pairs, come.n_sample, shares=bool(come.shares)),
        ready=judge.ready(item.pairs, ready.n_sample, shares=bool(ready.shares)),
    )
