"""One side of a comparison: a leg to simulate, or recordings of one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.drives.servo import Servo, ServoSignals
from synth.estimation.intervals import Estimate
from synth.swing.chain import Conditions
from synth.swing.driving_inputs import is_driven
from synth.swing.leg_model import Damper, Joint, Leg

MODEL, RECORDED = "model", "recorded"
NOT_SLOWED = "a known torque or a servo drives this recording, which no other time scale has"


@dataclass(frozen=True)
class ComparedJoint:
    """A joint's spring and damper as one side states them; ``damper_law`` if there is no single rate."""

    spring_rate: Estimate | None = None
    damper_rate: Estimate | None = None
    free_angle: Estimate | None = None
    damper_law: str = ""
    spring_part: str = ""
    damper_part: str = ""

    def as_json(self) -> dict[str, Any]:
        """The known values only."""
        rates = {"spring_rate": self.spring_rate, "damper_rate": self.damper_rate, "free_angle": self.free_angle}
        words = {"damper_law": self.damper_law, "spring_part": self.spring_part, "damper_part": self.damper_part}
        return {key: value.as_json() for key, value in rates.items() if value is not None} | {
            key: value for key, value in words.items() if value
        }


@dataclass(frozen=True)
class ComparedMotion:
    """A release.

    ``time`` (m,) s from 0; ``rotation`` (m, n) rad, nan for samples that do not count; ``start`` and ``rate`` (n,) rad
    and rad/s, the state at the first sample; ``conditions`` of the trial. ``known_torque``, ``signals``: what drives
    it, as for ``simulate``; ``not_driven``: why no leg can be driven as it was, empty if one can. ``cut``: it begins
    after the release. ``deviation`` (2, n) rad and rad/s: standard deviations of ``start`` and ``rate`` that were found
    from the first samples alone; None if they are stated, or fitted to the whole recording.
    """

    name: str
    time: Array
    rotation: Array
    start: Array
    rate: Array
    conditions: Conditions = field(default_factory=Conditions)
    known_torque: tuple[Array, Array] | None = None
    signals: ServoSignals | None = None
    not_driven: str = ""
    cut: bool = False
    deviation: Array | None = None

    @property
    def driven(self) -> bool:
        """Whether a known torque or a servo moved it: no release."""
        return bool(self.not_driven) or is_driven(self.known_torque, self.signals)

    @property
    def free(self) -> list[int]:
        """Joints that are not locked."""
        return [j for j in range(self.rotation.shape[1]) if j not in self.conditions.locked]

    def stretched(self, factor: float) -> ComparedMotion:
        """The same motion ``factor`` times slower; what drives it cannot be slowed down, it depends on the leg."""
        if factor == 1.0:
            return self
        slow = replace(self, time=self.time * factor, rate=self.rate / factor)
        if self.deviation is not None:
            slow = replace(slow, deviation=self.deviation / np.array([[1.0], [factor]]))
        has_inputs = self.known_torque is not None or self.signals is not None or bool(self.not_driven)
        return replace(slow, known_torque=None, signals=None, not_driven=NOT_SLOWED) if has_inputs else slow


@dataclass(frozen=True)
class FollowedMotion:
    """A ``recording`` and the ``rotation`` (m, n) rad of the leg that was fitted to it, at its samples."""

    recording: ComparedMotion
    rotation: Array

    def is_of(self, start: ComparedMotion) -> bool:
        """Whether ``start`` is this recording: files of other folders may have its name."""
        own = self.recording
        same = own.name == start.name and own.rotation.shape == start.rotation.shape == self.rotation.shape
        return same and bool(np.array_equal(own.rotation, start.rotation, equal_nan=True))


@dataclass(frozen=True)
class StatedFigure:
    """A number stated by a result, with its meaning."""

    what: str
    value: Mapping[str, Any]  # {"value", "unit", "interval90"}


@dataclass(frozen=True)
class Side:
    """One column of the comparison.

    Parameters
    ----------
    kind
        ``model``: ``leg`` is simulated from every start; ``recorded``: ``motions`` are measured.
    leg
        for recordings: the leg that defines their angles.
    stretch
        factor by which its motion, as recorded or simulated, is slowed down for the comparison.
    pace
        how many times slower this leg moves than the starts. It is simulated so much longer from rates so much lower,
        and overlaid in the starts' time; its characteristics are those in its own time.
    followed
        this leg's motions as they were fitted to recordings slowed by ``pace``: from the start and with the free angles
        that this leg has in each, which another leg's fit does not give.
    reads
        the leg's encoders err as its file states, where recordings are compared. Not of a fit's leg: a fit takes
        readings as exact, and its numbers follow them.
    bare
        the links are those of a design's target file, without the parts of the joints that the design draws on them.
    """

    name: str
    source: str
    kind: str
    leg: Leg
    joints: Mapping[str, ComparedJoint] = field(default_factory=dict)
    motions: tuple[ComparedMotion, ...] = ()
    stated: tuple[StatedFigure, ...] = ()
    stretch: float = 1.0
    pace: float = 1.0
    followed: tuple[FollowedMotion, ...] = ()
    reads: bool = False
    bare: bool = False

    def as_fitted_to(self, start: ComparedMotion) -> Array | None:
        """(m, n) rad, the leg's motion as it was fitted to this very recording; None if it was not."""
        if self.stretch != 1.0:
            return None
        return next((each.rotation for each in self.followed if each.is_of(start)), None)

    def other_convention(self, leg: Leg) -> list[str]:
        """Joints whose angles this side's leg counts from another zero, or in the other sense, than ``leg``."""
        own = {joint.name: (joint.zero, joint.sign) for joint in self.leg.joints}
        return [j.name for j in leg.joints if own.get(j.name, (j.zero, j.sign)) != (j.zero, j.sign)]

    def in_convention(self, leg: Leg) -> Side:
        """The same with its joints' free angles as ``leg`` counts them; motions are rotations, which do not depend."""
        joints = dict(self.joints)
        for name in self.other_convention(leg):
            own, shown = (each.joints[each.joint_names.index(name)] for each in (self.leg, leg))
            joint = joints.get(name)
            if joint is not None and joint.free_angle is not None:
                joints[name] = replace(joint, free_angle=_recounted(joint.free_angle, own, shown))
        return replace(self, joints=joints)

    @property
    def slowed(self) -> tuple[ComparedMotion, ...]:
        """The recordings in the time scale of the comparison."""
        return tuple(motion.stretched(self.stretch) for motion in self.motions)


def joints_of(leg: Leg, known: Mapping[str, Mapping[str, Any]] | None = None) -> dict[str, ComparedJoint]:
    """Joint values of a leg file; ``known``: estimates with intervals from a result, one per joint."""
    found = {}
    for joint in leg.joints:
        estimates = (known or {}).get(joint.name, {})
        rate = None if joint.spring is None else Estimate(joint.spring.rate, "N*m/rad")
        free = None if joint.spring is None else Estimate(joint.spring.free_angle, "deg")
        found[joint.name] = ComparedJoint(
            estimate_of(estimates.get("spring_rate"), "N*m/rad") or rate,
            estimate_of(estimates.get("damper_rate"), "N*m*s/rad") or _damper_rate(joint.damper),
            estimate_of(estimates.get("free_angle"), "deg") or free,
            "torque-speed curve" if joint.damper is not None and joint.damper.curve is not None else "",
            (joint.spring.part if joint.spring is not None else None) or "",
            (joint.damper.part if joint.damper is not None else None) or "",
        )
    return found


def _recounted(angle: Estimate, own: Joint, shown: Joint) -> Estimate:
    """An angle that ``own`` states, as ``shown`` counts it; the ends of an interval change places with the sense."""

    def counted(end: float | None) -> float | None:
        return None if end is None else shown.zero + shown.sign * own.sign * (end - own.zero)

    ends = [counted(angle.low), counted(angle.high)]
    low, high = ends if own.sign == shown.sign else ends[::-1]
    return Estimate(shown.zero + shown.sign * own.sign * (angle.value - own.zero), angle.shown_in, low, high)


def estimate_of(item: object, unit: str) -> Estimate | None:
    """A result's ``{"value", "unit", "interval90"}`` in SI; None if missing."""
    from synth.units import factor

    if not isinstance(item, Mapping) or not isinstance(item.get("value"), (int, float)):
        return None
    canonical = {"deg": "rad"}.get(unit, unit)
    scale = factor(str(item.get("unit")), canonical)
    low, high = (None if end is None else end * scale for end in item.get("interval90") or (None, None))
    return Estimate(item["value"] * scale, unit, low, high)


def _damper_rate(damper: Damper | None) -> Estimate | None:
    if damper is None or damper.rate is None:
        return None
    return Estimate(damper.rate, "N*m*s/rad")


def not_driven_alike(side: Side, start: ComparedMotion) -> str:
    """Why a side's leg cannot be driven as the recording was; empty if it can, or if nothing drove it."""
    if start.not_driven or (start.known_torque is None and start.signals is None):
        return start.not_driven
    if side.stretch != 1.0 or side.pace != 1.0:
        return NOT_SLOWED
    if start.signals is None:
        return ""
    told = [j for j in start.free if start.signals.enabled[:, j].any()]
    bare = [side.leg.joint_names[j] for j in told if not isinstance(side.leg.joints[j].drive, Servo)]
    return f"a servo drives this recording, and the leg has none at {', '.join(bare)}" if bare else ""
