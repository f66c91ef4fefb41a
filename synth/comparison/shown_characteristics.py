"""Characteristics of each side's motion, such as rise time and damping ratio, over the releases that all sides have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.comparison.overlay import Overlay
from synth.comparison.side import MODEL, ComparedMotion, Side
from synth.motion.characteristics import STARTS_AT_REST, Characteristics, characteristics
from synth.motion.rest import LEAST_SWING
from synth.motion.smoothing import smooth
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, mass_matrix, rest_pose
from synth.units import quantity

UNITS = {"rise_time": "s", "damping_ratio": "1", "damped_frequency": "rad/s", "overshoot": "1", "settling_time": "s"}
# Of the largest deflection at a release's start, over joints and sides: a joint that starts nearer to its rest is moved
# by the other joints and shows no release of its own; its overshoot would be a ratio to almost nothing. Smaller swings
# do not count either, see LEAST_SWING.
AT_REST = LEAST_SWING


@dataclass(frozen=True)
class Spread:
    """Median and range of one characteristic over ``motions`` motions, SI."""

    median: float
    least: float
    most: float
    motions: int

    def as_json(self, unit: str) -> dict[str, Any]:
        """``{"value", "unit", "least", "most", "motions"}``."""
        ends = {"least": self.least, "most": self.most}
        return quantity(self.median, unit) | ends | {"motions": self.motions}


@dataclass(frozen=True)
class Shown:
    """Joint -> characteristic -> spread of one side.

    ``own``: number of its own recordings if it shares no release with the other sides, else 0.
    """

    joints: Mapping[str, Mapping[str, Spread]]
    own: int = 0


@dataclass(frozen=True)
class _Motion:
    """A smooth motion: ``time`` (m,) s, ``angle`` (m, n) and ``noise`` (n,) rad; see ``ComparedMotion``."""

    time: Array
    angle: Array
    noise: Array
    free: Sequence[int]
    cut: bool


@dataclass(frozen=True)
class JointAlone:
    """One joint about the leg's equilibrium with all others locked: linear, without its drive's curve.

    ``stiffness`` N m/rad, spring and gravity; ``inertia`` kg m^2; ``frequency`` rad/s, undamped; ``damping_ratio`` None
    if the damper has no single rate.
    """

    stiffness: float
    inertia: float
    frequency: float | None
    damping_ratio: float | None

    def as_json(self) -> dict[str, Any]:
        """The known values."""
        found = {"stiffness": quantity(self.stiffness, "N*m/rad"), "inertia": quantity(self.inertia, "kg*m^2")}
        if self.frequency is not None:
            found["natural_frequency"] = quantity(self.frequency, "rad/s")
        if self.damping_ratio is not None:
            found["damping_ratio"] = quantity(self.damping_ratio, "1")
        return found


def shown(sides: Sequence[Side], overlays: Sequence[Overlay]) -> tuple[Shown, ...]:
    """What each side shows of the releases, all sides judged by one rule.

    A release counts for a joint if every side shows the joint's motion there and none starts at rest there; a
    characteristic is taken from the releases where all sides that ever show it do so. The noise is the recordings', the
    largest where sides differ, also for simulated sides; see ``AT_REST`` for rest. A side without any common release is
    judged over its own recordings by the same rule. Driven motions are no releases and are left out.
    """
    names = sides[0].leg.joint_names
    releases = [_release(sides, overlay) for overlay in overlays if not overlay.start.driven]
    common = [place for place in range(len(sides)) if any(place in release for release in releases)]
    together = _spreads(names, common, [_judged(release, names) for release in releases])
    found = []
    for place, side in enumerate(sides):
        if place in common:
            found.append(Shown(together[place]))
            continue
        own = [_judged({place: _smoothed(motion)}, names) for motion in side.slowed if not motion.driven]
        found.append(Shown(_spreads(names, [place], own)[place], len(own)))
    return tuple(found)


def _release(sides: Sequence[Side], overlay: Overlay) -> dict[int, _Motion]:
    """The motions of one start by the place of their side."""
    found = {}
    for place, (side, motion) in enumerate(zip(sides, overlay.motions, strict=True)):
        if motion is None:
            continue
        if motion.measured is not None:
            found[place] = _smoothed(motion.measured)
        elif side.kind == MODEL:
            start = overlay.start
            found[place] = _Motion(
                start.time * side.pace, motion.rotation, np.zeros(len(start.start)), start.free, start.cut
            )
    return found


def _smoothed(motion: ComparedMotion) -> _Motion:
    found = smooth(motion.time, motion.rotation, ~np.isfinite(motion.rotation))
    return _Motion(found.time, found.angle, found.noise, motion.free, motion.cut)


def _judged(release: Mapping[int, _Motion], names: Sequence[str]) -> dict[int, dict[str, Characteristics]]:
    """Side -> joint -> its characteristics in one release; joints that start at rest on any side are left out."""
    noise = np.nanmax([np.zeros(len(names)), *(motion.noise for motion in release.values())], axis=0)
    found = {
        place: {
            name: characteristics(motion.time, motion.angle[:, j], float(noise[j]), cut=motion.cut)
            for j, name in enumerate(names)
            if j in motion.free and np.isfinite(motion.angle[:, j]).all()
        }
        for place, motion in release.items()
    }
    amplitudes = [abs(seen.amplitude) for joints in found.values() for seen in joints.values()]
    least = AT_REST * max((value for value in amplitudes if np.isfinite(value)), default=0.0)
    rests = {
        name
        for joints in found.values()
        for name, seen in joints.items()
        if seen.validity == STARTS_AT_REST or abs(seen.amplitude) < least
    }
    return {
        place: {
            n: seen.without_step() if seen.starts_near_rest else seen for n, seen in joints.items() if n not in rests
        }
        for place, joints in found.items()
    }


def _spreads(
    names: Sequence[str], places: Sequence[int], releases: Sequence[Mapping[int, Mapping[str, Characteristics]]]
) -> dict[int, dict[str, dict[str, Spread]]]:
    """Side -> joint -> characteristic -> spread over the releases that count."""
    found: dict[int, dict[str, dict[str, Spread]]] = {place: {name: {} for name in names} for place in places}
    for name in names:
        moving = [place for place in places if any(name in release.get(place, {}) for release in releases)]
        counted = [release for release in releases if all(name in release.get(place, {}) for place in moving)]
        for key in UNITS:
            values = {place: [getattr(release[place][name], key) for release in counted] for place in moving}
            showing = [place for place in moving if any(value is not None for value in values[place])]
            for place in showing:
                taken = [
                    value for k, value in enumerate(values[place]) if all(values[p][k] is not None for p in showing)
                ]
                if taken:
                    found[place][name][key] = Spread(float(np.median(taken)), min(taken), max(taken), len(taken))
    return found


def alone(leg: Leg) -> Mapping[str, JointAlone]:
    """Each joint about the equilibrium pose, all others locked; empty if there is no equilibrium.

    ``k + d(gravity torque)/dq`` over the inertia outboard; ``zeta = b / (2 sqrt(k I))`` (Inman, *Engineering
    Vibration*, 4th ed., eq. 1.30).
    """
    try:
        pose = rest_pose(leg)
    except ArithmeticError:
        return {}
    coefficient = coefficients(leg)
    inertia = np.diag(mass_matrix(coefficient, pose, leg.tilt))
    # Rotating joint j rotates every link outboard of it by the same angle.
    phi = leg.tilt + np.cumsum(pose)
    weight = coefficient.weight_stiffness(phi)
    gravity = np.cumsum(weight[::-1])[::-1]
    found = {}
    for j, joint in enumerate(leg.joints):
        stiffness = float((joint.spring.rate if joint.spring is not None else 0.0) + gravity[j])
        rate = 0.0 if joint.damper is None else joint.damper.rate
        frequency = float(np.sqrt(stiffness / inertia[j])) if stiffness > 0 else None
        ratio = None if rate is None or frequency is None else float(rate / (2 * np.sqrt(stiffness * inertia[j])))
        found[joint.name] = JointAlone(stiffness, float(inertia[j]), frequency, ratio)
    return found
