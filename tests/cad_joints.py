"""What the CAD tests build on: joints whose upper arm points where their travel allows."""

from __future__ import annotations

from dataclasses import replace

from synth.cad import JointDimensions, clear_upper_arm_angle


def cleared(dimensions: JointDimensions) -> JointDimensions:
    """The joint with its upper arm in a direction that is free."""
    return replace(dimensions, upper_arm_angle=clear_upper_arm_angle(dimensions))
