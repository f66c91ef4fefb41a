"""Characteristics of each side's motion, such as rise time and damping ratio, over all its releases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.comparison.overlay import Overlay
from synth.comparison.side import MODEL, ComparedMotion, Side
from synth.motion.characteristics import Characteristics, characteristics
from synth.motion.smoothing import smooth
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, mass_matrix, rest_pose
from synth.units import quantity

UNITS = {"rise_time": "s", "damping_ratio": "1", "damped_frequency": "rad/s", "overshoot": "1", "settling_time": "s"}


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


def shown(side: Side, place: int, overlays: Sequence[Overlay]) -> dict[str, dict[str, Spread]]:
    """Joint -> characteristic -> spread, over all recordings of a recorded side or all starts of a leg.

    Driven motions are left out: they are no releases.
    """
    every: dict[str, list[Characteristics]] = {name: [] for name in side.leg.joint_names}
    if side.kind == MODEL:
        for overlay in overlays:
            motion = overlay.motions[place]
            if motion is not None and not overlay.start.driven:
                _add(every, overlay.start, overlay.start.time, motion.rotation, np.zeros(len(every)))
    else:
        for recording in (each for each in side.slowed if not each.driven):
            time, angle, noise = _smoothed(recording)
            _add(every, recording, time, angle, noise)
    return {name: _spreads(found) for name, found in every.items()}


def _smoothed(motion: ComparedMotion) -> tuple[Array, Array, Array]:
    found = smooth(motion.time, motion.rotation, ~np.isfinite(motion.rotation))
    return found.time, found.angle, found.noise


def _add(
    every: dict[str, list[Characteristics]], start: ComparedMotion, time: Array, angle: Array, noise: Array
) -> None:
    for j, name in enumerate(every):
        if j in start.free and np.isfinite(angle[:, j]).all():
            every[name].append(characteristics(time, angle[:, j], float(noise[j]), cut=start.cut))


def _spreads(found: Sequence[Characteristics]) -> dict[str, Spread]:
    out = {}
    for key in UNITS:
        values = [value for each in found if (value := getattr(each, key)) is not None]
        if values:
            out[key] = Spread(float(np.median(values)), min(values), max(values), len(values))
    return out


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
    weight = coefficient.gravity * np.cos(phi)
    gravity = np.cumsum(weight[::-1])[::-1]
    found = {}
    for j, joint in enumerate(leg.joints):
        stiffness = float((joint.spring.rate if joint.spring is not None else 0.0) + gravity[j])
        rate = 0.0 if joint.damper is None else joint.damper.rate
        frequency = float(np.sqrt(stiffness / inertia[j])) if stiffness > 0 else None
        ratio = None if rate is None or frequency is None else float(rate / (2 * np.sqrt(stiffness * inertia[j])))
        found[joint.name] = JointAlone(stiffness, float(inertia[j]), frequency, ratio)
    return found
