"""A wanted motion given by each joint's characteristics: ``wanted:`` instead of ``trials:``.

``wanted: {knee: {rest: 111 deg, amplitude: 25 deg, damping_ratio: 0.38, damped_frequency: 2.2 Hz}}``
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, radians
from typing import Annotated, Any

from pydantic import Field

from synth import units
from synth.errors import UserError
from synth.files.named_files import ProjectReader
from synth.files.validate import Quantity
from synth.files.yaml_lines import Key
from synth.swing.leg_model import Leg

SMALLEST = radians(0.5)  # a smaller motion is not a release (``fit.recordings``)


@dataclass(frozen=True)
class HertzOrRadians(Quantity):
    """A frequency as ``2.2 Hz``, or as in results, ``13.8 rad/s``."""

    def read(self, value: object) -> float:
        """The value in rad/s, or a refusal."""
        try:
            hertz = units.parse(value, "Hz")
        except UserError:
            return super().read(value)
        return super().read(f"{2 * pi * hertz!r} rad/s")


@dataclass(frozen=True)
class WantedCharacteristics:
    """One joint in a release of the whole leg from rest, SI.

    ``rest`` the measured angle of the equilibrium; ``amplitude`` from there to the release, in the
    measured angle's sense; ``damping_ratio`` by the logarithmic decrement, at least 1 without oscillation;
    ``damped_frequency`` in rad/s, ``rise_time`` from 10 to 90 % of the way: one of the two, or both.
    """

    rest: Annotated[float, Quantity("rad"), Field(examples=["111 deg"])]
    amplitude: Annotated[float, Quantity("rad", least=-radians(180), most=radians(180)), Field(examples=["25 deg"])]
    damping_ratio: Annotated[float, Quantity("1", above=0, most=20), Field(examples=["0.38"])]
    damped_frequency: Annotated[
        float | None, HertzOrRadians("rad/s", above=0, most=1e4), Field(examples=["2.2 Hz"])
    ] = None
    rise_time: Annotated[float | None, Quantity("s", above=0, most=1e3), Field(examples=["60 ms"])] = None


def read_wanted(
    reader: ProjectReader, value: Any, leg: Leg | None, key: Key = ("wanted",)
) -> dict[str, WantedCharacteristics]:
    """The wanted characteristics of every joint of ``leg``; mistakes go to the reader."""
    if not isinstance(value, Mapping):
        reader.refuse(f"{value!r} is not allowed: a mapping {{joint: {{rest: ..., amplitude: ...}}}} is needed", key)
        return {}
    if leg is None:
        return {}
    reader.known_joints(value, leg, key)
    missing = [name for name in leg.joint_names if name not in value]
    if missing:
        reader.refuse(f"{', '.join(missing)}: every joint of {leg.name} needs its characteristics", key)
    found = {}
    for name in leg.joint_names:
        if name not in value:
            continue
        joint = reader.entry(WantedCharacteristics, (*key, name), value[name])
        if joint is None:
            continue
        found[name] = joint
        if abs(joint.amplitude) < SMALLEST:
            reader.refuse("is less than 0.5 deg: too small for a motion", (*key, name, "amplitude"))
        if joint.damped_frequency is None and joint.rise_time is None:
            reader.refuse('needs "damped_frequency", "rise_time" or both beside its damping ratio', (*key, name))
        if joint.damping_ratio >= 1 and joint.damped_frequency is not None:
            text = "a joint with a damping ratio of 1 or more does not swing: give its rise_time instead"
            reader.refuse(text, (*key, name, "damped_frequency"))
    return found
