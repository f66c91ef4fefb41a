"""One side of a comparison: a leg to simulate, or recordings of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import Estimate
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Leg

MODEL, RECORDED = "model", "recorded"


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
    and rad/s, the state at the first sample; ``conditions`` of the trial.
    """

    name: str
    time: Array
    rotation: Array
    start: Array
    rate: Array
    conditions: Conditions = field(default_factory=Conditions)

    @property
    def free(self) -> list[int]:
        """Joints that are not locked."""
        return [j for j in range(self.rotation.shape[1]) if j not in self.conditions.locked]

    def stretched(self, factor: float) -> ComparedMotion:
        """The same motion ``factor`` times slower."""
        return replace(self, time=self.time * factor, rate=self.rate / factor)


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
        factor by which its recordings are slowed down for the comparison.
    pace
        how many times slower this leg moves than the starts; its initial rates are divided by it.
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


def nearest(motions: Sequence[ComparedMotion], like: ComparedMotion) -> tuple[ComparedMotion, float] | None:
    """The recording that starts nearest to ``like``, and its distance, rad at the joint farthest away.

    Only recordings with the same locked joints are considered.
    """
    found: tuple[ComparedMotion, float] | None = None
    for motion in motions:
        if motion.conditions.locked != like.conditions.locked:
            continue
        free = like.free
        away = float(np.abs(motion.start[free] - like.start[free]).max())
        if found is None or away < found[1]:
            found = motion, away
    return found
